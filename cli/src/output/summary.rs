//! A run in words.
//!
//! In: an outcome. Out: lines for people: what was done, what ran and what did not, what was kept, how far it is from
//! what is known. Never: a number with more digits than mean something.

use std::fmt::{self, Write};

use super::picture::duration;
use super::{rounded, title};
use crate::run::drift::VectorDrift;
use crate::run::{LawOutcome, Outcome};
use crate::scene::{CompareTime, Scene, plural};

/// The summary of a run of `scene`.
pub fn summary(scene: &Scene, outcome: &Outcome) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    _ = write(&mut text, scene, outcome);
    text
}

fn write(text: &mut String, scene: &Scene, outcome: &Outcome) -> fmt::Result {
    if let Some(title) = title(scene, outcome.time) {
        writeln!(text, "{title}")?;
    }
    let steps = outcome.steps.max(1) as f64;
    writeln!(
        text,
        "time {} s{} in {} of {}, {} evaluations, {}, {} s of computing ({} s a step)",
        rounded(outcome.time, 10),
        if outcome.time.abs() >= 172_800.0 { format!(" ({})", duration(outcome.time)) } else { String::new() },
        plural(outcome.steps as usize, "step"),
        outcome.integrator,
        outcome.evaluations,
        outcome.precision,
        rounded(outcome.wall_seconds, 3),
        rounded(outcome.wall_seconds / steps, 2),
    )?;
    if outcome.rejected > 0 {
        writeln!(text, "{} more tried and given up", plural(outcome.rejected as usize, "step"))?;
    }
    if let Some((last, step)) = outcome.short_step {
        writeln!(text, "the last step is {} s, not {} s, to come to the end", rounded(last, 4), rounded(step, 4))?;
    }
    laws(text, outcome)?;
    for unused in &outcome.unused {
        writeln!(text, "{unused} is unused: no running law touches it")?;
    }
    invariants(text, outcome)?;
    compared(text, scene, outcome)
}

fn laws(text: &mut String, outcome: &Outcome) -> fmt::Result {
    let running: Vec<&LawOutcome> = outcome.laws.iter().filter(|law| law.status == "active").collect();
    if running.is_empty() {
        writeln!(text, "no law runs")?;
    } else {
        let width = running.iter().map(|law| law.name.chars().count()).max().unwrap_or(0).max(3);
        writeln!(text, "\n{:width$}  {:>10}  backend   on", "law", "seconds")?;
        for law in running {
            let backend = law.backend.unwrap_or("cpu");
            let seconds = rounded(law.seconds, 3);
            writeln!(
                text,
                "{:width$}  {seconds:>10}  {backend:8}  {} of {}",
                law.name,
                plural(law.rows, "row"),
                law.domain
            )?;
        }
    }
    for law in outcome.laws.iter().filter(|law| law.status != "active") {
        let reason = law.reason.as_ref().map_or(String::new(), |reason| format!(": {reason}"));
        writeln!(text, "{} is {}{reason}", law.name, law.status)?;
    }
    Ok(())
}

fn invariants(text: &mut String, outcome: &Outcome) -> fmt::Result {
    let energy = &outcome.drift.energy;
    let known = outcome.laws.iter().filter(|law| law.status == "active").count() > energy.silent.len();
    if !known && outcome.drift.momenta.is_none() {
        return Ok(());
    }
    let line = |text: &mut String, name: &str, first: &str, last: &str, drift: &str| {
        writeln!(text, "{name:17}  {first:>32}  {last:>32}  {drift:>10}")
    };
    let said_drift = |drift: f64| if drift.is_nan() { "-".to_owned() } else { rounded(drift, 2).to_string() };
    writeln!(text)?;
    line(text, "", "first", "last", "changed by")?;
    if known {
        let said = |value: f64| rounded(value, 9).to_string();
        line(text, "energy", &said(energy.first), &said(energy.last), &said_drift(energy.max_relative_drift))?;
    }
    if let Some((momentum, angular)) = &outcome.drift.momenta {
        let said = |vector: [f64; 3], scale: f64| {
            // Rounding noise of a sum that is zero is not worth its digits.
            let number = |x: f64| rounded(if x.abs() < 1e-12 * scale { 0.0 } else { x }, 4).to_string();
            format!("({}, {}, {})", number(vector[0]), number(vector[1]), number(vector[2]))
        };
        for (name, VectorDrift { first, last, max_relative_drift, scale, .. }) in
            [("momentum", momentum), ("angular momentum", angular)]
        {
            line(text, name, &said(*first, *scale), &said(*last, *scale), &said_drift(*max_relative_drift))?;
        }
    }
    let units = if outcome.drift.by_parameter {
        "times G, since the scene gives GM for masses: in m^5/s^4, m^4/s^3, m^5/s^3"
    } else {
        "in J, kg m/s, kg m^2/s"
    };
    writeln!(text, "{units}")?;
    writeln!(
        text,
        "changed by: the largest change on the way, as a part of the first energy, or of the rows' magnitudes"
    )?;
    if let [first, more @ ..] = &energy.silent[..] {
        let which = if more.is_empty() { "this law does" } else { "these laws do" };
        let names = more.iter().fold(first.clone(), |names, name| format!("{names}, {name}"));
        writeln!(text, "the energy is without that of {names}, which {which} not tell")?;
    }
    Ok(())
}

