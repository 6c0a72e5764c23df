//! Lanes of x86-64 registers. The types stay inside this crate: [`super::Scalar::with_lanes`] alone hands them out,
//! and only where the processor has the instructions, which is what makes their safe operations sound.
//!
//! Why not plain numbers side by side here too, as on other architectures: the compiler does not find these registers by
//! itself (measured on a chain of five row laws: as slow as one row at a time, five times slower than with AVX2).

#![allow(unused_unsafe, reason = "SSE2 is always there, AVX2 and AVX-512 are not")]

use super::fused::{Estimates, estimates};
use super::registers::lanes;
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
/// The processor has AVX2 and FMA.
#[target_feature(enable = "avx2,fma")]
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

/// The sums of all lanes, by halves.
macro_rules! sums {
    ($($name:ident($register:ty) -> $scalar:ty: |$x:ident| $sum:expr;)*) => {$(
        /// # Safety
        /// The processor has the registers.
        #[inline(always)]
        unsafe fn $name([$x]: [$register; 1]) -> $scalar {
            // SAFETY: passed on to the caller.
            unsafe { $sum }
        }
    )*};
}
sums! {
    sum_128_ps(__m128) -> f32: |x| {
        let halves = _mm_add_ps(x, _mm_movehl_ps(x, x));
        _mm_cvtss_f32(_mm_add_ss(halves, _mm_shuffle_ps::<1>(halves, halves)))
    };
    sum_128_pd(__m128d) -> f64: |x| _mm_cvtsd_f64(_mm_add_sd(x, _mm_unpackhi_pd(x, x)));
    sum_256_ps(__m256) -> f32: |x| sum_128_ps([_mm_add_ps(_mm256_castps256_ps128(x), _mm256_extractf128_ps::<1>(x))]);
    sum_256_pd(__m256d) -> f64: |x| sum_128_pd([_mm_add_pd(_mm256_castpd256_pd128(x), _mm256_extractf128_pd::<1>(x))]);
    sum_512_ps(__m512) -> f32: |x| {
        sum_256_ps([_mm256_add_ps(_mm512_castps512_ps256(x), _mm512_extractf32x8_ps::<1>(x))])
    };
    sum_512_pd(__m512d) -> f64: |x| {
        sum_256_pd([_mm256_add_pd(_mm512_castpd512_pd256(x), _mm512_extractf64x4_pd::<1>(x))])
    };
}

/// The truth values of one register, one bit for each lane.
trait Truth {
    fn bits(self) -> u32;
}

macro_rules! truth {
    ($($register:ty: |$truth:ident| $bits:expr,)*) => {$(
        impl Truth for $register {
            #[inline(always)]
            fn bits(self) -> u32 {
                let $truth = self;
                // SAFETY: as for the operators of lanes: a register of truth values is only there with its instructions.
                unsafe { $bits }
            }
        }
    )*};
}
truth! {
    __m128: |truth| _mm_movemask_ps(truth) as u32,
    __m128d: |truth| _mm_movemask_pd(truth) as u32,
    __m256: |truth| _mm256_movemask_ps(truth) as u32,
    __m256d: |truth| _mm256_movemask_pd(truth) as u32,
    __mmask16: |truth| truth.into(),
    __mmask8: |truth| truth.into(),
}

