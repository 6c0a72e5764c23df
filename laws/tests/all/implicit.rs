//! Implicit integrators: stiff problems at steps that explicit ones cannot take, what is kept over long runs, and what a step
//! costs.

use vesper::prelude::*;
use vesper_laws::reference::{Kepler, Oscillator, Problem};
use vesper_laws::{ContactPlane, Coulomb, Drag, Gravity, Motion, UniformGravity};

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

/// Dust in a gas at rest, with weight: the stiff drag of the reference cases, relaxation in 1e-4 s.
fn dust<P: Precision>(builder: Builder<P>) -> Builder<P> {
    let bodies = Domain::new("bodies")
        .with(Position, [[0.0, 0.0, 1.0]])
        .with(Velocity, [[10.0, 0.0, 0.0]])
        .with(Mass, [1e-9])
        .with(DragCoefficient, [1e-5])
        .with(WindVelocity, [[1.0, 0.0, 0.0]]);
    let builder = builder.domain(bodies).constant(GravityAcceleration, [[0.0, 0.0, -9.81]]);
    builder.law(UniformGravity).law(Drag).law(Motion)
}

#[test]
fn stiff_drag_falls_at_its_terminal_speed() {
    // Steps of a hundred times the relaxation. Implicit Euler takes the fast part away at once; the midpoint rule turns its sign
    // 1000 times, by (1 - 50) / (1 + 50) each.
    let mut euler = dust(Engine::<f64>::builder()).integrator(ImplicitEuler::default()).step(0.01).build().unwrap();
    euler.steps_of(1000, 0.01).unwrap();
    let velocity = euler.state().get("bodies", Velocity, 0).unwrap();
    assert!((velocity - DVec3::new(1.0, 0.0, -9.81e-4)).length() < 1e-12, "{velocity}");
    let builder = dust(Engine::<f64>::builder()).integrator(ImplicitMidpoint::default());
    let mut midpoint = builder.step(0.01).build().unwrap();
    midpoint.steps_of(1, 0.01).unwrap();
    let turned = midpoint.state().get("bodies", Velocity, 0).unwrap().x - 1.0;
    assert!((turned + 9.0 * 49.0 / 51.0).abs() < 1e-12, "{turned}");
    midpoint.steps_of(999, 0.01).unwrap();
    let velocity = midpoint.state().get("bodies", Velocity, 0).unwrap();
    assert!((velocity - DVec3::new(1.0, 0.0, -9.81e-4)).length() < 1e-12, "{velocity}");
    // What an explicit method is told.
    let mut explicit = dust(Engine::<f64>::builder()).step(0.01).build().unwrap();
    let stable = explicit.stable_step().unwrap().unwrap();
    assert!((stable.usable - 2e-4).abs() < 1e-9, "{stable:?}");
}

#[test]
fn a_chain_of_a_thousand_links_at_ten_times_the_stable_step() {
    let step = 0.02;
    for (follows, builder) in [(true, super::stability::chain::<f64>(1000, 2.5e5)), (false, with_drag())] {
        let mut engine = builder.integrator(ImplicitMidpoint::default()).step(step).build().unwrap();
        let (first, _) = engine.energy().unwrap();
        engine.steps_of(10, step).unwrap();
        let (last, _) = engine.energy().unwrap();
        let per_step = |count: u64| count as f64 / engine.steps() as f64;
        println!(
            "a chain: energy off by {:.1e}; {:.1} evaluations and {:.1} derivatives a step",
            last / first - 1.0,
            per_step(engine.evaluations()),
            per_step(engine.derivatives())
        );
        if follows {
            // The springs are linear while all motion is along them.
            assert!((last / first - 1.0).abs() < 1e-8, "{first:e}, {last:e}");
        } else {
            assert!(last < first, "{first:e}, {last:e}");
        }
    }
}

/// The chain in a gas.
fn with_drag() -> Builder<f64> {
    super::stability::chain::<f64>(1000, 2.5e5).law(HeavyAir)
}

