//! `nystrom_12`: what it refuses, where its steps end, and what it costs beside others.

use vesper::prelude::*;
use vesper_laws::reference::{Cyclotron, Kepler, Problem};
use vesper_laws::{ElectricForce, Gravity, Motion};

fn tight() -> Nystrom12 {
    Nystrom12::new(Tolerance::relative(1e-13))
}

#[test]
fn eccentric_orbits_take_half_of_the_evaluations_that_order_8_takes() {
    let problem = Kepler { eccentricity: 0.9 };
    let run = |integrator: Box<dyn Integrator>| {
        let mut engine = problem.setup(Engine::<f64>::builder()).boxed_integrator(integrator).build().unwrap();
        // Not a whole number of orbits: there errors of the phase would not show.
        engine.advance(100.0).unwrap();
        (problem.error(&engine).unwrap(), engine.evaluations(), engine.tried_steps())
    };
    let (error, evaluations, [given_up, kept]) = run(Box::new(Nystrom12::new(Tolerance::relative(1e-11))));
    let (other, many, _) = run(Box::new(DormandPrince8::new(Tolerance::relative(1e-12))));
    println!("nystrom_12 {error:.1e} by {evaluations}, dormand_prince_8 {other:.1e} by {many}");
    assert!(error < 1e-9 && error < other && 2 * evaluations < many);
    // The step shrinks from each apocentre to the pericentre: foreseen, and not found out by trying.
    assert!(10 * given_up < kept, "{given_up} of {kept}");
}

#[test]
fn a_step_ends_where_a_charge_enters_a_field() {
    let place = |integrator: Box<dyn Integrator>| {
        let charge = Domain::new("charges")
            .with(Position, [[-1.0, 0.0, 0.0]])
            .with(Velocity, [[1.0, 0.5, 0.0]])
            .with(Mass, [2.0])
            .with(Charge, [1.0]);
        let plates = FieldBox { min: [0.0, -9.0, -9.0], max: [1.0, 9.0, 9.0], value: [0.0, 3.0, 0.0] };
        let plates = Boxes { boxes: vec![plates] };
        let builder = Engine::<f64>::builder().domain(charge).field(ElectricField, plates);
        let mut engine = builder.law(ElectricForce).law(Motion).boxed_integrator(integrator).build().unwrap();
        // In frames: a step from this side of the plates to the other would not see them.
        (0..10).for_each(|_| engine.advance(0.5).unwrap());
        engine.state().get("charges", Position, 0).unwrap()
    };
    // One second between the plates, accelerated by 1.5 m/s^2, then three seconds as fast as it is by then.
    let exact = DVec3::new(4.0, 0.5 * 5.0 + 0.75 + 3.0 * 1.5, 0.0);
    let off: f64 = (place(Box::new(tight())) - exact).length();
    assert!(off < 1e-12, "{off:e}");
}

#[test]
fn what_it_cannot_integrate_is_refused() {
    let fault = |builder: Builder<f64>| builder.integrator(tight()).build().err().unwrap().to_string();
    let turned = fault(Cyclotron::default().setup(Engine::builder()));
    assert!(turned.contains("nystrom_12 needs rates of momenta without momenta"), "{turned}");
    assert!(turned.contains("bodies.velocity"), "{turned}");
    let bodies = Domain::new("bodies").with(Position, [[0.0; 3], [1.0; 3]]).with(Velocity, [[0.0; 3]; 2]);
    let builder = Engine::builder().domain(bodies.with(Mass, [1.0; 2])).law(Gravity::default().every(2)).law(Motion);
    let seldom = fault(builder);
    assert!(seldom.contains("nystrom_12") && seldom.contains("on some steps only"), "{seldom}");
}

#[test]
fn it_goes_on_from_a_checkpoint_with_the_same_bits() {
    let problem = Kepler { eccentricity: 0.7 };
    let make = || problem.setup(Engine::<f64>::builder()).integrator(tight()).build().unwrap();
    let state = |engine: &Engine<f64>| {
        [engine.state().numbers("bodies", Position).unwrap(), engine.state().numbers("bodies", Velocity).unwrap()]
    };
    let mut whole = make();
    whole.advance(3.0).unwrap();
    let checkpoint = whole.checkpoint().unwrap();
    whole.advance(4.0).unwrap();
    let mut resumed = make();
    resumed.restore(&checkpoint).unwrap();
    resumed.advance(4.0).unwrap();
    assert_eq!(state(&whole), state(&resumed));
}
