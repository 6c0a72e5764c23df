//! Lanes of x86-64 registers. The types stay inside this crate: [`super::Scalar::with_lanes`] alone hands them out,
//! and only where the processor has the instructions, which is what makes their safe operations sound.
//!
//! Why not arrays here too: the compiler vectorises arrays of some widths and not of others (measured on a chain of
//! five row laws, AVX2: 16 f32 at the speed of a hand-written loop, 8 f32 and 8 f64 three to four times slower).

use super::{Lanes, Mask, Real, Vec3, WithLanes};
use core::arch::x86_64::*;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// Asks for the cache line of an address, which need not be valid.
#[inline(always)]
pub(crate) fn prefetch<P>(from: *const P) {
    // SAFETY: a prefetch reads nothing that the program sees, and never faults; every x86-64 processor has it.
    unsafe { _mm_prefetch::<_MM_HINT_T0>(from.cast()) };
}

/// Runs `task` compiled for AVX2.
///
/// # Safety
/// The processor has AVX2.
#[target_feature(enable = "avx2")]
pub(super) unsafe fn avx2<P, R: Lanes<P>, T: WithLanes<P>>(task: T) -> T::Output {
    task.with::<R>()
}

/// Runs `task` compiled for AVX-512.
///
/// # Safety
/// The processor has AVX-512 F and DQ.
#[target_feature(enable = "avx512f,avx512dq")]
pub(super) unsafe fn avx512<P, R: Lanes<P>, T: WithLanes<P>>(task: T) -> T::Output {
    task.with::<R>()
}

