//! Boris: half a drift, half a kick, the turn of the momenta, half a kick, half a drift.
//!
//! Order 2, one evaluation per step. For charges in magnetic fields, in frames that turn, and for all forces across the
//! velocity that laws declare as a turn: in a magnetic field alone the energy is conserved to rounding for any time and
//! any step, the drift across uniform fields at right angles is exact where the velocity is proportional to the momentum,
//! and the phase of a gyration has an error of (omega h)^2 / 12 of itself. Time-reversible, preserves volume. Without
//! turning it is `drift_kick_drift`. Refuses forces that depend on velocities in other ways, such as drag. Not where the
//! phase matters and omega h is not small: there `boris_8` is cheaper. Relativistic charges that drift fast across both
//! fields are for `higuera_cary`.
//!
//! Sources: Boris, Proc. 4th Conf. Numerical Simulation of Plasmas (1970), 3; Birdsall, Langdon, Plasma Physics via Computer
//! Simulation (1985), 4-3 and 4-4; Qin et al., Phys. Plasmas 20 (2013) 084503, for the volume.

use super::{Integrator, Part, Register, Rotation, Structure, System};
use crate::error::Fault;

/// Boris: order 2, one evaluation per step, rotates momenta.
#[derive(Clone, Copy, Debug, Default)]
pub struct Boris {
    checked: bool,
}

/// A kick of the momenta by `step`, in s, with their turn in the middle of it.
pub(super) fn kick_and_turn(system: &mut dyn System, step: f64, rotation: Rotation) {
    system.evaluate_unturned();
    system.axpy(Register::State, 0.5 * step, Register::Rates, Part::Momenta);
    system.turn_momenta(step, rotation);
    system.axpy(Register::State, 0.5 * step, Register::Rates, Part::Momenta);
}

/// Whether laws turn as they say; looked at once.
pub(super) fn check(system: &mut dyn System, name: &str, checked: &mut bool) -> Result<(), Fault> {
    if core::mem::replace(checked, true) {
        return Ok(());
    }
    let Some(state) = system.turns_amiss() else { return Ok(()) };
    Err(Fault::Integrator {
        integrator: name.to_owned(),
        need: "rates that turn as their laws say".to_owned(),
        found: format!("the rate of {state} is not that of rest, and what is turned x turn"),
        mend: "look at the laws that add to a turn, or take runge_kutta_4".to_owned(),
    })
}

/// A step of the second order, symmetric in time.
pub(super) fn step(system: &mut dyn System, step: f64, rotation: Rotation) {
    let start = system.time();
    system.advance(&[(Part::Coordinates, 0.5 * step)]);
    system.set_time(start + 0.5 * step);
    kick_and_turn(system, step, rotation);
    system.advance(&[(Part::Coordinates, 0.5 * step)]);
    system.set_time(start + step);
}

/// What Boris' method and those made of it have in common.
macro_rules! rotating {
    ($integrator:ident, $name:literal, $order:literal, $step:expr) => {
        impl Integrator for $integrator {
            fn name(&self) -> &'static str {
                $name
            }
            fn order(&self) -> u32 {
                $order
            }
            fn rotates(&self) -> bool {
                true
            }
            fn accept(&self, structure: &crate::integrate::Structure) -> Result<(), Fault> {
                structure.separable_but_for_turning($name).and_then(|()| structure.without_every($name))
            }
            fn remark(&self, structure: &crate::integrate::Structure) -> Option<String> {
                crate::integrate::boris::remark(structure)
            }
            fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
                crate::integrate::boris::check(system, $name, &mut self.checked)?;
                $step(system, step);
                Ok(())
            }
        }
    };
}
pub(super) use rotating;

pub(super) fn remark(structure: &Structure) -> Option<String> {
    let turned = structure.turned.join(", ");
    if turned.is_empty() { None } else { Some(format!("{turned}: turned without a change of magnitude")) }
}

rotating!(Boris, "boris", 2, |system: &mut dyn System, length| step(system, length, Rotation::Tangent));
