//! Laws composed at compile time give the bits of the same laws listed one by one.

use super::*;
use vesper::pipeline::{Chain, Chained};

/// How the laws are given.
#[derive(Clone, Copy, PartialEq)]
enum Way {
    Listed,
    Composed,
}

fn integrated<P: Precision>(builder: Builder<P>, integrator: usize) -> Builder<P> {
    match integrator {
        0 => builder.integrator(SemiImplicitEuler),
        1 => builder,
        _ => builder.integrator(RungeKutta4),
    }
}

/// Whether the two ways agree in every integrator; whether semi-implicit Euler ran the laws in one loop.
fn agree<P: Precision, T: Chained>(
    start: impl Fn() -> Builder<P>,
    chain: &Chain<T>,
    list: impl Fn(Builder<P>) -> Builder<P>,
) -> bool {
    let mut fused = false;
    for integrator in 0..3 {
        let run = |way: Way| {
            let builder = if way == Way::Composed { start().laws(chain.clone()) } else { list(start()) };
            let mut engine = integrated(builder.step(0.01), integrator).build().unwrap();
            engine.advance(0.07).unwrap();
            engine
        };
        let (listed, composed) = (run(Way::Listed), run(Way::Composed));
        assert_eq!(composed.state().hash(), listed.state().hash(), "{}, integrator {integrator}", P::NAME);
        fused |= composed.explain().contains("one loop composed at compile time");
    }
    fused
}

fn start<P: Precision>() -> Builder<P> {
    Engine::builder().domain(cloud(523, 12)).constant(GravityAcceleration, [[0.5, 0.0, -9.0]])
}

#[test]
fn composed_laws_give_the_bits_of_listed_ones() {
    let chain = pipeline![Motion, Weight, Drag];
    assert!(agree(start::<f64>, &chain, |b| b.law(Motion).law(Weight).law(Drag)));
    assert!(agree(start::<f32>, &chain, |b| b.law(Motion).law(Weight).law(Drag)));
    let windy = || start::<f64>().domain(Domain::new("elsewhere").rows(1));
    assert!(agree(windy, &chain, |b| b.law(Motion).law(Weight).law(Drag)));
}

#[test]
fn fields_and_set_properties_are_composed_too() {
    let chain = pipeline![Electric, Motion, Inertia];
    let start = || {
        let rows = 600;
        let mut random = Random(4);
        let mut vectors = || (0..rows).map(|_| random.vector()).collect::<Vec<_>>();
        let domain = Domain::new("bodies").with(Position, vectors()).with(Velocity, vectors());
        let builder =
            Engine::<f64>::builder().domain(domain.with(RestMass, vec![2.0; rows]).with(Charge, vec![0.3; rows]));
        builder.field(ElectricField, |at: DVec3, time: f64| DVec3::new(at.z, at.x, at.y) * (1.0 + time))
    };
    assert!(agree(start, &chain, |b| b.law(Electric).law(Motion).law(Inertia)));
}

#[test]
fn a_law_on_a_subset_between_them_falls_back() {
    let charged = || {
        let few = Domain::new("bodies");
        let state = State::new([cloud::<f64>(40, 3)], []).unwrap();
        let vectors =
            |property: PropertyInfo| Values::new(property.kind.width(), state.numbers("bodies", property).unwrap());
        let few = [Position.info(), Velocity.info(), Mass.info(), DragCoefficient.info()]
            .into_iter()
            .fold(few, |few, property| few.with(property, vectors(property)));
        Engine::<f64>::builder()
            .domain(few.subset(Charge, [3, 17, 21], [1.0, -2.0, 0.5]))
            .field(ElectricField, Uniform { value: [1.0, 2.0, 3.0] })
    };
    let chain = pipeline![Drag, Motion, Weight];
    assert!(!agree(|| charged().law(Electric), &chain, |b| b.law(Drag).law(Motion).law(Weight)));
    let chain = pipeline![Drag, Electric, Motion];
    assert!(!agree(charged, &chain, |b| b.law(Drag).law(Electric).law(Motion)));
}

#[test]
fn laws_of_other_shapes_before_them_do_not_disturb() {
    let chain = pipeline![Drag, Motion];
    let start = || start::<f64>().law(Gravity::default());
    agree(start, &chain, |b| b.law(Drag).law(Motion));
    let chain = pipeline![Gravity::<f64>::default(), Drag, Motion];
    agree(super::composed::start::<f64>, &chain, |b| b.law(Gravity::default()).law(Drag).law(Motion));
}

#[test]
fn a_composed_law_can_be_switched_off_and_looked_at() {
    let run = |way: Way| {
        let builder = start::<f64>().integrator(SemiImplicitEuler).step(0.01);
        let builder = match way {
            Way::Composed => builder.laws(pipeline![Weight, Drag, Motion]),
            Way::Listed => builder.law(Weight).law(Drag).law(Motion),
        };
        let mut engine = builder.observe("bodies", Force).build().unwrap();
        engine.advance(0.02).unwrap();
        engine.enable("drag", false).unwrap();
        engine.advance(0.02).unwrap();
        engine.enable("drag", true).unwrap();
        engine.advance(0.02).unwrap();
        (engine.state().hash(), engine.state().numbers("bodies", Force).unwrap())
    };
    assert_eq!(run(Way::Composed), run(Way::Listed));
}

/// Sets what `Motion` of the bodies reads as force, but on other rows.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "grains", reads(mass: Mass), sets(force: Force))]
struct Load;

#[kernel]
impl<R: Real> RowLaw<R> for Load {
    fn row(&self, row: LoadRow<R>) -> R::Vec3 {
        R::Vec3::new(row.mass, R::lit(0.0), R::lit(0.0))
    }
}

