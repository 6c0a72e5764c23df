//! The order of the laws, what nobody needs, and how both are told.

use crate::common::*;
use vesper::prelude::*;

fn bodies() -> Domain<f64> {
    cloud(3, 1)
}

fn set(name: &str, reads: impl AsProperty, sets: impl AsProperty) -> DynLaw {
    DynLaw::new(name).domain("bodies").reads(reads).sets(sets).body(|_, out| out.fill(1.0))
}

/// The laws in the order of an evaluation, each with its level.
fn order(builder: Builder<f64>) -> Vec<String> {
    let engine = builder.domain(bodies()).build().unwrap();
    let text = engine.explain();
    let lines = text.lines().filter_map(|line| line.trim_start().split_once(". level "));
    lines.map(|(_, law)| law.split(':').next().unwrap_or_default().to_owned()).collect()
}

#[test]
fn a_property_is_set_then_added_to_then_read() {
    let [first, second] =
        [PropertyInfo::new("first", Kind::Scalar, "1"), PropertyInfo::new("second", Kind::Scalar, "1")];
    let z = set("z_sets_first", Mass, first);
    let y = set("y_sets_second", first, second);
    let x = DynLaw::new("x_adds").domain("bodies").reads(second).adds(Force).body(|_, _| {});
    let found = order(Engine::builder().law(Motion).law(x).law(y).law(z));
    assert_eq!(found, ["0 z_sets_first", "1 y_sets_second", "2 x_adds", "3 motion"]);
}

#[test]
fn ties_are_broken_by_name_and_not_by_the_list() {
    let laws = |names: [&str; 3]| {
        let add = |name| DynLaw::new(name).domain("bodies").reads(Mass).adds(Force).body(|_, _| {});
        names.into_iter().fold(Engine::builder().law(Motion), |builder, name| builder.law(add(name)))
    };
    let expected = ["0 a", "0 b", "0 c", "1 motion"];
    assert_eq!(order(laws(["a", "b", "c"])), expected);
    assert_eq!(order(laws(["c", "a", "b"])), expected);
}

#[test]
fn laws_that_reach_across_rows_stand_before_a_pass_over_rows() {
    let builder = Engine::builder().law(Drag).law(Gravity::default()).law(Weight).law(Motion);
    assert_eq!(order(builder), ["0 gravity", "0 drag", "0 weight", "1 motion"]);
}

#[test]
fn a_reader_of_the_previous_value_stands_before_all_who_make_it() {
    let builder = Engine::builder().law(Drag).law(Echo).law(Motion).law(Weight).law(Gravity::default()).law(Remember);
    assert_eq!(order(builder), ["0 remember", "1 drag", "1 echo", "1 weight", "1 gravity", "2 motion"]);
}

#[test]
fn amending_laws_come_last() {
    let builder = Engine::builder().law(Floor).law(Motion).law(Weight);
    assert_eq!(order(builder), ["0 weight", "1 motion", "0 floor"]);
}

#[test]
fn a_circle_is_told_by_its_path() {
    let of = |name| PropertyInfo::at_run_time(name, Kind::Scalar, "1").unwrap();
    let laws = [("a", "p", "q"), ("b", "q", "r"), ("c", "r", "p"), ("on_top", "r", "s")];
    let builder = laws.into_iter().fold(Engine::builder().domain(bodies()), |builder, (name, reads, sets)| {
        builder.law(set(name, of(reads), of(sets)))
    });
    let text = builder.build().unwrap_err().to_string();
    let expected = "the laws close a circle: a sets bodies.q, which b reads, b sets bodies.r, which c reads, \
                    c sets bodies.p, which a reads: let one of them read the value before, `reads(previous ...)`";
    assert_eq!(text, expected);
}

