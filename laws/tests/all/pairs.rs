//! The loops of pair laws: estimates and their limits, each pair once, sums that do not grow worse with the number of rows.

use std::sync::atomic::{AtomicI64, Ordering};
use vesper::prelude::*;
use vesper::real::Isa;
use vesper_laws::{Gravity, Motion};

/// Numbers without order in -1 to 1, the same every time.
fn places(rows: usize) -> Vec<[f64; 3]> {
    let mut word = 1_u64;
    let mut next = || {
        word = word.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        f64::from(((word >> 11) as f64 / (1_u64 << 52) as f64 - 1.0) as f32)
    };
    (0..rows).map(|_| [next(), next(), next()]).collect()
}

const STEP: f64 = 1.0 / (1_u64 << 40) as f64;

/// Bodies at rest, of masses 1 to 7, before their first step.
fn builder<P: Precision>(places: &[[f64; 3]], isa: Isa, estimates: bool) -> Builder<P> {
    let rows = places.len();
    let bodies = Domain::new("bodies").with(Position, places).with(Velocity, vec![[0.0; 3]; rows]);
    let bodies = bodies.with(Mass, (0..rows).map(|row| 1.0 + (row % 7) as f64).collect::<Vec<_>>());
    Engine::builder().domain(bodies).law(Motion).integrator(SemiImplicitEuler).step(STEP).isa(isa).estimates(estimates)
}

/// What the bodies get in one step from rest, by its length: their accelerations, as exact as they are.
fn accelerations<P: Precision>(places: &[[f64; 3]], softening: f64, isa: Isa, estimates: bool) -> Vec<f64> {
    let mut engine = builder::<P>(places, isa, estimates).law(Gravity { g: 1.0, softening }).build().unwrap();
    // Not finite where a body is beyond what numbers can hold: then the state is looked at all the same.
    let _ = engine.steps_of(1, STEP);
    engine.state().numbers("bodies", Velocity).unwrap().into_iter().map(|velocity| velocity / STEP).collect()
}

/// The root mean square of differences of vectors, each in parts of the vector's length.
pub(crate) fn off(found: &[f64], exact: &[f64]) -> f64 {
    let squares = |numbers: &[f64]| numbers.iter().map(|x| x * x).sum::<f64>();
    let each = found.chunks(3).zip(exact.chunks(3)).map(|(found, exact)| {
        let difference: Vec<f64> = found.iter().zip(exact).map(|(a, b)| a - b).collect();
        squares(&difference) / squares(exact)
    });
    (each.sum::<f64>() * 3.0 / found.len() as f64).sqrt()
}

fn estimates_are_close<P: Precision>(roundings: f64) {
    // Where estimates begin, where each pair is looked at once, and what is left over of lanes, strips and blocks.
    for rows in [63, 64, 65, 100, 511, 512, 513, 543, 600, 1024, 1600, 1663] {
        let places = places(rows);
        let exact = accelerations::<f64>(&places, 1.0 / 64.0, Isa::detect(), false);
        for isa in Isa::available() {
            let found = accelerations::<P>(&places, 1.0 / 64.0, isa, true);
            let off = off(&found, &exact);
            assert!(off < roundings * P::EPSILON, "{rows} rows, {isa:?}: {off:e}");
        }
    }
}

#[test]
fn estimates_are_within_some_roundings() {
    estimates_are_close::<f32>(6.0);
    estimates_are_close::<f64>(12.0);
}

#[test]
fn sums_of_many_pairs_in_f32_are_as_good_as_sums_of_few() {
    for offset in [0.0, 1000.0] {
        for rows in [1536, 6144] {
            let places: Vec<_> =
                places(rows).iter().map(|place| place.map(|x| f64::from((x + offset) as f32))).collect();
            let exact = accelerations::<f64>(&places, 1.0 / 64.0, Isa::detect(), false);
            for estimates in [false, true] {
                let off = off(&accelerations::<f32>(&places, 1.0 / 64.0, Isa::detect(), estimates), &exact);
                assert!(off < 3e-7, "{rows} rows, {offset} off, estimates: {estimates}: {off:e}");
            }
        }
    }
}

#[test]
fn where_estimates_have_no_number_the_body_has_one() {
    // The square of this distance is beyond f32, and what the far body does and gets is nothing; two others are so near that
    // the cube of their distance is below it.
    for rows in [100, 700] {
        let mut places = places(rows);
        places[3] = [3e19, 0.0, 0.0];
        for isa in Isa::available() {
            let found = accelerations::<f32>(&places, 1.0 / 64.0, isa, true);
            let exact = accelerations::<f32>(&places, 1.0 / 64.0, Isa::Scalar, false);
            assert!(found.iter().all(|number| number.is_finite()), "{rows} rows, {isa:?}");
            assert_eq!(found[9..12], [0.0; 3], "{rows} rows, {isa:?}");
            let near = |all: &[f64]| [&all[..9], &all[12..]].concat();
            assert!(off(&near(&found), &near(&exact)) < 1e-6, "{rows} rows, {isa:?}");
        }
    }
}

