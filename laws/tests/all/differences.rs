//! Laws that look at differences of coordinates alone: what they gain where rounding errors are kept, and who is refused.

use vesper::prelude::*;
use vesper::real::Isa;
use vesper_laws::{Gravity, Motion, kepler_step};

/// Gravity that does not say what it looks at.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force))]
struct Silent;

#[kernel]
impl<R: Real> PairLaw<R> for Silent {
    fn pair(&self, i: SilentRow<R>, j: SilentRow<R>) -> R::Vec3 {
        let d = j.position - i.position;
        let r2 = d.length_squared();
        d * (i.mass * j.mass / (r2 * r2.sqrt()))
    }
}

/// Gravity as on a sphere about the origin: it looks at places, and says that it does not.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force), translation_invariant)]
struct Boasting;

#[kernel]
impl<R: Real> PairLaw<R> for Boasting {
    fn pair(&self, i: BoastingRow<R>, j: BoastingRow<R>) -> R::Vec3 {
        (j.position - i.position) * (i.mass * j.mass / i.position.length_squared())
    }
}

/// Seven bodies, so that lanes are full, and not: two close ones that circle each other about a place so far off, and five that
/// weigh nothing.
fn bodies<P: Precision>(far: f64) -> Domain<P> {
    let light = (0..5).map(|k| [far + 3.0 + f64::from(k), 7.0, -2.0]);
    let places = [[far, 0.0, 0.0], [far + 1.0 / 128.0, 0.0, 0.0]].into_iter().chain(light);
    // At the far end of an ellipse.
    let speeds = [[0.0; 3], [0.0, 8.0, 0.0]].into_iter().chain([[0.0; 3]; 5]);
    Domain::new("bodies")
        .with(Position, places.collect::<Vec<_>>())
        .with(Velocity, speeds.collect::<Vec<_>>())
        .with(Mass, [1.0, 1e-9, 1e-12, 1e-12, 1e-12, 1e-12, 1e-12])
}

/// Where the second one is about the first after some revolutions, by its distance at the start.
fn off(engine: &Engine<f64>) -> f64 {
    let numbers = engine.state().numbers("bodies", Position).unwrap();
    let found = DVec3::from_slice(&numbers[3..6]) - DVec3::from_slice(&numbers[..3]);
    let start = DVec3::new(1.0 / 128.0, 0.0, 0.0);
    let exact = start + kepler_step(1.0 + 1e-9, start, DVec3::new(0.0, 8.0, 0.0), engine.time()).position;
    (found - exact).length() / start.length()
}

#[test]
fn a_close_orbit_far_out_keeps_its_digits() {
    let run = |builder: Builder<f64>, integrator: Box<dyn Integrator>| {
        let builder = builder.domain(bodies(1e6)).law(Motion).boxed_integrator(integrator).step(1e-5).compensated();
        let mut engine = builder.build().unwrap();
        engine.advance(0.01).unwrap();
        off(&engine)
    };
    let integrators: [fn() -> Box<dyn Integrator>; 4] = [
        || Box::new(GaussRadau15::default()),
        || Box::new(Nystrom12::new(Tolerance::relative(1e-10))),
        || Box::new(DormandPrince8::new(Tolerance::relative(1e-10))),
        || Box::new(Symplectic8::default()),
    ];
    for make in integrators {
        let builder = || Engine::<f64>::builder();
        let plain = run(builder().law(Silent), make());
        let differences = run(builder().law(Gravity { g: 1.0, softening: 0.0 }), make());
        println!("{}: {differences:.1e}, {plain:.1e} by places", make().name());
        // A place has 1e-10 there, and the distance is 1e-2.
        assert!(differences < 2e-8 && plain > 3.0 * differences, "{}: {differences:e} {plain:e}", make().name());
    }
}