#[test]
fn what_reaches_neither_integrator_nor_observer_is_pruned() {
    let build = |observe: bool| {
        let builder = Engine::<f64>::builder().domain(bodies()).law(Motion).law(Weight).law(Recorder).step(0.1);
        let builder = if observe { builder.observe("bodies", Trace) } else { builder };
        let mut engine = builder.build().unwrap();
        engine.advance(0.1).unwrap();
        engine
    };
    let (blind, looking) = (build(false), build(true));
    assert_eq!(blind.report().law("recorder").unwrap().status.word(), "pruned");
    assert_eq!(looking.report().law("recorder").unwrap().status.word(), "active");
    assert!(blind.state().column("bodies", "trace").is_err(), "nobody made it");
    // A force that only one pass exchanges has no column; one that an observed law reads is as it was at the end.
    let trace = looking.state().get("bodies", Trace, 1).unwrap();
    let (mass, external) =
        (looking.state().get("bodies", Mass, 1).unwrap(), looking.state().get("bodies", ExternalForce, 1).unwrap());
    assert_eq!(trace, external + DVec3::new(0.0, 0.0, -10.0) * mass);
    assert_eq!(blind.state().hash(), looking.state().hash(), "looking changes nothing");
}

#[test]
fn a_sum_is_kept_where_it_is_looked_at_and_passed_on_in_a_scratch_elsewhere() {
    let build = |observe: bool| {
        let builder = Engine::<f64>::builder().domain(bodies()).law(Motion).law(Weight).step(0.1);
        let builder = builder.integrator(SemiImplicitEuler);
        let mut engine = if observe { builder.observe("bodies", Force) } else { builder }.build().unwrap();
        engine.advance(0.3).unwrap();
        engine
    };
    let (blind, looking) = (build(false), build(true));
    assert!(blind.state().column("bodies", "force").is_err());
    let force = looking.state().get("bodies", Force, 0).unwrap();
    let mass = looking.state().get("bodies", Mass, 0).unwrap();
    assert_eq!(force, looking.state().get("bodies", ExternalForce, 0).unwrap() + DVec3::new(0.0, 0.0, -10.0) * mass);
    assert_eq!(blind.state().hash(), looking.state().hash());
}

#[test]
fn one_more_property_is_looked_at_while_the_engine_runs() {
    let engine = || Engine::<f64>::builder().domain(bodies()).law(Motion).law(Weight).law(Recorder).step(0.1).build();
    let (mut blind, mut looking) = (engine().unwrap(), engine().unwrap());
    for engine in [&mut blind, &mut looking] {
        engine.advance(0.3).unwrap();
    }
    assert!(looking.state().column("bodies", "trace").is_err());
    looking.observe_also("bodies", Trace).unwrap();
    let (row, weight) = (1, DVec3::new(0.0, 0.0, -10.0));
    let expected = |engine: &Engine<f64>| {
        let state = engine.state();
        state.get("bodies", ExternalForce, row).unwrap() + weight * state.get("bodies", Mass, row).unwrap()
    };
    assert_eq!(looking.state().get("bodies", Trace, row), Ok(expected(&looking)), "at once");
    assert_eq!(looking.report().law("recorder").unwrap().status.word(), "active");
    looking.observe_also("bodies", Trace).unwrap();
    let refused = looking.observe_also("bodies", Colour).unwrap_err().to_string();
    assert!(refused.starts_with("bodies has no property colour"), "{refused}");
    assert!(looking.observe_also("dust", Trace).is_err());
    for engine in [&mut blind, &mut looking] {
        engine.advance(0.3).unwrap();
    }
    assert_eq!(looking.state().get("bodies", Trace, row), Ok(expected(&looking)), "a refused one leaves the others");
    assert_eq!(blind.state().hash(), looking.state().hash(), "looking changes nothing");
}

/// A scene with laws of all shapes, a dormant one, a pruned one, one that is off, and an unused column.
fn scene() -> Engine<f64> {
    Engine::builder()
        .domain(bodies().with(Colour, [[0.0; 3]; 3]))
        .domain(springs(3))
        .law(Motion)
        .law(Gravity::default())
        .law(Spring)
        .law(Drag.every(4))
        .law(Weight)
        .law(Inertia)
        .law(Recorder)
        .law(Electric.off())
        .law(Floor)
        .integrator(SemiImplicitEuler)
        .step(0.1)
        .build()
        .unwrap()
}

