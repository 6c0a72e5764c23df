//! What a step of two bodies costs, in ns: by the library itself and through the C interface, in turns, so that both see the
//! same machine. The mean over many engines, the least of many batches for each. A frame with nothing to do shows what the
//! interface adds, and little else. `step_cost.c` steps from C.

use core::ffi::CStr;
use std::time::Instant;
use vesper::prelude::*;
use vesper_c::interface::*;
use vesper_laws::{Gravity, Motion};

const CALLS: u32 = 1000;
const BATCHES: u32 = 20;
const ENGINES: usize = 240;
const STEP: f64 = 1.0 / 1024.0;
const POSITION: [[f64; 3]; 2] = [[0.0; 3], [1.0, 0.0, 0.0]];
const VELOCITY: [[f64; 3]; 2] = [[0.0; 3], [0.0, 1.0, 0.0]];
const MASS: [f64; 2] = [1.0, 1e-3];

/// The engine behind a handle; without bodies and laws where it has nothing to do.
fn through_c(bodies: bool) -> EngineId {
    let (mut builder, mut engine) = (BuilderId { id: 0 }, EngineId { id: 0 });
    let column = |builder, name: &CStr, numbers: &[f64]| {
        let (start, count) = (numbers.as_ptr().cast(), numbers.len());
        // SAFETY: texts end, and the array has so many numbers.
        unsafe { vesper_builder_column(builder, c"bodies".as_ptr(), name.as_ptr(), VESPER_F64, start, count) };
    };
    // SAFETY: texts end, and the places are variables.
    unsafe {
        vesper_builder_new(VESPER_F64, &raw mut builder);
        if bodies {
            vesper_builder_domain(builder, c"bodies".as_ptr(), 2);
            column(builder, c"position", POSITION.as_flattened());
            column(builder, c"velocity", VELOCITY.as_flattened());
            column(builder, c"mass", &MASS);
            vesper_builder_law(builder, c"gravity".as_ptr(), c"g = 1".as_ptr());
            vesper_builder_law(builder, c"motion".as_ptr(), core::ptr::null());
        }
        vesper_builder_settings(builder, c"integrator = 'leapfrog', step = 0.0009765625".as_ptr());
        assert_eq!(vesper_builder_build(builder, &raw mut engine), VESPER_OK, "the engine is built");
    }
    engine
}

/// The engine of the library.
fn in_rust() -> Result<Engine<f64>, Faults> {
    let bodies = Domain::new("bodies").with(Position, POSITION).with(Velocity, VELOCITY).with(Mass, MASS);
    let law = Gravity { g: 1.0, ..Gravity::default() };
    Engine::builder().domain(bodies).law(law).law(Motion).step(STEP).build()
}

/// The time of a call, in ns, where that is the least so far.
fn least(best: &mut f64, mut call: impl FnMut()) {
    let start = Instant::now();
    (0..CALLS).for_each(|_| call());
    *best = best.min(start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS));
}

/// Prints the means over all engines.
fn print(what: &str, rust: &[f64], c: &[f64]) {
    let mean = |all: &[f64]| all.iter().sum::<f64>() / all.len() as f64;
    let (rust, c) = (mean(rust), mean(c));
    println!("{what}: Rust {rust:.1} ns, C {c:.1} ns, {:+.1} ns", c - rust);
}

/// The least times of one pair of engines: in Rust and through C a step, a frame, and a frame with nothing to do.
fn race(turn: usize) -> Result<[f64; 6], Faults> {
    // In either order, and elsewhere each time.
    let first = turn.is_multiple_of(2).then(in_rust).transpose()?;
    core::mem::forget(vec![0_u8; turn * 7919 % 4099]);
    let handle = through_c(true);
    core::mem::forget(vec![0_u8; turn * 104_729 % 4099]);
    let mut engine = Box::new(first.map_or_else(in_rust, Ok)?);
    let mut empty = Box::new(Engine::<f64>::builder().step(STEP).build()?);
    let empty_handle = through_c(false);
    let mut least_of = [f64::INFINITY; 6];
    let [step, step_c, frame, frame_c, idle, idle_c] = &mut least_of;
    for _ in 0..BATCHES {
        least(step, || engine.steps_of(1, STEP).expect("a step"));
        // SAFETY: no pointer is given.
        least(step_c, || unsafe { assert_eq!(vesper_engine_step(handle, 1, STEP), VESPER_OK) });
        least(frame, || engine.advance(STEP).expect("a frame"));
        // SAFETY: no pointer is given.
        least(frame_c, || unsafe { assert_eq!(vesper_engine_advance(handle, STEP), VESPER_OK) });
        least(idle, || empty.advance(STEP).expect("a frame"));
        // SAFETY: no pointer is given.
        least(idle_c, || unsafe { assert_eq!(vesper_engine_advance(empty_handle, STEP), VESPER_OK) });
    }
    // SAFETY: no pointer is given.
    unsafe { assert_eq!((vesper_engine_free(handle), vesper_engine_free(empty_handle)), (VESPER_OK, VESPER_OK)) };
    Ok(least_of)
}

/// Runs that much deeper in the stack, in steps of `BYTES`: where calls and engines meet in a page, and how they lie in cache
/// lines, makes ten nanoseconds and more.
fn deeper<const BYTES: usize>(levels: usize, turn: usize) -> Result<[f64; 6], Faults> {
    let room = std::hint::black_box([0_u8; BYTES]);
    let least = if levels == 0 { race(turn) } else { deeper::<BYTES>(levels - 1, turn) };
    std::hint::black_box(room);
    least
}

fn main() -> Result<(), Faults> {
    let mut best: [Vec<f64>; 6] = Default::default();
    for turn in 0..ENGINES {
        let levels = turn * 31 % 23;
        let least = match turn % 4 {
            0 => deeper::<16>(levels, turn),
            1 => deeper::<32>(levels, turn),
            2 => deeper::<48>(levels, turn),
            _ => deeper::<64>(levels, turn),
        };
        best.iter_mut().zip(least?).for_each(|(all, least)| all.push(least));
    }
    let [step, step_c, frame, frame_c, idle, idle_c] = best;
    print("step of two bodies", &step, &step_c);
    print("frame of two bodies", &frame, &frame_c);
    print("frame with nothing to do", &idle, &idle_c);
    Ok(())
}
