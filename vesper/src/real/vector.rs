//! A plain vector of three, for the numbers that have no vector type of their own.

use super::{Real, Vector};
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Three numbers: the vector type of lanes, and of any other [`Real`] without one of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vec3<R> {
    /// First component.
    pub x: R,
    /// Second component.
    pub y: R,
    /// Third component.
    pub z: R,
}

macro_rules! componentwise {
    ($($operator:ident $method:ident,)*) => {$(
        impl<R: $operator<Output = R>> $operator for Vec3<R> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Vec3 { x: self.x.$method(other.x), y: self.y.$method(other.y), z: self.z.$method(other.z) }
            }
        }
    )*};
}
componentwise! { Add add, Sub sub, }

macro_rules! by_scalar {
    ($($operator:ident $method:ident,)*) => {$(
        impl<R: Copy + $operator<Output = R>> $operator<R> for Vec3<R> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, by: R) -> Self {
                Vec3 { x: self.x.$method(by), y: self.y.$method(by), z: self.z.$method(by) }
            }
        }
    )*};
}
by_scalar! { Mul mul, Div div, }

impl<R: Neg<Output = R>> Neg for Vec3<R> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Vec3 { x: -self.x, y: -self.y, z: -self.z }
    }
}
impl<R: Copy + Add<Output = R>> AddAssign for Vec3<R> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl<R: Copy + Sub<Output = R>> SubAssign for Vec3<R> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
impl<R: Real<Vec3 = Self>> Vector<R> for Vec3<R> {
    #[inline(always)]
    fn new(x: R, y: R, z: R) -> Self {
        Vec3 { x, y, z }
    }
    #[inline(always)]
    fn x(self) -> R {
        self.x
    }
    #[inline(always)]
    fn y(self) -> R {
        self.y
    }
    #[inline(always)]
    fn z(self) -> R {
        self.z
    }
}
