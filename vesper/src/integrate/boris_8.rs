//! Boris' splitting with exact angles, composed to order 8: seventeen evaluations per step.
//!
//! Each part is half a drift, half a kick, the turn by the exact angle, half a kick, half a drift: all of them exact
//! solutions of their parts, so that a gyration in a uniform field alone has no error but rounding at any step. The energy is
//! conserved to rounding in a magnetic field alone, and without a trend otherwise. For long runs and small errors, with a
//! compensated state. Refuses what `boris` refuses.
//!
//! Source: Kahan, Li, Math. Comp. 66 (1997) 1089, s17odr8b, for the composition; He et al., J. Comput. Phys. 281 (2015) 135,
//! for the parts.

use super::boris::{kick_and_turn, rotating};
use super::{Integrator, Part, Rotation, System, symplectic_8};
use crate::error::Fault;

/// Boris' splitting, composed: order 8, seventeen evaluations per step, rotates momenta.
#[derive(Clone, Copy, Debug, Default)]
pub struct Boris8 {
    checked: bool,
}

rotating!(Boris8, "boris_8", 8, composed);

fn composed(system: &mut dyn System, step: f64) {
    let start = system.time();
    let mut drifted = 0.0;
    let splitting = symplectic_8::GENERAL;
    for number in 0..splitting.len() {
        let factor = splitting.factor(number);
        if number.is_multiple_of(2) {
            system.advance(&[(Part::Coordinates, factor * step)]);
            drifted += factor;
            system.set_time(start + drifted * step);
        } else {
            kick_and_turn(system, factor * step, Rotation::Exact);
        }
    }
    system.set_time(start + step);
}
