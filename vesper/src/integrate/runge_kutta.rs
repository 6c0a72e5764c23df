//! What explicit Runge-Kutta methods share: stages from a table, and steps chosen by an embedded error.

use super::adaptive::{Control, Span, Steps};
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
const STAGES: usize = 16;

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
}

/// What such a method remembers from step to step.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Progress {
    pub(super) steps: Steps,
    /// Whether the rates of the state are in the first slope.
    holds_first: bool,
}

impl<const ERRORS: usize> Embedded<ERRORS> {
    pub(super) const fn work_vectors(&self) -> usize {
        2 + self.stages.len() + ERRORS
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
            let (step, last) = match closer.take() {
                Some(step) => span.part(step),
                None => span.cut(system, self.name, next)?,
            };
            system.copy(START, Register::State, Part::All);
            let time = system.time();
            self.try_step(system, time, step);
            let mut vectors = [START; ERRORS];
            for (number, weights) in self.errors.iter().enumerate() {
                vectors[number] = self.error_vector(number);
                let (terms, count) = along(weights, step, None);
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
            let (terms, count) = along(self.weights, step, None);
            system.add(Register::State, &terms[..count], Part::All);
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

    /// Leaves the rates of all stages in the slopes, and the state at the end of the step as a trial.
    fn try_step(&self, system: &mut dyn System, time: f64, step: f64) {
        for (number, (when, far)) in self.stages.iter().enumerate() {
            let (terms, count) = along(far, step, Some(START));
            system.combine(Register::State, &terms[..count], Part::All);
            system.set_time(time + when * step);
            system.evaluate(Part::All);
            system.copy(slope(number + 1), Register::Rates, Part::All);
        }
        if !self.last_is_first {
            let (terms, count) = along(self.weights, step, Some(START));
            system.combine(Register::State, &terms[..count], Part::All);
        }
    }
}

impl Progress {
    pub(super) fn restart(&mut self) {
        self.steps.restart();
        self.holds_first = false;
    }

    pub(super) fn memory(&self) -> Vec<f64> {
        let [next, last] = self.steps.memory();
        vec![next, last, f64::from(u8::from(self.holds_first))]
    }

    pub(super) fn set_memory(&mut self, memory: &[f64]) {
        self.restart();
        if let [steps @ .., holds] = memory {
            self.steps.set_memory(steps);
            self.holds_first = *holds == 1.0;
        }
    }
}

/// The terms of a sum over the slopes, and how many there are. What they are added to comes last, so that it is rounded
/// once.
fn along(weights: &[f64], step: f64, from: Option<Register>) -> ([Term; STAGES], usize) {
    let mut terms = [(0.0, START); STAGES];
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
