//! What the macros make of a client's laws, where that takes more than one law to see.

use vesper::prelude::*;

/// A law of each shape that reads one property and pushes along x by it: names, properties and kernels come from
/// different places here.
macro_rules! pushes {
    ($row:ident, $pair:ident, $link:ident, $column:ident, $columns:ident, $property:path, $sum:ident) => {
        /// By its own value.
        #[derive(Law, Clone, Copy, Debug)]
        #[law(reads(amount: $property), adds(force: $sum))]
        struct $row<R = f64> {
            /// Per unit.
            #[law(unit = "1", default = 2.0)]
            factor: R,
        }

        #[kernel]
        impl<R: Real> RowLaw<R> for $row<R> {
            fn row(&self, row: Self::Row) -> R::Vec3 {
                R::Vec3::new(self.factor * row.amount, R::lit(0.0), R::lit(0.0))
            }
        }

        /// By the values of all others.
        #[derive(Law, Clone, Copy, Debug)]
        #[law(reads(amount: $property), adds(force: $sum))]
        struct $pair;

        #[kernel]
        impl<R: Real> PairLaw<R> for $pair {
            fn pair(&self, _i: Self::Row, j: Self::Row) -> R::Vec3 {
                R::Vec3::new(j.amount, R::lit(0.0), R::lit(0.0))
            }
        }

        /// The first end by the value of the second.
        #[derive(Law, Clone, Copy, Debug)]
        #[law(reads(stiffness: Stiffness), link(ends: Ends, reads(amount: $property), adds(force: $sum)))]
        struct $link;

        #[kernel]
        impl<R: Real> LinkLaw<R> for $link {
            fn link(&self, row: Self::Row, [_, b]: [Self::End; 2]) -> [R::Vec3; 2] {
                let push = R::Vec3::new(row.stiffness * b.amount, R::lit(0.0), R::lit(0.0));
                [push, R::Vec3::zero()]
            }
        }

        /// By the sum of all values.
        #[derive(Law, Clone, Copy, Debug)]
        #[law(reads(amount: $property), adds(force: $sum))]
        struct $column;

        #[kernel]
        impl<P: Precision> ColumnLaw<P> for $column {
            fn columns(&self, mut columns: $columns<'_, P>) {
                let rows = columns.amount.len();
                let mut sum = P::lit(0.0);
                for row in 0..rows {
                    sum += columns.amount.get(row);
                }
                for row in 0..rows {
                    columns.force.add(row, P::Vec3::new(sum, P::lit(0.0), P::lit(0.0)));
                }
            }
        }
    };
}
pushes!(ByMass, ByOtherMasses, ByLinkedMass, ByAllMasses, ByAllMassesColumns, Mass, Force);

#[test]
fn laws_made_by_a_macro_run() {
    let bodies = Domain::new("bodies").with(Mass, [1.0, 4.0]);
    let links = Domain::new("links").link(Ends, "bodies", [[0, 1]]).with(Stiffness, [10.0]);
    let builder = Engine::<f64>::builder().domain(bodies).domain(links).observe("bodies", Force).step(1.0);
    let builder = builder.law(ByMass::default().on("bodies")).law(ByOtherMasses.on("bodies"));
    let mut engine = builder.law(ByLinkedMass).law(ByAllMasses.on("bodies")).build().unwrap();
    engine.advance(1.0).unwrap();
    let force = engine.state().values("bodies", Force).unwrap();
    assert_eq!(force, [DVec3::X * (2.0 + 4.0 + 40.0 + 5.0), DVec3::X * (8.0 + 1.0 + 5.0)]);
}

/// A push with and without a declared strength.
#[derive(Law, Clone, Copy, Debug)]
#[law(reads(mass: Mass), adds(force: Force))]
struct Push<R: Real = f64> {
    /// Where to.
    #[law(unit = "N/kg", default = [1.0, 2.0, 3.0])]
    direction: R::Vec3,
    /// How strong.
    #[law(unit = "1")]
    strength: R,
}

#[kernel]
impl<R: Real> RowLaw<R> for Push<R> {
    fn row(&self, row: PushRow<R>) -> R::Vec3 {
        self.direction * (self.strength * row.mass)
    }
}

#[test]
fn parameters_that_are_not_given_have_their_defaults_or_show() {
    let none = Push::from_parameters(&[]);
    assert!(none.direction == DVec3::new(1.0, 2.0, 3.0) && none.strength.is_nan());
    let some = Push::from_parameters(&[4.0, 5.0]);
    assert!(some.direction == DVec3::new(4.0, 5.0, 3.0) && some.strength.is_nan());
    let all = Push::from_parameters(&[4.0, 5.0, 6.0, 7.0, 8.0]);
    assert!(all.direction == DVec3::new(4.0, 5.0, 6.0) && all.strength == 7.0);
}
