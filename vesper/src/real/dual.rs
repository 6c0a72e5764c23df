//! Dual numbers: a number and its derivative along one direction, so that a law's body, unchanged, gives the exact
//! derivative of what it computes.
//!
//! Where a function has a corner or an infinite slope, the derivative is one that its neighbours have, or their mean: 0 for
//! the root and the magnitude of 0, so that the length of a null vector, which laws multiply by the vector itself, spoils no
//! product; that of the branch taken for `min`, `max` and `select`.
//!
//! Source: Griewank, Walther, Evaluating Derivatives, 2nd ed., SIAM 2008, chapter 3, the forward mode.

use super::{Real, Vec3};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A number and its derivative along a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dual<R> {
    /// The number.
    pub value: R,
    /// Its derivative.
    pub derivative: R,
}

impl<R: Real> Dual<R> {
    /// A number with its derivative.
    #[inline(always)]
    pub fn new(value: R, derivative: R) -> Self {
        Dual { value, derivative }
    }

    /// A number that does not change.
    #[inline(always)]
    pub fn constant(value: R) -> Self {
        Dual { value, derivative: R::lit(0.0) }
    }

    /// A function of it: its value there, and its slope.
    #[inline(always)]
    fn chain(self, value: R, slope: R) -> Self {
        Dual { value, derivative: slope * self.derivative }
    }
}

/// `yes`, or 0 where `zero` is 0, whatever `yes` is then.
#[inline(always)]
fn unless_zero<R: Real>(zero: R, yes: R) -> R {
    R::select(zero.equal(R::lit(0.0)), R::lit(0.0), yes)
}

impl<R: Real> Add for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Dual { value: self.value + other.value, derivative: self.derivative + other.derivative }
    }
}

impl<R: Real> Sub for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Dual { value: self.value - other.value, derivative: self.derivative - other.derivative }
    }
}

impl<R: Real> Mul for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        let derivative = self.derivative * other.value + self.value * other.derivative;
        Dual { value: self.value * other.value, derivative }
    }
}

impl<R: Real> Div for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let value = self.value / other.value;
        Dual { value, derivative: (self.derivative - value * other.derivative) / other.value }
    }
}

impl<R: Real> Neg for Dual<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Dual { value: -self.value, derivative: -self.derivative }
    }
}

impl<R: Real> AddAssign for Dual<R> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<R: Real> SubAssign for Dual<R> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<R: Real> Real for Dual<R> {
    type Vec3 = Vec3<Self>;
    type Mask = R::Mask;

