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
    // By what the errors of two neighbouring tolerances are: one of them alone may be small by chance.
    let mut before = [[f64::INFINITY; 2]; 2];
    for tenth in 4..11 {
        let tolerance = Tolerance::relative(10.0_f64.powi(-tenth));
        let (fifth, fifths) = error(Box::new(DormandPrince5::new(tolerance)));
        let (eighth, eighths) = error(Box::new(DormandPrince8::new(tolerance)));
        println!("{:.0e}: {fifth:.1e} in {fifths}, {eighth:.1e} in {eighths}", tolerance.relative);
        for error in [fifth, eighth] {
            assert!(error < 2e3 * tolerance.relative && error > 1e-2 * tolerance.relative, "{error} of {tolerance:?}");
        }
        let [two_ago, last] = before;
        assert!(fifth < 0.25 * two_ago[0] && eighth < 0.25 * two_ago[1], "a hundredth of the tolerance, {before:?}");
        before = [last, [fifth, eighth]];
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
    let integrators: [Box<dyn Integrator>; 4] = [
        Box::new(DormandPrince5::default()),
        Box::new(DormandPrince8::default()),
        Box::new(Nystrom12::default()),
        Box::new(GaussRadau15::default()),
    ];
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
    for number in 0..3 {
        let builder = problem.setup(Engine::<f32>::builder());
        let tolerance = Tolerance::relative(1e-14);
        let mut engine = match number {
            1 => builder.integrator(Nystrom12::new(tolerance)),
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
    for number in 0..4 {
        let builder = Engine::<f64>::builder().domain(bodies.clone()).law(Motion);
        let mut engine = match number {
            0 => builder.integrator(DormandPrince5::default()),
            1 => builder.integrator(DormandPrince8::default()),
            2 => builder.integrator(Nystrom12::default()),
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

/// A planet on an ellipse, by frames of this length, up to this time: the largest error of a place at the end of a frame, and
/// the evaluations.
fn by_frames(integrator: impl Integrator + 'static, frame: f64, end: f64) -> (f64, u64) {
    let problem = Kepler { eccentricity: 0.3 };
    let exact = |time: f64| {
        let mut engine = problem.engine::<f64>(GaussRadau15::default(), end).unwrap();
        engine.advance(time).unwrap();
        engine.state().numbers("bodies", Position).unwrap()
    };
    let mut engine = problem.engine::<f64>(integrator, frame).unwrap();
    let mut worst = 0.0;
    let count = (end / frame).round() as u32;
    for number in 1..=count {
        engine.advance(frame).unwrap();
        // Some of them, at no fixed place of a step.
        if number.is_multiple_of(count / 16) || number == count {
            let found = engine.state().numbers("bodies", Position).unwrap();
            let exact = exact(engine.time());
            worst = found.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(worst, f64::max);
        }
    }
    (worst, engine.evaluations())
}

#[test]
fn frames_shorter_than_steps_cost_no_further_steps() {
    let tolerance = Tolerance::relative(1e-9);
    for (name, whole, short) in [
        (
            "dormand_prince_5",
            by_frames(DormandPrince5::new(tolerance), 6.0, 6.0),
            by_frames(DormandPrince5::new(tolerance), 6.0 / 4096.0, 6.0),
        ),
        (
            "dormand_prince_8",
            by_frames(DormandPrince8::new(tolerance), 6.0, 6.0),
            by_frames(DormandPrince8::new(tolerance), 6.0 / 4096.0, 6.0),
        ),
    ] {
        println!("{name}: {whole:?} in one frame, {short:?} in 4096");
        // Four more evaluations for twelve, and a step behind the end.
        assert!(short.1 < whole.1 * 3 / 2 + 32, "{name}: {} evaluations, and not {}", short.1, whole.1);
        assert!(short.0 < 20.0 * whole.0 + 1e-8, "{name}: {:e}, and not {:e}", short.0, whole.0);
    }
}

#[test]
fn within_a_step_the_error_has_its_order() {
    // One step each, looked at in the middle and near both ends; the error of a step of order p goes with its power p + 1.
    fn order(name: &str, make: fn(Tolerance) -> Box<dyn Integrator>, steps: [f64; 2]) -> f64 {
        let problem = Kepler { eccentricity: 0.1 };
        let loose = Tolerance { relative: 1e9, absolute: 1e9 };
        let errors = steps.map(|step| {
            [0.1, 0.45].map(|share| {
                let place = |integrator: Box<dyn Integrator>, ahead: bool| {
                    let builder = problem.setup(Engine::<f64>::builder()).boxed_integrator(integrator).step(step);
                    let mut engine = builder.build().unwrap();
                    engine.advance(share * step).unwrap();
                    assert!(!ahead || engine.tried_steps() == [0, 1], "{name}: one step");
                    engine.state().numbers("bodies", Position).unwrap()
                };
                let (found, exact) = (place(make(loose), true), place(Box::<GaussRadau15>::default(), false));
                found.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
            })
        });
        let worst = errors.map(|errors| f64::max(errors[0], errors[1]));
        let order = (worst[0] / worst[1]).log2() / (steps[0] / steps[1]).log2();
        println!("{name}: {worst:?}, power {order:.2}");
        order
    }
    let fifth = order("dormand_prince_5", |loose| Box::new(DormandPrince5::new(loose)), [0.1, 0.05]);
    let eighth = order("dormand_prince_8", |loose| Box::new(DormandPrince8::new(loose)), [0.5, 0.25]);
    assert!((fifth - 5.0).abs() < 0.3 && (eighth - 8.0).abs() < 0.5, "{fifth} {eighth}");
}

#[test]
fn a_checkpoint_within_a_step_goes_on_with_the_same_bits_and_a_change_counts() {
    for make in [
        || Box::<DormandPrince5>::default() as Box<dyn Integrator>,
        || Box::<DormandPrince8>::default() as Box<dyn Integrator>,
    ] {
        let engine = || {
            let builder = Kepler { eccentricity: 0.3 }.setup(Engine::<f64>::builder());
            builder.boxed_integrator(make()).step(1e-3).build().unwrap()
        };
        let numbers = |engine: &Engine<f64>| engine.state().numbers("bodies", Position).unwrap();
        let (mut one, mut other) = (engine(), engine());
        one.advance(0.007).unwrap();
        let checkpoint = one.checkpoint().unwrap();
        other.restore(&checkpoint).unwrap();
        for engine in [&mut one, &mut other] {
            for _ in 0..500 {
                engine.advance(1e-3).unwrap();
            }
        }
        assert_eq!(numbers(&one), numbers(&other), "{}", one.integrator().name());
        // From where it is now, not from the end of a step that was taken before.
        let place = |engine: &Engine<f64>| engine.state().get("bodies", Position, 1).unwrap();
        let before = place(&one);
        one.state_mut().set("bodies", Velocity, 1, DVec3::ZERO).unwrap();
        one.advance(1e-3).unwrap();
        let moved = (place(&one) - before).length();
        assert!(moved < 2e-6, "{}: {moved:e}", one.integrator().name());
    }
}

#[test]
fn a_coarse_precision_does_not_look_for_what_its_own_rounds_leave() {
    // A spring that has come to rest: what is left of its rates is what rounds did not close, and that has no polynomial.
    let evaluations = |precision: f64| {
        let problem = Oscillator { damping: 200.0, ..Oscillator::default() };
        let mut engine =
            problem.setup(Engine::<f64>::builder()).integrator(GaussRadau15::new(precision)).build().unwrap();
        engine.advance(5.0).unwrap();
        engine.evaluations()
    };
    let fine = evaluations(1e-7);
    for precision in [0.5, 0.1, 1e-2, 1e-3] {
        let coarse = evaluations(precision);
        assert!(coarse < 2 * fine, "{coarse} at {precision}, {fine} at 1e-7");
    }
}
