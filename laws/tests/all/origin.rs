//! Positions from an origin that moves with the rows: what it saves far from where coordinates begin, and who refuses it.

use vesper::prelude::*;
use vesper_laws::{Gravity, HenonHeiles, Motion, Spring, UniformGravity, kepler_step};

const G: f64 = 6.6743e-11;
const MASSES: [f64; 2] = [1e15, 1.0];

/// A boulder about an asteroid, 100 m from it, which is 2.3e7 m from the origin and flies by with some velocity.
fn orbit<P: Precision>(velocity: f64) -> Builder<P> {
    let bodies = Domain::new("bodies")
        .with_unit(Position, "km", [[1e4, -2e4, 5e3], [1e4 + 0.1, -2e4, 5e3]])
        .with(Velocity, [[velocity, 0.0, 0.0], [velocity, 20.0, 16.0]])
        .with(Mass, MASSES);
    Engine::builder()
        .domain(bodies)
        .law(Gravity { g: G, ..Gravity::default() })
        .law(Motion)
        .integrator(Symplectic8::default())
        .step(0.05)
}

/// How far the boulder is from where it should be about the asteroid, in distances of the two at the start.
fn off<P: Precision>(builder: Builder<P>, frames: u32) -> f64 {
    let mut engine = builder.build().unwrap();
    (0..frames).for_each(|_| engine.advance(24.0).unwrap());
    let numbers = engine.state().numbers("bodies", Position).unwrap();
    let found = DVec3::from_slice(&numbers[3..]) - DVec3::from_slice(&numbers[..3]);
    let (start, velocity) = (DVec3::new(100.0, 0.0, 0.0), DVec3::new(0.0, 20.0, 16.0));
    let mu = G * (MASSES[0] + MASSES[1]);
    let exact = start + kepler_step(mu, start, velocity, 24.0 * f64::from(frames)).position;
    (found - exact).length() / 100.0
}

#[test]
fn an_orbit_far_out_keeps_the_digits_of_its_own_extent() {
    let run = |moves: bool, compensated: bool| {
        fn by<P: Precision>(moves: bool, compensated: bool) -> f64 {
            let builder = if moves { orbit::<P>(0.0).moving_origin(Position) } else { orbit(0.0) };
            off(if compensated { builder.compensated() } else { builder }, 100)
        }
        [by::<f32>(moves, compensated), by::<f64>(moves, compensated)]
    };
    println!("an orbit of 100 m, 2.3e7 m from the origin, after 100 periods: error by its radius in f32, f64");
    let all = [(false, false), (false, true), (true, false), (true, true)].map(|(moves, compensated)| {
        let errors = run(moves, compensated);
        println!("origin moves: {moves}, compensated: {compensated}: {:.1e}, {:.1e}", errors[0], errors[1]);
        errors
    });
    let [[lost, coarse], [found, also_fine], [kept, fine], [best, finest]] = all;
    // In f32 places are whole metres there; gravity is told what rounding took from them, where that is kept.
    assert!(lost > 0.1 && found < 5e-2, "{lost:e} {found:e}");
    assert!(kept < 5e-2 && best < 1e-5, "{kept:e} {best:e}");
    let fine = [fine, also_fine, finest];
    assert!(coarse > 1e-8 && fine.iter().all(|error| *error < 1e-10), "{coarse:e} {fine:?}");
}

#[test]
fn the_origin_goes_with_rows_that_fly_away() {
    let mut engine = orbit::<f32>(1e4).moving_origin(Position).build().unwrap();
    let begin = engine.state().origin(Position);
    (0..10).for_each(|_| engine.advance(24.0).unwrap());
    let (end, row) = (engine.state().origin(Position), engine.state().get("bodies", Position, 0).unwrap());
    assert_eq!(begin, [1e7 + 50.0, -2e7, 5e6]);
    assert!((end[0] - begin[0] - 240.0 * 1e4).abs() < 300.0 && row.length() < 1000.0, "{end:?} {row:?}");
    let numbers = engine.state().numbers("bodies", Position).unwrap();
    let whole = end[0] + f64::from(row.x);
    assert!((numbers[0] - whole).abs() < 1e-8, "{} {whole}", numbers[0]);
    // Half a metre in a step of 500 m is what f32 has here.
    let (moving, still) =
        (off(orbit::<f32>(1e4).moving_origin(Position).compensated(), 10), off(orbit::<f32>(1e4), 10));
    assert!(moving < 1e-2 && still > 0.1, "{moving:e} {still:e}");
}

