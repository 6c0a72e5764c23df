//! Small laws of every shape, and small domains to run them on.

#![allow(dead_code, reason = "every test takes what it needs")]

use vesper::prelude::*;

property! {
    /// Heat content per heat capacity: a state that is neither coordinate nor momentum.
    pub Temperature: Scalar, "K";
    /// How fast a row cools.
    pub Cooling: Scalar, "1/s";
    /// What a law left for others.
    pub Trace: Vector, "N";
    /// The force of the evaluation before.
    pub Memory: Vector, "N";
    /// How fast a row turns.
    pub Spin: Scalar, "rad/s", momentum of Angle;
    /// Something no law uses.
    pub Colour: Vector, "1";
    /// An angle: a second coordinate.
    pub Angle: Scalar, "rad", coordinate;
    /// The row that a row hangs on.
    pub Parent: Link<1>;
}

/// Gravitation.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force))]
pub struct Gravity<R = f64> {
    /// Constant of gravitation.
    #[law(unit = "m^3 kg^-1 s^-2", default = 1.0)]
    pub g: R,
    /// Softening length.
    #[law(unit = "m", default = 0.1)]
    pub softening: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for Gravity<R> {
    fn pair(&self, i: GravityRow<R>, j: GravityRow<R>) -> R::Vec3 {
        let d = j.position - i.position;
        let r2 = d.length_squared() + self.softening * self.softening;
        d * (self.g * i.mass * j.mass / (r2 * r2.sqrt()))
    }
    fn energy(&self, i: GravityRow<R>, j: GravityRow<R>) -> R {
        let d = j.position - i.position;
        -self.g * i.mass * j.mass / (d.length_squared() + self.softening * self.softening).sqrt()
    }
}

/// Repulsion of charges.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, charge: Charge), adds(force: Force))]
pub struct Coulomb;

#[kernel]
impl<R: Real> PairLaw<R> for Coulomb {
    fn pair(&self, i: CoulombRow<R>, j: CoulombRow<R>) -> R::Vec3 {
        let d = i.position - j.position;
        let r2 = d.length_squared() + R::lit(1e-3);
        d * (i.charge * j.charge / (r2 * r2.sqrt()))
    }
}

/// Newton's second law.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity, force: Force, mass: Mass),
      rates(position: Position from (velocity), velocity: Velocity from (force, mass)))]
pub struct Motion;

#[kernel]
impl<R: Real> RowLaw<R> for Motion {
    fn row(&self, body: MotionRow<R>) -> MotionOutput<R> {
        MotionOutput { position: body.velocity, velocity: body.force / body.mass }
    }
    fn energy(&self, body: MotionRow<R>) -> R {
        R::lit(0.5) * body.mass * body.velocity.length_squared()
    }
}

/// Linear drag, against the wind where there is one.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity, coefficient: DragCoefficient), reads(wind: WindVelocity, optional), adds(force: Force))]
pub struct Drag;

#[kernel]
impl<R: Real> RowLaw<R> for Drag {
    fn row(&self, row: DragRow<R>) -> R::Vec3 {
        (row.wind.unwrap_or(R::Vec3::zero()) - row.velocity) * row.coefficient
    }
}

/// Weight.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(mass: Mass), scene(gravity: GravityAcceleration = [0.0, 0.0, -10.0]), adds(force: Force))]
pub struct Weight;

#[kernel]
impl<R: Real> RowLaw<R> for Weight {
    fn row(&self, row: WeightRow<R>) -> R::Vec3 {
        row.gravity * row.mass
    }
}

/// Springs.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "springs", reads(stiffness: Stiffness, rest: RestLength),
      link(ends: Ends, reads(position: Position), adds(force: Force)))]
pub struct Spring;

#[kernel]
impl<R: Real> LinkLaw<R> for Spring {
    fn link(&self, spring: SpringRow<R>, [a, b]: [SpringEnd<R>; 2]) -> [R::Vec3; 2] {
        let d = b.position - a.position;
        let length = (d.length_squared() + R::lit(1e-12)).sqrt();
        let force = d * (spring.stiffness * (length - spring.rest) / length);
        [force, -force]
    }
}

/// Mass from rest mass and speed.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(rest: RestMass, velocity: Velocity), sets(mass: Mass))]
pub struct Inertia;

