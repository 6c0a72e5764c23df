//! The classical Runge-Kutta method.
//!
//! Order 4. Four evaluations per step. Works with every kind of state and force. Not symplectic: over many periods it
//! loses energy, about (h omega)^6 / 72 of an oscillator's per step, so not for very long runs of few steps per period.
//!
//! Source: Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 2nd ed., II.1, table 1.2.

use super::{Integrator, Register, StableLimits, System};
use crate::error::Fault;
use crate::law::Part;

/// The classical Runge-Kutta method: order 4, four evaluations per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct RungeKutta4;

const START: Register = Register::Work(0);
const SUM: Register = Register::Work(1);

impl Integrator for RungeKutta4 {
    fn name(&self) -> &'static str {
        "runge_kutta_4"
    }

    fn order(&self) -> u32 {
        4
    }

    fn steps_alike(&self) -> bool {
        true
    }

    // |1 + z + z^2 / 2 + z^3 / 6 + z^4 / 24| <= 1
    fn stable_limits(&self, _second_order: bool) -> Option<StableLimits> {
        Some(StableLimits { oscillation: 2.828, decay: 2.785, kicks: false })
    }

    fn work_vectors(&self) -> usize {
        2
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        let time = system.time();
        system.copy(START, Register::State, Part::All);
        system.zero(SUM, Part::All);
        // (weight of the stage, how far the next stage goes along its rates)
        for (weight, next) in [(1.0, Some(0.5)), (2.0, Some(0.5)), (2.0, Some(1.0)), (1.0, None)] {
            system.evaluate(Part::All);
            system.add(SUM, &[(weight, Register::Rates)], Part::All);
            if let Some(fraction) = next {
                system.combine(Register::State, &[(fraction * step, Register::Rates), (1.0, START)], Part::All);
                system.set_time(time + fraction * step);
            }
        }
        system.copy(Register::State, START, Part::All);
        system.add(Register::State, &[(step / 6.0, SUM)], Part::All);
        system.set_time(time + step);
        Ok(())
    }
}
