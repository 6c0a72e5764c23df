//! Runs of a task by programs of their own, which are asked in JSON: REBOUND by a script, diffsol by a program that is built here.

use super::compared::Curve;
use crate::{REPEATS, SECONDS, Task};
use serde_json::{Value, json};
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::OnceLock;

/// Who is asked.
#[derive(Clone, Copy, Debug)]
pub enum Peer {
    /// By the script beside the benches.
    Rebound,
    /// By the program beside the benches, in a workspace of its own: nobody builds its crates who does not measure.
    Diffsol,
}

impl Peer {
    fn name(self) -> &'static str {
        match self {
            Peer::Rebound => "REBOUND",
            Peer::Diffsol => "diffsol",
        }
    }

    /// What runs it, and what is to be done where that fails.
    fn command(self) -> Result<(Command, &'static str), String> {
        let benches = Path::new(env!("CARGO_MANIFEST_DIR"));
        match self {
            Peer::Rebound => {
                let python = std::env::var("VESPER_PYTHON").unwrap_or_else(|_| "python3".to_owned());
                let mut command = Command::new(python);
                command.arg(benches.join("rebound_runs.py"));
                Ok((command, "install it by `pip install rebound`, and say VESPER_PYTHON=.."))
            }
            Peer::Diffsol => {
                static BUILT: OnceLock<Result<(), String>> = OnceLock::new();
                let folder = benches.join("../target/diffsol");
                let build = || {
                    let mut cargo = Command::new(env!("CARGO"));
                    cargo
                        .args(["build", "--release", "--quiet", "--manifest-path"])
                        .arg(benches.join("diffsol/Cargo.toml"));
                    let built = cargo.arg("--target-dir").arg(&folder).status();
                    match built.map_err(|error| error.to_string())? {
                        status if status.success() => Ok(()),
                        status => Err(format!("it cannot be built: {status}")),
                    }
                };
                BUILT.get_or_init(build).clone()?;
                Ok((Command::new(folder.join("release/diffsol-runs")), "look at what it says"))
            }
        }
    }
}

/// An integrator with each of its settings.
///
/// # Errors
/// In words: what is missing.
pub fn curve(peer: Peer, task: &Task, name: &str, settings: &[f64], options: &[(&str, &str)]) -> Result<Curve, String> {
    let options: serde_json::Map<String, Value> =
        options.iter().map(|(name, value)| ((*name).to_owned(), json!(value))).collect();
    let runs: Vec<Value> =
        settings.iter().map(|setting| json!({ "integrator": name, "setting": setting, "options": options })).collect();
    let bodies: Vec<Value> =
        task.case.bodies.iter().map(|body| json!([body.mass, body.position, body.velocity])).collect();
    let asked = json!({
        "g": task.gravity, "bodies": bodies, "times": task.problem.times, "scales": task.scales(), "runs": runs,
        "repeats": REPEATS, "seconds": SECONDS,
    });
    let (mut command, mend) = peer.command()?;
    let missing = |what: String| format!("{what}; {mend}");
    let mut child = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .map_err(|error| missing(format!("{} cannot be run: {error}", peer.name())))?;
    if let Some(mut input) = child.stdin.take() {
        // A script that does not read has ended; its words tell why.
        _ = input.write_all(asked.to_string().as_bytes());
    }
    let done = child.wait_with_output().map_err(|error| format!("{} ended: {error}", peer.name()))?;
    if !done.status.success() {
        let words = String::from_utf8_lossy(&done.stderr);
        return Err(missing(words.lines().last().unwrap_or("it failed").to_owned()));
    }
    let told: Value =
        serde_json::from_slice(&done.stdout).map_err(|error| format!("what it says is no JSON: {error}"))?;
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
        let seconds = run["seconds"].as_array().into_iter().flatten().map(numbers);
        (task.error(&states(run)), vec![seconds.fold(f64::INFINITY, f64::min)])
    });
    let version = told["version"].as_str().unwrap_or("");
    let told = |option: &str, words| if options.contains_key(option) { words } else { "" };
    let words = [told("corrector", ", corrected"), told("kernel", ", lazy kernel")].concat();
    Ok(Curve { name: format!("{} {version} {name}{words}", peer.name()), points: points.collect() })
}
