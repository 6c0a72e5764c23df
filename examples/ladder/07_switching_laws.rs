//! Laws are switched on and off, fall asleep when their data go, and wake when they come.
//!
//! `cargo run --release --example switching_laws`

use vesper::prelude::*;
use vesper_laws::{Drag, Motion, UniformGravity};

fn main() -> Result<(), Faults> {
    let stones = Domain::new("stones").with(Position, [[0.0; 3]]).with(Velocity, [[0.0, 0.0, 20.0]]).with(Mass, [1.0]);
    let mut engine = Engine::<f64>::builder()
        .domain(stones)
        .constant(GravityAcceleration, [0.0, 0.0, -9.81])
        .law(UniformGravity)
        .law(Drag)
        .law(Motion)
        .step(1e-3)
        .build()?;
    // Drag lacks its coefficient: it is dormant, and the report says what to add.
    println!("{}", engine.report());
    assert_eq!(engine.report().law("drag").map(|law| law.status.word()), Some("dormant"));

    engine.enable("uniform_gravity", false)?;
    engine.advance(1.0)?;
    let free = engine.state().get("stones", Velocity, 0)?.z;
    assert_eq!(free, 20.0, "no law acts");

    // The coefficient comes: drag wakes.
    engine.state_mut().add_columns(Domain::new("stones").with(DragCoefficient, [0.5]))?;
    engine.advance(1.0)?;
    println!("{}", engine.report());
    let slowed = engine.state().get("stones", Velocity, 0)?.z;
    let exact = 20.0 * (-0.5_f64).exp();
    println!("after one second of drag: {slowed:.6} m/s, exactly {exact:.6} m/s");
    assert!((slowed - exact).abs() < 1e-5);

    // A typo is answered with the nearest name.
    println!("{}", engine.enable("uniform_gravty", true).err().map_or(String::new(), |fault| fault.to_string()));
    Ok(())
}
