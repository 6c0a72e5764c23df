//! Far fields: gravitation of a Plummer sphere with a requested error, beside the Barnes-Hut method of `particular` and beside all
//! pairs. One step of an engine, trees and all; errors are root mean squares of |a - a_ref| / |a_ref| over a sample of the bodies.

use particular::ComputeMethod;
use particular::sequential::BarnesHutSoftened;
use particular::storage::{ParticleSystem, ParticleTree, PointMass};
use vesper::prelude::*;
use vesper_benches::scenes::{Plummer, STEP};
use vesper_benches::{Case, Contender, Race, Run, Summary};
use vesper_laws::{Gravity, Motion};

const SOFTENING: f64 = 1.0 / 128.0;
const STAYS: &str = "the bodies stay finite";
/// Bodies, errors that are asked for, and whether all pairs and Barnes-Hut run beside them.
const STUDIES: [(usize, &[f64], bool, bool); 4] = [
    (8192, &[1.2e-3, 1e-5], true, false),
    (50_000, &[1e-5], true, false),
    (100_000, &[1.2e-3, 1e-5], false, true),
    (1_000_000, &[1.3e-3], false, false),
];

fn engine(bodies: &Plummer, error: Option<f64>) -> Engine<f32> {
    let law = Gravity { g: 1.0, softening: SOFTENING };
    let builder = Engine::builder().domain(bodies.domain()).law(Motion).integrator(SemiImplicitEuler).step(STEP);
    let builder = match error {
        Some(error) => builder.law(law.far_field(error)),
        None => builder.law(law),
    };
    builder.threads(1).strict().build().expect("the scene has all that the laws read")
}

/// The error of one step from rest: velocities are accelerations then.
fn error_of(bodies: &Plummer, engine: &mut Engine<f32>) -> f64 {
    engine.steps_of(1, STEP).expect(STAYS);
    let velocities = engine.state().numbers("bodies", Velocity).expect("the engine has velocities");
    bodies.error(SOFTENING, |row| [0, 1, 2].map(|axis| velocities[3 * row + axis] / STEP))
}

/// Barnes-Hut of `particular`, the tree made anew each time; with its error.
fn barnes_hut<'a>(bodies: &Plummer, theta: f32) -> (Contender<'a>, f64) {
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

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let mut summary = Summary::new("far_field", run);
    for (n, errors, all_pairs, beside) in if run == Run::Test { &STUDIES[..1] } else { &STUDIES[..] } {
        if !run.wants(&format!("far_field/{n}")) {
            continue;
        }
        let bodies = Plummer::new(*n, 0.0);
        let (mut contenders, mut found) = (Vec::new(), Vec::new());
        for asked in *errors {
            let mut far = engine(&bodies, Some(*asked));
            let error = error_of(&bodies, &mut far);
            assert!(error < 1.5 * asked, "asked {asked:e}, found {error:e}");
            found.push(error);
            contenders.push(Contender::new("far field", move || far.steps_of(1, STEP).expect(STAYS)));
        }
        if *all_pairs {
            let mut direct = engine(&bodies, None);
            contenders.push(Contender::new("all pairs", move || direct.steps_of(1, STEP).expect(STAYS)));
        }
        if *beside {
            let (contender, error) = barnes_hut(&bodies, 0.5);
            println!("far_field particular Barnes-Hut 0.5, n={n}: rms error {error:.1e}");
            contenders.push(contender);
        }
        let times = Race { rounds: 7, ..Race::default() }.run(run, *n as f64, &mut contenders);
        let (ours, peers) = times.split_at(errors.len());
        for ((time, asked), error) in ours.iter().zip(*errors).zip(&found) {
            let name = format!("far field of {asked:e}");
            let case = Case { name: &name, n: *n, threads: 1, precision: "f32", unit: "ns/body" };
            let beside: Vec<_> = peers.iter().map(|peer| (*peer, Some(*error))).collect();
            summary.add(case, *time, &beside);
            if run == Run::Measure {
                println!(
                    "    {:.1} ms a step, rms error asked {asked:e}, found {error:.1e}",
                    time.median * *n as f64 / 1e6
                );
            }
        }
    }
    summary.write()
}
