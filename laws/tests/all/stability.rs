//! The longest stable steps of explicit integrators: those that runs confirm.

use vesper::prelude::*;
use vesper_laws::reference::{LinearDrag, Oscillator, Problem};
use vesper_laws::{Motion, Spring};

/// The explicit integrators of fixed steps.
fn integrators() -> Vec<Box<dyn Fn() -> Box<dyn Integrator>>> {
    vec![
        Box::new(|| Box::new(ExplicitEuler)),
        Box::new(|| Box::new(SemiImplicitEuler)),
        Box::new(|| Box::new(Midpoint)),
        Box::new(|| Box::new(Leapfrog::default())),
        Box::new(|| Box::new(DriftKickDrift)),
        Box::new(|| Box::new(RungeKutta4)),
        Box::new(|| Box::new(Symplectic4::default())),
        Box::new(|| Box::new(Symplectic6::default())),
        Box::new(|| Box::new(Symplectic8::default())),
    ]
}

fn engine(problem: &impl Problem, integrator: Box<dyn Integrator>, step: f64) -> Result<Engine<f64>, Faults> {
    problem.setup(Engine::builder()).boxed_integrator(integrator).step(step).build()
}

/// The largest number of the state over many steps, of what is left when the rest is taken away.
fn largest(
    problem: &impl Problem,
    integrator: Box<dyn Integrator>,
    step: f64,
    of: impl Fn(&Engine<f64>) -> f64,
) -> f64 {
    let mut engine = engine(problem, integrator, step).unwrap();
    let mut found = 0.0_f64;
    for _ in 0..2000 {
        if engine.steps_of(1, step).is_err() {
            return f64::INFINITY;
        }
        found = found.max(of(&engine));
    }
    found
}

fn out(engine: &Engine<f64>) -> f64 {
    (engine.state().get("bodies", Position, 1).unwrap().x - 1000.0).abs()
}

/// With a length at which what grows can be seen to grow before the spring is turned over.
fn oscillator(damping: f64) -> Oscillator {
    Oscillator { stiffness: 4.0, damping, rest_length: 1000.0, displacement: 0.01, ..Oscillator::default() }
}

fn limit(engine: &mut Engine<f64>) -> StableStep {
    engine.stable_step().unwrap().unwrap()
}

#[test]
fn of_an_oscillation_are_those_at_which_it_begins_to_grow() {
    let problem = oscillator(0.0);
    for make in integrators() {
        let name = make().name();
        let limits = make().stable_limits(true).unwrap();
        let found = limit(&mut engine(&problem, make(), 0.1).unwrap());
        assert!((found.rate[1] - 2.0).abs() < 1e-6 && found.rate[0] == 0.0, "{name}: {found:?}");
        if limits.oscillation == 0.0 {
            assert!(found.step == 0.0 && (found.usable - 1.0).abs() < 1e-6, "{name}: {found:?}");
            continue;
        }
        assert!(
            (found.step * 2.0 - limits.oscillation).abs() < 1e-5 && found.usable == found.step,
            "{name}: {found:?}"
        );
        let stays = largest(&problem, make(), 0.99 * found.step, out);
        assert!(stays < 1.0, "{name}: {stays}");
        let steps = (1..=20).map(|k| found.step * (1.0 + 0.001 * f64::from(k)));
        let grows = steps.map(|step| largest(&problem, make(), step, out)).fold(0.0, f64::max);
        println!("{name}: {stays} {grows}");
        assert!(grows > 10.0 * stays, "{name}: {grows}");
    }
}

#[test]
fn of_a_decay_are_those_at_which_it_begins_to_grow() {
    let problem = LinearDrag::default();
    let speed = |engine: &Engine<f64>| engine.state().get("bodies", Velocity, 0).unwrap().length();
    for make in integrators() {
        let name = make().name();
        let Ok(mut engine) = engine(&problem, make(), 0.1) else { continue };
        let found = limit(&mut engine);
        let begin = speed(&engine).max(1.0);
        assert!(found.step > 0.0 && found.step.is_finite() && found.rate[1] == 0.0, "{name}: {found:?}");
        let of = |step: f64| largest(&problem, make(), step, speed);
        assert!(of(0.99 * found.step) < 20.0 * begin && of(1.02 * found.step) > 1e6, "{name}: {found:?}");
    }
}

