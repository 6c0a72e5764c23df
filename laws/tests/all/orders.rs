//! The order of each integrator, measured: halving the step divides the error by two to that power.

use vesper::prelude::*;
use vesper_laws::reference::{Cyclotron, Kepler, LinearDrag, Oscillator, Problem};

fn error(problem: &impl Problem, integrator: impl Integrator + 'static, end: f64, steps: u32) -> f64 {
    let step = end / f64::from(steps);
    let mut engine = problem.engine::<f64>(integrator, step).unwrap();
    engine.steps_of(steps.into(), step).unwrap();
    problem.error(&engine).unwrap()
}

/// The power by which the error falls between `steps` steps and twice as many, up to `end`.
fn measured(problem: &impl Problem, integrator: impl Integrator + Clone + 'static, end: f64, steps: u32) -> f64 {
    let error = |steps: u32| error(problem, integrator.clone(), end, steps);
    (error(steps) / error(2 * steps)).log2()
}

/// The same for high orders: the slope of a fit to errors within `window`, below those of other orders and above rounding,
/// which a compensated state keeps low. The largest error on the way counts, since at one time the leading term may
/// vanish; over a longer time, so that there are numbers of steps enough.
fn fitted(
    problem: &impl Problem,
    integrator: impl Integrator + Clone + 'static,
    end: f64,
    window: core::ops::Range<f64>,
) -> f64 {
    let mut points = Vec::new();
    let mut steps = 3;
    while points.len() < 12 && steps < 4000 {
        let step = 4.0 * end / f64::from(steps);
        let builder = problem.setup(Engine::<f64>::builder()).compensated();
        let mut engine = builder.integrator(integrator.clone()).step(step).build().unwrap();
        let grows = integrator.is_adaptive() && !integrator.compensates(f64::EPSILON);
        let error = (0..steps).fold(0.0, |worst, _| {
            if grows {
                // Whoever touches the state makes it begin anew, with the step that it was given.
                engine.state_mut();
            }
            engine.steps_of(1, step).unwrap();
            f64::max(worst, problem.error(&engine).unwrap())
        });
        if error < window.start && points.len() > 2 {
            break;
        }
        // A step that had to be cut says nothing of the one that was asked for.
        let whole = engine.tried_steps()[0] == 0;
        if whole && window.contains(&error) {
            points.push((f64::from(steps).ln(), error.ln()));
        }
        steps += (steps / 12).max(1);
    }
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let slope = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum::<f64>();
    -slope / points.iter().map(|point| (point.0 - x) * (point.0 - x)).sum::<f64>()
}

fn check(problem: &impl Problem, orders: &[(u32, f64)]) {
    println!("{}: {orders:.3?}", problem.name());
    for &(order, measured) in orders {
        assert!((measured - f64::from(order)).abs() < 0.15, "{}: {measured} is not {order}", problem.name());
    }
}

/// No error is too large: each step is the one that is asked for.
const LOOSE: Tolerance = Tolerance { relative: 1e9, absolute: 1e9 };

/// The orders of the integrators that take any laws, up to 5.
fn any_laws(problem: &impl Problem, end: f64) {
    let orders = [
        (1, measured(problem, ExplicitEuler, end, 4000)),
        (1, measured(problem, SemiImplicitEuler, end, 4000)),
        (2, measured(problem, Midpoint, end, 1000)),
        (2, measured(problem, Leapfrog::default(), end, 1000)),
        (4, measured(problem, RungeKutta4, end, 400)),
        (1, measured(problem, ImplicitEuler::default(), end, 4000)),
        (2, measured(problem, ImplicitMidpoint::default(), end, 1000)),
        (5, fitted(problem, DormandPrince5::new(LOOSE), end, 1e-12..1e-9)),
    ];
    check(problem, &orders);
}

/// Those of the integrators that kick and drift, and of the high ones.
fn separable(problem: &impl Problem, end: f64) {
    let orders = [
        (2, measured(problem, DriftKickDrift, end, 1000)),
        (4, fitted(problem, Symplectic4::default(), end, 1e-12..1e-9)),
        (6, fitted(problem, Symplectic6::default(), end, 3e-13..1e-10)),
        (8, fitted(problem, Symplectic8::default(), end, 3e-13..1e-10)),
        (8, fitted(problem, DormandPrince8::new(LOOSE), end, 3e-13..1e-10)),
    ];
    check(problem, &orders);
}

/// That of one of the highest, of which the errors fall to rounding while the step shrinks by half.
fn highest(
    problem: &impl Problem,
    integrator: impl Integrator + Clone + 'static,
    window: core::ops::Range<f64>,
    spread: f64,
) {
    let (name, claimed) = (integrator.name(), f64::from(integrator.order()));
    let order = fitted(problem, integrator, 24.0, window);
    println!("{}: {name} {order:.3}", problem.name());
    assert!((order - claimed).abs() < spread, "{}, {name}: {order} is not {claimed}", problem.name());
}

