//! The summary: one line for each pair of times, printed as a table, and kept as `benches/results/summary.csv`.
//!
//! Our loops are chosen at run time; those of peers are compiled for the processor that a build is for. So a build for the very
//! processor that it runs on (`RUSTFLAGS="-C target-cpu=native"`) is another study, whose name ends in `_native`.

use crate::{Run, Time};
use std::fs;
use std::path::PathBuf;
use vesper::real::Isa;

const HEADER: &str = "study,case,n,threads,precision,backend,ours,unit,error,peer,peers,ratio,peer_error,processor";

/// The lines of one study. When it ends they are put in place of its old ones: of all, or, where words have chosen some cases, of
/// the same ones.
#[derive(Debug)]
pub struct Summary {
    study: String,
    run: Run,
    lines: Vec<String>,
}

/// What was raced.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// Its name, without a comma.
    pub name: &'a str,
    /// Rows or links.
    pub n: usize,
    /// Threads; 0 for a graphics processor.
    pub threads: usize,
    /// "f32" or "f64".
    pub precision: &'a str,
    /// The unit of the times.
    pub unit: &'a str,
    /// The error of our result by a reference, where the study has one; what it is, the study says.
    pub error: Option<f64>,
}

impl Summary {
    /// A study that has no lines yet.
    pub fn new(study: &'static str, run: Run) -> Self {
        if run == Run::Measure {
            println!(
                "{:<10} {:<38} {:>9} {:>7} {:<4} {:>25} {:>12} {:<8}  {:<26} {:>10} {:>6} {:<8}",
                "study",
                "case",
                "n",
                "threads",
                "",
                "ours: median (quartiles)",
                "",
                "error",
                "peer",
                "median",
                "ratio",
                "error"
            );
        }
        let study = if cfg!(target_feature = "avx2") { format!("{study}_native") } else { study.to_owned() };
        Summary { study, run, lines: Vec::new() }
    }

    /// Notes our time beside those of the peers, each with the error of its result, by our reference where there is one, else the
    /// largest difference from ours in parts of it.
    pub fn add(&mut self, case: Case<'_>, ours: Time, peers: &[(Time, Option<f64>)]) {
        let Case { name, n, threads, precision, unit, error } = case;
        assert!(!name.contains(','), "{name}: a comma would end the cell of the summary");
        let Time { median, low, high, .. } = ours;
        let study = &self.study;
        if self.run == Run::Test {
            println!("{study} {name} n={n} {precision} {threads}: runs");
        }
        let backend = match threads {
            0 => "gpu",
            1 => "cpu",
            _ => "parallel",
        };
        let number = |error: Option<f64>| error.map_or(String::new(), |error| format!("{error:.1e}"));
        let kept = format!("{study},{name},{n},{threads},{precision},{backend},{median:.4},{unit},{}", number(error));
        let mut shown = format!(
            "{study:<10} {name:<38} {n:>9} {threads:>7} {precision:<4} {:>25} {unit:>12} {:<8}",
            format!("{median:.4} ({low:.4}-{high:.4})"),
            number(error)
        );
        for (peer, error) in peers {
            let ratio = median / peer.median;
            let (Time { name, median, .. }, error) = (peer, number(*error));
            if self.run == Run::Measure {
                println!("{shown}  {name:<26} {median:>10.4} {ratio:>6.2} {error:<8}");
                shown = " ".repeat(shown.chars().count());
            }
            self.lines.push(format!("{kept},{name},{median:.4},{ratio:.4},{error},{}", processor()));
        }
        if peers.is_empty() {
            if self.run == Run::Measure {
                println!("{shown}");
            }
            self.lines.push(format!("{kept},,,,,{}", processor()));
        }
    }

    /// Puts the lines in place of the study's old ones.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(self) -> std::io::Result<()> {
        if self.run != Run::Measure || self.lines.is_empty() {
            return Ok(());
        }
        let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("results/summary.csv");
        let old = fs::read_to_string(&path).unwrap_or_default();
        let keys: Vec<_> = self.lines.iter().map(|line| key(line)).collect();
        let replaced = |line: &str| match Run::is_whole() {
            true => line.split(',').next() == Some(&self.study),
            false => keys.contains(&key(line)),
        };
        let kept = old.lines().skip(1).filter(|line| !replaced(line)).map(str::to_owned);
        let mut lines: Vec<String> = kept.chain(self.lines.clone()).collect();
        // A study's lines stay together, in the order in which they were made.
        lines.sort_by(|a, b| a.split(',').next().cmp(&b.split(',').next()));
        fs::write(&path, [HEADER.to_owned()].into_iter().chain(lines).collect::<Vec<_>>().join("\n") + "\n")?;
        println!("{}: {} lines are in benches/results/summary.csv", self.study, self.lines.len());
        Ok(())
    }
}

/// The processor's name, where the system tells, and its widest lanes that are used.
fn processor() -> String {
    let told = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let name = told.lines().find_map(|line| line.strip_prefix("model name")?.split(':').nth(1));
    format!("{} {:?}", name.unwrap_or("unknown").trim().replace(',', ";"), Isa::detect())
}

/// What a line is about: study, case, rows, threads, precision, backend, peer.
fn key(line: &str) -> Vec<&str> {
    line.split(',').enumerate().filter(|(column, _)| *column < 6 || *column == 9).map(|(_, cell)| cell).collect()
}
