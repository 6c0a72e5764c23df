//! The units that the far field is computed in.
//!
//! In: places, strengths and a softening in the units of a scene. Out: the powers of two that bring them to a size where no power of
//! a distance leaves the range of the numbers. Never: a rounding, as long as the results are no subnormal numbers.
//!
//! The seventh power of an inverse distance enters the local sums of the sixth order. In f32 it overflows at a distance of about 2^-16
//! and in places of 10^20 m the square of a distance overflows: so the whole scene is given an extent of 2^12, and the largest
//! strength is brought to 1. Powers of two are applied in several factors, since one alone may be out of range.

use super::order::Box3;
use crate::real::Scalar;

/// The power of two that the extent of the scene is brought to.
const EXTENT: i32 = 12;

/// A product of four powers of two.
#[derive(Clone, Copy, Debug)]
pub(super) struct Power<P>([P; 4]);

impl<P: Scalar> Power<P> {
    pub(super) fn of(exponent: i32) -> Self {
        let part = |number: i32| P::from_f64(2f64.powi((exponent + number).div_euclid(4)));
        Power([part(0), part(1), part(2), part(3)])
    }

    /// The number times the power.
    #[inline(always)]
    pub(super) fn times(self, number: P) -> P {
        number * self.0[0] * self.0[1] * self.0[2] * self.0[3]
    }
}

/// What a scene is multiplied with.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame<P> {
    pub(super) length: Power<P>,
    pub(super) strength: Power<P>,
    /// Of the square of the softening.
    pub(super) square: Power<P>,
    /// Back from the frame's field to the scene's.
    pub(super) field: Power<P>,
    /// Back from the frame's potential to the scene's.
    pub(super) potential: Power<P>,
    /// The box of all places, in the scene.
    scene: Box3<P>,
}

impl<P: Scalar> Frame<P> {
    /// The box of all places, in the frame.
    pub(super) fn around(&self) -> Box3<P> {
        let own = |place| self.length.times(place);
        Box3 { low: self.scene.low.map(own), high: self.scene.high.map(own) }
    }
}

/// The largest integer power of two that is no larger, about; 0 for what has none.
fn exponent(number: f64) -> i32 {
    if number > 0.0 && number.is_finite() { number.log2().floor() as i32 } else { 0 }
}

impl<P: Scalar> Frame<P> {
    /// The frame of a scene; none if one of its numbers is not finite.
    pub(super) fn new(places: [&[P]; 3], strength: &[P], softening_squared: P) -> Option<Self> {
        // Infinities and NaN times 0 are NaN, and stay it in a sum.
        let mut check = softening_squared * P::from_f64(0.0);
        let (mut extent, mut largest) = (0f64, 0f64);
        let mut scene = Box3::at([P::from_f64(0.0); 3]);
        for (k, axis) in places.into_iter().enumerate() {
            let Some(&first) = axis.first() else { continue };
            let (mut low, mut high) = (first, first);
            for &place in axis {
                check += place * P::from_f64(0.0);
                low = low.min(place);
                high = high.max(place);
            }
            (scene.low[k], scene.high[k]) = (low, high);
            // Half of each: the difference of two finite numbers may be infinite.
            extent = extent.max(high.to_f64() * 0.5 - low.to_f64() * 0.5);
            largest = largest.max(high.to_f64().abs()).max(low.to_f64().abs());
        }
        let mut strongest = P::from_f64(0.0);
        for &strength in strength {
            check += strength * P::from_f64(0.0);
            strongest = strongest.max(strength.abs());
        }
        if check.to_f64() != 0.0 {
            return None;
        }
        let size = extent.max(softening_squared.to_f64().sqrt() * 0.5);
        // The place itself, not only the extent, stays within range: a point far from the origin has no extent.
        let range = if P::EPSILON > 1e-10 { 100 } else { 900 };
        let length = (EXTENT - 1 - exponent(size)).min(range - exponent(largest));
        let source = -1 - exponent(strongest.to_f64());
        Some(Frame {
            length: Power::of(length),
            strength: Power::of(source),
            square: Power::of(2 * length),
            field: Power::of(2 * length - source),
            potential: Power::of(length - source),
            scene,
        })
    }
}
