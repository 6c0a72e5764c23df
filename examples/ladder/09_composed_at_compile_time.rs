//! The same laws as one loop that the compiler composes, with the sums in registers: the same bits, faster.
//!
//! `cargo run --release --example composed_at_compile_time`

use vesper::prelude::*;
use vesper_laws::{Drag, Motion, UniformGravity};

fn dust() -> Builder<f32> {
    let rows = 10_000;
    let along = |row: usize| [row as f32 * 0.01, 0.0, 0.0];
    let dust = Domain::new("dust")
        .with(Position, (0..rows).map(along).collect::<Vec<_>>())
        .with(Velocity, vec![[0.0_f32, 1.0, 0.0]; rows])
        .with(Mass, vec![1e-6; rows])
        .with(DragCoefficient, vec![2e-6; rows]);
    Engine::builder()
        .domain(dust)
        .constant(GravityAcceleration, [0.0, 0.0, -9.81])
        .integrator(SemiImplicitEuler)
        .step(0.01)
}

fn main() -> Result<(), Faults> {
    let mut listed = dust().law(UniformGravity).law(Drag).law(Motion).build()?;
    // Two laws that both set one property, a circle, one name with two units: these would not compile.
    let mut composed = dust().laws(pipeline![UniformGravity, Drag, Motion]).build()?;
    println!("{}", composed.explain());
    listed.advance(1.0)?;
    composed.advance(1.0)?;
    println!("hash of the state: {:016x} listed, {:016x} composed", listed.state().hash(), composed.state().hash());
    assert_eq!(listed.state().hash(), composed.state().hash());
    Ok(())
}
