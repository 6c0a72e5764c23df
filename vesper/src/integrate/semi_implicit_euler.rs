//! Semi-implicit (symplectic) Euler: v += h a(x, v), then x += h v with the new v.
//!
//! Order 1. One evaluation per step. Symplectic where forces do not depend on velocities: the energy of an oscillator
//! stays bounded for h omega < 2. The games' method; where accuracy matters take leapfrog, which costs the same.
//!
//! Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., I.1.2, eq. 1.9.

use super::{Integrator, StableLimits, System};
use crate::error::Fault;
use crate::law::Part;

/// Semi-implicit Euler: order 1, one evaluation per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct SemiImplicitEuler;

impl Integrator for SemiImplicitEuler {
    fn name(&self) -> &'static str {
        "semi_implicit_euler"
    }

    fn order(&self) -> u32 {
        1
    }

    fn steps_alike(&self) -> bool {
        true
    }

    fn stable_limits(&self, _second_order: bool) -> Option<StableLimits> {
        Some(StableLimits { oscillation: 2.0, decay: 2.0, kicks: true })
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        system.advance(&[(Part::Momenta, step), (Part::Coordinates, step)]);
        system.set_time(system.time() + step);
        Ok(())
    }
}
