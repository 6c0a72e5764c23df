//! Our own runs of a task.

use super::compared::Curve;
use crate::{Task, shortest};
use std::time::Instant;
use vesper::prelude::*;
use vesper_cli::assemble::integrators::integrator;

/// An integrator, with these options, and each of its settings: steps, or tolerances.
pub fn curve(task: &Task, name: &str, settings: &[f64], options: &[(&str, f64)]) -> Curve {
    let known = integrator(name).expect("it is one of ours");
    let points = settings.iter().map(|setting| {
        let fixed = !(known.make)(&|_, usual| usual).is_adaptive();
        let option = |option: &str, usual: f64| match options.iter().find(|(name, _)| *name == option) {
            Some((_, value)) => *value,
            None if !fixed && known.options.first() == Some(&option) => *setting,
            None => usual,
        };
        let once = || {
            let made = (known.make)(&option);
            let configure = |builder: Builder<f64>| builder.boxed_integrator(made);
            let mut engine = task.problem.engine(configure).expect("it fits");
            let (mut spent, mut moments) = (0.0, Vec::new());
            for time in &task.problem.times {
                let way = time - engine.time();
                let begin = Instant::now();
                let count = (way / setting - 1e-9).ceil();
                let done = if fixed { engine.steps_of(count as u64, way / count) } else { engine.advance(way) };
                spent += begin.elapsed().as_secs_f64();
                // So coarse that bodies meet: no answer.
                if done.is_err() {
                    break;
                }
                let numbers = |property: vesper::property::PropertyInfo| {
                    engine.state().numbers("bodies", property).expect("it is there")
                };
                moments.push([numbers(Position::INFO), numbers(Velocity::INFO)]);
            }
            (spent, moments)
        };
        let (shortest, moments) = shortest(once);
        (task.error(&moments), vec![shortest])
    });
    let corrected = if options.is_empty() { "" } else { ", corrected" };
    Curve { name: format!("`{name}`{corrected}"), points: points.collect() }
}
