//! The runs of a sweep as one table: comma-separated values for programs, columns of text for people.
//!
//! In: an ensemble, its records. Out: text that depends on nothing else: the same bytes however the runs were shared out, but for how far
//! those came that were given up. Never: a time of a clock.

use super::ensemble::Ensemble;
use super::record::{DRIFTS, Record};
use crate::output::rounded;
use crate::output::table::cell;

/// For people, more runs than this are looked at with other means.
const MOST_LINES: usize = 200;

/// A line for each run, in SI; numbers read back to the same bits, a cell without a number is empty.
pub fn csv(ensemble: &Ensemble, records: &[Record]) -> String {
    let mut head = vec!["run".to_owned()];
    head.extend(ensemble.varies.iter().map(|vary| vary.path.clone()));
    head.extend(["status", "time", "steps", "evaluations"].map(str::to_owned));
    head.extend(DRIFTS.map(|(_, name)| name.to_owned()));
    head.extend(ensemble.measures.iter().map(|measure| measure.text.clone()));
    head.push("error".to_owned());
    let mut text = line(&head);
    let number = |value: Option<f64>| value.map_or_else(String::new, |value| format!("{value:?}"));
    for record in records {
        let mut cells = vec![record.run.to_string()];
        cells.extend(ensemble.parameters(record.run).into_iter().map(|(_, value)| value.to_owned()));
        cells.push(record.status().to_owned());
        cells.push(number(Some(record.time).filter(|time| time.is_finite())));
        cells.extend([record.steps.to_string(), record.evaluations.to_string()]);
        cells.extend(DRIFTS.map(|(name, _)| number(record.drift(name))));
        cells.extend(record.measures.iter().map(|value| number(*value)));
        cells.push(record.fault.clone().unwrap_or_default());
        text += &line(&cells);
    }
    text
}

fn line(cells: &[String]) -> String {
    let cells: Vec<String> = cells.iter().map(|text| cell(text)).collect();
    format!("{}\n", cells.join(","))
}

/// The same in columns of one width each, without columns that no run has a number for.
pub fn words(ensemble: &Ensemble, records: &[Record]) -> String {
    let number =
        |value: Option<f64>, digits| value.map_or_else(String::new, |value| rounded(value, digits).to_string());
    let shown = &records[..records.len().min(MOST_LINES)];
    let mut columns: Vec<Vec<String>> = Vec::new();
    let mut add = |head: String, cells: &mut dyn Iterator<Item = String>| {
        let cells: Vec<String> = cells.collect();
        if cells.iter().any(|cell| !cell.is_empty()) {
            columns.push([vec![head], cells].concat());
        }
    };
    add("run".to_owned(), &mut shown.iter().map(|record| record.run.to_string()));
    for (place, vary) in ensemble.varies.iter().enumerate() {
        let value = |record: &Record| vary.values.get(ensemble.indices(record.run)[place]).map_or("", String::as_str);
        let value = |record: &Record| short(value(record));
        add(vary.path.clone(), &mut shown.iter().map(value));
    }
    add("time [s]".to_owned(), &mut shown.iter().map(|record| number(Some(record.time), 6)));
    add("steps".to_owned(), &mut shown.iter().map(|record| record.steps.to_string()));
    for (name, column) in DRIFTS {
        add(column.replace('_', " "), &mut shown.iter().map(|record| number(record.drift(name), 3)));
    }
    for (place, measure) in ensemble.measures.iter().enumerate() {
        let unit = if measure.unit.is_empty() { String::new() } else { format!(" [{}]", measure.unit) };
        let value = |record: &Record| number(record.measures.get(place).copied().flatten(), 7);
        add(format!("{}{unit}", measure.text), &mut shown.iter().map(value));
    }
    let widths: Vec<usize> =
        columns.iter().map(|cells| cells.iter().map(|cell| cell.chars().count()).max().unwrap_or(0)).collect();
    let mut text = format!("{}\n", ensemble.title);
    for row in 0..=shown.len() {
        let cells: Vec<String> =
            columns.iter().zip(&widths).map(|(cells, width)| format!("{:>width$}", cells[row])).collect();
        let failed = row.checked_sub(1).map_or_else(String::new, |row| failure(&shown[row], &shown[..row]));
        text += &format!("{}\n", format!("{}{failed}", cells.join("  ")).trim_end());
    }
    if records.len() > shown.len() {
        text += &format!("and {} more\n", records.len() - shown.len());
    }
    text
}

/// Why a run failed; of a reason that stands above already, only where.
fn failure(record: &Record, before: &[Record]) -> String {
    let Some(fault) = &record.fault else { return String::new() };
    match before.iter().find(|known| known.fault.as_ref() == Some(fault)) {
        Some(known) => format!("  failed as run {}", known.run),
        None => format!("  failed: {fault}"),
    }
}

/// A value in at most eight digits, where it has a fraction.
fn short(value: &str) -> String {
    let number = value.parse().ok().filter(|number: &f64| number.is_finite() && value.contains(['.', 'e']));
    number.map_or_else(|| value.to_owned(), |number| rounded(number, 8).to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sweep::{Measure, Vary};
    use serde_json::json;

    #[test]
    fn a_failed_run_has_its_reason_and_no_numbers() {
        let ensemble = Ensemble {
            title: "a scene".to_owned(),
            varies: vec![Vary::read("engine.step=[0.5, 1]").unwrap()],
            measures: vec![Measure { unit: "m".to_owned(), ..Measure::read("a.b[0].x").unwrap() }],
        };
        let done = Record {
            run: 1,
            fault: None,
            time: 2.0,
            steps: 4,
            evaluations: 5,
            invariants: json!({ "energy": { "max_relative_drift": 1e-3 }, "momentum": {}, "angular_momentum": {} }),
            measures: vec![Some(1.0 / 3.0)],
            wall_seconds: 0.5,
        };
        let fault = Some("x, y".to_owned());
        let failed = Record { fault, time: 1.0, ..Record::refused(&ensemble, 2, &[]) };
        assert_eq!(failure(&failed, std::slice::from_ref(&failed)), "  failed as run 2");
        let records = [done, failed];
        assert_eq!(
            csv(&ensemble, &records),
            "run,engine.step,status,time,steps,evaluations,energy_drift,momentum_drift,angular_momentum_drift,\
             a.b[0].x,error\n1,0.5,done,2.0,4,5,0.001,,,0.3333333333333333,\n2,1,failed,1.0,0,0,,,,,\"x, y\"\n"
        );
        let text = words(&ensemble, &records);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines[1], "run  engine.step  time [s]  steps  energy drift  a.b[0].x [m]");
        assert_eq!(lines[2], "  1          0.5         2      4         0.001     0.3333333");
        assert!(lines[3].ends_with("  failed: x, y"), "{text}");
    }
}
