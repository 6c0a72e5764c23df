//! A law from somebody else's crate (`examples/foreign`, outside the workspace) beside stock laws.
//!
//! `cargo run --release --example foreign_law`

use vesper::prelude::*;
use vesper_laws::Motion;

fn main() -> Result<(), Faults> {
    // Two equal masses that turn around each other at a distance of 1 m, once in a minute.
    let omega = core::f64::consts::TAU / 60.0;
    let g = 6.674_30e-11;
    let mass = omega * omega / (2.0 * g);
    let bodies = Domain::new("bodies")
        .with(Position, [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]])
        .with(Velocity, [[0.0, -0.5 * omega, 0.0], [0.0, 0.5 * omega, 0.0]])
        .with(Mass, [mass, mass]);
    let mut engine = Engine::<f64>::builder()
        .domain(bodies)
        .law(foreign_gravity::Gravity::default())
        .law(Motion)
        .integrator(RungeKutta4)
        .step(0.01)
        .build()?;
    engine.advance(60.0)?;

    let place = engine.state().get("bodies", Position, 1)?;
    println!("after one turn: {place:?}, at first (0.5, 0, 0)");
    assert!((place - DVec3::new(0.5, 0.0, 0.0)).length() < 1e-9);
    Ok(())
}
