//! Mistakes between steps, and with lent memory.

use super::*;

#[test]
fn mistakes_between_steps() {
    let two = || Domain::new("bodies").with(Position, [[0.0; 3]; 2]).with(Velocity, [[0.0; 3]; 2]).with(Mass, [1.0; 2]);
    check(&[
        (edited(|state| Ok(state.get("bodeis", Mass, 0)?)), "domain bodeis does not exist; did you mean bodies?"),
        (
            edited(|state| Ok(state.get("bodies", RestMass, 0)?)),
            "bodies has no property rest_mass: give it as a column, or observe it where a law computes it",
        ),
        (
            edited(|state| Ok(state.get("bodies", Force, 0)?)),
            "bodies has no property force: give it as a column, or observe it where a law computes it",
        ),
        (edited(|state| Ok(state.get("bodies", Mass, 3)?)), "bodies has no row 3: it has 3 rows, counted from 0"),
        (edited(|state| Ok(state.set("bodies", Mass, 9, 1.0)?)), "bodies has no row 9: it has 3 rows, counted from 0"),
        (
            edited(|state| Ok(state.values("bodies", WrongMass)?)),
            "bodies.mass is a scalar, but it is asked for as a vector: give the property that the column was made with",
        ),
        (
            edited(|state| state.add_rows(Domain::new("bodies").with(Mass, [1.0]))),
            "the new rows of bodies lack position [m], which all rows have: give it for them too\nthe new rows of bodies lack velocity [m/s], which all rows have: give it for them too",
        ),
        (
            edited(|state| state.add_rows(two().with(Charge, [1.0; 2]))),
            "bodies has no property charge: give it as a column, or observe it where a law computes it",
        ),
        (edited(|state| state.add_rows(two().with(Mass, [1.0]))), "bodies.mass is given twice: keep one"),
        (
            edited(|state| state.add_rows(Domain::new("scene").with(Mass, [1.0]))),
            "domain scene has always one row, which holds the constants: change a constant by `set_constant`",
        ),
        (
            edited(|state| {
                state.add_rows(
                    Domain::new("springs").link(Ends, "stars", [[0, 1]]).with(Stiffness, [1.0]).with(RestLength, [1.0]),
                )
            }),
            "springs.ends links to bodies, but the new rows link to stars: link them to bodies",
        ),
        (
            edited(|state| {
                state.add_rows(
                    Domain::new("springs")
                        .link(Ends, "bodies", [[0, 3]])
                        .with(Stiffness, [1.0])
                        .with(RestLength, [1.0]),
                )
            }),
            "springs.ends: row 0 links to row 3 of bodies, which has 3 rows, counted from 0",
        ),
        (
            edited(|state| {
                state.add_rows(
                    Domain::new("springs")
                        .link(Ends, "bodies", [[0, 1]])
                        .subset(Stiffness, [0], [1.0])
                        .with(RestLength, [1.0]),
                )
            }),
            "springs.stiffness has a value for every row: give one for every new row, not for a subset of them",
        ),
        (
            edited(|state| Ok(state.remove_rows("bodies", &[0, 3])?)),
            "bodies has no row 3: it has 3 rows, counted from 0",
        ),
        (
            edited(|state| Ok(state.remove_rows("scene", &[0])?)),
            "domain scene has always one row, which holds the constants: take a constant away by `remove_column`",
        ),
        (
            edited(|state| Ok(state.remove_column("scene", Time)?)),
            "domain scene has always one row, which holds the constants: its time stays, set it to another value",
        ),
        (
            edited(|state| state.add_columns(Domain::new("scene").with(Time, [5.0]))),
            "domain scene has always one row, which holds the constants: its time is there, set it to another value",
        ),
        (
            edited(|state| Ok(state.remove_column("bodies", Charge)?)),
            "bodies has no property charge: give it as a column, or observe it where a law computes it",
        ),
        (
            edited(|state| state.add_columns(Domain::new("bodies").with(Charge, [1.0; 3]).with(Mass, [1.0; 3]))),
            "bodies.mass is given twice: keep one",
        ),
        (
            edited(|state| state.add_columns(Domain::new("bodies").with(Charge, [1.0; 2]))),
            "bodies.charge has 2 values, but domain bodies has 3 rows, as stated: give one value per row",
        ),
        (
            edited(|state| state.set_constant(GravityAcceleration, [1.0, 2.0])),
            "scene.gravity is a vector, but it is given as 1 number per row: give 3 numbers per row",
        ),
        (
            edited(|state| state.set("bodies", Velocity, 1, DVec3::NAN).map_err(Faults::from)),
            "bodies.velocity: row 1 is NaN: give a finite number",
        ),
        (changed(moving(), |state| *state = State::new([], []).unwrap()), "nothing is wrong"),
        (
            changed(moving().strict(), |state| state.remove_column("bodies", Mass).unwrap()),
            "motion must run, but is dormant: it reads mass [kg], which domain bodies does not have: add mass",
        ),
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
        (said(running.advance(0.1)), "bodies.position is borrowed by the client: let go of it first"),
        (
            said(running.state_mut().set("bodies", Position, 0, DVec3::ZERO)),
            "bodies.position is borrowed by the client: let go of it first",
        ),
        (said(running.state_mut().add_rows(more())), "bodies.position is borrowed by the client: let go of it first"),
        (said(running.energy()), "bodies.position is borrowed by the client: let go of it first"),
    ];
    drop(guard);
    let guard = lent.write();
    table.push((
        said(running.state().get("bodies", Position, 0)),
        "bodies.position is borrowed by the client: let go of it first",
    ));
    drop(guard);
    table.push((
        said(fixed.state_mut().add_rows(more())),
        "bodies.position is the client's own memory, which cannot grow: it is raw memory of a fixed number of rows",
    ));
    table.push((
        said(fixed.state_mut().remove_rows("bodies", &[0])),
        "bodies.position is the client's own memory, which cannot shrink: it is raw memory of a fixed number of rows",
    ));
    table.push((said(fixed.advance(0.1)), "nothing is wrong"));
    if let vesper::column::Memory::Vector(rows) = &mut *lent.write() {
        rows.push([0.0; 3]);
    }
    table.push((said(running.advance(0.1)), "bodies.position has 3 values, but domain bodies has 2 rows, as added and removed through the state: give one value per row"));
    check(&table);
}
