//! Pairs on a spring, seven cases: through the interface the same bits as in Rust.

use super::support::*;
use std::ffi::CString;
use vesper::prelude::*;
use vesper_laws::reference::{BODIES, Pair, Problem, pairs};

/// A pair through the interface; positions lent where `lent` says.
fn through_c(pair: &Pair, precision: Type) -> EngineId {
    let builder = builder(precision);
    ok(domain(builder, c"bodies", 2));
    ok(column(builder, c"bodies", c"position", &[-10.0, 5.0, 0.0, 10.0, 5.0, 0.0]));
    ok(column(builder, c"bodies", c"velocity", pair.velocities.as_flattened()));
    ok(column(builder, c"bodies", c"mass", &pair.masses));
    ok(law(builder, c"motion", c""));
    if let Some(stiffness) = pair.stiffness {
        ok(domain(builder, c"springs", 1));
        ok(link(builder, c"springs", c"ends", c"bodies", &[0, 1]));
        ok(column(builder, c"springs", c"stiffness", &[stiffness]));
        ok(column(builder, c"springs", c"damping", &[10.0]));
        ok(column(builder, c"springs", c"rest_length", &[10.0]));
        ok(law(builder, c"spring", c""));
        ok(law(builder, c"damper", c""));
    }
    if pair.gravity {
        ok(column(builder, c"scene", c"gravity", &[0.0, 0.0, -9.81]));
        ok(law(builder, c"uniform_gravity", c""));
    }
    ok(settings(builder, c"integrator = 'runge_kutta_4', step = 1e-3"));
    built(builder)
}

/// The scene of a pair, as the command runs it.
fn scene(case: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/scenes");
    let found = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let name = format!("c7{case}-");
    let mut found = found.filter(|path| path.file_name().unwrap().to_string_lossy().starts_with(&name));
    std::fs::read_to_string(found.next().unwrap()).unwrap()
}

fn in_rust<P: Precision>(pair: &Pair) -> Vec<f64> {
    let mut engine = pair.engine::<P>(RungeKutta4, 1e-3).unwrap();
    engine.advance(10.0).unwrap();
    let numbers = |property: PropertyInfo| engine.state().numbers(BODIES, property).unwrap();
    [numbers(Position::INFO), numbers(Velocity::INFO)].concat()
}

fn ten_seconds(engine: EngineId) -> Vec<f64> {
    ok(advance(engine, 10.0));
    let numbers = [get(engine, c"bodies", c"position", 6), get(engine, c"bodies", c"velocity", 6)].concat();
    ok(free(engine));
    numbers
}

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

#[test]
fn from_arrays_they_have_the_bits_of_rust() {
    for pair in pairs() {
        let doubles = ten_seconds(through_c(&pair, VESPER_F64));
        assert_eq!(bits(&doubles), bits(&in_rust::<f64>(&pair)), "{} in f64", pair.case);
        let singles = ten_seconds(through_c(&pair, VESPER_F32));
        assert_eq!(bits(&singles), bits(&in_rust::<f32>(&pair)), "{} in f32", pair.case);
        assert!(doubles.iter().all(|number| number.is_finite()) && doubles != singles, "{}", pair.case);
    }
}

#[test]
fn from_scenes_they_have_the_bits_of_rust() {
    for pair in pairs() {
        let (builder, text) = (builder(VESPER_F64), CString::new(scene(pair.case)).unwrap());
        // SAFETY: the text ends.
        ok(unsafe { vesper_builder_scene(builder, text.as_ptr(), ptr::null()) });
        assert_eq!(bits(&ten_seconds(built(builder))), bits(&in_rust::<f64>(&pair)), "{}", pair.case);
    }
}

#[test]
fn lent_memory_has_the_same_bits() {
    for pair in pairs() {
        let mut position = [-10.0, 5.0, 0.0, 10.0, 5.0, 0.0];
        let mut velocity = *pair.velocities.as_flattened().first_chunk::<6>().unwrap();
        let builder = builder(VESPER_F64);
        ok(domain(builder, c"bodies", 2));
        ok(lend(builder, c"bodies", c"position", &mut position));
        ok(lend(builder, c"bodies", c"velocity", &mut velocity));
        ok(column(builder, c"bodies", c"mass", &pair.masses));
        ok(column(builder, c"scene", c"gravity", &[0.0, 0.0, -9.81]));
        ok(law(builder, c"motion", c""));
        ok(law(builder, c"uniform_gravity", c""));
        ok(settings(builder, c"integrator = 'runge_kutta_4', step = 1e-3"));
        let engine = built(builder);
        ok(advance(engine, 10.0));
        ok(free(engine));
        let parabolas = Pair { stiffness: None, gravity: true, ..pair };
        assert_eq!(bits(&[position, velocity].concat()), bits(&in_rust::<f64>(&parabolas)), "{}", pair.case);
    }
}
