//! Forces that turn velocities, and the integrators that rotate them: Boris, Higuera and Cary, and their composition.

use vesper::prelude::*;
use vesper_laws::reference::{Cyclotron, Problem};
use vesper_laws::{
    Drag, ElectricForce, MagneticForce, Motion, RelativisticMotion, RelativisticVelocity, RotatingFrame,
};

/// One charge, q / m = 1, in uniform fields.
fn charge<P: Precision>(velocity: [f64; 3], electric: [f64; 3], magnetic: [f64; 3]) -> Builder<P> {
    let bodies = Domain::new("bodies")
        .with(Position, [[0.0; 3]])
        .with(Velocity, [velocity])
        .with(Mass, [2.0])
        .with(Charge, [2.0]);
    let builder = Engine::<P>::builder().domain(bodies).field(ElectricField, Uniform { value: electric });
    builder.field(MagneticField, Uniform { value: magnetic }).law(ElectricForce).law(MagneticForce).law(Motion)
}

/// A relativistic charge of rest mass and charge 1 where light has speed 1.
fn fast(momentum: [f64; 3], electric: [f64; 3], magnetic: [f64; 3]) -> Builder<f64> {
    let bodies = Domain::new("bodies")
        .with(Position, [[0.0; 3]])
        .with(Momentum, [momentum])
        .with(RestMass, [1.0])
        .with(Charge, [1.0]);
    let builder = Engine::<f64>::builder().domain(bodies).constant(SpeedOfLight, [1.0]);
    builder
        .field(ElectricField, Uniform { value: electric })
        .field(MagneticField, Uniform { value: magnetic })
        .law(ElectricForce)
        .law(MagneticForce)
        .law(RelativisticVelocity)
        .law(RelativisticMotion)
}

fn velocity<P: Precision>(engine: &Engine<P>) -> DVec3 {
    DVec3::from_slice(&engine.state().numbers("bodies", Velocity).unwrap())
}

fn momentum(engine: &Engine<f64>) -> DVec3 {
    engine.state().get("bodies", Momentum, 0).unwrap()
}

fn place(engine: &Engine<f64>) -> DVec3 {
    engine.state().get("bodies", Position, 0).unwrap()
}

#[test]
fn the_speed_stays_in_a_magnetic_field_at_any_step() {
    for step in [0.1, 0.9, 3.0] {
        let field = [0.3, -0.4, 0.5_f64.sqrt()];
        let start = [2.0, 0.5, -1.0];
        let run = |integrator: Box<dyn Integrator>, compensated: bool| {
            let builder = charge::<f64>(start, [0.0; 3], field).boxed_integrator(integrator).step(step);
            let mut engine = if compensated { builder.compensated() } else { builder }.build().unwrap();
            let before = velocity(&engine).length();
            engine.steps_of(20_000, step).unwrap();
            (velocity(&engine).length() / before - 1.0).abs()
        };
        for compensated in [false, true] {
            let errors = [
                run(Box::<Boris>::default(), compensated),
                run(Box::<HigueraCary>::default(), compensated),
                run(Box::<Boris8>::default(), compensated),
            ];
            println!("step {step}, compensated {compensated}: {errors:?}");
            // A random walk of roundings: a step of the first two makes a few of 1e-16, of the last one 17 times as many.
            let walk = 5.0 * 1.1e-16 * 20_000.0_f64.sqrt();
            assert!(errors[0] < 2.0 * walk && errors[1] < 2.0 * walk && errors[2] < 8.0 * walk, "{errors:?}");
        }
    }
}

#[test]
fn the_drift_across_fields_at_right_angles_is_exact() {
    // E x B / B^2 = (0.3, 0, 0) x (0, 0, 1) = (0, -0.3, 0); after whole steps that bring the gyration round, nearly.
    let (steps, step) = (62_832, 0.1);
    for integrator in [Box::<Boris>::default() as Box<dyn Integrator>, Box::<HigueraCary>::default()] {
        let mut engine = charge::<f64>([0.0, -0.3, 0.0], [0.3, 0.0, 0.0], [0.0, 0.0, 1.0])
            .boxed_integrator(integrator)
            .step(step)
            .build()
            .unwrap();
        engine.steps_of(steps, step).unwrap();
        let drift = place(&engine) / engine.time();
        assert!((drift - DVec3::new(0.0, -0.3, 0.0)).length() < 1e-10, "{drift}");
    }
    // From rest, a cycloid of known mean: the gyration of the method closes after n steps of angle 2 atan(h / 2).
    let angle = 2.0 * 0.05_f64.atan();
    let turns = 1000.0;
    let steps = (turns * core::f64::consts::TAU / angle).round();
    let mut engine = charge::<f64>([0.0; 3], [0.3, 0.0, 0.0], [0.0, 0.0, 1.0])
        .integrator(Boris::default())
        .step(step)
        .build()
        .unwrap();
    engine.steps_of(steps as u64, step).unwrap();
    // The place is within a gyration's width of the mean: what is left of the last turn.
    let rest = (steps * angle - turns * core::f64::consts::TAU).abs();
    let drift = place(&engine).y / engine.time();
    assert!((drift + 0.3).abs() < 1e-10 + 0.3 * rest / engine.time(), "{drift}, {rest}");
}

