//! What the laws of a scene do, as a table for people.
//!
//! In: an attribution, what error is allowed. Out: text. Never: a law that was not switched off.

use std::fmt::Write;

use super::attribution::{Attribution, Finding, Share, Verdict};
use crate::output::picture::duration;
use crate::output::rounded;

/// The table.
pub fn shares(attribution: &Attribution, budget: Option<f64>) -> String {
    let Attribution { case, length, by, uncertainty, own, laws } = attribution;
    let mut text = format!("{case}: what each law does to the end, {} on\n", duration(*length));
    // Writing to a string cannot fail.
    _ = writeln!(text, "all laws: {by}; it may be wrong by {uncertainty:.0e} of the scale");
    match own {
        Ok(error) => _ = writeln!(text, "as the scene runs, its steps are wrong by {error:.0e} of the scale"),
        Err(reason) => _ = writeln!(text, "as the scene runs, it does not come to the end: {reason}"),
    }
    let name = |law: &Finding| match law {
        Finding::Share(share) => share.law.len(),
        Finding::Stays(law, _) => law.len(),
    };
    let width = laws.iter().map(name).max().unwrap_or(3).max(3);
    let changes: Vec<String> = laws.iter().map(change).collect();
    let wide = changes.iter().map(|words| words.chars().count()).max().unwrap_or(6).max(6);
    _ = writeln!(text, "\n{:width$}  {:wide$}  {:>8}  {:>6}", "law", "change", "of scale", "saves");
    for (law, change) in laws.iter().zip(changes) {
        match law {
            Finding::Stays(law, why) => _ = writeln!(text, "{law:width$}  stays: {why}"),
            Finding::Share(share) => {
                let saves = format!("{:.0} %", 100.0 * share.saves.max(0.0));
                let words = words(attribution, share, budget);
                let Share { law, by_scale, .. } = share;
                _ = writeln!(text, "{law:width$}  {change:wide$}  {by_scale:>8.0e}  {saves:>6}  {words}");
            }
        }
    }
    _ = writeln!(text, "\nsaves: the part of the time of an evaluation that is saved without the law");
    text
}

/// "13923 km of Mercury, position".
fn change(law: &Finding) -> String {
    let Finding::Share(Share { quantity, row, change, unit, .. }) = law else { return String::new() };
    let (value, unit) = prefixed(*change, unit);
    let of = quantity.rsplit('.').next().unwrap_or(quantity);
    format!("{} {unit} of {row}, {of}", rounded(value, 4))
}

/// A number with the prefix that brings it near 1: for lengths, and what is of them per time.
fn prefixed(value: f64, unit: &str) -> (f64, String) {
    let length = unit == "m" || unit.starts_with("m/");
    let (factor, prefix) = match value {
        size if !length || size == 0.0 => (1.0, ""),
        size if size >= 1e4 => (1e-3, "k"),
        size if size < 1e-7 => (1e9, "n"),
        size if size < 1e-4 => (1e6, "u"),
        size if size < 1e-1 => (1e3, "m"),
        _ => (1.0, ""),
    };
    (value * factor, format!("{prefix}{unit}"))
}

fn words(attribution: &Attribution, share: &Share, budget: Option<f64>) -> String {
    let verdict = match attribution.verdict(share, budget) {
        Verdict::Needed => "needed".to_owned(),
        Verdict::Droppable => format!("can be dropped: less than {:e}", budget.unwrap_or_default()),
        Verdict::BelowStep => "below the error of the step".to_owned(),
        Verdict::Nothing => "changes nothing here".to_owned(),
    };
    let asleep = (!share.asleep.is_empty()).then(|| format!("{} does not run without it", share.asleep.join(", ")));
    let large = Attribution::is_saturated(share).then(|| "as large as the motion itself".to_owned());
    [Some(verdict), asleep, large].into_iter().flatten().collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_prefixes() {
        let words = |value: f64, unit: &str| {
            let (value, unit) = prefixed(value, unit);
            format!("{} {unit}", rounded(value, 3))
        };
        assert_eq!(words(1.39e7, "m"), "13900 km");
        assert_eq!(words(2.5e-6, "m/s"), "2.5 um/s");
        assert_eq!(words(0.0, "m"), "0 m");
        assert_eq!(words(1e9, "K"), "1e9 K");
    }
}
