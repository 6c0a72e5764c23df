//! The implicit midpoint rule: `y1 = y0 + h f(t + h/2, (y0 + y1) / 2)`, solved to rounding.
//!
//! Order 2. Symplectic and symmetric for any laws, also where forces depend on velocities, and it keeps every invariant that is
//! quadratic: the energy of a linear oscillator at any step. Stable at any step, but not L-stable: what is faster than the step
//! neither grows nor fades, it turns its sign in every step; where it is to fade, take implicit Euler. An evaluation and some
//! derivatives of all laws for each correction of the solver, two to five per step: where leapfrog is stable it is cheaper.
//!
//! Laws are to be evaluated whenever it asks: one with `every` is refused, since the equation would hold for shares of another
//! step.
//!
//! Sources: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., II.1, eq. 1.7, IV.2 and VI.4; Hairer, Wanner,
//! Solving Ordinary Differential Equations II, 2nd ed., IV.3.

use super::{Integrator, Structure, System, implicit};
use crate::error::Fault;

/// The implicit midpoint rule: order 2, symplectic, stable at any step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ImplicitMidpoint {
    /// Whether the rate of every coordinate is its momentum, where that is known.
    follows: Option<bool>,
}

impl Integrator for ImplicitMidpoint {
    fn name(&self) -> &'static str {
        "implicit_midpoint"
    }

    fn order(&self) -> u32 {
        2
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
        implicit::step((self.name(), follows), system, step, (0.5, 2.0))
    }

    fn restart(&mut self) {
        self.follows = None;
    }
}
