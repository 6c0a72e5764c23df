//! The explicit midpoint rule: the rates at a half step of explicit Euler, for the whole step.
//!
//! Order 2, two evaluations per step. Works with every kind of state and force. Not symplectic: the energy of an
//! oscillator grows by (h omega)^4 / 4 of itself per step. Where forces do not depend on velocities leapfrog is as
//! accurate at half the cost, and keeps the energy.
//!
//! Source: Runge, Math. Ann. 46 (1895) 167; Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed.,
//! II.1, eq. 1.4.

use super::{Integrator, Register, StableLimits, System};
use crate::error::Fault;
use crate::law::Part;

/// The explicit midpoint rule: order 2, two evaluations per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Midpoint;

const START: Register = Register::Work(0);

impl Integrator for Midpoint {
    fn name(&self) -> &'static str {
        "midpoint"
    }

    fn order(&self) -> u32 {
        2
    }

    fn steps_alike(&self) -> bool {
        true
    }

    // |1 + z + z^2 / 2| <= 1
    fn stable_limits(&self, _second_order: bool) -> Option<StableLimits> {
        Some(StableLimits { oscillation: 0.0, decay: 2.0, kicks: false })
    }

    fn work_vectors(&self) -> usize {
        1
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        let (time, half) = (system.time(), 0.5 * step);
        system.copy(START, Register::State, Part::All);
        system.evaluate(Part::All);
        system.combine(Register::State, &[(half, Register::Rates), (1.0, START)], Part::All);
        system.set_time(time + half);
        system.evaluate(Part::All);
        system.copy(Register::State, START, Part::All);
        system.add(Register::State, &[(step, Register::Rates)], Part::All);
        system.set_time(time + step);
        Ok(())
    }
}
