//! A module of laws, one of each shape: `cargo build --release -p wings` makes `target/release/libwings.so`, and
//! `vesper run scene.toml --laws target/release` finds it. Nothing here knows that it is loaded at run time: the same laws can be
//! listed by a program that is compiled with them.

use vesper::prelude::*;
use vesper::real::Mask as _;

/// Lift of a wing: a force upwards, by the speed forwards.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity), adds(force: Force))]
pub struct Lift<R = f64> {
    /// Force per velocity.
    #[law(unit = "kg/s", default = 0.1)]
    pub slope: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for Lift<R> {
    fn row(&self, body: LiftRow<R>) -> R::Vec3 {
        R::Vec3::new(R::lit(0.0), R::lit(0.0), self.slope * body.velocity.x())
    }
}

/// The law of motion, as a module has it.
#[derive(Law, Clone, Copy, Debug)]
#[law(
    reads(velocity: Velocity, force: Force, mass: Mass),
    rates(position: Position from (velocity), velocity: Velocity from (force, mass)),
    second_order
)]
pub struct Flight;

#[kernel]
impl<R: Real> RowLaw<R> for Flight {
    fn row(&self, body: FlightRow<R>) -> FlightOutput<R> {
        FlightOutput { position: body.velocity, velocity: body.force / body.mass }
    }
}

/// Birds of a flock keep away from each other, less the further they are.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force))]
pub struct Flock<R = f64> {
    /// Force at no distance.
    #[law(unit = "N", default = 1.0)]
    pub strength: R,
    /// Distance at which it is half.
    #[law(unit = "m", default = 1.0)]
    pub reach: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for Flock<R> {
    fn pair(&self, i: FlockRow<R>, j: FlockRow<R>) -> R::Vec3 {
        let apart = i.position - j.position;
        let square = apart.dot(apart);
        let reach = self.reach * self.reach;
        apart * (self.strength * self.reach / (square + reach))
    }
    fn energy(&self, i: FlockRow<R>, j: FlockRow<R>) -> R {
        let apart = i.position - j.position;
        self.strength / (apart.dot(apart) + self.reach * self.reach)
    }
}

/// A cord that pulls by its length.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(stiffness: Stiffness), link(ends: Ends, reads(position: Position), adds(force: Force)))]
pub struct Cord;

#[kernel]
impl<R: Real> LinkLaw<R, 2> for Cord {
    fn link(&self, cord: CordRow<R>, [a, b]: [CordEnd<R>; 2]) -> [R::Vec3; 2] {
        let pull = (b.position - a.position) * cord.stiffness;
        [pull, -pull]
    }
}

/// The flock flies at one height: every bird is drawn to the mean. It panics where the stiffness is negative, which switches it off, and
/// nothing else.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force))]
pub struct Level<R = f64> {
    /// Force per distance from the mean.
    #[law(unit = "N/m", default = 0.5)]
    pub stiffness: R,
}

#[kernel]
impl<P: Precision> ColumnLaw<P> for Level<P> {
    fn columns(&self, mut birds: LevelColumns<'_, P>) {
        let negative = self.stiffness < P::lit(0.0);
        assert!(!negative, "the stiffness is negative");
        let count = birds.position.len();
        let sum = (0..count).fold(P::lit(0.0), |sum, row| sum + birds.position.get(row).z());
        let mean = sum / P::lit(count.max(1) as f64);
        for row in 0..count {
            let height = birds.position.get(row).z();
            birds.force.add(row, <P as Real>::Vec3::new(P::lit(0.0), P::lit(0.0), self.stiffness * (mean - height)));
        }
    }
}

/// An updraft, which carries every bird alike. It panics where a mass is negative.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(mass: Mass), adds(force: Force))]
pub struct Updraft<R = f64> {
    /// Acceleration upwards.
    #[law(unit = "m/s^2", default = 1.0)]
    pub rise: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for Updraft<R> {
    fn row(&self, bird: UpdraftRow<R>) -> R::Vec3 {
        assert!(bird.mass.less(R::lit(0.0)).bits() == 0, "a mass is negative");
        R::Vec3::new(R::lit(0.0), R::lit(0.0), self.rise * bird.mass)
    }
}

vesper::export_laws![Lift, Flight, Flock, Cord, Level, Updraft];
