//! Stop, save, load, go on: the same bits.

use super::*;
use vesper::engine::{ColumnData, DomainData};

fn build<P: Precision>(integrator: usize) -> Engine<P> {
    let builder = Engine::<P>::builder().domain(cloud(20, 6)).domain(springs(20)).step(0.1);
    let builder =
        builder.law(Gravity::default()).law(Spring.every(3)).law(Drag.every(2)).law(Motion).law(Echo).law(Remember);
    let builder = match integrator {
        0 => builder,
        1 => builder.integrator(RungeKutta4),
        _ => builder.integrator(SemiImplicitEuler),
    };
    builder.build().unwrap()
}

fn goes_on<P: Precision>() {
    for integrator in 0..3 {
        for frames in [1, 4, 7] {
            let mut straight = build::<P>(integrator);
            (0..frames).for_each(|_| straight.advance(0.25).unwrap());
            let saved = straight.checkpoint().unwrap();
            let mut later = build::<P>(integrator);
            later.advance(0.1).unwrap();
            later.restore(&saved).unwrap();
            assert_eq!(later.checkpoint().unwrap(), saved, "what is restored is what was saved");
            for _ in 0..5 {
                straight.advance(0.25).unwrap();
                later.advance(0.25).unwrap();
                assert_eq!((later.steps(), later.time()), (straight.steps(), straight.time()));
                assert_eq!(later.state().hash(), straight.state().hash(), "integrator {integrator}, {frames} frames");
            }
            assert_eq!(later.evaluations(), straight.evaluations());
        }
    }
}

#[test]
fn a_run_goes_on_from_a_checkpoint_in_f64() {
    goes_on::<f64>();
}

#[test]
fn a_run_goes_on_from_a_checkpoint_in_double_double() {
    goes_on::<DoubleDouble>();
}

#[test]
fn a_run_goes_on_from_a_checkpoint_in_f32() {
    goes_on::<f32>();
}

#[test]
fn a_checkpoint_has_its_own_rows() {
    let mut engine = build::<f64>(0);
    engine.advance(0.5).unwrap();
    let saved = engine.checkpoint().unwrap();
    let mut other = build::<f64>(0);
    other.state_mut().remove_rows("bodies", &[3, 4, 5]).unwrap();
    other.advance(0.3).unwrap();
    other.restore(&saved).unwrap();
    engine.advance(0.5).unwrap();
    other.advance(0.5).unwrap();
    assert_eq!(engine.state().hash(), other.state().hash());
}

#[test]
fn lent_memory_is_restored_in_place() {
    let memory = Lent::new(vec![[0.0; 3]; 2]);
    let domain =
        Domain::new("bodies").lend(Position, &memory).with(Velocity, [[1.0, 0.0, 0.0]; 2]).with(Mass, [1.0; 2]);
    let mut engine = Engine::<f64>::builder().domain(domain).law(Motion).step(1.0).build().unwrap();
    let saved = engine.checkpoint().unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!(memory.read()[1], [1.0, 0.0, 0.0]);
    let guard = memory.read();
    assert!(engine.restore(&saved).is_err(), "the client looks at it");
    drop(guard);
    engine.restore(&saved).unwrap();
    assert_eq!(memory.read()[1], [0.0; 3]);
}

#[test]
fn a_checkpoint_that_does_not_fit_changes_nothing() {
    let mut engine = build::<f64>(0);
    engine.advance(0.3).unwrap();
    let saved = engine.checkpoint().unwrap();
    type Spoil = fn(&mut vesper::engine::Checkpoint);
    fn domain<'a>(checkpoint: &'a mut vesper::engine::Checkpoint, name: &str) -> &'a mut DomainData {
        checkpoint.domains.iter_mut().find(|domain| domain.name == name).unwrap()
    }
    fn column<'a>(checkpoint: &'a mut vesper::engine::Checkpoint, name: &str, property: &str) -> &'a mut ColumnData {
        domain(checkpoint, name).columns.iter_mut().find(|column| column.property == property).unwrap()
    }
    let table: &[(Spoil, &str)] = &[
        (|c| c.precision = "f32".to_owned(), "it is in f32, the engine in f64"),
        (|c| c.integrator = "euler".to_owned(), "it is of euler, the engine has leapfrog"),
        (|c| c.clock.1 = 99, "its clock makes no sense"),
        (|c| c.remainder = f64::NAN, "its clock makes no sense"),
        (|c| _ = c.domains.pop(), "it has 2 domains, the engine 3"),
        (|c| domain(c, "springs").name = "threads".to_owned(), "it lacks domain springs"),
        (|c| _ = domain(c, "bodies").columns.pop(), "domain bodies has other columns or rows"),
        (|c| domain(c, "scene").rows = 0, "domain scene has other columns or rows"),
        (|c| column(c, "bodies", "mass").property = "charge".to_owned(), "it lacks bodies.mass"),
        (|c| _ = column(c, "bodies", "mass").numbers.pop(), "bodies.mass has another number of values"),
        (|c| domain(c, "bodies").rows = 21, "bodies.position has another number of values"),
        (|c| column(c, "springs", "ends").links[3] = 20, "springs.ends links to rows that do not exist"),
        (|c| _ = column(c, "springs", "ends").links.pop(), "springs.ends has another number of links"),
        (
            |c| column(c, "bodies", "charge").subset = Some((1..21).collect()),
            "bodies.charge has values for rows that do not exist, or not in their order",
        ),
        (
            |c| column(c, "bodies", "charge").subset = Some((0..20).rev().collect()),
            "bodies.charge has values for rows that do not exist, or not in their order",
        ),
    ];
    for (spoil, expected) in table {
        let mut spoilt = saved.clone();
        spoil(&mut spoilt);
        let text = engine.restore(&spoilt).unwrap_err().to_string();
        assert_eq!(text, format!("the checkpoint does not fit: {expected}"));
        assert_eq!(engine.checkpoint().unwrap(), saved, "after: {text}");
    }
    // Numbers of an integrator that do not fit are not taken; the run goes on from the state.
    let mut short = saved.clone();
    short.registers.clear();
    engine.restore(&short).unwrap();
    engine.advance(0.1).unwrap();
}
