//! A law of your own: a struct that says what it touches, and one function.
//!
//! `cargo run --release --example first_law`

use vesper::prelude::*;
use vesper_laws::{Motion, UniformGravity};

/// Lift of a flat kite: upwards, as the square of the speed over ground.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity), adds(force: Force))]
pub struct Lift<R = f64> {
    /// Force per square of the speed.
    #[law(unit = "kg/m", default = 0.02)]
    pub coefficient: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for Lift<R> {
    fn row(&self, kite: LiftRow<R>) -> R::Vec3 {
        let (x, y) = (kite.velocity.x(), kite.velocity.y());
        R::Vec3::new(R::lit(0.0), R::lit(0.0), self.coefficient * (x * x + y * y))
    }
}

fn main() -> Result<(), Faults> {
    let kites = Domain::new("kites")
        .with(Position, [[0.0, 0.0, 100.0], [0.0, 10.0, 100.0]])
        .with(Velocity, [[22.1472, 0.0, 0.0], [10.0, 0.0, 0.0]])
        .with(Mass, [1.0, 1.0]);

    let mut engine = Engine::<f64>::builder()
        .domain(kites)
        .constant(GravityAcceleration, [0.0, 0.0, -9.81])
        .law(Lift::default())
        .law(UniformGravity)
        .law(Motion)
        .step(1e-3)
        .build()?;
    println!("{}", engine.explain());

    engine.advance(2.0)?;
    for (kite, place) in engine.state().values("kites", Position)?.into_iter().enumerate() {
        println!("kite {kite} after {} s: {place:.3} m", engine.time());
    }

    // The first one flies at the speed at which lift carries the weight: 0.02 v^2 = 9.81. The second one falls with
    // what is left of the weight: 9.81 - 0.02 * 10^2 = 7.81 m/s^2.
    let fast = engine.state().get("kites", Position, 0)?;
    let slow = engine.state().get("kites", Position, 1)?;
    assert!((fast.z - 100.0).abs() < 1e-3);
    assert!((slow.z - (100.0 - 0.5 * 7.81 * 4.0)).abs() < 1e-9);
    Ok(())
}
