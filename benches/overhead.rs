//! What a frame costs when there is nothing to do, what each law adds, and a small scene.

use bevy_ecs::prelude::{Component, Query};
use bevy_ecs::schedule::Schedule;
use bevy_ecs::world::World;
use std::hint::black_box;
use vesper::prelude::*;
use vesper_benches::hand::{Sprung, difference};
use vesper_benches::scenes::{Bodies, GRAVITY, Lattice, STEP};
use vesper_benches::{Case, Contender, Race, Run, Summary, Time, criterion, peers};
use vesper_laws::{Motion, Spring, UniformGravity};

/// Laws from whose time together the time of one is taken.
const LAWS: usize = 16;

/// Frames of one piece of work: the race's own call of it costs as much as an empty frame.
const FRAMES: f64 = 100.0;

fn frames(mut frame: impl FnMut()) -> impl FnMut() {
    move || (0..FRAMES as u32).for_each(|_| frame())
}

#[derive(Component)]
struct Weight(f64);
#[derive(Component)]
struct Sum(f64);

/// An engine of so many laws on so many rows.
fn engine(laws: usize, rows: usize) -> Engine<f64> {
    let mut builder = Engine::builder()
        .domain(Bodies::new(rows).moving())
        .constant(GravityAcceleration, [GRAVITY])
        .integrator(SemiImplicitEuler)
        .backend(Backend::Cpu)
        .step(STEP);
    if rows > 0 {
        builder = builder.law(Motion);
    }
    for law in 0..laws {
        builder = builder.law(UniformGravity.label(&format!("law {law}")));
    }
    builder.build().expect("the scene has all that the laws read")
}

fn add_weight(mut bodies: Query<(&mut Sum, &Weight)>) {
    for (mut sum, weight) in &mut bodies {
        sum.0 += weight.0;
    }
}

fn systems(systems: usize, rows: usize) -> (World, Schedule) {
    let mut world = World::new();
    world.spawn_batch((0..rows).map(|_| (Sum(0.0), Weight(1e-9))));
    let mut schedule = peers::bevy::schedule();
    for _ in 0..systems {
        schedule.add_systems(add_weight);
    }
    (world, schedule)
}

/// A list of closures over so many rows.
fn closures(count: usize, rows: usize) -> Vec<Box<dyn FnMut()>> {
    let closure = |_| -> Box<dyn FnMut()> {
        let (mut sums, weights) = (vec![0.0; rows], vec![1e-9; rows]);
        Box::new(move || {
            for (sum, weight) in sums.iter_mut().zip(&weights) {
                *sum += weight;
            }
        })
    };
    (0..count).map(closure).collect()
}

/// The time of one of the laws.
fn each(name: &'static str, none: Time, all: Time) -> Time {
    let of = |all: f64| (all - none.median).max(0.0) / LAWS as f64;
    Time { name, median: of(all.median), low: of(all.low), high: of(all.high) }
}

