//! The summary: one line for each pair of times, printed, and kept as `bench-summary.csv` in the target folder.

use crate::{Run, Time};
use std::fs;
use std::path::PathBuf;

const HEADER: &str = "study,case,n,threads,precision,backend,ours,peer,peers,ratio,error,unit";

/// The lines of one study. Written when it ends; lines of other cases and peers stay.
#[derive(Debug)]
pub struct Summary {
    study: &'static str,
    run: Run,
    lines: Vec<String>,
}

/// What was raced.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// Its name, without a comma.
    pub name: &'a str,
    /// Rows, pairs or links.
    pub n: usize,
    /// Threads.
    pub threads: usize,
    /// "f32" or "f64".
    pub precision: &'a str,
    /// The unit of the times.
    pub unit: &'a str,
}

impl Summary {
    /// A study that has no lines yet.
    pub fn new(study: &'static str, run: Run) -> Self {
        Summary { study, run, lines: Vec::new() }
    }

    /// Notes our time beside those of the peers; an error is the largest difference from that peer's result, in parts
    /// of it.
    pub fn add(&mut self, case: Case<'_>, ours: Time, peers: &[(Time, Option<f64>)]) {
        let Case { name, n, threads, precision, unit } = case;
        assert!(!name.contains(','), "{name}: a comma would end the cell of the summary");
        let Time { median, low, high, .. } = ours;
        if self.run == Run::Test {
            println!("{} {name} n={n} {precision}: runs", self.study);
        } else {
            let on = if threads == 1 { String::new() } else { format!(" on {threads} threads") };
            println!("{:<9} {name:<28} n={n:<8} {precision}{on}", self.study);
            println!("    {:<26} {median:>9.3} {unit}  ({low:.3} to {high:.3})", "ours");
        }
        let backend = if threads == 1 { "cpu" } else { "parallel" };
        for (peer, error) in peers {
            let ratio = median / peer.median;
            let told = error.map_or(String::new(), |error| format!("  error {error:.1e}"));
            if self.run == Run::Measure {
                let Time { name, median, low, high } = peer;
                println!("    {name:<26} {median:>9.3} {unit}  ({low:.3} to {high:.3})  ours/its {ratio:.2}{told}");
            }
            let error = error.map_or(String::new(), |error| format!("{error:e}"));
            self.lines.push(format!(
                "{},{name},{n},{threads},{precision},{backend},{median:.4},{},{:.4},{ratio:.4},{error},{unit}",
                self.study, peer.name, peer.median
            ));
        }
    }

    /// Puts the lines in place of the study's old ones.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(self) -> std::io::Result<()> {
        let (Run::Measure, Some(path)) = (self.run, path()) else { return Ok(()) };
        let old = fs::read_to_string(&path).unwrap_or_default();
        let keys: Vec<_> = self.lines.iter().map(|line| key(line)).collect();
        let kept = old.lines().skip(1).filter(|line| !keys.contains(&key(line))).map(str::to_owned);
        let lines: Vec<String> = [HEADER.to_owned()].into_iter().chain(kept).chain(self.lines.clone()).collect();
        fs::write(&path, lines.join("\n") + "\n")?;
        println!("{} lines are in {}", self.study, path.display());
        Ok(())
    }
}

/// What a line is about: all columns but the measured ones.
fn key(line: &str) -> Vec<&str> {
    line.split(',').enumerate().filter(|(column, _)| *column < 6 || *column == 7).map(|(_, cell)| cell).collect()
}

/// `target/bench-summary.csv`: a bench is `target/release/deps/NAME`.
fn path() -> Option<PathBuf> {
    Some(std::env::current_exe().ok()?.ancestors().nth(3)?.join("bench-summary.csv"))
}
