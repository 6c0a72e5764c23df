//! A scene whose laws run here and there, by the words `backend` of its file alone.

use std::path::Path;

use vesper::backend::gpu::{Device, Transfers};
use vesper::prelude::*;
use vesper_cli::assemble;
use vesper_cli::scene::Scene;

const GALAXY: &str = include_str!("../../examples/scenes/c9-galaxy.toml");

/// Frames, each of one step.
const FRAMES: u64 = 50;

/// The galaxy with the force and the motion where these words say.
fn galaxy([force, motion]: [&str; 2]) -> Engine<f32> {
    let text = GALAXY
        .replace("name = \"motion\"", &format!("name = \"motion\"\nbackend = \"{motion}\""))
        .replace("name = \"gravity\"", &format!("name = \"gravity\"\nbackend = \"{force}\""));
    assert_eq!(text.matches("backend = ").count(), 2);
    let scene = Scene::from_text("galaxy.toml", &text, Path::new("."), &[]).unwrap();
    assemble::engine::<f32>(&scene).unwrap()
}

fn is_required() -> bool {
    std::env::var("VESPER_REQUIRE_GPU").is_ok_and(|required| required == "1")
}

/// What the client looks at after each frame; or at positions after the last one.
#[derive(Clone, Copy, Debug)]
enum Looks {
    Positions,
    All,
    InTheEnd,
}

/// What a run moved: columns to the device and to the host, in the first frame, in each later one, and when the client looked in the end.
#[derive(Debug, PartialEq)]
struct Moved {
    first: [u64; 2],
    later: [u64; 2],
    end: [u64; 2],
}

fn columns(now: Transfers, before: Transfers) -> [u64; 2] {
    let bodies = |bytes: u64| bytes / (1536 * 4);
    // A vector is one column, whatever it takes.
    assert!(bodies(now.uploaded) <= 3 * now.uploads && bodies(now.downloaded) <= 3 * now.downloads);
    [now.uploads - before.uploads, now.downloads - before.downloads]
}

fn run(places: [&str; 2], looks: Looks) -> (Moved, Engine<f32>) {
    let mut engine = galaxy(places);
    let look = |engine: &Engine<f32>, what: &[PropertyInfo]| {
        what.iter().for_each(|property| drop(engine.state().numbers("bodies", *property).unwrap()));
    };
    let (mut frames, mut before) = (Vec::new(), engine.transfers());
    let mut since = |engine: &Engine<f32>| {
        let now = engine.transfers();
        columns(now, core::mem::replace(&mut before, now))
    };
    for _ in 0..FRAMES {
        engine.advance(0.01).unwrap();
        match looks {
            Looks::Positions => look(&engine, &[Position.info()]),
            Looks::All => look(&engine, &[Position.info(), Velocity.info(), Mass.info()]),
            Looks::InTheEnd => {}
        }
        frames.push(since(&engine));
    }
    look(&engine, &[Position.info()]);
    let end = since(&engine);
    assert!(frames[2..].iter().all(|frame| *frame == frames[1]), "{frames:?}");
    (Moved { first: frames[0], later: frames[1], end }, engine)
}

#[test]
fn a_galaxy_moves_what_somebody_reads_and_nothing_else() {
    let device = match Device::open() {
        Ok(device) => device,
        Err(error) => {
            assert!(!is_required(), "{error}");
            eprintln!("on the host alone: {error}");
            let (moved, engine) = run(["gpu"; 2], Looks::Positions);
            assert_eq!(moved, Moved { first: [0, 0], later: [0, 0], end: [0, 0] });
            return assert!(engine.explain().contains("not on the graphics processor: "), "{}", engine.explain());
        }
    };
    let (none, host) = run(["cpu", "cpu"], Looks::Positions);
    assert_eq!(none, Moved { first: [0, 0], later: [0, 0], end: [0, 0] });

    // The force there, the motion here: places go there, forces come back. In the first frame masses go, too, and there are two
    // evaluations.
    let (mixed, there) = run(["gpu", "cpu"], Looks::Positions);
    assert_eq!(mixed, Moved { first: [3, 2], later: [1, 1], end: [0, 0] });

    // All there: places, velocities and masses go once, what is looked at comes back.
    let (all, looked) = run(["gpu", "gpu"], Looks::Positions);
    assert_eq!(all, Moved { first: [3, 1], later: [0, 1], end: [0, 0] });
    let (every, seen) = run(["gpu", "gpu"], Looks::All);
    // Masses never left.
    assert_eq!(every, Moved { first: [3, 2], later: [0, 2], end: [0, 0] });
    let (late, blind) = run(["gpu", "gpu"], Looks::InTheEnd);
    assert_eq!(late, Moved { first: [3, 0], later: [0, 0], end: [0, 1] });
    println!("on {}: {:?}", device.name(), blind.transfers());

    // Where laws run, and who looks, changes nothing but the order of the sums.
    let numbers = |engine: &Engine<f32>, property| engine.state().numbers("bodies", property).unwrap();
    for property in [Position.info(), Velocity.info()] {
        let of_host = numbers(&host, property);
        let size = of_host.iter().fold(0.0, |size, number| f64::max(size, number.abs()));
        let runs = [&there, &looked, &seen, &blind].map(|engine| numbers(engine, property));
        for run in &runs {
            let off = run.iter().zip(&of_host).fold(0.0, |off, (a, b)| f64::max(off, (a - b).abs()));
            assert!(off < 2e-6 * size, "{}: {off} of {size}", property.name);
        }
        assert!(runs[2] == runs[1] && runs[3] == runs[1]);
        // Lavapipe rounds products and sums as the host does.
        assert!(runs[0] == runs[1] || !device.name().contains("llvmpipe"));
    }
}

/// What is printed before a run is what the run moves.
#[test]
fn explain_says_what_moves_and_for_whom() {
    if Device::open().is_err() {
        assert!(!is_required());
        return eprintln!("not run: there is no device");
    }
    let text = galaxy(["gpu", "cpu"]).explain();
    for line in [
        "  the first: 43008 bytes to the graphics processor: bodies.position for gravity, bodies.mass for gravity, bodies.position for gravity",
        "  each later one: 18432 bytes to the graphics processor: bodies.position for gravity",
        "  each later one: 18432 bytes to the host: bodies.force for motion",
    ] {
        assert!(text.lines().any(|told| told == line), "{line}\n{text}");
    }
    let text = galaxy(["gpu"; 2]).explain();
    assert!(text.contains("  each later one: nothing"), "{text}");
}
