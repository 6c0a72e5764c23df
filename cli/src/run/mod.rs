//! A run of a scene: from its engine to an [`Outcome`] that can be printed, saved and drawn.
//!
//! In: a scene, what to record. Out: every mistake of the scene, or else everything that a user wants to know of the run,
//! also of one that failed on its way. Never: a file; whoever wants files brings a recorder.

pub mod compare;
pub mod course;
pub mod drift;
mod drive;
mod law_times;
mod outcome;
pub mod patience;
pub mod snapshot;
pub mod stable;
mod way;

pub use outcome::{Compared, LawOutcome, Outcome};

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use vesper::prelude::*;
use vesper_laws::catalog::CatalogPrecision;

use crate::assemble;
use crate::fault::{SceneFault, number};
use crate::scene::Scene;
use compare::Targets;
use course::Course;
use drive::Drive;
use snapshot::{ShownDomain, shown_columns, snapshot};

/// How a scene is run.
#[derive(Clone, Debug, Default)]
pub struct Request {
    /// Whether to show a progress bar, where standard error is a terminal.
    pub progress: bool,
    /// Record every frame of so many, the first and the last; 0 for none.
    pub record_every: u64,
    /// Draw every frame of so many, beside those recorded; 0 for none.
    pub draw_every: u64,
    /// Once it is true, the run ends with the step that it is in.
    pub stop: Arc<AtomicBool>,
}

/// What a recorder gets: the engine, and the columns shown; none at a moment that is only to be drawn.
pub type Record<'r, P> = dyn FnMut(&Engine<P>, Option<&[ShownDomain]>) -> Result<(), String> + 'r;

/// A scene that is ready to run: everything that can be wrong with it has been looked at.
#[derive(Debug)]
pub struct Ready<'s, P: CatalogPrecision> {
    scene: &'s Scene,
    /// The engine, where it begins.
    pub engine: Engine<P>,
    /// Its steps.
    pub course: Course,
    targets: Targets,
    resumed: bool,
}

/// A checkpoint from behind the end leaves nothing to run; one from the end itself was asked for twice, which is no fault.
fn past_the_end<P: Precision>(scene: &Scene, engine: &Engine<P>, course: &Course) -> Result<(), Vec<SceneFault>> {
    let slack = 1e-9 * course.step;
    let Some(end) = scene.engine.end.as_ref().filter(|end| engine.time() > end.value + slack) else { return Ok(()) };
    let text =
        format!("the checkpoint, at {} s, is already past the end, {} s", number(engine.time()), number(end.value));
    let help = "set a later end, with --end S, or leave --resume out".to_owned();
    Err(vec![scene.fault(end.span, text, Some(help))])
}

impl<'s, P: CatalogPrecision> Ready<'s, P> {
    /// Puts the scene together, to begin at its start or to go on from a checkpoint.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn new(scene: &'s Scene, resume: Option<&Checkpoint>) -> Result<Self, Vec<SceneFault>> {
        let engine = assemble::engine::<P>(scene);
        // A scene starts at 0 s, or at its constant `time`.
        let start = engine.as_ref().map_or(0.0, Engine::time);
        let course = Course::new(scene, start);
        let targets = scene.compare.as_ref().map(|compare| compare::targets(scene, compare, start)).transpose();
        let mut faults = Vec::new();
        let engine = engine.map_err(|more| faults.extend(more)).ok();
        let course = course.map_err(|more| faults.extend(more)).ok();
        let targets = targets.map_err(|more| faults.extend(more)).ok();
        let (Some(mut engine), Some(mut course), Some(targets)) = (engine, course, targets) else {
            return Err(faults);
        };
        let asleep = assemble::asleep(scene, engine.report());
        if !asleep.is_empty() {
            return Err(asleep);
        }
        if let Some(checkpoint) = resume {
            engine.restore(checkpoint).map_err(|faults| assemble::run_faults(scene, &faults))?;
            course = course.resumed(checkpoint);
            past_the_end(scene, &engine, &course)?;
        }
        Ok(Self { scene, engine, course, targets: targets.unwrap_or_default(), resumed: resume.is_some() })
    }

    /// In words, that the step is longer than the integrator bears at the start; `None` where it is not, or not known.
    pub fn too_long(&mut self) -> Option<String> {
        let stable = stable::longest(&mut self.engine)?;
        let step = self.course.step.min(self.course.end - self.engine.time());
        stable::too_long(self.engine.integrator().name(), step, &stable)
    }

    /// Runs to the end.
    pub fn run(mut self, request: Request, record: &mut Record<'_, P>) -> Outcome {
        let columns = shown_columns(self.scene, &self.engine);
        let (last, rest) = self.course.last();
        let steps = last.saturating_sub(self.engine.steps()) + u64::from(rest > 0.0);
        let mut drive = Drive::new(self.engine.report().laws.len(), steps, "running", &request, self.scene.is_strict());
        let mut outcome = Outcome { precision: P::NAME, ..Outcome::default() };
        let way = way::Way { scene: self.scene, course: self.course, targets: &self.targets };
        let mut show = |engine: &Engine<P>, whole: bool| {
            let shown = whole.then(|| snapshot(engine, &columns));
            record(engine, shown.as_deref())
        };
        let went = way.go(&mut self.engine, &mut drive, &mut outcome, &request, &mut show);
        outcome.faults = went.err().unwrap_or_default();
        let (wall, seconds) = drive.finish();
        outcome.wall_seconds = wall;
        if let (Some(compared), true) = (&mut outcome.compared, outcome.faults.is_empty() && !self.resumed) {
            match way.distances_without::<P>(&request) {
                Ok(distances) => {
                    for (row, distance) in compared.iter_mut().zip(distances) {
                        row.without = Some(distance);
                    }
                }
                Err(faults) => outcome.faults = faults,
            }
            outcome.interrupted = request.stop.load(Ordering::Relaxed);
        }
        outcome.compared.iter_mut().for_each(|rows| rows.sort_by_key(|row| row.row));
        let engine = &self.engine;
        outcome.time = engine.time();
        let [rejected, accepted] = engine.tried_steps();
        outcome.steps = if accepted > 0 { accepted } else { engine.steps() };
        outcome.rejected = rejected;
        outcome.evaluations = engine.evaluations();
        outcome.integrator = engine.integrator().name().to_owned();
        outcome.domains = snapshot(engine, &columns);
        outcome.laws = outcome::law_outcomes(engine, &seconds);
        outcome.unused.clone_from(&engine.report().unused);
        outcome.skipped = self.targets.skipped;
        outcome
    }
}
