//! Symplectic splitting of order 6, ten or eleven evaluations per step.
//!
//! Time-reversible and symplectic: the energy error stays bounded, without a trend. For long runs of smooth problems.
//! Refuses forces that depend on velocities. Not for close encounters.
//!
//! Where x' is the momentum itself (Motion), a Nystroem table of eleven evaluations is used.
//!
//! Source: Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313, tables 2 (S10) and 3 (SRKN11b).

use super::splitting::{Splitting, symplectic};
use super::{Integrator, System};
use crate::error::Fault;
use crate::law::Part;

/// Symplectic of order 6, ten or eleven evaluations per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Symplectic6 {
    /// Whether the rates of the last step's end still hold.
    remembers: bool,
    /// Whether the rate of every coordinate is its momentum, where that is known.
    follows: Option<bool>,
}

symplectic!(Symplectic6, "symplectic_6", 6, [6.14, 9.07], GENERAL, SECOND_ORDER);

/// For any kinetic energy: S10 of Blanes and Moan, drift first.
const GENERAL: Splitting = Splitting { first: Part::Coordinates, half: GENERAL_FACTORS };
const GENERAL_FACTORS: &[f64] = &[
    0.050_262_764_400_392_2,
    0.148_816_447_901_042,
    0.413_514_300_428_344,
    -0.132_385_865_767_784,
    0.045_079_889_794_397_7,
    0.067_307_604_692_185,
    -0.188_054_853_819_569,
    0.432_666_402_578_175,
    0.541_960_678_450_78,
    -0.016_404_589_403_618,
    -0.725_525_558_508_689_8,
];

/// For x'' = f(x): their SRKN11b, kick first, whose last kick is the first one of the next step.
const SECOND_ORDER: Splitting = Splitting { first: Part::Momenta, half: SECOND_ORDER_FACTORS };
const SECOND_ORDER_FACTORS: &[f64] = &[
    0.041_464_998_518_262_4,
    0.123_229_775_946_271,
    0.198_128_671_918_067,
    0.290_553_797_799_558,
    -0.040_006_192_104_153_3,
    -0.127_049_212_625_417,
    0.075_253_984_301_580_7,
    -0.246_331_761_062_075,
    -0.011_511_387_420_687_9,
    0.357_208_872_795_928,
    0.236_669_924_786_931_1,
    0.204_777_054_291_47,
];
