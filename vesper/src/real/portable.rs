//! Lanes without any register named: numbers side by side, as many as fill 128 bits, for the compiler to put in registers.
//!
//! In: nothing. Out: the same two types as in `x86` and `neon`, for architectures without registers of their own here, and for tests
//! everywhere. Never: an estimate, or a product fused with a sum.

#![allow(unused_unsafe, reason = "numbers are always there")]

use super::registers::lanes;
use super::{Lanes, Mask, Real, Vec3};
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};
use core::ptr::{read_unaligned, write_unaligned};

/// The sum of all lanes, by halves.
#[inline(always)]
fn by_halves<P: Copy + Add<Output = P>, const N: usize>(mut lanes: [P; N]) -> P {
    let mut half = N / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] = lanes[lane] + lanes[lane + half];
        }
        half /= 2;
    }
    lanes[0]
}

/// One truth value as a bit.
trait Truth {
    fn bits(self) -> u32;
}

impl Truth for bool {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.into()
    }
}

lanes!(
    BaselineF32, BaselineF32Mask, f32, f32, f32, bool, 4 [0 1 2 3], 1,
    f32::from, read_unaligned, write_unaligned, f32::add, f32::sub, f32::mul, f32::div, f32::sqrt, Real::min, Real::max, by_halves,
    |a, b, m| neg -a, abs a.abs(), less a < b, less_or_equal a <= b, equal a == b, select if m { a } else { b },
    and a & b, or a | b, not !a
);
lanes!(
    BaselineF64, BaselineF64Mask, f64, f64, f64, bool, 2 [0 1], 1,
    f64::from, read_unaligned, write_unaligned, f64::add, f64::sub, f64::mul, f64::div, f64::sqrt, Real::min, Real::max, by_halves,
    |a, b, m| neg -a, abs a.abs(), less a < b, less_or_equal a <= b, equal a == b, select if m { a } else { b },
    and a & b, or a | b, not !a
);
