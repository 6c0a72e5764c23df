//! The same problems in f32 and in f64, in one program.

use vesper::prelude::*;
use vesper_laws::reference::{Cyclotron, Kepler, LinearDrag, Oscillator, Problem, QuadraticFall, Throw, pairs};

/// Errors in f32 and f64 of Runge-Kutta 4 at the problem's first time.
fn errors(problem: &impl Problem, steps: u32) -> (f64, f64) {
    fn error<P: Precision>(problem: &impl Problem, end: f64, steps: u32) -> f64 {
        let step = end / f64::from(steps);
        let mut engine = problem.engine::<P>(RungeKutta4, step).unwrap();
        engine.steps_of(steps.into(), step).unwrap();
        problem.error(&engine).unwrap()
    }
    let end = problem.times()[0];
    (error::<f32>(problem, end, steps), error::<f64>(problem, end, steps))
}

fn check(problem: &impl Problem) {
    let (single, double) = errors(problem, 200);
    println!("{}: f32 {single:.1e}, f64 {double:.1e}", problem.name());
    // 200 steps leave f32 a few of its roundings (6e-8 each), and f64 the error of the method.
    assert!(single < 1e-5, "{}: {single:e}", problem.name());
    assert!(double < 1e-8, "{}: {double:e}", problem.name());
    assert!(double == 0.0 || single > 10.0 * double, "{}: f32 is no f64: {single:e} {double:e}", problem.name());
}

#[test]
fn f32_follows_f64_to_its_own_precision() {
    check(&Oscillator::default());
    check(&Kepler { eccentricity: 0.3 });
    check(&Throw::vertical());
    check(&Throw::oblique());
    check(&LinearDrag::default());
    check(&QuadraticFall::default());
    check(&Cyclotron::default());
    for pair in pairs() {
        check(&pair);
    }
}

#[test]
fn small_motions_far_from_the_origin_are_lost_in_f32_only() {
    // The classic trouble of scales: at 1e8 m f32 is 8 m coarse.
    fn moved<P: Precision>() -> f64 {
        let bodies = Domain::<P>::new("bodies")
            .with(Position, [[1e8, 0.0, 0.0]])
            .with(Velocity, [[1.0, 0.0, 0.0]])
            .with(Mass, [1.0]);
        let mut engine = Engine::<P>::builder().domain(bodies).law(vesper_laws::Motion).step(1.0).build().unwrap();
        engine.advance(10.0).unwrap();
        engine.state().numbers("bodies", Position).unwrap()[0] - 1e8
    }
    assert_eq!(moved::<f64>(), 10.0);
    assert_eq!(moved::<f32>(), 0.0);
}

#[test]
fn kept_rounding_errors_give_f32_what_single_steps_cannot() {
    // A step of 1 m is less than half of what f32 tells apart at 1e8 m; a thousand of them are not.
    let moved = |compensated: bool| {
        let bodies = Domain::<f32>::new("bodies")
            .with(Position, [[1e8, 0.0, 0.0]])
            .with(Velocity, [[1.0, 0.0, 0.0]])
            .with(Mass, [1.0]);
        let builder = Engine::<f32>::builder().domain(bodies).law(vesper_laws::Motion).step(1.0);
        let mut engine = if compensated { builder.compensated() } else { builder }.build().unwrap();
        engine.steps_of(1000, 1.0).unwrap();
        engine.state().numbers("bodies", Position).unwrap()[0] - 1e8
    };
    assert_eq!(moved(false), 0.0);
    assert!((moved(true) - 1000.0).abs() <= 4.0, "{}", moved(true));
}

/// A spring from the origin, of 1 N/m.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position), adds(force: Force))]
struct Pull;

#[kernel]
impl<R: Real> RowLaw<R> for Pull {
    fn row(&self, body: PullRow<R>) -> R::Vec3 {
        -body.position
    }
}

#[test]
fn steps_and_coefficients_are_not_rounded_to_f32_where_errors_are_kept() {
    // Each of them is wrong by up to 6e-8 otherwise, always the same way: the phase runs off.
    let error = |compensated: bool| {
        let bodies =
            Domain::<f32>::new("bodies").with(Position, [[1.0, 0.0, 0.0]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
        let builder = Engine::<f32>::builder().domain(bodies).law(Pull).law(vesper_laws::Motion);
        let builder = builder.integrator(Symplectic8::default()).step(0.2);
        let mut engine = if compensated { builder.compensated() } else { builder }.build().unwrap();
        engine.steps_of(20_000, 0.2).unwrap();
        (engine.state().numbers("bodies", Position).unwrap()[0] - engine.time().cos()).abs()
    };
    let (plain, kept) = (error(false), error(true));
    println!("after 640 periods: {plain:.1e}, with sums in f64 {kept:.1e}");
    assert!(kept < 0.1 * plain && kept < 3e-6, "{kept:e} {plain:e}");
}
