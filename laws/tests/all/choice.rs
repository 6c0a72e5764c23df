//! The integrator that the structure of the laws suggests.

use vesper::prelude::*;
use vesper_laws::{Drag, Gravity, Motion};

fn bodies() -> Domain<f64> {
    Domain::new("bodies")
        .with(Position, [[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]])
        .with(Velocity, [[0.0, 0.5, 0.0], [0.0, -0.5, 0.0]])
        .with(Mass, [1.0; 2])
        .with(DragCoefficient, [0.1; 2])
}

/// The name of the integrator, and the energy that is lost in 3 s.
fn run(builder: Builder<f64>) -> (&'static str, f64) {
    let mut engine = builder.integrator(Auto::default()).step(0.1).build().unwrap();
    let before = engine.energy().unwrap().0;
    engine.advance(3.0).unwrap();
    (engine.integrator().name(), (engine.energy().unwrap().0 - before).abs())
}

const GRAVITY: Gravity = Gravity { g: 1.0, softening: 0.0 };

#[test]
fn all_digits_where_nothing_speaks_against_it() {
    let builder = Engine::<f64>::builder().domain(bodies()).law(GRAVITY).law(Motion);
    let (name, lost) = run(builder);
    assert!(name == "gauss_radau_15" && lost < 1e-14, "{name} {lost:e}");
}

#[test]
fn laws_of_different_pace_kick_at_their_own() {
    let builder = || Engine::<f64>::builder().domain(bodies()).law(GRAVITY.every(3)).law(Motion);
    assert_eq!(run(builder()).0, "respa");
    // A force that depends on the velocity is none that respa takes.
    assert_eq!(run(builder().law(Drag)).0, "leapfrog");
}

#[test]
fn corrections_after_a_step_need_steps_that_are_given() {
    /// Keeps rows above the ground.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(velocity: Velocity), amends(position: Position))]
    struct Ground;
    #[kernel]
    impl<P: Precision> ColumnLaw<P> for Ground {
        fn columns(&self, columns: GroundColumns<'_, P>) {
            let _ = columns;
        }
    }
    let builder = Engine::<f64>::builder().domain(bodies()).law(GRAVITY).law(Motion).law(Ground);
    assert_eq!(run(builder).0, "leapfrog");
}

#[test]
fn what_it_took_is_explained() {
    let engine = Engine::<f64>::builder().domain(bodies()).law(GRAVITY).law(Motion).integrator(Auto::default());
    let text = engine.build().unwrap().explain();
    assert!(text.contains("the laws suggest gauss_radau_15, of order 15"), "{text}");
}
