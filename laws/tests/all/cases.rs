//! The case studies C2 to C7: where everything ends up, to the accuracy that the integrator allows.

use vesper::prelude::*;
use vesper_laws::invariants::{Invariants, invariants};
use vesper_laws::reference::{Pair, Problem, Spectrograph, Throw, pairs};
use vesper_laws::{Damper, Drag, Motion, Spring, UniformGravity};

/// The largest error of a problem at its times, each reached by a whole number of steps of at most `step`.
fn error(problem: &impl Problem, integrator: impl Integrator + 'static, step: f64) -> f64 {
    let mut engine = problem.engine::<f64>(integrator, step).unwrap();
    let errors = problem.times().into_iter().map(|time| {
        let rest = time - engine.time();
        let count = (rest / step - 1e-6).ceil();
        engine.steps_of(count as u64, rest / count).unwrap();
        problem.error(&engine).unwrap()
    });
    errors.fold(0.0, f64::max)
}

#[test]
fn c2_uniform_motion_reaches_its_place() {
    let problem = Throw::uniform_motion();
    // The only error is the rounding of 600 sums; with a step that binary numbers hold there is none.
    assert!(error(&problem, SemiImplicitEuler, 1.0 / 60.0) < 1e-13);
    let mut engine = problem.engine::<f64>(SemiImplicitEuler, 1.0 / 64.0).unwrap();
    engine.advance(10.0).unwrap();
    assert_eq!(engine.state().get("bodies", Position, 0).unwrap(), DVec3::new(0.0, 0.0, 10.0));
}

#[test]
fn c3_a_vertical_throw_turns_and_comes_back() {
    let problem = Throw::vertical();
    // A constant force: order 2 and more are exact but for rounding; semi-implicit Euler falls short by g t h / 2.
    assert!(error(&problem, Leapfrog::default(), 1.0 / 60.0) < 1e-13);
    assert!(error(&problem, RungeKutta4, 1.0 / 60.0) < 1e-13);
    let top = 10.0 / 9.81;
    let step = top / 64.0;
    let mut engine = problem.engine::<f64>(SemiImplicitEuler, step).unwrap();
    engine.steps_of(128, step).unwrap();
    let z = engine.state().get("bodies", Position, 0).unwrap().z;
    assert!((z + 9.81 * 2.0 * top * step / 2.0).abs() < 1e-12, "{z}");
    // It stands still after a little over 1 s: 62 frames of 1/60 s are too late, 61 too early.
    let mut engine = problem.engine::<f64>(Leapfrog::default(), 1.0 / 60.0).unwrap();
    let speed = |engine: &Engine<f64>| engine.state().get("bodies", Velocity, 0).unwrap().z;
    engine.steps_of(61, 1.0 / 60.0).unwrap();
    assert!(speed(&engine) > 0.0);
    engine.steps_of(1, 1.0 / 60.0).unwrap();
    assert!(speed(&engine) < 0.0);
}

#[test]
fn c4_oblique_throws_keep_equal_heights_and_their_ratios() {
    let problem = Throw::oblique();
    assert!(error(&problem, Leapfrog::default(), 1.0 / 60.0) < 1e-13);
    let mut engine = problem.engine::<f64>(Leapfrog::default(), 1.0 / 60.0).unwrap();
    for _frame in 0..360 {
        engine.steps_of(1, 1.0 / 60.0).unwrap();
        let place = engine.state().values("bodies", Position).unwrap();
        assert!(place[0].z == place[1].z && place[1].z == place[2].z, "equal heights at every instant");
        assert!((place[1].x - 2.0 * place[0].x).abs() < 1e-12 && (place[2].x - 3.0 * place[0].x).abs() < 1e-12);
    }
}