// A selection is written in bits: the compiler knows these and makes the best of them (one `and` where one side is zero),
// but leaves a `blendv`, which looks at signs alone, as it stands.
lanes!(
    BaselineF32, BaselineF32Mask, f32, f32, __m128, __m128, 1 [0], 4,
    _mm_set1_ps, _mm_loadu_ps, _mm_storeu_ps, _mm_add_ps, _mm_sub_ps, _mm_mul_ps, _mm_div_ps,
    _mm_sqrt_ps, _mm_min_ps, _mm_max_ps, sum_128_ps,
    |a, b, m| neg _mm_xor_ps(a, _mm_set1_ps(-0.0)), abs _mm_andnot_ps(_mm_set1_ps(-0.0), a),
    less _mm_cmplt_ps(a, b), less_or_equal _mm_cmple_ps(a, b), equal _mm_cmpeq_ps(a, b),
    select _mm_or_ps(_mm_and_ps(m, a), _mm_andnot_ps(m, b)),
    and _mm_and_ps(a, b), or _mm_or_ps(a, b), not _mm_xor_ps(a, _mm_castsi128_ps(_mm_set1_epi32(-1)))
);
lanes!(
    BaselineF64, BaselineF64Mask, f64, f64, __m128d, __m128d, 1 [0], 2,
    _mm_set1_pd, _mm_loadu_pd, _mm_storeu_pd, _mm_add_pd, _mm_sub_pd, _mm_mul_pd, _mm_div_pd,
    _mm_sqrt_pd, _mm_min_pd, _mm_max_pd, sum_128_pd,
    |a, b, m| neg _mm_xor_pd(a, _mm_set1_pd(-0.0)), abs _mm_andnot_pd(_mm_set1_pd(-0.0), a),
    less _mm_cmplt_pd(a, b), less_or_equal _mm_cmple_pd(a, b), equal _mm_cmpeq_pd(a, b),
    select _mm_or_pd(_mm_and_pd(m, a), _mm_andnot_pd(m, b)),
    and _mm_and_pd(a, b), or _mm_or_pd(a, b), not _mm_xor_pd(a, _mm_castsi128_pd(_mm_set1_epi32(-1)))
);
lanes!(
    Avx2F32, Avx2F32Mask, f32, f32, __m256, __m256, 1 [0], 8,
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps, _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_div_ps,
    _mm256_sqrt_ps, _mm256_min_ps, _mm256_max_ps, sum_256_ps,
    |a, b, m| neg _mm256_xor_ps(a, _mm256_set1_ps(-0.0)), abs _mm256_andnot_ps(_mm256_set1_ps(-0.0), a),
    less _mm256_cmp_ps::<_CMP_LT_OQ>(a, b), less_or_equal _mm256_cmp_ps::<_CMP_LE_OQ>(a, b),
    equal _mm256_cmp_ps::<_CMP_EQ_OQ>(a, b), select _mm256_or_ps(_mm256_and_ps(m, a), _mm256_andnot_ps(m, b)),
    and _mm256_and_ps(a, b), or _mm256_or_ps(a, b), not _mm256_xor_ps(a, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))
);
lanes!(
    Avx2F64, Avx2F64Mask, f64, f64, __m256d, __m256d, 1 [0], 4,
    _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd, _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd,
    _mm256_sqrt_pd, _mm256_min_pd, _mm256_max_pd, sum_256_pd,
    |a, b, m| neg _mm256_xor_pd(a, _mm256_set1_pd(-0.0)), abs _mm256_andnot_pd(_mm256_set1_pd(-0.0), a),
    less _mm256_cmp_pd::<_CMP_LT_OQ>(a, b), less_or_equal _mm256_cmp_pd::<_CMP_LE_OQ>(a, b),
    equal _mm256_cmp_pd::<_CMP_EQ_OQ>(a, b), select _mm256_or_pd(_mm256_and_pd(m, a), _mm256_andnot_pd(m, b)),
    and _mm256_and_pd(a, b), or _mm256_or_pd(a, b), not _mm256_xor_pd(a, _mm256_castsi256_pd(_mm256_set1_epi32(-1)))
);
lanes!(
    Avx512F32, Avx512F32Mask, Avx2F32, f32, __m512, __mmask16, 1 [0], 16,
    _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps, _mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps, _mm512_div_ps,
    _mm512_sqrt_ps, _mm512_min_ps, _mm512_max_ps, sum_512_ps,
    |a, b, m| neg _mm512_xor_ps(a, _mm512_set1_ps(-0.0)), abs _mm512_abs_ps(a),
    less _mm512_cmp_ps_mask::<_CMP_LT_OQ>(a, b), less_or_equal _mm512_cmp_ps_mask::<_CMP_LE_OQ>(a, b),
    equal _mm512_cmp_ps_mask::<_CMP_EQ_OQ>(a, b), select _mm512_mask_blend_ps(m, b, a),
    and a & b, or a | b, not !a
);
lanes!(
    Avx512F64, Avx512F64Mask, Avx2F64, f64, __m512d, __mmask8, 1 [0], 8,
    _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd, _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd,
    _mm512_sqrt_pd, _mm512_min_pd, _mm512_max_pd, sum_512_pd,
    |a, b, m| neg _mm512_xor_pd(a, _mm512_set1_pd(-0.0)), abs _mm512_abs_pd(a),
    less _mm512_cmp_pd_mask::<_CMP_LT_OQ>(a, b), less_or_equal _mm512_cmp_pd_mask::<_CMP_LE_OQ>(a, b),
    equal _mm512_cmp_pd_mask::<_CMP_EQ_OQ>(a, b), select _mm512_mask_blend_pd(m, b, a),
    and a & b, or a | b, not !a
);

// The estimates are within 1.5 2^-12 (rsqrtps) and 2^-14 (rsqrt14) of the root, so that a series of so many terms leaves an
// error below half a rounding.
estimates!(Avx2F32, f32, 2, _mm256_fmadd_ps, _mm256_fmsub_ps, _mm256_fnmadd_ps, |x| Avx2F32([_mm256_rsqrt_ps(x.0[0])]));
estimates!(Avx2F64, f64, 0, _mm256_fmadd_pd, _mm256_fmsub_pd, _mm256_fnmadd_pd, |x| x.rsqrt());
estimates!(Avx512F32, f32, 1, _mm512_fmadd_ps, _mm512_fmsub_ps, _mm512_fnmadd_ps, |x| Avx512F32([_mm512_rsqrt14_ps(
    x.0[0]
)]));
estimates!(Avx512F64, f64, 3, _mm512_fmadd_pd, _mm512_fmsub_pd, _mm512_fnmadd_pd, |x| Avx512F64([_mm512_rsqrt14_pd(
    x.0[0]
)]));
