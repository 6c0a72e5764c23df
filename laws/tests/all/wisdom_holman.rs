//! Wisdom and Holman's splitting: exact for two, its order for three, with further laws, and what it refuses.

use vesper::prelude::*;
use vesper_laws::{
    Drag, Gravity, GravityByParameter, Kinematics, Motion, PostNewtonian, RelativisticMotion, RelativisticVelocity,
    WisdomHolman,
};

/// A sun and planets of these masses, on orbits of a few percent of eccentricity, G = 1.
fn planets(masses: &[f64]) -> Domain<f64> {
    let axes = [1.0, 2.3, 4.1];
    let (mut position, mut velocity) = (vec![[0.0; 3]], vec![[0.0; 3]]);
    for (row, axis) in axes.iter().enumerate().take(masses.len()) {
        let (sine, cosine) = (1.3 * row as f64).sin_cos();
        let speed = 1.03 / f64::sqrt(*axis);
        position.push([axis * cosine, axis * sine, 0.02 * axis]);
        velocity.push([-speed * sine, speed * cosine, 0.01 * speed]);
    }
    let all: Vec<f64> = core::iter::once(1.0).chain(masses.iter().copied()).collect();
    Domain::new("bodies").with(Position, position).with(Velocity, velocity).with(Mass, all)
}

const GRAVITY: Gravity = Gravity { g: 1.0, softening: 0.0 };

fn builder(bodies: Domain<f64>) -> Builder<f64> {
    Engine::<f64>::builder().domain(bodies).law(GRAVITY).law(Motion)
}

fn places(builder: Builder<f64>, integrator: impl Integrator + 'static, time: f64, steps: u32) -> Vec<DVec3> {
    let mut engine = builder.integrator(integrator).build().unwrap();
    engine.steps_of(steps.into(), time / f64::from(steps)).unwrap();
    engine.state().values("bodies", Position).unwrap()
}

fn apart(one: &[DVec3], other: &[DVec3]) -> f64 {
    one.iter().zip(other).map(|(one, other)| (*one - *other).length()).fold(0.0, f64::max)
}

/// The largest distance of a planet of this mass from where it should be after some time.
fn error(mass: f64, integrator: WisdomHolman, steps: u32) -> f64 {
    let bodies = || builder(planets(&[mass, 2.0 * mass]));
    let exact = places(bodies(), GaussRadau15::default(), 50.0, 1);
    apart(&places(bodies(), integrator, 50.0, steps), &exact)
}

#[test]
fn two_rows_are_exact_in_one_step() {
    // Equal masses on orbits of eccentricity 0.6 about each other, and a far lighter row first.
    for masses in [[1.0, 1.0], [1e-6, 1.0]] {
        let total = masses[0] + masses[1];
        let speed = (0.4 * total).sqrt();
        let bodies = || {
            Domain::new("bodies")
                .with(Position, [[0.5, 0.0, 0.0], [-0.5, 0.0, 0.1]])
                .with(Velocity, [[0.3, speed, 0.0], [0.3, 0.0, 0.0]])
                .with(Mass, masses)
        };
        for time in [0.01, 1.0, 30.0] {
            let exact = places(builder(bodies()), GaussRadau15::default(), time, 1);
            let found = places(builder(bodies()), WisdomHolman::new(), time, 1);
            let error = apart(&found, &exact);
            println!("masses {masses:?}, {time} s in one step: {error:.1e}");
            assert!(error < 1e-15 * (10.0 + 100.0 * time), "{error:e}");
        }
    }
}

#[test]
fn the_order_is_two_in_the_step_and_one_in_the_disturbance() {
    let order = (error(1e-4, WisdomHolman::new(), 1000) / error(1e-4, WisdomHolman::new(), 2000)).log2();
    let power = (error(1e-4, WisdomHolman::new(), 1000) / error(1e-6, WisdomHolman::new(), 1000)).log10() / 2.0;
    println!("order {order:.3}, power of the disturbance {power:.3}");
    assert!((order - 2.0).abs() < 0.1 && (power - 1.0).abs() < 0.1, "{order} {power}");
}

#[test]
fn a_corrector_leaves_the_square_of_the_disturbance() {
    let corrected = || WisdomHolman::new().with_corrector(17);
    let order = (error(1e-3, corrected(), 500) / error(1e-3, corrected(), 1000)).log2();
    let power = (error(1e-3, corrected(), 500) / error(1e-4, corrected(), 500)).log10();
    println!("order {order:.3}, power of the disturbance {power:.3}");
    assert!((order - 2.0).abs() < 0.2 && (power - 2.0).abs() < 0.2, "{order} {power}");
    for (order, at_least) in [(3, 4.0), (5, 20.0), (7, 20.0), (11, 20.0), (17, 20.0)] {
        let gain = error(1e-6, WisdomHolman::new(), 500) / error(1e-6, WisdomHolman::new().with_corrector(order), 500);
        println!("corrector of order {order}: error less by {gain:.1}");
        assert!(gain > at_least, "{order}: {gain}");
    }
}