fn compared(text: &mut String, scene: &Scene, outcome: &Outcome) -> fmt::Result {
    let (Some(compare), Some(rows)) = (&scene.compare, &outcome.compared) else { return Ok(()) };
    if rows.is_empty() {
        return writeln!(text, "\nnone of the dates of {} lies on the way of this run", compare.csv.value);
    }
    let left_out: Vec<&str> = compare.without.iter().map(|law| law.value.as_str()).collect();
    let left_out = format!("without {}", left_out.join(", "));
    let wide = left_out.chars().count().max(14);
    let twice = rows.iter().any(|row| row.without.is_some());
    writeln!(text, "\ndistance from {}, in km", compare.csv.value)?;
    let column = compare.time.column.value.as_str();
    let julian = julian_days(&compare.time);
    let head = if twice { format!("  {left_out:>wide$}") } else { String::new() };
    let date = if julian { format!("  {:10}", "date") } else { String::new() };
    writeln!(text, "{:12}  {column:>12}{date}  {:>10}  {:>14}{head}", "body", "after", "with all laws")?;
    for row in rows {
        let km = |metres: f64| format!("{:.*}", if metres < 1e5 { 2 } else { 0 }, metres / 1e3);
        let without = row.without.map_or(String::new(), |metres| format!("  {:>wide$}", km(metres)));
        let (after, distance) = (duration(row.time), km(row.distance));
        let date = if julian { format!("  {}", calendar_date(row.date)) } else { String::new() };
        writeln!(text, "{:12}  {:>12}{date}  {after:>10}  {distance:>14}{without}", row.name, row.date)?;
    }
    let shown = |name: &str| rows.iter().any(|row| row.name == name);
    for (name, members) in compare.barycentres.iter().filter(|(name, _)| shown(&name.value)) {
        let members: Vec<&str> = members.iter().map(|label| label.value.as_str()).collect();
        writeln!(text, "{} is the barycentre of {}", name.value, members.join(" and "))?;
    }
    for (name, [body, from]) in compare.relative.iter().filter(|(name, _)| shown(&name.value)) {
        writeln!(text, "{} is {} as seen from {}", name.value, body.value, from.value)?;
    }
    if !outcome.skipped.is_empty() {
        writeln!(text, "not compared, for the scene does not have them: {}", outcome.skipped.join(", "))?;
    }
    Ok(())
}

/// Whether times are Julian days, by the name of their column and by their unit.
fn julian_days(time: &CompareTime) -> bool {
    let day = time.unit.as_ref().is_some_and(|unit| unit.value == "d");
    day && time.column.value.to_lowercase().starts_with("jd")
}

/// The day of the Gregorian calendar on which a Julian day number falls, which counts from noon of 1 January 4713 BC.
fn calendar_date(julian: f64) -> String {
    // Days from 1 March of the year 0: then a leap day is the last one of its year, and of its cycles of 4, 100, 400 years.
    let days = (julian + 0.5).floor() as i64 - 1_721_120;
    let (cycle, day) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (day - day / 1460 + day / 36_524 - day / 146_096) / 365;
    let day = day - (365 * year + year / 4 - year / 100);
    // Months from March: five have 153 days.
    let month = (5 * day + 2) / 153;
    let day = day - (153 * month + 2) / 5 + 1;
    let (month, next) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{:04}-{month:02}-{day:02}", 400 * cycle + year + next)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn julian_days_are_dates() {
        let dates = [2_440_432.5, 2_451_545.0, 2_451_604.4, 2_451_604.5, 2_451_605.5, 2_415_079.5, 2_444_239.5];
        let said = ["1969-07-30", "2000-01-01", "2000-02-29", "2000-03-01", "2000-03-02", "1900-03-01", "1980-01-01"];
        assert_eq!(dates.map(calendar_date), said);
    }
}