#[test]
fn a_checkpoint_holds_the_origin() {
    let build = || orbit::<f32>(1e4).moving_origin(Position).build().unwrap();
    let (mut whole, mut first) = (build(), build());
    (0..4).for_each(|_| whole.advance(24.0).unwrap());
    (0..2).for_each(|_| first.advance(24.0).unwrap());
    let mut second = build();
    second.restore(&first.checkpoint().unwrap()).unwrap();
    (0..2).for_each(|_| second.advance(24.0).unwrap());
    let places = |engine: &Engine<f32>| engine.state().numbers("bodies", Position).unwrap();
    assert_eq!((second.state().hash(), places(&second)), (whole.state().hash(), places(&whole)));
    let fixed = orbit::<f32>(1e4).build().unwrap().checkpoint().unwrap();
    assert!(second.restore(&fixed).unwrap_err().to_string().contains("its origin does not move"));
    assert!(orbit::<f32>(1e4).build().unwrap().restore(&first.checkpoint().unwrap()).is_err());
}

/// A pair law that looks at places: the field of one body is weaker the farther out it is.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force))]
struct Fading;

#[kernel]
impl<R: Real> PairLaw<R> for Fading {
    fn pair(&self, i: FadingRow<R>, j: FadingRow<R>) -> R::Vec3 {
        (j.position - i.position) * (i.mass * j.mass / j.position.length_squared())
    }
}

#[test]
fn laws_that_look_at_places_do_not_let_it_move() {
    let bodies = || {
        let bodies = Domain::<f64>::new("bodies").with(Position, [[1.0, 2.0, 3.0], [2.0, 2.0, 3.0]]);
        bodies.with(Velocity, [[0.0; 3]; 2]).with(Mass, [1.0; 2]).with(Charge, [1.0; 2])
    };
    let builder = || Engine::builder().law(Motion).moving_origin(Position);
    let fault = |builder: Builder<f64>| builder.build().err().unwrap().to_string();
    let down = builder().domain(bodies()).constant(GravityAcceleration, [0.0, 0.0, -9.81]);
    assert_eq!(
        fault(down.law(UniformGravity)),
        "uniform_gravity does not let the origin move: it looks at position itself, not at differences of it"
    );
    let both = fault(builder().domain(bodies()).law(HenonHeiles::default()).law(Fading));
    assert!(both.contains("henon_heiles does not let the origin move"), "{both}");
    assert_eq!(
        fault(builder().domain(bodies()).law(Fading)),
        "fading does not let the origin move: rates change where position of all rows changes alike: look at differences of it only"
    );
    let swirl = |place: DVec3, _| DVec3::new(place.y, -place.x, 0.0);
    let field = builder().domain(bodies()).field(ElectricField, swirl).law(vesper_laws::ElectricForce);
    assert!(fault(field).contains("field electric_field differs from place to place"));
    let uniform = Uniform { value: [1.0, 0.0, 0.0] };
    assert!(builder().domain(bodies()).field(ElectricField, uniform).law(vesper_laws::ElectricForce).build().is_ok());
    let springs = Domain::new("springs").link(Ends, "bodies", [[0, 1]]).with(Stiffness, [1.0]).with(RestLength, [0.5]);
    assert!(builder().domain(bodies()).domain(springs).law(Spring).law(Gravity::default()).build().is_ok());
    assert!(fault(builder()).contains("position does not let the origin move: no domain has it"));
    let other = Engine::builder().law(Motion).moving_origin(Mass).domain(bodies());
    assert!(fault(other).contains("mass does not let the origin move: it is no coordinate"));
    // What is wrong with the values is still said.
    let broken = Domain::new("bodies").with_unit(Position, "kg", [[f64::NAN; 3]]);
    let broken = fault(builder().domain(broken));
    assert!(broken.contains("is measured in m") || broken.contains("finite"), "{broken}");
}

