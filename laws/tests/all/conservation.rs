//! What is conserved, and how well: energy, momentum, angular momentum, the motion of the centre of mass.

use vesper::prelude::*;
use vesper_laws::invariants::{Weight, angular_momentum, centre_of_mass, invariants, momentum};
use vesper_laws::reference::{Cyclotron, Kepler, Oscillator, Problem};
use vesper_laws::{Coulomb, Damper, Gravity, GravityByParameter, Kinematics, Motion, PostNewtonian, Spring};

/// The largest |E - E_0| / |E_0| over `blocks` blocks of `steps` steps each, for the first half and for all of them.
fn energy_drift(engine: &mut Engine<f64>, step: f64, blocks: u32, steps: u64) -> (f64, f64) {
    let (first, silent) = engine.energy().unwrap();
    assert!(silent.is_empty(), "{silent:?}");
    let (mut half, mut all) = (0.0_f64, 0.0_f64);
    for block in 0..blocks {
        engine.steps_of(steps, step).unwrap();
        let off = ((engine.energy().unwrap().0 - first) / first).abs();
        all = all.max(off);
        if block < blocks / 2 {
            half = half.max(off);
        }
    }
    (half, all)
}

#[test]
fn symplectic_integrators_do_not_lose_energy_over_hundreds_of_periods() {
    // 300 periods of 100 steps; the bounds are (h omega)^2 / 4 and h omega / 2 of the energy, with h omega = 0.063.
    let step = core::f64::consts::TAU / 100.0;
    for symplectic in [true, false] {
        let problem = Oscillator { speed: 0.5, ..Oscillator::default() };
        let (mut engine, bound) = if symplectic {
            (problem.engine(Leapfrog::default(), step).unwrap(), 1.1e-3)
        } else {
            (problem.engine(SemiImplicitEuler, step).unwrap(), 0.06)
        };
        let (half, all) = energy_drift(&mut engine, step, 300, 97);
        assert!(all < bound && all < 1.01 * half, "{half:e} {all:e}");
    }
    let (half, all) =
        energy_drift(&mut Kepler { eccentricity: 0.5 }.engine(Leapfrog::default(), 0.01).unwrap(), 0.01, 300, 629);
    assert!(all < 1e-3 && all < 1.05 * half, "{half:e} {all:e}");
}

#[test]
fn runge_kutta_loses_energy_as_its_theory_says() {
    // (h omega)^6 / 72 of the energy per step: over 100 periods of 100 steps 8.5e-6.
    let step = core::f64::consts::TAU / 100.0;
    let mut engine = Oscillator::default().engine(RungeKutta4, step).unwrap();
    let (_, lost) = energy_drift(&mut engine, step, 100, 100);
    let theory = 1e4 * step.powi(6) / 72.0;
    assert!((lost / theory - 1.0).abs() < 0.05, "{lost:e} against {theory:e}");
}

#[test]
fn a_magnetic_field_does_no_work() {
    // Runge-Kutta 4: (h omega)^6 / 72 per step again, 628 steps of h omega = 0.01.
    let mut engine = Cyclotron::default().engine(RungeKutta4, 0.01).unwrap();
    let (_, lost) = energy_drift(&mut engine, 0.01, 1, 628);
    assert!(lost < 2.0 * 628.0 * 1e-12 / 72.0, "{lost:e}");
}

/// A cloud of rows without order, but the same every time.
fn cloud(count: usize, scale: f64) -> Vec<[f64; 3]> {
    // The additive sequence of the plastic number's generalisation: fills the cube evenly.
    let place = |row: usize, by: f64| ((row as f64 + 1.0) * by).fract() * 2.0 - 1.0;
    (0..count).map(|row| [0.819_172_513_4, 0.671_043_606_7, 0.549_700_477_9].map(|by| scale * place(row, by))).collect()
}

