//! How a run is cut into frames, looked at, and lent memory for, does not show in its results.

use super::*;

fn heap() -> Builder<f64> {
    let bodies = cloud(6, 8);
    Engine::builder().domain(bodies).law(Gravity::default()).law(Motion).step(0.01)
}

#[test]
fn amending_laws_give_the_same_bits_in_one_frame_and_in_many() {
    let run = |frames: u32| {
        let mut engine = heap().law(Floor).build().unwrap();
        (0..frames).for_each(|_| engine.advance(0.2 / f64::from(frames)).unwrap());
        assert_eq!(engine.steps(), 20);
        engine.state().hash()
    };
    assert_eq!(run(1), run(20));
    assert_eq!(run(1), run(4));
}

#[test]
fn looking_at_forces_and_energy_changes_nothing_that_laws_look_back_at() {
    let run = |looks: bool| {
        let builder = heap().law(Echo).law(Remember).law(Drag);
        let builder = if looks { builder.observe("bodies", Force).observe("bodies", Memory) } else { builder };
        let mut engine = builder.build().unwrap();
        for _ in 0..10 {
            engine.advance(0.01).unwrap();
            if looks {
                engine.energy().unwrap();
                engine.refresh().unwrap();
            }
        }
        engine.state().hash()
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn what_is_looked_at_is_there_before_the_first_step() {
    let one = one().with(ExternalForce, [[8.0, 0.0, 0.0]]);
    let builder = Engine::<f64>::builder().domain(one).law(Motion).observe("bodies", Force);
    let mut engine = builder.build().unwrap();
    let force = |engine: &Engine<f64>| engine.state().get("bodies", Force, 0).unwrap();
    assert_eq!(force(&engine), DVec3::new(8.0, 0.0, 0.0));
    engine.state_mut().set("bodies", ExternalForce, 0, DVec3::new(0.0, 3.0, 0.0)).unwrap();
    engine.advance(0.0).unwrap();
    assert_eq!(force(&engine), DVec3::new(0.0, 3.0, 0.0));
    let saved = engine.checkpoint().unwrap();
    engine.state_mut().set("bodies", ExternalForce, 0, DVec3::ZERO).unwrap();
    engine.restore(&saved).unwrap();
    assert_eq!(force(&engine), DVec3::new(0.0, 3.0, 0.0));
}

#[test]
fn lent_memory_that_the_client_changes_is_noticed() {
    let rows = |x: f64| vec![[0.0; 3], [x, 0.0, 0.0]];
    let (position, velocity) = (Lent::new(rows(1.0)), Lent::new(rows(0.0)));
    let mut raw = rows(1.0);
    // SAFETY: the vector outlives the engine, and is changed only between frames.
    let memory = unsafe { Lent::from_raw(std::ptr::NonNull::new(raw.as_mut_ptr()).unwrap(), 2) };
    let build = |domain: Domain<f64>| {
        let builder = Engine::<f64>::builder().domain(domain.with(Mass, [1.0, 2.0])).law(Gravity::default());
        builder.law(Motion).step(0.1).build().unwrap()
    };
    let mut lent = build(Domain::new("bodies").lend(Position, &position).lend(Velocity, &velocity));
    let mut of_others = build(Domain::new("bodies").lend(Position, &memory).with(Velocity, rows(0.0)));
    let mut owned = build(Domain::new("bodies").with(Position, rows(1.0)).with(Velocity, rows(0.0)));
    [&mut lent, &mut of_others, &mut owned].into_iter().for_each(|engine| engine.advance(0.3).unwrap());
    let moved = [0.0, 2.0, 0.0];
    position.write()[1] = moved;
    raw[1] = moved;
    owned.state_mut().set("bodies", Position, 1, moved.into()).unwrap();
    [&mut lent, &mut of_others, &mut owned].into_iter().for_each(|engine| engine.advance(0.1).unwrap());
    assert_eq!(lent.state().hash(), owned.state().hash());
    assert_eq!(of_others.state().hash(), owned.state().hash());
}

#[test]
fn a_guard_that_the_client_forgot_is_a_fault_and_no_deadlock() {
    let position = Lent::new(vec![[0.0; 3]]);
    let domain = Domain::new("bodies").lend(Position, &position).with(Velocity, [[0.0; 3]]).with(Mass, [1.0]);
    let build = || Engine::<f64>::builder().domain(domain.clone()).law(Motion).step(0.5).build();
    let said = "bodies.position is borrowed by the client: let go of it first";
    let guard = position.write();
    assert_eq!(build().err().unwrap().to_string(), said);
    drop(guard);
    let mut engine = build().unwrap();
    let guard = position.write();
    assert_eq!(engine.advance(0.5).unwrap_err().to_string(), said);
    assert_eq!(engine.checkpoint().unwrap_err().to_string(), said);
    engine.trace_blow_ups(true);
    assert_eq!(engine.advance(0.5).unwrap_err().to_string(), said);
    engine.enable("motion", false).unwrap();
    engine.enable("motion", true).unwrap();
    assert_eq!(engine.advance(0.5).unwrap_err().to_string(), said);
    engine.state().hash();
    drop(guard);
    engine.advance(0.5).unwrap();
}

#[test]
fn an_engine_moves_to_another_thread() {
    let mut engine = heap().build().unwrap();
    let mut other = heap().build().unwrap();
    engine.advance(0.1).unwrap();
    other.advance(0.1).unwrap();
    let moved = std::thread::spawn(move || {
        engine.advance(0.1).unwrap();
        engine.state().hash()
    });
    other.advance(0.1).unwrap();
    assert_eq!(moved.join().unwrap(), other.state().hash());
}
