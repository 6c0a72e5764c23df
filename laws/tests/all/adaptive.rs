//! Integrators that choose their steps: tolerances, rounding, and what happens where no step is short enough.

use vesper::prelude::*;
use vesper_laws::reference::{Kepler, Oscillator, Problem};
use vesper_laws::{Gravity, Motion};

fn at(problem: &impl Problem, integrator: impl Integrator + 'static, end: f64) -> Engine<f64> {
    let mut engine = problem.setup(Engine::<f64>::builder()).integrator(integrator).build().unwrap();
    engine.advance(end).unwrap();
    engine
}

#[test]
fn the_error_follows_the_tolerance() {
    let problem = Kepler { eccentricity: 0.6 };
    let error = |integrator: Box<dyn Integrator>| {
        let mut engine = problem.setup(Engine::<f64>::builder()).boxed_integrator(integrator).build().unwrap();
        engine.advance(20.0).unwrap();
        (problem.error(&engine).unwrap(), engine.evaluations())
    };
    let mut before = [f64::INFINITY; 2];
    for tenth in 4..11 {
        let tolerance = Tolerance::relative(10.0_f64.powi(-tenth));
        let (fifth, fifths) = error(Box::new(DormandPrince5::new(tolerance)));
        let (eighth, eighths) = error(Box::new(DormandPrince8::new(tolerance)));
        println!("{:.0e}: {fifth:.1e} in {fifths}, {eighth:.1e} in {eighths}", tolerance.relative);
        for error in [fifth, eighth] {
            assert!(error < 2e3 * tolerance.relative && error > 1e-2 * tolerance.relative, "{error} of {tolerance:?}");
        }
        assert!(fifth < 0.5 * before[0] && eighth < 0.5 * before[1], "a tenth of the tolerance, {before:?}");
        before = [fifth, eighth];
        assert!(tenth < 7 || eighths < fifths, "the higher order is cheaper for small errors");
    }
}

#[test]
fn gauss_radau_keeps_an_eccentric_orbit_to_rounding() {
    // 100 orbits of eccentricity 0.99, whose distance changes by a factor of 200.
    let problem = Kepler { eccentricity: 0.99 };
    let mut engine = problem.setup(Engine::<f64>::builder()).integrator(GaussRadau15::default()).build().unwrap();
    // Where they are farthest apart: at the other end the energy is a difference of numbers a hundred times as large.
    engine.advance(core::f64::consts::PI).unwrap();
    let before = engine.energy().unwrap().0;
    for _ in 0..100 {
        engine.advance(core::f64::consts::TAU).unwrap();
    }
    let change = (engine.energy().unwrap().0 / before - 1.0).abs();
    println!("energy {change:.1e}, {} evaluations", engine.evaluations());
    // 100 passages, each with roundings of about 5e-15, as a random walk.
    assert!(change < 1e-13, "{change}");
}

#[test]
fn frames_of_any_length_end_where_they_should() {
    let problem = Oscillator { speed: 0.5, ..Oscillator::default() };
    for integrator in [true, false] {
        let builder = problem.setup(Engine::<f64>::builder()).step(0.3);
        let builder = match integrator {
            true => builder.integrator(GaussRadau15::default()),
            false => builder.integrator(DormandPrince8::new(Tolerance::relative(1e-13))),
        };
        let mut engine = builder.build().unwrap();
        for frame in [1e-9, 0.7, 1e-3, 12.0, 0.1, 1.0 / 3.0] {
            engine.advance(frame).unwrap();
        }
        let error = problem.error(&engine).unwrap();
        assert!(error < 2e-13, "{error}");
        assert_eq!(engine.time(), 1e-9 + 0.7 + 1e-3 + 12.0 + 0.1 + 1.0 / 3.0);
    }
}

