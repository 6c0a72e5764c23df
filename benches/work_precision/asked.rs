//! REBOUND's runs of a task, by a script.

use super::compared::Curve;
use crate::Task;
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

/// An integrator with each of its settings.
///
/// # Errors
/// In words: what is missing.
pub fn curve(task: &Task, name: &str, settings: &[f64], options: &[(&str, &str)]) -> Result<Curve, String> {
    let python = std::env::var("VESPER_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("rebound_runs.py");
    let options: serde_json::Map<String, Value> =
        options.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
    let runs: Vec<Value> =
        settings.iter().map(|setting| json!({ "integrator": name, "setting": setting, "options": options })).collect();
    let bodies: Vec<Value> =
        task.case.bodies.iter().map(|body| json!([body.mass, body.position, body.velocity])).collect();
    let asked = json!({
        "g": task.gravity, "bodies": bodies, "times": task.problem.times, "runs": runs, "repeats": 1,
    });
    let missing = |what: String| format!("{what}; install it by `pip install rebound`, and say VESPER_PYTHON=..");
    let mut child = Command::new(&python)
        .arg(script)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| missing(format!("`{python}` cannot be run: {error}")))?;
    if let Some(mut input) = child.stdin.take() {
        // A script that does not read has ended; its words tell why.
        _ = input.write_all(asked.to_string().as_bytes());
    }
    let done = child.wait_with_output().map_err(|error| format!("`{python}` ended: {error}"))?;
    if !done.status.success() {
        let words = String::from_utf8_lossy(&done.stderr);
        return Err(missing(words.lines().last().unwrap_or("the script failed").to_owned()));
    }
    let told: Value = serde_json::from_slice(&done.stdout).map_err(|error| format!("the script says {error}"))?;
    let numbers = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
    let states = |run: &Value| -> Vec<[Vec<f64>; 2]> {
        let moments = run["states"].as_array().into_iter().flatten();
        let part = |moment: &Value, part: usize| -> Vec<f64> {
            let bodies = moment.as_array().into_iter().flatten();
            bodies.flat_map(|body| (0..3).map(move |c| numbers(&body[part][c]))).collect()
        };
        moments.map(|moment| [part(moment, 0), part(moment, 1)]).collect()
    };
    let points = told["runs"].as_array().into_iter().flatten().map(|run| {
        let seconds = run["seconds"].as_array().into_iter().flatten().map(numbers).collect();
        (task.error(&states(run)), seconds)
    });
    let version = told["version"].as_str().unwrap_or("");
    let told = |option: &str, words| if options.contains_key(option) { words } else { "" };
    let words = [told("corrector", ", corrected"), told("kernel", ", lazy kernel")].concat();
    Ok(Curve { name: format!("REBOUND {version} {name}{words}"), points: points.collect() })
}
