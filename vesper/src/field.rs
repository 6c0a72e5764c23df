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

    /// Whether it jumps between regions, each with a formula of its own. Integrators end their steps at the borders of such a
    /// field.
    fn has_regions(&self) -> bool {
        false
    }

    /// The region that a place is in; any numbers that tell them apart.
    fn region(&self, _position: P::Vec3) -> u64 {
        0
    }

    /// The value that the formula of a region gives, wherever the place is.
    fn sample_in(&self, _region: u64, position: P::Vec3, time: P) -> P::Vec3 {
        self.sample(position, time)
    }

    /// How deep inside of a region a place is, in m: the distance from its border, or a number that goes to zero as that
    /// does; below 0 outside.
    fn depth(&self, _region: u64, _position: P::Vec3) -> P {
        P::from_f64(1.0)
    }

    /// How fast the value that the formula of a region gives changes, as the place moves by `along` per unit of time: what
    /// implicit integrators and limits of steps ask. Without a formula, a central difference over the cube root of rounding
    /// times the distance from the origin (Dennis, Schnabel, Numerical Methods for Unconstrained Optimization and Nonlinear
    /// Equations, 5.4): give one where the field changes over much less than that.
    fn derivative(&self, region: u64, position: P::Vec3, along: P::Vec3, time: P) -> P::Vec3 {
        let [size, speed] = [position, along].map(|vector| vector.length().to_f64());
        if speed == 0.0 {
            return P::Vec3::zero();
        }
        let by = P::from_f64(P::EPSILON.cbrt() * if size > 0.0 { size } else { 1.0 } / speed);
        let value = |by: P| self.sample_in(region, position + along * by, time);
        (value(by) - value(-by)) / (by + by)
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

/// Boxes with a value each; 0 outside all, the sum where they overlap. Up to 64 of them, integrators end their steps at the
/// faces; of more, they go across them.
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
    fn derivative(&self, _region: u64, _position: P::Vec3, _along: P::Vec3, _time: P) -> P::Vec3 {
        P::Vec3::zero()
    }
}

impl FieldBox {
    fn holds(&self, at: [f64; 3]) -> bool {
        (0..3).all(|axis| self.min[axis] <= at[axis] && at[axis] < self.max[axis])
    }

    /// The distance from the nearest face, for a place inside; outside, less than 0, by the axis that is farthest off.
    fn depth(&self, at: [f64; 3]) -> f64 {
        let axis = |axis: usize| (at[axis] - self.min[axis]).min(self.max[axis] - at[axis]);
        (0..3).map(axis).fold(f64::INFINITY, f64::min)
    }
}

fn numbers<P: Scalar>(position: P::Vec3) -> [f64; 3] {
    [position.x(), position.y(), position.z()].map(P::to_f64)
}

impl<P: Scalar> Field<P> for Boxes {
    fn sample(&self, position: P::Vec3, _time: P) -> P::Vec3 {
        let at = numbers::<P>(position);
        let inside = self.boxes.iter().filter(|part| part.holds(at));
        inside.fold(P::Vec3::zero(), |sum, part| sum + vector::<P>(part.value))
    }

    fn derivative(&self, _region: u64, _position: P::Vec3, _along: P::Vec3, _time: P) -> P::Vec3 {
        P::Vec3::zero()
    }

    fn has_regions(&self) -> bool {
        !self.boxes.is_empty() && self.boxes.len() <= 64
    }

    /// A bit for each box that the place is in.
    fn region(&self, position: P::Vec3) -> u64 {
        let at = numbers::<P>(position);
        self.boxes.iter().enumerate().map(|(number, part)| u64::from(part.holds(at)) << number).sum()
    }

    fn sample_in(&self, region: u64, _position: P::Vec3, _time: P) -> P::Vec3 {
        let inside = self.boxes.iter().enumerate().filter(|(number, _)| region >> number & 1 == 1);
        inside.fold(P::Vec3::zero(), |sum, (_, part)| sum + vector::<P>(part.value))
    }