/// Drag without a coefficient of its own, so that the chain needs none.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity), adds(force: Force))]
struct HeavyAir;

#[kernel]
impl<R: Real> RowLaw<R> for HeavyAir {
    fn row(&self, body: HeavyAirRow<R>) -> R::Vec3 {
        body.velocity * (R::lit(-0.5) * body.velocity.length())
    }
}

/// The largest distance from the answer at the problem's times, as part of its scale.
fn errors(problem: &Oscillator, engine: &mut Engine<impl Precision>, step: f64) -> f64 {
    (0..20).fold(0.0, |worst, _| {
        engine.steps_of(10, step).unwrap();
        f64::max(worst, problem.error(engine).unwrap())
    })
}

#[test]
fn single_precision_and_compensated_states_follow_the_answer() {
    let problem = Oscillator { damping: 0.3, ..Oscillator::default() };
    let step = 0.02;
    let double = errors(&problem, &mut problem.engine::<f64>(ImplicitMidpoint::default(), step).unwrap(), step);
    let single = errors(&problem, &mut problem.engine::<f32>(ImplicitMidpoint::default(), step).unwrap(), step);
    assert!(double < 1e-4 && (single - double).abs() < 2e-6, "{double:e}, {single:e}");
    let builder = problem.setup(Engine::<f32>::builder()).compensated().integrator(ImplicitMidpoint::default());
    let compensated = errors(&problem, &mut builder.step(step).build().unwrap(), step);
    assert!((compensated - double).abs() < 1e-6, "{double:e}, {compensated:e}");
}

/// A force that grows with the time: x'' = 6 t, of which x = t^3.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(mass: Mass), scene(time: Time), adds(force: Force))]
struct Growing;

#[kernel]
impl<R: Real> RowLaw<R> for Growing {
    fn row(&self, body: GrowingRow<R>) -> R::Vec3 {
        R::Vec3::new(R::lit(6.0) * body.time * body.mass, R::lit(0.0), R::lit(0.0))
    }
}

#[test]
fn time_is_that_of_the_rule() {
    let bodies = Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    let builder = || Engine::<f64>::builder().domain(bodies.clone()).law(Growing).law(Motion).step(0.5);
    let mut euler = builder().integrator(ImplicitEuler::default()).build().unwrap();
    euler.steps_of(2, 0.5).unwrap();
    // v = 0.5 (6 0.5 + 6 1), x = 0.5 (1.5 + 4.5)
    assert_eq!(euler.state().get("bodies", Velocity, 0).unwrap().x, 4.5);
    assert_eq!(euler.state().get("bodies", Position, 0).unwrap().x, 3.0);
    let mut midpoint = builder().integrator(ImplicitMidpoint::default()).build().unwrap();
    midpoint.steps_of(2, 0.5).unwrap();
    // v = 0.5 (6 0.25 + 6 0.75), x = 0.5 (0.375 + 1.875)
    assert_eq!(midpoint.state().get("bodies", Velocity, 0).unwrap().x, 3.0);
    assert_eq!(midpoint.state().get("bodies", Position, 0).unwrap().x, 1.125);
}

