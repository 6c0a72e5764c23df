//! The order of each integrator, measured: halving the step divides the error by two to that power.

use vesper::prelude::*;
use vesper_laws::reference::{Cyclotron, Kepler, LinearDrag, Oscillator, Problem};

/// The power by which the error falls between `steps` steps and twice as many, up to `end`.
fn measured(problem: &impl Problem, integrator: impl Integrator + Clone + 'static, end: f64, steps: u32) -> f64 {
    let error = |steps: u32| {
        let step = end / f64::from(steps);
        let mut engine = problem.engine::<f64>(integrator.clone(), step).unwrap();
        engine.steps_of(steps.into(), step).unwrap();
        problem.error(&engine).unwrap()
    };
    (error(steps) / error(2 * steps)).log2()
}

fn check(problem: &impl Problem, end: f64) {
    let orders = [
        (1, measured(problem, SemiImplicitEuler, end, 4000)),
        (2, measured(problem, Leapfrog::default(), end, 1000)),
        (4, measured(problem, RungeKutta4, end, 400)),
    ];
    println!("{}: {orders:?}", problem.name());
    for (order, measured) in orders {
        assert!((measured - f64::from(order)).abs() < 0.1, "{}: {measured} is not {order}", problem.name());
    }
}

#[test]
fn of_an_oscillator() {
    // Not at a multiple of the half period, where the first-order error of semi-implicit Euler vanishes.
    check(&Oscillator { speed: 0.5, ..Oscillator::default() }, 4.0);
}

#[test]
fn of_a_kepler_orbit() {
    check(&Kepler { eccentricity: 0.3 }, 4.0);
}

#[test]
fn with_forces_that_depend_on_the_velocity() {
    check(&Cyclotron::default(), 2.0);
    check(&LinearDrag::default(), 3.0);
    check(&Oscillator { damping: 0.4, speed: 0.5, ..Oscillator::default() }, 4.0);
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
    check(&Fast, 1.0);
}