/// One lane type: `$count` registers of `$register`, each with `$per` numbers of `$scalar`.
///
/// Everything is written out for each register, and lanes are never touched in a closure: a closure cannot be told to be
/// inlined, and whatever is not is compiled without the instructions of its lanes, as calls of them, 50 times slower.
macro_rules! lanes {
    (
        $name:ident, $mask:ident, $scalar:ident, $register:ty, $truth:ty, $count:literal [$($i:literal)+], $per:literal,
        $set1:ident $load:ident $store:ident $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident $min:ident $max:ident,
        |$a:ident, $b:ident, $m:ident| neg $neg:expr, abs $abs:expr, less $less:expr, less_or_equal $less_eq:expr,
        equal $equal:expr, select $select:expr, and $and:expr, or $or:expr, not $not:expr
    ) => {
        #[doc = concat!("Lanes of `", stringify!($scalar), "` in `", stringify!($register), "`.")]
        #[derive(Clone, Copy, Debug)]
        pub struct $name([$register; $count]);

        #[doc = concat!("Truth values for [`", stringify!($name), "`].")]
        #[derive(Clone, Copy, Debug)]
        pub struct $mask([$truth; $count]);

        impl Mask for $mask {}

        impl $name {
            /// Lane by lane, through memory once: no register is taken apart.
            #[inline(always)]
            fn each(self, f: impl Fn($scalar, usize) -> $scalar) -> Self {
                let mut numbers = [0.0; $count * $per];
                // SAFETY: the array has a number for every lane.
                unsafe { self.store(numbers.as_mut_ptr()) };
                for (lane, number) in numbers.iter_mut().enumerate() {
                    *number = f(*number, lane);
                }
                // SAFETY: as above.
                unsafe { Self::load(numbers.as_ptr()) }
            }
        }

        // About the safety of every block in these operators: a value of this type exists only inside `with_lanes`, that is
        // after the processor was asked for the instructions; they have no other condition.
        impl Add for $name {
            type Output = Self;
            #[inline(always)]
            fn add(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $add(self.0[$i], other.0[$i]) }),+])
            }
        }
        impl Sub for $name {
            type Output = Self;
            #[inline(always)]
            fn sub(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $sub(self.0[$i], other.0[$i]) }),+])
            }
        }
        impl Mul for $name {
            type Output = Self;
            #[inline(always)]
            fn mul(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $mul(self.0[$i], other.0[$i]) }),+])
            }
        }
        impl Div for $name {
            type Output = Self;
            #[inline(always)]
            fn div(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $div(self.0[$i], other.0[$i]) }),+])
            }
        }
        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: see above.
                $name([$({
                    let $a = self.0[$i];
                    // SAFETY: see above.
                    unsafe { $neg }
                }),+])
            }
        }
        impl AddAssign for $name {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }
        impl SubAssign for $name {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }
        impl BitAnd for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitand(self, other: Self) -> Self {
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    #[allow(unused_unsafe, reason = "mask registers are combined by safe operators")]
                    // SAFETY: see above.
                    unsafe {
                        $and
                    }
                }),+])
            }
        }
        impl BitOr for $mask {
            type Output = Self;
            #[inline(always)]
            fn bitor(self, other: Self) -> Self {
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    #[allow(unused_unsafe, reason = "mask registers are combined by safe operators")]
                    // SAFETY: see above.
                    unsafe {
                        $or
                    }
                }),+])
            }
        }
        impl Not for $mask {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                $mask([$({
                    let $a = self.0[$i];
                    #[allow(unused_unsafe, reason = "mask registers are combined by safe operators")]
                    // SAFETY: see above.
                    unsafe {
                        $not
                    }
                }),+])
            }
        }

        impl Real for $name {
            type Vec3 = Vec3<Self>;
            type Mask = $mask;
            #[inline(always)]
            fn lit(value: f64) -> Self {
                Self::splat(value as $scalar)
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $sqrt(self.0[$i]) }),+])
            }
            #[inline(always)]
            fn abs(self) -> Self {
                // SAFETY: see above.
                $name([$({
                    let $a = self.0[$i];
                    // SAFETY: see above.
                    unsafe { $abs }
                }),+])
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $min(self.0[$i], other.0[$i]) }),+])
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: see above.
                $name([$(unsafe { $max(self.0[$i], other.0[$i]) }),+])
            }
            #[inline(always)]
            fn sin(self) -> Self {
                self.each(|number, _| number.sin())
            }
            #[inline(always)]
            fn cos(self) -> Self {
                self.each(|number, _| number.cos())
            }
            #[inline(always)]
            fn exp(self) -> Self {
                self.each(|number, _| number.exp())
            }
            #[inline(always)]
            fn ln(self) -> Self {
                self.each(|number, _| number.ln())
            }
            #[inline(always)]
            fn powf(self, exponent: Self) -> Self {
                let mut exponents = [0.0; $count * $per];
                // SAFETY: the array has a number for every lane.
                unsafe { exponent.store(exponents.as_mut_ptr()) };
                self.each(|number, lane| number.powf(exponents[lane]))
            }
            #[inline(always)]
            fn less(self, other: Self) -> $mask {
                // SAFETY: see above.
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    // SAFETY: see above.
                    unsafe { $less }
                }),+])
            }
            #[inline(always)]
            fn less_or_equal(self, other: Self) -> $mask {
                // SAFETY: see above.
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    // SAFETY: see above.
                    unsafe { $less_eq }
                }),+])
            }
            #[inline(always)]
            fn equal(self, other: Self) -> $mask {
                // SAFETY: see above.
                $mask([$({
                    let ($a, $b) = (self.0[$i], other.0[$i]);
                    // SAFETY: see above.
                    unsafe { $equal }
                }),+])
            }
            #[inline(always)]
            fn select(mask: $mask, yes: Self, no: Self) -> Self {
                $name([$({
                    let ($m, $a, $b) = (mask.0[$i], yes.0[$i], no.0[$i]);
                    // SAFETY: see above.
                    unsafe { $select }
                }),+])
            }
        }

        impl Lanes<$scalar> for $name {
            const WIDTH: usize = $count * $per;
            #[inline(always)]
            unsafe fn load(from: *const $scalar) -> Self {
                // SAFETY: the caller promises WIDTH readable numbers; the instruction takes any alignment.
                $name([$(unsafe { $load(from.add($i * $per)) }),+])
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $scalar) {
                // SAFETY: the caller promises WIDTH writable numbers; the instruction takes any alignment.
                unsafe { $($store(to.add($i * $per), self.0[$i]);)+ }
            }
            #[inline(always)]
            fn splat(value: $scalar) -> Self {
                // SAFETY: see above.
                $name([unsafe { $set1(value) }; $count])
            }
            #[inline(always)]
            fn from_lanes(lane: impl FnMut(usize) -> $scalar) -> Self {
                let lanes: [$scalar; $count * $per] = core::array::from_fn(lane);
                // SAFETY: the array has WIDTH numbers.
                unsafe { Self::load(lanes.as_ptr()) }
            }
            #[inline(always)]
            fn lane(self, index: usize) -> $scalar {
                let mut lanes: [$scalar; $count * $per] = [0.0; $count * $per];
                // SAFETY: the array has WIDTH numbers.
                unsafe { self.store(lanes.as_mut_ptr()) };
                lanes[index]
            }
        }
    };
}

