//! `f32` and `f64`: one row at a time, and the precision a whole engine runs in, which may be [`DoubleDouble`], too.

use super::fused::Estimates;
use super::lanes::{Isa, Lanes, WithLanes};
use super::{DoubleDouble, Real, Vector};

/// The precision of a state: `f32`, `f64` or [`DoubleDouble`]. All exist in one program, so that speed can be compared with error.
pub trait Scalar: Real + Lanes<Self> + PartialOrd + Default + core::fmt::Display + sealed::Sealed {
    /// "f32", "f64" or "double-double".
    const NAME: &'static str;
    /// The distance from 1 to the next number, or what rounding makes it uncertain by.
    const EPSILON: f64;
    /// The nearest number of this precision.
    fn from_f64(value: f64) -> Self;
    /// The product of two, rounded to this precision: not to f64 before, where this has more digits.
    #[inline(always)]
    fn from_product(a: f64, b: f64) -> Self {
        Self::from_f64(a * b)
    }
    /// The nearest f64: the same number, unless it is a [`DoubleDouble`].
    fn to_f64(self) -> f64;
    /// What [`Scalar::to_f64`] leaves out.
    #[inline(always)]
    fn rest(self) -> f64 {
        0.0
    }
    /// The sum of a number and what it leaves out.
    #[inline(always)]
    fn from_parts(number: f64, _rest: f64) -> Self {
        Self::from_f64(number)
    }
    /// How many f64 hold one number.
    const PARTS: usize = 1;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
    /// Its bits, for hashes; where it has more than 64, all of them folded.
    fn bits(self) -> u64;
    /// The one of three things that is made for this precision.
    fn choose<T: InPrecision>(
        single: impl FnOnce() -> T::Of<f32>,
        double: impl FnOnce() -> T::Of<f64>,
        twice: impl FnOnce() -> T::Of<DoubleDouble>,
    ) -> T::Of<Self>;
    /// Runs `task` in the widest lanes of the instruction set `isa`.
    fn with_lanes<T: WithLanes<Self>>(isa: Isa, task: T) -> T::Output;
    /// The same for a law that allows `estimates`: in lanes that fuse products with sums and estimate roots, where `isa` has them.
    #[inline(always)]
    fn with_estimates<T: WithLanes<Self>>(isa: Isa, task: T) -> T::Output {
        Self::with_lanes(isa, task)
    }
}

/// Something that there is for each precision.
pub trait InPrecision {
    /// It, for precision `P`.
    type Of<P: Scalar>;
}

/// A function of the precision that is compiled in this crate, once for each precision, and not again in every
/// program that calls it: an engine is thousands of functions, and most of what a short program would compile
/// (`cargo rustc --example first_law -- -Z time-passes` shows it on nightly).
macro_rules! compiled_here {
    (<$precision:ident> |$($argument:ident: $type:ty),+| -> $result:ty { $body:expr }) => {{
        use $crate::real::{InPrecision, Scalar};
        struct Each;
        impl InPrecision for Each {
            type Of<$precision: Scalar> = fn($($type),+) -> $result;
        }
        // What is not generic is compiled where it stands, if nobody inlines it.
        let single = || -> <Each as InPrecision>::Of<f32> {
            type $precision = f32;
            #[inline(never)]
            fn single($($argument: $type),+) -> $result {
                $body
            }
            single
        };
        let double = || -> <Each as InPrecision>::Of<f64> {
            type $precision = f64;
            #[inline(never)]
            fn double($($argument: $type),+) -> $result {
                $body
            }
            double
        };
        let twice = || -> <Each as InPrecision>::Of<$crate::real::DoubleDouble> {
            type $precision = $crate::real::DoubleDouble;
            #[inline(never)]
            fn twice($($argument: $type),+) -> $result {
                $body
            }
            twice
        };
        <$precision as Scalar>::choose::<Each>(single, double, twice)
    }};
}
pub(crate) use compiled_here;

mod sealed {
    /// Keeps `Scalar` to the precisions that the backends are made for.
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
    impl Sealed for super::DoubleDouble {}
}

