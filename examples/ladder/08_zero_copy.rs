//! The client's own arrays, used in place: no copy in, no copy out.
//!
//! `cargo run --release --example zero_copy`

use vesper::prelude::*;
use vesper_laws::{Motion, UniformGravity};

fn main() -> Result<(), Faults> {
    // As a renderer has them: x, y, z of one vertex after the other.
    let positions = Lent::new(vec![[0.0_f32, 0.0, 50.0]; 1000]);
    let address = positions.read().as_ptr();

    let drops = Domain::new("drops")
        .lend(Position, &positions)
        .with(Velocity, vec![[1.0, 0.0, 0.0]; 1000])
        .with(Mass, vec![1e-3; 1000]);
    let mut engine = Engine::<f32>::builder()
        .domain(drops)
        .constant(GravityAcceleration, [0.0, 0.0, -9.81])
        .law(UniformGravity)
        .law(Motion)
        .step(1.0 / 256.0)
        .build()?;

    for frame in 0..3 {
        engine.advance(0.25)?;
        // "Draw": read the array that the engine has just moved.
        println!("frame {frame}: drop 7 at {:?}", positions.read()[7]);
    }
    assert_eq!(positions.read().as_ptr(), address, "the same memory all the way");
    assert!((positions.read()[7][0] - 0.75).abs() < 1e-5);

    // Between frames the client writes to it as it likes.
    positions.write()[7] = [100.0, 0.0, 50.0];
    engine.advance(0.25)?;
    assert!((positions.read()[7][0] - 100.25).abs() < 1e-4);

    // While it holds on to it, the engine waits for it, with words.
    let held = positions.read();
    println!("{}", engine.advance(0.25).err().map_or(String::new(), |faults| faults.to_string()));
    drop(held);
    Ok(())
}