/// C5: rings of masses joined along the rings and along the radii; the rim is fixed, the others are displaced. With dampers
/// along the threads, in N s/m, and air around, in kg/s, or without.
fn web(damping: Option<f64>, air: Option<f64>) -> Builder<f64> {
    const SPOKES: u32 = 5;
    const RINGS: u32 = 4;
    let flat = |row: u32| {
        let angle = core::f64::consts::TAU * f64::from(row % SPOKES) / f64::from(SPOKES);
        DVec3::new(angle.cos(), angle.sin(), 0.0) * (2.5 * f64::from(row / SPOKES + 1))
    };
    let free = |row: u32| row < SPOKES * (RINGS - 1);
    // Random numbers of a fixed seed: Knuth's linear congruential generator (MMIX), its upper bits.
    let mut seed = 7_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let mut position = Vec::new();
    for row in 0..SPOKES * RINGS {
        let by = DVec3::new(random(), random(), random());
        position.push(if free(row) { flat(row) + by } else { flat(row) });
    }
    let rows = SPOKES * RINGS;
    let ring = (0..rows).map(|row| [row, row / SPOKES * SPOKES + (row + 1) % SPOKES]);
    let radii = (0..rows - SPOKES).map(|row| [row, row + SPOKES]);
    let ends: Vec<[u32; 2]> = ring.chain(radii).filter(|&[a, b]| free(a) || free(b)).collect();
    // Threads are taut: a tenth shorter than the flat web would have them.
    let rest: Vec<f64> = ends.iter().map(|&[a, b]| 0.9 * (flat(b) - flat(a)).length()).collect();
    let mut bodies = Domain::new("bodies")
        .with(Position, position)
        .with(Velocity, vec![[0.0; 3]; rows as usize])
        .with(Mass, (0..rows).map(|row| f64::from(u8::from(free(row)))).collect::<Vec<_>>());
    let mut springs = Domain::new("springs")
        .link(Ends, "bodies", ends.clone())
        .with(Stiffness, vec![100.0; ends.len()])
        .with(RestLength, rest);
    if let Some(damping) = damping {
        springs = springs.with(Damping, vec![damping; ends.len()]);
    }
    if let Some(air) = air {
        bodies = bodies.with(DragCoefficient, vec![air; rows as usize]);
    }
    // Without coefficients the damper and the drag are dormant.
    Engine::builder().domain(bodies).domain(springs).law(Spring).law(Damper).law(Drag).law(Motion)
}

fn fastest(engine: &Engine<f64>) -> f64 {
    engine.state().values("bodies", Velocity).unwrap().into_iter().map(DVec3::length).fold(0.0, f64::max)
}

#[test]
fn c5_a_web_without_damping_keeps_its_energy() {
    let mut engine = web(None, None).integrator(Leapfrog::default()).step(0.005).build().unwrap();
    let first = engine.energy().unwrap().0;
    for _ in 0..100 {
        engine.advance(0.5).unwrap();
        let off = (engine.energy().unwrap().0 / first - 1.0).abs();
        assert!(off < 2e-3, "{off:e}");
    }
}

#[test]
fn c5_a_web_comes_to_rest_and_never_gains_energy() {
    // Dampers along the threads alone would take for ever: motion across taut threads stretches them in second order only,
    // so what is left swings ever longer. Air takes that too.
    let mut engine = web(Some(1.0), Some(0.5)).integrator(RungeKutta4).step(0.01).build().unwrap();
    let (first, silent) = engine.energy().unwrap();
    assert!(silent.is_empty());
    let mut before = first;
    for frame in 0..1200 {
        engine.advance(0.1).unwrap();
        let energy = engine.energy().unwrap().0;
        // At rest only rounding is left: some parts in 1e16 of the energy of the taut threads.
        assert!(energy <= before + 1e-14 * first, "frame {frame}: {energy} after {before}");
        assert!(energy < before || fastest(&engine) < 1e-6, "frame {frame}: it falls until nothing moves");
        before = energy;
    }
    let fastest = fastest(&engine);
    let heights = engine.state().values("bodies", Position).unwrap().into_iter().map(|place| place.z.abs());
    let highest = heights.fold(0.0, f64::max);
    println!("energy {first} J to {before} J; at 120 s up to {fastest:.1e} m/s and {highest:.1e} m from flat");
    assert!(fastest < 1e-9 && highest < 1e-9, "at rest, and flat again: {fastest:e} m/s, {highest:e} m");
    assert!(before > 0.0 && before < 0.8 * first, "{before} of {first}: the threads stay taut");
}

