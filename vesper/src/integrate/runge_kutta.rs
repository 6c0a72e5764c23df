//! What explicit Runge-Kutta methods share: stages from a table, and steps chosen by an embedded error.
//!
//! A frame that is shorter than half of the step which the tolerance allows does not cut it: the step is taken whole, frames
//! within it get the dense output, and the next step goes on from its end. Longer frames end with a step.

use super::adaptive::{Control, Span, Steps};
use super::dense::{Ahead, Dense};
use super::jump::{Found, Jump};
use super::{Register, System, Term, Tolerance};
use crate::error::Fault;
use crate::law::Part;

/// The state at the beginning of the step.
const START: Register = Register::Work(0);

/// The rates of a stage.
const fn slope(stage: usize) -> Register {
    Register::Work(1 + stage)
}

/// The most stages of a table.
pub(super) const STAGES: usize = 16;
/// Steps that are so many times as long as the frame go beyond its end.
const BEYOND: f64 = 2.0;

/// An explicit method with an error estimate (Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, II.4).
pub(super) struct Embedded<const ERRORS: usize> {
    pub(super) name: &'static str,
    /// By stage, from the second on: when it is, in steps, and how far it goes along the rates of those before.
    pub(super) stages: &'static [(f64, &'static [f64])],
    /// The weights of the rates in the step.
    pub(super) weights: &'static [f64],
    /// The weights of the rates in the errors. One more than the stages: that of the rates at the end.
    pub(super) errors: [&'static [f64]; ERRORS],
    /// The one error made of them.
    pub(super) error: fn([f64; ERRORS]) -> f64,
    /// Whether the last stage is at the end of the step, so that it is the first one of the next.
    pub(super) last_is_first: bool,
    pub(super) control: Control,
    /// The state within a step.
    pub(super) dense: Dense,
}

/// What such a method remembers from step to step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Progress {
    pub(super) steps: Steps,
    /// Whether the rates of the state are in the first slope.
    holds_first: bool,
    /// The step that the frame is in, where it ends behind it.
    ahead: Option<Ahead>,
}

impl<const ERRORS: usize> Embedded<ERRORS> {
    pub(super) const fn work_vectors(&self) -> usize {
        3 + self.stages.len() + ERRORS + self.further()
    }

    /// How many rates the dense output needs besides those of the stages.
    const fn further(&self) -> usize {
        self.dense.further.len() + if self.last_is_first { 0 } else { 1 }
    }

    /// The rates of a stage, or of one that is only for the dense output.
    fn slope(&self, number: usize) -> Register {
        let stages = self.stages.len() + 1;
        if number < stages { slope(number) } else { slope(number + ERRORS) }
    }

    /// The state at the end of a step that goes beyond the frame.
    fn end(&self) -> Register {
        slope(self.stages.len() + 1 + ERRORS + self.further())
    }

    fn error_vector(&self, number: usize) -> Register {
        slope(self.stages.len() + 1 + number)
    }

    /// Covers a span by steps within the tolerance.
    pub(super) fn cover(
        &self,
        (progress, tolerance): (&mut Progress, &Tolerance),
        system: &mut dyn System,
        length: f64,
    ) -> Result<(), Fault> {
        let end = system.time() + length;
        let mut length = length;
        if let Some(ahead) = progress.ahead {
            if end <= ahead.end() {
                system.set_time(end);
                return Ok(());
            }
            length = end - ahead.end();
            self.go_on(progress, system, ahead);
        }
        let mut span = Span::new(system, length);
        let holds = system.hold();
        let (mut jump, mut closer) = (Jump::default(), None);
        while span.rest() > 0.0 {
            if !progress.holds_first {
                system.evaluate(Part::All);
                system.copy(slope(0), Register::Rates, Part::All);
                progress.holds_first = true;
            }
            let next = progress.steps.begin(system, self.control.order, tolerance.relative, length);
            let beyond = !holds && span.is_untouched() && next >= BEYOND * span.rest();
            let (step, last) = match closer.take() {
                Some(step) => span.part(step),
                None if beyond => (next, true),
                None => span.cut(system, self.name, next)?,
            };
            system.copy(START, Register::State, Part::All);
            let time = system.time();
            self.try_step(system, time, step);
            let mut vectors = [START; ERRORS];
            for (number, weights) in self.errors.iter().enumerate() {
                vectors[number] = self.error_vector(number);
                let (terms, count) = along(weights, step, None, slope);
                system.combine(vectors[number], &terms[..count], Part::All);
            }
            // Where a jump is near, a longer step was good enough already.
            let accepted = jump.is_near() || {
                let error = tolerance.excess(system, vectors, self.error, (START, slope(0), step));
                progress.steps.judge(&self.control, step, error)
            };
            let mut landed = false;
            if accepted && holds {
                system.set_time(time + step);
                match jump.look(system, step) {
                    Found::Nothing => {}
                    Found::Closer(length) => closer = Some(length),
                    Found::Here => landed = true,
                }
            }
            let accepted = accepted && closer.is_none();
            system.count_step(accepted);
            system.copy(Register::State, START, Part::All);
            if !accepted {
                system.set_time(time);
                continue;
            }
            let (terms, count) = along(self.weights, step, None, slope);
            system.add(Register::State, &terms[..count], Part::All);
            if beyond {
                system.copy(self.end(), Register::State, Part::All);
                progress.ahead = Some(Ahead { begin: time, step, ready: false });
                system.set_time(end);
                return Ok(());
            }
            progress.holds_first = self.last_is_first && !landed;
            if progress.holds_first {
                system.copy(slope(0), slope(self.stages.len()), Part::All);
            }
            // A step cut short to end the span says little about the next one.
            if last && step < 0.9 * next {
                progress.steps.next = progress.steps.next.map(|known| known.max(next));
            }
            system.set_time(span.add(step, last));
            if landed {
                system.turn();
                jump = Jump::default();
            } else if holds {
                system.hold();
            }
        }
        Ok(())
    }

