//! Bodies are added and removed at run time; springs between them follow.
//!
//! `cargo run --release --example rows_come_and_go`

use vesper::prelude::*;
use vesper_laws::{Motion, Spring};

fn main() -> Result<(), Faults> {
    let beads = Domain::new("beads")
        .with(Position, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
        .with(Velocity, [[0.0; 3]; 3])
        .with(Mass, [1.0; 3]);
    let springs = Domain::new("springs")
        .link(Ends, "beads", [[0, 1], [1, 2]])
        .with(Stiffness, [100.0, 100.0])
        .with(RestLength, [1.0, 1.0]);
    let mut engine =
        Engine::<f64>::builder().domain(beads).domain(springs).law(Spring).law(Motion).step(1e-3).build()?;
    engine.advance(0.1)?;

    // A fourth bead, and a spring to it that is stretched.
    let bead = Domain::new("beads").with(Position, [[3.5, 0.0, 0.0]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    engine.state_mut().add_rows(bead)?;
    let spring = Domain::new("springs").link(Ends, "beads", [[2, 3]]).with(Stiffness, [100.0]).with(RestLength, [1.0]);
    engine.state_mut().add_rows(spring)?;
    engine.advance(1.0)?;
    println!("with four beads: {:.3?}", engine.state().values("beads", Position)?);

    // What is missing is said; nothing changes then.
    let incomplete = Domain::new("beads").with(Position, [[9.0, 0.0, 0.0]]);
    println!("refused:\n{}", engine.state_mut().add_rows(incomplete).err().map_or(String::new(), |f| f.to_string()));

    // Bead 1 goes, and with it the springs that hung on it; the last spring's ends are renumbered.
    engine.state_mut().remove_rows("beads", &[1])?;
    let ends = engine.state().column("springs", "ends")?.links().map(|(_, _, rows)| rows.to_vec());
    println!("ends of the springs that are left: {ends:?}");
    assert_eq!(ends, Some(vec![1, 2]));

    let momentum = |engine: &Engine<f64>| -> Result<DVec3, Fault> {
        Ok(engine.state().values("beads", Velocity)?.into_iter().sum())
    };
    let before = momentum(&engine)?;
    engine.advance(10.0)?;
    assert!((momentum(&engine)? - before).length() < 1e-12, "springs conserve momentum");
    Ok(())
}