#[test]
fn what_changes_later_is_looked_at_too() {
    let refused = |engine: &mut Engine<f64>| {
        let fault = engine.advance(1.0).unwrap_err().to_string();
        assert!(fault.contains("does not let the origin move"), "{fault}");
    };
    // A law that comes to act.
    let down = orbit::<f64>(0.0).constant(GravityAcceleration, [0.0, 0.0, -9.81]).law(UniformGravity.off());
    let mut engine = down.moving_origin(Position).build().unwrap();
    engine.advance(1.0).unwrap();
    engine.enable("uniform_gravity", true).unwrap();
    refused(&mut engine);
    engine.enable("uniform_gravity", false).unwrap();
    engine.advance(1.0).unwrap();
    // New rows are given from where coordinates begin, as the first ones were.
    let mut engine = orbit::<f64>(0.0).moving_origin(Position).build().unwrap();
    let third = Domain::new("bodies").with_unit(Position, "km", [[1e4, -2e4, 5.1e3]]);
    engine.state_mut().add_rows(third.with(Velocity, [[0.0; 3]]).with(Mass, [1.0])).unwrap();
    assert_eq!(engine.state().get("bodies", Position, 2).unwrap(), DVec3::new(-50.0, 0.0, 1e5));
    let lent = Lent::<f64, 3>::new(vec![[0.0; 3]]);
    let others = Domain::new("others").lend(Position, &lent);
    assert!(engine.state_mut().add_columns(others).unwrap_err().to_string().contains("client's memory"));
    engine.advance(1.0).unwrap();
    // A field that comes to differ from place to place.
    let bodies = Domain::new("bodies").with(Position, [[1.0; 3]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    let builder = Engine::builder().domain(bodies.with(Charge, [1.0])).law(vesper_laws::ElectricForce).law(Motion);
    let uniform = Uniform { value: [1.0, 0.0, 0.0] };
    let mut engine = builder.field(ElectricField, uniform).step(0.1).moving_origin(Position).build().unwrap();
    engine.advance(1.0).unwrap();
    engine.state_mut().set_field(ElectricField, |place: DVec3, _| DVec3::new(place.y, 0.0, 0.0));
    refused(&mut engine);
    refused(&mut engine);
}

#[test]
fn integrators_that_keep_places_go_on_after_a_move() {
    // Frames of a second, in each of which the origin moves: shorter than the steps of some of them.
    let fast = |integrator: Box<dyn Integrator>, moves: bool| {
        let builder = orbit::<f64>(1e3).boxed_integrator(integrator);
        let mut engine = if moves { builder.moving_origin(Position) } else { builder }.build().unwrap();
        (0..48).for_each(|_| engine.advance(1.0).unwrap());
        let numbers = engine.state().numbers("bodies", Position).unwrap();
        DVec3::from_slice(&numbers[3..]) - DVec3::from_slice(&numbers[..3])
    };
    let exact = DVec3::new(100.0, 0.0, 0.0)
        + kepler_step(G * (MASSES[0] + MASSES[1]), DVec3::new(100.0, 0.0, 0.0), DVec3::new(0.0, 20.0, 16.0), 48.0)
            .position;
    let tight = Tolerance::relative(1e-11);
    let all: [fn(Tolerance) -> Box<dyn Integrator>; 5] = [
        |tight| Box::new(DormandPrince5::new(tight)),
        |tight| Box::new(DormandPrince8::new(tight)),
        |tight| Box::new(Nystrom12::new(tight)),
        |_| Box::new(GaussRadau15::default()),
        |_| Box::new(Symplectic8::default()),
    ];
    for make in all {
        let (moving, fixed) = ((fast(make(tight), true) - exact).length(), (fast(make(tight), false) - exact).length());
        println!("{}: {moving:.1e} m, {fixed:.1e} m with a fixed origin", make(tight).name());
        assert!(moving < 1e-7, "{}: {moving:e}", make(tight).name());
    }
}