#[test]
fn the_graph_is_explained() {
    assert_eq!(scene().explain(), EXPLAINED);
}

#[test]
fn the_graph_is_drawn() {
    assert_eq!(scene().to_dot(), DRAWN);
}

const EXPLAINED: &str = r#"integrator semi_implicit_euler (order 1), precision f64
order of an evaluation:
   1. level 0 drag: row law on 3 rows of bodies, every 4 steps
        reads bodies.velocity [m/s]
        reads bodies.drag_coefficient [kg/s]
        reads wind_velocity, which is not there [m/s]
        adds bodies.force [N]
   2. level 0 gravity: pair law on 3 rows of bodies, 3 pairs
        reads bodies.position [m]
        reads bodies.mass [kg]
        adds bodies.force [N]
   3. level 0 spring: link law on 2 rows of springs
        reads springs.stiffness [N/m]
        reads springs.rest_length [m]
        reads bodies.position [m] of the rows linked to
        adds bodies.force [N] of the rows linked to
   4. level 0 weight: row law on 3 rows of bodies
        reads bodies.mass [kg]
        reads gravity, by default [m/s^2]
        adds bodies.force [N]
   5. level 1 motion: row law on 3 rows of bodies
        reads bodies.velocity [m/s]
        reads bodies.force [N]
        reads bodies.mass [kg]
        rates bodies.position [m]
        rates bodies.velocity [m/s]
        after drag, which adds bodies.force
        after gravity, which adds bodies.force
        after spring, which adds bodies.force
        after weight, which adds bodies.force
   6. level 0 floor: row law on 3 rows of bodies
        reads bodies.position [m]
        amends bodies.position [m]
rates of momenta: 7 passes
  rows: start of sums (block by block)
  shares of drag begin anew, every 4 steps
  rows: drag (block by block)
  held shares of drag are added
  pairs: gravity (3 rows)
  links: spring (2 links)
  rows: weight, motion (block by block)
rates of coordinates: 1 pass
  rows: motion (block by block)
kick and drift in one go: 7 passes
  rows: start of sums (block by block)
  shares of drag begin anew, every 4 steps
  rows: drag (block by block)
  held shares of drag are added
  pairs: gravity (3 rows)
  links: spring (2 links)
  rows: weight, motion (block by block)
after a step: 1 pass
  rows: floor (block by block)
inertia is dormant: it reads rest_mass [kg], which domain bodies does not have: add rest_mass
recorder is pruned: neither the integrator nor an observer needs bodies.trace; 3 rows saved per evaluation
electric is off
bodies.charge is unused: no running law touches it
bodies.colour is unused: no running law touches it
"#;
const DRAWN: &str = r#"digraph laws {
  rankdir = LR;
  node [shape = box, fontname = "sans-serif"];
  l0 [label = "1. drag\nrow law on bodies"];
  l2 [label = "2. gravity\npair law on bodies"];
  l5 [label = "3. spring\nlink law on springs"];
  l6 [label = "4. weight\nrow law on bodies"];
  l3 [label = "5. motion\nrow law on bodies"];
  l4 [label = "6. recorder\nrow law on bodies", style = dashed];
  l1 [label = "7. floor\nrow law on bodies"];
  l0 -> l3 [label = "adds bodies.force"];
  l0 -> l4 [label = "adds bodies.force"];
  l2 -> l3 [label = "adds bodies.force"];
  l2 -> l4 [label = "adds bodies.force"];
  l5 -> l3 [label = "adds bodies.force"];
  l5 -> l4 [label = "adds bodies.force"];
  l6 -> l3 [label = "adds bodies.force"];
  l6 -> l4 [label = "adds bodies.force"];
  q0 [label = "bodies.velocity\nkicked", shape = ellipse];
  l3 -> q0 [label = "rates"];
  q4 [label = "bodies.position\ndrifted", shape = ellipse];
  l1 -> q4 [label = "amends"];
  l3 -> q4 [label = "rates"];
}
"#;
