//! The way of a run: from its first step to its end, with a stop wherever something is due.
//!
//! In: an engine, its course, the frames to record, the dates to compare at. Out: the engine at its end, or where it
//! broke. Never: a step of another length than the course says, except a last one that makes the run end where it should.
//!
//! A date that no step ends with is reached by a second engine, which takes one shorter step from a checkpoint of the
//! first. Interpolating would cost less, and mix its own error into the distances.

use vesper::prelude::*;
use vesper_laws::catalog::CatalogPrecision;

use super::compare::{Target, Targets};
use super::course::Course;
use super::drive::{Drive, contained};
use super::{Compared, Outcome, Request};
use crate::assemble;
use crate::fault::SceneFault;
use crate::scene::{LawRequest, Scene};

/// What is fixed on the way.
pub(super) struct Way<'a> {
    pub(super) scene: &'a Scene,
    pub(super) course: Course,
    pub(super) targets: &'a Targets,
}

/// Every k-th frame, one after the other.
struct Due {
    frame: u64,
    every: u64,
}

impl Due {
    /// The first such frame that ends after `step`; none where `every` is 0.
    fn after(step: u64, every: u64, course: &Course) -> Self {
        let frame = course.frame_after(step);
        Due { frame: if every == 0 { u64::MAX } else { frame.div_ceil(every).saturating_mul(every) }, every }
    }

    /// The step with which it ends.
    fn step(&self, course: &Course) -> u64 {
        if self.frame > course.frames() { u64::MAX } else { course.frame_end(self.frame) }
    }

    /// Whether it ends with `step`; if so, the next one is due.
    fn passes(&mut self, step: u64, course: &Course) -> bool {
        let passes = self.step(course) <= step;
        if passes {
            *self = Due::after(step, self.every, course);
        }
        passes
    }
}

/// Shows a moment: to be recorded, or only to be drawn.
type Show<'s, P, E> = dyn FnMut(&Engine<P>, bool) -> Result<(), E> + 's;

impl Way<'_> {
    fn broken(&self, faults: &Faults) -> Vec<SceneFault> {
        assemble::run_faults(self.scene, faults)
    }

    /// Looks at energy and momenta; again, without it, where a law fails that need not run.
    fn look<P: CatalogPrecision>(&self, engine: &mut Engine<P>, outcome: &mut Outcome) -> Result<(), Faults> {
        match outcome.drift.look(engine) {
            Err(faults) => contained(Err(faults), self.scene.is_strict()).and_then(|()| outcome.drift.look(engine)),
            done => done,
        }
    }

    /// Goes to the end, and shows the first moment, every so many frames, and the last moment.
    pub(super) fn go<P: CatalogPrecision>(
        &self,
        engine: &mut Engine<P>,
        drive: &mut Drive,
        outcome: &mut Outcome,
        request: &Request,
        show: &mut Show<'_, P, String>,
    ) -> Result<(), Vec<SceneFault>> {
        let mut recorded = None;
        let mut show = |engine: &Engine<P>, record: bool| {
            if record && recorded.replace(engine.steps()) == Some(engine.steps()) {
                return Ok(());
            }
            show(engine, record).map_err(|text| vec![self.scene.fault_of_file(text)])
        };
        if request.record_every > 0 {
            show(engine, true)?;
        }
        let went = self.go_on(engine, drive, outcome, request, &mut show);
        // The last moment is shown whichever way it ended.
        if request.record_every > 0 {
            show(engine, true)?;
        }
        went
    }

    fn go_on<P: CatalogPrecision>(
        &self,
        engine: &mut Engine<P>,
        drive: &mut Drive,
        outcome: &mut Outcome,
        request: &Request,
        show: &mut Show<'_, P, Vec<SceneFault>>,
    ) -> Result<(), Vec<SceneFault>> {
        let course = &self.course;
        let (last, rest) = course.last();
        let look_every = course.frames().div_ceil(moments(engine)).max(1);
        let mut to_record = Due::after(engine.steps(), request.record_every, course);
        let mut to_draw = Due::after(engine.steps(), request.draw_every, course);
        let mut to_look = Due::after(engine.steps(), look_every, course);
        let mut dates = self.dates(engine.time()).into_iter().peekable();
        let mut aside = Aside { scene: self.scene, off: Vec::new(), engine: None };
        outcome.compared = self.scene.compare.is_some().then(Vec::new);
        self.look(engine, outcome).map_err(|faults| self.broken(&faults))?;
        loop {
            while let Some((target, _, rest)) = dates.next_if(|(_, step, _)| *step <= engine.steps()) {
                let distance = aside.distance(engine, target, rest, &self.targets.domain)?;
                let Target { name, date, time, row, .. } = target.clone();
                outcome.compared.get_or_insert_default().push(Compared {
                    name,
                    date,
                    time,
                    row,
                    distance,
                    without: None,
                });
            }
            if engine.steps() >= last || drive.is_stopped() {
                break;
            }
            let date = dates.peek().map_or(last, |(_, step, _)| *step);
            let due = [&to_record, &to_draw, &to_look].map(|due| due.step(course));
            let next = due.into_iter().fold(last.min(date), u64::min);
            drive.to(engine, next, course.step).map_err(|faults| self.broken(&faults))?;
            let between = engine.steps() < last;
            if to_look.passes(engine.steps(), course) && between {
                self.look(engine, outcome).map_err(|faults| self.broken(&faults))?;
                // To go on from where the run fails further on. Who writes no files has no use for it.
                if request.record_every > 0 {
                    outcome.checkpoint = Some(engine.checkpoint().map_err(|faults| self.broken(&faults))?);
                }
            }
            let (record, draw) = (to_record.passes(engine.steps(), course), to_draw.passes(engine.steps(), course));
            if (record || draw) && between {
                show(engine, record)?;
            }
        }
        outcome.checkpoint = Some(engine.checkpoint().map_err(|faults| self.broken(&faults))?);
        outcome.interrupted = engine.steps() < last;
        if rest > 0.0 && !outcome.interrupted {
            // From where the engine says it is, so that its clock comes to the end itself.
            drive.to(engine, last + 1, course.end - engine.time()).map_err(|faults| self.broken(&faults))?;
            outcome.interrupted = engine.steps() == last;
            outcome.short_step = (!outcome.interrupted).then_some((rest, course.step));
        }
        self.look(engine, outcome).map_err(|faults| self.broken(&faults))
    }

    /// The targets from `begin` to the end, each with the last step before it and what is left to it, in s.
    fn dates(&self, begin: f64) -> Vec<(&Target, u64, f64)> {
        let slack = 1e-9 * self.course.step;
        let on_the_way = |target: &&Target| begin - slack <= target.time && target.time <= self.course.end + slack;
        let list = self.targets.list.iter().filter(on_the_way);
        list.map(|target| (target, self.course.steps_at(target.time)))
            .map(|(target, (step, rest))| (target, step, rest))
            .collect()
    }

    /// The distances of a second run, without the laws that `[compare]` leaves out; none where it leaves none out.
    pub(super) fn distances_without<P: CatalogPrecision>(
        &self,
        request: &Request,
    ) -> Result<Vec<f64>, Vec<SceneFault>> {
        let Some(compare) = &self.scene.compare else { return Ok(Vec::new()) };
        let left_out = |law: &&LawRequest| {
            compare.without.iter().any(|name| name.value == law.called() || name.value == law.name.value)
        };
        let off: Vec<String> = self.scene.laws.iter().filter(left_out).map(|law| law.called().to_owned()).collect();
        if off.is_empty() {
            return Ok(Vec::new());
        }
        let mut engine = switched_off::<P>(self.scene, &off)?;
        let dates = self.dates(engine.time());
        let last = dates.last().map_or(0, |(_, step, _)| *step);
        let mut drive = Drive::new(
            self.scene.laws.len(),
            last,
            &format!("without {}", off.join(", ")),
            request,
            self.scene.is_strict(),
        );
        let mut aside = Aside { scene: self.scene, off, engine: None };
        let mut distances = Vec::new();
        for (target, step, rest) in dates {
            drive.to(&mut engine, step, self.course.step).map_err(|faults| self.broken(&faults))?;
            if engine.steps() < step {
                break;
            }
            distances.push(aside.distance(&engine, target, rest, &self.targets.domain)?);
        }
        drive.finish();
        Ok(distances)
    }
}

