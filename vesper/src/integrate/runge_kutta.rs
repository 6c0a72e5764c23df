//! What explicit Runge-Kutta methods share: stages and errors from a table, and the state within a step.

use super::adaptive::Control;
use super::dense::{Ahead, Dense};
use super::embedded::{Progress, START, Scheme, slope, slopes};
use super::{Combination, Register, System, Terms, Tolerance};
use crate::law::Part;

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

impl<const ERRORS: usize> Embedded<ERRORS> {
    pub(super) const fn work_vectors(&self) -> usize {
        3 + self.stages.len() + ERRORS + self.further()
    }

    /// How many rates the dense output needs besides those of the stages.
    const fn further(&self) -> usize {
        self.dense.further.len() + if self.last_is_first { 0 } else { 1 }
    }

    /// Behind the rates of the stages, and of those that are only for the dense output.
    fn end_vector(&self) -> Register {
        slope(self.stages.len() + 1 + self.further())
    }

    fn error_vector(&self, number: usize) -> Register {
        slope(self.stages.len() + 2 + self.further() + number)
    }

    /// Leaves the start and the slopes by a row of the table in the state.
    fn go(system: &mut dyn System, weights: &[f64], step: f64) {
        let terms = slopes(weights, step).and(&[(1.0, START)]);
        sum(system, Register::State, terms, false);
    }

    /// Puts the state at the system's time, where that is within a step.
    pub(super) fn finish(&self, progress: &mut Progress, system: &mut dyn System) {
        let Some(ahead) = &mut progress.ahead else { return };
        let now = system.time();
        let share = (now - ahead.begin) / ahead.step;
        if share >= 1.0 {
            return system.copy(Register::State, self.end_vector(), Part::All);
        }
        let last = self.stages.len() + usize::from(!self.last_is_first);
        if !ahead.ready {
            self.take_further(system, *ahead, last);
            system.set_time(now);
            ahead.ready = true;
        }
        let weights = self.dense.weights(share, self.weights, last);
        Self::go(system, &weights[..self.stages.len() + 1 + self.further()], ahead.step);
    }

    /// Evaluates the stages that are only for the dense output.
    fn take_further(&self, system: &mut dyn System, ahead: Ahead, last: usize) {
        if !self.last_is_first {
            system.copy(Register::State, self.end_vector(), Part::All);
            system.set_time(ahead.end());
            system.evaluate_to(slope(last), Part::All);
        }
        for (number, (when, far)) in self.dense.further.iter().enumerate() {
            Self::go(system, far, ahead.step);
            system.set_time(ahead.begin + when * ahead.step);
            system.evaluate_to(slope(last + 1 + number), Part::All);
        }
    }
}

impl<const ERRORS: usize> Scheme for Embedded<ERRORS> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn control(&self) -> &Control {
        &self.control
    }

    fn last_slope(&self) -> Option<Register> {
        self.last_is_first.then(|| slope(self.stages.len()))
    }

    fn end(&self) -> Option<Register> {
        Some(self.end_vector())
    }

    fn try_step(&self, system: &mut dyn System, time: f64, step: f64) {
        for (number, (when, far)) in self.stages.iter().enumerate() {
            Self::go(system, far, step);
            system.set_time(time + when * step);
            system.evaluate_to(slope(number + 1), Part::All);
        }
        if !self.last_is_first {
            Self::go(system, self.weights, step);
        }
    }

    fn excess(&self, system: &mut dyn System, tolerance: &Tolerance, step: f64) -> f64 {
        let mut vectors = [START; ERRORS];
        for (number, weights) in self.errors.iter().enumerate() {
            vectors[number] = self.error_vector(number);
            sum(system, vectors[number], slopes(weights, step), false);
        }
        tolerance.excess(system, vectors, self.error, (START, slope(0), step))
    }

    fn take(&self, system: &mut dyn System, step: f64) {
        sum(system, Register::State, slopes(self.weights, step), true);
    }
}

fn sum(system: &mut dyn System, to: Register, terms: Terms<'_>, adds: bool) {
    system.linear(Combination { to, adds, part: Part::All, terms, momenta: Terms::NONE });
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
                self.progress.cover((&$method, &self.tolerance), system, step)
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
