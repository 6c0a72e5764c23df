//! The bodies that are moved, from a fixed seed, and the laws that move them.

use crate::Random;
use vesper::prelude::*;

/// Acceleration of free fall, in m/s^2.
pub const GRAVITY: [f64; 3] = [0.0, 0.0, -9.8125];
/// Electric field, in V/m.
pub const ELECTRIC: [f64; 3] = [0.5, -0.25, 2.0];
/// Magnetic flux density, in T.
pub const MAGNETIC: [f64; 3] = [0.25, 0.5, 1.0];
/// Step of the row laws, in s.
pub const STEP: f64 = 1.0 / 1024.0;

/// Charged bodies in a viscous medium; one in 64 is immovable.
#[derive(Clone, Debug, Default)]
pub struct Bodies {
    /// Places, in m.
    pub position: Vec<[f64; 3]>,
    /// Velocities, in m/s.
    pub velocity: Vec<[f64; 3]>,
    /// Masses, in kg.
    pub mass: Vec<f64>,
    /// Charges, in C.
    pub charge: Vec<f64>,
    /// Coefficients of drag, in kg/s.
    pub drag: Vec<f64>,
}

impl Bodies {
    /// `count` bodies in a cube of 20 m.
    pub fn new(count: usize) -> Self {
        let mut random = Random::new(1);
        let mut bodies = Bodies::default();
        for row in 0..count {
            bodies.position.push(random.vector(-10.0, 10.0));
            bodies.velocity.push(random.vector(-1.0, 1.0));
            bodies.mass.push(if row % 64 == 63 { 0.0 } else { random.between(1.0, 2.0) });
            bodies.charge.push(random.between(-1.0, 1.0));
            bodies.drag.push(random.between(0.25, 0.75));
        }
        bodies
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.mass.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.mass.is_empty()
    }

    /// With all columns.
    pub fn domain<P: Precision>(&self) -> Domain<P> {
        self.moving().with(Charge, &self.charge).with(DragCoefficient, &self.drag)
    }

    /// With place, velocity and mass.
    pub fn moving<P: Precision>(&self) -> Domain<P> {
        Domain::new("bodies").with(Position, &self.position).with(Velocity, &self.velocity).with(Mass, &self.mass)
    }
}

/// How bodies are distributed in space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A Plummer sphere with G = M = a = 1, cut off at 10 a.
    Plummer,
    /// A galaxy's disc: its density falls as exp(-R), cut off at 8, and as sech^2(z / 0.1).
    Disc,
    /// Everywhere in a cube of edge 2 alike.
    Uniform,
    /// Two Plummer spheres, 1000 a apart.
    Clusters,
    /// On a straight line of length 2, which lies across all axes.
    Line,
    /// On a sphere of radius 1.
    Shell,
    /// All but one at the same point.
    Point,
}

impl Shape {
    /// All of them, each with a word for it.
    pub const ALL: [(&'static str, Shape); 7] = [
        ("Plummer sphere", Shape::Plummer),
        ("galaxy disc", Shape::Disc),
        ("uniform cube", Shape::Uniform),
        ("two clusters", Shape::Clusters),
        ("line", Shape::Line),
        ("shell", Shape::Shell),
        ("all but one at a point", Shape::Point),
    ];

    /// The place of the body of this number.
    fn place(self, body: usize, random: &mut Random) -> [f64; 3] {
        match self {
            Shape::Plummer => loop {
                // The share of the mass within r is (1 + 1 / r^2)^(-3/2).
                let r = 1.0 / (random.between(1e-6, 1.0).powf(-2.0 / 3.0) - 1.0).sqrt();
                if r < 10.0 {
                    return random.direction().map(|x| x * r);
                }
            },
            Shape::Disc => loop {
                // The share of the mass within R is 1 - (1 + R) exp(-R): that of the sum of two deviates of exp(-R).
                let radius = -(random.between(1e-6, 1.0) * random.between(1e-6, 1.0)).ln();
                let height = 0.1 * random.between(-0.999, 0.999).atanh();
                if radius < 8.0 {
                    let angle = core::f64::consts::TAU * random.between(0.0, 1.0);
                    return [radius * angle.cos(), radius * angle.sin(), height];
                }
            },
            Shape::Uniform => random.vector(-1.0, 1.0),
            Shape::Clusters => {
                let [x, y, z] = Shape::Plummer.place(body, random);
                [x + if body.is_multiple_of(2) { 500.0 } else { -500.0 }, y, z]
            }
            Shape::Line => {
                let along = random.between(-1.0, 1.0);
                [along, 0.5 * along, 0.25 * along]
            }
            Shape::Shell => random.direction(),
            Shape::Point => [if body == 0 { 1.0 } else { 0.0 }, 0.0, 0.0],
        }
    }
}

/// Bodies of equal masses at rest, one unit of mass in all.
#[derive(Clone, Debug)]
pub struct Cloud {
    /// Places, rounded to f32.
    pub position: Vec<[f64; 3]>,
}

impl Cloud {
    /// So many bodies, around a point that is `offset` from the origin along each axis.
    pub fn new(shape: Shape, count: usize, offset: f64) -> Self {
        let mut random = Random::new(3);
        let place = |body| shape.place(body, &mut random).map(|x| f64::from((x + offset) as f32));
        Cloud { position: (0..count).map(place).collect() }
    }

    /// A Plummer sphere.
    pub fn plummer(count: usize, offset: f64) -> Self {
        Cloud::new(Shape::Plummer, count, offset)
    }

