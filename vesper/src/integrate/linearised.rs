//! What implicit integrators and estimates of stability ask of laws and data, besides sums: derivatives of the rates along a
//! direction, without a matrix; products of vectors; vectors that favour no direction.
//!
//! In: vectors by name. Out: vectors and numbers. Never: a change of the state, or of the rates.

use super::Register;
use crate::law::Part;

/// How the rates change near the state as it is.
pub trait Linearised {
    /// `to = J along`: the derivative of the rates of all states, at the state and time as they are, as the state moves along
    /// a direction; exact for laws whose bodies are generic over numbers. Switches and regions stay as they are held. For
    /// integrators that say [`super::Integrator::needs_derivatives`].
    ///
    /// # Panics
    /// The integrator does not say so, or one of the vectors is the state.
    fn derivative(&mut self, to: Register, along: Register);
    /// The sum over this part of the products of numbers, in f64, each times the weight of its state; a weight for each state,
    /// in the order of [`super::System::magnitudes`]. Neither may be the state.
    fn dot(&self, a: Register, b: Register, part: Part, weights: &[f64]) -> f64;
    /// Fills a vector with numbers that look random, always the same ones: of either sign, between half the scale of their state
    /// and the whole of it.
    fn scatter(&mut self, to: Register, scales: &[f64]);
}
