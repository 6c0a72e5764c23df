//! Leapfrog, drift-kick-drift (position Verlet): x += h/2 v, v += h a at the place between, x += h/2 v.
//!
//! Order 2, one evaluation per step, nothing remembered from step to step, so a step may change at no cost.
//! Time-reversible and symplectic, as `leapfrog`.
//! Refuses forces that depend on velocities.
//!
//! Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., I.1.4, eq. 1.17.

use super::{Integrator, StableLimits, Structure, System};
use crate::error::Fault;
use crate::law::Part;

/// Leapfrog, drift first: order 2, one evaluation per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct DriftKickDrift;

impl Integrator for DriftKickDrift {
    fn name(&self) -> &'static str {
        "drift_kick_drift"
    }

    fn order(&self) -> u32 {
        2
    }

    fn steps_alike(&self) -> bool {
        true
    }

    fn stable_limits(&self, _second_order: bool) -> Option<StableLimits> {
        Some(StableLimits { oscillation: 2.0, decay: 2.0, kicks: true })
    }

    fn accept(&self, structure: &Structure) -> Result<(), Fault> {
        structure.separable(self.name())
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        let (time, half) = (system.time(), 0.5 * step);
        system.advance(&[(Part::Coordinates, half)]);
        system.set_time(time + half);
        system.advance(&[(Part::Momenta, step), (Part::Coordinates, half)]);
        system.set_time(time + step);
        Ok(())
    }
}
