//! Explicit Euler: x += h v, v += h a, both from the beginning of the step.
//!
//! Order 1, one evaluation per step. The yardstick: the energy of an oscillator grows by (h omega)^2 of itself per step, for
//! any step. For relaxation without oscillation only; everywhere else semi-implicit Euler costs the same and stays.
//!
//! Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed., I.7, eq. 7.3.

use super::{Integrator, StableLimits, System};
use crate::error::Fault;
use crate::law::Part;

/// Explicit Euler: order 1, one evaluation per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct ExplicitEuler;

impl Integrator for ExplicitEuler {
    fn name(&self) -> &'static str {
        "explicit_euler"
    }

    fn order(&self) -> u32 {
        1
    }

    fn steps_alike(&self) -> bool {
        true
    }

    // |1 + z| <= 1
    fn stable_limits(&self, _second_order: bool) -> Option<StableLimits> {
        Some(StableLimits { oscillation: 0.0, decay: 2.0, kicks: false })
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        system.advance(&[(Part::All, step)]);
        system.set_time(system.time() + step);
        Ok(())
    }
}