    /// The mass of each body.
    pub fn mass(&self) -> f64 {
        1.0 / self.position.len() as f64
    }

    /// With place, velocity and mass.
    pub fn domain<P: Precision>(&self) -> Domain<P> {
        let rest = vec![[0.0; 3]; self.position.len()];
        let domain = Domain::new("bodies").with(Position, &self.position).with(Velocity, rest);
        domain.with(Mass, vec![self.mass(); self.position.len()])
    }

    /// The root mean square of |a - a_ref| / |a_ref| over a sample of the bodies, for sums in f64.
    pub fn error(&self, softening: f64, acceleration: impl Fn(usize) -> [f64; 3]) -> f64 {
        let count = self.position.len();
        let (mut squares, mut sample) = (0.0, 0.0);
        // An odd stride: bodies may alternate.
        for i in (0..count).step_by(count.div_ceil(500) | 1) {
            // With what rounding leaves of every addition (Neumaier 1974): beside this, the sums that are measured have errors.
            let (mut exact, mut rests) = ([0.0_f64; 3], [0.0_f64; 3]);
            for (_, place) in self.position.iter().enumerate().filter(|(j, _)| *j != i) {
                let d = [0, 1, 2].map(|axis| place[axis] - self.position[i][axis]);
                let r2 = d.iter().map(|d| d * d).sum::<f64>() + softening * softening;
                for axis in 0..3 {
                    let share = self.mass() * d[axis] / (r2 * r2.sqrt());
                    let sum = exact[axis] + share;
                    let of_share = sum - exact[axis];
                    rests[axis] += (exact[axis] - (sum - of_share)) + (share - of_share);
                    exact[axis] = sum;
                }
            }
            exact.iter_mut().zip(rests).for_each(|(sum, rest)| *sum += rest);
            let found = acceleration(i);
            let off: f64 = (0..3).map(|axis| (found[axis] - exact[axis]).powi(2)).sum();
            squares += off / exact.iter().map(|a| a * a).sum::<f64>();
            sample += 1.0;
        }
        (squares / sample).sqrt()
    }

    /// The same, of the accelerations that an engine's first step of [`STEP`] gives.
    pub fn error_of_step<P: Precision>(&self, softening: f64, engine: &mut Engine<P>) -> f64 {
        engine.steps_of(1, STEP).expect("the bodies stay finite");
        let velocities = engine.state().numbers("bodies", Velocity).expect("the engine has velocities");
        // They were 0 before.
        self.error(softening, |row| [0, 1, 2].map(|axis| velocities[3 * row + axis] / STEP))
    }
}

/// Bodies on a cubic lattice with springs between neighbours, a little off their places.
#[derive(Clone, Debug, Default)]
pub struct Lattice {
    /// The bodies; those of the lowest layer are immovable.
    pub bodies: Bodies,
    /// The two bodies of each spring.
    pub ends: Vec<[u32; 2]>,
    /// Stiffnesses, in N/m.
    pub stiffness: Vec<f64>,
    /// Lengths at ease, in m.
    pub rest_length: Vec<f64>,
}

impl Lattice {
    /// `edge` bodies to an edge, one metre apart, and the first `springs` of the springs between neighbours.
    pub fn new(edge: u32, springs: usize) -> Self {
        Lattice::braced(edge, springs, 0.0)
    }

    /// The same, and from so many of the bodies one more spring, along a diagonal of a face or of the cell, which chance chooses.
    pub fn braced(edge: u32, springs: usize, share: f64) -> Self {
        let mut random = Random::new(2);
        let mut lattice = Lattice::default();
        let number = |x, y, z| (z * edge + y) * edge + x;
        let places = || (0..edge).flat_map(move |z| (0..edge).flat_map(move |y| (0..edge).map(move |x| [x, y, z])));
        for [x, y, z] in places() {
            let off = random.vector(-0.125, 0.125);
            lattice.bodies.position.push([f64::from(x) + off[0], f64::from(y) + off[1], f64::from(z) + off[2]]);
            lattice.bodies.velocity.push([0.0; 3]);
            lattice.bodies.mass.push(if z == 0 { 0.0 } else { 1.0 });
            let next = [[x + 1, y, z], [x, y + 1, z], [x, y, z + 1]];
            for [a, b, c] in next.into_iter().filter(|next| next.iter().all(|&place| place < edge)) {
                lattice.ends.push([number(x, y, z), number(a, b, c)]);
                lattice.rest_length.push(1.0);
            }
            if share > 0.0 && random.between(0.0, 1.0) < share {
                let [a, b, c] = [[1, 1, 0], [1, 0, 1], [0, 1, 1], [1, 1, 1]][(random.word() >> 62) as usize];
                if [x + a, y + b, z + c].iter().all(|&place| place < edge) {
                    lattice.ends.push([number(x, y, z), number(x + a, y + b, z + c)]);
                    lattice.rest_length.push(f64::from(a + b + c).sqrt());
                }
            }
        }
        lattice.ends.truncate(springs);
        lattice.rest_length.truncate(springs);
        lattice.stiffness = lattice.ends.iter().map(|_| random.between(500.0, 1000.0)).collect();
        lattice
    }

    /// The domain of the springs.
    pub fn springs<P: Precision>(&self) -> Domain<P> {
        Domain::new("springs")
            .link(Ends, "bodies", self.ends.iter().copied())
            .with(Stiffness, &self.stiffness)
            .with(RestLength, &self.rest_length)
    }
}
