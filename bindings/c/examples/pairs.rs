//! Pairs on a spring, seven cases: the bits of positions and velocities after ten seconds, in both precisions, by the library
//! itself. `pairs.c` prints the same lines from C.

use vesper::prelude::*;
use vesper_laws::reference::{BODIES, Problem, pairs};

fn bits<P: Precision>(problem: &impl Problem) -> Result<String, Faults> {
    let mut engine = problem.engine::<P>(RungeKutta4, 1e-3)?;
    engine.advance(10.0)?;
    let digits = size_of::<P>() * 2;
    let mut text = String::new();
    for property in [Position::INFO, Velocity::INFO] {
        let column = engine.state().column(BODIES, property.name)?;
        let components = column.components().unwrap_or_default();
        for row in 0..2 {
            for component in &components {
                text += &format!(" {:0digits$x}", component[row].bits());
            }
        }
    }
    Ok(text)
}

fn main() -> Result<(), Faults> {
    for pair in pairs() {
        println!("{} f64{}", pair.case, bits::<f64>(&pair)?);
        println!("{} f32{}", pair.case, bits::<f32>(&pair)?);
    }
    Ok(())
}
