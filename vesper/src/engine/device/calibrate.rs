//! Where laws run that are to run where a step takes least.
//!
//! In: laws, a state, an integrator. Out: the same laws, each with a place, and what was found. Steps are taken on copies of the state, so
//! short that nothing moves, with all that they bring and take back, and the client's looks at what it observes. First all laws are here,
//! then all that can are there; then each in turn changes sides. Never: a state that has moved.

use crate::engine::lent::with_runner;
use crate::error::Faults;
use crate::integrate::Integrator;
use crate::pipeline::{FusedChain, Key, Listed, Machine, Pipeline, Settings, lent_columns};
use crate::real::Scalar;
use crate::registry::Backend;
use crate::state::State;
use std::time::{Duration, Instant};

/// Timed steps, the shortest of which counts: another process may have had the processor during the others.
const STEPS: usize = 5;
/// Where steps take as long together, no more are timed.
const LONG: Duration = Duration::from_millis(300);
/// What has to be gained by a change of sides: less may be noise.
const GAIN: f64 = 0.95;
/// Steps are so much shorter than the run's.
const SHORT: f64 = 1e-6;

/// A pipeline, and lines for people.
type Found<P> = (Pipeline<P>, Vec<String>);

/// Gives laws that are to run where a step takes least a place, and makes the pipeline anew.
pub(in crate::engine) fn calibrated<P: Scalar>(
    pipeline: Pipeline<P>,
    (laws, chains, machine): (&mut [Listed<P>], &[FusedChain<P>], &mut Machine),
    (state, integrator): (&mut State<P>, &mut dyn Integrator),
    (observe, settings, step): (&[(String, String)], Settings, Option<f64>),
) -> Result<Found<P>, Faults> {
    let asks = |law: &usize| laws[*law].entry.options.backend == Backend::Fastest;
    let free: Vec<usize> = (0..laws.len()).filter(asks).collect();
    let lends = lent_columns(state).next().is_some();
    let why = match &machine.device {
        _ if free.is_empty() => return Ok((pipeline, Vec::new())),
        Some(Err(reason)) => Some(reason.as_str()),
        None => Some("no device was opened"),
        // A step would change what is the client's.
        Some(Ok(_)) if lends => Some("memory is lent, in which no steps are tried"),
        Some(Ok(_)) => None,
    };
    if let Some(why) = why {
        return Ok((pipeline, vec![format!("not calibrated, all laws run on the host: {why}")]));
    }
    let mut trial =
        Trial { laws, chains, machine, state, integrator, observe, settings, step: step.unwrap_or(1e-3) * SHORT };
    let mut there = vec![false; free.len()];
    let here = trial.seconds(&free, &there)?;
    let all = trial.seconds(&free, &vec![true; free.len()])?;
    let mut lines = vec![format!(
        "calibrated: a step takes {} with all laws on the host, {} with all that can be on the graphics processor",
        told(here),
        told(all)
    )];
    let mut least = here;
    if all < GAIN * here {
        (least, there) = (all, vec![true; free.len()]);
    }
    // With one law that was all there is.
    for number in (0..free.len()).filter(|_| free.len() > 1) {
        there[number] = !there[number];
        let seconds = trial.seconds(&free, &there)?;
        if seconds < GAIN * least {
            let (side, law) = (side(there[number]), trial.laws[free[number]].entry.label());
            lines.push(format!("  {} with {law} {side}", told(seconds)));
            least = seconds;
        } else {
            there[number] = !there[number];
        }
    }
    trial.place(&free, &there);
    let Trial { laws, chains, machine, state, integrator, .. } = trial;
    let pipeline = Pipeline::new(laws, chains, state, &*integrator, observe, settings, machine)?;
    let placed = |law: &usize| format!("  {}: {}", laws[*law].entry.label(), side(pipeline.is_on_device(*law)));
    lines.extend(free.iter().map(placed));
    Ok((pipeline, lines))
}

fn side(there: bool) -> &'static str {
    if there { "on the graphics processor" } else { "on the host" }
}

fn told(seconds: f64) -> String {
    format!("{:.3} ms", 1e3 * seconds)
}

/// What steps are tried with.
struct Trial<'a, P: Scalar> {
    laws: &'a mut [Listed<P>],
    chains: &'a [FusedChain<P>],
    machine: &'a mut Machine,
    state: &'a mut State<P>,
    integrator: &'a mut dyn Integrator,
    observe: &'a [(String, String)],
    settings: Settings,
    step: f64,
}

impl<P: Scalar> Trial<'_, P> {
    fn place(&mut self, free: &[usize], there: &[bool]) {
        for (law, there) in free.iter().zip(there) {
            self.laws[*law].entry.options.backend = if *there { Backend::Gpu } else { Backend::Auto };
        }
    }

    /// The shortest of some steps, in s, with these laws there; infinite where they cannot be taken.
    fn seconds(&mut self, free: &[usize], there: &[bool]) -> Result<f64, Faults> {
        self.place(free, there);
        let mut state = self.state.clone();
        let Trial { laws, chains, machine, integrator, observe, settings, step, .. } = self;
        let mut pipeline = Pipeline::new(laws, chains, &mut state, &**integrator, observe, *settings, machine)?;
        let (mut least, begun) = (0.0, Instant::now());
        let memory = integrator.memory();
        // The first step brings everything there, and does not count where others follow.
        for number in 0..=STEPS {
            let begin = Instant::now();
            let shared = (&**laws, *chains, &**machine);
            // Step 0, on which every law is due.
            let done = with_runner(&mut pipeline, &state, shared, (state.time().to_f64(), 0), |runner| {
                let done = integrator.step(runner, *step).and_then(|()| integrator.finish(runner));
                runner.run(Key::Observe);
                done.is_ok()
            });
            if done != Ok(true) {
                least = f64::INFINITY;
                break;
            }
            for (domain, property) in *observe {
                // It was found when the pipeline was made.
                let _ = state.column(domain, property).map(|column| column.components().is_some());
            }
            pipeline.finish();
            let took = begin.elapsed().as_secs_f64();
            least = if number <= 1 { took } else { least.min(took) };
            if begun.elapsed() > LONG {
                break;
            }
        }
        integrator.set_memory(&memory);
        integrator.restart();
        Ok(least)
    }
}
