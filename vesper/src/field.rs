//! Functions of position and time: what a law samples at the place of each row.
//!
//! In: a closure of the client, or a stock shape. Out: [`Field`]. Never: a row, a law.

use crate::real::{Scalar, Vector};

/// A vector as a function of position and time. Closures `|position, time| vector` are fields.
pub trait Field<P: Scalar>: Send + Sync + 'static {
    /// The value at a place, at a time in s.
    fn sample(&self, position: P::Vec3, time: P) -> P::Vec3;

    /// The value everywhere and always, if it is one: such a field costs nothing per row.
    fn uniform(&self) -> Option<P::Vec3> {
        None
    }

    /// The values at many places. One call for a block of rows, so that a closure behind a pointer costs little.
    fn sample_block(&self, [x, y, z]: [&[P]; 3], time: P, [to_x, to_y, to_z]: [&mut [P]; 3]) {
        for row in 0..x.len() {
            let value = self.sample(P::Vec3::new(x[row], y[row], z[row]), time);
            (to_x[row], to_y[row], to_z[row]) = (value.x(), value.y(), value.z());
        }
    }
}

impl<P: Scalar, F: Fn(P::Vec3, P) -> P::Vec3 + Send + Sync + 'static> Field<P> for F {
    fn sample(&self, position: P::Vec3, time: P) -> P::Vec3 {
        self(position, time)
    }
}

/// The same value everywhere and always.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniform {
    /// The value.
    pub value: [f64; 3],
}

/// Boxes with a value each; 0 outside all, the sum where they overlap.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Boxes {
    /// The boxes.
    pub boxes: Vec<FieldBox>,
}

/// One box: `min <= position < max`, component by component; infinite bounds are allowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FieldBox {
    /// Lower bounds, in m, inclusive.
    pub min: [f64; 3],
    /// Upper bounds, in m, exclusive.
    pub max: [f64; 3],
    /// The value inside.
    pub value: [f64; 3],
}

/// A central field: `strength * (position - at) / |position - at|^3`, 0 at the centre itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The centre, in m.
    pub at: [f64; 3],
    /// Value at a distance of 1 m, times m^2; positive points away from the centre.
    pub strength: f64,
}

/// The field of a dipole: `(3 n (m . n) - m) / r^3` with `n = (position - at) / r`; 0 at the centre itself.
///
/// Griffiths, Introduction to Electrodynamics, 4th ed., eq. 5.89, without its factor `mu_0 / 4 pi`: the moment has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dipole {
    /// The centre, in m.
    pub at: [f64; 3],
    /// The moment: value on the axis at a distance of 1 m, halved, times m^3.
    pub moment: [f64; 3],
}

/// The sum of central fields.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Points {
    /// The fields.
    pub points: Vec<Point>,
}

/// A field that is strongest at both ends of its axis, z, and holds what follows its lines between them:
/// `value * (-x z / length^2, -y z / length^2, 1 + z^2 / length^2)`, free of sources.
///
/// Chen, Introduction to Plasma Physics and Controlled Fusion, 3rd ed., 2.3.3, with the divergence taken to be 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bottle {
    /// The value at the origin, along z.
    pub value: f64,
    /// The distance along the axis at which it has doubled, in m.
    pub length: f64,
}

fn vector<P: Scalar>([x, y, z]: [f64; 3]) -> P::Vec3 {
    P::Vec3::new(P::from_f64(x), P::from_f64(y), P::from_f64(z))
}

impl<P: Scalar> Field<P> for Uniform {
    fn sample(&self, _position: P::Vec3, _time: P) -> P::Vec3 {
        vector::<P>(self.value)
    }
    fn uniform(&self) -> Option<P::Vec3> {
        Some(vector::<P>(self.value))
    }
}

impl<P: Scalar> Field<P> for Boxes {
    fn sample(&self, position: P::Vec3, _time: P) -> P::Vec3 {
        let at = [position.x(), position.y(), position.z()].map(P::to_f64);
        let mut sum = P::Vec3::zero();
        for part in &self.boxes {
            if (0..3).all(|axis| part.min[axis] <= at[axis] && at[axis] < part.max[axis]) {
                sum += vector::<P>(part.value);
            }
        }
        sum
    }
}

impl<P: Scalar> Field<P> for Point {
    fn sample(&self, position: P::Vec3, _time: P) -> P::Vec3 {
        let from = position - vector::<P>(self.at);
        let r2 = from.length_squared();
        if r2 == P::default() {
            return P::Vec3::zero();
        }
        from * (P::from_f64(self.strength) / (r2 * r2.sqrt()))
    }
}

impl<P: Scalar> Field<P> for Points {
    fn sample(&self, position: P::Vec3, time: P) -> P::Vec3 {
        let mut sum = P::Vec3::zero();
        for point in &self.points {
            sum += Field::<P>::sample(point, position, time);
        }
        sum
    }
}

impl<P: Scalar> Field<P> for Bottle {
    fn sample(&self, position: P::Vec3, _time: P) -> P::Vec3 {
        let (value, length) = (P::from_f64(self.value), P::from_f64(self.length));
        let (x, y, z) = (position.x(), position.y(), position.z());
        let square = length * length;
        let across = -(value * z / square);
        P::Vec3::new(across * x, across * y, value + value * z * z / square)
    }
}

impl<P: Scalar> Field<P> for Dipole {
    fn sample(&self, position: P::Vec3, _time: P) -> P::Vec3 {
        let from = position - vector::<P>(self.at);
        let r2 = from.length_squared();
        if r2 == P::default() {
            return P::Vec3::zero();
        }
        let moment = vector::<P>(self.moment);
        (from * (P::lit(3.0) * moment.dot(from) / r2) - moment) / (r2 * r2.sqrt())
    }
}
