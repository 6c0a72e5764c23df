//! A run as one JSON object.
//!
//! In: an outcome. Out: the object, in SI; numbers read back to the same bits, numbers that are not finite are null.

use serde_json::{Map, Value, json};

use crate::run::Outcome;
use crate::run::drift::{Drift, VectorDrift};
use crate::run::snapshot::{Shown, ShownDomain};

/// The object that `run --json` prints and `summary.json` holds.
pub fn outcome(outcome: &Outcome) -> Value {
    let domains: Map<String, Value> =
        outcome.domains.iter().map(|domain| (domain.name.clone(), columns(domain))).collect();
    let laws: Vec<Value> = outcome.laws.iter().map(law).collect();
    let mut object = json!({
        "time": outcome.time,
        "steps": outcome.steps,
        "evaluations": outcome.evaluations,
        "wall_seconds": outcome.wall_seconds,
        "domains": domains,
        "laws": laws,
        "unused": outcome.unused,
        "transfers": { "uploads": 0, "upload_bytes": 0, "downloads": 0, "download_bytes": 0 },
        "invariants": invariants(&outcome.drift),
    });
    let Some(root) = object.as_object_mut() else { return object };
    if let Some(compared) = &outcome.compared {
        let rows: Vec<Value> = compared
            .iter()
            .map(|row| {
                let mut object = json!({
                    "name": row.name,
                    "date": row.date,
                    "time": row.time,
                    "distance": row.distance,
                });
                if let (Some(without), Some(fields)) = (row.without, object.as_object_mut()) {
                    fields.insert("distance_without".to_owned(), json!(without));
                }
                object
            })
            .collect();
        root.insert("compare".to_owned(), Value::Array(rows));
    }
    if outcome.interrupted && outcome.faults.is_empty() {
        root.insert("error".to_owned(), json!("interrupted"));
    }
    if !outcome.faults.is_empty() {
        let texts: Vec<&str> = outcome.faults.iter().map(|fault| fault.text.as_str()).collect();
        root.insert("error".to_owned(), json!(texts.join("; ")));
    }
    object
}

/// Energy, momentum and angular momentum over a run; of momenta nothing, where no rows have them.
pub fn invariants(drift: &Drift) -> Value {
    let energy = &drift.energy;
    let mut invariants = Map::new();
    let mut energy_object = json!({
        "first": energy.first,
        "last": energy.last,
        "max_relative_drift": energy.max_relative_drift,
    });
    if let (false, Some(object)) = (energy.silent.is_empty(), energy_object.as_object_mut()) {
        object.insert("laws_without_energy".to_owned(), json!(energy.silent));
    }
    invariants.insert("energy".to_owned(), energy_object);
    let momenta = drift.momenta.as_ref();
    let of =
        |which: fn(&(VectorDrift, VectorDrift)) -> VectorDrift| momenta.map_or(json!({}), |both| vector(which(both)));
    invariants.insert("momentum".to_owned(), of(|both| both.0));
    invariants.insert("angular_momentum".to_owned(), of(|both| both.1));
    Value::Object(invariants)
}

/// JSON for people too: an entry a line, but lists of numbers and objects in lists each on one line.
pub fn text(value: &Value) -> String {
    let mut text = String::new();
    write(&mut text, value, 0);
    text.push('\n');
    text
}

fn write(text: &mut String, value: &Value, depth: usize) {
    let indent = "  ".repeat(depth + 1);
    match value {
        Value::Object(fields) if !fields.is_empty() => {
            text.push_str("{\n");
            for (index, (key, value)) in fields.iter().enumerate() {
                text.push_str(&format!("{indent}{}: ", Value::from(key.as_str())));
                write(text, value, depth + 1);
                text.push_str(if index + 1 < fields.len() { ",\n" } else { "\n" });
            }
            text.push_str(&format!("{}}}", "  ".repeat(depth)));
        }
        Value::Array(items) if items.first().is_some_and(Value::is_object) => {
            let lines: Vec<String> = items.iter().map(|item| format!("{indent}{item}")).collect();
            text.push_str(&format!("[\n{}\n{}]", lines.join(",\n"), "  ".repeat(depth)));
        }
        _ => text.push_str(&value.to_string()),
    }
}

fn law(law: &crate::run::LawOutcome) -> Value {
    let mut object = json!({ "name": law.name, "status": law.status });
    if let Some(fields) = object.as_object_mut() {
        if let Some(backend) = law.backend {
            fields.insert("backend".to_owned(), json!(backend));
            fields.insert("seconds".to_owned(), json!(law.seconds));
        }
        if let Some(reason) = &law.reason {
            fields.insert("reason".to_owned(), json!(reason));
        }
    }
    object
}

fn vector(drift: VectorDrift) -> Value {
    json!({ "first": drift.first, "last": drift.last, "max_relative_drift": drift.max_relative_drift })
}

fn columns(domain: &ShownDomain) -> Value {
    let columns: Map<String, Value> =
        domain.columns.iter().map(|column| (column.property.name.to_owned(), values(column))).collect();
    Value::Object(columns)
}

/// A list with an entry for each row; of a subset, as in a scene, `{ rows, value }`.
fn values(column: &Shown) -> Value {
    let is_link = matches!(column.property.kind, vesper::prelude::Kind::Link(_));
    // Row numbers are whole, and look so.
    let number = |number: &f64| if is_link { json!(*number as u64) } else { json!(number) };
    let list = match column.width() {
        1 if !is_link => column.numbers.iter().map(number).collect(),
        width => column.numbers.chunks(width.max(1)).map(|row| row.iter().map(number).collect()).collect(),
    };
    match &column.subset {
        None => Value::Array(list),
        Some(rows) => json!({ "rows": rows, "value": list }),
    }
}
