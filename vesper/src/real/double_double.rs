//! Numbers of twice the digits of f64, as the sum of two: for answers that others are judged by, and for what rounding takes
//! from chaotic problems.
//!
//! Not one of the crates for them: the division of `twofloat` 0.8 is wrong in its 17th digit, and so are its functions.
//! Where f64 has an infinity, or a zero that is no difference, the result is that of f64.
//!
//! Sources: Joldes, Muller, Popescu, ACM TOMS 44 (2017) 15, algorithms 6, 12 and 17 for sum, product and quotient; Lefevre, Louvet,
//! Muller, Picot, Rideau, ACM TOMS 49 (2023) 1, for the root: errors of less than 16 times 2^-106. Functions: reduced to a
//! small argument, and Taylor's series. The logarithm of a number next to 1 has an absolute error of that size. Products take the
//! fused multiply-add of the processor by way of the system's library, which chooses at run time.

use super::lanes::{Isa, Lanes, WithLanes};
use super::scalar::InPrecision;
use super::{Real, Scalar, Vec3};
use core::cmp::Ordering;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A number of 106 bits: the unevaluated sum of two f64 ("double-double").
///
/// What goes in and out of a state by numbers is f64: places that a client reads have been rounded, and so are parameters and values
/// that it gives. Laws made at run time, [`crate::law::DynLaw`], compute in f64. Of the integrators `gauss_radau_15` has the weights of
/// its steps to 32 digits; those of others are f64, which leaves such a state errors of one sign and of that size. Rounding errors
/// are not kept besides.
#[derive(Clone, Copy, Default, PartialEq)]
pub struct DoubleDouble {
    /// The nearest f64.
    hi: f64,
    /// What that leaves out.
    lo: f64,
}

/// The sum of two numbers, the first of which is the larger one.
#[inline(always)]
fn fast_sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    DoubleDouble { hi, lo: b - (hi - a) }
}

/// The sum of two numbers, without an error.
#[inline(always)]
fn sum(a: f64, b: f64) -> DoubleDouble {
    let hi = a + b;
    let back = hi - b;
    DoubleDouble { hi, lo: (a - back) + (b - (hi - back)) }
}

/// Half of pi, and the logarithm of 2, in three parts.
const HALF_PI: [f64; 3] = [core::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_169_8e-33];
const LN_2: [f64; 3] = [core::f64::consts::LN_2, 2.319_046_813_846_299_6e-17, 5.707_708_438_416_212e-34];
/// Angles up to which their turns are counted; of larger ones sine and cosine are those of f64.
const TURNS: f64 = 4_503_599_627_370_496.0;
/// Halvings of the argument of the exponential function.
const HALVINGS: i32 = 8;

impl DoubleDouble {
    /// The nearest f64, and what it leaves out.
    pub fn parts(self) -> [f64; 2] {
        [self.hi, self.lo]
    }

    /// The product of two f64, without an error.
    #[inline(always)]
    fn product(a: f64, b: f64) -> Self {
        let hi = a * b;
        DoubleDouble { hi, lo: a.mul_add(b, -hi) }
    }

    /// What `exact` gives, where f64 gives a number that is neither infinite nor 0.
    #[inline(always)]
    fn unless(plain: f64, exact: impl FnOnce() -> Self) -> Self {
        if plain.is_finite() && plain != 0.0 { exact() } else { Self::from_f64(plain) }
    }

    /// The quotient of two.
    fn by(self, other: Self) -> Self {
        let by = self.hi / other.hi;
        Self::unless(by, || {
            let back = Self::product(by, other.hi);
            let back = fast_sum(back.hi, by.mul_add(other.lo, back.lo));
            fast_sum(by, ((self.hi - back.hi) + (self.lo - back.lo)) / other.hi)
        })
    }

    /// Times a power of 2.
    fn scaled(self, power: i32) -> Self {
        // In two steps, since the power alone may be out of range.
        let [first, second] = [power / 2, power - power / 2].map(|power| 2f64.powi(power));
        DoubleDouble { hi: self.hi * first * second, lo: self.lo * first * second }
    }

    /// Without so many times a constant.
    fn without(self, times: f64, constant: [f64; 3]) -> Self {
        constant.into_iter().fold(self, |left, part| left - Self::product(times, part))
    }

    /// The terms of Taylor's series from `first` on: each the one before by `by`, divided by the next two numbers.
    fn series(first: Self, by: Self, from: i32) -> Self {
        let (mut term, mut sum) = (first, first);
        for k in 0..14 {
            let next = f64::from(from + 2 * k);
            term = term * by / Self::from_f64((next + 1.0) * (next + 2.0));
            sum += term;
        }
        sum
    }

