//! Every mistake in data, settings and lists of laws has one message, which says who, what, where, and what to do.

mod common;

use common::*;
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
fn mistakes_in_what_a_client_gives() {
    let one = || Domain::new("bodies").with(Mass, [1.0, 2.0]);
    let lent = Lent::new(vec![[0.0; 3]; 2]);
    let in_run_time = |kind| PropertyInfo::at_run_time("odd", kind, "m").unwrap();
    check(&[
        (built(engine().domain(one().with(Position, [1.0, 2.0]))), "KIND"),
        (built(engine().domain(one().with(Ends, [1.0, 2.0]))), "KIND LINK"),
        (built(engine().domain(one().link(Mass, "bodies", [[0, 1], [1, 0]]))), "TWICE"),
        (built(engine().domain(Domain::new("b").link(Mass, "b", [[0, 1], [1, 0]]))), "KIND LINK 2"),
        (built(engine().domain(Domain::new("b").link(Ends, "b", [[0, 1, 0]]))), "ARITY"),
        (built(engine().domain(Domain::new("b").link(in_run_time(Kind::Link(0)), "b", [[0; 0]; 2]))), "ARITY 0"),
        (built(engine().domain(one().with(Position, Values::new(3, vec![1.0; 7])))), "PART"),
        (built(engine().domain(one().with(DragCoefficient, [1.0]))), "LENGTH"),
        (built(engine().domain(one().rows(3))), "STATED"),
        (built(engine().domain(one().subset(Charge, [0], [1.0, 2.0]))), "SUBSET LENGTH"),
        (built(engine().domain(one().subset(Charge, [1, 1], [1.0, 2.0]))), "SUBSET TWICE"),
        (built(engine().domain(one().subset(Charge, [2], [1.0]))), "SUBSET RANGE"),
        (built(engine().domain(Domain::new("bodies").with_unit(Mass, "m", [1.0]))), "DIMENSION"),
        (built(engine().domain(Domain::new("bodies").with_unit(Mass, "kgg", [1.0]))), "UNIT"),
        (said(PropertyInfo::at_run_time("odd", Kind::Scalar, "furlong")), "UNIT AT RUN TIME"),
        (built(engine().domain(Domain::new("bodies").with(Mass, [1.0, f64::NAN]))), "NAN"),
        (said(Engine::<f32>::builder().domain(Domain::new("bodies").with(Mass, [1.0, 1e300])).build()), "F32"),
        (built(engine().domain(one()).domain(one())), "DOMAIN TWICE"),
        (built(engine().field(ElectricField, Uniform { value: [0.0; 3] }).field(ElectricField, Boxes::default())), "FIELD"),
        (built(engine().field(Charge, Uniform { value: [0.0; 3] })), "FIELD KIND"),
        (built(engine().domain(one()).domain(Domain::new("springs").link(Ends, "bodys", [[0, 1]]))), "TARGET"),
        (built(engine().domain(one()).domain(Domain::new("springs").link(Ends, "stars", [[0, 1]]))), "TARGET FAR"),
        (built(engine().domain(one()).domain(Domain::new("springs").link(Ends, "bodies", [[0, 1], [1, 2]]))), "LINK RANGE"),
        (built(engine().domain(Domain::new("a").lend(Position, &lent)).domain(Domain::new("b").lend(Velocity, &lent))), "LENT TWICE"),
        (built(engine().domain(Domain::new("scene").lend(GravityAcceleration, &Lent::new(vec![[0.0; 3]])))), "LENT CONSTANT"),
        (built(engine().constant(SpeedOfLight, Vec::<f64>::new())), "NO CONSTANT"),
        (built(engine().domain(Domain::new("a").rows(1 << 40))), "ROWS"),
    ]);
}

