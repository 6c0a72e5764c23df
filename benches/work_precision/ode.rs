//! The runs of a task by `ode_solvers`, with a right-hand side as a careful user writes it: each pair once, plain arrays.

use super::compared::Curve;
use crate::{Task, shortest};
use ode_solvers::dop_shared::OutputType;
use ode_solvers::{Dop853, Dopri5, SVector, System};
use std::time::Instant;

/// Two methods that are alike.
#[derive(Debug)]
pub struct Method {
    /// Ours.
    pub ours: &'static str,
    /// Theirs.
    theirs: &'static str,
}

/// What is compared.
pub const METHODS: [Method; 3] = [
    Method { ours: "dormand_prince_5", theirs: "Dopri5" },
    Method { ours: "dormand_prince_8", theirs: "Dop853" },
    // The best of both for this kind of problem.
    Method { ours: "nystrom_12", theirs: "Dop853" },
];

/// Bodies that attract each other: positions of all, then velocities of all.
struct Bodies {
    parameters: Vec<f64>,
}

impl<const N: usize> System<f64, SVector<f64, N>> for Bodies {
    fn system(&self, _time: f64, y: &SVector<f64, N>, rates: &mut SVector<f64, N>) {
        let (y, rates) = (y.as_slice(), rates.as_mut_slice());
        let half = y.len() / 2;
        let (places, velocities) = y.split_at(half);
        let (moving, forces) = rates.split_at_mut(half);
        moving.copy_from_slice(velocities);
        forces.fill(0.0);
        for i in 0..self.parameters.len() {
            for j in 0..i {
                let d: [f64; 3] = core::array::from_fn(|c| places[3 * j + c] - places[3 * i + c]);
                let square = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                let by = 1.0 / (square * square.sqrt());
                for c in 0..3 {
                    forces[3 * i + c] += self.parameters[j] * by * d[c];
                    forces[3 * j + c] -= self.parameters[i] * by * d[c];
                }
            }
        }
    }
}

/// A method with each of its tolerances.
pub fn curve(task: &Task, method: &Method, tolerances: &[f64]) -> Curve {
    let numbers = 6 * task.case.bodies.len();
    let points = tolerances.iter().map(|tolerance| match numbers {
        18 => point::<18>(task, method, *tolerance),
        36 => point::<36>(task, method, *tolerance),
        _ => unreachable!("the tasks are of three and of six bodies"),
    });
    Curve { name: format!("ode_solvers {}", method.theirs), points: points.collect() }
}

/// The error and the shortest time of some runs.
fn point<const N: usize>(task: &Task, method: &Method, tolerance: f64) -> (f64, Vec<f64>) {
    let (shortest, moments) = shortest(|| run::<N>(task, method, tolerance));
    (task.error(&moments), vec![shortest])
}

/// The time of one run and what it comes to, of vectors whose length the compiler knows.
fn run<const N: usize>(task: &Task, method: &Method, tolerance: f64) -> (f64, Vec<[Vec<f64>; 2]>) {
    let bodies = &task.case.bodies;
    let parameters: Vec<f64> = bodies.iter().map(|body| task.gravity * body.mass).collect();
    let numbers = bodies.iter().flat_map(|body| body.position).chain(bodies.iter().flat_map(|body| body.velocity));
    let (mut time, mut state) = (task.problem.start, SVector::<f64, N>::from_iterator(numbers));
    let (mut spent, mut moments) = (0.0, Vec::new());
    for &end in &task.problem.times {
        let system = Bodies { parameters: parameters.clone() };
        let begin = Instant::now();
        let (way, most, output) = (end - time, u32::MAX, OutputType::Sparse);
        // A component that stays zero needs some tolerance. Their defaults, but for the output, a state for each step without a dense one, and for the most steps.
        let last = if method.theirs == "Dopri5" {
            let mut stepper = Dopri5::from_param(
                system, time, end, way, state, tolerance, 1e-30, 0.9, 0.04, 0.2, 10.0, way, 0.0, most, most, output,
            );
            stepper.integrate().ok().and_then(|_| stepper.y_out().last().copied())
        } else {
            let mut stepper = Dop853::from_param(
                system, time, end, way, state, tolerance, 1e-30, 0.9, 0.0, 0.333, 6.0, way, 0.0, most, most, output,
            );
            stepper.integrate().ok().and_then(|_| stepper.y_out().last().copied())
        };
        spent += begin.elapsed().as_secs_f64();
        let Some(last) = last else { break };
        let (places, velocities) = last.as_slice().split_at(N / 2);
        moments.push([places.to_vec(), velocities.to_vec()]);
        (time, state) = (end, last);
    }
    (spent, moments)
}
