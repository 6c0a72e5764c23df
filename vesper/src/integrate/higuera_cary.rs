//! Higuera and Cary: Boris' method, with the momenta turned at the velocity of the mean momentum.
//!
//! Order 2, one evaluation per step; laws that make a velocity of a momentum are asked a few times more, until the mean
//! momentum stays. It is Boris' method where the velocity is proportional to the momentum. For relativistic charges: the
//! drift across electric and magnetic fields is right at any speed, where that of Boris is not, and it preserves volume,
//! which Vay's method does not. Refuses what `boris` refuses.
//!
//! Source: Higuera, Cary, Phys. Plasmas 24 (2017) 052104, eq. 11 to 23; there the mean is found in closed form from
//! gamma, here by iteration from any law of the velocity. Review: Ripperda et al., Astrophys. J. Suppl. 235 (2018) 21.

use super::boris::{rotating, step};
use super::{Integrator, Rotation, System};
use crate::error::Fault;

/// Higuera and Cary: order 2, one evaluation per step, rotates momenta.
#[derive(Clone, Copy, Debug, Default)]
pub struct HigueraCary {
    checked: bool,
}

rotating!(HigueraCary, "higuera_cary", 2, |system: &mut dyn System, length| step(
    system,
    length,
    Rotation::TangentOfMean
));
