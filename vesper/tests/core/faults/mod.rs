//! Every mistake in data, settings and lists of laws has one message, which says who, what, where, and what to do.

mod between;
mod data;
mod dormant;
mod laws;

use crate::common::*;
use std::fmt::Display;
use vesper::prelude::*;
use vesper::registry::Options;

fn bodies() -> Domain<f64> {
    Domain::new("bodies")
        .with(Position, [[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
        .with(Velocity, [[0.0; 3]; 3])
        .with(Mass, [1.0, 2.0, 3.0])
}

fn engine() -> Builder<f64> {
    Engine::builder().step(0.1)
}

fn moving() -> Builder<f64> {
    engine().domain(bodies()).law(Motion)
}

/// What is said of what went wrong.
fn said<T>(result: Result<T, impl Display>) -> String {
    match result {
        Ok(_) => "nothing is wrong".to_owned(),
        Err(fault) => fault.to_string(),
    }
}

fn built(builder: Builder<f64>) -> String {
    said(builder.build())
}

/// Builds, changes the state, takes a step.
fn changed(builder: Builder<f64>, change: impl FnOnce(&mut State<f64>)) -> String {
    match builder.build() {
        Err(faults) => format!("at build: {faults}"),
        Ok(mut engine) => {
            change(engine.state_mut());
            said(engine.advance(0.1))
        }
    }
}

fn edited<T>(edit: impl FnOnce(&mut State<f64>) -> Result<T, Faults>) -> String {
    match moving().domain(springs(3)).build() {
        Err(faults) => format!("at build: {faults}"),
        Ok(mut engine) => {
            let before = engine.state().hash();
            let text = said(edit(engine.state_mut()));
            assert_eq!(engine.state().hash(), before, "a refused edit changes nothing: {text}");
            assert_eq!(said(engine.advance(0.1)), "nothing is wrong", "and the engine goes on: {text}");
            text
        }
    }
}

fn set(name: &str, reads: impl AsProperty, sets: impl AsProperty) -> DynLaw {
    DynLaw::new(name).reads(reads).sets(sets).body(|_, out| out.fill(1.0))
}

fn check(table: &[(String, &str)]) {
    let wrong: Vec<String> = table
        .iter()
        .filter(|(text, expected)| text != expected)
        .map(|(text, expected)| format!("    said: {text}\nexpected: {expected}"))
        .collect();
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n\n"));
}

#[test]
fn mistakes_in_settings() {
    let advanced = |frame| said(moving().build().and_then(|mut engine| engine.advance(frame)));
    let switched = |law| said(moving().build().map(|mut engine| engine.enable(law, false)).unwrap());
    check(&[
        (built(moving().step(0.0)), "the step is 0.0 s: give a finite time above 0"),
        (built(moving().step(f64::NAN)), "the step is NaN s: give a finite time above 0"),
        (advanced(-1.0), "the frame is -1.0 s: give a finite time, 0 or above"),
        (advanced(f64::INFINITY), "the frame is inf s: give a finite time, 0 or above"),
        (
            said(moving().build().and_then(|mut engine| engine.steps_of(1, -0.5))),
            "the step is -0.5 s: give a finite time above 0",
        ),
        (advanced(1e300), "a frame of 1e300 s in steps of 1e-1 s is more steps than can be counted: take longer steps"),
        (built(moving().threads(100_000)), "threads is 100000: give 1 to 1024, or leave it out for all cores"),
        (
            built(moving().field(ElectricField, Uniform { value: [0.0, f64::NAN, 0.0] })),
            "field electric_field is NaN everywhere: give finite numbers",
        ),
        (
            built(moving().law(Gravity { g: f64::NAN, softening: f64::INFINITY })),
            "gravity: parameter g is NaN: give a finite number\ngravity: parameter softening is inf: give a finite number",
        ),
        (built(moving().threads(0)), "threads is 0: give 1 to 1024, or leave it out for all cores"),
        (switched("motoin"), "no law motoin; did you mean motion?"),
        (switched("x"), "no law x: list it in the builder"),
    ]);
}

#[test]
fn several_mistakes_are_reported_together() {
    let bodies = bodies().with(DragCoefficient, [1.0]).subset(Charge, [7], [f64::NAN]).with(Mass, [1.0; 3]);
    let springs = Domain::new("springs").link(Ends, "bodys", [[0, 1]]).with_unit(Stiffness, "N", [1.0]);
    let text = built(engine().domain(bodies).domain(springs).step(-1.0).threads(0));
    check(&[(
        text,
        "the step is -1.0 s: give a finite time above 0\nthreads is 0: give 1 to 1024, or leave it out for all cores\nbodies.drag_coefficient has 1 value, but domain bodies has 3 rows, counted by position: give one value per row\nbodies.charge: row 7 is outside domain bodies, which has 3 rows, counted from 0\nbodies.mass is given twice: keep one\nsprings.ends links to domain bodys, which does not exist; did you mean bodies?\nsprings.stiffness is given in N, but it is measured in N/m: give it in a unit of that dimension",
    )]);
    let laws = moving().law(Motion).law(Weight.every(0)).law(Drag.on("stars")).observe("bodies", Colour).step(0.0);
    check(&[(
        built(laws.law(set("rigid", Mass, Velocity)).require("drug")),
        "the step is 0.0 s: give a finite time above 0\nno law drug; did you mean drag?\nweight is to be evaluated every 0 steps: give at least 1\nbodies has no property colour: give it as a column, or observe it where a law computes it\ndrag stands on domain stars, which does not exist: add the domain\nmotion is given twice on domain bodies: keep one, or give each a label of its own, `.label(\"...\")`\nmotion gives the rate of bodies.velocity, which rigid sets: a state belongs to the integrator, so keep one of the two laws\nrigid sets bodies.velocity, which the client gives: take the column away, or switch rigid off",
    )]);
    let faults = moving().law(Weight.every(0)).law(Drag.on("stars")).build().unwrap_err();
    assert_eq!(faults.len(), 2);
    assert!(matches!(faults.iter().next(), Some(Fault::Every { every: 0, .. })));
}

#[test]
fn a_listed_law_takes_its_options() {
    let compiled = vesper::backend::Compile::compile(&Weight);
    let options = Options { label: Some("heavy".to_owned()), ..Options::default() };
    let engine = moving().listed(compiled, options).build().unwrap();
    assert_eq!(engine.report().law("heavy").unwrap().to_string(), "heavy is active on 3 rows of bodies");
}
