//! Several rows side by side: the lane trait, plain arrays that every processor can run, and the choice at run time.

use super::{Mask, Real, Vec3};
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};

/// The most lanes that there are.
pub(crate) const MAX_WIDTH: usize = 16;

/// A [`Real`] that holds `WIDTH` numbers of precision `P`, one row in each lane.
pub trait Lanes<P>: Real {
    /// Numbers side by side.
    const WIDTH: usize;
    /// Reads `WIDTH` neighbouring numbers.
    ///
    /// # Safety
    /// `from` points to `WIDTH` readable numbers; no alignment is needed.
    unsafe fn load(from: *const P) -> Self;
    /// Writes `WIDTH` neighbouring numbers.
    ///
    /// # Safety
    /// `to` points to `WIDTH` writable numbers; no alignment is needed.
    unsafe fn store(self, to: *mut P);
    /// The same number in every lane.
    fn splat(value: P) -> Self;
    /// Each lane from its index.
    fn from_lanes(lane: impl FnMut(usize) -> P) -> Self;
    /// The number in one lane.
    fn lane(self, index: usize) -> P;
}

/// Work that can be done in any lanes; a [`super::Scalar`] picks them and calls [`WithLanes::with`].
pub trait WithLanes<P> {
    /// What the work gives.
    type Output;
    /// Does the work in lanes of type `R`. Implementations must be `#[inline(always)]`, else the body is compiled
    /// without the instructions it was chosen for.
    fn with<R: Lanes<P>>(self) -> Self::Output;
}

/// An instruction set, chosen once at start from what the processor has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Isa {
    /// One row at a time: the reference that the others are compared with.
    Scalar,
    /// Arrays of numbers, vectorised as far as the compiler goes.
    Portable,
    /// x86-64 with AVX2: 256-bit registers, in pairs.
    #[cfg(target_arch = "x86_64")]
    #[non_exhaustive]
    Avx2,
    /// x86-64 with AVX-512: 512-bit registers.
    #[cfg(target_arch = "x86_64")]
    #[non_exhaustive]
    Avx512,
}

impl Isa {
    /// The widest that this processor has.
    pub fn detect() -> Isa {
        Isa::available().pop().unwrap_or(Isa::Scalar)
    }

    /// All that this processor has, narrowest first.
    pub fn available() -> Vec<Isa> {
        #[allow(unused_mut, reason = "only one architecture adds to it")]
        let mut sets = vec![Isa::Scalar, Isa::Portable];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                sets.push(Isa::Avx2);
            }
            if is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq") {
                sets.push(Isa::Avx512);
            }
        }
        sets
    }
}

/// `N` numbers in an array.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Array<P, const N: usize>([P; N]);

/// `N` truth values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ArrayMask<const N: usize>([bool; N]);

impl<const N: usize> Mask for ArrayMask<N> {}

impl<P: Copy, const N: usize> Array<P, N> {
    #[inline(always)]
    fn map(mut self, f: impl Fn(P) -> P) -> Self {
        for lane in &mut self.0 {
            *lane = f(*lane);
        }
        self
    }
    #[inline(always)]
    fn zip(mut self, other: Self, f: impl Fn(P, P) -> P) -> Self {
        for (lane, other) in self.0.iter_mut().zip(other.0) {
            *lane = f(*lane, other);
        }
        self
    }
    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(P, P) -> bool) -> ArrayMask<N> {
        ArrayMask(core::array::from_fn(|i| f(self.0[i], other.0[i])))
    }
}

macro_rules! array_operators {
    ($($operator:ident $method:ident,)*) => {$(
        impl<P: Copy + $operator<Output = P>, const N: usize> $operator for Array<P, N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.zip(other, P::$method)
            }
        }
    )*};
}
array_operators! { Add add, Sub sub, Mul mul, Div div, }

impl<P: Copy + Neg<Output = P>, const N: usize> Neg for Array<P, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(P::neg)
    }
}
impl<P: Copy + Add<Output = P>, const N: usize> AddAssign for Array<P, N> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl<P: Copy + Sub<Output = P>, const N: usize> SubAssign for Array<P, N> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
impl<const N: usize> BitAnd for ArrayMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        ArrayMask(core::array::from_fn(|i| self.0[i] & other.0[i]))
    }
}
impl<const N: usize> BitOr for ArrayMask<N> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        ArrayMask(core::array::from_fn(|i| self.0[i] | other.0[i]))
    }
}
impl<const N: usize> Not for ArrayMask<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        ArrayMask(self.0.map(|lane| !lane))
    }
}

impl<P: Real<Mask = bool>, const N: usize> Real for Array<P, N> {
    type Vec3 = Vec3<Self>;
    type Mask = ArrayMask<N>;
    #[inline(always)]
    fn lit(value: f64) -> Self {
        Array([P::lit(value); N])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(P::sqrt)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(P::abs)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, P::min)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, P::max)
    }
    fn sin(self) -> Self {
        self.map(P::sin)
    }
    fn cos(self) -> Self {
        self.map(P::cos)
    }
    fn exp(self) -> Self {
        self.map(P::exp)
    }
    fn ln(self) -> Self {
        self.map(P::ln)
    }
    fn powf(self, exponent: Self) -> Self {
        self.zip(exponent, P::powf)
    }
    #[inline(always)]
    fn less(self, other: Self) -> Self::Mask {
        self.compare(other, P::less)
    }
    #[inline(always)]
    fn less_or_equal(self, other: Self) -> Self::Mask {
        self.compare(other, P::less_or_equal)
    }
    #[inline(always)]
    fn equal(self, other: Self) -> Self::Mask {
        self.compare(other, P::equal)
    }
    #[inline(always)]
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self {
        Array(core::array::from_fn(|i| if mask.0[i] { yes.0[i] } else { no.0[i] }))
    }
}

impl<P: Real<Mask = bool>, const N: usize> Lanes<P> for Array<P, N> {
    const WIDTH: usize = N;
    #[inline(always)]
    unsafe fn load(from: *const P) -> Self {
        // SAFETY: the caller promises N readable numbers; an unaligned read needs no more.
        Array(unsafe { from.cast::<[P; N]>().read_unaligned() })
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut P) {
        // SAFETY: the caller promises N writable numbers; an unaligned write needs no more.
        unsafe { to.cast::<[P; N]>().write_unaligned(self.0) }
    }
    #[inline(always)]
    fn splat(value: P) -> Self {
        Array([value; N])
    }
    #[inline(always)]
    fn from_lanes(lane: impl FnMut(usize) -> P) -> Self {
        Array(core::array::from_fn(lane))
    }
    #[inline(always)]
    fn lane(self, index: usize) -> P {
        self.0[index]
    }
}
