//! What a client may do with data and laws, each against a computation by hand or against another way to the same end.

mod checkpoint;
mod composed;
mod data;
mod hand_written;
mod laws;
mod lent;
mod looks;
mod reach;
mod rows;
mod time;

use crate::common::*;
use vesper::prelude::*;

/// A body of mass 2 at rest at the origin.
fn one() -> Domain<f64> {
    Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[0.0; 3]]).with(Mass, [2.0])
}

fn place(engine: &Engine<f64>, row: usize) -> DVec3 {
    engine.state().get("bodies", Position, row).unwrap()
}

fn speed(engine: &Engine<f64>, row: usize) -> DVec3 {
    engine.state().get("bodies", Velocity, row).unwrap()
}

fn status(engine: &mut Engine<f64>, law: &str) -> &'static str {
    engine.refresh().unwrap().law(law).unwrap().status.word()
}
