//! One body, any numbers: lanes of every width give the bits of the scalar, and dual numbers give its derivative.

use crate::common::*;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};
use vesper::backend::Compile;
use vesper::law::Law;
use vesper::prelude::*;
use vesper::real::{Isa, Vec3 as PlainVec3};

fn hash<P: Precision>(law: impl Compile + Clone, rows: usize, isa: Isa, seed: u64) -> u64 {
    let builder = Engine::<P>::builder().domain(cloud(rows, seed)).domain(springs(rows)).isa(isa).step(0.01);
    let mut engine = builder.law(law).law(Motion).build().unwrap();
    engine.advance(0.03).unwrap();
    engine.state().hash()
}

fn same_in_every_width<P: Precision>() {
    assert!(Isa::available().len() >= 2, "there is always a scalar and a portable set");
    for rows in (1..20).chain([31, 32, 33, 63, 65]) {
        for isa in Isa::available() {
            let seed = rows as u64;
            let same = |name: &str, found: u64, scalar: u64| assert_eq!(found, scalar, "{name}, {isa:?}, {rows} rows");
            let scalar = hash::<P>(Gravity::default(), rows, Isa::Scalar, seed);
            same("pairs", hash::<P>(Gravity::default(), rows, isa, seed), scalar);
            same("rows", hash::<P>(Drag, rows, isa, seed), hash::<P>(Drag, rows, Isa::Scalar, seed));
            same("links", hash::<P>(Spring, rows, isa, seed), hash::<P>(Spring, rows, Isa::Scalar, seed));
        }
    }
}

#[test]
fn lanes_of_f64_give_the_bits_of_the_scalar() {
    same_in_every_width::<f64>();
}

#[test]
fn lanes_of_f32_give_the_bits_of_the_scalar() {
    same_in_every_width::<f32>();
}

/// A number and its derivative.
#[derive(Clone, Copy, Debug)]
struct Dual {
    value: f64,
    slope: f64,
}

impl Dual {
    /// A function's value and slope at this number.
    fn chain(self, value: f64, slope: f64) -> Self {
        Dual { value, slope: slope * self.slope }
    }
}

impl Add for Dual {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Dual { value: self.value + other.value, slope: self.slope + other.slope }
    }
}
impl Sub for Dual {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Dual { value: self.value - other.value, slope: self.slope - other.slope }
    }
}
impl Mul for Dual {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Dual { value: self.value * other.value, slope: self.slope * other.value + self.value * other.slope }
    }
}
impl Div for Dual {
    type Output = Self;
    fn div(self, by: Self) -> Self {
        let value = self.value / by.value;
        Dual { value, slope: (self.slope - value * by.slope) / by.value }
    }
}
impl Neg for Dual {
    type Output = Self;
    fn neg(self) -> Self {
        Dual { value: -self.value, slope: -self.slope }
    }
}
impl AddAssign for Dual {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}
impl SubAssign for Dual {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Real for Dual {
    type Vec3 = PlainVec3<Dual>;
    type Mask = bool;
    fn lit(value: f64) -> Self {
        Dual { value, slope: 0.0 }
    }
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.chain(root, 0.5 / root)
    }
    fn abs(self) -> Self {
        self.chain(self.value.abs(), self.value.signum())
    }
    fn min(self, other: Self) -> Self {
        if self.value < other.value { self } else { other }
    }
    fn max(self, other: Self) -> Self {
        if self.value > other.value { self } else { other }
    }
    fn sin(self) -> Self {
        self.chain(self.value.sin(), self.value.cos())
    }
    fn cos(self) -> Self {
        self.chain(self.value.cos(), -self.value.sin())
    }
    fn exp(self) -> Self {
        self.chain(self.value.exp(), self.value.exp())
    }
    fn ln(self) -> Self {
        self.chain(self.value.ln(), 1.0 / self.value)
    }
    fn powf(self, exponent: Self) -> Self {
        (exponent * self.ln()).exp()
    }
    fn less(self, other: Self) -> bool {
        self.value < other.value
    }
    fn less_or_equal(self, other: Self) -> bool {
        self.value <= other.value
    }
    fn equal(self, other: Self) -> bool {
        self.value == other.value
    }
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

/// What the row at `at` gets of a row at the origin, in any numbers.
fn pull<R: Real>(at: [R; 3]) -> [R; 3] {
    let law = Gravity { g: 6.5, softening: 0.25 }.body::<R>();
    let row = |position: R::Vec3, mass| GravityRow { position, mass: R::lit(mass) };
    let force = law.pair(row(R::Vec3::new(at[0], at[1], at[2]), 2.0), row(R::Vec3::zero(), 3.0));
    [force.x(), force.y(), force.z()]
}

#[test]
fn a_number_type_of_the_users_own_gives_the_derivative_of_a_body() {
    let mut random = Random(3);
    for _ in 0..100 {
        let (at, along) = (random.vector(), random.vector());
        let found = pull::<Dual>(core::array::from_fn(|c| Dual { value: at[c], slope: along[c] }));
        let step = 1e-5;
        let moved = |by: f64| pull::<f64>(core::array::from_fn(|c| at[c] + by * along[c]));
        let (ahead, behind, here) = (moved(step), moved(-step), moved(0.0));
        for c in 0..3 {
            let difference = (ahead[c] - behind[c]) / (2.0 * step);
            assert_eq!(found[c].value, here[c], "the values are those of f64");
            let scale = 1.0 + difference.abs() + found.iter().fold(0.0, |most: f64, found| most.max(found.slope.abs()));
            assert!((found[c].slope - difference).abs() < 1e-6 * scale, "{} against {difference}", found[c].slope);
        }
    }
}
