//! Far fields: gravitation with a requested error, beside the Barnes-Hut method of `particular` and beside all pairs. One step of an
//! engine, trees and all; errors are root mean squares of |a - a_ref| / |a_ref| over a sample of the bodies.
//!
//! A Plummer sphere and a galaxy's disc for the times; the errors that are found where others are asked for, over these and
//! distributions that are hard for trees.

use particular::ComputeMethod;
use particular::sequential::BarnesHutSoftened;
use particular::storage::{ParticleSystem, ParticleTree, PointMass};
use vesper::prelude::*;
use vesper_benches::scenes::{Cloud, STEP, Shape};
use vesper_benches::{Case, Contender, Race, Run, Summary};
use vesper_laws::{Gravity, Motion};

const SOFTENING: f64 = 1.0 / 128.0;
const STAYS: &str = "the bodies stay finite";
/// How bodies lie, how many, errors that are asked for, and whether all pairs and Barnes-Hut run beside them.
const STUDIES: [(Shape, usize, &[f64], bool, bool); 8] = [
    (Shape::Plummer, 4096, &[1.2e-3], true, false),
    (Shape::Plummer, 8192, &[1.2e-3, 1e-5], true, false),
    (Shape::Plummer, 50_000, &[1e-5], true, false),
    (Shape::Plummer, 100_000, &[1.2e-3, 1e-5], false, true),
    (Shape::Plummer, 1_000_000, &[1.3e-3], false, false),
    (Shape::Disc, 50_000, &[1e-5], true, false),
    (Shape::Disc, 100_000, &[1.2e-3, 1e-5], false, true),
    (Shape::Disc, 1_000_000, &[1.3e-3], false, false),
];
/// Bodies of each distribution of which the error is looked at, and errors that are asked for.
const LOOKED_AT: (usize, [f64; 3]) = (20_000, [1e-2, 1e-3, 1e-4]);

fn engine<P: Precision>(bodies: &Cloud, error: Option<f64>) -> Engine<P> {
    let law = Gravity { g: 1.0, softening: SOFTENING };
    let builder = Engine::builder().domain(bodies.domain()).law(Motion).integrator(SemiImplicitEuler).step(STEP);
    let builder = match error {
        Some(error) => builder.law(law.far_field(error)),
        None => builder.law(law),
    };
    builder.threads(1).strict().build().expect("the scene has all that the laws read")
}

/// The error of one step from rest: velocities are accelerations then.
fn error_of<P: Precision>(bodies: &Cloud, engine: &mut Engine<P>) -> f64 {
    engine.steps_of(1, STEP).expect(STAYS);
    let velocities = engine.state().numbers("bodies", Velocity).expect("the engine has velocities");
    bodies.error(SOFTENING, |row| [0, 1, 2].map(|axis| velocities[3 * row + axis] / STEP))
}

/// Barnes-Hut of `particular`, the tree made anew each time; with its error.
fn barnes_hut<'a>(bodies: &Cloud, theta: f32) -> (Contender<'a>, f64) {
    let mass = bodies.mass() as f32;
    let points: Vec<PointMass<ultraviolet::Vec3, f32>> = bodies
        .position
        .iter()
        .map(|place| {
            let [x, y, z] = place.map(|number| number as f32);
            PointMass::new(ultraviolet::Vec3::new(x, y, z), mass)
        })
        .collect();
    let run = move || {
        let tree = ParticleTree::<8, 3, ultraviolet::Vec3, f32>::from(&points[..]);
        let system = ParticleSystem { affected: &points[..], massive: &tree };
        BarnesHutSoftened { theta, softening: SOFTENING as f32 }.compute(system)
    };
    let found = run();
    let error = bodies.error(SOFTENING, |row| [found[row].x, found[row].y, found[row].z].map(f64::from));
    (Contender::new("particular Barnes-Hut 0.5", move || drop(std::hint::black_box(run()))), error)
}

/// The error that is found where another one is asked for, in f64, and the time beside all pairs.
fn distributions(summary: &mut Summary) {
    let (n, asked) = LOOKED_AT;
    for (words, shape) in Shape::ALL {
        let bodies = Cloud::new(shape, n, 0.0);
        let mut direct = engine::<f64>(&bodies, None);
        let exact = error_of(&bodies, &mut direct);
        let mut contenders = vec![Contender::new("all pairs", move || direct.steps_of(1, STEP).expect(STAYS))];
        let errors = asked.map(|asked| {
            let mut far = engine::<f64>(&bodies, Some(asked));
            let error = error_of(&bodies, &mut far);
            contenders.push(Contender::new("far field", move || far.steps_of(1, STEP).expect(STAYS)));
            error
        });
        let times = Race { rounds: 5, ..Race::default() }.run(Run::Measure, n as f64, &mut contenders);
        for ((time, asked), error) in times[1..].iter().zip(asked).zip(errors) {
            let name = format!("{words} to {asked:e}");
            let case = Case { name: &name, n, threads: 1, precision: "f64", unit: "ns/body", error: Some(error) };
            summary.add(case, *time, &[(times[0], Some(exact))]);
        }
    }
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let mut summary = Summary::new("far_field", run);
    for (shape, n, errors, all_pairs, beside) in if run == Run::Test { &STUDIES[..1] } else { &STUDIES[..] } {
        let words = if *shape == Shape::Disc { "galaxy disc" } else { "Plummer sphere" };
        if !run.wants(&format!("far_field/{words}/{n}")) {
            continue;
        }
        let bodies = Cloud::new(*shape, *n, 0.0);
        let (mut contenders, mut found, mut beside_error) = (Vec::new(), Vec::new(), Vec::new());
        for asked in *errors {
            let mut far = engine::<f32>(&bodies, Some(*asked));
            let error = error_of(&bodies, &mut far);
            assert!(error < 1.5 * asked, "asked {asked:e}, found {error:e}");
            found.push(error);
            contenders.push(Contender::new("far field", move || far.steps_of(1, STEP).expect(STAYS)));
        }
        if *all_pairs {
            let mut direct = engine::<f32>(&bodies, None);
            beside_error.push(Some(error_of(&bodies, &mut direct)));
            contenders.push(Contender::new("all pairs", move || direct.steps_of(1, STEP).expect(STAYS)));
        }
        if *beside {
            let (contender, error) = barnes_hut(&bodies, 0.5);
            beside_error.push(Some(error));
            contenders.push(contender);
        }
        let times = Race { rounds: 7, ..Race::default() }.run(run, *n as f64, &mut contenders);
        let (ours, peers) = times.split_at(errors.len());
        for ((time, asked), error) in ours.iter().zip(*errors).zip(&found) {
            let name = format!("{words} to {asked:e}");
            let case = Case { name: &name, n: *n, threads: 1, precision: "f32", unit: "ns/body", error: Some(*error) };
            let beside: Vec<_> = peers.iter().copied().zip(beside_error.iter().copied()).collect();
            summary.add(case, *time, &beside);
        }
    }
    if run == Run::Measure && run.wants("far_field/distributions") {
        distributions(&mut summary);
    }
    summary.write()
}
