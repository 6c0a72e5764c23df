//! Numbers that are no numbers any more are found, and traced to the step and to the first law that made one.

use vesper::prelude::*;

/// A force that has no value from a certain time on: the root of what is left until then.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(mass: Mass), scene(time: Time), adds(force: Force))]
struct Ends<R = f64> {
    /// The time.
    #[law(unit = "s", default = 0.25)]
    at: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for Ends<R> {
    fn row(&self, row: EndsRow<R>) -> R::Vec3 {
        R::Vec3::new((self.at - row.time).sqrt() * row.mass, R::lit(0.0), R::lit(0.0))
    }
}

/// A constant force.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(mass: Mass), adds(force: Force))]
struct Weight;

#[kernel]
impl<R: Real> RowLaw<R> for Weight {
    fn row(&self, row: WeightRow<R>) -> R::Vec3 {
        R::Vec3::new(R::lit(0.0), R::lit(0.0), row.mass)
    }
}

/// Newton's second law.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity, force: Force, mass: Mass),
      rates(position: Position from (velocity), velocity: Velocity from (force, mass)))]
struct Newton;

#[kernel]
impl<R: Real> RowLaw<R> for Newton {
    fn row(&self, row: NewtonRow<R>) -> NewtonOutput<R> {
        NewtonOutput { position: row.velocity, velocity: row.force / row.mass }
    }
}

fn engine() -> Builder<f64> {
    let bodies =
        Domain::new("bodies").with(Position, [[0.0; 3]; 2]).with(Velocity, [[0.0; 3]; 2]).with(Mass, [1.0, 1.0]);
    Engine::builder().domain(bodies).law(Weight).law(Newton).integrator(SemiImplicitEuler).step(0.0625)
}

fn blow_up(engine: &mut Engine<f64>, frame: f64) -> (u64, String) {
    let faults = engine.advance(frame).expect_err("it blows up");
    match faults.iter().next() {
        Some(Fault::BlowUp { step, first, .. }) => (*step, first.clone()),
        other => panic!("another fault: {other:?}"),
    }
}

#[test]
fn a_number_that_is_none_is_found_once_a_frame() {
    let mut engine = engine().law(Ends::default()).build().expect("it fits");
    engine.advance(0.25).expect("all is well up to here");
    let (step, first) = blow_up(&mut engine, 1.0);
    assert_eq!(step, 20, "it is found at the end of the frame");
    assert!(first.contains("newton moves it, fed by ends, weight"), "{first}");
}

#[test]
fn traced_it_names_the_step_and_the_first_law_and_leaves_the_last_good_state() {
    let mut engine = engine().law(Ends::default()).build().expect("it fits");
    engine.trace_blow_ups(true);
    let (step, first) = blow_up(&mut engine, 1.25);
    // Steps 0 to 4 begin at times up to 0.25; the one that begins after it has no force.
    assert_eq!(step, 6);
    assert!(first.starts_with("ends is the first law whose result is not finite"), "{first}");
    assert_eq!(engine.steps(), 5);
    assert!(engine.state().get("bodies", Velocity, 1).expect("it is there").is_finite());
}

#[test]
fn a_step_that_is_too_long_is_called_so() {
    /// A force against the velocity, far too stiff for the step.
    #[derive(Law, Clone, Copy, Debug)]
    #[law(reads(velocity: Velocity), adds(force: Force))]
    struct Brake;

    #[kernel]
    impl<R: Real> RowLaw<R> for Brake {
        fn row(&self, row: BrakeRow<R>) -> R::Vec3 {
            -row.velocity * R::lit(1e200)
        }
    }

    let mut engine = engine().law(Brake).build().expect("it fits");
    engine.trace_blow_ups(true);
    let (_, first) = blow_up(&mut engine, 1.0);
    assert!(first.contains("too long") || first.contains("brake is the first law"), "{first}");
    assert!(engine.state().get("bodies", Velocity, 0).expect("it is there").is_finite());
}