    /// Sine and cosine of less than [`TURNS`].
    fn circular(self) -> [Self; 2] {
        let first = (self.hi / HALF_PI[0]).round();
        let rest = self.without(first, HALF_PI);
        // Of many turns the first quotient is not the nearest one.
        let second = (rest.hi / HALF_PI[0]).round();
        let rest = rest.without(second, HALF_PI);
        let turns = first.rem_euclid(4.0) + second.rem_euclid(4.0);
        let by = -(rest * rest);
        let (sine, cosine) = (Self::series(rest, by, 1), Self::series(Self::from_f64(1.0), by, 0));
        match turns.rem_euclid(4.0) {
            0.0 => [sine, cosine],
            1.0 => [cosine, -sine],
            2.0 => [-sine, -cosine],
            _ => [-cosine, sine],
        }
    }
}

impl core::fmt::Debug for DoubleDouble {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{:?} + {:e}", self.hi, self.lo)
    }
}

impl core::fmt::Display for DoubleDouble {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        self.hi.fmt(f)
    }
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.parts().partial_cmp(&other.parts())
    }
}

// None of the operations is inlined: each is dozens of instructions, and a law's body is hundreds of operations.
impl Add for DoubleDouble {
    type Output = Self;
    #[inline(never)]
    fn add(self, other: Self) -> Self {
        let (high, low) = (sum(self.hi, other.hi), sum(self.lo, other.lo));
        // Zeros have a sign, too.
        if !high.hi.is_finite() || high.hi == 0.0 && self.lo == 0.0 && other.lo == 0.0 {
            return Self::from_f64(high.hi);
        }
        let middle = fast_sum(high.hi, high.lo + low.hi);
        fast_sum(middle.hi, low.lo + middle.lo)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        let high = Self::product(self.hi, other.hi);
        Self::unless(high.hi, || {
            let cross = self.lo.mul_add(other.hi, self.hi.mul_add(other.lo, self.lo * other.lo));
            fast_sum(high.hi, high.lo + cross)
        })
    }
}

impl Div for DoubleDouble {
    type Output = Self;
    #[inline(never)]
    fn div(self, other: Self) -> Self {
        self.by(other)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;
    fn neg(self) -> Self {
        DoubleDouble { hi: -self.hi, lo: -self.lo }
    }
}

impl AddAssign for DoubleDouble {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for DoubleDouble {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Real for DoubleDouble {
    type Vec3 = Vec3<Self>;
    type Mask = bool;

