//! Far rows summed together: the error that is asked for, the same bits on any number of threads, and what is refused.

use crate::pairs::off;
use vesper::prelude::*;
use vesper::real::Isa;
use vesper_laws::{Coulomb, Gravity, Motion, UniformGravity};

const STEP: f64 = 1.0 / (1_u64 << 40) as f64;
const ROWS: usize = 16_000;

/// Numbers without order in 0 to 1, the same every time.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A ball whose density falls with the distance from its centre, at rest.
fn ball<P: Precision>(rows: usize) -> Domain<P> {
    let mut numbers = Numbers(3);
    let mut place = || {
        let radius = 0.01 + 4.0 * numbers.next().powi(2);
        let [cos, angle] = [2.0 * numbers.next() - 1.0, core::f64::consts::TAU * numbers.next()];
        let sin = (1.0 - cos * cos).sqrt();
        [radius * sin * angle.cos(), radius * sin * angle.sin(), radius * cos].map(|x| f64::from(x as f32))
    };
    let places: Vec<_> = (0..rows).map(|_| place()).collect();
    let charges: Vec<f64> = (0..rows).map(|row| if row % 3 == 0 { 1.0 } else { -0.5 }).collect();
    let domain = Domain::new("bodies").with(Position, &places).with(Velocity, vec![[0.0; 3]; rows]);
    domain.with(Mass, (0..rows).map(|row| 1.0 + (row % 7) as f64).collect::<Vec<_>>()).with(Charge, charges)
}

fn gravity() -> Gravity {
    Gravity { g: 1.0, softening: 1.0 / 64.0 }
}

fn engine<P: Precision>(law: impl Listing, threads: usize) -> Engine<P> {
    let builder = Engine::builder().domain(ball(ROWS)).law(law).law(Motion).integrator(SemiImplicitEuler).step(STEP);
    builder.backend(Backend::Parallel).threads(threads).build().unwrap()
}

/// Velocities after one step from rest.
fn kicks<P: Precision>(engine: &mut Engine<P>) -> Vec<f64> {
    engine.steps_of(1, STEP).unwrap();
    engine.state().numbers("bodies", Velocity).unwrap()
}

#[test]
fn the_error_is_the_one_that_is_asked_for() {
    let exact = kicks(&mut engine::<f64>(gravity(), 2));
    for error in [1e-2, 1e-3, 1e-4, 1e-5] {
        let mut far = engine::<f64>(gravity().far_field(error), 2);
        let found = off(&kicks(&mut far), &exact);
        println!("asked {error:e}, found {found:.1e}");
        assert!((error / 3.0..1.5 * error).contains(&found), "asked {error:e}, found {found:e}");
        let explained = far.explain();
        assert!(explained.contains(&format!("far ones together, error {error:e}, measured")), "{explained}");
        let single = off(&kicks(&mut engine::<f32>(gravity().far_field(error), 2)), &exact);
        assert!(single < 1.5 * error, "in f32 asked {error:e}, found {single:e}");
    }
}

#[test]
fn charges_of_both_signs_have_far_fields_too() {
    let law = || Coulomb { k: 1.0, softening: 1.0 / 64.0 };
    let exact = kicks(&mut engine::<f64>(law(), 2));
    let found = kicks(&mut engine::<f64>(law().far_field(1e-4), 2));
    // Their fields nearly cancel in some places, which errors are not small beside.
    let size = (exact.iter().map(|x| x * x).sum::<f64>() / ROWS as f64).sqrt();
    let apart = found.iter().zip(&exact).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
    assert!((apart / ROWS as f64).sqrt() < 1e-3 * size);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let reference = kicks(&mut engine::<f32>(gravity().far_field(1e-3), 1));
    for threads in [2, 3, 7] {
        assert_eq!(kicks(&mut engine::<f32>(gravity().far_field(1e-3), threads)), reference, "{threads} threads");
    }
}

#[test]
fn the_energy_is_that_of_all_pairs() {
    let (all, _) = engine::<f64>(gravity(), 1).energy().unwrap();
    let (far, _) = engine::<f64>(gravity().far_field(1e-4), 1).energy().unwrap();
    assert!((far / all - 1.0).abs() < 1e-4, "{far} of {all}");
}

#[test]
fn few_rows_are_summed_as_they_are() {
    let run = |law: &dyn Fn() -> vesper::engine::Configured<Gravity>| {
        let builder = Engine::<f64>::builder().domain(ball(600)).law(law()).law(Motion).step(STEP);
        let mut engine = builder.isa(Isa::Scalar).build().unwrap();
        engine.steps_of(1, STEP).unwrap();
        engine.state().hash()
    };
    assert_eq!(run(&|| gravity().far_field(1e-2)), run(&|| gravity().every(1)));
}

/// Attraction with another power of the distance than it says.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(position: Position, mass: Mass), adds(force: Force))]
struct Cubic<R = f64> {
    /// Strength.
    #[law(unit = "N m^3/kg^2", default = 1.0)]
    strength: R,
}

#[kernel]
impl<R: Real> PairLaw<R> for Cubic<R> {
    fn pair(&self, i: CubicRow<R>, j: CubicRow<R>) -> R::Vec3 {
        let d = j.position - i.position;
        let r2 = d.length_squared();
        d * (self.strength * i.mass * j.mass / (r2 * r2))
    }

    fn inverse_square(&self, row: CubicRow<R>) -> InverseSquare<R> {
        InverseSquare { source: row.mass, response: self.strength * row.mass, softening: R::lit(0.0) }
    }
}

#[test]
fn far_fields_that_are_none_are_refused() {
    let fault = |law: &dyn Fn(Builder<f64>) -> Builder<f64>| {
        let builder = Engine::<f64>::builder().domain(ball(ROWS)).constant(GravityAcceleration, [[0.0; 3]]).law(Motion);
        law(builder).step(STEP).build().err().unwrap().to_string()
    };
    assert_eq!(
        fault(&|builder| builder.law(Cubic { strength: 1.0 }.far_field(1e-3))),
        "cubic says inverse_square, but `pair` gives something else than response_i source_j d / (d^2 + softening^2)^(3/2), d = x_j - x_i: \
         make them agree, or leave the word out"
    );
    assert_eq!(
        fault(&|builder| builder.law(UniformGravity.far_field(1e-3))),
        "uniform_gravity has no far field: it does not say that its body is one of inverse squares: write `fn inverse_square` beside \
         `pair`, or leave it out"
    );
    for error in [0.0, -1.0, f64::NAN, 2.0] {
        let text = fault(&|builder| builder.law(gravity().far_field(error)));
        assert!(text.starts_with("gravity has no far field: its error is"), "{text}");
    }
}
