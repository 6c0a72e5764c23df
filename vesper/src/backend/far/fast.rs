//! Operations of lanes that the trait has not yet; to be replaced by its own.

use crate::real::{Lanes, Real};
#[cfg(target_arch = "x86_64")]
use core::arch::x86_64::*;
use core::mem::{size_of, transmute_copy};

#[inline(always)]
fn is_zmm<P, R: Lanes<P>>() -> bool {
    cfg!(target_arch = "x86_64") && size_of::<R>() == 64 && size_of::<P>() * R::WIDTH == 64
}

/// One over the square root.
#[inline(always)]
pub(super) fn rsqrt<P, R: Lanes<P>>(number: R) -> R {
    #[cfg(target_arch = "x86_64")]
    if is_zmm::<P, R>() {
        // SAFETY: throwaway.
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
        // SAFETY: throwaway.
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

/// Truth values as bits.
#[inline(always)]
pub(super) fn bits<P, R: Lanes<P>>(mask: R::Mask) -> u32 {
    #[cfg(target_arch = "x86_64")]
    if is_zmm::<P, R>() {
        // SAFETY: throwaway.
        unsafe {
            return if size_of::<P>() == 4 {
                u32::from(transmute_copy::<_, u16>(&mask))
            } else {
                u32::from(transmute_copy::<_, u8>(&mask))
            };
        }
    }
    let truth = R::select(mask, R::lit(1.0), R::lit(0.0));
    let zero = R::lit(0.0);
    let _ = zero;
    let mut bits = 0;
    for lane in 0..R::WIDTH {
        // A truth value is 1 or 0, and 0 is the only number equal to its own negative in bits but for the sign.
        bits |= u32::from(is_one::<P, R>(truth, lane)) << lane;
    }
    bits
}

#[inline(always)]
fn is_one<P, R: Lanes<P>>(truth: R, lane: usize) -> bool {
    let number = truth.lane(lane);
    // SAFETY: throwaway.
    unsafe {
        if size_of::<P>() == 4 {
            transmute_copy::<P, f32>(&number) != 0.0
        } else {
            transmute_copy::<P, f64>(&number) != 0.0
        }
    }
}

/// Of a size known: see [`Real`].
#[allow(dead_code)]
fn is_real<R: Real>(_: R) {}