#[test]
fn the_kernel_makes_it_order_four() {
    let order = (error(3e-3, WisdomHolman::high(), 400) / error(3e-3, WisdomHolman::high(), 800)).log2();
    let gain = error(3e-3, WisdomHolman::new().with_corrector(17), 800) / error(3e-3, WisdomHolman::high(), 800);
    println!("order {order:.3}, error less by {gain:.0} than with the corrector alone");
    assert!((order - 4.0).abs() < 0.3 && gain > 30.0, "{order} {gain}");
}

#[test]
fn with_another_constant_it_is_right_in_short_steps() {
    let error = |steps| error(1e-4, WisdomHolman::new().with_g(1.1), steps);
    let order = (error(4000) / error(8000)).log2();
    println!("order {order:.3}, {:.1e}", error(8000));
    assert!((order - 2.0).abs() < 0.1, "{order}");
}

#[test]
fn energy_has_no_trend() {
    let mut engine = builder(planets(&[1e-3, 3e-4, 5e-5])).integrator(WisdomHolman::new()).step(0.3).build().unwrap();
    let first = engine.energy().unwrap().0;
    let count = 1000;
    let mut errors = Vec::new();
    for _ in 0..count {
        engine.steps_of(100, 0.3).unwrap();
        errors.push(engine.energy().unwrap().0 / first - 1.0);
    }
    // A line through the errors, and its standard deviation, as if they were independent.
    let mean = errors.iter().sum::<f64>() / f64::from(count);
    let at = |k: usize| k as f64 - 0.5 * f64::from(count - 1);
    let squares: f64 = (0..errors.len()).map(|k| at(k) * at(k)).sum();
    let slope = errors.iter().enumerate().map(|(k, error)| at(k) * (error - mean)).sum::<f64>() / squares;
    let spread = (errors.iter().map(|error| (error - mean).powi(2)).sum::<f64>() / f64::from(count)).sqrt();
    let noise = spread / squares.sqrt();
    let largest = errors.iter().fold(0.0, |worst, error| f64::max(worst, error.abs()));
    println!("1e5 steps: at most {largest:.1e}, slope {:.2} of its noise", slope / noise);
    assert!(largest < 1e-4 && slope.abs() < 4.0 * noise, "{largest:e} {}", slope / noise);
}

#[test]
fn mercurys_perihelion_advances_by_further_laws() {
    // An orbit of eccentricity 0.3 about a parameter of 1: 6 pi / (c^2 (1 - e^2)) per revolution.
    let (eccentricity, light): (f64, f64) = (0.3, 3000.0);
    let advance = |integrator: WisdomHolman, steps: u32| {
        let speed = ((1.0 + eccentricity) / (1.0 - eccentricity)).sqrt();
        let bodies = Domain::new("bodies")
            .with(Position, [[0.0; 3], [1.0 - eccentricity, 0.0, 0.0]])
            .with(Velocity, [[0.0; 3], [0.0, speed, 0.0]])
            .with(StandardGravitationalParameter, [1.0, 0.0]);
        let builder = Engine::<f64>::builder().domain(bodies).constant(SpeedOfLight, [light]);
        let builder = builder.law(GravityByParameter::default()).law(PostNewtonian).law(Kinematics);
        let mut engine = builder.integrator(integrator).build().unwrap();
        engine.steps_of(steps.into(), core::f64::consts::TAU / f64::from(steps)).unwrap();
        let r = engine.state().get("bodies", Position, 1).unwrap();
        let v = engine.state().get("bodies", Velocity, 1).unwrap();
        let pericentre = v.cross(r.cross(v)) - r / r.length();
        pericentre.y.atan2(pericentre.x)
    };
    let einstein = 6.0 * core::f64::consts::PI / (light * light * (1.0 - eccentricity * eccentricity));
    for (integrator, steps) in [(WisdomHolman::new(), 400), (WisdomHolman::high(), 100)] {
        let found = advance(integrator.clone(), steps);
        println!("{}: {steps} steps: {found:e} of {einstein:e}", integrator.name());
        assert!((found / einstein - 1.0).abs() < 1e-3, "{found} {einstein}");
    }
}

#[test]
fn forces_that_depend_on_velocities_leave_order_two() {
    let drag = || builder(planets(&[1e-3, 1e-3]).with(DragCoefficient, [0.0, 2e-7, 4e-7])).law(Drag);
    let exact = places(drag(), GaussRadau15::default(), 50.0, 1);
    let error = |steps| apart(&places(drag(), WisdomHolman::new(), 50.0, steps), &exact);
    let order = (error(1000) / error(2000)).log2();
    println!("order {order:.3}");
    assert!((order - 2.0).abs() < 0.1, "{order}");
    let engine = drag().integrator(WisdomHolman::new()).build().unwrap();
    let remark = engine
        .integrator()
        .remark(&Structure { momenta_depend_on_momenta: Some("bodies.velocity".to_owned()), ..Structure::default() });
    assert!(remark.unwrap().contains("two evaluations"));
}

/// The numbers of all rows.
fn numbers(engine: &Engine<f64>) -> Vec<f64> {
    let state = engine.state();
    [state.numbers("bodies", Position).unwrap(), state.numbers("bodies", Velocity).unwrap()].concat()
}