#[test]
fn a_stiff_contact_is_touched_and_left() {
    // A ball that falls by 1 m on a plane it sinks in by 4.4e-5 m; a step is seven times the time of the touch.
    let bodies = Domain::new("bodies").with(Position, [[0.0, 0.0, 1.0]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    let plane = ContactPlane {
        normal: DVec3::Z,
        offset: 0.0,
        stiffness: 1e10,
        damping: 0.0,
        friction: 0.0,
        resting_speed: 1e-6,
    };
    let mut engine = Engine::<f64>::builder()
        .domain(bodies)
        .constant(GravityAcceleration, [[0.0, 0.0, -10.0]])
        .law(UniformGravity)
        .law(plane)
        .law(Motion)
        .integrator(ImplicitMidpoint::default())
        .step(1e-3)
        .build()
        .unwrap();
    let (first, _) = engine.energy().unwrap();
    let mut lowest = f64::INFINITY;
    for _ in 0..800 {
        engine.steps_of(1, 1e-3).unwrap();
        lowest = lowest.min(engine.state().get("bodies", Position, 0).unwrap().z);
    }
    let (last, _) = engine.energy().unwrap();
    let velocity = engine.state().get("bodies", Velocity, 0).unwrap().z;
    println!("energy off by {:.1e}, lowest {lowest:e}, {velocity} m/s", last / first - 1.0);
    assert!(
        (last / first - 1.0).abs() < 1e-6 && lowest > -1e-3 && velocity > 0.0,
        "{first} {last} {lowest} {velocity}"
    );
}

/// A state that is neither coordinate nor momentum: a rod that cools, row by row, with x' = -k x for very unlike k.
#[test]
fn states_that_are_no_motion_relax() {
    property! {
        /// What is left.
        pub Left: Scalar, "1";
        /// How fast it goes.
        pub Decay: Scalar, "1/s";
    }
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(left: Left, decay: Decay), rates(left: Left))]
    struct Fade;
    #[kernel]
    impl<R: Real> RowLaw<R> for Fade {
        fn row(&self, row: FadeRow<R>) -> R {
            -row.left * row.decay
        }
    }
    let rods = Domain::new("rods").with(Left, [1.0, 1.0, 1.0]).with(Decay, [1e-3, 1.0, 1e6]);
    let mut engine =
        Engine::<f64>::builder().domain(rods).law(Fade).integrator(ImplicitEuler::default()).step(0.5).build().unwrap();
    engine.steps_of(2, 0.5).unwrap();
    let left = engine.state().numbers("rods", Left).unwrap();
    for (left, decay) in left.iter().zip([1e-3, 1.0, 1e6_f64]) {
        let exact = (1.0 + 0.5 * decay).powi(-2);
        assert!((left - exact).abs() < 1e-14, "{left} {exact}");
    }
}

#[test]
fn momenta_of_relativity_are_solved_for_with_their_coordinates() {
    // p' = -k x for a charge tied to a place, of which the velocity is no multiple of the momentum: leapfrog at a hundredth of
    // the step agrees.
    use vesper_laws::{FieldGravity, RelativisticMotion};
    let bodies = Domain::new("bodies")
        .with(Position, [[1.0, 0.0, 0.0]])
        .with(Momentum, [[0.0, 2.0, 0.0]])
        .with(RestMass, [1.0])
        .with(Mass, [1.0]);
    let builder = || {
        let pull = Points { points: vec![Point { at: [0.0; 3], strength: -4.0 }] };
        let builder = Engine::<f64>::builder().domain(bodies.clone()).constant(SpeedOfLight, [3.0]);
        builder.field(GravityField, pull).law(FieldGravity).law(RelativisticMotion).step(0.01)
    };
    let place = |integrator: Box<dyn Integrator>, step: f64| {
        let mut engine = builder().boxed_integrator(integrator).build().unwrap();
        engine.steps_of((1.0 / step).round() as u64, step).unwrap();
        engine.state().get("bodies", Position, 0).unwrap()
    };
    let exact = place(Box::<Leapfrog>::default(), 1e-5);
    let [coarse, fine] = [0.02, 0.01].map(|step| (place(Box::<ImplicitMidpoint>::default(), step) - exact).length());
    assert!((coarse / fine).log2() > 1.9 && fine < 1e-3, "{coarse:e} {fine:e}");
}