    #[inline(always)]
    fn lit(value: f64) -> Self {
        Dual::constant(R::lit(value))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, unless_zero(root, R::lit(0.5) / root))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        let (zero, one) = (R::lit(0.0), R::lit(1.0));
        let sign = R::select(self.value.less(zero), -one, R::select(zero.less(self.value), one, zero));
        self.chain(self.value.abs(), sign)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        Self::select(self.value.less(other.value), self, other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::select(other.value.less(self.value), self, other)
    }
    fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }
    fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }
    fn exp(self) -> Self {
        let value = self.value.exp();
        self.chain(value, value)
    }
    fn ln(self) -> Self {
        self.chain(self.value.ln(), R::lit(1.0) / self.value)
    }
    fn powf(self, exponent: Self) -> Self {
        let value = self.value.powf(exponent.value);
        // x^p changes with x by p x^(p-1), and with p by x^p ln x; neither counts where that one does not change.
        let slope = exponent.value * self.value.powf(exponent.value - R::lit(1.0));
        let by_base = unless_zero(exponent.value, unless_zero(self.derivative, slope * self.derivative));
        let growth = unless_zero(value, value * self.value.ln());
        let by_exponent = unless_zero(exponent.derivative, growth * exponent.derivative);
        Dual { value, derivative: by_base + by_exponent }
    }

    #[inline(always)]
    fn less(self, other: Self) -> Self::Mask {
        self.value.less(other.value)
    }
    #[inline(always)]
    fn less_or_equal(self, other: Self) -> Self::Mask {
        self.value.less_or_equal(other.value)
    }
    #[inline(always)]
    fn equal(self, other: Self) -> Self::Mask {
        self.value.equal(other.value)
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Dual { value: R::select(mask, yes.value, no.value), derivative: R::select(mask, yes.derivative, no.derivative) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Scalar, Vector as _};
    use super::*;

    /// A function of two numbers, in any numbers.
    macro_rules! functions {
        ($($name:literal: |$a:ident, $b:ident| $body:expr, $by_a:expr, $by_b:expr;)*) => {
            /// Each: its name, over duals, over plain numbers, and its derivatives by either argument in closed form.
            fn functions<P: Scalar>() -> Vec<Function<P>> {
                vec![$((
                    $name,
                    (|$a: Dual<P>, $b: Dual<P>| $body) as fn(Dual<P>, Dual<P>) -> Dual<P>,
                    (|$a: f64, $b: f64| $body) as fn(f64, f64) -> f64,
                    (|$a: f64, $b: f64| {
                        _ = ($a, $b);
                        [$by_a, $by_b]
                    }) as fn(f64, f64) -> [f64; 2],
                )),*]
            }
        };
    }
    type Function<P> = (&'static str, fn(Dual<P>, Dual<P>) -> Dual<P>, fn(f64, f64) -> f64, fn(f64, f64) -> [f64; 2]);

    functions! {
        "add": |a, b| a + b, 1.0, 1.0;
        "sub": |a, b| a - b, 1.0, -1.0;
        "mul": |a, b| a * b, b, a;
        "div": |a, b| a / b, 1.0 / b, -a / (b * b);
        "neg": |a, _b| -a, -1.0, 0.0;
        "add_assign": |a, b| { let mut sum = a; sum += b * b; sum }, 1.0, 2.0 * b;
        "sub_assign": |a, b| { let mut rest = a; rest -= b * b; rest }, 1.0, -2.0 * b;
        "sqrt": |a, b| Real::sqrt(Real::abs(a * b)), 0.5 * (b / a).abs().sqrt() * a.signum(),
            0.5 * (a / b).abs().sqrt() * b.signum();
        "rsqrt": |a, _b| Real::rsqrt(Real::abs(a)), -0.5 * a.signum() * a.abs().powf(-1.5), 0.0;
        "over_root_cubed": |a, b| Real::over_root_cubed(a, b * b + a * a), (b * b - 2.0 * a * a) * (a * a + b * b).powf(-2.5),
            -3.0 * a * b * (a * a + b * b).powf(-2.5);
        "abs": |a, b| Real::abs(a) * b, a.signum() * b, a.abs();
        "min": |a, b| Real::min(a, b), f64::from(a < b), f64::from(a >= b);
        "max": |a, b| Real::max(a, b), f64::from(a > b), f64::from(a <= b);
        "sin": |a, b| Real::sin(a * b), b * (a * b).cos(), a * (a * b).cos();
        "cos": |a, b| Real::cos(a * b), -b * (a * b).sin(), -a * (a * b).sin();
        "exp": |a, b| Real::exp(a + b), (a + b).exp(), (a + b).exp();
        "ln": |a, b| Real::ln(Real::abs(a)) * b, b / a, a.abs().ln();
        "powf": |a, b| Real::powf(Real::abs(a), b), a.signum() * b * a.abs().powf(b - 1.0),
            a.abs().powf(b) * a.abs().ln();
        "select": |a, b| Real::select(Real::less(a, b), a * a, b * b),
            if a < b { 2.0 * a } else { 0.0 }, if a < b { 0.0 } else { 2.0 * b };
    }

    fn agrees<P: Scalar>(tolerance: f64, by_difference: f64) {
        for (name, dual, plain, closed) in functions::<P>() {
            for (a, b) in [(0.7, 1.9), (-1.3, 0.4), (2.5, -0.8), (-0.6, -1.1)] {
                for along in [[1.0, 0.0], [0.0, 1.0], [0.3, -2.0]] {
                    let [p, q] = [(a, along[0]), (b, along[1])]
                        .map(|(value, derivative)| Dual::new(P::from_f64(value), P::from_f64(derivative)));
                    let found = dual(p, q);
                    let [by_a, by_b] = closed(a, b);
                    let expected = by_a * along[0] + by_b * along[1];
                    let size = 1.0 + (by_a * along[0]).abs() + (by_b * along[1]).abs();
                    let off = (found.derivative.to_f64() - expected).abs() / size;
                    assert!(off < tolerance, "{name} at {a}, {b} along {along:?}: {found:?}, {expected}");
                    assert!((found.value.to_f64() - plain(a, b)).abs() < tolerance * (1.0 + plain(a, b).abs()));
                    let h = 6e-6;
                    let at = |h: f64| plain(a + h * along[0], b + h * along[1]);
                    let difference = (at(h) - at(-h)) / (2.0 * h);
                    assert!(
                        (found.derivative.to_f64() - difference).abs() < by_difference * size,
                        "{name}: {difference}"
                    );
                }
            }
        }
    }

    #[test]
    fn every_function_has_its_derivative() {
        agrees::<f64>(2e-15, 1e-9);
        agrees::<f32>(2e-6, 2e-6);
    }

    #[test]
    fn corners_give_numbers() {
        let zero = Dual::new(0.0, 1.0);
        assert_eq!([zero.sqrt().derivative, zero.abs().derivative], [0.0, 0.0]);
        // |v| v has the derivative 0 at rest.
        let rest = Vec3::<Dual<f64>>::new(zero, zero, Dual::constant(0.0));
        assert_eq!((rest * rest.length()).x.derivative, 0.0);
        // Powers of 0, and of numbers below 0 with a whole exponent.
        assert_eq!(zero.powf(Dual::constant(2.0)), Dual::new(0.0, 0.0));
        assert_eq!(zero.powf(Dual::constant(1.0)), Dual::new(0.0, 1.0));
        assert_eq!(zero.powf(Dual::constant(0.0)), Dual::new(1.0, 0.0));
        assert_eq!(Dual::new(-2.0, 1.0).powf(Dual::constant(3.0)), Dual::new(-8.0, 12.0));
        assert_eq!(Dual::constant(0.0).powf(Dual::constant(0.5)), Dual::new(0.0, 0.0));
    }

    #[test]
    fn vectors_have_the_derivatives_of_their_products() {
        let vector = |value: [f64; 3], along: [f64; 3]| {
            let number = |c: usize| Dual::new(value[c], along[c]);
            Vec3::<Dual<f64>>::new(number(0), number(1), number(2))
        };
        let (a, b) = (vector([1.0, 2.0, 3.0], [1.0, 0.0, 0.0]), vector([-1.0, 0.5, 2.0], [0.0, 0.0, 1.0]));
        // (a . b)' = a' . b + a . b', (a x b)' = a' x b + a x b'
        assert_eq!(a.dot(b).derivative, -1.0 + 3.0);
        let cross = a.cross(b);
        assert_eq!([cross.x, cross.y, cross.z].map(|c| c.derivative), [2.0, -2.0 - 1.0, 0.5]);
        assert_eq!(a.length().derivative, 1.0 / 14.0_f64.sqrt());
    }
}
