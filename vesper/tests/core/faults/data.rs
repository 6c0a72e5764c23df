//! Mistakes in what a client gives.

use super::*;

#[test]
fn mistakes_in_what_a_client_gives() {
    let one = || Domain::new("bodies").with(Mass, [1.0, 2.0]);
    let lent = Lent::new(vec![[0.0; 3]; 2]);
    let in_run_time = |kind| PropertyInfo::at_run_time("odd", kind, "m").unwrap();
    check(&[
        (
            built(engine().domain(one().with(Position, [1.0, 2.0]))),
            "bodies.position is a vector, but it is given as 1 number per row: give 3 numbers per row",
        ),
        (
            built(engine().domain(one().with(Ends, [1.0, 2.0]))),
            "bodies.ends is a link to 2 rows, but it is given as 1 number per row: give 2 rows of a domain for each row, `.link(..)`",
        ),
        (built(engine().domain(one().link(Mass, "bodies", [[0, 1], [1, 0]]))), "bodies.mass is given twice: keep one"),
        (
            built(engine().domain(Domain::new("b").link(Mass, "b", [[0, 1], [1, 0]]))),
            "b.mass is a scalar, but it is given as a link to 2 rows: give 1 number per row",
        ),
        (
            built(engine().domain(Domain::new("b").link(Ends, "b", [[0, 1, 0]]))),
            "b.ends is a link to 2 rows, but it is given as a link to 3 rows: give 2 rows of a domain for each row, `.link(..)`",
        ),
        (
            built(engine().domain(Domain::new("b").link(in_run_time(Kind::Link(0)), "b", [[0; 0]; 2]))),
            "b.odd links to no row: declare it as a link to at least one",
        ),
        (
            built(engine().domain(one().with(Position, Values::new(3, vec![1.0; 7])))),
            "bodies.position is a vector, but it is given as 7 numbers in all: give 3 numbers per row",
        ),
        (
            built(engine().domain(one().with(DragCoefficient, [1.0]))),
            "bodies.drag_coefficient has 1 value, but domain bodies has 2 rows, counted by mass: give one value per row",
        ),
        (
            built(engine().domain(one().rows(3))),
            "bodies.mass has 2 values, but domain bodies has 3 rows, as stated: give one value per row",
        ),
        (
            built(engine().domain(one().subset(Charge, [0], [1.0, 2.0]))),
            "bodies.charge has 2 values for a subset of 1 row: give one value per row",
        ),
        (
            built(engine().domain(one().subset(Charge, [1, 1], [1.0, 2.0]))),
            "bodies.charge: row 1 is given twice: a subset names each row once",
        ),
        (
            built(engine().domain(one().subset(Charge, [2], [1.0]))),
            "bodies.charge: row 2 is outside domain bodies, which has 2 rows, counted from 0",
        ),
        (
            built(engine().domain(Domain::new("bodies").with_unit(Mass, "m", [1.0]))),
            "bodies.mass is given in m, but it is measured in kg: give it in a unit of that dimension",
        ),
        (
            built(engine().domain(Domain::new("bodies").with_unit(Mass, "kgg", [1.0]))),
            "bodies.mass: unknown unit `kgg` in \"kgg\": did you mean `kg`?",
        ),
        (
            said(PropertyInfo::at_run_time("odd", Kind::Scalar, "kgg")),
            "odd: unknown unit `kgg` in \"kgg\": did you mean `kg`?",
        ),
        (
            built(engine().domain(Domain::new("bodies").with(Mass, [1.0, f64::NAN]))),
            "bodies.mass: row 1 is NaN: give a finite number",
        ),
        (
            said(Engine::<f32>::builder().domain(Domain::new("bodies").with(Mass, [1.0, 1e300])).build()),
            "bodies.mass: row 1 is 1e300, which is beyond f32: take f64, or a property with a larger unit",
        ),
        (built(engine().domain(one()).domain(one())), "domain bodies is given twice: keep one"),
        (
            built(engine().field(ElectricField, Uniform { value: [0.0; 3] }).field(ElectricField, Boxes::default())),
            "field electric_field is given twice: keep one",
        ),
        (
            built(engine().field(Charge, Uniform { value: [0.0; 3] })),
            "field charge is declared as a scalar, but a field gives vectors: declare the property as a vector",
        ),
        (
            built(engine().domain(one()).domain(Domain::new("springs").link(Ends, "bodys", [[0, 1]]))),
            "springs.ends links to domain bodys, which does not exist; did you mean bodies?",
        ),
        (
            built(engine().domain(one()).domain(Domain::new("springs").link(Ends, "stars", [[0, 1]]))),
            "springs.ends links to domain stars, which does not exist: add the domain",
        ),
        (
            built(engine().domain(one()).domain(Domain::new("springs").link(Ends, "bodies", [[0, 1], [1, 2]]))),
            "springs.ends: row 1 links to row 2 of bodies, which has 2 rows, counted from 0",
        ),
        (
            built(
                engine().domain(Domain::new("a").lend(Position, &lent)).domain(Domain::new("b").lend(Velocity, &lent)),
            ),
            "b.velocity is the client's own memory, which cannot be lent twice: it is lent to a.position already: lend each column memory of its own",
        ),
        (
            built(engine().domain(Domain::new("scene").lend(GravityAcceleration, &Lent::new(vec![[0.0; 3]])))),
            "scene.gravity is the client's own memory, which cannot hold a constant: it can change while laws run: give the value",
        ),
        (
            built(engine().constant(SpeedOfLight, Vec::<f64>::new())),
            "scene.speed_of_light has 0 values, but domain scene has 1 row, one value of each constant: give one value per row",
        ),
        (
            built(engine().domain(Domain::new("a").rows(1 << 40))),
            "domain a has 1099511627776 rows: at most 4294967295 can be numbered",
        ),
    ]);
}