#[test]
fn a_run_goes_on_from_a_checkpoint_with_the_same_bits() {
    let problem = Kepler { eccentricity: 0.7 };
    let make = |number: usize| {
        let builder = problem.setup(Engine::<f64>::builder());
        let builder = match number {
            0 => builder.integrator(DormandPrince5::default()),
            1 => builder.integrator(DormandPrince8::default()),
            2 => builder.integrator(GaussRadau15::default()),
            3 => builder.integrator(Symplectic6::default()).step(0.01),
            _ => builder.integrator(RungeKutta4).step(0.01).compensated(),
        };
        builder.build().unwrap()
    };
    for number in 0..5 {
        let mut whole = make(number);
        whole.advance(1.5).unwrap();
        let checkpoint = whole.checkpoint().unwrap();
        whole.advance(2.5).unwrap();
        let mut resumed = make(number);
        resumed.restore(&checkpoint).unwrap();
        resumed.advance(2.5).unwrap();
        assert_eq!(resumed.state().hash(), whole.state().hash(), "{number}");
        assert_eq!(resumed.evaluations(), whole.evaluations(), "{number}");
    }
}

#[test]
fn a_collision_is_a_fault_that_says_when() {
    let bodies = || {
        Domain::new("bodies")
            .with(Position, [[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]])
            .with(Velocity, [[0.0; 3]; 2])
            .with(Mass, [0.5, 0.5])
    };
    let builder = || Engine::<f64>::builder().domain(bodies()).law(Gravity { g: 1.0, softening: 0.0 }).law(Motion);
    let integrators: [Box<dyn Integrator>; 3] =
        [Box::new(DormandPrince5::default()), Box::new(DormandPrince8::default()), Box::new(GaussRadau15::default())];
    for integrator in integrators {
        let name = integrator.name();
        let mut engine = builder().boxed_integrator(integrator).build().unwrap();
        let fault = engine.advance(3.0).unwrap_err().to_string();
        // They meet after pi / sqrt(8) s, free fall from 1 m.
        let met = core::f64::consts::PI / 8.0_f64.sqrt();
        assert!(fault.starts_with(&format!("{name} finds no step that meets its tolerance at 1.11")), "{fault}");
        assert!((engine.time() - met).abs() < 1e-4, "{name} stands at {} s", engine.time());
    }
}

#[test]
fn a_tolerance_below_what_f32_can_hold_is_met_as_well_as_it_can_be() {
    let problem = Kepler { eccentricity: 0.3 };
    for number in 0..2 {
        let builder = problem.setup(Engine::<f32>::builder());
        let tolerance = Tolerance::relative(1e-14);
        let mut engine = match number {
            0 => builder.integrator(DormandPrince8::new(tolerance)),
            _ => builder.integrator(GaussRadau15::default()),
        }
        .build()
        .unwrap();
        engine.advance(6.0).unwrap();
        let error = problem.error(&engine).unwrap();
        assert!(error < 2e-5, "{error}");
    }
}

#[test]
fn a_compensated_state_loses_fewer_digits() {
    let problem = Oscillator { speed: 0.5, ..Oscillator::default() };
    let run = |compensated: bool| {
        let builder = problem.setup(Engine::<f32>::builder()).integrator(Leapfrog::default()).step(1e-4);
        let builder = if compensated { builder.compensated() } else { builder };
        let mut engine = builder.build().unwrap();
        engine.advance(20.0).unwrap();
        problem.error(&engine).unwrap()
    };
    let (plain, compensated) = (run(false), run(true));
    println!("f32, 200 000 steps: {plain:.1e} plain, {compensated:.1e} compensated");
    assert!(compensated < 0.1 * plain, "{plain} {compensated}");
}

#[test]
fn nothing_moves_and_nothing_is_wrong() {
    // A body at rest, without a force: no rate to choose a step by.
    let bodies = Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    for number in 0..3 {
        let builder = Engine::<f64>::builder().domain(bodies.clone()).law(Motion);
        let mut engine = match number {
            0 => builder.integrator(DormandPrince5::default()),
            1 => builder.integrator(DormandPrince8::default()),
            _ => builder.integrator(GaussRadau15::default()),
        }
        .build()
        .unwrap();
        engine.advance(1e6).unwrap();
        assert!(engine.evaluations() < 1000, "{}", engine.evaluations());
        assert_eq!(engine.state().get("bodies", Position, 0).unwrap(), DVec3::ZERO);
    }
    let spring = at(&Oscillator { displacement: 0.0, ..Oscillator::default() }, GaussRadau15::default(), 1e3);
    assert!(spring.evaluations() < 100_000, "a spring at rest: {}", spring.evaluations());
}
