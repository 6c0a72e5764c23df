//! Numbers that a law body is written in.
//!
//! In: nothing. Out: [`Real`] and [`Vector`], the two traits a law may use, implemented for `f32`, `f64`,
//! SIMD lanes of them (one row per lane) and [`DoubleDouble`], and for [`Dual`], a number with its derivative. A law written against them runs unchanged in every one. Never: a loop over rows,
//! a column, a law.
//!
//! Comparisons give a mask, and [`Real::select`] takes one: a branch would decide for one row, while a lane type
//! holds several. Every operation rounds like the scalar one, so the width of the lanes never changes a result; but for laws that allow
//! estimates (`fused`).

mod double_double;
mod dual;
#[cfg_attr(
    not(any(target_arch = "x86_64", target_arch = "aarch64")),
    allow(dead_code, unused_macros, unused_imports, reason = "no lanes of this architecture have estimates")
)]
mod fused;
mod lanes;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(any(test, not(any(target_arch = "x86_64", target_arch = "aarch64"))))]
mod portable;
mod registers;
mod scalar;
mod vector;
#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(target_arch = "aarch64")]
use neon as baseline;
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
use portable as baseline;
#[cfg(target_arch = "x86_64")]
use x86 as baseline;

pub(crate) use lanes::MAX_WIDTH;
#[cfg(target_arch = "x86_64")]
pub(crate) use x86::prefetch;

/// Only where the processor's family has the instruction.
#[cfg(not(target_arch = "x86_64"))]
pub(crate) fn prefetch<P>(_from: *const P) {}
pub use double_double::DoubleDouble;
pub use dual::Dual;
pub use lanes::{Isa, Lanes, WithLanes};
pub(crate) use scalar::compiled_here;
pub use scalar::{InPrecision, Scalar};
pub use vector::Vec3;

use core::fmt::Debug;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// A real number, or several of them side by side: what a law computes with.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a number that laws compute with",
    note = "laws are generic: `impl<R: Real> RowLaw<R> for ...`; the numbers are f32, f64, lanes of them, and DoubleDouble"
)]
pub trait Real:
    Copy
    + Send
    + Sync
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// Three of these numbers: a vector in space.
    type Vec3: Vector<Self>;
    /// The answer of a comparison, one truth value per lane.
    type Mask: Mask;

    /// The number nearest to `value`, in every lane.
    fn lit(value: f64) -> Self;
    /// Square root, correctly rounded.
    fn sqrt(self) -> Self;
    /// One over the square root: `1 / sqrt(self)`, both correctly rounded; in a law that allows `estimates`, within two roundings of it.
    #[inline(always)]
    fn rsqrt(self) -> Self {
        Self::lit(1.0) / self.sqrt()
    }
    /// `self / (square * sqrt(square))`, each correctly rounded: the weight of an inverse-square law, for the square of a
    /// distance. In a law that allows `estimates` within three roundings of it, for less than half of the time.
    #[inline(always)]
    fn over_root_cubed(self, square: Self) -> Self {
        self / (square * square.sqrt())
    }
    /// Magnitude.
    fn abs(self) -> Self;
    /// The smaller of two; `other` where either is NaN.
    fn min(self, other: Self) -> Self;
    /// The larger of two; `other` where either is NaN.
    fn max(self, other: Self) -> Self;
    /// Sine of an angle in rad.
    fn sin(self) -> Self;
    /// Cosine of an angle in rad.
    fn cos(self) -> Self;
    /// The exponential function.
    fn exp(self) -> Self;
    /// The natural logarithm.
    fn ln(self) -> Self;
    /// `self` to the power of `exponent`.
    fn powf(self, exponent: Self) -> Self;

    /// Where `self < other`; false where either is NaN.
    fn less(self, other: Self) -> Self::Mask;
    /// Where `self <= other`; false where either is NaN.
    fn less_or_equal(self, other: Self) -> Self::Mask;
    /// Where `self == other`; false where either is NaN.
    fn equal(self, other: Self) -> Self::Mask;
    /// `yes` where the mask holds, `no` elsewhere. Both are computed.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// `yes` where the mask holds, `no` elsewhere, for vectors.
    #[inline(always)]
    fn select_vector(mask: Self::Mask, yes: Self::Vec3, no: Self::Vec3) -> Self::Vec3 {
        Self::Vec3::new(
            Self::select(mask, yes.x(), no.x()),
            Self::select(mask, yes.y(), no.y()),
            Self::select(mask, yes.z(), no.z()),
        )
    }
}

/// The answer of a comparison: one truth value per lane.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// The truth value of each lane, the first one in the lowest bit.
    fn bits(self) -> u32;
}
impl Mask for bool {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.into()
    }
}

/// A vector in space over the numbers `R`.
pub trait Vector<R>:
    Copy
    + Send
    + Sync
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Neg<Output = Self>
    + Mul<R, Output = Self>
    + Div<R, Output = Self>
    + AddAssign
    + SubAssign
    + 'static
where
    R: Real<Vec3 = Self>,
{
    /// The vector of three components.
    fn new(x: R, y: R, z: R) -> Self;
    /// First component.
    fn x(self) -> R;
    /// Second component.
    fn y(self) -> R;
    /// Third component.
    fn z(self) -> R;
    /// The null vector.
    #[inline(always)]
    fn zero() -> Self {
        Self::new(R::lit(0.0), R::lit(0.0), R::lit(0.0))
    }
    /// The vector nearest to `value`, in every lane.
    #[inline(always)]
    fn lit(value: glam::DVec3) -> Self {
        Self::new(R::lit(value.x), R::lit(value.y), R::lit(value.z))
    }
    /// Scalar product.
    #[inline(always)]
    fn dot(self, other: Self) -> R {
        self.x() * other.x() + self.y() * other.y() + self.z() * other.z()
    }
    /// Vector product.
    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        Self::new(
            self.y() * other.z() - self.z() * other.y(),
            self.z() * other.x() - self.x() * other.z(),
            self.x() * other.y() - self.y() * other.x(),
        )
    }
    /// Square of the length.
    #[inline(always)]
    fn length_squared(self) -> R {
        self.dot(self)
    }
    /// Length.
    #[inline(always)]
    fn length(self) -> R {
        self.length_squared().sqrt()
    }
}
