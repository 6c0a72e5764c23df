//! Symplectic splitting of order 4, six evaluations per step.
//!
//! Time-reversible and symplectic: the energy error stays bounded, without a trend. Made for small errors, not for few
//! kicks. Refuses forces that depend on velocities. Not for close encounters, whose step it cannot adapt.
//!
//! Where x' is the momentum itself (Motion), a Nystroem table is used, whose error is smaller.
//!
//! Source: Blanes, Moan, J. Comput. Appl. Math. 142 (2002) 313, tables 2 (S6) and 3 (SRKN6b).

use super::splitting::{Splitting, symplectic};
use super::{Integrator, System};
use crate::error::Fault;
use crate::law::Part;

/// Symplectic of order 4, six evaluations per step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Symplectic4 {
    /// Whether the rates of the last step's end still hold.
    remembers: bool,
    /// Whether the rate of every coordinate is its momentum, where that is known.
    follows: Option<bool>,
}

symplectic!(Symplectic4, "symplectic_4", 4, [6.31, 5.02], GENERAL, SECOND_ORDER);

/// For any kinetic energy: S6 of Blanes and Moan, drift first.
const GENERAL: Splitting = Splitting { first: Part::Coordinates, half: GENERAL_FACTORS };
const GENERAL_FACTORS: &[f64] = &[
    0.079_203_696_431_195_7,
    0.209_515_106_613_362,
    0.353_172_906_049_774,
    -0.143_851_773_179_818,
    -0.042_065_080_357_719_5,
    0.434_336_666_566_456,
    0.219_376_955_753_499_6,
];

/// For x'' = f(x): their SRKN6b, kick first, whose last kick is the first one of the next step.
const SECOND_ORDER: Splitting = Splitting { first: Part::Momenta, half: SECOND_ORDER_FACTORS };
const SECOND_ORDER_FACTORS: &[f64] = &[
    0.082_984_406_417_405_2,
    0.245_298_957_184_271,
    0.396_309_801_498_368,
    0.604_872_665_711_08,
    -0.039_056_304_922_348_6,
    -0.350_171_622_895_351,
    0.119_524_194_013_150_8,
];