#[test]
fn mistakes_in_a_list_of_laws() {
    let heat = || Domain::new("rods").with(Temperature, [1.0]).with(Cooling, [1.0]);
    let plain = PropertyInfo::new("force", Kind::Vector, "N");
    let pounds = PropertyInfo::new("mass", Kind::Scalar, "g");
    let wide = (0..22).fold(DynLaw::new("wide"), |law, k| {
        law.reads(PropertyInfo::at_run_time(&format!("p{k}"), Kind::Vector, "m").unwrap())
    });
    check(&[
        (built(moving().law(set("a", Mass, Trace)).law(set("b", Mass, Trace))), "TWO SETTERS"),
        (built(moving().law(DynLaw::new("push").reads(Mass).rates(Velocity).body(|_, _| {}))), "TWO RATERS"),
        (built(moving().law(set("rigid", Mass, Velocity))), "RATE OF SET"),
        (built(engine().domain(bodies().with(Force, [[0.0; 3]; 3])).law(DynLaw::new("rush").reads(Mass).rates(Force).body(|_, _| {})).law(Weight)), "RATE OF SUM"),
        (built(engine().domain(bodies()).law(set("heavy", Velocity, Mass))), "SET GIVEN"),
        (built(moving().law(DynLaw::new("bump").reads(Mass).adds(Velocity).body(|_, _| {}))), "ADD PLAIN"),
        (built(moving().law(set("a", Trace, Colour)).law(set("b", Colour, Trace))), "CYCLE"),
        (built(moving().law(DynLaw::new("grow").reads(Force).adds(Force).body(|_, _| {}))), "CYCLE OF ONE"),
        (built(moving().law(Weight).law(Weight)), "LAW TWICE"),
        (built(moving().domain(Domain::new("stars").with(Mass, [1.0])).law(Weight)), "WHICH DOMAIN"),
        (built(moving().law(Weight.on("bodeis"))), "LAW DOMAIN"),
        (built(moving().law(Weight.every(0))), "EVERY 0"),
        (built(engine().domain(bodies()).law(Motion.every(2))), "EVERY RATES"),
        (built(engine().domain(heat()).law(Cool)), "INTEGRATOR"),
        (built(moving().law(DynLaw::new("lift").reads(Mass).adds(plain).body(|_, _| {}))), "ROLE"),
        (built(moving().law(DynLaw::new("lift").reads(pounds).adds(Force).body(|_, _| {}))), "UNITS"),
        (built(engine().domain(Domain::new("bodies").with(pounds, [1.0])).law(Weight)), "UNITS OF DATA"),
        (built(moving().law(wide.adds(Force).body(|_, _| {}))), "WIDE"),
        (built(moving().domain(springs(3)).law(DynLaw::new("count").reads(Ends).sets(Stiffness).body(|_, _| {}))), "LINK READ"),
        (built(moving().law(DynLaw::new("glow").field(Charge).adds(Force).body(|_, _| {}))), "FIELD READ"),
        (built(moving().observe("bodies", WindVelocity)), "OBSERVE"),
        (built(moving().observe("bodie", Force)), "OBSERVE DOMAIN"),
        (built(moving().require("moton")), "REQUIRE"),
        (built(engine().domain(bodies().subset(Charge, [1], [1.0])).law(Charged)), "COLUMN SUBSET"),
        (built(moving().domain(springs(3)).law(Spring).law(Hinge)), "PAIR SETS"),
        (built(engine().domain(bodies().subset(Charge, [0, 2], [1.0; 2])).law(set("polish", Charge, Trace)).observe("bodies", Trace)), "SET SUBSET"),
        (built(engine().domain(bodies().subset(WindVelocity, [0], [[1.0; 3]]).with(DragCoefficient, [1.0; 3])).law(Drag).law(Motion)), "OPTIONAL SUBSET"),
        (built(engine().domain(bodies().subset(ExternalForce, [0], [[1.0; 3]])).law(Motion)), "START SUBSET"),
        (built(engine().domain(Domain::new("bodies").rows(3).subset(Position, [0], [[1.0; 3]])).domain(springs(3)).law(Spring).observe("bodies", Force)), "END SUBSET"),
    ]);
}

/// A law over whole columns that reads a subset.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(charge: Charge), adds(force: Force))]
struct Charged;

