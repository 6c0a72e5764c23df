//! A run in words.
//!
//! In: an outcome. Out: lines for people: what was done, what ran and what did not, what was kept, how far it is from
//! what is known. Never: a number with more digits than mean something.

use std::fmt::{self, Write};

use super::picture::duration;
use super::rounded;
use crate::run::drift::VectorDrift;
use crate::run::{LawOutcome, Outcome};
use crate::scene::{Scene, plural};

/// The summary of a run of `scene`.
pub fn summary(scene: &Scene, outcome: &Outcome) -> String {
    let mut text = String::new();
    // Writing to a string cannot fail.
    _ = write(&mut text, scene, outcome);
    text
}

fn write(text: &mut String, scene: &Scene, outcome: &Outcome) -> fmt::Result {
    if let Some(title) = &scene.title {
        writeln!(text, "{}", title.value)?;
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
    let by = if outcome.drift.by_parameter { " (times G)" } else { "" };
    if !known && outcome.drift.momenta.is_none() {
        return Ok(());
    }
    let line = |text: &mut String, name: &str, first: &str, last: &str, drift: &str| {
        writeln!(text, "{name:17}  {first:>32}  {last:>32}  {drift:>9}")
    };
    let said_drift = |drift: f64| if drift.is_nan() { "-".to_owned() } else { rounded(drift, 2).to_string() };
    writeln!(text)?;
    line(text, &format!("kept{by}"), "first", "last", "drift")?;
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
    if !energy.silent.is_empty() {
        writeln!(text, "the energy is without that of {}, which the law does not tell", energy.silent.join(", "))?;
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
    let head = if twice { format!("  {left_out:>wide$}") } else { String::new() };
    writeln!(text, "{:12}  {column:>12}  {:>10}  {:>14}{head}", "body", "after", "with all laws")?;
    for row in rows {
        let km = |metres: f64| format!("{:.*}", if metres < 1e5 { 2 } else { 0 }, metres / 1e3);
        let without = row.without.map_or(String::new(), |metres| format!("  {:>wide$}", km(metres)));
        let (after, distance) = (duration(row.time), km(row.distance));
        writeln!(text, "{:12}  {:>12}  {after:>10}  {distance:>14}{without}", row.name, row.date)?;
    }
    if !outcome.skipped.is_empty() {
        writeln!(text, "not compared, for the scene does not have them: {}", outcome.skipped.join(", "))?;
    }
    Ok(())
}