    /// Puts the state at the end of the step that the last frame was in.
    fn go_on(&self, progress: &mut Progress, system: &mut dyn System, ahead: Ahead) {
        progress.ahead = None;
        system.copy(Register::State, self.end(), Part::All);
        system.set_time(ahead.end());
        progress.holds_first = self.last_is_first;
        if progress.holds_first {
            system.copy(slope(0), slope(self.stages.len()), Part::All);
        }
    }

    /// Puts the state at the system's time, where that is within a step.
    pub(super) fn finish(&self, progress: &mut Progress, system: &mut dyn System) {
        let Some(ahead) = &mut progress.ahead else { return };
        let now = system.time();
        let share = (now - ahead.begin) / ahead.step;
        if share >= 1.0 {
            return system.copy(Register::State, self.end(), Part::All);
        }
        let last = self.stages.len() + usize::from(!self.last_is_first);
        if !ahead.ready {
            self.take_further(system, *ahead, last);
            system.set_time(now);
            ahead.ready = true;
        }
        let weights = self.dense.weights(share, self.weights, last);
        let (terms, count) = along(&weights, ahead.step, Some(START), |stage| self.slope(stage));
        system.combine(Register::State, &terms[..count], Part::All);
    }

    /// Evaluates the stages that are only for the dense output.
    fn take_further(&self, system: &mut dyn System, ahead: Ahead, last: usize) {
        if !self.last_is_first {
            system.copy(Register::State, self.end(), Part::All);
            system.set_time(ahead.end());
            system.evaluate(Part::All);
            system.copy(self.slope(last), Register::Rates, Part::All);
        }
        for (number, (when, far)) in self.dense.further.iter().enumerate() {
            let (terms, count) = along(far, ahead.step, Some(START), |stage| self.slope(stage));
            system.combine(Register::State, &terms[..count], Part::All);
            system.set_time(ahead.begin + when * ahead.step);
            system.evaluate(Part::All);
            system.copy(self.slope(last + 1 + number), Register::Rates, Part::All);
        }
    }

    /// Leaves the rates of all stages in the slopes, and the state at the end of the step as a trial.
    fn try_step(&self, system: &mut dyn System, time: f64, step: f64) {
        for (number, (when, far)) in self.stages.iter().enumerate() {
            let (terms, count) = along(far, step, Some(START), slope);
            system.combine(Register::State, &terms[..count], Part::All);
            system.set_time(time + when * step);
            system.evaluate(Part::All);
            system.copy(slope(number + 1), Register::Rates, Part::All);
        }
        if !self.last_is_first {
            let (terms, count) = along(self.weights, step, Some(START), slope);
            system.combine(Register::State, &terms[..count], Part::All);
        }
    }
}

impl Progress {
    pub(super) fn restart(&mut self) {
        self.steps.restart();
        (self.holds_first, self.ahead) = (false, None);
    }

    pub(super) fn memory(&self) -> Vec<f64> {
        let [next, last] = self.steps.memory();
        let ahead = self.ahead.map(|ahead| [ahead.begin, ahead.step, f64::from(u8::from(ahead.ready))]);
        [&[next, last, f64::from(u8::from(self.holds_first))][..], ahead.as_slice().as_flattened()].concat()
    }

    pub(super) fn set_memory(&mut self, memory: &[f64]) {
        self.restart();
        if let [next, last, holds, ahead @ ..] = memory {
            self.steps.set_memory(&[*next, *last]);
            self.holds_first = *holds == 1.0;
            if let [begin, step, ready] = *ahead {
                self.ahead = Some(Ahead { begin, step, ready: ready == 1.0 });
            }
        }
    }
}

/// The terms of a sum over the slopes, and how many there are. What they are added to comes last, so that it is rounded
/// once.
fn along(
    weights: &[f64],
    step: f64,
    from: Option<Register>,
    slope: impl Fn(usize) -> Register,
) -> ([Term; STAGES + 1], usize) {
    let mut terms = [(0.0, START); STAGES + 1];
    let mut count = 0;
    let slopes = weights.iter().enumerate().filter(|(_, weight)| **weight != 0.0);
    for term in slopes.map(|(stage, weight)| (weight * step, slope(stage))).chain(from.map(|from| (1.0, from))) {
        terms[count] = term;
        count += 1;
    }
    (terms, count)
}

/// Makes an integrator of a table, for a type with `tolerance` and `progress`.
macro_rules! adaptive_runge_kutta {
    ($integrator:ident, $method:ident, $order:literal) => {
        impl Integrator for $integrator {
            fn name(&self) -> &'static str {
                $method.name
            }
            fn order(&self) -> u32 {
                $order
            }
            fn work_vectors(&self) -> usize {
                $method.work_vectors()
            }
            fn is_adaptive(&self) -> bool {
                true
            }
            fn set_first_step(&mut self, step: f64) {
                self.progress.steps.first = Some(step);
            }
            fn accept(&self, structure: &crate::integrate::Structure) -> Result<(), Fault> {
                structure.without_every($method.name)
            }
            fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
                $method.cover((&mut self.progress, &self.tolerance), system, step)
            }
            fn finish(&mut self, system: &mut dyn System) -> Result<(), Fault> {
                $method.finish(&mut self.progress, system);
                Ok(())
            }
            fn restart(&mut self) {
                self.progress.restart();
            }
            fn memory(&self) -> Vec<f64> {
                self.progress.memory()
            }
            fn set_memory(&mut self, memory: &[f64]) {
                self.progress.set_memory(memory);
            }
        }
    };
}
pub(super) use adaptive_runge_kutta;
