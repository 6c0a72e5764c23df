//! What a run leaves: words, JSON, tables, a picture, a checkpoint.
//!
//! In: an [`Outcome`](crate::run::Outcome), and the columns at moments of the run. Out: text, files in a folder. Never: a
//! number in other units than SI, except where it says so.

pub mod checkpoint;
pub mod folder;
pub mod json;
pub mod picture;
pub mod summary;
pub(crate) mod svg;
pub mod table;
mod trails;

use std::fmt;

use crate::scene::Scene;

/// The title of a scene that came to `time`, in s. A title may tell what the scene's own end shows; where a run had another
/// end, the title says so.
pub(crate) fn title(scene: &Scene, time: f64) -> Option<String> {
    let title = &scene.title.as_ref()?.value;
    let same = scene.own_end.is_none_or(|end| (time - end).abs() <= 1e-9 * end.abs());
    Some(if same { title.clone() } else { format!("{title} (run to {})", picture::duration(time)) })
}

/// A number with about `digits` digits, in the shorter of the usual forms; for people.
pub(crate) fn rounded(value: f64, digits: usize) -> Rounded {
    Rounded { value, digits }
}

/// See [`rounded`].
pub(crate) struct Rounded {
    value: f64,
    digits: usize,
}

impl fmt::Display for Rounded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, digits) = (self.value, self.digits.max(1));
        if value == 0.0 || !value.is_finite() {
            return f.pad(&value.to_string());
        }
        let text = format!("{value:.*e}", digits - 1);
        let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
        let exponent: i32 = exponent.parse().unwrap_or(0);
        let text = if (-4..digits as i32 + 3).contains(&exponent) {
            let places = (digits as i32 - 1 - exponent).max(0) as usize;
            let text = format!("{value:.places$}");
            if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
        } else if mantissa.contains('.') {
            format!("{}e{exponent}", mantissa.trim_end_matches('0').trim_end_matches('.'))
        } else {
            text
        };
        f.pad(&text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people() {
        let said = |value, digits| rounded(value, digits).to_string();
        assert_eq!(said(0.1 + 0.2, 4), "0.3");
        assert_eq!(said(1234.567, 3), "1235");
        assert_eq!(said(3.8172, 3), "3.82");
        assert_eq!(said(1.5e-12, 3), "1.5e-12");
        assert_eq!(said(-6.02214e23, 3), "-6.02e23");
        assert_eq!(said(0.00012, 2), "0.00012");
        assert_eq!(said(347_155_200.0, 12), "347155200");
        assert_eq!(said(0.0, 3), "0");
        assert_eq!(format!("{:>8}", rounded(f64::NAN, 3)), "     NaN");
    }
}