    fn depth(&self, region: u64, position: P::Vec3) -> P {
        let at = numbers::<P>(position);
        let depths = self.boxes.iter().enumerate().map(|(number, part)| {
            let depth = part.depth(at);
            if region >> number & 1 == 1 { depth } else { -depth }
        });
        P::from_f64(depths.fold(f64::INFINITY, f64::min).clamp(-1e300, 1e300))
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

    /// `(along - 3 n (n . along)) strength / r^3`
    fn derivative(&self, _region: u64, position: P::Vec3, along: P::Vec3, _time: P) -> P::Vec3 {
        let from = position - vector::<P>(self.at);
        let r2 = from.length_squared();
        if r2 == P::default() {
            return P::Vec3::zero();
        }
        let across = along - from * (P::lit(3.0) * from.dot(along) / r2);
        across * (P::from_f64(self.strength) / (r2 * r2.sqrt()))
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

    fn derivative(&self, region: u64, position: P::Vec3, along: P::Vec3, time: P) -> P::Vec3 {
        let each = self.points.iter().map(|point| Field::<P>::derivative(point, region, position, along, time));
        each.fold(P::Vec3::zero(), |sum, change| sum + change)
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

    fn derivative(&self, _region: u64, position: P::Vec3, along: P::Vec3, _time: P) -> P::Vec3 {
        let length = P::from_f64(self.length);
        let by = P::from_f64(self.value) / (length * length);
        let (z, rising) = (position.z(), along.z());
        let across = |place: P, moving: P| -(by * (rising * place + z * moving));
        P::Vec3::new(across(position.x(), along.x()), across(position.y(), along.y()), P::lit(2.0) * by * z * rising)
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

    /// `3 (n (m . a) + a (m . n) + m (n . a) - 5 n (m . n) (n . a)) / r^4` for `a = along`.
    fn derivative(&self, _region: u64, position: P::Vec3, along: P::Vec3, _time: P) -> P::Vec3 {
        let from = position - vector::<P>(self.at);
        let r2 = from.length_squared();
        if r2 == P::default() {
            return P::Vec3::zero();
        }
        let moment = vector::<P>(self.moment);
        let (through, rising) = (moment.dot(from), from.dot(along));
        let turned = from * moment.dot(along) + along * through + moment * rising;
        let stretched = from * (P::lit(5.0) * through * rising / r2);
        (turned - stretched) * (P::lit(3.0) / (r2 * r2 * r2.sqrt()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A field without its formula of derivatives.
    struct Plain<F>(F);

    impl<F: Field<f64>> Field<f64> for Plain<F> {
        fn sample(&self, position: glam::DVec3, time: f64) -> glam::DVec3 {
            self.0.sample(position, time)
        }
    }

    #[test]
    fn derivatives_of_stock_fields_are_those_of_differences() {
        fn check(field: impl Field<f64> + Clone) {
            let place = glam::DVec3::new(0.7, -0.4, 1.1);
            for along in [glam::DVec3::X, glam::DVec3::new(0.2, -3.0, 0.5), glam::DVec3::ZERO] {
                let exact = field.derivative(field.region(place), place, along, 0.0);
                let found = Plain(field.clone()).derivative(0, place, along, 0.0);
                assert!((exact - found).length() < 1e-8 * (1.0 + exact.length()), "{exact}, {found}");
            }
        }
        let point = Point { at: [0.1, 0.2, -0.3], strength: -2.0 };
        check(point);
        check(Points { points: vec![point, Point { at: [2.0, 0.0, 0.0], strength: 0.5 }] });
        check(Dipole { at: [0.1, 0.2, -0.3], moment: [0.4, -1.0, 2.0] });
        check(Bottle { value: 3.0, length: 0.8 });
        check(Uniform { value: [1.0, 2.0, 3.0] });
        let part = FieldBox { min: [-1.0; 3], max: [2.0; 3], value: [1.0, 0.0, 0.0] };
        check(Boxes { boxes: vec![part] });
    }
}
