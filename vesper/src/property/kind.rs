//! Scalar, vector, quaternion, link: how many numbers a property has and which value a kernel gets.

use crate::real::{Real, Vector as _};
use core::fmt;

/// The kind of a property, as data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// One number.
    Scalar,
    /// Three numbers: x, y, z.
    Vector,
    /// Four numbers: x, y, z, w.
    Quaternion,
    /// This many rows of another domain.
    Link(usize),
}

impl Kind {
    /// Numbers (or rows) in one value.
    pub const fn width(self) -> usize {
        match self {
            Kind::Scalar => 1,
            Kind::Vector => 3,
            Kind::Quaternion => 4,
            Kind::Link(arity) => arity,
        }
    }

    /// Whether the two are the same kind, in constant evaluation too.
    pub const fn same_as(self, other: Kind) -> bool {
        matches!(
            (self, other),
            (Kind::Scalar, Kind::Scalar) | (Kind::Vector, Kind::Vector) | (Kind::Quaternion, Kind::Quaternion)
        ) || matches!((self, other), (Kind::Link(a), Kind::Link(b)) if a == b)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Kind::Scalar => write!(f, "scalar"),
            Kind::Vector => write!(f, "vector"),
            Kind::Quaternion => write!(f, "quaternion"),
            Kind::Link(arity) => write!(f, "link to {arity} rows"),
        }
    }
}

/// A kind at the level of types: [`Scalar`], [`Vector`], [`Quaternion`] or [`Link`].
pub trait KindOf: Copy + Send + Sync + 'static {
    /// The kind as data.
    const KIND: Kind;
}

/// A kind whose values are numbers that a kernel computes with: all but [`Link`].
#[diagnostic::on_unimplemented(
    message = "a kernel cannot compute with a value of kind `{Self}`",
    note = "a link is declared as `link(ends: Ends, reads(..), adds(..))`; its rows are gathered for the kernel"
)]
pub trait Numeric: KindOf {
    /// What a kernel over the numbers `R` gets and gives.
    type Value<R: Real>: Copy + Send + Sync + fmt::Debug + 'static;
    /// A value from its components.
    fn from_components<R: Real>(components: impl Give<R>) -> Self::Value<R>;
    /// A value's components, in order.
    fn each_component<R: Real>(value: Self::Value<R>, components: impl Take<R>);
}

/// Gives components by their number. Closures do; lanes need a type of their own, whose method is always inlined: a
/// closure cannot be told to be, and what is not inlined is compiled without the instructions of the lanes.
pub trait Give<R> {
    /// The component of this number; asked for in order.
    fn give(&mut self, component: usize) -> R;
}
impl<R, F: FnMut(usize) -> R> Give<R> for F {
    #[inline(always)]
    fn give(&mut self, component: usize) -> R {
        self(component)
    }
}

/// Takes components and their numbers. Closures do; see [`Give`].
pub trait Take<R> {
    /// The component of this number; offered in order.
    fn take(&mut self, component: usize, number: R);
}
impl<R, F: FnMut(usize, R)> Take<R> for F {
    #[inline(always)]
    fn take(&mut self, component: usize, number: R) {
        self(component, number);
    }
}

/// One number.
#[derive(Clone, Copy, Debug)]
pub struct Scalar;
/// Three numbers.
#[derive(Clone, Copy, Debug)]
pub struct Vector;
/// Four numbers.
#[derive(Clone, Copy, Debug)]
pub struct Quaternion;
/// `N` rows of another domain.
#[derive(Clone, Copy, Debug)]
pub struct Link<const N: usize>;

impl KindOf for Scalar {
    const KIND: Kind = Kind::Scalar;
}
impl KindOf for Vector {
    const KIND: Kind = Kind::Vector;
}
impl KindOf for Quaternion {
    const KIND: Kind = Kind::Quaternion;
}
impl<const N: usize> KindOf for Link<N> {
    const KIND: Kind = Kind::Link(N);
}

impl Numeric for Scalar {
    type Value<R: Real> = R;
    #[inline(always)]
    fn from_components<R: Real>(mut components: impl Give<R>) -> R {
        components.give(0)
    }
    #[inline(always)]
    fn each_component<R: Real>(value: R, mut components: impl Take<R>) {
        components.take(0, value);
    }
}
impl Numeric for Vector {
    type Value<R: Real> = R::Vec3;
    #[inline(always)]
    fn from_components<R: Real>(mut components: impl Give<R>) -> R::Vec3 {
        let (x, y, z) = (components.give(0), components.give(1), components.give(2));
        R::Vec3::new(x, y, z)
    }
    #[inline(always)]
    fn each_component<R: Real>(value: R::Vec3, mut components: impl Take<R>) {
        components.take(0, value.x());
        components.take(1, value.y());
        components.take(2, value.z());
    }
}
impl Numeric for Quaternion {
    type Value<R: Real> = [R; 4];
    #[inline(always)]
    fn from_components<R: Real>(mut components: impl Give<R>) -> [R; 4] {
        [components.give(0), components.give(1), components.give(2), components.give(3)]
    }
    #[inline(always)]
    fn each_component<R: Real>([x, y, z, w]: [R; 4], mut components: impl Take<R>) {
        components.take(0, x);
        components.take(1, y);
        components.take(2, z);
        components.take(3, w);
    }
}