macro_rules! scalar {
    ($scalar:ident, $vector:ty, $baseline:ident, $avx2:ident, $avx512:ident, |$single:ident, $double:ident, $twice:ident| $chosen:ident) => {
        impl Real for $scalar {
            type Vec3 = $vector;
            type Mask = bool;
            #[inline(always)]
            fn lit(value: f64) -> Self {
                value as $scalar
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $scalar::sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $scalar::abs(self)
            }
            // Not `f64::min`: this form is what the vector instructions compute, NaN included.
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            fn sin(self) -> Self {
                $scalar::sin(self)
            }
            fn cos(self) -> Self {
                $scalar::cos(self)
            }
            fn exp(self) -> Self {
                $scalar::exp(self)
            }
            fn ln(self) -> Self {
                $scalar::ln(self)
            }
            fn powf(self, exponent: Self) -> Self {
                $scalar::powf(self, exponent)
            }
            #[inline(always)]
            fn less(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn less_or_equal(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn equal(self, other: Self) -> bool {
                self == other
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
        }

        impl Vector<$scalar> for $vector {
            #[inline(always)]
            fn new(x: $scalar, y: $scalar, z: $scalar) -> Self {
                <$vector>::new(x, y, z)
            }
            #[inline(always)]
            fn x(self) -> $scalar {
                self.x
            }
            #[inline(always)]
            fn y(self) -> $scalar {
                self.y
            }
            #[inline(always)]
            fn z(self) -> $scalar {
                self.z
            }
        }

        impl Lanes<$scalar> for $scalar {
            const WIDTH: usize = 1;
            type Narrow = $scalar;
            #[inline(always)]
            unsafe fn load(from: *const $scalar) -> Self {
                // SAFETY: the caller promises one readable number at `from`.
                unsafe { *from }
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $scalar) {
                // SAFETY: the caller promises one writable number at `to`.
                unsafe { *to = self }
            }
            #[inline(always)]
            fn splat(value: $scalar) -> Self {
                value
            }
            #[inline(always)]
            fn from_lanes(mut lane: impl FnMut(usize) -> $scalar) -> Self {
                lane(0)
            }
            #[inline(always)]
            fn lane(self, _index: usize) -> $scalar {
                self
            }
            #[inline(always)]
            fn sum(self) -> Self {
                self
            }
        }

        impl Estimates<$scalar> for $scalar {
            type Half = $scalar;
            const TERMS: usize = 0;
            #[inline(always)]
            fn fused_add(self, factor: Self, term: Self) -> Self {
                self.mul_add(factor, term)
            }
            #[inline(always)]
            fn fused_sub(self, factor: Self, term: Self) -> Self {
                self.mul_add(factor, -term)
            }
            #[inline(always)]
            fn fused_from(self, factor: Self, term: Self) -> Self {
                (-self).mul_add(factor, term)
            }
            #[inline(always)]
            fn estimate(self) -> Self {
                self.rsqrt()
            }
        }

        impl Scalar for $scalar {
            const NAME: &'static str = stringify!($scalar);
            const EPSILON: f64 = $scalar::EPSILON as f64;
            #[inline(always)]
            fn from_f64(value: f64) -> Self {
                value as $scalar
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                $scalar::is_finite(self)
            }
            fn bits(self) -> u64 {
                self.to_bits().into()
            }
            fn choose<T: InPrecision>(
                $single: impl FnOnce() -> T::Of<f32>,
                $double: impl FnOnce() -> T::Of<f64>,
                $twice: impl FnOnce() -> T::Of<DoubleDouble>,
            ) -> T::Of<Self> {
                let _ = (&$single, &$double, &$twice);
                $chosen()
            }
            #[inline(always)]
            fn with_lanes<T: WithLanes<Self>>(isa: Isa, task: T) -> T::Output {
                match isa {
                    Isa::Scalar => task.with::<$scalar>(),
                    Isa::Baseline => task.with::<super::baseline::$baseline>(),
                    // SAFETY: only `Isa::detect` and `Isa::available` give these out, after asking the processor.
                    #[cfg(target_arch = "x86_64")]
                    Isa::Avx2 => unsafe { super::x86::avx2::<$scalar, super::x86::$avx2, T>(task) },
                    // SAFETY: as above.
                    #[cfg(target_arch = "x86_64")]
                    Isa::Avx512 => unsafe { super::x86::avx512::<$scalar, super::x86::$avx512, T>(task) },
                }
            }
            #[inline(always)]
            fn with_estimates<T: WithLanes<Self>>(isa: Isa, task: T) -> T::Output {
                // Not imported: not every architecture has lanes that estimate.
                match isa {
                    // SAFETY: as above.
                    #[cfg(target_arch = "x86_64")]
                    Isa::Avx2 => unsafe {
                        super::x86::avx2::<$scalar, super::fused::Fused<$scalar, super::x86::$avx2>, T>(task)
                    },
                    // SAFETY: as above.
                    #[cfg(target_arch = "x86_64")]
                    Isa::Avx512 => unsafe {
                        super::x86::avx512::<$scalar, super::fused::Fused<$scalar, super::x86::$avx512>, T>(task)
                    },
                    #[cfg(target_arch = "aarch64")]
                    Isa::Baseline => task.with::<super::fused::Fused<$scalar, super::neon::$baseline>>(),
                    #[cfg(not(target_arch = "aarch64"))]
                    Isa::Baseline => Self::with_lanes(isa, task),
                    Isa::Scalar => Self::with_lanes(isa, task),
                }
            }
        }
    };
}
scalar!(f32, glam::Vec3, BaselineF32, Avx2F32, Avx512F32, |single, double, twice| single);
scalar!(f64, glam::DVec3, BaselineF64, Avx2F64, Avx512F64, |single, double, twice| double);
