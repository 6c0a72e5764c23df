//! Integrates bodies with diffsol, for `cargo bench -- work_precision`.
//!
//! In: on standard input, one JSON object: `g`, `bodies` (mass, position, velocity of each), `times`, `scales` (of positions and velocities), `runs` (integrator, setting), `repeats` and `seconds`.
//! Out: on standard output, one JSON object: the version, and for each run the seconds that it took, and positions and velocities
//! at the times. Timed is the solver alone. The right-hand side is as a careful user writes it: each pair once, plain slices.

use diffsol::{NalgebraMat, OdeBuilder, OdeSolverMethod, OdeSolverStopReason};
use serde::{Deserialize, Serialize};
use std::error::Error;
use std::time::Instant;

#[derive(Deserialize)]
struct Asked {
    g: f64,
    /// Mass, position, velocity.
    bodies: Vec<(f64, [f64; 3], [f64; 3])>,
    times: Vec<f64>,
    /// Of positions, and of velocities.
    scales: [f64; 2],
    runs: Vec<Run>,
    /// Runs of each at least.
    repeats: usize,
    /// The time that they take at least.
    seconds: f64,
}

#[derive(Deserialize)]
struct Run {
    integrator: String,
    /// The relative tolerance.
    setting: f64,
}

#[derive(Serialize)]
struct Told {
    version: &'static str,
    runs: Vec<Done>,
}

#[derive(Serialize)]
struct Done {
    /// Of every repeat.
    seconds: Vec<f64>,
    /// Position and velocity of each body at each time.
    states: Vec<Vec<[Vec<f64>; 2]>>,
}

/// Rates of positions of all, then velocities of all.
fn rates(parameters: &[f64], y: &[f64], rates: &mut [f64]) {
    let half = y.len() / 2;
    let (places, velocities) = y.split_at(half);
    let (moving, forces) = rates.split_at_mut(half);
    moving.copy_from_slice(velocities);
    forces.fill(0.0);
    for i in 0..parameters.len() {
        for j in 0..i {
            let d: [f64; 3] = core::array::from_fn(|c| places[3 * j + c] - places[3 * i + c]);
            let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
            let by = 1.0 / (square * square.sqrt());
            for c in 0..3 {
                forces[3 * i + c] += parameters[j] * by * d[c];
                forces[3 * j + c] -= parameters[i] * by * d[c];
            }
        }
    }
}

fn run(asked: &Asked, run: &Run) -> Result<Done, Box<dyn Error>> {
    if run.integrator != "tsit45" {
        return Err(format!("no integrator is called {}", run.integrator).into());
    }
    let parameters: Vec<f64> = asked.bodies.iter().map(|(mass, ..)| asked.g * mass).collect();
    let positions = asked.bodies.iter().flat_map(|(_, position, _)| *position);
    let start: Vec<f64> = positions.chain(asked.bodies.iter().flat_map(|(.., velocity)| *velocity)).collect();
    let numbers = start.len();
    // A part of what is usual: components pass through zero.
    let tolerances = asked.scales.into_iter().flat_map(|scale| vec![run.setting * scale; numbers / 2]);
    let problem = OdeBuilder::<NalgebraMat<f64>>::new()
        .rtol(run.setting)
        .atol(tolerances)
        .rhs(|y: &[f64], _: &[f64], _, to: &mut [f64]| rates(&parameters, y, to))
        .init(|_: &[f64], _, to: &mut [f64]| to.copy_from_slice(&start), numbers)
        .build()?;
    let mut states = Vec::new();
    let begin = Instant::now();
    let mut solver = problem.tsit45()?;
    for time in &asked.times {
        solver.set_stop_time(*time)?;
        while !matches!(solver.step()?, OdeSolverStopReason::TstopReached) {}
        let state = solver.state();
        let (positions, velocities) = state.y.batch_as_slice(0).split_at(numbers / 2);
        let rows = positions.chunks(3).zip(velocities.chunks(3));
        states.push(rows.map(|(position, velocity)| [position.to_vec(), velocity.to_vec()]).collect());
    }
    Ok(Done { seconds: vec![begin.elapsed().as_secs_f64()], states })
}

fn main() -> Result<(), Box<dyn Error>> {
    let asked: Asked = serde_json::from_reader(std::io::stdin())?;
    // A run that ends early has no states: it came to no error.
    let runs = asked.runs.iter().map(|each| {
        let all = run(&asked, each).and_then(|mut all| {
            while all.seconds.len() < asked.repeats
                || all.seconds.iter().sum::<f64>() < asked.seconds && all.seconds.len() < 1000
            {
                all.seconds.extend(run(&asked, each)?.seconds);
            }
            Ok(all)
        });
        all.unwrap_or_else(|reason| {
            eprintln!("{}, {:e}: {reason}", each.integrator, each.setting);
            Done { seconds: vec![f64::NAN], states: Vec::new() }
        })
    });
    let runs = runs.collect();
    serde_json::to_writer(std::io::stdout(), &Told { version: "0.18", runs })?;
    Ok(())
}
