//! Lanes for laws that allow `estimates`: a product that something is added to is one operation with it, and reciprocal roots
//! begin with the processor's estimate.
//!
//! In: lanes whose processor has both ([`Estimates`]). Out: [`Fused`], the same lanes as a [`Real`]. Never: lanes for a law that
//! does not allow it, whose bits must not depend on the processor.
//!
//! The compiler may not fuse what is written as two operations, since that changes the last bit. So a product is kept as its two
//! factors until somebody wants it. Which of the two a number is, `product` says: once everything is inlined, it is a constant,
//! and nothing of it is left in the loop. What is fused is decided by the text of the body alone, not by the compiler: the same
//! bits in debug and release.

use super::{Lanes, Real, Scalar, Vec3};
use core::marker::PhantomData;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// What [`Fused`] is made of.
pub trait Estimates<P>: Lanes<P> {
    /// [`Lanes::Narrow`].
    type Half: Estimates<P>;
    /// Terms of the series in `1 - self * estimate^2` that correct an estimate to the precision `P`; 0 where the processor has
    /// no estimate.
    const TERMS: usize;
    /// `self * factor + term`, rounded once.
    fn fused_add(self, factor: Self, term: Self) -> Self;
    /// `self * factor - term`, rounded once.
    fn fused_sub(self, factor: Self, term: Self) -> Self;
    /// `term - self * factor`, rounded once.
    fn fused_from(self, factor: Self, term: Self) -> Self;
    /// About `1 / sqrt(self)`.
    fn estimate(self) -> Self;
}

/// [`Estimates`] of a lane type of one register: three operations on registers, and one on lanes.
macro_rules! estimates {
    ($name:ident, $scalar:ty, $terms:literal, $add:path, $sub:path, $from:path, |$x:ident| $estimate:expr) => {
        impl Estimates<$scalar> for $name {
            type Half = <$name as Lanes<$scalar>>::Narrow;
            const TERMS: usize = $terms;
            #[inline(always)]
            fn fused_add(self, factor: Self, term: Self) -> Self {
                // SAFETY: as for the operators of the lanes.
                $name([unsafe { $add(self.0[0], factor.0[0], term.0[0]) }])
            }
            #[inline(always)]
            fn fused_sub(self, factor: Self, term: Self) -> Self {
                // SAFETY: as above.
                $name([unsafe { $sub(self.0[0], factor.0[0], term.0[0]) }])
            }
            #[inline(always)]
            fn fused_from(self, factor: Self, term: Self) -> Self {
                // SAFETY: as above.
                $name([unsafe { $from(self.0[0], factor.0[0], term.0[0]) }])
            }
            #[inline(always)]
            fn estimate(self) -> Self {
                let $x = self;
                // SAFETY: as above.
                unsafe { $estimate }
            }
        }
    };
}
pub(super) use estimates;

/// A number of precision `P`, or the product of two that is not computed yet.
#[derive(Clone, Copy, Debug)]
pub struct Fused<P, L> {
    a: L,
    b: L,
    product: bool,
    precision: PhantomData<P>,
}

impl<P: Scalar, L: Estimates<P>> Fused<P, L> {
    #[inline(always)]
    fn of(a: L) -> Self {
        Fused { a, b: a, product: false, precision: PhantomData }
    }

    #[inline(always)]
    fn value(self) -> L {
        if self.product { self.a * self.b } else { self.a }
    }
}

/// What stands before the powers of `h` in `(1 - h)^(-1/2)` and in `(1 - h)^(-3/2)`, after the 1 (binomial series).
const ROOT: [f64; 3] = [0.5, 0.375, 0.3125];
const CUBE: [f64; 3] = [1.5, 1.875, 2.1875];

/// The first terms of such a series, by Horner, for `h = 1 - x square`, where `square` is that of an estimate of `1 / sqrt(x)`.
#[inline(always)]
fn correction<P: Scalar, L: Estimates<P>>(x: L, square: L, coefficients: [f64; 3]) -> L {
    let h = x.fused_from(square, L::lit(1.0));
    let mut terms = coefficients[..L::TERMS].iter().rev();
    let mut sum = L::lit(terms.next().copied().unwrap_or_default());
    for &coefficient in terms {
        sum = sum.fused_add(h, L::lit(coefficient));
    }
    sum.fused_add(h, L::lit(1.0))
}

impl<P: Scalar, L: Estimates<P>> Add for Fused<P, L> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self::of(match (self.product, other.product) {
            (_, true) => other.a.fused_add(other.b, self.value()),
            (true, false) => self.a.fused_add(self.b, other.a),
            (false, false) => self.a + other.a,
        })
    }
}
impl<P: Scalar, L: Estimates<P>> Sub for Fused<P, L> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self::of(match (self.product, other.product) {
            (_, true) => other.a.fused_from(other.b, self.value()),
            (true, false) => self.a.fused_sub(self.b, other.a),
            (false, false) => self.a - other.a,
        })
    }
}
impl<P: Scalar, L: Estimates<P>> Mul for Fused<P, L> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Fused { a: self.value(), b: other.value(), product: true, precision: PhantomData }
    }
}
impl<P: Scalar, L: Estimates<P>> Div for Fused<P, L> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self::of(self.value() / other.value())
    }
}
impl<P: Scalar, L: Estimates<P>> Neg for Fused<P, L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Fused { a: -self.a, ..self }
    }
}
impl<P: Scalar, L: Estimates<P>> AddAssign for Fused<P, L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl<P: Scalar, L: Estimates<P>> SubAssign for Fused<P, L> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

/// Functions of one number, and of two, that have no other form.
macro_rules! as_written {
    ($($function:ident($($other:ident)?),)*) => {$(
        #[inline(always)]
        fn $function(self $(, $other: Self)?) -> Self {
            Self::of(self.value().$function($($other.value())?))
        }
    )*};
}

