//! The galaxy of `examples/scenes/c9-galaxy.toml` on a graphics processor: where its laws run, and who looks, beside a program of three
//! kernels that was written for it by hand.
//!
//! Feature `gpu`: `cargo bench -p vesper-benches --features gpu --bench gpu`. Times are of a step, in f32, in frames of one step after
//! which places are looked at, or of fifty steps and one look. The error is that of places after fifty steps, beside f64 on the host: the
//! largest, in parts of the largest coordinate.

use std::path::Path;
use vesper::backend::gpu::Device;
use vesper::prelude::*;
use vesper_benches::hand::gpu::Suns;
use vesper_benches::{Case, Contender, Race, Run, Summary, Time};
use vesper_cli::assemble;
use vesper_cli::scene::Scene;
use vesper_laws::catalog::CatalogPrecision;

const STEPS: u32 = 50;
const STEP: f64 = 0.01;
const STAYS: &str = "the suns stay finite";
const SCENE: &str = "the scene is one";

/// The galaxy of so many suns, its laws where these words say.
fn galaxy<P: CatalogPrecision>(rows: usize, [force, motion]: [&str; 2]) -> Engine<P> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("../examples/scenes/c9-galaxy.toml")).expect("it is there");
    let text = text
        .replace("count = 1536", &format!("count = {rows}"))
        .replace("name = \"motion\"", &format!("name = \"motion\"\nbackend = \"{motion}\""))
        .replace("name = \"gravity\"", &format!("name = \"gravity\"\nbackend = \"{force}\""));
    let scene = Scene::from_text("galaxy.toml", &text, root, &[]).expect(SCENE);
    assemble::builder::<P>(&scene).expect(SCENE).threads(2).build().expect(SCENE)
}

/// All x first.
fn column<P: Precision>(engine: &Engine<P>, property: &str) -> Vec<P> {
    engine.state().column("bodies", property).expect("bodies have it").components().expect("it is owned").concat()
}

fn by_hand(engine: &Engine<f32>) -> Suns {
    let [places, velocities, masses] = ["position", "velocity", "mass"].map(|property| column(engine, property));
    Suns::new(&places, &velocities, &masses, 6.674_30e-11, 0.1)
}

/// The largest difference, in parts of the largest number.
fn apart(found: &[f32], exact: &[f64]) -> f64 {
    let largest = exact.iter().fold(0.0, |largest, number| f64::max(largest, number.abs()));
    found.iter().zip(exact).fold(0.0, |most, (a, b)| f64::max(most, (f64::from(*a) - b).abs())) / largest
}

fn study(rows: usize, run: Run, summary: &mut Summary) {
    let mut exact = galaxy::<f64>(rows, ["auto"; 2]);
    exact.steps_of(STEPS.into(), STEP).expect(STAYS);
    let exact = column(&exact, "position");
    let suns = by_hand(&galaxy(rows, ["cpu"; 2]));
    let by_hand_off = apart(&suns.places_after(STEPS, STEP as f32), &exact);
    let places = [["auto"; 2], ["gpu", "auto"], ["gpu"; 2]];
    let errors = places.map(|places| {
        let mut engine = galaxy::<f32>(rows, places);
        engine.steps_of(STEPS.into(), STEP).expect(STAYS);
        apart(&column(&engine, "position"), &exact)
    });
    assert!(errors.iter().chain([&by_hand_off]).all(|error| *error < 1e-5), "{errors:?}, by hand {by_hand_off:e}");

    let names = ["host", "force there", "all there"];
    let mut each = places.map(|places| galaxy::<f32>(rows, places));
    let mut once = places.map(|places| galaxy::<f32>(rows, places));
    let hand = [by_hand(&each[0]), by_hand(&each[0])];
    let mut contenders: Vec<Contender<'_>> = Vec::new();
    contenders.push(Contender::new("by hand, looked at each step", || {
        drop(hand[0].places_after(1, STEP as f32));
    }));
    for (engine, name) in each.iter_mut().zip(names) {
        contenders.push(Contender::new(name, || {
            engine.steps_of(1, STEP).expect(STAYS);
            drop(column(engine, "position"));
        }));
    }
    let each = Race::default().run(run, 1.0, &mut contenders);
    let mut contenders: Vec<Contender<'_>> = Vec::new();
    contenders.push(Contender::new("by hand, looked at once", || {
        drop(hand[1].places_after(STEPS, STEP as f32));
    }));
    for (engine, name) in once.iter_mut().zip(names) {
        contenders.push(Contender::new(name, || {
            engine.steps_of(STEPS.into(), STEP).expect(STAYS);
            drop(column(engine, "position"));
        }));
    }
    let once = Race { rounds: 41, ..Race::default() }.run(run, STEPS.into(), &mut contenders);
    let pairs = rows as f64 * (rows as f64 - 1.0);
    for (times, looks) in [(&each, "each step"), (&once, "once in 50")] {
        let milli = |time: Time| Time { median: time.median / 1e6, low: time.low / 1e6, high: time.high / 1e6, ..time };
        for ((time, name), error) in times[1..].iter().zip(names).zip(errors) {
            // A device has no threads of ours.
            let threads = if name == "host" { 2 } else { 0 };
            let name = format!("galaxy {name}; looks {looks}");
            let case = Case { name: &name, n: rows, threads, precision: "f32", unit: "ms/step", error: Some(error) };
            summary.add(case, milli(*time), &[(milli(times[0]), Some(by_hand_off))]);
        }
        if run == Run::Measure {
            let rate = times.iter().map(|time| format!("{:.2}", pairs / time.median)).collect::<Vec<_>>().join(", ");
            println!("    1e9 pairs/s, by hand, host, force there, all there: {rate}");
        }
    }
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let mut summary = Summary::new("gpu", run);
    match Device::open() {
        Ok(device) if run != Run::List => {
            println!("on {}", device.name());
            // Software takes a second for a step of the larger one.
            let sizes: &[usize] = if device.name().contains("llvmpipe") { &[1536] } else { &[1536, 16_384] };
            for rows in sizes.iter().filter(|rows| run.wants(&format!("gpu galaxy {rows}"))) {
                study(*rows, run, &mut summary);
            }
        }
        Ok(_) => {}
        Err(error) => println!("not run: {error}"),
    }
    summary.write()
}
