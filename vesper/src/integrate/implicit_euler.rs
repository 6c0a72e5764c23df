//! Implicit Euler: `y1 = y0 + h f(t + h, y1)`, solved to rounding.
//!
//! Order 1. Stable at any step, and takes fast motion away instead of following it (L-stable): for stiff drag, stiff dampers and
//! contact, and for what comes to rest. Not where energy is to be kept: an oscillation loses (h omega)^2 of its energy per step.
//! An evaluation and some derivatives of all laws for each correction of the solver, two to five per step.
//!
//! Laws are to be evaluated whenever it asks: one with `every` is refused, since the equation would hold for shares of another
//! step.
//!
//! Source: Hairer, Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.3.

use super::{Integrator, Structure, System, implicit};
use crate::error::Fault;

/// Implicit Euler: order 1, stable at any step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ImplicitEuler {
    /// Whether the rate of every coordinate is its momentum, where that is known.
    follows: Option<bool>,
}

impl Integrator for ImplicitEuler {
    fn name(&self) -> &'static str {
        "implicit_euler"
    }

    fn order(&self) -> u32 {
        1
    }

    fn work_vectors(&self) -> usize {
        implicit::VECTORS
    }

    fn needs_derivatives(&self) -> bool {
        true
    }

    fn accept(&self, structure: &Structure) -> Result<(), Fault> {
        structure.without_every(self.name())
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        let follows = *self.follows.get_or_insert_with(|| system.coordinates_follow_momenta());
        implicit::step((self.name(), follows), system, step, (1.0, 1.0))
    }

    fn restart(&mut self) {
        self.follows = None;
    }
}
