//! One periodic direction, and coordinates in it that can be moved from box to box without rounding.
//!
//! In: a length, how far rows look, and coordinates wherever they have drifted to. Out: each coordinate in the box, on a
//! grid. Never: a list, a pair.
//!
//! A difference of coordinates must not depend on which of the two was brought back into the box, or the last digits of a sum
//! would change with the age of a list. So every coordinate is first rounded to a multiple of a unit that divides the
//! length, too, and is a power of two so small that coordinates of this precision, as large as the box and what looks over its
//! faces, have no finer digits anyway. All sums of these multiples are exact: `(x_j + m L) - (x_i + n L)` has the same bits
//! for all `m` and `n` with the same `m - n`.
//!
//! What is exact: rows no further than 2^25 boxes from the origin (2^10 in f32). Beyond that, and in double-double numbers, whose
//! sums round otherwise, coordinates are right to their own last digits, which may then depend on the box.

use crate::real::{Lanes, Scalar};

/// A direction in which everything comes again after a length.
#[derive(Clone, Copy, Debug)]
pub(super) struct Period<P> {
    /// The length, a multiple of the unit; the one that was asked for, where at most three tenths of it are looked over.
    pub(super) length: P,
    /// The length once more, as a sum: so many digits, and so few in the first part, that whole multiples are exact.
    high: P,
    low: P,
    /// The first number from which on all numbers of this precision are multiples of the unit.
    whole: P,
}

/// How much larger numbers may be than coordinates in the box with all that is seen from it: room for a sum in between.
const ROOM: f64 = 1.25;

impl<P: Scalar> Period<P> {
    /// Boxes from the origin where a coordinate has three digits left, in base two, to tell where in the box it is. A row
    /// further away has no place.
    const FARTHEST: f64 = 0.125 / P::EPSILON;

    /// For a length, and how far beyond its faces rows may be looked for. `None` where numbers of this precision cannot do it.
    pub(super) fn new(length: f64, beyond: f64) -> Option<Self> {
        let length = P::from_f64(length).to_f64();
        let largest = ROOM * (length / 2.0 + beyond);
        // The power of two above it, bit by bit: a logarithm could differ between machines.
        let power = 2.0 * f64::from_bits(largest.to_bits() & (0x7ff << 52));
        let unit = power * P::EPSILON / 2.0;
        if !(unit > f64::MIN_POSITIVE && P::from_f64(power * 4.0).is_finite() && P::from_f64(unit).to_f64() == unit) {
            return None;
        }
        let rounded = (length / unit).round() * unit;
        // Half of the digits.
        let coarse = unit * if P::EPSILON > 1e-10 { 4096.0 } else { 67_108_864.0 };
        let high = (rounded / coarse).round() * coarse;
        let [length, high, low, whole] = [rounded, high, rounded - high, power / 2.0].map(P::from_f64);
        (rounded > 0.0).then_some(Period { length, high, low, whole })
    }

    /// How many lengths bring a coordinate into the box around the origin; `None` for one that has no place.
    #[inline(always)]
    pub(super) fn turns(&self, place: P) -> Option<P> {
        /// Added and taken away again, it rounds to whole numbers.
        const ROUND: f64 = 6_755_399_441_055_744.0;
        let turns = place.to_f64() / self.length.to_f64();
        // Also false for what is no number.
        (turns.abs() <= Self::FARTHEST).then(|| P::from_f64(0.0 - ((turns + ROUND) - ROUND)))
    }

    /// The multiple of the unit nearest to a coordinate, and so many lengths on.
    #[inline(always)]
    pub(super) fn moved<R: Lanes<P>>(&self, place: R, turns: R) -> R {
        let whole = R::splat(self.whole);
        let size = place.abs();
        let rounded = (size + whole) - whole;
        let rounded = R::select(place.less(R::lit(0.0)), -rounded, rounded);
        let rounded = R::select(size.less(whole), rounded, place);
        (rounded + turns * R::splat(self.high)) + turns * R::splat(self.low)
    }

    /// So many lengths, exact for as many as are looked over.
    #[inline(always)]
    pub(super) fn times(&self, count: i32) -> P {
        P::from_f64(f64::from(count)) * self.length
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moves a place by boxes, and looks whether differences notice.
    fn differences_are_exact<P: Scalar>(most: f64) {
        for (length, beyond) in [(33.591_918, 2.8), (1.0, 0.2999), (7.77e-3, 1e-3), (0.3, 2.0), (1e6, 3.0)] {
            let period = Period::<P>::new(length, beyond).unwrap();
            let error = (period.length.to_f64() - length).abs() / length;
            assert!(error <= P::EPSILON * (1.0 + 4.0 * beyond / length), "{length}: {error:e}");
            let (mut place, mut images) = (0.123_456_789, 0);
            for _ in 0..2000 {
                place = (place * 997.123_4 + 0.618_03_f64).fract();
                let spread = (place - 0.5) * most * length;
                let first = P::from_f64(spread);
                let turns = period.turns(first).unwrap();
                let inside = period.moved(first, turns);
                let half = 0.5 * length + 1e-5 * length + most * length * P::EPSILON;
                assert!(inside.to_f64().abs() <= half, "{spread} of {length}: {inside}");
                for boxes in -9..9 {
                    let other = period.moved(first, turns + P::from_f64(boxes.into()));
                    if other.to_f64().abs() <= length / 2.0 + beyond {
                        let step = period.times(boxes);
                        assert_eq!((other - inside).bits(), step.bits(), "{}: {spread} of {length}", P::NAME);
                        assert_eq!((inside + step).bits(), other.bits(), "{}: {spread} of {length}", P::NAME);
                        images += i32::from(boxes != 0);
                    }
                }
            }
            assert!(images > 3 || beyond < 1e-5 * length, "{images}");
        }
    }

    #[test]
    fn a_length_on_is_exactly_a_length_on() {
        differences_are_exact::<f64>(1.0);
        differences_are_exact::<f64>(6e7);
        differences_are_exact::<f32>(1.0);
        differences_are_exact::<f32>(2000.0);
    }

    #[test]
    fn what_has_no_place_gets_no_turns() {
        let period = Period::<f32>::new(2.0, 0.1).unwrap();
        for place in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
            assert_eq!(period.turns(place), None);
        }
        assert!(Period::<f32>::new(1e-44, 0.0).is_none() && Period::<f32>::new(3e38, 0.0).is_none());
        assert!(Period::<f64>::new(f64::NAN, 0.0).is_none());
    }
}