#[kernel]
impl<R: Real> RowLaw<R> for Inertia {
    fn row(&self, row: InertiaRow<R>) -> R {
        row.rest * (R::lit(1.0) + row.velocity.length_squared() * R::lit(0.01)).sqrt()
    }
}

/// Force of an electric field.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(charge: Charge), fields(electric: ElectricField), adds(force: Force))]
pub struct Electric;

#[kernel]
impl<R: Real> RowLaw<R> for Electric {
    fn row(&self, row: ElectricRow<R>) -> R::Vec3 {
        row.electric * row.charge
    }
}

/// Cools towards nothing.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(temperature: Temperature, cooling: Cooling), rates(temperature: Temperature))]
pub struct Cool;

#[kernel]
impl<R: Real> RowLaw<R> for Cool {
    fn row(&self, row: CoolRow<R>) -> R {
        -row.cooling * row.temperature
    }
}

/// Keeps every row above the floor.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(place: Position), amends(position: Position))]
pub struct Floor;

#[kernel]
impl<R: Real> RowLaw<R> for Floor {
    fn row(&self, row: FloorRow<R>) -> R::Vec3 {
        R::Vec3::new(row.place.x(), row.place.y(), row.place.z().max(R::lit(0.0)))
    }
}

/// Remembers the force of the evaluation before.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "bodies", reads(previous before: Force), sets(memory: Memory))]
pub struct Remember;

#[kernel]
impl<R: Real> RowLaw<R> for Remember {
    fn row(&self, row: RememberRow<R>) -> R::Vec3 {
        row.before
    }
}

/// Adds a part of what is remembered.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(memory: Memory), adds(force: Force))]
pub struct Echo;

#[kernel]
impl<R: Real> RowLaw<R> for Echo {
    fn row(&self, row: EchoRow<R>) -> R::Vec3 {
        row.memory * R::lit(0.5)
    }
}

/// Pulls every row to the mean of all, as a law over whole columns.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force))]
pub struct Herd;

#[kernel]
impl<P: Precision> ColumnLaw<P> for Herd {
    fn columns(&self, mut columns: HerdColumns<'_, P>) {
        let mut sum = P::Vec3::zero();
        for row in 0..columns.position.len() {
            sum += columns.position.get(row);
        }
        let mean = sum / P::from_f64(columns.position.len().max(1) as f64);
        for row in 0..columns.position.len() {
            columns.force.add(row, mean - columns.position.get(row));
        }
    }
}

/// Writes what it sees of the force.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "bodies", reads(force: Force), sets(trace: Trace))]
pub struct Recorder;

#[kernel]
impl<R: Real> RowLaw<R> for Recorder {
    fn row(&self, row: RecorderRow<R>) -> R::Vec3 {
        row.force
    }
}

/// A small generator of numbers: SplitMix64 (Steele, Lea, Flood, OOPSLA 2014).
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
    /// A number below `bound`.
    pub fn below(&mut self, bound: usize) -> usize {
        (self.next() % bound as u64) as usize
    }
    /// A number from -1 to 1.
    pub fn unit(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
    pub fn coin(&mut self) -> bool {
        self.next() & 1 == 1
    }
    pub fn vector(&mut self) -> [f64; 3] {
        [self.unit(), self.unit(), self.unit()]
    }
    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for k in (1..items.len()).rev() {
            items.swap(k, self.below(k + 1));
        }
    }
}

/// Bodies at random places with everything that the laws here read.
pub fn cloud<P: Precision>(rows: usize, seed: u64) -> Domain<P> {
    let mut random = Random(seed);
    let mut vectors = || (0..rows).map(|_| random.vector()).collect::<Vec<_>>();
    let (position, velocity, external) = (vectors(), vectors(), vectors());
    let mut numbers = || (0..rows).map(|_| random.unit() + 1.5).collect::<Vec<_>>();
    Domain::new("bodies")
        .with(Position, position)
        .with(Velocity, velocity)
        .with(ExternalForce, external)
        .with(Mass, numbers())
        .with(DragCoefficient, numbers())
        .with(Charge, numbers())
}

/// A chain of springs through all rows of a domain of this many.
pub fn springs<P: Precision>(rows: usize) -> Domain<P> {
    let links: Vec<[u32; 2]> = (1..rows as u32).map(|row| [row - 1, row]).collect();
    let count = links.len();
    Domain::new("springs")
        .link(Ends, "bodies", links)
        .with(Stiffness, vec![3.0; count])
        .with(RestLength, vec![0.5; count])
}