#[test]
fn rows_at_one_place_without_softening_are_no_numbers_with_and_without_estimates() {
    let mut places = places(700);
    places[640] = places[5];
    for estimates in [false, true] {
        let found = accelerations::<f64>(&places, 0.0, Isa::detect(), estimates);
        let lost: Vec<usize> = (0..700).filter(|row| found[3 * row].is_nan()).collect();
        assert_eq!(lost, [5, 640], "estimates: {estimates}");
    }
}

#[test]
fn what_one_row_gets_another_one_loses() {
    for (rows, isa) in
        [512, 1024, 1088].into_iter().flat_map(|rows| Isa::available().into_iter().map(move |isa| (rows, isa)))
    {
        let found = accelerations::<f64>(&places(rows), 1.0 / 64.0, isa, true);
        let momentum = (0..rows).map(|row| (1.0 + (row % 7) as f64) * found[3 * row]).sum::<f64>();
        let all = (0..rows).map(|row| (1.0 + (row % 7) as f64) * found[3 * row].abs()).sum::<f64>();
        assert!(momentum.abs() < 1e-14 * all, "{rows} rows, {isa:?}: {momentum:e} of {all:e}");
    }
}

/// Attraction that is not returned by lighter bodies.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force), antisymmetric, estimates)]
struct Unrequited<R = f64> {
    /// Strength.
    #[law(unit = "N/(kg m)", default = 1.0)]
    strength: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for Unrequited<R> {
    fn pair(&self, i: UnrequitedRow<R>, j: UnrequitedRow<R>) -> R::Vec3 {
        (j.position - i.position) * (self.strength * i.mass)
    }
}

#[test]
fn a_law_that_gives_more_than_it_takes_may_not_say_that_it_does_not() {
    let law = || Unrequited { strength: 1.0 };
    let fault = builder::<f64>(&places(512), Isa::detect(), true).law(law()).build().err().unwrap().to_string();
    assert_eq!(
        fault,
        "unrequited says antisymmetric, but what row j does to row i is not the opposite of what row i does to row j: give i and j \
         opposite shares, or leave the word out"
    );
    // Where nobody takes it at its word it runs as it is.
    builder::<f64>(&places(511), Isa::detect(), true).law(law()).build().unwrap().steps_of(1, STEP).unwrap();
}

/// Gravitation whose body gives up once, after so many calls.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force), antisymmetric, estimates)]
struct GivesUp<R = f64> {
    /// Constant of gravitation.
    #[law(unit = "m^3 kg^-1 s^-2", default = 1.0)]
    g: R,
}

static CALLS_LEFT: AtomicI64 = AtomicI64::new(i64::MAX);

#[kernel]
impl<R: Real> PairLaw<R> for GivesUp<R> {
    fn pair(&self, i: GivesUpRow<R>, j: GivesUpRow<R>) -> R::Vec3 {
        assert!(CALLS_LEFT.fetch_sub(1, Ordering::Relaxed) != 0, "the body gives up");
        let d = j.position - i.position;
        d * (self.g * i.mass * j.mass).over_root_cubed(d.length_squared() + R::lit(1.0))
    }
}

#[test]
fn a_body_that_panics_holds_up_no_other_thread_and_leaves_nothing() {
    let places = places(2000);
    let engine = || {
        let builder = builder::<f32>(&places, Isa::detect(), true).law(GivesUp { g: 1.0 }).threads(3);
        builder.backend(Backend::Parallel).observe("bodies", Force).build().unwrap()
    };
    let forces = |engine: &mut Engine<f32>| {
        engine.steps_of(1, STEP).unwrap();
        engine.state().numbers("bodies", Force).unwrap()
    };
    // From any meeting on: the first ones, and the last ones, after which bodies are given what they are due.
    for calls in [0, 1000, 50_000, 60_000] {
        let mut broken = engine();
        CALLS_LEFT.store(calls, Ordering::Relaxed);
        let step = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| broken.steps_of(1, STEP)));
        CALLS_LEFT.store(i64::MAX, Ordering::Relaxed);
        assert!(step.is_err(), "the panic is passed on");
        // Not `assert_eq`, which would print thousands of numbers.
        assert!(forces(&mut broken) == forces(&mut engine()), "what was summed before is gone, {calls} calls");
    }
}
