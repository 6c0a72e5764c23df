//! Takes an engine from step to step, with a progress bar and a look at the laws' times now and then.
//!
//! In: an engine and the number of a step. Out: the engine there. Never: other results for other lengths of the pieces
//! in which it goes: they only decide how often the bar moves and the laws are watched.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use vesper::prelude::*;

use super::Request;
use super::law_times::LawTimes;

/// A piece that took less is followed by a longer one.
const SHORT: Duration = Duration::from_millis(5);
/// A piece that took more is followed by a shorter one.
const LONG: Duration = Duration::from_millis(50);
/// Watched pieces take about one part in this many of the run.
const WATCHED_PART: u32 = 20;

/// An engine on its way.
#[derive(Debug)]
pub struct Drive {
    times: Arc<LawTimes>,
    piece: u64,
    wall: Duration,
    watched: Duration,
    bar: ProgressBar,
    stop: Arc<AtomicBool>,
    /// Whether a law that fails ends the run.
    strict: bool,
}

impl Drive {
    /// For an engine with this many laws, which all have to run where it is `strict`, and a run of `steps` steps; with a progress bar if one is asked for and
    /// standard error is a terminal.
    pub fn new(laws: usize, steps: u64, what: &str, request: &Request, strict: bool) -> Self {
        let bar = if request.progress { ProgressBar::new(steps) } else { ProgressBar::hidden() };
        if let Ok(style) = ProgressStyle::with_template("{msg} [{bar:40}] {percent:>3} %, {eta} left") {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_message(what.to_owned());
        Self {
            times: Arc::new(LawTimes::new(laws)),
            piece: 1,
            wall: Duration::ZERO,
            watched: Duration::ZERO,
            bar,
            stop: request.stop.clone(),
            strict,
        }
    }

    /// Whether somebody asked for the run to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    /// Takes `engine` to step `target`, by steps of `step` s; not so far where somebody asked for the run to stop.
    ///
    /// # Errors
    /// As [`Engine::steps_of`]; the engine stands where it broke.
    pub fn to<P: Precision>(&mut self, engine: &mut Engine<P>, target: u64, step: f64) -> Result<(), Faults> {
        while engine.steps() < target && !self.is_stopped() {
            let count = self.piece.min(target - engine.steps());
            let took = self.piece(engine, count, step)?;
            if count == self.piece && took < SHORT {
                self.piece = self.piece.saturating_mul(2);
            } else if took > LONG {
                self.piece = (self.piece / 2).max(1);
            }
        }
        Ok(())
    }

    fn piece<P: Precision>(&mut self, engine: &mut Engine<P>, count: u64, step: f64) -> Result<Duration, Faults> {
        let watch = self.watched * WATCHED_PART <= self.wall;
        if watch {
            engine.set_probe(Some(self.times.clone()));
        }
        let from = Instant::now();
        let result = contained(engine.steps_of(count, step), self.strict);
        let took = from.elapsed();
        self.wall += took;
        if watch {
            engine.set_probe(None);
            self.watched += took;
        }
        self.bar.inc(count);
        result.map(|()| took)
    }

    /// Ends the run: its time, in s, and each law's.
    pub fn finish(self) -> (f64, Vec<f64>) {
        self.bar.finish_and_clear();
        (self.wall.as_secs_f64(), self.times.seconds(self.wall, self.watched))
    }
}

/// A law that failed is switched off, which the report says, and the others go on; but where every law has to run.
pub(super) fn contained(result: Result<(), Faults>, strict: bool) -> Result<(), Faults> {
    match result {
        Err(faults) if !strict && faults.iter().all(|fault| matches!(fault, Fault::LawFailed { .. })) => Ok(()),
        other => other,
    }
}
