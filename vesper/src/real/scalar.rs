//! `f32` and `f64`: one row at a time, and the precision a whole engine runs in.

use super::lanes::{Isa, Lanes, WithLanes};
use super::{Real, Vector};

/// The precision of a state: `f32` or `f64`. Both exist in one program, so that speed can be compared with error.
pub trait Scalar: Real + Lanes<Self> + PartialOrd + Default + core::fmt::Display + sealed::Sealed {
    /// "f32" or "f64".
    const NAME: &'static str;
    /// The distance from 1 to the next number.
    const EPSILON: f64;
    /// The nearest number of this precision.
    fn from_f64(value: f64) -> Self;
    /// The same number in f64, exactly.
    fn to_f64(self) -> f64;
    /// Neither NaN nor infinite.
    fn is_finite(self) -> bool;
    /// Its bits, for hashes and exact comparison.
    fn bits(self) -> u64;
    /// The one of two things that is made for this precision.
    fn choose<T: InPrecision>(single: impl FnOnce() -> T::Of<f32>, double: impl FnOnce() -> T::Of<f64>) -> T::Of<Self>;
    /// Runs `task` in the widest lanes of the instruction set `isa`.
    fn with_lanes<T: WithLanes<Self>>(isa: Isa, task: T) -> T::Output;
}

/// Something that there is for either precision.
pub trait InPrecision {
    /// It, for precision `P`.
    type Of<P: Scalar>;
}

/// A function of the precision that is compiled in this crate, once for `f32` and once for `f64`, and not again in every
/// program that calls it: an engine is thousands of functions, and most of what a short program would compile
/// (`cargo rustc --example first_law -- -Z time-passes` shows it on nightly).
macro_rules! compiled_here {
    (<$precision:ident> |$($argument:ident: $type:ty),+| -> $result:ty { $body:expr }) => {{
        use $crate::real::{InPrecision, Scalar};
        struct Either;
        impl InPrecision for Either {
            type Of<$precision: Scalar> = fn($($type),+) -> $result;
        }
        // What is not generic is compiled where it stands, if nobody inlines it.
        let single = || -> <Either as InPrecision>::Of<f32> {
            type $precision = f32;
            #[inline(never)]
            fn single($($argument: $type),+) -> $result {
                $body
            }
            single
        };
        let double = || -> <Either as InPrecision>::Of<f64> {
            type $precision = f64;
            #[inline(never)]
            fn double($($argument: $type),+) -> $result {
                $body
            }
            double
        };
        <$precision as Scalar>::choose::<Either>(single, double)
    }};
}
pub(crate) use compiled_here;

mod sealed {
    /// Keeps `Scalar` to the two precisions that the backends are made for.
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

macro_rules! scalar {
    ($scalar:ident, $vector:ty, $baseline:ident, $avx2:ident, $avx512:ident, |$single:ident, $double:ident| $chosen:ident) => {
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
            ) -> T::Of<Self> {
                let _ = (&$single, &$double);
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
        }
    };
}
scalar!(f32, glam::Vec3, BaselineF32, Avx2F32, Avx512F32, |single, double| single);
scalar!(f64, glam::DVec3, BaselineF64, Avx2F64, Avx512F64, |single, double| double);