#[test]
fn of_an_oscillator() {
    // Not at a multiple of the half period, where the first-order error of semi-implicit Euler vanishes.
    let problem = Oscillator { speed: 0.5, ..Oscillator::default() };
    any_laws(&problem, 4.0);
    separable(&problem, 4.0);
    let (radau, nystrom) = (GaussRadau15::new(1e9), Nystrom12::new(LOOSE));
    highest(&problem, radau.clone(), 4e-14..1e-10, 0.15);
    highest(&problem, nystrom, 1e-10..1e-7, 0.15);
    // A force that depends on the velocity, and on the way of a Kepler orbit: the leading term is not alone above rounding.
    highest(&Oscillator { damping: 0.02, ..problem }, radau.clone(), 4e-14..1e-10, 0.3);
    let nearly_a_circle = Kepler { eccentricity: 0.05 };
    highest(&nearly_a_circle, radau, 5e-12..3e-9, 1.0);
    // There its leading term is smaller than the next one: the errors fall by the power 13.
    highest(&nearly_a_circle, nystrom, 1e-12..1e-9, 1.5);
}

#[test]
fn of_a_kepler_orbit() {
    any_laws(&Kepler { eccentricity: 0.3 }, 4.0);
    // Nearly a circle, so that the steps at one end do not hide those at the other.
    separable(&Kepler { eccentricity: 0.05 }, 4.0);
}

#[test]
fn with_forces_that_depend_on_the_velocity() {
    any_laws(&Cyclotron::default(), 2.0);
    any_laws(&LinearDrag::default(), 3.0);
    any_laws(&Oscillator { damping: 0.4, speed: 0.5, ..Oscillator::default() }, 4.0);
}

#[test]
fn with_momentum_as_the_state() {
    /// A relativistic charge in a magnetic field: p' = q v x B with v of p.
    struct Fast;
    impl Problem for Fast {
        fn name(&self) -> String {
            "relativistic_cyclotron".to_owned()
        }
        fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P> {
            use vesper_laws::{MagneticForce, RelativisticMotion, RelativisticVelocity};
            let bodies = Domain::new("bodies")
                .with(Position, [[0.0; 3]])
                .with(Momentum, [[8.0, 0.0, 0.0]])
                .with(RestMass, [2.0])
                .with(Charge, [2.0]);
            let field = Uniform { value: [0.0, 0.0, 5.0] };
            let builder = builder.domain(bodies).constant(SpeedOfLight, [3.0]).field(MagneticField, field);
            builder.law(RelativisticVelocity).law(MagneticForce).law(RelativisticMotion)
        }
        fn exact(&self, time: f64) -> Option<Vec<vesper_laws::reference::Phase>> {
            // v = 4/5 c = 2.4, gamma = 5/3, so the angular frequency is 3.
            let (sine, cosine) = (3.0 * time).sin_cos();
            let position = DVec3::new(0.8 * sine, 0.8 * (cosine - 1.0), 0.0);
            Some(vec![vesper_laws::reference::Phase { position, velocity: DVec3::new(cosine, -sine, 0.0) * 2.4 }])
        }
        fn times(&self) -> Vec<f64> {
            vec![1.0]
        }
        fn error<P: Precision>(&self, engine: &Engine<P>) -> Option<f64> {
            let place = engine.state().numbers("bodies", Position).ok()?;
            Some((DVec3::from_slice(&place) - self.exact(engine.time())?[0].position).length())
        }
    }
    any_laws(&Fast, 1.0);
    let turning =
        [(2, measured(&Fast, Boris::default(), 1.0, 1000)), (2, measured(&Fast, HigueraCary::default(), 1.0, 1000))];
    check(&Fast, &turning);
}

#[test]
fn of_a_charge_in_crossed_fields() {
    /// From rest, with q E / m = 0.3 along x and q B / m = 1 along z: a cycloid.
    struct Crossed;
    impl Problem for Crossed {
        fn name(&self) -> String {
            "crossed_fields".to_owned()
        }
        fn setup<P: Precision>(&self, builder: Builder<P>) -> Builder<P> {
            use vesper_laws::{ElectricForce, MagneticForce, Motion};
            let bodies = Domain::new("bodies")
                .with(Position, [[0.0; 3]])
                .with(Velocity, [[0.0; 3]])
                .with(Mass, [1.0])
                .with(Charge, [1.0]);
            let builder = builder.domain(bodies).field(ElectricField, Uniform { value: [0.3, 0.0, 0.0] });
            let builder = builder.field(MagneticField, Uniform { value: [0.0, 0.0, 1.0] });
            builder.law(ElectricForce).law(MagneticForce).law(Motion)
        }
        fn exact(&self, time: f64) -> Option<Vec<vesper_laws::reference::Phase>> {
            // Landau, Lifshitz, The Classical Theory of Fields, 4th ed., eq. 22.5 to 22.7.
            let (sine, cosine) = time.sin_cos();
            let position = DVec3::new(1.0 - cosine, sine - time, 0.0) * 0.3;
            Some(vec![vesper_laws::reference::Phase { position, velocity: DVec3::new(sine, cosine - 1.0, 0.0) * 0.3 }])
        }
        fn times(&self) -> Vec<f64> {
            vec![4.0]
        }
    }
    any_laws(&Crossed, 4.0);
    let turning = [
        (2, measured(&Crossed, Boris::default(), 4.0, 1000)),
        (2, measured(&Crossed, HigueraCary::default(), 4.0, 1000)),
        (8, fitted(&Crossed, Boris8::default(), 4.0, 3e-13..1e-9)),
    ];
    check(&Crossed, &turning);
}
