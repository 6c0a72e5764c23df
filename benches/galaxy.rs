//! The scene `examples/scenes/c9-galaxy.toml`: 1536 suns around a heavy core, every pair attracts. A frame is a step of leapfrog.
//!
//! Frames per second on one thread and on two. The error is that of the forces in the first frame: the root mean square of
//! |F - F_ref| / |F_ref| beside f64 without estimates, from the places of f64. Printed beside it is what the energy has changed by at the
//! scene's end, 400 frames on, in parts of it: that is the method's.

use std::path::Path;
use vesper::prelude::*;
use vesper_benches::{Case, Contender, Race, Run, Summary, Time};
use vesper_cli::assemble;
use vesper_cli::scene::Scene;
use vesper_laws::catalog::CatalogPrecision;

const STAYS: &str = "the suns stay finite";

fn engine<P: CatalogPrecision>(scene: &Scene, threads: usize) -> Engine<P> {
    let builder = assemble::builder::<P>(scene).expect("the scene is one");
    builder.threads(threads).build().expect("the scene has all that the laws read")
}

/// The forces on all suns.
fn forces<P: CatalogPrecision>(scene: &Scene, estimates: bool) -> Vec<f64> {
    let builder = assemble::builder::<P>(scene).expect("the scene is one").observe("bodies", Force);
    let mut engine = builder.threads(1).estimates(estimates).build().expect("the scene has all that the laws read");
    // So short that no place changes by what its last digits are, in f32.
    engine.steps_of(1, 1e-12).expect(STAYS);
    engine.state().numbers("bodies", Force).expect("it is observed")
}

fn study<P: CatalogPrecision>(scene: &Scene, run: Run, summary: &mut Summary) {
    let (exact, found) = (forces::<f64>(scene, false), forces::<P>(scene, true));
    let square = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
    let rows = exact.chunks_exact(3).zip(found.chunks_exact(3));
    let squares: f64 = rows.map(|(exact, found)| square(exact, found) / square(exact, &[0.0; 3])).sum();
    let error = (3.0 * squares / exact.len() as f64).sqrt();
    assert!(error < 1e4 * P::EPSILON, "an error of {error:e}");

    let step = scene.engine.step.as_ref().map_or(0.01, |step| step.value);
    let mut engines = [1, 2].map(|threads| engine::<P>(scene, threads));
    let mut contenders: Vec<_> = engines
        .iter_mut()
        .zip(["one thread", "two threads"])
        .map(|(engine, name)| Contender::new(name, || engine.steps_of(1, step).expect(STAYS)))
        .collect();
    let times = Race::default().run(run, 1.0, &mut contenders);
    drop(contenders);
    let [one, two] = times[..] else { return };
    let milli = |time: Time| Time { median: time.median / 1e6, low: time.low / 1e6, high: time.high / 1e6, ..time };
    let rows = exact.len() / 3;
    let case = |threads| Case {
        name: "galaxy frame",
        n: rows,
        threads,
        precision: P::NAME,
        unit: "ms/frame",
        error: Some(error),
    };
    summary.add(case(1), milli(one), &[]);
    summary.add(case(2), milli(two), &[(milli(one), None)]);
    if run == Run::Measure {
        let mut engine = engine::<P>(scene, 2);
        let begun = engine.energy().expect("the laws know it").0;
        engine.steps_of(400, step).expect(STAYS);
        let change = engine.energy().expect("the laws know it").0 / begun - 1.0;
        let [one, two] = [one, two].map(|time| 1e9 / time.median);
        println!(
            "    {}: {one:.0} frames a second on one thread, {two:.0} on two; energy {change:+.1e} after 400 frames",
            P::NAME
        );
    }
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let mut summary = Summary::new("galaxy", run);
    if run.wants("galaxy") {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let scene = Scene::read(&root.join("../examples/scenes/c9-galaxy.toml"), &[]).expect("the scene can be read");
        study::<f32>(&scene, run, &mut summary);
        study::<f64>(&scene, run, &mut summary);
    }
    summary.write()
}
