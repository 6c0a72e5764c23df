//! What symplectic methods of higher order share: kicks and drifts by a table.

use super::{Register, System};
use crate::law::Part;

/// Kicks and drifts in turn, symmetric about the middle of the step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Splitting {
    /// What the first factor is of; the last one is of the same.
    pub(super) first: Part,
    /// The factors of the step up to the middle one, that included: the others follow backwards.
    pub(super) half: &'static [f64],
}

impl Splitting {
    /// The factor of the step for this part.
    pub(super) fn factor(&self, number: usize) -> f64 {
        self.half[number.min(self.len() - 1 - number)]
    }

    /// Parts of a step.
    pub(super) const fn len(&self) -> usize {
        2 * self.half.len() - 1
    }

    /// Takes one step. `remembers`: the rates of the momenta at its beginning are there; afterwards, whether those at its
    /// end are.
    pub(super) fn step(&self, system: &mut dyn System, step: f64, remembers: &mut bool) {
        let start = system.time();
        let mut drifted = 0.0;
        let mut number = 0;
        let kicks_first = self.first == Part::Momenta;
        if kicks_first {
            if !*remembers {
                system.evaluate(Part::Momenta);
            }
            system.add(Register::State, &[(self.factor(0) * step, Register::Rates)], Part::Momenta);
            number = 1;
        }
        while number < self.len() {
            let drift = self.factor(number) * step;
            // The rates of a last kick are those of the next step's first one, so they are kept.
            let last = kicks_first && number + 2 == self.len();
            drifted += self.factor(number);
            system.advance(&[(Part::Coordinates, drift)]);
            system.set_time(start + drifted * step);
            if last {
                system.evaluate(Part::Momenta);
                system.add(Register::State, &[(self.factor(number + 1) * step, Register::Rates)], Part::Momenta);
            } else if number + 1 < self.len() {
                system.advance(&[(Part::Momenta, self.factor(number + 1) * step)]);
            }
            number += 2;
        }
        system.set_time(start + step);
        *remembers = kicks_first;
    }
}

/// Makes an integrator of tables, for a type with `remembers` and `follows`: one for any kinetic energy, and one that
/// is better where the rate of every coordinate is its momentum. Behind the order, the longest step times the rate of an
/// oscillation up to which half the trace of the matrix of a step is within -1 and 1; but for a gap of 1 % about pi, in which
/// an oscillation grows by less than 3 % a step.
macro_rules! symplectic {
    ($integrator:ident, $name:literal, $order:literal, $stable:expr, $general:expr, $second_order:expr) => {
        impl Integrator for $integrator {
            fn name(&self) -> &'static str {
                $name
            }
            fn order(&self) -> u32 {
                $order
            }
            // Of an oscillation, which is all that such methods take.
            fn stable_limits(&self, second_order: bool) -> Option<crate::integrate::StableLimits> {
                let oscillation: f64 = $stable[usize::from(second_order)];
                Some(crate::integrate::StableLimits { oscillation, decay: oscillation, kicks: true })
            }
            fn accept(&self, structure: &crate::integrate::Structure) -> Result<(), Fault> {
                structure.separable($name).and_then(|()| structure.without_every($name))
            }
            fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
                let follows = *self.follows.get_or_insert_with(|| system.coordinates_follow_momenta());
                let splitting: Splitting = if follows { $second_order } else { $general };
                splitting.step(system, step, &mut self.remembers);
                Ok(())
            }
            fn restart(&mut self) {
                *self = Self::default();
            }
            fn memory(&self) -> Vec<f64> {
                if self.remembers { vec![f64::from(u8::from(self.follows == Some(true)))] } else { Vec::new() }
            }
            fn set_memory(&mut self, memory: &[f64]) {
                self.restart();
                if let [follows] = memory {
                    (self.remembers, self.follows) = (true, Some(*follows == 1.0));
                }
            }
        }
    };
}
pub(super) use symplectic;