#[test]
fn the_phase_of_a_fast_cyclotron_is_of_second_order() {
    // gamma = 10: p = sqrt(99), omega = B / gamma = 1.
    let start = 99.0_f64.sqrt();
    let phase = |integrator: Box<dyn Integrator>, steps: u32| {
        let step = 10.0 / f64::from(steps);
        let mut engine = fast([start, 0.0, 0.0], [0.0; 3], [0.0, 0.0, 10.0])
            .boxed_integrator(integrator)
            .step(step)
            .build()
            .unwrap();
        engine.steps_of(steps.into(), step).unwrap();
        let p = momentum(&engine);
        assert!((p.length() / start - 1.0).abs() < 1e-13, "{p}");
        let angle = (-p.y).atan2(p.x);
        (angle - 10.0).rem_euclid(core::f64::consts::TAU).min((10.0 - angle).rem_euclid(core::f64::consts::TAU))
    };
    let order = |make: fn() -> Box<dyn Integrator>| (phase(make(), 100) / phase(make(), 200)).log2();
    let [boris, higuera_cary] = [order(|| Box::<Boris>::default()), order(|| Box::<HigueraCary>::default())];
    assert!((boris - 2.0).abs() < 0.05 && (higuera_cary - 2.0).abs() < 0.05, "{boris}, {higuera_cary}");
    // (omega h)^2 / 12 of the phase, and nothing but rounding for exact angles.
    assert!((phase(Box::<Boris>::default(), 1000) / (10.0 * 1e-4 / 12.0) - 1.0).abs() < 1e-3);
    assert!(phase(Box::<Boris8>::default(), 10) < 1e-13);
}

#[test]
fn a_fast_charge_that_drifts_stays_in_its_drift_with_higuera_and_cary() {
    // v = E x B / B^2 = 0.9 across both, gamma = 1 / sqrt(0.19): no force, so straight on. The step is long.
    let gamma = 1.0 / 0.19_f64.sqrt();
    let error = |integrator: Box<dyn Integrator>| {
        let builder = fast([0.0, -0.9 * gamma, 0.0], [0.9, 0.0, 0.0], [0.0, 0.0, 1.0]);
        let mut engine = builder.boxed_integrator(integrator).step(0.5).build().unwrap();
        engine.steps_of(1000, 0.5).unwrap();
        (place(&engine) / engine.time() - DVec3::new(0.0, -0.9, 0.0)).length()
    };
    let [boris, higuera_cary] = [error(Box::<Boris>::default()), error(Box::<HigueraCary>::default())];
    println!("boris {boris:.1e}, higuera_cary {higuera_cary:.1e}");
    assert!(higuera_cary < 1e-13 && boris > 1e-6, "{boris:e}, {higuera_cary:e}");
}