#[test]
fn subsets_and_many_threads_give_the_same_bits() {
    let run = |threads: usize| {
        let bodies = Domain::new("bodies")
            .with(Position, (0..50).map(|row| [f64::from(row), f64::from(row % 7), 0.0]).collect::<Vec<_>>())
            .with(Velocity, vec![[0.0, 0.1, 0.0]; 50])
            .with(Mass, vec![1.0; 50])
            .subset(Charge, [3, 17, 40, 41], [1.0, -2.0, 1.5, 0.5])
            .subset(DragCoefficient, [0, 17, 49], [1e4, 10.0, 1e5]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .law(Coulomb { k: 1e3, softening: 0.0 })
            .law(Drag)
            .law(Motion)
            .integrator(ImplicitEuler::default())
            .step(0.05)
            .backend(if threads > 1 { Backend::Parallel } else { Backend::Cpu })
            .threads(threads)
            .build()
            .unwrap();
        engine.steps_of(20, 0.05).unwrap();
        engine.state().numbers("bodies", Position).unwrap()
    };
    let one = run(1);
    assert_eq!(one, run(3));
    // Drag without a charge near: v = 0.1 (1 + 1e4 h)^-20 is gone after the first step.
    let gone = 0.1 * 0.05 / (1.0 + 1e4 * 0.05);
    assert!((one[1] - gone / (1.0 - 1.0 / 501.0)).abs() < 1e-9, "{}", one[1]);
}

#[test]
fn a_checkpoint_goes_on_with_the_same_bits() {
    let problem = stiff_spring(0.1);
    let step = 1.0 / 60.0;
    let mut whole = problem.engine::<f64>(ImplicitMidpoint::default(), step).unwrap();
    whole.steps_of(7, step).unwrap();
    let kept = whole.checkpoint().unwrap();
    whole.steps_of(9, step).unwrap();
    let mut again = problem.engine::<f64>(ImplicitMidpoint::default(), step).unwrap();
    again.restore(&kept).unwrap();
    again.steps_of(9, step).unwrap();
    assert_eq!(whole.state().numbers("bodies", Position), again.state().numbers("bodies", Position));
}

/// A force with a jump in it that no switch tells of.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force))]
struct Cliff;

#[kernel]
impl<R: Real> RowLaw<R> for Cliff {
    fn row(&self, body: CliffRow<R>) -> R::Vec3 {
        let zero = R::lit(0.0);
        let push = R::select(body.position.x().less(zero), R::lit(1.0), R::lit(-1.0));
        R::Vec3::new(push, zero, zero)
    }
}

#[test]
fn a_step_without_a_solution_is_a_fault_and_changes_nothing() {
    let bodies = Domain::new("bodies").with(Position, [[0.1, 0.0, 0.0]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    let builder = Engine::<f64>::builder().domain(bodies).law(Cliff).law(Motion).integrator(ImplicitEuler::default());
    let mut engine = builder.step(1.0).build().unwrap();
    let faults = engine.steps_of(1, 1.0).unwrap_err();
    let text = faults.to_string();
    let expected = "implicit_euler cannot solve its equation for the step of 1e0 s at 0e0 s: ";
    assert!(text.starts_with(expected) && text.contains("take a shorter step"), "{text}");
    assert_eq!(engine.state().get("bodies", Position, 0).unwrap(), DVec3::new(0.1, 0.0, 0.0));
    assert_eq!(engine.state().get("bodies", Velocity, 0).unwrap(), DVec3::ZERO);
    assert_eq!(engine.time(), 0.0);
}

#[test]
fn laws_that_are_not_evaluated_on_every_step_are_refused() {
    for integrator in [Box::new(ImplicitEuler::default()) as Box<dyn Integrator>, Box::new(ImplicitMidpoint::default())]
    {
        let name = integrator.name();
        let bodies =
            Domain::new("bodies").with(Position, [[0.0; 3]; 2]).with(Velocity, [[0.0; 3]; 2]).with(Mass, [1.0; 2]);
        let builder = Engine::<f64>::builder().domain(bodies).law(Gravity::default().every(4)).law(Motion);
        let faults = builder.boxed_integrator(integrator).step(0.1).build().unwrap_err();
        let expected = format!(
            "{name} needs every law to be evaluated whenever it asks, but gravity is evaluated on some steps only: leave out its \
             `every`, or take respa"
        );
        assert_eq!(faults.to_string(), expected);
    }
}
