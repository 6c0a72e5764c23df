//! Implicit integrators: stiff problems at steps that explicit ones cannot take, what is kept over long runs, and what a step
//! costs.

use vesper::prelude::*;
use vesper_laws::reference::{Kepler, Oscillator, Problem};

/// The stiff spring of the reference cases: k = 5e6 N/m, m = 100 kg, pulled out by 1 cm, a damping ratio.
fn stiff_spring(ratio: f64) -> Oscillator {
    let (stiffness, mass) = (5e6, 100.0_f64);
    let damping = 2.0 * ratio * (stiffness * mass).sqrt();
    Oscillator { mass, stiffness, damping, rest_length: 1.0, displacement: 0.01, speed: 0.0 }
}

/// The largest |x| of the displacement over 300 frames of 1/60 s, by that at the start; its largest error, and the one at the
/// end.
fn over_frames(problem: &Oscillator, integrator: impl Integrator + 'static) -> ([f64; 3], Engine<f64>) {
    let step = 1.0 / 60.0;
    let mut engine = problem.engine::<f64>(integrator, step).unwrap();
    let mut found = [0.0_f64; 3];
    for _ in 0..300 {
        engine.steps_of(1, step).unwrap();
        let x = engine.state().get("bodies", Position, 1).unwrap().x - problem.rest_length;
        let exact = problem.exact(engine.time()).unwrap()[1].position.x - problem.rest_length;
        let off = (x - exact).abs() / problem.displacement;
        found = [found[0].max(x.abs() / problem.displacement), found[1].max(off), off];
    }
    (found, engine)
}

#[test]
fn a_stiff_spring_stays_bounded_at_all_damping_ratios() {
    println!("omega h = 3.73; errors by the displacement at the start");
    println!("ratio  integrator         largest |x|  largest error  error at 5 s  evaluations  derivatives (a step)");
    for ratio in [0.0, 0.1, 1.0, 2.0] {
        let problem = stiff_spring(ratio);
        for (name, (found, engine)) in [
            ("implicit_euler", over_frames(&problem, ImplicitEuler::default())),
            ("implicit_midpoint", over_frames(&problem, ImplicitMidpoint::default())),
        ] {
            let [largest, worst, last] = found;
            let per_step = |count: u64| count as f64 / engine.steps() as f64;
            println!(
                "{ratio:<6} {name:<18} {largest:<12.4} {worst:<14.2e} {last:<13.2e} {:<12.2} {:.2}",
                per_step(engine.evaluations()),
                per_step(engine.derivatives())
            );
            assert!(largest < 1.0 + 1e-9, "{name} at {ratio}: {largest}");
            // What fades is gone at the end, where anything does; the midpoint rule does not take away what is fast.
            if name == "implicit_euler" && ratio > 0.0 {
                assert!(last < 1e-9, "{name} at {ratio}: {last:e}");
            }
        }
    }
}

#[test]
fn implicit_midpoint_keeps_the_energy_of_a_linear_spring() {
    // 1e5 steps of omega h = 3.73: a quadratic invariant, so that only rounding and what the solver leaves are lost.
    let problem = stiff_spring(0.0);
    let step = 1.0 / 60.0;
    let mut engine = problem.engine::<f64>(ImplicitMidpoint::default(), step).unwrap();
    let (first, _) = engine.energy().unwrap();
    let mut worst = 0.0_f64;
    for _ in 0..100 {
        engine.steps_of(1000, step).unwrap();
        worst = worst.max((engine.energy().unwrap().0 / first - 1.0).abs());
    }
    println!("energy off by {worst:.1e} of itself over 1e5 steps");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn implicit_midpoint_follows_a_kepler_orbit_without_drift() {
    let step = 0.01;
    let mut engine = Kepler { eccentricity: 0.5 }.engine::<f64>(ImplicitMidpoint::default(), step).unwrap();
    let (first, _) = engine.energy().unwrap();
    let mut halves = [0.0_f64; 2];
    // Often enough to see each pass of the centre.
    for look in 0..6283 {
        engine.steps_of(10, step).unwrap();
        let off = (engine.energy().unwrap().0 / first - 1.0).abs();
        halves[look / 3142] = halves[look / 3142].max(off);
    }
    let [early, late] = halves;
    println!("energy off by {early:.2e} in the first 50 orbits, {late:.2e} in the next");
    assert!(late < 1e-3 && late < 1.05 * early, "{early:e}, {late:e}");
}
