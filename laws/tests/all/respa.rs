//! Laws of different pace under reversible RESPA.

use vesper::prelude::*;
use vesper_laws::{Drag, Gravity, Motion, Spring};

/// Two dumbbells about each other: springs of period 0.45, held together by gravity, whose law costs the most.
fn dumbbells(every: u32) -> Builder<f64> {
    let bodies = Domain::new("bodies")
        .with(Position, [[1.0, 0.0, 0.0], [1.25, 0.0, 0.1], [-1.0, 0.0, 0.0], [-1.25, 0.0, 0.05]])
        .with(Velocity, [[0.0, 0.55, 0.0], [0.0, 0.55, 0.1], [0.0, -0.55, 0.0], [0.1, -0.55, 0.0]])
        .with(Mass, [1.0; 4]);
    let springs = Domain::new("springs")
        .link(Ends, "bodies", [[0, 1], [2, 3]])
        .with(Stiffness, [100.0; 2])
        .with(RestLength, [0.25; 2]);
    let gravity = Gravity { g: 0.4, softening: 0.3 };
    Engine::<f64>::builder().domain(bodies).domain(springs).law(gravity.every(every)).law(Spring).law(Motion)
}

fn numbers(engine: &Engine<f64>) -> Vec<f64> {
    let state = engine.state();
    [state.numbers("bodies", Position).unwrap(), state.numbers("bodies", Velocity).unwrap()].concat()
}

fn largest(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).fold(0.0, |most, (one, other)| f64::max(most, (one - other).abs()))
}

#[test]
fn its_order_is_two_at_every_pace() {
    let mut exact = dumbbells(1).integrator(GaussRadau15::default()).build().unwrap();
    exact.advance(3.0).unwrap();
    let exact = numbers(&exact);
    for every in [1, 2, 5] {
        let error = |steps: u32| {
            let step = 3.0 / f64::from(steps);
            let mut engine = dumbbells(every).integrator(Respa::default()).step(step).build().unwrap();
            engine.steps_of(steps.into(), step).unwrap();
            largest(&numbers(&engine), &exact)
        };
        let order = (error(3000) / error(6000)).log2();
        println!("every {every}: {order:.3}");
        assert!((order - 2.0).abs() < 0.15, "every {every}: {order}");
    }
}

#[test]
fn of_one_pace_it_is_leapfrog() {
    let run = |integrator: Box<dyn Integrator>| {
        let mut engine = dumbbells(1).boxed_integrator(integrator).step(0.01).build().unwrap();
        engine.steps_of(100, 0.01).unwrap();
        numbers(&engine)
    };
    assert_eq!(run(Box::<Respa>::default()), run(Box::<Leapfrog>::default()));
}

#[test]
fn time_runs_back() {
    let mut engine = dumbbells(4).integrator(Respa::default()).step(0.01).build().unwrap();
    let before = numbers(&engine);
    engine.steps_of(40, 0.01).unwrap();
    for row in 0..4 {
        let back = -engine.state().get("bodies", Velocity, row).unwrap();
        engine.state_mut().set("bodies", Velocity, row, back).unwrap();
    }
    engine.steps_of(40, 0.01).unwrap();
    let after = numbers(&engine);
    let back: Vec<f64> = after[12..].iter().map(|number| -number).collect();
    let off = largest(&before[..12], &after[..12]).max(largest(&before[12..], &back));
    assert!(off < 1e-13, "{off:e}");
}

#[test]
fn the_energy_stays_where_a_held_force_drifts() {
    let drift = |integrator: Box<dyn Integrator>| {
        let mut engine = dumbbells(5).boxed_integrator(integrator).step(0.01).build().unwrap();
        let start = engine.energy().unwrap().0;
        let mut worst = 0.0_f64;
        for _ in 0..400 {
            engine.steps_of(50, 0.01).unwrap();
            worst = worst.max((engine.energy().unwrap().0 - start).abs());
        }
        (worst, engine.evaluations())
    };
    let (respa, evaluations) = drift(Box::<Respa>::default());
    let (held, _) = drift(Box::<Leapfrog>::default());
    println!("respa {respa:.1e}, held {held:.1e}, evaluations {evaluations}");
    assert!(respa < 1.5e-2 && held > 1000.0 * respa, "{respa:e} {held:e}");
    // 20 000 steps: the fast laws once each, all of them once in five, and both once at the beginning.
    assert_eq!(evaluations, 20_000 + 4_000 + 2);
}

#[test]
fn a_frame_may_end_between_two_kicks() {
    let mut exact = dumbbells(1).integrator(GaussRadau15::default()).build().unwrap();
    exact.advance(3.0).unwrap();
    let error = |frame: u64, step: f64| {
        let mut engine = dumbbells(4).integrator(Respa::default()).step(step).build().unwrap();
        for _ in 0..((3.0 / step).round() as u64 / frame) {
            engine.steps_of(frame, step).unwrap();
        }
        largest(&numbers(&engine), &numbers(&exact))
    };
    for frame in [1, 3, 5, 7] {
        let order = (error(frame, 3.0 / 2100.0) / error(frame, 3.0 / 4200.0)).log2();
        assert!((order - 2.0).abs() < 0.15, "frames of {frame}: {order}");
    }
}

#[test]
fn forces_that_depend_on_velocities_are_refused() {
    let bodies = Domain::new("bodies")
        .with(Position, [[0.0; 3]])
        .with(Velocity, [[1.0, 0.0, 0.0]])
        .with(Mass, [1.0])
        .with(DragCoefficient, [0.1]);
    let builder = Engine::<f64>::builder().domain(bodies).law(Drag).law(Motion).integrator(Respa::default());
    assert!(builder.build().unwrap_err().to_string().contains("respa"));
}
