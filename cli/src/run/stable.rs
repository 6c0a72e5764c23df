//! Whether a step is too long for an explicit integrator, told before the run.
//!
//! In: an engine at its start, a step. Out: a line that says which limit, which step, and what to do; nothing where the step is
//! short enough, or where the answer would cost much beside the run. Never: a change of the engine's state.

use vesper::prelude::*;

use crate::output::rounded;

/// Rows, links and pairs up to which the laws' derivatives are asked for: some tenths of a second.
const MOST_TERMS: u64 = 300_000;

/// How long a step of the engine's integrator may be at the state as it is, where that is known.
pub fn longest<P: Precision>(engine: &mut Engine<P>) -> Option<StableStep> {
    if engine.terms() > MOST_TERMS {
        return None;
    }
    // What is wrong with the state the run itself says.
    engine.stable_step().ok().flatten().filter(|stable| stable.usable.is_finite())
}

/// In words, that a step is longer than the integrator bears; `None` where it is not.
pub fn too_long(integrator: &str, step: f64, stable: &StableStep) -> Option<String> {
    // What is known of the fastest rate is some thousandths too little.
    if step <= 1.001 * stable.usable {
        return None;
    }
    let [decay, frequency] = stable.rate;
    let rate = match (decay > 0.0, frequency > 0.0) {
        (true, true) => format!("oscillate at {} rad/s and decay at {} /s", rounded(frequency, 3), rounded(decay, 3)),
        (false, true) => format!("oscillate at {} rad/s", rounded(frequency, 3)),
        _ => format!("decay at {} /s", rounded(decay, 3)),
    };
    Some(format!(
        "{integrator} is stable up to steps of {} s here, where laws {rate}, and the step is {} s: take a shorter one, or \
         implicit_midpoint, or implicit_euler",
        rounded(stable.usable, 3),
        rounded(step, 4)
    ))
}
