//! What a client may do between frames: look, teleport, push, change a constant.
//!
//! `cargo run --release --example between_frames`

use vesper::prelude::*;
use vesper_laws::{Motion, UniformGravity};

fn main() -> Result<(), Faults> {
    let balls = Domain::new("balls")
        .with(Position, [[0.0, 0.0, 10.0], [5.0, 0.0, 10.0]])
        .with(Velocity, [[0.0; 3], [0.0; 3]])
        .with(Mass, [2.0, 2.0])
        .with(ExternalForce, [[0.0; 3], [0.0; 3]]);
    let mut engine = Engine::<f64>::builder()
        .domain(balls)
        .constant(GravityAcceleration, [0.0, 0.0, -9.81])
        .law(UniformGravity)
        .law(Motion)
        .step(1.0 / 240.0)
        .build()?;
    let frame = 1.0 / 60.0;

    // Push: the sum of forces starts from the external force. Half a second of 20 N gives 2 kg a speed of 5 m/s.
    engine.state_mut().set("balls", ExternalForce, 0, DVec3::new(20.0, 0.0, 0.0))?;
    for _ in 0..30 {
        engine.advance(frame)?;
    }
    engine.state_mut().set("balls", ExternalForce, 0, DVec3::ZERO)?;
    let speed = engine.state().get("balls", Velocity, 0)?.x;
    println!("pushed for {:.3} s: {speed:.6} m/s", engine.time());
    assert!((speed - 5.0).abs() < 1e-9);

    // Teleport: put it back and stop it.
    engine.state_mut().set("balls", Position, 0, DVec3::new(0.0, 0.0, 10.0))?;
    engine.state_mut().set("balls", Velocity, 0, DVec3::ZERO)?;

    // And fly to the Moon.
    engine.state_mut().set_constant(GravityAcceleration, [0.0, 0.0, -1.62])?;
    for _ in 0..60 {
        engine.advance(frame)?;
    }
    let height = engine.state().get("balls", Position, 0)?.z;
    println!("after one second on the Moon: {height:.6} m");
    assert!((height - (10.0 - 0.5 * 1.62)).abs() < 1e-9);
    Ok(())
}