#[test]
fn frames_and_checkpoints_leave_the_bits_as_they_are() {
    for integrator in [WisdomHolman::new(), WisdomHolman::high()] {
        let engine = || builder(planets(&[1e-3, 1e-4])).integrator(integrator.clone()).step(0.25).build().unwrap();
        let (mut once, mut often, mut again) = (engine(), engine(), engine());
        once.advance(25.0).unwrap();
        for _ in 0..50 {
            often.advance(0.25).unwrap();
        }
        let checkpoint = often.checkpoint().unwrap();
        again.restore(&checkpoint).unwrap();
        for _ in 0..50 {
            again.advance(0.25).unwrap();
        }
        assert_eq!(numbers(&once), numbers(&again));
    }
}

#[test]
fn what_the_client_changes_counts() {
    let mut engine = builder(planets(&[1e-3, 1e-4])).integrator(WisdomHolman::high()).step(0.05).build().unwrap();
    engine.advance(5.0).unwrap();
    let mut other = builder(planets(&[1e-3, 1e-4])).integrator(GaussRadau15::default()).build().unwrap();
    other.advance(5.0).unwrap();
    for engine in [&mut engine, &mut other] {
        engine.state_mut().set("bodies", Velocity, 2, DVec3::new(0.1, 0.5, 0.0)).unwrap();
        engine.state_mut().set("bodies", Mass, 1, 2e-3).unwrap();
        engine.advance(5.0).unwrap();
    }
    let off = numbers(&engine).iter().zip(numbers(&other)).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
    assert!(off < 1e-7, "{off:e}");
}

#[test]
fn f32_keeps_more_than_its_own_rounding() {
    let bodies = Domain::<f32>::new("bodies")
        .with(Position, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.3, 0.0]])
        .with(Velocity, [[0.0; 3], [0.0, 1.0, 0.0], [-0.65, 0.0, 0.0]])
        .with(Mass, [1.0, 1e-3, 1e-3]);
    let law = Gravity { g: 1.0, softening: 0.0 };
    let builder = Engine::<f32>::builder().domain(bodies).law(law).law(Motion).integrator(WisdomHolman::new());
    let mut engine = builder.step(0.125).build().unwrap();
    let first = engine.energy().unwrap().0;
    engine.advance(1000.0).unwrap();
    let off = (engine.energy().unwrap().0 / first - 1.0).abs();
    assert!(off < 3e-6, "{off:e}");
}

#[test]
fn what_does_not_fit_is_refused() {
    let fault = |builder: Builder<f64>, integrator: WisdomHolman| {
        let built = builder.integrator(integrator).build();
        built.and_then(|mut engine| engine.steps_of(1, 0.1)).unwrap_err().to_string()
    };
    let plain = WisdomHolman::new;
    let free = || Engine::<f64>::builder().domain(planets(&[1e-3])).law(Motion);
    let softened = GravityByParameter { softening: 0.1 };
    let parameters = |parameters: [f64; 2]| {
        let bodies = planets(&[1e-3]).with(StandardGravitationalParameter, parameters);
        Engine::<f64>::builder().domain(bodies).law(softened).law(Kinematics)
    };
    let dragged = || builder(planets(&[1e-3]).with(DragCoefficient, [0.0, 1e-6])).law(Drag.every(2));
    let rows = Domain::new("bodies")
        .with(Position, [[0.0; 3], [1.0, 0.0, 0.0]])
        .with(Momentum, [[0.0; 3]; 2])
        .with(RestMass, [1.0; 2])
        .with(Mass, [1.0; 2]);
    let fast = Engine::<f64>::builder().domain(rows).constant(SpeedOfLight, [1.0]).law(GRAVITY);
    let fast = fast.law(RelativisticVelocity).law(RelativisticMotion);
    assert!(parameters([1.0, 0.0]).integrator(plain()).build().unwrap().steps_of(1, 0.1).is_ok());
    let table = [
        (fault(builder(planets(&[])), plain()), "bodies.position is that of 1 row: take gauss_radau_15"),
        (fault(free(), plain()), "gravity and gravity_by_parameter do not run: add one of them"),
        (fault(builder(planets(&[1e-3])), plain().with_corrector(4)), "a corrector of order 3, 5, 7, 11 or 17"),
        (fault(builder(planets(&[1e-3])), plain().with_g(-1.0)), "g is -1.0"),
        (fault(builder(planets(&[0.0])), plain()), "row 1 of bodies attracts by 0e0 m^3/s^2: give it a mass"),
        (fault(parameters([1.0, -2.0]), plain()), "row 1 of bodies attracts by -2e0 m^3/s^2"),
        (fault(parameters([0.0, 0.0]), plain()), "row 0 of bodies attracts by 0e0 m^3/s^2"),
        (fault(dragged(), plain()), "drag is evaluated on some steps only"),
        (fault(fast, plain()), "laws move bodies.position, bodies.momentum: take gauss_radau_15"),
    ];
    for (found, expected) in &table {
        assert!(found.contains(expected) && found.contains("wisdom_holman needs"), "{found}");
    }
}
