//! What implicit steps cost: an evaluation of all laws beside a derivative along a direction, and how often a step asks for
//! either, by the number of steps that leapfrog is stable at in one of theirs.
//!
//! `cargo bench -- implicit`; times are medians of rounds in which all take turns.

use std::time::Instant;

use vesper::prelude::*;
use vesper_benches::Run;
use vesper_benches::scenes::Bodies;
use vesper_laws::{Gravity, Motion, Spring};

/// Masses in a row, joined by stiff springs, the first one fixed.
fn chain(links: u32) -> Builder<f64> {
    let rows = links as usize + 1;
    let at = |row: usize| [row as f64 + 0.01 * (0.1 * row as f64).sin(), 0.0, 0.0];
    let bodies = Domain::new("bodies")
        .with(Position, (0..rows).map(at).collect::<Vec<_>>())
        .with(Velocity, vec![[0.0; 3]; rows])
        .with(Mass, (0..rows).map(|row| f64::from(row > 0)).collect::<Vec<_>>());
    let springs = Domain::new("springs")
        .link(Ends, "bodies", (0..links).map(|link| [link, link + 1]).collect::<Vec<_>>())
        .with(Stiffness, vec![2.5e5; links as usize])
        .with(RestLength, vec![1.0; links as usize]);
    Engine::builder().domain(bodies).domain(springs).law(Spring).law(Motion)
}

fn cloud(bodies: usize) -> Builder<f64> {
    let domain = Bodies::new(bodies).moving();
    Engine::builder().domain(domain).law(Gravity { g: 1e-3, softening: 0.25 }).law(Motion)
}

/// In place of steps: evaluations, or derivatives.
struct Asks {
    derivatives: bool,
}

impl Integrator for Asks {
    fn name(&self) -> &'static str {
        "asks"
    }
    fn order(&self) -> u32 {
        1
    }
    fn work_vectors(&self) -> usize {
        2
    }
    fn needs_derivatives(&self) -> bool {
        true
    }
    fn step(&mut self, system: &mut dyn System, _step: f64) -> Result<(), Fault> {
        if self.derivatives {
            system.derivative(Register::Work(1), Register::Work(0));
        } else {
            system.evaluate(Part::All);
        }
        Ok(())
    }
}

/// A scene by its name, how it is made, and a step.
type Scene = (&'static str, fn() -> Builder<f64>, f64);

const SCENES: [Scene; 3] = [
    ("chain of 1000 links", || chain(1000), 1e-3),
    ("cloud of 100", || cloud(100), 0.1),
    ("cloud of 1000", || cloud(1000), 0.1),
];

fn seconds(engine: &mut Engine<f64>, count: u64) -> f64 {
    let from = Instant::now();
    engine.steps_of(count, 1e-9).expect("the state stays finite");
    from.elapsed().as_secs_f64() / count as f64
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn costs(run: Run, (name, make, _): Scene) {
    let expect = "the scene has all that the laws read";
    let asks = |derivatives| make().backend(Backend::Cpu).integrator(Asks { derivatives }).build().expect(expect);
    let [mut evaluates, mut differentiates] = [asks(false), asks(true)];
    let (rounds, count) = if run == Run::Measure { (41, 20) } else { (1, 1) };
    let (mut plain, mut dual) = (Vec::new(), Vec::new());
    for _ in 0..rounds {
        plain.push(seconds(&mut evaluates, count));
        dual.push(seconds(&mut differentiates, count));
    }
    if run == Run::Measure {
        let (plain, dual) = (median(plain), median(dual));
        println!("{name:<20} evaluation {:9.2} us, derivative {:9.2} us: {:.1}", plain * 1e6, dual * 1e6, dual / plain);
    }
}

fn steps(run: Run, (name, make, step): Scene) {
    let longer: &[f64] = if run == Run::Measure { &[1.0, 10.0, 100.0] } else { &[1.0] };
    for factor in longer {
        let step = factor * step;
        for implicit in [false, true] {
            let integrator: Box<dyn Integrator> =
                if implicit { Box::new(ImplicitMidpoint::default()) } else { Box::new(ImplicitEuler::default()) };
            let mut engine = make().backend(Backend::Cpu).boxed_integrator(integrator).build().expect("as above");
            let count = if run == Run::Measure { 5 } else { 1 };
            let from = Instant::now();
            let done = engine.steps_of(count, step);
            let each = from.elapsed().as_secs_f64() / count as f64;
            let by = |number: u64| number as f64 / count as f64;
            let what = format!("{name:<20} {:<18} step {step:<6}", engine.integrator().name());
            match done {
                Ok(()) if run == Run::Measure => println!(
                    "{what} {:5.1} evaluations, {:7.1} derivatives, {:9.3} ms",
                    by(engine.evaluations()),
                    by(engine.derivatives()),
                    each * 1e3
                ),
                Ok(()) => {}
                Err(faults) => println!("{what} {faults}"),
            }
        }
    }
}

fn main() {
    let run = Run::from_arguments();
    if run == Run::List {
        println!("implicit: benchmark");
        return;
    }
    if !run.wants("implicit") {
        return;
    }
    SCENES.into_iter().for_each(|scene| costs(run, scene));
    SCENES.into_iter().for_each(|scene| steps(run, scene));
}
