//! Two operations that lanes have faster than their trait gives them: an inverse root from the processor's estimate, and a product
//! with a sum in one rounding.
//!
//! In: lanes. Out: lanes. Never: another result for another lane; the same bits with AVX-512 as without it: there the estimate of 14
//! bits is corrected once in f32 and by three terms in f64, to about one unit in the last place, elsewhere both are the exact operations.
//! Not the lanes of laws that allow estimates (`real::fused`): those keep products apart until they are wanted, which takes three
//! registers for each number where arrays of them are kept.

use crate::real::Lanes;
#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::*;
#[cfg(target_arch = "x86_64")]
use core::mem::transmute_copy;

/// Whether the lanes are one register of AVX-512.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn is_zmm<P, R: Lanes<P>>() -> bool {
    size_of::<R>() == 64 && size_of::<P>() * R::WIDTH == 64
}

/// One over the square root.
#[inline(always)]
pub(super) fn rsqrt<P, R: Lanes<P>>(number: R) -> R {
    #[cfg(target_arch = "x86_64")]
    if is_zmm::<P, R>() {
        // SAFETY: lanes of 64 bytes are one AVX-512 register of numbers P (`real::x86` has no others), and exist only where the
        // processor has the instructions; both types have that size.
        unsafe {
            if size_of::<P>() == 4 {
                let x: __m512 = transmute_copy(&number);
                let y = _mm512_rsqrt14_ps(x);
                let t = _mm512_mul_ps(x, y);
                let c = _mm512_fnmadd_ps(t, y, _mm512_set1_ps(3.0));
                let r = _mm512_mul_ps(_mm512_mul_ps(y, _mm512_set1_ps(0.5)), c);
                return transmute_copy(&r);
            }
            let x: __m512d = transmute_copy(&number);
            let y = _mm512_rsqrt14_pd(x);
            // e = 1 - x y^2; y (1 + e/2 + 3/8 e^2 + 5/16 e^3).
            let e = _mm512_fnmadd_pd(_mm512_mul_pd(x, y), y, _mm512_set1_pd(1.0));
            let p = _mm512_fmadd_pd(e, _mm512_set1_pd(0.3125), _mm512_set1_pd(0.375));
            let p = _mm512_fmadd_pd(e, p, _mm512_set1_pd(0.5));
            let r = _mm512_fmadd_pd(_mm512_mul_pd(y, e), p, y);
            return transmute_copy(&r);
        }
    }
    number.rsqrt()
}

/// `a b + c`.
#[inline(always)]
pub(super) fn fused<P, R: Lanes<P>>(a: R, b: R, c: R) -> R {
    #[cfg(target_arch = "x86_64")]
    if is_zmm::<P, R>() {
        // SAFETY: lanes of 64 bytes are one AVX-512 register of numbers P (`real::x86` has no others), and exist only where the
        // processor has the instructions; both types have that size.
        unsafe {
            if size_of::<P>() == 4 {
                let r = _mm512_fmadd_ps(transmute_copy(&a), transmute_copy(&b), transmute_copy(&c));
                return transmute_copy(&r);
            }
            let r = _mm512_fmadd_pd(transmute_copy(&a), transmute_copy(&b), transmute_copy(&c));
            return transmute_copy(&r);
        }
    }
    a * b + c
}
