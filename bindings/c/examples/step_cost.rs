//! What a step of two bodies costs, in ns: by the library itself and through the C interface, in turns, so that both see the
//! same machine. The least of many batches. `step_cost.c` does the same from C.

use core::ffi::CStr;
use std::time::Instant;
use vesper::prelude::*;
use vesper_c::interface::*;
use vesper_laws::{Gravity, Motion};

const CALLS: u32 = 2000;
const BATCHES: u32 = 2000;
const STEP: f64 = 1.0 / 1024.0;
const POSITION: [[f64; 3]; 2] = [[0.0; 3], [1.0, 0.0, 0.0]];
const VELOCITY: [[f64; 3]; 2] = [[0.0; 3], [0.0, 1.0, 0.0]];
const MASS: [f64; 2] = [1.0, 1e-3];

/// The engine behind a handle.
fn through_c() -> EngineId {
    let (mut builder, mut engine) = (BuilderId { id: 0 }, EngineId { id: 0 });
    let column = |builder, name: &CStr, numbers: &[f64]| {
        let (start, count) = (numbers.as_ptr().cast(), numbers.len());
        // SAFETY: texts end, and the array has so many numbers.
        unsafe { vesper_builder_column(builder, c"bodies".as_ptr(), name.as_ptr(), VESPER_F64, start, count) };
    };
    // SAFETY: texts end, and the places are variables.
    unsafe {
        vesper_builder_new(VESPER_F64, &raw mut builder);
        vesper_builder_domain(builder, c"bodies".as_ptr(), 2);
        column(builder, c"position", POSITION.as_flattened());
        column(builder, c"velocity", VELOCITY.as_flattened());
        column(builder, c"mass", &MASS);
        vesper_builder_law(builder, c"gravity".as_ptr(), c"g = 1".as_ptr());
        vesper_builder_law(builder, c"motion".as_ptr(), core::ptr::null());
        vesper_builder_settings(builder, c"integrator = 'leapfrog', step = 0.0009765625".as_ptr());
        assert_eq!(vesper_builder_build(builder, &raw mut engine), VESPER_OK, "the engine is built");
    }
    engine
}

/// The time of a call, in ns, where that is the least so far.
fn least(best: &mut f64, mut call: impl FnMut()) {
    let start = Instant::now();
    (0..CALLS).for_each(|_| call());
    *best = best.min(start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS));
}

fn main() -> Result<(), Faults> {
    let bodies = Domain::new("bodies").with(Position, POSITION).with(Velocity, VELOCITY).with(Mass, MASS);
    let law = Gravity { g: 1.0, ..Gravity::default() };
    let mut engine = Engine::<f64>::builder().domain(bodies).law(law).law(Motion).step(STEP).build()?;
    let handle = through_c();
    let mut best = [f64::INFINITY; 4];
    for _ in 0..BATCHES {
        least(&mut best[0], || engine.steps_of(1, STEP).expect("a step"));
        // SAFETY: no pointer is given.
        least(&mut best[1], || unsafe { assert_eq!(vesper_engine_step(handle, 1, STEP), VESPER_OK) });
        least(&mut best[2], || engine.advance(STEP).expect("a frame"));
        // SAFETY: no pointer is given.
        least(&mut best[3], || unsafe { assert_eq!(vesper_engine_advance(handle, STEP), VESPER_OK) });
    }
    let [step, step_c, advance, advance_c] = best;
    println!("step: Rust {step:.1} ns, C {step_c:.1} ns, {:+.1} ns", step_c - step);
    println!("advance: Rust {advance:.1} ns, C {advance_c:.1} ns, {:+.1} ns", advance_c - advance);
    Ok(())
}
