//! A field is a function of position and time: a closure, or one of the stock shapes.
//!
//! `cargo run --release --example closure_field`

use vesper::prelude::*;
use vesper_laws::{ElectricForce, MagneticForce, Motion};

fn main() -> Result<(), Faults> {
    // A charge at rest in crossed fields drifts with E / B across both, on a cycloid.
    let charges = Domain::new("charges")
        .with(Position, [[0.0; 3]])
        .with(Velocity, [[0.0; 3]])
        .with(Mass, [1.0])
        .with(Charge, [1.0]);
    let mut engine = Engine::<f64>::builder()
        .domain(charges)
        .field(ElectricField, |_position: DVec3, _time: f64| DVec3::new(0.0, 0.5, 0.0))
        .field(MagneticField, Uniform { value: [0.0, 0.0, 2.0] })
        .law(ElectricForce)
        .law(MagneticForce)
        .law(Motion)
        .integrator(RungeKutta4)
        .step(1e-3)
        .build()?;

    // One turn of the cycloid: t = 2 pi m / (q B); x = (E / B) t, y back at 0.
    let turn = core::f64::consts::PI;
    while engine.time() + 1e-3 < turn {
        engine.advance(1e-3)?;
    }
    engine.steps_of(1, turn - engine.time())?;
    let place = engine.state().get("charges", Position, 0)?;
    println!("after one turn: {place:?}; E/B t = {:.9}", 0.25 * turn);
    assert!((place - DVec3::new(0.25 * turn, 0.0, 0.0)).length() < 1e-9);
    Ok(())
}
