//! Small scenes of extreme sizes and numbers: no panic, and a number that is none is always reported.

use crate::common::*;
use vesper::prelude::*;

/// Numbers from far below to far above everything, some of them 0.
fn number(random: &mut Random, reach: i32) -> f64 {
    match random.below(6) {
        0 => 0.0,
        1 => random.unit(),
        _ => random.unit() * 10_f64.powi(random.below(2 * reach as usize) as i32 - reach),
    }
}

fn bodies<P: Precision>(rows: usize, random: &mut Random, reach: i32) -> Domain<P> {
    let mut vectors =
        || -> Vec<[f64; 3]> { (0..rows).map(|_| core::array::from_fn(|_| number(random, reach))).collect() };
    let (position, velocity) = (vectors(), vectors());
    let mut numbers = |count: usize| -> Vec<f64> { (0..count).map(|_| number(random, reach)).collect() };
    let (mass, coefficient) = (numbers(rows), numbers(rows));
    let charged: Vec<u32> = (0..rows as u32).filter(|row| row % 3 == 0).collect();
    let charges = numbers(charged.len());
    Domain::new("bodies")
        .with(Position, position)
        .with(Velocity, velocity)
        .with(Mass, mass)
        .with(DragCoefficient, coefficient)
        .subset(Charge, charged, charges)
}

/// Runs one scene; whether it blew up.
fn run<P: Precision>(seed: u64) -> bool {
    let mut random = Random(seed);
    // Numbers that are finite in f32 too.
    let reach = [2, 20, 36][random.below(3)];
    let rows = [0, 1, 2, 3, 7, 8, 9, 15, 17, 33, 64][random.below(11)];
    let rows = if seed.is_multiple_of(64) { 511 + random.below(3) } else { rows };
    let mut builder = Engine::<P>::builder()
        .domain(bodies(rows, &mut random, reach))
        .domain(springs(rows))
        .field(ElectricField, Point { at: [0.0; 3], strength: number(&mut random, reach) })
        .step(number(&mut random, 10).abs().max(1e-12));
    builder = match random.below(3) {
        0 => builder.integrator(Leapfrog::default()),
        1 => builder.integrator(RungeKutta4),
        _ => builder.integrator(SemiImplicitEuler),
    };
    for law in 0..7 {
        builder = match (random.coin(), law) {
            (true, 0) => builder.law(Gravity { g: number(&mut random, reach), softening: number(&mut random, reach) }),
            (true, 1) => builder.law(Drag.every(1 + random.below(3) as u32)),
            (true, 2) => builder.law(Spring),
            (true, 3) => builder.law(Coulomb),
            (true, 4) => builder.law(Electric),
            (true, 5) => builder.law(Herd),
            (true, 6) => builder.law(Weight).law(Floor),
            _ => builder,
        };
    }
    if random.coin() {
        builder = builder.backend(Backend::Parallel).threads(2);
    }
    let mut engine = builder.law(Motion).build().unwrap();
    let step = number(&mut random, 10).abs().max(1e-12);
    let outcome = engine.steps_of(3, step);
    _ = engine.energy();
    let finite = ["position", "velocity"].into_iter().all(|property| {
        let column = engine.state().column("bodies", property).unwrap();
        column.components().unwrap().into_iter().flatten().all(|number| number.is_finite())
    });
    match outcome {
        Ok(()) => assert!(finite, "scene {seed} has numbers that are none, and nobody says so"),
        Err(faults) => {
            assert!(!finite, "scene {seed} is told off for nothing: {faults}");
            assert!(faults.iter().all(|fault| matches!(fault, Fault::BlowUp { .. })), "{faults}");
        }
    }
    !finite
}

#[test]
fn extreme_scenes_neither_panic_nor_hide_numbers_that_are_none() {
    let blown = (0..1500).filter(|&seed| run::<f64>(seed)).count() + (0..1500).filter(|&seed| run::<f32>(seed)).count();
    assert!((300..2700).contains(&blown), "{blown} of 3000 scenes blew up: the test tries both");
}
