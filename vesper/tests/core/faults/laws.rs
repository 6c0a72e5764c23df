//! Mistakes in a list of laws.

use super::*;

#[test]
fn mistakes_in_a_list_of_laws() {
    let heat = || Domain::new("rods").with(Temperature, [1.0]).with(Cooling, [1.0]);
    let plain = PropertyInfo::new("force", Kind::Vector, "N");
    let pounds = PropertyInfo::new("mass", Kind::Scalar, "g");
    let wide = (0..22).fold(DynLaw::new("wide"), |law, k| {
        law.reads(PropertyInfo::at_run_time(&format!("p{k}"), Kind::Vector, "m").unwrap())
    });
    check(&[
        (
            built(moving().law(set("a", Mass, Trace)).law(set("b", Mass, Trace))),
            "a and b both set bodies.trace: keep one; several laws may add, one may set",
        ),
        (
            built(moving().law(DynLaw::new("push").reads(Mass).rates(Velocity).body(|_, _| {}))),
            "motion and push both give the rate of bodies.velocity: keep one",
        ),
        (
            built(moving().law(set("rigid", Mass, Velocity))),
            "motion gives the rate of bodies.velocity, which rigid sets: a state belongs to the integrator, so keep one of the two laws\nrigid sets bodies.velocity, which the client gives: take the column away, or switch rigid off",
        ),
        (
            built(
                engine()
                    .domain(bodies().with(Force, [[0.0; 3]; 3]))
                    .law(DynLaw::new("rush").reads(Mass).rates(Force).body(|_, _| {}))
                    .law(Weight),
            ),
            "rush gives the rate of bodies.force, which weight adds to: a state belongs to the integrator, so keep one of the two laws\nweight adds to bodies.force, which the client gives: take the column away, or switch weight off",
        ),
        (
            built(engine().domain(bodies()).law(set("heavy", Velocity, Mass))),
            "heavy sets bodies.mass, which the client gives: take the column away, or switch heavy off",
        ),
        (
            built(moving().law(DynLaw::new("bump").reads(Mass).adds(Velocity).body(|_, _| {}))),
            "bump adds to velocity, which is no sum: declare the property with `sum`, or set it",
        ),
        (
            built(moving().law(set("a", Trace, Colour)).law(set("b", Colour, Trace))),
            "the laws close a circle: a sets bodies.colour, which b reads, b sets bodies.trace, which a reads: let one of them read the value before, `reads(previous ...)`",
        ),
        (
            built(moving().law(DynLaw::new("grow").reads(Force).adds(Force).body(|_, _| {}))),
            "the laws close a circle: grow adds to bodies.force, which grow reads: let one of them read the value before, `reads(previous ...)`",
        ),
        (
            built(moving().law(Weight.label("motion"))),
            "motion is given twice on domain bodies: keep one, or give each a label of its own, `.label(\"...\")`",
        ),
        (
            built(moving().law(DynLaw::new("twice").sets(Trace).sets(Trace).body(|_, _| {}))),
            "twice declares two outputs of bodies.trace: keep one",
        ),
        (
            built(moving().law(Weight).law(Weight)),
            "weight is given twice on domain bodies: keep one, or give each a label of its own, `.label(\"...\")`",
        ),
        (
            built(moving().domain(Domain::new("stars").with(Mass, [1.0])).law(Weight)),
            "weight can stand on bodies or stars: say on which, `.on(\"bodies\")`",
        ),
        (
            built(moving().law(Weight.on("bodeis"))),
            "weight stands on domain bodeis, which does not exist; did you mean bodies?",
        ),
        (built(moving().law(Weight.every(0))), "weight is to be evaluated every 0 steps: give at least 1"),
        (
            built(engine().domain(bodies()).law(Motion.every(2))),
            "motion is evaluated every 2 steps, but it gives the rate of position: only a law that only adds can be held between steps",
        ),
        (
            built(engine().domain(heat()).law(Cool)),
            "leapfrog needs every state to be a coordinate or a momentum, but rods.temperature is neither: take runge_kutta_4",
        ),
        (
            built(moving().law(DynLaw::new("lift").reads(Mass).adds(plain).body(|_, _| {}))),
            "lift adds to force, which is no sum: declare the property with `sum`, or set it\nproperty force is declared as vector [N], a sum from external_force by law motion and as vector [N], without a role by law lift: declare it alike, or rename one of them",
        ),
        (
            built(moving().law(DynLaw::new("lift").reads(pounds).adds(Force).body(|_, _| {}))),
            "property mass is declared as scalar [kg] by law motion and as scalar [g] by law lift: declare it alike, or rename one of them",
        ),
        (
            built(engine().domain(Domain::new("bodies").with(pounds, [1.0])).law(Weight)),
            "property mass is declared as scalar [kg] by law weight and as scalar [g] by domain bodies: declare it alike, or rename one of them",
        ),
        (
            built(moving().law(Hoard)),
            "hoard adds to force and reads its previous value, which is gone when the sum begins anew: let one law set a property of its own from it, and another one add that",
        ),
        (
            built(moving().law(wide.adds(Force).body(|_, _| {}))),
            "wide touches 69 numbers of a row: 64 are possible, split it into several laws",
        ),
        (
            built(moving().domain(springs(3)).law(DynLaw::new("count").reads(Ends).sets(Stiffness).body(|_, _| {}))),
            "count reads ends, but it is a row law: a link is followed by a link law or a column law, `link(..)`\ncount sets springs.stiffness, which the client gives: take the column away, or switch count off",
        ),
        (
            built(moving().law(DynLaw::new("glow").field(Charge).adds(Force).body(|_, _| {}))),
            "field charge is declared as a scalar, but a field gives vectors: declare the property as a vector",
        ),
        (
            built(moving().observe("bodies", WindVelocity)),
            "bodies has no property wind_velocity: give it as a column, or observe it where a law computes it",
        ),
        (built(moving().observe("bodie", Force)), "domain bodie does not exist; did you mean bodies?"),
        (built(moving().require("moton")), "no law moton; did you mean motion?"),
        (
            built(engine().domain(bodies().subset(Charge, [1], [1.0])).law(Charged)),
            "charged cannot use charge, which only 1 of 3 rows have: a column law gets whole columns, so give all rows a value",
        ),
        (
            built(moving().domain(springs(3)).law(Spring).law(Hinge)),
            "hinge sets trace, but it is a pair law: it may only add; write a row law or a column law",
        ),
        (
            built(
                engine()
                    .domain(bodies().subset(Charge, [0, 2], [1.0; 2]))
                    .law(set("polish", Charge, Trace))
                    .observe("bodies", Trace),
            ),
            "polish sets trace for all rows, but reads charge, which only 2 of 3 rows have: give the others a value",
        ),
        (
            built(
                engine()
                    .domain(bodies().subset(WindVelocity, [0], [[1.0; 3]]).with(DragCoefficient, [1.0; 3]))
                    .law(Drag)
                    .law(Motion),
            ),
            "drag cannot use wind_velocity, which only 1 of 3 rows have: it is optional, so give it to all rows, or to none",
        ),
        (
            built(engine().domain(bodies().subset(ExternalForce, [0], [[1.0; 3]])).law(Motion)),
            "bodies.force starts from external_force, which only 1 of 3 rows have: give all rows a value, 0 where there is none",
        ),
        (
            built(
                engine()
                    .domain(Domain::new("bodies").rows(3).subset(Position, [0], [[1.0; 3]]))
                    .domain(springs(3))
                    .law(Spring)
                    .observe("bodies", Force),
            ),
            "spring cannot use position, which only 1 of 3 rows have: any row may be linked to, so give all of them a value",
        ),
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

/// Adds to a sum that it looks back at.
#[derive(Law, Clone, Copy, Debug)]
#[law(domain = "bodies", reads(previous before: Force), adds(force: Force))]
struct Hoard;

#[kernel]
impl<R: Real> RowLaw<R> for Hoard {
    fn row(&self, row: HoardRow<R>) -> R::Vec3 {
        row.before
    }
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