#[test]
fn of_a_damped_oscillation_are_safe() {
    for (ratio, part) in [(0.05, 0.9), (0.3, 0.9), (0.6, 0.9), (0.9, 0.9), (2.0, 0.85), (10.0, 0.9)] {
        // From its rest length, where nothing pulls across.
        let problem = Oscillator { displacement: 0.0, speed: 1e-6, ..oscillator(4.0 * ratio) };
        for make in integrators() {
            let name = make().name();
            let Ok(mut engine) = engine(&problem, make(), 0.1) else { continue };
            let found = limit(&mut engine);
            let stays = largest(&problem, make(), part * found.step, out);
            println!("{name} at {ratio}: {found:?}, {stays:.3}");
            assert!(found.step > 0.0 && stays < 1.0, "{name} at {ratio}: {found:?} {stays}");
            // And not far too short.
            let grows = largest(&problem, make(), 2.5 * found.usable, out);
            assert!(grows > 10.0, "{name} at {ratio}: {grows}");
        }
    }
}

/// Masses in a row, joined by springs, the first one fixed.
pub(super) fn chain<P: Precision>(links: u32, stiffness: f64) -> Builder<P> {
    let rows = links as usize + 1;
    let at = |row: usize| [row as f64 + 0.01 * (0.1 * row as f64).sin(), 0.0, 0.0];
    let bodies = Domain::new("bodies")
        .with(Position, (0..rows).map(at).collect::<Vec<_>>())
        .with(Velocity, vec![[0.0; 3]; rows])
        .with(Mass, (0..rows).map(|row| f64::from(row > 0)).collect::<Vec<_>>());
    let springs = Domain::new("springs")
        .link(Ends, "bodies", (0..links).map(|link| [link, link + 1]).collect::<Vec<_>>())
        .with(Stiffness, vec![stiffness; links as usize])
        .with(RestLength, vec![1.0; links as usize]);
    Engine::builder().domain(bodies).domain(springs).law(Spring).law(Motion)
}

#[test]
fn of_a_chain_is_that_of_its_fastest_wave() {
    // omega = 2 sqrt(k / m) for many links; leapfrog allows 2 / omega.
    let mut engine = chain::<f64>(1000, 2.5e5).step(1e-4).build().unwrap();
    let found = limit(&mut engine);
    println!("{found:?}: {:.4} of 1e-3 s", found.step / 2e-3 * 2.0);
    assert!((found.step * 500.0 - 1.0).abs() < 0.03, "{found:?}");
    let mut single = chain::<f32>(1000, 2.5e5).step(1e-4).build().unwrap();
    let single = single.stable_step().unwrap().unwrap();
    assert!((single.step / found.step - 1.0).abs() < 0.02, "{single:?}, {found:?}");
}

#[test]
fn what_neither_decays_nor_oscillates_has_no_limit_and_asking_changes_nothing() {
    let free = Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[1.0, 2.0, 3.0]]).with(Mass, [1.0]);
    for make in integrators() {
        let free = Engine::<f64>::builder().domain(free.clone()).law(Motion);
        let mut free = free.boxed_integrator(make()).step(0.1).build().unwrap();
        assert_eq!(limit(&mut free).usable, f64::INFINITY, "{}", make().name());
    }
    for adaptive in [true, false] {
        let mut none = match adaptive {
            true => oscillator(0.0).engine::<f64>(DormandPrince5::default(), 0.1).unwrap(),
            false => oscillator(0.0).engine::<f64>(ImplicitMidpoint::default(), 0.1).unwrap(),
        };
        assert_eq!(none.stable_step().unwrap(), None);
    }
    let run = |asks: bool| {
        let mut engine = chain::<f64>(20, 100.0).step(0.01).build().unwrap();
        for _ in 0..20 {
            engine.steps_of(5, 0.01).unwrap();
            if asks {
                engine.stable_step().unwrap();
            }
        }
        (engine.state().numbers("bodies", Position).unwrap(), engine.evaluations())
    };
    assert_eq!(run(true), run(false));
}