#[test]
fn without_turns_it_is_leapfrog() {
    let run = |integrator: Box<dyn Integrator>| {
        let bodies = Domain::new("bodies")
            .with(Position, [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
            .with(Velocity, [[0.0, 0.5, 0.0], [0.0, -0.5, 0.0]])
            .with(Mass, [1.0, 1.0]);
        let gravity = vesper_laws::Gravity { g: 1.0, softening: 0.1 };
        let builder = Engine::<f64>::builder().domain(bodies).law(gravity).law(Motion);
        let mut engine = builder.boxed_integrator(integrator).step(0.01).build().unwrap();
        engine.steps_of(100, 0.01).unwrap();
        place(&engine)
    };
    let [boris, leapfrog] = [run(Box::<Boris>::default()), run(Box::new(DriftKickDrift))];
    assert!((boris - leapfrog).length() < 1e-14, "{boris} {leapfrog}");
}

#[test]
fn a_frame_that_turns_keeps_its_jacobi_constant() {
    let bodies = Domain::new("bodies")
        .with(Position, [[3.0, 0.0, 0.0], [0.0, -1.0, 0.5]])
        .with(Velocity, [[1.0, -1.5, 0.25], [0.0, 0.1, 0.0]])
        .with(Mass, [2.0, 0.5]);
    let frame = RotatingFrame { angular_velocity: DVec3::Z * 0.5 };
    let builder = Engine::<f64>::builder().domain(bodies).law(frame).law(Motion);
    let mut engine = builder.integrator(Boris8::default()).step(0.05).build().unwrap();
    engine.steps_of(80, 0.05).unwrap();
    let (sine, cosine) = 2.0_f64.sin_cos();
    assert!((place(&engine) - DVec3::new(7.0 * cosine, -7.0 * sine, 1.0)).length() < 1e-11, "{}", place(&engine));
}

#[test]
fn some_rows_of_many_are_charged_and_any_memory_and_threads_give_the_same() {
    let rows = 1000;
    let places: Vec<[f64; 3]> = (0..rows).map(|row| [f64::from(row), 0.0, 0.0]).collect();
    let velocities: Vec<[f64; 3]> = (0..rows).map(|row| [1.0, f64::from(row % 7), 0.5]).collect();
    let charged: Vec<u32> = (0..rows as u32).filter(|row| row % 3 == 0).collect();
    let charges = vec![2.0; charged.len()];
    let run = |isa: vesper::real::Isa| {
        let bodies = Domain::new("bodies")
            .with(Position, places.clone())
            .with(Velocity, velocities.clone())
            .with(Mass, vec![2.0; rows as usize])
            .subset(Charge, charged.clone(), charges.clone());
        let builder = Engine::<f64>::builder().domain(bodies).isa(isa);
        let builder = builder.field(MagneticField, Uniform { value: [0.0, 0.0, 1.0] });
        let mut engine = builder.law(MagneticForce).law(Motion).integrator(Boris::default()).step(0.1).build().unwrap();
        engine.steps_of(10, 0.1).unwrap();
        engine.state().numbers("bodies", Velocity).unwrap()
    };
    let all: Vec<Vec<f64>> = vesper::real::Isa::available().into_iter().map(run).collect();
    assert!(all.iter().all(|one| *one == all[0]), "instruction sets differ");
    // A third gyrates by ten times 2 atan(h / 2), the others fly on.
    let angle = 20.0 * 0.05_f64.atan();
    for row in 0..rows as usize {
        let now = DVec3::from_slice(&all[0][3 * row..]);
        let before = DVec3::from_array(velocities[row]);
        let turned = DVec3::new(
            before.x * angle.cos() + before.y * angle.sin(),
            before.y * angle.cos() - before.x * angle.sin(),
            before.z,
        );
        let exact = if row % 3 == 0 { turned } else { before };
        assert!((now - exact).length() < 1e-13, "{row}: {now} {exact}");
    }
}

#[test]
fn f32_and_compensated_states_turn_too() {
    let problem = Cyclotron::default();
    for compensated in [false, true] {
        let builder = problem.setup(Engine::<f32>::builder()).integrator(Boris8::default()).step(0.1);
        let mut engine = if compensated { builder.compensated() } else { builder }.build().unwrap();
        engine.steps_of(1000, 0.1).unwrap();
        let error = problem.error(&engine).unwrap();
        println!("compensated {compensated}: {error:.1e}");
        assert!(error < if compensated { 1e-4 } else { 1e-3 }, "{error:e}");
    }
}

#[test]
fn other_forces_that_depend_on_velocities_are_refused() {
    let bodies = Domain::new("bodies")
        .with(Position, [[0.0; 3]])
        .with(Velocity, [[1.0, 0.0, 0.0]])
        .with(Mass, [1.0])
        .with(DragCoefficient, [0.1])
        .with(Charge, [1.0]);
    let builder = Engine::<f64>::builder().domain(bodies).field(MagneticField, Uniform { value: [0.0, 0.0, 1.0] });
    let faults = builder.law(MagneticForce).law(Drag).law(Motion).integrator(Boris::default()).build().unwrap_err();
    let text = faults.to_string();
    assert!(text.contains("bodies.velocity, and not by a law's turn alone") && text.contains("leapfrog"), "{text}");
}

#[test]
fn a_turn_that_is_not_that_of_the_force_is_found() {
    /// A magnetic force with a turn of the wrong sign.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(velocity: Velocity), adds(force: Force, turn: Turn))]
    struct Wrong;
    #[kernel]
    impl<R: Real> RowLaw<R> for Wrong {
        fn row(&self, body: WrongRow<R>) -> WrongOutput<R> {
            let field = R::Vec3::new(R::lit(0.0), R::lit(0.0), R::lit(1.0));
            WrongOutput { force: body.velocity.cross(field), turn: field * R::lit(-1.0) }
        }
    }
    let bodies = Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[1.0, 0.0, 0.0]]).with(Mass, [1.0]);
    let builder = Engine::<f64>::builder().domain(bodies).law(Wrong).law(Motion).integrator(Boris::default());
    let text = builder.step(0.1).build().unwrap().steps_of(1, 0.1).unwrap_err().to_string();
    assert!(text.contains("bodies.velocity") && text.contains("turn"), "{text}");
}

#[test]
fn a_turn_can_be_observed() {
    let builder = charge::<f64>([1.0, 0.0, 0.0], [0.0; 3], [0.0, 0.5, 0.0]).observe("bodies", Turn);
    let mut engine = builder.integrator(Boris::default()).step(0.1).build().unwrap();
    engine.steps_of(3, 0.1).unwrap();
    assert_eq!(engine.state().get("bodies", Turn, 0).unwrap(), DVec3::new(0.0, 1.0, 0.0));
}
