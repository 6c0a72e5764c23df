//! Leapfrog, kick-drift-kick (velocity Verlet): v += h/2 a, x += h v, v += h/2 a at the new place.
//!
//! Order 2. One evaluation per step, because the last one of a step is the first one of the next. Time-reversible and
//! symplectic: no drift of energy over any time for h omega < 2. Not for steep close encounters, whose step it cannot
//! adapt, and not where errors below 1e-8 are wanted: there a higher order is cheaper.
//!
//! Where a force depends on a velocity the plain second kick would cost an order. It is then taken in two: the velocity
//! at the end is predicted, and the force evaluated again with it: order 2, two evaluations per step, no longer exactly
//! symplectic. Where the rate of a coordinate depends on a coordinate or on the time, the drift is a step of the midpoint
//! rule for the same reason.
//!
//! Sources: Verlet, Phys. Rev. 159 (1967) 98; Swope et al., J. Chem. Phys. 76 (1982) 637, for the velocity form; the
//! predicted kick is the trapezoidal rule with one fixed-point iteration.

use super::{Integrator, Register, StableLimits, Structure, System};
use crate::error::Fault;
use crate::law::Part;

/// Leapfrog (velocity Verlet): order 2, one evaluation per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Leapfrog {
    /// Whether the rates of the last step's end still hold.
    remembers: bool,
}

const SAVED: Register = Register::Work(0);

impl Integrator for Leapfrog {
    fn name(&self) -> &'static str {
        "leapfrog"
    }

    fn order(&self) -> u32 {
        2
    }

    fn steps_alike(&self) -> bool {
        true
    }

    // Where the second kick is predicted, decay is that of 1 + z + z^2 / 2.
    fn stable_limits(&self, _second_order: bool) -> Option<StableLimits> {
        Some(StableLimits { oscillation: 2.0, decay: 2.0, kicks: true })
    }

    fn work_vectors(&self) -> usize {
        1
    }

    fn accept(&self, structure: &Structure) -> Result<(), Fault> {
        structure.without_others(self.name())
    }

    fn remark(&self, structure: &Structure) -> Option<String> {
        let kick = structure.momenta_depend_on_momenta.as_ref().map(|momentum| {
            format!(
                "a rate of a momentum depends on {momentum}: the second kick is predicted and evaluated again, two evaluations \
                 per step"
            )
        });
        let drift = structure.coordinates_depend_on.as_ref().map(|other| {
            format!("a rate of a coordinate depends on {other}: the drift is a midpoint step, no longer symplectic")
        });
        let remarks: Vec<String> = kick.into_iter().chain(drift).collect();
        (!remarks.is_empty()).then(|| remarks.join("; "))
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        let half = 0.5 * step;
        if !self.remembers {
            system.evaluate(Part::Momenta);
        }
        system.add(Register::State, &[(half, Register::Rates)], Part::Momenta);
        let start = system.time();
        if system.coordinates_depend_on_others() {
            system.copy(SAVED, Register::State, Part::Coordinates);
            system.evaluate(Part::Coordinates);
            system.combine(Register::State, &[(half, Register::Rates), (1.0, SAVED)], Part::Coordinates);
            system.set_time(start + half);
            system.evaluate(Part::Coordinates);
            system.copy(Register::State, SAVED, Part::Coordinates);
            system.add(Register::State, &[(step, Register::Rates)], Part::Coordinates);
        } else {
            system.advance(&[(Part::Coordinates, step)]);
        }
        system.set_time(start + step);
        system.evaluate(Part::Momenta);
        if system.momenta_depend_on_momenta() {
            system.copy(SAVED, Register::State, Part::Momenta);
            system.combine(Register::State, &[(half, Register::Rates), (1.0, SAVED)], Part::Momenta);
            system.evaluate(Part::Momenta);
            system.copy(Register::State, SAVED, Part::Momenta);
        }
        system.add(Register::State, &[(half, Register::Rates)], Part::Momenta);
        self.remembers = true;
        Ok(())
    }

    fn restart(&mut self) {
        self.remembers = false;
    }

    fn memory(&self) -> Vec<f64> {
        if self.remembers { vec![1.0] } else { Vec::new() }
    }

    fn set_memory(&mut self, memory: &[f64]) {
        self.remembers = !memory.is_empty();
    }
}
