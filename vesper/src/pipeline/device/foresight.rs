//! What a step will move between host and device, before it is taken.
//!
//! In: a pipeline, an integrator. Out: the columns that move in each of a few steps, in which direction, and for whom. The integrator takes
//! its steps on a system without numbers, which keeps the same book of what is where as a run does. Never: a number, or a move.

use super::ledger::{Ledger, Side, Touch};
use super::residency::{Residency, What, lock};
use crate::backend::gpu::Access;
use crate::error::Fault;
use crate::integrate::{Combination, Integrator, Linearised, Pace, Quantity, Register, Structure, System};
use crate::law::Part;
use crate::pipeline::bind::Pass;
use crate::pipeline::run::{is_due, next_key};
use crate::pipeline::{Key, Pipeline};
use crate::real::Scalar;
use core::fmt::Write;

/// Who needs a column where it is not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Reader {
    Law(usize),
    /// The integrator, or a pass without a law.
    Step,
    /// Who observes it.
    Client,
}

/// A column that moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Move {
    to: Side,
    what: What,
    bytes: usize,
    reader: Reader,
}

/// What moves in the first frames, each of one step after which the client looks at what it observes.
#[derive(Debug, Default)]
pub(crate) struct Foresight {
    /// When the engine is built, and then in each frame.
    frames: Vec<Vec<Move>>,
}

/// Frames after which nothing is new.
const FRAMES: u32 = 3;

impl<P: Scalar> Pipeline<P> {
    /// Foresees what frames will move, for integrators whose steps do not depend on numbers.
    pub(crate) fn foresee(&self, integrator: &mut dyn Integrator) -> Option<Foresight> {
        self.foresee_frames(integrator, FRAMES)
    }

    pub(crate) fn foresee_frames(&self, integrator: &mut dyn Integrator, frames: u32) -> Option<Foresight> {
        let shared = self.residency.as_ref()?;
        let mut passes = self.programs.iter().flat_map(|program| &program.passes);
        let looks = !integrator.steps_alike() || self.switches.any();
        if looks || !passes.any(|pass| matches!(pass.pass, Pass::Device(_))) {
            return None;
        }
        let mut residency = lock(shared);
        let ledger = residency.ledger.clone();
        let mut rehearsal = Rehearsal {
            pipeline: self,
            residency: &mut residency,
            ledger,
            moves: Vec::new(),
            filled: self.vectors.filled.clone(),
            time: 0.0,
            step: 0,
            pace: Pace::Held,
        };
        rehearsal.look();
        let mut foresight = Foresight { frames: vec![core::mem::take(&mut rehearsal.moves)] };
        let memory = integrator.memory();
        let mut done = Ok(());
        for _ in 0..frames {
            done = done.and_then(|()| rehearsal.frame(integrator));
            foresight.frames.push(core::mem::take(&mut rehearsal.moves));
        }
        integrator.set_memory(&memory);
        integrator.restart();
        done.ok().map(|()| foresight)
    }
}

/// A system without numbers.
struct Rehearsal<'a, P: Scalar> {
    pipeline: &'a Pipeline<P>,
    residency: &'a mut Residency<P>,
    ledger: Ledger,
    moves: Vec<Move>,
    filled: Vec<bool>,
    time: f64,
    step: u64,
    pace: Pace,
}

impl<P: Scalar> Rehearsal<'_, P> {
    /// As `Engine::take` does with one step.
    fn frame(&mut self, integrator: &mut dyn Integrator) -> Result<(), Fault> {
        integrator.step(self, 1.0)?;
        self.step += 1;
        if self.pipeline.amends {
            integrator.finish(self)?;
            self.run(Key::Amend);
            integrator.restart();
        }
        integrator.finish(self)?;
        self.look();
        let lent = self.residency.lent();
        self.touch(Side::Host, &lent, Reader::Client);
        Ok(())
    }

    /// The client looks at what it observes.
    fn look(&mut self) {
        if self.pipeline.observes {
            self.run(Key::Observe);
        }
        let observed = self.pipeline.observed.iter().filter_map(|id| self.residency.find(What::Quantity(*id)));
        let touches: Vec<Touch> = observed.map(|column| Touch { column, access: Access::Read }).collect();
        self.touch(Side::Host, &touches, Reader::Client);
    }

    fn touch(&mut self, to: Side, touches: &[Touch], reader: Reader) {
        for touch in touches {
            while self.ledger.len() <= touch.column {
                self.ledger.add();
            }
            if self.ledger.is_missing(to, *touch) && self.residency.bytes(touch.column) > 0 {
                let (what, bytes) = (self.residency.what(touch.column), self.residency.bytes(touch.column));
                self.moves.push(Move { to, what, bytes, reader });
            }
            self.ledger.touch(to, *touch);
        }
    }

    fn run(&mut self, key: Key) {
        let pipeline = self.pipeline;
        for bound in &pipeline.programs[key.index()].passes {
            if !is_due(bound, &mut self.filled, (self.pace, self.step)) {
                continue;
            }
            let reader = bound.laws.first().map_or(Reader::Step, |law| Reader::Law(*law));
            match &bound.pass {
                Pass::Device(pass) => {
                    self.touch(Side::Host, &pass.constants, reader);
                    self.touch(Side::Device, &pass.touches, reader);
                }
                _ => self.touch(Side::Host, &bound.touches, reader),
            }
        }
    }

    /// Everything is looked at on the host, or changed there.
    fn come_home(&mut self, changes: bool) {
        let access = if changes { Access::Update } else { Access::Read };
        let all: Vec<Touch> = (0..self.residency.ledger.len()).map(|column| Touch { column, access }).collect();
        self.touch(Side::Host, &all, Reader::Step);
    }
}

