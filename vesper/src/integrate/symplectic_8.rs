//! Symplectic composition of order 8, seventeen evaluations per step.
//!
//! Time-reversible and symplectic: the energy error stays bounded, without a trend. For long runs of smooth problems and
//! small errors, with a compensated state. Refuses forces that depend on velocities. Not for close encounters.
//!
//! Source: Kahan, Li, Math. Comp. 66 (1997) 1089, s17odr8b; Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd
//! ed. (2006), V.3.2, eq. 3.11. Each of the seventeen parts is a leapfrog step, drift first; neighbouring drifts are one.

use super::splitting::{Splitting, symplectic};
use super::{Integrator, System};
use crate::error::Fault;
use crate::law::Part;

/// Symplectic of order 8, seventeen evaluations per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Symplectic8 {
    /// Whether the rates of the last step's end still hold.
    remembers: bool,
    /// Whether the rate of every coordinate is its momentum, where that is known.
    follows: Option<bool>,
}

symplectic!(Symplectic8, "symplectic_8", 8, [5.63, 5.63], GENERAL, GENERAL);

/// Half of the first part drifts; then the kick of a part, and the drift of two halves, in turn.
pub(super) const GENERAL: Splitting = Splitting { first: Part::Coordinates, half: GENERAL_FACTORS };
const GENERAL_FACTORS: &[f64] = &[
    0.065_101_241_544_445_03,
    0.130_202_483_088_890_07,
    0.345_682_732_431_999_2,
    0.561_162_981_775_108_4,
    0.085_844_009_565_130_55,
    -0.389_474_962_644_847_27,
    -0.115_316_528_044_845_84,
    0.158_841_906_555_155_6,
    -0.118_530_993_789_040_99,
    -0.395_903_894_133_237_57,
    -0.105_682_126_577_460_94,
    0.184_539_640_978_315_7,
    0.221_457_014_332_318_87,
    0.258_374_387_686_322_04,
    0.276_693_055_647_816_16,
    0.295_011_723_609_310_3,
    -0.155_248_405_110_362_11,
    -0.605_508_533_830_034_6,
];