#[kernel]
impl<P: Precision> ColumnLaw<P> for Charged {
    fn columns(&self, _: ChargedColumns<'_, P>) {}
}

/// A pair law that sets.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "bodies", reads(mass: Mass), sets(trace: Trace))]
struct Hinge;

#[kernel]
impl<R: Real> PairLaw<R> for Hinge {
    fn pair(&self, _: HingeRow<R>, _: HingeRow<R>) -> R::Vec3 {
        R::Vec3::zero()
    }
}

#[test]
fn mistakes_in_settings() {
    let advanced = |frame| said(moving().build().and_then(|mut engine| engine.advance(frame)));
    let switched = |law| said(moving().build().map(|mut engine| engine.enable(law, false)).unwrap());
    check(&[
        (built(moving().step(0.0)), "STEP 0"),
        (built(moving().step(f64::NAN)), "STEP NAN"),
        (advanced(-1.0), "FRAME"),
        (advanced(f64::INFINITY), "FRAME INF"),
        (said(moving().build().and_then(|mut engine| engine.steps_of(1, -0.5))), "STEPS OF"),
        (built(moving().threads(0)), "THREADS"),
        (switched("motoin"), "ENABLE"),
        (switched("x"), "ENABLE FAR"),
    ]);
}

#[test]
fn mistakes_between_steps() {
    let two = || Domain::new("bodies").with(Position, [[0.0; 3]; 2]).with(Velocity, [[0.0; 3]; 2]).with(Mass, [1.0; 2]);
    check(&[
        (edited(|state| Ok(state.get("bodeis", Mass, 0)?)), "GET DOMAIN"),
        (edited(|state| Ok(state.get("bodies", RestMass, 0)?)), "GET PROPERTY"),
        (edited(|state| Ok(state.get("bodies", Mass, 3)?)), "GET ROW"),
        (edited(|state| Ok(state.set("bodies", Mass, 9, 1.0)?)), "SET ROW"),
        (edited(|state| Ok(state.values("bodies", WrongMass)?)), "VALUES KIND"),
        (edited(|state| state.add_rows(Domain::new("bodies").with(Mass, [1.0]))), "ADD LACKS"),
        (edited(|state| state.add_rows(two().with(Charge, [1.0; 2]))), "ADD UNKNOWN"),
        (edited(|state| state.add_rows(two().with(Mass, [1.0]))), "ADD TWICE"),
        (edited(|state| state.add_rows(Domain::new("scene").with(Mass, [1.0]))), "ADD SCENE"),
        (edited(|state| state.add_rows(Domain::new("springs").link(Ends, "stars", [[0, 1]]).with(Stiffness, [1.0]).with(RestLength, [1.0]))), "ADD TARGET"),
        (edited(|state| state.add_rows(Domain::new("springs").link(Ends, "bodies", [[0, 3]]).with(Stiffness, [1.0]).with(RestLength, [1.0]))), "ADD RANGE"),
        (edited(|state| state.add_rows(Domain::new("springs").link(Ends, "bodies", [[0, 1]]).subset(Stiffness, [0], [1.0]).with(RestLength, [1.0]))), "ADD SUBSET"),
        (edited(|state| Ok(state.remove_rows("bodies", &[0, 3])?)), "REMOVE"),
        (edited(|state| Ok(state.remove_rows("scene", &[0])?)), "REMOVE SCENE"),
        (edited(|state| Ok(state.remove_column("scene", Time)?)), "REMOVE TIME"),
        (edited(|state| Ok(state.remove_column("bodies", Charge)?)), "REMOVE COLUMN"),
        (edited(|state| state.add_columns(Domain::new("bodies").with(Charge, [1.0; 3]).with(Mass, [1.0; 3]))), "COLUMN TWICE"),
        (edited(|state| state.add_columns(Domain::new("bodies").with(Charge, [1.0; 2]))), "COLUMN LENGTH"),
        (edited(|state| state.set_constant(GravityAcceleration, [1.0, 2.0])), "CONSTANT"),
        (changed(moving(), |state| state.set("bodies", Velocity, 1, DVec3::NAN).unwrap()), "BLOW UP"),
        (changed(moving(), |state| *state = State::new([], []).unwrap()), "nothing is wrong"),
        (changed(moving().strict(), |state| state.remove_column("bodies", Mass).unwrap()), "STRICT LATER"),
    ]);
}

property! {
    /// A mass that is a vector.
    WrongMass = "mass": Vector, "kg";
}

#[test]
fn mistakes_with_lent_memory() {
    let lent = Lent::new(vec![[0.0; 3]; 2]);
    let mut numbers = vec![[0.0; 3]; 2];
    let start = std::ptr::NonNull::new(numbers.as_mut_ptr()).unwrap();
    // SAFETY: the vector outlives the handle, and nobody else touches it.
    let raw = unsafe { Lent::from_raw(start, 2) };
    let engine = |memory: &Lent<f64, 3>| {
        let bodies = Domain::new("bodies").lend(Position, memory).with(Velocity, [[1.0; 3]; 2]).with(Mass, [1.0; 2]);
        engine().domain(bodies).law(Motion).build().unwrap()
    };
    let more = || Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    let mut running = engine(&lent);
    let mut fixed = engine(&raw);
    let guard = lent.read();
    let mut table = vec![
        (said(running.advance(0.1)), "BORROWED"),
        (said(running.state_mut().set("bodies", Position, 0, DVec3::ZERO)), "BORROWED SET"),
        (said(running.state_mut().add_rows(more())), "BORROWED ADD"),
        (said(running.energy()), "BORROWED ENERGY"),
    ];
    drop(guard);
    let guard = lent.write();
    table.push((said(running.state().get("bodies", Position, 0)), "BORROWED GET"));
    drop(guard);
    table.push((said(fixed.state_mut().add_rows(more())), "RAW GROW"));
    table.push((said(fixed.state_mut().remove_rows("bodies", &[0])), "RAW SHRINK"));
    table.push((said(fixed.advance(0.1)), "nothing is wrong"));
    if let vesper::column::Memory::Vector(rows) = &mut *lent.write() {
        rows.push([0.0; 3]);
    }
    table.push((said(running.advance(0.1)), "LENT LENGTH"));
    check(&table);
}

#[test]
fn what_a_law_sleeps_for() {
    let report = |builder: Builder<f64>, law: &str| builder.build().unwrap().report().law(law).unwrap().to_string();
    let few = || Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[0.0; 3]]);
    let misspelt = PropertyInfo::new("mas", Kind::Scalar, "kg");
    let thread = || Domain::new("springs").with(Stiffness, [1.0]).with(RestLength, [1.0]);
    check(&[
        (report(engine().domain(few()).law(Gravity::default()), "gravity"), "MISSING"),
        (report(engine().domain(few().with(misspelt, [1.0])).law(Motion), "motion"), "NEAREST"),
        (report(engine().domain(few()).law(Motion).law(Inertia), "motion"), "STARVED"),
        (report(engine().domain(few()).law(Motion).law(Inertia), "inertia"), "STARVING"),
        (report(engine().domain(thread()).law(Spring), "spring"), "LINK"),
        (report(engine().domain(few()).law(Spring), "spring"), "DOMAIN"),
        (report(engine().domain(few()).domain(Domain::new("spring").rows(1)).law(Spring), "spring"), "NEAR DOMAIN"),
        (report(engine().law(Motion), "motion"), "NO DOMAIN"),
        (report(engine().domain(few().with(Charge, [1.0])).law(Electric), "electric"), "FIELD"),
        (report(engine().domain(few().with(Charge, [1.0])).field(MagneticField, Boxes::default()).law(Electric), "electric"), "FIELD"),
        (report(engine().domain(Domain::new("b").with(Charge, [1.0])).field(ElectricField, Boxes::default()).law(Electric), "electric"), "FIELD PLACE"),
        (report(engine().domain(few()).law(DynLaw::new("fall").scene(GravityAcceleration).adds(Force).body(|_, _| {})), "fall"), "CONSTANT"),
        (report(engine().domain(Domain::new("bodies").with(Cooling, [1.0])).law(Cool), "cool"), "STATE"),
        (report(moving().law(Weight.off()), "weight"), "OFF"),
        (report(engine().domain(bodies()).law(Weight), "weight"), "PRUNED"),
        (report(moving(), "motion"), "ACTIVE"),
        (built(engine().domain(few()).law(Motion).strict()), "STRICT"),
        (built(engine().domain(few()).law(Motion.required())), "REQUIRED"),
        (built(engine().domain(few()).require("motion").law(Motion)), "REQUIRED BY NAME"),
        (built(engine().domain(Domain::new("bodies").with(Position, Vec::<[f64; 3]>::new()).with(Velocity, Vec::<[f64; 3]>::new()).with(Mass, Vec::<f64>::new())).law(Motion).strict()), "EMPTY"),
    ]);
}

#[test]
fn several_mistakes_are_reported_together() {
    let bodies = bodies().with(DragCoefficient, [1.0]).subset(Charge, [7], [f64::NAN]).with(Mass, [1.0; 3]);
    let springs = Domain::new("springs").link(Ends, "bodys", [[0, 1]]).with_unit(Stiffness, "N", [1.0]);
    let text = built(engine().domain(bodies).domain(springs).step(-1.0).threads(0));
    check(&[(text, "DATA")]);
    let laws = moving().law(Motion).law(Weight.every(0)).law(Drag.on("stars")).observe("bodies", Colour).step(0.0);
    check(&[(built(laws.law(set("rigid", Mass, Velocity)).require("drug")), "LAWS")]);
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