#[test]
fn c5_dampers_along_the_threads_never_add_energy() {
    let mut engine = web(Some(1.0), None).integrator(RungeKutta4).step(0.01).build().unwrap();
    let first = engine.energy().unwrap().0;
    let mut before = first;
    for frame in 0..1200 {
        engine.advance(0.1).unwrap();
        let energy = engine.energy().unwrap().0;
        assert!(energy < before, "frame {frame}: {energy} after {before}");
        before = energy;
    }
    println!("dampers alone: energy {first} J to {before} J in 120 s");
}

/// Where each particle comes back to y = 0, interpolated within the step, less where it should: in m. Steps go across the
/// jumps of the fields.
fn landing_errors(integrator: impl Integrator + 'static, step: f64) -> [f64; 6] {
    let builder = Spectrograph.setup(Engine::<f64>::builder()).across_jumps();
    let mut engine = builder.integrator(integrator).step(step).build().unwrap();
    let mut landed = [None; 6];
    let mut before = engine.state().values("bodies", Position).unwrap();
    while landed.iter().any(Option::is_none) {
        assert!(engine.time() < 20.0, "{landed:?}");
        engine.steps_of(1, step).unwrap();
        let now = engine.state().values("bodies", Position).unwrap();
        for row in 0..6 {
            if before[row].y >= 0.0 && now[row].y < 0.0 && landed[row].is_none() {
                let fraction = before[row].y / (before[row].y - now[row].y);
                landed[row] = Some(before[row].x + fraction * (now[row].x - before[row].x));
            }
        }
        before = now;
    }
    let exact = Spectrograph.landings();
    core::array::from_fn(|row| landed[row].unwrap() - exact[row].x)
}

#[test]
fn c6_six_particles_land_where_they_should() {
    // The field that a particle feels jumps at y = 0, and a step that goes across the jump takes the wrong one for up to its whole
    // length: the speed is off by up to q E h / m or the direction by up to q B h / m, so the landing by some v h. That is
    // first order in the step for any integrator: a tenth of the step gives a tenth of the bound, and no better integrator
    // helps.
    let fastest = 100.0;
    for step in [1e-2, 1e-3, 1e-4] {
        let errors = [
            landing_errors(SemiImplicitEuler, step),
            landing_errors(Leapfrog::default(), step),
            landing_errors(RungeKutta4, step),
        ];
        let worst = errors.map(|rows| rows.into_iter().map(f64::abs).fold(0.0, f64::max));
        println!("step {step:e} s: largest error of a landing {:.1e} {:.1e} {:.1e} m", worst[0], worst[1], worst[2]);
        for worst in worst {
            assert!(worst < 4.0 * fastest * step, "{worst} m at a step of {step} s");
        }
        // It is there: order 4 is no better than order 1 within a factor, where a smooth field would leave it 1e-8 m.
        assert!(worst[2] > 0.01 * fastest * step, "{} m at a step of {step} s", worst[2]);
    }
}

/// Momentum and angular momentum lost since `first`, of the sum of their magnitudes then and now.
fn lost(first: &Invariants, last: &Invariants) -> (f64, f64) {
    let scale = |a: f64, b: f64| a.max(b).max(f64::MIN_POSITIVE);
    let momentum = (last.momentum - first.momentum).length() / scale(first.momentum_scale, last.momentum_scale);
    let turning = (last.angular_momentum - first.angular_momentum).length();
    (momentum, turning / scale(first.angular_momentum_scale, last.angular_momentum_scale))
}

/// The invariants of a pair, after taking away what gravity gives to momentum and angular momentum.
fn without_gravity(pair: &Pair, engine: &Engine<f64>) -> Invariants {
    let mut sums = invariants(engine.state(), "bodies").unwrap();
    if pair.gravity {
        // dp/dt = M g, dL/dt = M centre x g: along y only, so z of L and x, y of p are kept as they are.
        sums.momentum.z = 0.0;
        sums.angular_momentum.x = 0.0;
        sums.angular_momentum.y = 0.0;
    }
    sums
}