    fn lit(value: f64) -> Self {
        Self::from_f64(value)
    }
    #[inline(never)]
    fn sqrt(self) -> Self {
        let root = self.hi.sqrt();
        Self::unless(root, || {
            let left = self.lo + (-root).mul_add(root, self.hi);
            fast_sum(root, left / (2.0 * root))
        })
    }
    fn abs(self) -> Self {
        if self.hi.is_sign_negative() { -self } else { self }
    }
    fn min(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
    fn max(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(never)]
    fn sin(self) -> Self {
        let plain = self.hi.sin();
        if self.hi.abs() > TURNS { Self::from_f64(plain) } else { Self::unless(plain, || self.circular()[0]) }
    }
    #[inline(never)]
    fn cos(self) -> Self {
        let plain = self.hi.cos();
        if self.hi.abs() > TURNS { Self::from_f64(plain) } else { Self::unless(plain, || self.circular()[1]) }
    }
    #[inline(never)]
    fn exp(self) -> Self {
        Self::unless(self.hi.exp(), || {
            let twos = (self.hi / LN_2[0]).round();
            let small = self.without(twos, LN_2).scaled(-HALVINGS);
            let (mut term, mut less_one) = (small, small);
            for k in 2..11 {
                term = term * small / Self::from_f64(f64::from(k));
                less_one += term;
            }
            for _ in 0..HALVINGS {
                less_one = less_one + less_one + less_one * less_one;
            }
            (less_one + Self::from_f64(1.0)).scaled(twos as i32)
        })
    }
    #[inline(never)]
    fn ln(self) -> Self {
        let near = self.hi.ln();
        if !near.is_finite() {
            return Self::from_f64(near);
        }
        // Halley's step from the f64 next to it, whose error has the third power.
        let (near, back) = (Self::from_f64(near), Self::from_f64(near).exp());
        let step = (self - back) / (self + back);
        near + step + step
    }
    #[inline(never)]
    fn powf(self, exponent: Self) -> Self {
        let plain = self.hi.powf(exponent.hi);
        // The powers of 0 and of infinity that are 1.
        if !self.hi.abs().ln().is_finite() || !exponent.is_finite() {
            return Self::from_f64(plain);
        }
        Self::unless(plain, || {
            let magnitude = (exponent * self.abs().ln()).exp();
            // Whole powers of negative numbers are those that f64 knows.
            if plain < 0.0 { -magnitude } else { magnitude }
        })
    }
    fn less(self, other: Self) -> bool {
        self < other
    }
    fn less_or_equal(self, other: Self) -> bool {
        self <= other
    }
    fn equal(self, other: Self) -> bool {
        self == other
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

impl Lanes<DoubleDouble> for DoubleDouble {
    const WIDTH: usize = 1;
    type Narrow = DoubleDouble;
    #[inline(always)]
    unsafe fn load(from: *const DoubleDouble) -> Self {
        // SAFETY: the caller promises one readable number at `from`.
        unsafe { *from }
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut DoubleDouble) {
        // SAFETY: the caller promises one writable number at `to`.
        unsafe { *to = self }
    }
    #[inline(always)]
    fn splat(value: DoubleDouble) -> Self {
        value
    }
    #[inline(always)]
    fn from_lanes(mut lane: impl FnMut(usize) -> DoubleDouble) -> Self {
        lane(0)
    }
    #[inline(always)]
    fn lane(self, _index: usize) -> DoubleDouble {
        self
    }
    #[inline(always)]
    fn sum(self) -> Self {
        self
    }
}

impl Scalar for DoubleDouble {
    const NAME: &'static str = "double-double";
    // 2^-104: sums and products are off by up to a few units of 2^-106.
    const EPSILON: f64 = 4.930_380_657_631_324e-32;
    fn from_f64(value: f64) -> Self {
        DoubleDouble { hi: value, lo: 0.0 }
    }
    fn from_product(a: f64, b: f64) -> Self {
        Self::unless(a * b, || Self::product(a, b))
    }
    fn to_f64(self) -> f64 {
        self.hi
    }
    fn rest(self) -> f64 {
        self.lo
    }
    fn from_parts(number: f64, rest: f64) -> Self {
        // Parts of another number are added, those of one of these are it, whatever sign a zero has.
        if number + rest == number { DoubleDouble { hi: number, lo: rest } } else { sum(number, rest) }
    }
    const PARTS: usize = 2;
    fn is_finite(self) -> bool {
        self.hi.is_finite()
    }
    fn bits(self) -> u64 {
        self.hi.to_bits() ^ self.lo.to_bits().rotate_left(32)
    }
    fn choose<T: InPrecision>(
        _single: impl FnOnce() -> T::Of<f32>,
        _double: impl FnOnce() -> T::Of<f64>,
        twice: impl FnOnce() -> T::Of<DoubleDouble>,
    ) -> T::Of<Self> {
        twice()
    }
    fn with_lanes<T: WithLanes<Self>>(_isa: Isa, task: T) -> T::Output {
        task.with::<DoubleDouble>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(hi: f64, lo: f64) -> DoubleDouble {
        DoubleDouble::from_f64(hi) + DoubleDouble::from_f64(lo)
    }

    /// Against identities that hold exactly, of numbers that f64 does not hold.
    #[test]
    fn results_have_twice_the_digits() {
        let third = of(1.0, 0.0) / of(3.0, 0.0);
        let near = |found: DoubleDouble, exact: DoubleDouble, within: f64| {
            let off = ((found - exact) / exact).abs().to_f64();
            assert!(off <= within * DoubleDouble::EPSILON, "{found:?} is {off:e} off");
        };
        near(third + third + third, of(1.0, 0.0), 1.0);
        near(third * of(3.0, 0.0), of(1.0, 0.0), 1.0);
        let root = of(2.0, 0.0).sqrt();
        near(root * root, of(2.0, 0.0), 1.0);
        // Second parts on both sides.
        near(root / third, root * of(3.0, 0.0), 4.0);
        near((root / third) * third, root, 4.0);
        near(third.sqrt() * third.sqrt(), third, 4.0);
        near((root + third) - root, third, 8.0);
        // sqrt(2), from its digits.
        near(root, of(core::f64::consts::SQRT_2, -9.667_293_313_452_913e-17), 4.0);
        // From their digits: e, the logarithm of 10, the sine and cosine of 1.
        near(of(1.0, 0.0).exp(), of(core::f64::consts::E, 1.445_646_891_729_250_2e-16), 16.0);
        near(of(10.0, 0.0).ln(), of(core::f64::consts::LN_10, -2.170_756_223_382_249_4e-16), 16.0);
        near(of(1.0, 0.0).sin(), of(0.841_470_984_807_896_5, 1.776_845_092_935_536e-18), 16.0);
        near(of(1.0, 0.0).cos(), of(0.540_302_305_868_139_8, -4.760_954_612_604_417e-17), 16.0);
        // Where all parts of pi and of the logarithm of 2 count.
        near(of(1e9, 0.0).sin(), of(0.545_843_449_448_699_6, 6.175_733_356_664_077_5e-18), 16.0);
        near(of(600.0, 0.0).exp(), of(3.773_020_300_929_939_7e260, 1.611_693_410_923_224_7e244), 4.0);
        for number in [-600.0, -1.0, 0.1, 0.5, 30.0, 650.0] {
            let number = of(number, 0.0) + third.scaled(-60);
            near(number.exp().ln(), number, 16.0);
            let [sine, cosine] = [number.sin(), number.cos()];
            near(sine * sine + cosine * cosine, of(1.0, 0.0), 16.0);
            near((number + number).sin(), (sine + sine) * cosine, 64.0);
        }
        near(third.powf(of(3.0, 0.0)), third * third * third, 64.0);
        near((-third).powf(of(3.0, 0.0)), -(third * third * third), 64.0);
        near(DoubleDouble::from_product(0.1, 0.1), of(0.1, 0.0) * of(0.1, 0.0), 1.0);
        assert!(of(1.0, 1e-20) > of(1.0, 0.0) && of(1.0, -1e-20) < of(1.0, 0.0));
        assert_eq!((of(1.0, 1e-20) - of(1.0, 0.0)).to_f64(), 1e-20);
    }

    /// Beside f64, at the corners of both.
    #[test]
    fn results_are_those_of_f64_to_its_last_digits() {
        let numbers = [
            0.0,
            -0.0,
            1.0,
            -1.0,
            2.0,
            0.3,
            -2.7,
            1e-30,
            1e30,
            1e15,
            1e17,
            700.25,
            f64::INFINITY,
            -f64::INFINITY,
            f64::NAN,
        ];
        fn results<R: Real>(a: R, b: R) -> [R; 15] {
            let (one, zero) = (R::lit(1.0), R::lit(0.0));
            let ordered = R::select(a.less(b) | a.equal(b), one, zero);
            let all =
                [a + b, a - b, a * b, a / b, -a, a.abs(), a.sqrt(), a.min(b), a.max(b), a.sin(), a.cos(), a.exp()];
            let [a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11] = all;
            [a0, a1, a2, a3, a4, a5, a6, a7, a8, a9, a10, a11, a.ln(), a.powf(b), ordered]
        }
        for a in numbers {
            for b in numbers {
                let found = results(DoubleDouble::from_f64(a), DoubleDouble::from_f64(b));
                for (number, (found, expected)) in found.iter().zip(results(a, b)).enumerate() {
                    let [found, off] = [found.to_f64(), (found.to_f64() - expected).abs()];
                    let same =
                        found == expected && (found != 0.0 || found.is_sign_negative() == expected.is_sign_negative());
                    let near = off <= 4.0 * f64::EPSILON * expected.abs();
                    assert!(
                        same || near && found != 0.0 || found.is_nan() && expected.is_nan(),
                        "{number} of {a:e}, {b:e}: {found:e} {expected:e}"
                    );
                }
            }
            let parts = DoubleDouble::from_f64(a);
            let again = DoubleDouble::from_parts(parts.to_f64(), parts.rest());
            assert!(again.bits() == parts.bits() || a.is_nan(), "{a:e}");
        }
    }

    #[test]
    fn where_f64_has_no_number_the_result_is_that_of_f64() {
        let [zero, one, infinity] = [0.0, 1.0, f64::INFINITY].map(DoubleDouble::from_f64);
        assert_eq!((one / zero).to_f64(), f64::INFINITY);
        assert_eq!((-one / zero).to_f64(), f64::NEG_INFINITY);
        assert_eq!((one / infinity).to_f64(), 0.0);
        assert_eq!((one + infinity).to_f64(), f64::INFINITY);
        assert_eq!((infinity * infinity).to_f64(), f64::INFINITY);
        assert_eq!(zero.sqrt().to_f64(), 0.0);
        assert!((zero / zero).to_f64().is_nan() && (infinity - infinity).to_f64().is_nan());
        assert!((-one).sqrt().to_f64().is_nan() && !(one / zero).is_finite());
        assert_eq!(zero.ln().to_f64(), f64::NEG_INFINITY);
        assert_eq!(infinity.exp().to_f64(), f64::INFINITY);
    }
}