fn laws(rows: usize, run: Run, summary: &mut Summary, lines: &mut criterion::Criterion) {
    let name = format!("overhead/{rows} rows");
    let mut engines = [engine(0, rows), engine(LAWS, rows)];
    let mut worlds = [systems(0, rows), systems(LAWS, rows)];
    let mut lists = [closures(0, rows), closures(LAWS, rows)];
    // Written by hand there is no list of laws: a loop over the laws' numbers that the compiler cannot leave out.
    let mut sums = vec![0.0; rows];
    let [no_engine, engine] = &mut engines;
    let [no_world, world] = &mut worlds;
    let [no_list, list] = &mut lists;
    let stays = "the bodies stay finite";
    let by_hand = |laws: usize, sums: &mut [f64]| {
        for _ in 0..black_box(laws) {
            for sum in black_box(&mut *sums) {
                *sum += 1e-9;
            }
        }
    };
    let mut other_sums = sums.clone();
    let mut contenders = [
        Contender::new("engine, no law", frames(|| no_engine.advance(black_box(STEP)).expect(stays))),
        Contender::new("engine, 16 laws", frames(|| engine.advance(black_box(STEP)).expect(stays))),
        Contender::new("bevy_ecs, no system", frames(|| no_world.1.run(&mut no_world.0))),
        Contender::new("bevy_ecs, 16 systems", frames(|| world.1.run(&mut world.0))),
        Contender::new("no closure", frames(|| black_box(&mut *no_list).iter_mut().for_each(|law| law()))),
        Contender::new("16 closures", frames(|| black_box(&mut *list).iter_mut().for_each(|law| law()))),
        Contender::new("hand, no law", frames(|| by_hand(0, &mut sums))),
        Contender::new("hand, 16 laws", frames(|| by_hand(LAWS, &mut other_sums))),
    ];
    if run.wants(&name) {
        let times = Race::default().run(run, FRAMES, &mut contenders);
        let [no_law, laws, no_system, systems, no_closure, closures, no_hand, hand] = times[..] else { return };
        let case = |name| Case { name, n: rows, threads: 1, precision: "f64", unit: "ns", error: None };
        let named = |name, time| Time { name, ..time };
        let first = if rows == 0 { "advance of an empty engine" } else { "advance of motion alone" };
        let empty = [
            (named("bevy_ecs schedule", no_system), None),
            (named("Vec<Box<dyn FnMut>>", no_closure), None),
            (named("hand loop", no_hand), None),
        ];
        summary.add(case(first), no_law, if rows == 0 { &empty } else { &[] });
        let further = [
            (each("bevy_ecs system", no_system, systems), None),
            (each("Box<dyn FnMut>", no_closure, closures), None),
            (each("hand loop", no_hand, hand), None),
        ];
        summary.add(case("each further law"), each("law", no_law, laws), &further);
    }
    Race::lines(lines, &name, FRAMES, &mut contenders);
}

/// Four masses, joined by six springs, fall beside three that are immovable.
fn tetrahedron() -> Lattice {
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    let floor = [[-9.0, -9.0, -5.0], [9.0, -9.0, -5.0], [0.0, 9.0, -5.0]];
    let bodies = Bodies {
        position: corners.into_iter().chain(floor).collect(),
        velocity: vec![[0.0; 3]; 7],
        mass: [[1.0; 4].as_slice(), &[0.0; 3]].concat(),
        ..Bodies::default()
    };
    Lattice {
        bodies,
        ends: vec![[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]],
        stiffness: vec![1000.0; 6],
        rest_length: vec![2.75; 6],
    }
}

fn small_scene(run: Run, summary: &mut Summary, lines: &mut criterion::Criterion) {
    let name = "overhead/small scene";
    let scene = tetrahedron();
    let mut engine = Engine::<f64>::builder()
        .domain(scene.bodies.moving())
        .domain(scene.springs())
        .constant(GravityAcceleration, [GRAVITY])
        .law(UniformGravity)
        .law(Spring)
        .law(Motion)
        .integrator(SemiImplicitEuler)
        .backend(Backend::Cpu)
        .step(STEP)
        .strict()
        .build()
        .expect("the scene has all that the laws read");
    let mut hand = Sprung::<f64>::new(&scene);
    let stays = "the bodies stay finite";
    for _ in 0..64 {
        engine.advance(STEP).expect(stays);
        hand.step(GRAVITY);
    }
    let error = difference(&engine, Position, &hand.position).expect("the engine has places");
    assert!(error < 1e-12, "{name}: the same motion");
    let mut contenders = [
        Contender::new("engine", || engine.advance(STEP).expect(stays)),
        Contender::new("hand loop", || hand.step(GRAVITY)),
    ];
    if run.wants(name) {
        let times = Race::default().run(run, 1.0, &mut contenders);
        let [ours, hand] = times[..] else { return };
        let case =
            Case { name: "tetrahedron of six springs", n: 7, threads: 1, precision: "f64", unit: "ns", error: None };
        summary.add(case, ours, &[(hand, Some(error))]);
    }
    Race::lines(lines, name, 1.0, &mut contenders);
}

fn main() -> std::io::Result<()> {
    let run = Run::from_arguments();
    let (mut summary, mut lines) = (Summary::new("overhead", run), criterion());
    laws(0, run, &mut summary, &mut lines);
    laws(1, run, &mut summary, &mut lines);
    small_scene(run, &mut summary, &mut lines);
    lines.final_summary();
    summary.write()
}