#[test]
fn c7_pairs_on_a_spring_follow_their_references() {
    for pair in pairs() {
        // Order 4 at 1e-3 s: sqrt(k / reduced mass) is 14 per s, so (h omega)^4 / 120 per radian is about 3e-10.
        let (rk4, leapfrog) = (error(&pair, RungeKutta4, 1e-3), error(&pair, Leapfrog::default(), 1e-3));
        let euler = error(&pair, SemiImplicitEuler, 1e-3);
        println!("{}: runge_kutta_4 {rk4:.1e}, leapfrog {leapfrog:.1e}, semi_implicit_euler {euler:.1e}", pair.name());
        assert!(rk4 < 5e-9, "{}: {rk4:e}", pair.name());
        assert!(leapfrog < 1e-3, "{}: {leapfrog:e}", pair.name());
        assert!(euler < 1e-1, "{}: {euler:e}", pair.name());
        // A tenth of the step: the limit is the rounding of 1e5 sums.
        let fine = error(&pair, RungeKutta4, 1e-4);
        assert!(fine < 1e-11, "{}: {fine:e}", pair.name());
    }
}

#[test]
fn c7_momentum_and_angular_momentum_are_kept() {
    // Every kick is along the line between the two, so the first two keep both whatever the step. Runge-Kutta keeps what is
    // linear in the state, as momentum is; of the angular momentum it loses a share of its own order: 1.4e-12 at 1e-3 s.
    type Method = fn() -> Box<dyn Integrator>;
    let integrators: [(Method, f64); 3] = [
        (|| Box::new(SemiImplicitEuler), 1e-3),
        (|| Box::new(Leapfrog::default()), 1e-3),
        (|| Box::new(RungeKutta4), 5e-4),
    ];
    for pair in pairs() {
        for (integrator, step) in integrators {
            let builder = pair.setup(Engine::<f64>::builder()).boxed_integrator(integrator());
            let mut engine = builder.step(step).build().unwrap();
            let first = without_gravity(&pair, &engine);
            for _ in 0..10 {
                engine.advance(1.0).unwrap();
                let (momentum, turning) = lost(&first, &without_gravity(&pair, &engine));
                assert!(momentum < 1e-12 && turning < 1e-12, "{}: {momentum:e} {turning:e}", pair.name());
            }
        }
    }
}

#[test]
fn an_external_force_is_where_the_sum_of_forces_starts() {
    // It holds one of two bodies against its weight; the other one falls.
    let bodies = Domain::new("bodies")
        .with(Position, [[0.0; 3]; 2])
        .with(Velocity, [[0.0; 3]; 2])
        .with(Mass, [2.0; 2])
        .with(ExternalForce, [[0.0, 0.0, 16.0], [0.0; 3]]);
    let mut engine = Engine::<f64>::builder()
        .domain(bodies)
        .constant(GravityAcceleration, [[0.0, 0.0, -8.0]])
        .law(UniformGravity)
        .law(Motion)
        .step(0.25)
        .build()
        .unwrap();
    engine.advance(1.0).unwrap();
    let height = |engine: &Engine<f64>| -> Vec<f64> {
        engine.state().values("bodies", Position).unwrap().into_iter().map(|place| place.z).collect()
    };
    assert_eq!(height(&engine), [0.0, -4.0]);
    // The client lets go of it, and pushes the other one up: from v = -8 it takes another second to stop.
    engine.state_mut().set("bodies", ExternalForce, 0, DVec3::ZERO).unwrap();
    engine.state_mut().set("bodies", ExternalForce, 1, DVec3::Z * 32.0).unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(height(&engine), [-4.0, -8.0]);
    assert_eq!(engine.state().get("bodies", Velocity, 1).unwrap(), DVec3::ZERO);
}