#[test]
fn differences_have_the_same_bits_in_all_lanes() {
    fn run<P: Precision>(isa: Isa) -> Vec<u64> {
        let builder = Engine::<P>::builder().domain(bodies(100.0)).law(Gravity { g: 1.0, softening: 0.0 }).law(Motion);
        let mut engine = builder.integrator(Leapfrog::default()).compensated().isa(isa).step(1e-5).build().unwrap();
        engine.steps_of(50, 1e-5).unwrap();
        let numbers = engine.state().numbers("bodies", Velocity).unwrap();
        numbers.into_iter().map(f64::to_bits).collect()
    }
    for isa in Isa::available() {
        assert_eq!(run::<f64>(isa), run::<f64>(Isa::Scalar), "{isa:?}");
        assert_eq!(run::<f32>(isa), run::<f32>(Isa::Scalar), "{isa:?}");
    }
}

#[test]
fn a_law_that_looks_at_places_may_not_say_that_it_does_not() {
    let builder =
        || Engine::<f64>::builder().domain(bodies(1.0)).law(Motion).step(1e-5).integrator(Leapfrog::default());
    let fault = builder().law(Boasting).compensated().build().err().unwrap().to_string();
    assert_eq!(
        fault,
        "boasting says translation_invariant, but what it gives changes where both rows of a pair move alike: look at differences \
         of coordinates only, or leave the word out"
    );
    // A row at the origin is where it is said to be.
    let at_origin = Domain::new("bodies").with(Position, [[0.0; 3], [1.0, 0.0, 0.0]]).with(Velocity, [[0.0; 3]; 2]);
    let builder_there = Engine::<f64>::builder().domain(at_origin.with(Mass, [1.0; 2])).law(Motion).law(Boasting);
    assert!(builder_there.compensated().build().is_err());
    // Where nobody takes it at its word it runs as it is.
    builder().law(Boasting).build().unwrap().advance(1e-4).unwrap();
}

#[test]
fn a_checkpoint_goes_on_with_differences_and_without() {
    let build = |lent: Option<&Lent<f64, 3>>| {
        let all = bodies::<f64>(1e6);
        let domain = match lent {
            Some(places) => {
                let domain = Domain::new("bodies").lend(Position, places);
                let speeds = [[0.0; 3], [0.0, 8.0, 0.0]].into_iter().chain([[0.0; 3]; 5]).collect::<Vec<_>>();
                domain.with(Velocity, speeds).with(Mass, [1.0, 1e-9, 1e-12, 1e-12, 1e-12, 1e-12, 1e-12])
            }
            None => all,
        };
        let builder = Engine::<f64>::builder().domain(domain).law(Gravity { g: 1.0, softening: 0.0 }).law(Motion);
        builder.integrator(GaussRadau15::default()).build().unwrap()
    };
    let (mut whole, mut first, mut second) = (build(None), build(None), build(None));
    (0..2).for_each(|_| whole.advance(1e-3).unwrap());
    first.advance(1e-3).unwrap();
    second.restore(&first.checkpoint().unwrap()).unwrap();
    second.advance(1e-3).unwrap();
    assert_eq!(whole.state().hash(), second.state().hash());
    // Memory of the client's has no differences; what is saved of it fits all the same.
    let light = (0..5).map(|k| [1e6 + 3.0 + f64::from(k), 7.0, -2.0]);
    let places = [[1e6, 0.0, 0.0], [1e6 + 1.0 / 128.0, 0.0, 0.0]].into_iter().chain(light).collect::<Vec<_>>();
    let places = Lent::new(places);
    let mut lent = build(Some(&places));
    lent.advance(1e-3).unwrap();
    let mut owned = build(None);
    owned.restore(&lent.checkpoint().unwrap()).unwrap();
    owned.advance(1e-3).unwrap();
    let far = |engine: &Engine<f64>| engine.state().get("bodies", Position, 1).unwrap();
    assert!((far(&owned) - far(&whole)).length() < 1e-6, "{} {}", far(&owned), far(&whole));
}