/// Stands on bodies by declaration.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "bodies", reads(mass: Mass), sets(force: Force))]
struct Lift;

#[kernel]
impl<R: Real> RowLaw<R> for Lift {
    fn row(&self, row: LiftRow<R>) -> R::Vec3 {
        R::Vec3::new(R::lit(0.0), R::lit(0.0), row.mass)
    }
}

#[test]
fn laws_of_two_domains_are_composed_and_each_stays_on_its_own() {
    // Two setters of one property: no contradiction, since they stand on different rows.
    let chain = pipeline![Load, Lift, Motion];
    let start = || {
        let grains = Domain::new("grains").with(Mass, vec![3.0; 700]);
        Engine::<f64>::builder().domain(cloud(523, 12)).domain(grains).observe("grains", Force).observe("bodies", Force)
    };
    assert!(!agree(start, &chain, |b| b.law(Load).law(Lift).law(Motion)));
    let mut engine = start().laws(chain).step(0.01).build().unwrap();
    engine.advance(0.02).unwrap();
    let (grain, mass) =
        (engine.state().get("grains", Force, 699).unwrap(), engine.state().get("bodies", Mass, 5).unwrap());
    assert_eq!(grain, DVec3::new(3.0, 0.0, 0.0));
    assert_eq!(engine.state().get("bodies", Force, 5).unwrap(), DVec3::new(0.0, 0.0, mass));
}

#[test]
fn a_sum_that_a_law_sets_begins_there() {
    let chain = pipeline![Weight, Motion, Lift];
    let start = || start::<f64>().observe("bodies", Force);
    assert!(agree(start, &chain, |b| b.law(Weight).law(Motion).law(Lift)));
    let mut engine = start().law(Weight).law(Motion).law(Lift).step(0.01).build().unwrap();
    let before = engine.state().get("bodies", Velocity, 5).unwrap();
    engine.advance(0.01).unwrap();
    let mass = engine.state().get("bodies", Mass, 5).unwrap();
    let pull = mass * DVec3::new(0.5, 0.0, -8.0);
    assert!((engine.state().get("bodies", Force, 5).unwrap() - pull).length() < 1e-14);
    let push = (engine.state().get("bodies", Velocity, 5).unwrap() - before) / 0.01 * mass;
    assert!((push - pull).length() < 1e-11, "{push} instead of {pull}");
}

/// Reads a coefficient that its rates do not need.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity, force: Force, mass: Mass, coefficient: DragCoefficient),
      rates(position: Position from (velocity), velocity: Velocity from (force, mass)))]
struct Ample;

#[kernel]
impl<R: Real> RowLaw<R> for Ample {
    fn row(&self, row: AmpleRow<R>) -> AmpleOutput<R> {
        AmpleOutput { position: row.velocity, velocity: row.force / row.mass }
    }
}

#[test]
fn a_value_that_no_rate_needs_is_not_needed_in_the_loop() {
    let chain = pipeline![Ample, Weight];
    agree(start::<f64>, &chain, |b| b.law(Ample).law(Weight));
}

/// Motion where a force may or may not be there.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(velocity: Velocity), reads(force: Force, optional), rates(position: Position, velocity: Velocity))]
struct Free;

#[kernel]
impl<R: Real> RowLaw<R> for Free {
    fn row(&self, row: FreeRow<R>) -> FreeOutput<R> {
        let push = R::Vec3::new(R::lit(9.0), R::lit(0.0), R::lit(0.0));
        FreeOutput { position: row.velocity, velocity: row.force.unwrap_or(push) }
    }
}

#[test]
fn an_optional_sum_is_there_in_the_loop_too() {
    let chain = pipeline![Weight, Free];
    assert!(agree(start::<f64>, &chain, |b| b.law(Weight).law(Free)));
}

/// A second coordinate, which turns the faster the farther a row is, and its momentum. By its name it stands last.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), rates(angle: Angle from (position), spin: Spin from (mass)))]
struct Yaw;

#[kernel]
impl<R: Real> RowLaw<R> for Yaw {
    fn row(&self, row: YawRow<R>) -> YawOutput<R> {
        YawOutput { angle: row.position.x(), spin: row.mass }
    }
}

/// Evaluates once before it takes steps of kick and drift, so that old rates lie around.
#[derive(Debug)]
struct Restless;

impl Integrator for Restless {
    fn name(&self) -> &'static str {
        "restless"
    }
    fn order(&self) -> u32 {
        1
    }
    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        system.evaluate(Part::All);
        system.advance(&[(Part::Momenta, step), (Part::Coordinates, step)]);
        system.advance(&[(Part::Momenta, step)]);
        system.advance(&[(Part::Coordinates, step)]);
        system.set_time(system.time() + step);
        Ok(())
    }
}

#[test]
fn a_state_that_another_law_of_its_stage_looks_at_advances_after_the_stage() {
    let turning = || {
        let domain = cloud::<f64>(30, 2).with(Angle, vec![0.0; 30]).with(Spin, vec![0.0; 30]);
        Engine::builder().domain(domain)
    };
    let chain = pipeline![Motion, Yaw, Weight];
    assert!(!agree(turning, &chain, |b| b.law(Motion).law(Yaw).law(Weight)));
    let run = |way: Way| {
        let builder = turning().integrator(Restless).step(0.1);
        let builder = match way {
            Way::Composed => builder.laws(chain.clone()),
            Way::Listed => builder.law(Motion).law(Yaw).law(Weight),
        };
        let mut engine = builder.build().unwrap();
        engine.advance(0.5).unwrap();
        engine.state().hash()
    };
    assert_eq!(run(Way::Composed), run(Way::Listed));
}