#[test]
fn pairs_and_springs_conserve_momentum_and_angular_momentum() {
    let count = 60;
    let velocities: Vec<[f64; 3]> = cloud(2 * count, 0.3).split_off(count);
    let masses: Vec<f64> = (0..count).map(|row| 1.0 + 0.1 * row as f64).collect();
    for precision in ["Cpu", "Parallel"] {
        let backend = if precision == "Cpu" { Backend::Cpu } else { Backend::Parallel };
        let bodies = Domain::new("bodies")
            .with(Position, cloud(count, 1.0))
            .with(Velocity, velocities.clone())
            .with(Mass, masses.clone())
            .subset(Charge, [3, 1, 40, 59], [0.5, -0.25, 0.5, 0.75]);
        let springs = Domain::new("springs")
            .link(Ends, "bodies", (0..count as u32 - 1).map(|row| [row, row + 1]))
            .with(Stiffness, vec![5.0; count - 1])
            .with(Damping, vec![0.5; count - 1])
            .with(RestLength, vec![0.5; count - 1]);
        let mut engine = Engine::<f64>::builder()
            .domain(bodies)
            .domain(springs)
            .law(Gravity { g: 1e-2, softening: 0.1 })
            .law(Coulomb { k: 1.0, softening: 0.1 })
            .law(Spring)
            .law(Damper)
            .law(Motion)
            .backend(backend)
            .step(1e-3)
            .build()
            .unwrap();
        let first = invariants(engine.state(), "bodies").unwrap();
        assert_eq!(first.weight, Weight::Mass);
        engine.advance(2.0).unwrap();
        let last = invariants(engine.state(), "bodies").unwrap();
        let moved = (last.momentum - first.momentum).length() / last.momentum_scale;
        let turned = (last.angular_momentum - first.angular_momentum).length() / last.angular_momentum_scale;
        assert!(moved < 1e-13 && turned < 1e-13, "{precision}: {moved:e} {turned:e}");
        let drifted = first.centre + first.momentum / first.mass * 2.0;
        assert!((last.centre - drifted).length() < 1e-13, "{precision}: the centre moves uniformly");
        // And the springs did something: the energy fell.
        assert!((last.momentum_scale / first.momentum_scale - 1.0).abs() > 0.01);
    }
}

#[test]
fn energy_by_parameter_is_conserved_too() {
    let engine = |integrator: Box<dyn Integrator>, relativity: bool| {
        let bodies = Domain::new("planets")
            .with(Position, [[0.0; 3], [1.0, 0.0, 0.0], [-3.0, 0.0, 0.5]])
            .with(Velocity, [[0.0, -0.01, 0.0], [0.0, 1.0, 0.1], [0.1, -0.5, 0.0]])
            .with(StandardGravitationalParameter, [1.0, 1e-2, 1e-3]);
        let builder = Engine::<f64>::builder().domain(bodies).law(GravityByParameter::default()).law(Kinematics);
        let builder = builder.constant(SpeedOfLight, [100.0]).boxed_integrator(integrator).step(1e-2);
        if relativity { builder.law(PostNewtonian).build().unwrap() } else { builder.build().unwrap() }
    };
    let (_, all) = energy_drift(&mut engine(Box::<Leapfrog>::default(), false), 1e-2, 100, 100);
    assert!(all < 1e-4, "{all:e}");
    let mut relativistic = engine(Box::new(RungeKutta4), true);
    assert_eq!(relativistic.energy().unwrap().1, ["post_newtonian"], "its energy is unknown, and that is said");
    let first = invariants(relativistic.state(), "planets").unwrap();
    assert_eq!(first.weight, Weight::StandardGravitationalParameter);
    relativistic.advance(100.0).unwrap();
    let last = invariants(relativistic.state(), "planets").unwrap();
    assert!((last.momentum - first.momentum).length() < 1e-13 * last.momentum_scale);
}

#[test]
fn invariants_are_sums_over_the_rows_that_have_what_they_need() {
    let bodies = Domain::new("bodies")
        .with(Position, [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0], [9.0, 9.0, 9.0]])
        .with(Velocity, [[0.0, 3.0, 0.0], [4.0, 0.0, 0.0], [9.0, 9.0, 9.0]])
        .subset(Mass, [1, 0], [1.0, 3.0]);
    let fast =
        Domain::new("fast").with(Position, [[1.0, 0.0, 0.0]]).with(Momentum, [[0.0, 5.0, 0.0]]).with(RestMass, [2.0]);
    let state = State::<f32>::new([bodies, fast, Domain::new("springs").with(Stiffness, [1.0])], []).unwrap();
    assert_eq!(momentum(&state, "bodies"), Some(DVec3::new(4.0, 9.0, 0.0)));
    assert_eq!(angular_momentum(&state, "bodies"), Some(DVec3::Z * (9.0 - 8.0)));
    assert_eq!(centre_of_mass(&state, "bodies"), Some(DVec3::new(0.75, 0.5, 0.0)));
    let of_fast = invariants(&state, "fast").unwrap();
    assert_eq!((of_fast.weight, of_fast.mass), (Weight::Momentum, 2.0));
    assert_eq!((of_fast.momentum, of_fast.angular_momentum), (DVec3::Y * 5.0, DVec3::Z * 5.0));
    assert_eq!(invariants(&state, "springs"), None);
    assert_eq!(invariants(&state, "nowhere"), None);
}