impl<P: Scalar, L: Estimates<P>> Real for Fused<P, L> {
    type Vec3 = Vec3<Self>;
    type Mask = L::Mask;
    as_written! { sqrt(), abs(), min(other), max(other), sin(), cos(), exp(), ln(), powf(other), }
    #[inline(always)]
    fn lit(value: f64) -> Self {
        Self::of(L::lit(value))
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        let x = self.value();
        if L::TERMS == 0 {
            return Self::of(x.rsqrt());
        }
        let root = x.estimate();
        Self::of(root) * Self::of(correction(x, root * root, ROOT))
    }
    #[inline(always)]
    fn over_root_cubed(self, square: Self) -> Self {
        let x = square.value();
        if L::TERMS == 0 {
            return Self::of(self.value().over_root_cubed(x));
        }
        let root = x.estimate();
        let inverse = root * root;
        Self::of(self.value() * (root * inverse)) * Self::of(correction(x, inverse, CUBE))
    }
    #[inline(always)]
    fn less(self, other: Self) -> L::Mask {
        self.value().less(other.value())
    }
    #[inline(always)]
    fn less_or_equal(self, other: Self) -> L::Mask {
        self.value().less_or_equal(other.value())
    }
    #[inline(always)]
    fn equal(self, other: Self) -> L::Mask {
        self.value().equal(other.value())
    }
    #[inline(always)]
    fn select(mask: L::Mask, yes: Self, no: Self) -> Self {
        Self::of(L::select(mask, yes.value(), no.value()))
    }
}

impl<P: Scalar, L: Estimates<P>> Lanes<P> for Fused<P, L> {
    const WIDTH: usize = L::WIDTH;
    type Narrow = Fused<P, L::Half>;
    const ESTIMATES: bool = true;
    #[inline(always)]
    unsafe fn load(from: *const P) -> Self {
        // SAFETY: the caller promises as many numbers.
        Self::of(unsafe { L::load(from) })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut P) {
        // SAFETY: the caller promises as many numbers.
        unsafe { self.value().store(to) };
    }
    #[inline(always)]
    fn splat(value: P) -> Self {
        Self::of(L::splat(value))
    }
    #[inline(always)]
    fn from_lanes(lane: impl FnMut(usize) -> P) -> Self {
        Self::of(L::from_lanes(lane))
    }
    #[inline(always)]
    fn lane(self, index: usize) -> P {
        self.value().lane(index)
    }
    #[inline(always)]
    fn sum(self) -> P {
        self.value().sum()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DoubleDouble, Isa, WithLanes};
    use super::*;

    /// The largest errors of `rsqrt`, of `over_root_cubed`, and of a product with a sum and a difference, in parts of the epsilon
    /// of `P`; and whether there are estimates.
    struct Errors<P>(PhantomData<P>);

    impl<P: Scalar> WithLanes<P> for Errors<P> {
        type Output = ([f64; 3], bool);
        #[inline(always)]
        fn with<R: Lanes<P>>(self) -> Self::Output {
            let exact = |number: P| DoubleDouble::from_f64(number.to_f64());
            let mut most = [0.0; 3];
            // Powers of a number a little above 1: from some 1e-6 to 1e6, every binade many times.
            for first in -20_000..20_000 {
                let number =
                    |lane: usize| P::from_f64(f64::from(first + 977 * lane as i32).mul_add(1e-3, 0.123).exp2());
                let weight = |lane: usize| P::from_f64(1.0 + 0.37 * (lane + 1) as f64);
                let (x, w) = (R::from_lanes(number), R::from_lanes(weight));
                let sums = x * w + w * R::lit(3.0) - x * x;
                let found = [x.rsqrt(), w.over_root_cubed(x), sums];
                for lane in 0..R::WIDTH {
                    let (x, w) = (exact(number(lane)), exact(weight(lane)));
                    let root = DoubleDouble::lit(1.0) / x.sqrt();
                    let terms = [x * w, w * DoubleDouble::lit(3.0), x * x];
                    let scale = terms[0] + terms[1] + terms[2];
                    let expected = [root, w * root / x, terms[0] + terms[1] - terms[2]];
                    for (which, scale) in [expected[0], expected[1], scale].into_iter().enumerate() {
                        let off = (exact(found[which].lane(lane)) - expected[which]) / scale;
                        most[which] = f64::max(most[which], off.abs().to_f64() / P::EPSILON);
                    }
                }
            }
            (most, R::ESTIMATES)
        }
    }

    fn estimates_keep_their_promise<P: Scalar>() {
        for isa in Isa::available() {
            let (written, estimates) = P::with_lanes(isa, Errors(PhantomData));
            assert!(!estimates);
            let (found, estimates) = P::with_estimates(isa, Errors(PhantomData));
            println!("{} {isa:?}: as written {written:.2?}, estimates ({estimates}) {found:.2?}", P::NAME);
            for ((found, written), roundings) in found.iter().zip(written).zip([2.0, 3.0, 1.0]) {
                assert!(*found < written + roundings, "{} {isa:?}: {found} epsilon, {written} as written", P::NAME);
            }
        }
    }

    #[test]
    fn estimates_are_within_the_roundings_that_they_promise() {
        estimates_keep_their_promise::<f32>();
        estimates_keep_their_promise::<f64>();
    }

    #[test]
    fn the_baseline_of_aarch64_has_estimates_and_others_have_not() {
        let of = |isa| f64::with_estimates(isa, Errors(PhantomData)).1;
        assert!(!of(Isa::Scalar));
        assert_eq!(of(Isa::Baseline), cfg!(target_arch = "aarch64"));
    }
}