// A selection is written in bits: the compiler knows these and makes the best of them (one `and` where one side is zero),
// but leaves a `blendv`, which looks at signs alone, as it stands.
lanes!(
    Avx2F32, Avx2F32Mask, f32, __m256, __m256, 1 [0], 8,
    _mm256_set1_ps _mm256_loadu_ps _mm256_storeu_ps _mm256_add_ps _mm256_sub_ps _mm256_mul_ps _mm256_div_ps
    _mm256_sqrt_ps _mm256_min_ps _mm256_max_ps,
    |a, b, m| neg _mm256_xor_ps(a, _mm256_set1_ps(-0.0)), abs _mm256_andnot_ps(_mm256_set1_ps(-0.0), a),
    less _mm256_cmp_ps::<_CMP_LT_OQ>(a, b), less_or_equal _mm256_cmp_ps::<_CMP_LE_OQ>(a, b),
    equal _mm256_cmp_ps::<_CMP_EQ_OQ>(a, b), select _mm256_or_ps(_mm256_and_ps(m, a), _mm256_andnot_ps(m, b)),
    and _mm256_and_ps(a, b), or _mm256_or_ps(a, b), not _mm256_xor_ps(a, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))
);
lanes!(
    Avx2F64, Avx2F64Mask, f64, __m256d, __m256d, 1 [0], 4,
    _mm256_set1_pd _mm256_loadu_pd _mm256_storeu_pd _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd
    _mm256_sqrt_pd _mm256_min_pd _mm256_max_pd,
    |a, b, m| neg _mm256_xor_pd(a, _mm256_set1_pd(-0.0)), abs _mm256_andnot_pd(_mm256_set1_pd(-0.0), a),
    less _mm256_cmp_pd::<_CMP_LT_OQ>(a, b), less_or_equal _mm256_cmp_pd::<_CMP_LE_OQ>(a, b),
    equal _mm256_cmp_pd::<_CMP_EQ_OQ>(a, b), select _mm256_or_pd(_mm256_and_pd(m, a), _mm256_andnot_pd(m, b)),
    and _mm256_and_pd(a, b), or _mm256_or_pd(a, b), not _mm256_xor_pd(a, _mm256_castsi256_pd(_mm256_set1_epi32(-1)))
);
lanes!(
    Avx512F32, Avx512F32Mask, f32, __m512, __mmask16, 1 [0], 16,
    _mm512_set1_ps _mm512_loadu_ps _mm512_storeu_ps _mm512_add_ps _mm512_sub_ps _mm512_mul_ps _mm512_div_ps
    _mm512_sqrt_ps _mm512_min_ps _mm512_max_ps,
    |a, b, m| neg _mm512_xor_ps(a, _mm512_set1_ps(-0.0)), abs _mm512_abs_ps(a),
    less _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b), less_or_equal _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b),
    equal _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(a, b), select _mm512_mask_blend_ps(m, b, a),
    and a & b, or a | b, not !a
);
lanes!(
    Avx512F64, Avx512F64Mask, f64, __m512d, __mmask8, 1 [0], 8,
    _mm512_set1_pd _mm512_loadu_pd _mm512_storeu_pd _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd
    _mm512_sqrt_pd _mm512_min_pd _mm512_max_pd,
    |a, b, m| neg _mm512_xor_pd(a, _mm512_set1_pd(-0.0)), abs _mm512_abs_pd(a),
    less _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b), less_or_equal _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b),
    equal _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(a, b), select _mm512_mask_blend_pd(m, b, a),
    and a & b, or a | b, not !a
);
