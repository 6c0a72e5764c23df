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
/// What is run in turns.
struct Study {
    shape: Shape,
    bodies: usize,
    /// Errors that are asked for.
    errors: &'static [f64],
    all_pairs: bool,
    barnes_hut: bool,
}

const fn study_of(shape: Shape, bodies: usize, errors: &'static [f64], all_pairs: bool, barnes_hut: bool) -> Study {
    Study { shape, bodies, errors, all_pairs, barnes_hut }
}

const STUDIES: [Study; 8] = [
    study_of(Shape::Plummer, 4096, &[1.2e-3], true, false),
    study_of(Shape::Plummer, 8192, &[1.2e-3, 1e-5], true, false),
    study_of(Shape::Plummer, 50_000, &[1e-5], true, false),
    study_of(Shape::Plummer, 100_000, &[1.2e-3, 1e-5], false, true),
    study_of(Shape::Plummer, 1_000_000, &[1.3e-3], false, false),
    study_of(Shape::Disc, 50_000, &[1e-5], true, false),
    study_of(Shape::Disc, 100_000, &[1.2e-3, 1e-5], false, true),
    study_of(Shape::Disc, 1_000_000, &[1.3e-3], false, false),
];
/// Bodies of each distribution of which the error is looked at, and errors that are asked for.
const LOOKED_AT: (usize, [f64; 3]) = (20_000, [1e-2, 1e-3, 1e-4]);
/// Of bodies on a line or at two points errors are smaller than what is asked for: they come out exactly, or nearly so.
const EASY: [Shape; 2] = [Shape::Line, Shape::Point];

fn engine<P: Precision>(bodies: &Cloud, error: Option<f64>, threads: usize) -> Engine<P> {
    let law = Gravity { g: 1.0, softening: SOFTENING };
    let builder = Engine::builder().domain(bodies.domain()).law(Motion).integrator(SemiImplicitEuler).step(STEP);
    let builder = match error {
        Some(error) => builder.law(law.far_field(error)),
        None => builder.law(law),
    };
    builder.threads(threads).strict().build().expect("the scene has all that the laws read")
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

/// Far fields to the errors that are asked for, on one thread and on two, beside others.
fn study(words: &str, asked: &Study, run: Run, summary: &mut Summary) {
    let n = asked.bodies;
    let bodies = Cloud::new(asked.shape, n, 0.0);
    let (mut contenders, mut found, mut beside_error) = (Vec::new(), Vec::new(), Vec::new());
    for error in asked.errors {
        for threads in [1, 2] {
            let mut far = engine::<f32>(&bodies, Some(*error), threads);
            if threads == 1 {
                found.push(bodies.error_of_step(SOFTENING, &mut far));
            }
            let name = if threads == 1 { "one thread" } else { "two threads" };
            contenders.push(Contender::new(name, move || far.steps_of(1, STEP).expect(STAYS)));
        }
        let last = found[found.len() - 1];
        assert!(last < 1.5 * error, "asked {error:e}, found {last:e}");
    }
    if asked.all_pairs {
        let mut direct = engine::<f32>(&bodies, None, 1);
        beside_error.push(Some(bodies.error_of_step(SOFTENING, &mut direct)));
        contenders.push(Contender::new("all pairs", move || direct.steps_of(1, STEP).expect(STAYS)));
    }
    if asked.barnes_hut {
        let (contender, error) = barnes_hut(&bodies, 0.5);
        beside_error.push(Some(error));
        contenders.push(contender);
    }
    if n >= 1_000_000 {
        // What a tenth of the bodies takes at the same time, not for each body: linear would be a tenth.
        let bodies = Cloud::new(asked.shape, n / 10, 0.0);
        let mut far = engine::<f32>(&bodies, Some(1.2e-3), 1);
        beside_error.push(Some(bodies.error_of_step(SOFTENING, &mut far)));
        contenders.push(Contender::new("a tenth of the bodies", move || far.steps_of(1, STEP).expect(STAYS)));
    }
    let times = Race { rounds: 7, ..Race::default() }.run(run, n as f64, &mut contenders);
    let (ours, peers) = times.split_at(2 * asked.errors.len());
    let peers: Vec<_> = peers.iter().copied().zip(beside_error).collect();
    for ((times, error), found) in ours.chunks_exact(2).zip(asked.errors).zip(&found) {
        let name = format!("{words} to {error:e}");
        let case = |threads| Case { name: &name, n, threads, precision: "f32", unit: "ns/body", error: Some(*found) };
        // Barnes-Hut as it is comes to some 2e-3: beside that, and not beside smaller errors.
        let comparable = !asked.barnes_hut || *error > 1e-3;
        summary.add(case(1), times[0], if comparable { &peers } else { &[] });
        summary.add(case(2), times[1], &[(times[0], Some(*found))]);
    }
}

/// The error that is found where another one is asked for, in f64, and the time beside all pairs.
fn distributions(run: Run, summary: &mut Summary) {
    let (n, asked) = LOOKED_AT;
    for (words, shape) in Shape::ALL {
        let bodies = Cloud::new(shape, n, 0.0);
        let mut direct = engine::<f64>(&bodies, None, 1);
        let exact = bodies.error_of_step(SOFTENING, &mut direct);
        let mut contenders = vec![Contender::new("all pairs", move || direct.steps_of(1, STEP).expect(STAYS))];
        let errors = asked.map(|asked| {
            let mut far = engine::<f64>(&bodies, Some(asked), 1);
            let error = bodies.error_of_step(SOFTENING, &mut far);
            let least = if EASY.contains(&shape) { 0.0 } else { asked / 3.0 };
            assert!((least..3.0 * asked).contains(&error), "{words}: asked {asked:e}, found {error:e}");
            contenders.push(Contender::new("far field", move || far.steps_of(1, STEP).expect(STAYS)));
            error
        });
        let times = Race { rounds: 5, ..Race::default() }.run(run, n as f64, &mut contenders);
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
    for asked in if run == Run::Test { &STUDIES[..1] } else { &STUDIES[..] } {
        let words = if asked.shape == Shape::Disc { "galaxy disc" } else { "Plummer sphere" };
        if run.wants(&format!("far_field/{words}/{}", asked.bodies)) {
            study(words, asked, run, &mut summary);
        }
    }
    if run.wants("far_field/distributions") {
        distributions(run, &mut summary);
    }
    summary.write()
}
