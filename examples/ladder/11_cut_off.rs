//! A law that ends at a distance, and a periodic box: the framework keeps lists of neighbours. The law is in `lennard_jones.rs`
//! beside this file; nothing in it speaks of lists, boxes, lanes or threads.
//!
//! `cargo run --release --example cut_off`

use std::time::Instant;
use vesper::prelude::*;
use vesper_examples::lennard_jones::{LATTICE_ENERGY, LennardJones, length, melt};
use vesper_laws::Motion;

const CELLS: usize = 20;
const STEPS: u64 = 200;
const STEP: f64 = 0.005;

fn main() -> Result<(), Faults> {
    let mut engine = Engine::<f64>::builder()
        .domain(melt(CELLS))
        .constant(PeriodicBox, [[length(CELLS); 3]])
        .law(LennardJones::default())
        .law(Motion)
        .integrator(Leapfrog::default())
        .step(STEP)
        .threads(1)
        .strict()
        .build()?;
    let atoms = 4 * CELLS.pow(3);
    let kinetic = |engine: &Engine<f64>| -> Result<f64, Faults> {
        Ok(engine.state().numbers("atoms", Velocity)?.iter().map(|v| 0.5 * v * v).sum::<f64>() / atoms as f64)
    };
    let energy = |engine: &mut Engine<f64>| -> Result<f64, Faults> { Ok(engine.energy()?.0 / atoms as f64) };
    let (total, moving) = (energy(&mut engine)?, kinetic(&engine)?);
    let potential = total - moving;
    println!("{atoms} atoms, energy per atom {potential:.10} at rest, {total:.6} in all");
    assert!((potential - LATTICE_ENERGY).abs() < 1e-9, "that of the lattice");

    let start = Instant::now();
    engine.steps_of(STEPS, STEP)?;
    let rate = atoms as f64 * STEPS as f64 / start.elapsed().as_secs_f64();
    let after = energy(&mut engine)?;
    println!(
        "after {STEPS} steps {after:.6}, temperature {:.4}; {rate:.1e} atom-steps a second",
        2.0 / 3.0 * kinetic(&engine)?
    );
    // The usual melt goes from -4.6134 to -4.6223 in its first 100 steps: pairs that come and go at the cut-off take 0.016 with them.
    assert!((after - total).abs() < 2e-2, "the energy stays, but for the jumps at the cut-off");
    Ok(())
}
