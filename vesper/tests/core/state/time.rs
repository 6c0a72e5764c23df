//! Frames cut into steps; the time does not gather rounding errors.

use super::*;

fn engine(step: Option<f64>) -> Engine<f64> {
    let builder = Engine::builder().domain(one()).law(Motion).law(Weight).integrator(SemiImplicitEuler);
    match step {
        Some(step) => builder.step(step).build().unwrap(),
        None => builder.build().unwrap(),
    }
}

#[test]
fn ten_frames_of_a_tenth_are_ten_steps_of_a_tenth() {
    let mut engine = engine(Some(0.1));
    for frame in 1..=1000 {
        engine.advance(0.1).unwrap();
        assert_eq!(engine.steps(), frame);
        assert_eq!(engine.time(), 0.1 * frame as f64, "one product, not a sum of rounding errors");
        assert_eq!(engine.state().time(), engine.time());
    }
}

#[test]
fn what_no_step_covers_is_carried_to_the_next_frame() {
    let mut engine = engine(Some(0.1));
    let steps: Vec<u64> = (0..8)
        .map(|_| {
            engine.advance(0.025).unwrap();
            engine.steps()
        })
        .collect();
    assert_eq!(steps, [0, 0, 0, 1, 1, 1, 1, 2]);
    engine.advance(0.35).unwrap();
    assert_eq!(engine.steps(), 5);
    engine.advance(0.05).unwrap();
    assert_eq!(engine.steps(), 6);
    engine.advance(0.0).unwrap();
    assert_eq!(engine.steps(), 6);
}

#[test]
fn without_a_step_every_frame_is_one() {
    let mut engine = engine(None);
    for frame in [0.5, 0.25, 0.0, 0.25] {
        engine.advance(frame).unwrap();
    }
    assert_eq!((engine.steps(), engine.time()), (3, 1.0));
    // v: -5, -7.5, -10; x: -2.5, -4.375, -6.875
    assert_eq!((speed(&engine, 0).z, place(&engine, 0).z), (-10.0, -6.875));
}

#[test]
fn a_client_sets_the_clock() {
    let domain = one().with(Charge, [2.0]);
    let builder = Engine::builder().domain(domain).law(Electric).law(Motion).integrator(SemiImplicitEuler).step(0.5);
    let builder = builder.field(ElectricField, |_: DVec3, time: f64| DVec3::new(time, 0.0, 0.0));
    let mut engine = builder.constant(Time, 100.0).build().unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!((engine.time(), speed(&engine, 0).x), (101.0, 0.5 * (100.0 + 100.5)));
    engine.state_mut().set("scene", Time, 0, 7.0).unwrap();
    engine.advance(0.5).unwrap();
    assert_eq!((engine.time(), speed(&engine, 0).x), (7.5, 0.5 * (100.0 + 100.5 + 7.0)));
}

#[test]
fn time_goes_on_where_nothing_moves() {
    let mut engine = Engine::<f64>::builder().domain(one()).step(0.25).build().unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!((engine.time(), engine.state().time(), engine.steps()), (1.0, 1.0, 4));
    engine.steps_of(u64::MAX, 0.25).unwrap();
    assert_eq!(engine.steps(), i64::MAX as u64, "counting ends there");
}
