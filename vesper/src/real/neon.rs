//! Lanes of NEON registers, 128 bits each, which every processor of aarch64 has, and with them one operation for a product with a
//! sum, and an estimate of reciprocal roots.
//!
//! In: nothing. Out: [`BaselineF32`] and [`BaselineF64`], with [`Estimates`]. Never: a question to the processor, since there is
//! none that could say no; a result that differs from the scalar one, but for laws that allow estimates.

#![allow(unused_unsafe, reason = "NEON is always there")]

use super::fused::{Estimates, estimates};
use super::registers::lanes;
use super::{Lanes, Mask, Real, Vec3};
use core::arch::aarch64::*;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// What has no instruction of its own, has one that means another thing, or takes its numbers in another order.
macro_rules! operations {
    ($($(#[$about:meta])* $name:ident($($argument:ident: $type:ty),+) -> $result:ty { $body:expr })*) => {$(
        $(#[$about])*
        #[inline(always)]
        fn $name($($argument: $type),+) -> $result {
            // SAFETY: the instructions are in the baseline of aarch64, and have no other condition; none reads or writes memory.
            unsafe { $body }
        }
    )*};
}
operations! {
    // Not `vminq` and `vmaxq`, which give NaN where either number is one, and know of signs of 0.
    /// The smaller of two; `b` where either is NaN.
    min_f32(a: float32x4_t, b: float32x4_t) -> float32x4_t { vbslq_f32(vcltq_f32(a, b), a, b) }
    /// As above.
    min_f64(a: float64x2_t, b: float64x2_t) -> float64x2_t { vbslq_f64(vcltq_f64(a, b), a, b) }
    /// The larger of two; `b` where either is NaN.
    max_f32(a: float32x4_t, b: float32x4_t) -> float32x4_t { vbslq_f32(vcgtq_f32(a, b), a, b) }
    /// As above.
    max_f64(a: float64x2_t, b: float64x2_t) -> float64x2_t { vbslq_f64(vcgtq_f64(a, b), a, b) }

    // Not `vaddvq`, which begins with neighbours.
    /// The sum of all lanes, by halves.
    sum_f32(x: [float32x4_t; 1]) -> f32 { vpadds_f32(vadd_f32(vget_low_f32(x[0]), vget_high_f32(x[0]))) }
    /// The sum of both lanes.
    sum_f64(x: [float64x2_t; 1]) -> f64 { vpaddd_f64(x[0]) }

    /// `a * b + c`, rounded once.
    fused_add_f32(a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t { vfmaq_f32(c, a, b) }
    /// As above.
    fused_add_f64(a: float64x2_t, b: float64x2_t, c: float64x2_t) -> float64x2_t { vfmaq_f64(c, a, b) }
    /// `a * b - c`, rounded once.
    fused_sub_f32(a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t { vfmaq_f32(vnegq_f32(c), a, b) }
    /// As above.
    fused_sub_f64(a: float64x2_t, b: float64x2_t, c: float64x2_t) -> float64x2_t { vfmaq_f64(vnegq_f64(c), a, b) }
    /// `c - a * b`, rounded once.
    fused_from_f32(a: float32x4_t, b: float32x4_t, c: float32x4_t) -> float32x4_t { vfmsq_f32(c, a, b) }
    /// As above.
    fused_from_f64(a: float64x2_t, b: float64x2_t, c: float64x2_t) -> float64x2_t { vfmsq_f64(c, a, b) }

    // The instruction looks at 9 bits of a number and gives 8: by its definition it is within 2^-8.25 of the root. From there the
    // three terms that `fused` has leave 2^-27.7, too much in f64 (in f32 they would do, one operation less than a step and a term,
    // with two constants more). One step of Newton, y (3 - x y^2) / 2, leaves 1.5 times the square of the error, 2^-15.9: better
    // than the estimates of 14 bits of AVX-512, so that the same series end it. A second step would take three operations for the
    // two terms that it makes needless in f64, and for none in f32.
    // The square of the estimate is the factor of its own, not x y: the instruction of the step knows infinity times 0, so that
    // estimates of roots of 0 and of infinity stay infinity and 0.
    /// About `1 / sqrt(x)`.
    estimate_f32(x: float32x4_t) -> float32x4_t {{
        let y = vrsqrteq_f32(x);
        vmulq_f32(y, vrsqrtsq_f32(x, vmulq_f32(y, y)))
    }}
    /// As above.
    estimate_f64(x: float64x2_t) -> float64x2_t {{
        let y = vrsqrteq_f64(x);
        vmulq_f64(y, vrsqrtsq_f64(x, vmulq_f64(y, y)))
    }}

    /// Where `mask` does not hold.
    not_u64(mask: uint64x2_t) -> uint64x2_t { veorq_u64(mask, vdupq_n_u64(u64::MAX)) }
}

/// The truth values of one register, one bit for each lane.
trait Truth {
    fn bits(self) -> u32;
}
impl Truth for uint32x4_t {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: as for the operations above; the array has the four numbers that are read.
        unsafe { vaddvq_u32(vandq_u32(self, vld1q_u32([1, 2, 4, 8].as_ptr()))) }
    }
}
impl Truth for uint64x2_t {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: as for the operations above; the array has the two numbers that are read.
        unsafe { vaddvq_u64(vandq_u64(self, vld1q_u64([1, 2].as_ptr()))) as u32 }
    }
}

lanes!(
    BaselineF32, BaselineF32Mask, f32, f32, float32x4_t, uint32x4_t, 1 [0], 4,
    vdupq_n_f32, vld1q_f32, vst1q_f32, vaddq_f32, vsubq_f32, vmulq_f32, vdivq_f32, vsqrtq_f32, min_f32, max_f32, sum_f32,
    |a, b, m| neg vnegq_f32(a), abs vabsq_f32(a), less vcltq_f32(a, b), less_or_equal vcleq_f32(a, b), equal vceqq_f32(a, b),
    select vbslq_f32(m, a, b), and vandq_u32(a, b), or vorrq_u32(a, b), not vmvnq_u32(a)
);
lanes!(
    BaselineF64, BaselineF64Mask, f64, f64, float64x2_t, uint64x2_t, 1 [0], 2,
    vdupq_n_f64, vld1q_f64, vst1q_f64, vaddq_f64, vsubq_f64, vmulq_f64, vdivq_f64, vsqrtq_f64, min_f64, max_f64, sum_f64,
    |a, b, m| neg vnegq_f64(a), abs vabsq_f64(a), less vcltq_f64(a, b), less_or_equal vcleq_f64(a, b), equal vceqq_f64(a, b),
    select vbslq_f64(m, a, b), and vandq_u64(a, b), or vorrq_u64(a, b), not not_u64(a)
);

// After one term in f32 the series is within 1.9 2^-29.8 of its sum, after three in f64 within 2.5 2^-59.7: below half a rounding.
estimates!(BaselineF32, f32, 1, fused_add_f32, fused_sub_f32, fused_from_f32, |x| BaselineF32([estimate_f32(x.0[0])]));
estimates!(BaselineF64, f64, 3, fused_add_f64, fused_sub_f64, fused_from_f64, |x| BaselineF64([estimate_f64(x.0[0])]));

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest error of an estimate, in parts of the root. What the instruction gives depends on the 9 first bits of a number
    /// (the lowest bit of the exponent, 8 of the fraction), so that the largest errors are at the first and the last number of each.
    fn largest_error(estimate: impl Fn(f64) -> f64, last: f64) -> f64 {
        let ends = |first: f64, width: f64| [first, first + width * last];
        let numbers = (0..256).flat_map(|step| {
            let step = f64::from(step) / 256.0;
            ends(1.0 + step, 1.0 / 256.0).into_iter().chain(ends(2.0 + 2.0 * step, 2.0 / 256.0))
        });
        numbers.map(|number| (estimate(number) * number.sqrt() - 1.0).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn estimates_have_the_bits_that_the_series_begin_with() {
        let last = 1.0 - f64::from(f32::EPSILON) * 256.0;
        let f32 = largest_error(|x| BaselineF32::splat(x as f32).estimate().lane(0).into(), last);
        let f64 = largest_error(|x| BaselineF64::splat(x).estimate().lane(1), 1.0 - 256.0 * f64::EPSILON);
        println!("f32: 2^{:.2}, f64: 2^{:.2}", f32.log2(), f64.log2());
        for error in [f32, f64] {
            // Not much better either: then a step would be there for nothing.
            assert!((2f64.powf(-16.0)..2f64.powf(-15.9)).contains(&error), "{error:e}");
        }
    }
}
