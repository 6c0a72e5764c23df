//! The client's own memory, used in place.

use super::*;

#[test]
fn lent_memory_is_used_in_place_and_gives_the_same_bits() {
    const ROWS: usize = 700;
    let cloud = || cloud::<f64>(ROWS, 5);
    let start = State::new([cloud()], []).unwrap();
    let rows = |property: &str| -> Vec<[f64; 3]> {
        let column = start.column("bodies", property).unwrap().components().unwrap();
        (0..ROWS).map(|row| core::array::from_fn(|c| column[c][row])).collect()
    };
    let position = Lent::new(rows("position"));
    let mut velocity = rows("velocity");
    let memory = std::ptr::NonNull::new(velocity.as_mut_ptr()).unwrap();
    // SAFETY: the vector outlives the engine, and is looked at only after it is gone.
    let velocity_lent = unsafe { Lent::from_raw(memory, ROWS) };
    let before = position.read().as_ptr();
    let numbers = |property| start.numbers("bodies", property).unwrap();
    let domain = Domain::new("bodies")
        .lend(Position, &position)
        .lend(Velocity, &velocity_lent)
        .with(Mass, numbers(Mass.info()))
        .with(DragCoefficient, numbers(DragCoefficient.info()))
        .with(ExternalForce, rows("external_force"));
    for threads in [1, 3] {
        let build = |domain: Domain<f64>| {
            let builder = Engine::builder().domain(domain).domain(springs(ROWS)).step(0.01).threads(threads);
            let builder = if threads > 1 { builder.backend(Backend::Parallel) } else { builder };
            builder.law(Gravity::default()).law(Spring).law(Drag).law(Herd).law(Motion).build().unwrap()
        };
        let mut lent = build(domain.clone());
        let mut owned = build(cloud());
        if threads == 3 {
            // The lent memory has gone on by then.
            *owned.state_mut() = lent.state().clone();
        }
        lent.advance(0.02).unwrap();
        owned.advance(0.02).unwrap();
        if threads == 1 {
            let same = |property| {
                let numbers = |engine: &Engine<f64>| engine.state().numbers("bodies", property).unwrap();
                assert_eq!(numbers(&lent), numbers(&owned));
            };
            same(Position.info());
            same(Velocity.info());
        }
        let moved = lent.state().get("bodies", Position, 9).unwrap().to_array();
        assert_eq!(position.read()[9], moved, "the client sees it in its own memory");
        assert_eq!(position.read().as_ptr(), before, "which is where it was");
        drop((lent, owned));
    }
    assert_ne!(velocity, rows("velocity"), "raw memory was used in place too");
}

#[test]
fn a_client_changes_lent_memory_between_frames() {
    let position = Lent::new(vec![[0.0; 3]]);
    let domain = Domain::new("bodies").lend(Position, &position).with(Velocity, [[1.0, 0.0, 0.0]]).with(Mass, [1.0]);
    let mut engine = Engine::<f64>::builder().domain(domain).law(Motion).step(1.0).build().unwrap();
    engine.advance(1.0).unwrap();
    position.write()[0][0] += 10.0;
    engine.advance(1.0).unwrap();
    assert_eq!(place(&engine, 0).x, 12.0);
}

#[test]
fn rows_come_and_go_in_lent_vectors_too() {
    let position = Lent::new(vec![[0.0; 3], [5.0; 3]]);
    let domain =
        Domain::new("bodies").lend(Position, &position).with(Velocity, [[1.0, 0.0, 0.0]; 2]).with(Mass, [1.0; 2]);
    let mut engine = Engine::<f64>::builder().domain(domain).law(Motion).step(1.0).build().unwrap();
    engine.advance(1.0).unwrap();
    let more =
        Domain::new("bodies").with(Position, [[7.0; 3]; 50]).with(Velocity, [[0.0; 3]; 50]).with(Mass, [1.0; 50]);
    engine.state_mut().add_rows(more).unwrap();
    engine.state_mut().remove_rows("bodies", &[0]).unwrap();
    engine.advance(1.0).unwrap();
    assert_eq!((position.read().len(), position.read()[0][0], position.read()[50]), (51, 7.0, [7.0; 3]));
}

#[test]
fn memory_is_not_lent_to_a_second_column_later() {
    let memory = Lent::new(vec![[0.0; 3]]);
    let mut state = State::<f64>::new([Domain::new("bodies").lend(Memory, &memory)], []).unwrap();
    let again = state.add_columns(Domain::new("bodies").lend(Trace, &memory)).unwrap_err();
    assert_eq!(
        again.to_string(),
        "bodies.trace is the client's own memory, which cannot be lent twice: it is lent to bodies.memory already: \
         lend each column memory of its own"
    );
}