impl<P: Scalar> System for Rehearsal<'_, P> {
    fn time(&self) -> f64 {
        self.time
    }
    fn set_time(&mut self, time: f64) {
        self.time = time;
    }
    fn evaluate(&mut self, part: Part) {
        self.run(Key::Evaluate(part));
    }
    fn advance(&mut self, stages: &[(Part, f64)]) {
        if self.pipeline.vectors.compensated {
            for (part, step) in stages {
                self.evaluate(*part);
                self.axpy(Register::State, *step, Register::Rates, *part);
            }
            return;
        }
        let mut rest = stages;
        while let Some((key, _, after)) = next_key(rest) {
            self.run(key);
            rest = after;
        }
    }
    fn linear(&mut self, combination: Combination<'_>) {
        let share = self.residency.share(&self.pipeline.vectors, &combination);
        share.touches().for_each(|touches| self.touch(Side::Device, touches, Reader::Step));
        self.touch(Side::Host, &share.host, Reader::Step);
    }
    fn magnitudes(&mut self, _of: &[Register], _part: Part, _each: &mut dyn FnMut(usize, &[f64])) {
        self.come_home(false);
    }
    fn structure(&self) -> &Structure {
        &self.pipeline.structure
    }
    fn find(&self, _name: &str) -> Option<Quantity> {
        None
    }
    fn read(&self, _quantity: Quantity, _from: Register, to: &mut [f64]) {
        to.fill(0.0);
    }
    fn write(&mut self, _quantity: Quantity, _from: &[f64]) {
        self.come_home(true);
    }
    fn momenta_depend_on_momenta(&self) -> bool {
        self.pipeline.structure.momenta_depend_on_momenta.is_some()
    }
    fn coordinates_depend_on_others(&self) -> bool {
        self.pipeline.structure.coordinates_depend_on.is_some()
    }
    fn coordinates_follow_momenta(&mut self) -> bool {
        if !self.pipeline.structure.second_order || self.pipeline.vectors.momentum_behind.is_none() {
            return false;
        }
        self.run(Key::Evaluate(Part::Coordinates));
        self.come_home(false);
        true
    }
    fn evaluate_at_pace(&mut self, pace: Pace) {
        let before = core::mem::replace(&mut self.pace, pace);
        self.evaluate(Part::Momenta);
        self.pace = before;
    }
    fn paces(&self) -> Vec<u32> {
        self.pipeline.paces()
    }
    fn steps_done(&self) -> u64 {
        self.step
    }
    fn epsilon(&self) -> f64 {
        P::EPSILON
    }
    fn count_step(&mut self, _accepted: bool) {}
}

impl<P: Scalar> Linearised for Rehearsal<'_, P> {
    fn derivative(&mut self, _to: Register, _along: Register) {
        self.come_home(true);
    }
    fn dot(&self, _a: Register, _b: Register, _part: Part, _weights: &[f64]) -> f64 {
        0.0
    }
    fn scatter(&mut self, _to: Register, _scales: &[f64]) {
        self.come_home(true);
    }
}

impl Foresight {
    /// How many frames there are, with the one before the first.
    #[cfg(test)]
    pub(crate) fn len(&self) -> usize {
        self.frames.len()
    }

    /// Columns that go to the device in a frame, their bytes, columns that come back, and theirs.
    #[cfg(test)]
    pub(crate) fn counts(&self, frame: usize) -> [u64; 4] {
        let of = |to| self.frames[frame].iter().filter(move |known| known.to == to);
        let bytes = |to| of(to).map(|known| known.bytes as u64).sum();
        let [up, down] = [Side::Device, Side::Host];
        [of(up).count() as u64, bytes(up), of(down).count() as u64, bytes(down)]
    }

    /// The first frame, and those that follow, for people.
    pub(crate) fn told(&self, what: impl Fn(What) -> String, law: impl Fn(usize) -> String) -> Vec<String> {
        let mut lines = vec!["moved in a frame of one step, if the client then looks at what it observes:".to_owned()];
        let frames = [("the first", self.frames.get(1)), ("each later one", self.frames.last())];
        for (frame, moves) in frames.into_iter().filter_map(|(frame, moves)| Some((frame, moves?))) {
            if moves.is_empty() {
                lines.push(format!("  {frame}: nothing"));
            }
            for (to, side) in [(Side::Device, "the graphics processor"), (Side::Host, "the host")] {
                let of: Vec<&Move> = moves.iter().filter(|known| known.to == to).collect();
                let bytes: usize = of.iter().map(|known| known.bytes).sum();
                let mut line = format!("  {frame}: {bytes} bytes to {side}");
                for (at, known) in of.iter().enumerate() {
                    let reader = match known.reader {
                        Reader::Law(number) => format!("for {}", law(number)),
                        Reader::Step => "for the integrator".to_owned(),
                        Reader::Client => "for the client".to_owned(),
                    };
                    // Writing to a string cannot fail.
                    let _ = write!(line, "{} {} {reader}", if at == 0 { ":" } else { "," }, what(known.what));
                }
                lines.extend((!of.is_empty()).then_some(line));
            }
        }
        lines
    }
}
