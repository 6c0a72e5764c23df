//! The runs of a task by `ode_solvers`, with a right-hand side as a careful user writes it: each pair once, plain arrays.

use super::compared::Curve;
use crate::Task;
use ode_solvers::{DVector, Dop853, Dopri5, System};
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
pub const METHODS: [Method; 2] =
    [Method { ours: "dormand_prince_5", theirs: "Dopri5" }, Method { ours: "dormand_prince_8", theirs: "Dop853" }];

/// Bodies that attract each other: positions of all, then velocities of all.
struct Bodies {
    parameters: Vec<f64>,
}

impl System<f64, DVector<f64>> for Bodies {
    fn system(&self, _time: f64, y: &DVector<f64>, rates: &mut DVector<f64>) {
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
    let points = tolerances.iter().map(|tolerance| {
        let bodies = &task.case.bodies;
        let parameters: Vec<f64> = bodies.iter().map(|body| task.gravity * body.mass).collect();
        let start: Vec<f64> =
            bodies.iter().flat_map(|body| body.position).chain(bodies.iter().flat_map(|body| body.velocity)).collect();
        let (mut time, mut state) = (task.problem.start, DVector::from_vec(start));
        let (mut spent, mut moments) = (0.0, Vec::new());
        for &end in &task.problem.times {
            let system = Bodies { parameters: parameters.clone() };
            let begin = Instant::now();
            let last = match method.theirs {
                "Dopri5" => {
                    let mut stepper = Dopri5::new(system, time, end, end - time, state.clone(), *tolerance, 1e-30);
                    stepper.integrate().ok().and_then(|_| stepper.y_out().last().cloned())
                }
                _ => {
                    let mut stepper = Dop853::new(system, time, end, end - time, state.clone(), *tolerance, 1e-30);
                    stepper.integrate().ok().and_then(|_| stepper.y_out().last().cloned())
                }
            };
            spent += begin.elapsed().as_secs_f64();
            let Some(last) = last else { break };
            let (places, velocities) = last.as_slice().split_at(last.len() / 2);
            moments.push([places.to_vec(), velocities.to_vec()]);
            (time, state) = (end, last);
        }
        (task.error(&moments), vec![spent])
    });
    Curve { name: format!("ode_solvers {}", method.theirs), points: points.collect() }
}
