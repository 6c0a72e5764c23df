//! A run, told: everything that a user wants to know of it.
//!
//! In: an engine at its end. Out: plain data, the same for each precision. Never: a file, a format.

use vesper::prelude::*;

use super::drift::Drift;
use super::snapshot::ShownDomain;
use crate::fault::SceneFault;

/// What became of a law.
#[derive(Clone, Debug, PartialEq)]
pub struct LawOutcome {
    /// Its label, or else its name.
    pub name: String,
    /// The domain it stands on.
    pub domain: String,
    /// "active", "dormant", "pruned", "off", "failed".
    pub status: &'static str,
    /// Why it does not run.
    pub reason: Option<String>,
    /// Rows it runs on.
    pub rows: usize,
    /// "cpu" or "parallel", where it runs.
    pub backend: Option<&'static str>,
    /// Time it took, in s, scaled up from a sample; of all threads together.
    pub seconds: f64,
}

/// One distance from a position known from elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// The name in the table.
    pub name: String,
    /// The time as the table says it.
    pub date: f64,
    /// The time of the scene, in s.
    pub time: f64,
    /// Its row in the table.
    pub row: usize,
    /// Distance with all laws, in m.
    pub distance: f64,
    /// Distance without the laws left out, in m.
    pub without: Option<f64>,
}

/// A run, told.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Time reached, in s.
    pub time: f64,
    /// Steps taken, since the scene's start; an adaptive integrator's own.
    pub steps: u64,
    /// Steps that an adaptive integrator tried and gave up.
    pub rejected: u64,
    /// The length of a last step that was shorter than the others, and theirs, in s.
    pub short_step: Option<(f64, f64)>,
    /// Evaluations of the laws, since the scene's start.
    pub evaluations: u64,
    /// Time of the integration in this run, in s.
    pub wall_seconds: f64,
    /// "f32", "f64" or "double-double".
    pub precision: &'static str,
    /// The integrator's name.
    pub integrator: String,
    /// The shown columns at the end.
    pub domains: Vec<ShownDomain>,
    /// The laws, as listed.
    pub laws: Vec<LawOutcome>,
    /// Columns, constants and fields that no running law touches.
    pub unused: Vec<String>,
    /// Energy, momentum, angular momentum.
    pub drift: Drift,
    /// Distances, where the scene compares, in the order of its table.
    pub compared: Option<Vec<Compared>>,
    /// Names of the table that the scene does not have.
    pub skipped: Vec<String>,
    /// The engine after its last whole step; of a run that failed, at a moment before that, if there was one.
    pub checkpoint: Option<Checkpoint>,
    /// Whether somebody stopped the run before its end.
    pub interrupted: bool,
    /// Why the run did not reach its end; empty if it did.
    pub faults: Vec<SceneFault>,
}

/// What became of each law of `engine`, which took so many `seconds`.
pub(super) fn law_outcomes<P: Precision>(engine: &Engine<P>, seconds: &[f64]) -> Vec<LawOutcome> {
    let backends = engine.backends();
    let outcome = |(index, law): (usize, &vesper::registry::LawReport)| {
        let runs = matches!(law.status, Status::Active { .. });
        let backend = backends.get(index).copied().flatten().filter(|_| runs);
        LawOutcome {
            name: law.label.clone(),
            domain: law.domain.clone(),
            status: law.status.word(),
            reason: match &law.status {
                Status::Dormant(why) => Some(why.to_string()),
                Status::Pruned { results, saving } => Some(format!(
                    "neither the integrator nor an observer needs {}; {saving} saved per evaluation",
                    results.join(", ")
                )),
                Status::Failed { reason } => Some(reason.clone()),
                Status::Active { .. } | Status::Off => None,
            },
            rows: if let Status::Active { rows } = law.status { rows } else { 0 },
            backend: backend.map(|backend| match backend {
                Backend::Parallel => "parallel",
                Backend::Gpu => "gpu",
                Backend::Fastest => "fastest",
                Backend::Cpu | Backend::Auto => "cpu",
            }),
            seconds: seconds.get(index).copied().unwrap_or(0.0),
        }
    };
    engine.report().laws.iter().enumerate().map(outcome).collect()
}