fn switched_off<P: CatalogPrecision>(scene: &Scene, off: &[String]) -> Result<Engine<P>, Vec<SceneFault>> {
    let mut engine = assemble::engine::<P>(scene)?;
    for law in off {
        engine.enable(law, false).map_err(|fault| assemble::run_faults(scene, &fault.into()))?;
    }
    Ok(engine)
}

/// A second engine for dates that no step ends with.
struct Aside<'s, P: CatalogPrecision> {
    scene: &'s Scene,
    off: Vec<String>,
    engine: Option<Engine<P>>,
}

impl<P: CatalogPrecision> Aside<'_, P> {
    /// The distance of `main` from `target`, `rest` s later.
    fn distance(&mut self, main: &Engine<P>, target: &Target, rest: f64, domain: &str) -> Result<f64, Vec<SceneFault>> {
        if rest == 0.0 {
            return Ok(target.distance(main.state(), domain));
        }
        let mut engine = match self.engine.take() {
            Some(engine) => engine,
            None => switched_off(self.scene, &self.off)?,
        };
        let broken = |faults: Faults| assemble::run_faults(self.scene, &faults);
        let saved = main.checkpoint().map_err(broken)?;
        engine.restore(&saved).map_err(broken)?;
        engine.steps_of(1, target.time - main.time()).map_err(broken)?;
        let distance = target.distance(engine.state(), domain);
        self.engine = Some(engine);
        Ok(distance)
    }
}

/// How many moments energy and momenta are looked at: fewer where a look visits many pairs.
fn moments<P: Precision>(engine: &Engine<P>) -> u64 {
    let rows = |law: &vesper::registry::LawReport| match law.status {
        Status::Active { rows } => rows as u64,
        Status::Dormant(_) | Status::Pruned { .. } | Status::Off | Status::Failed { .. } => 0,
    };
    let most = engine.report().laws.iter().map(rows).max().unwrap_or(0).max(1);
    (30_000_000 / most.saturating_mul(most)).clamp(8, 256)
}
