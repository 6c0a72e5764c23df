//! What a client gives of one kind of thing: a name, and columns of values.
//!
//! In: arrays, units, links, borrowed memory. Out: [`Domain`], plain data that a state is made from and checked
//! against. Never: a check: everything wrong is found at once, when the state is made.

use crate::column::{Lent, LentMemory, Values};
use crate::dimension::Unit;
use crate::property::{Property, PropertyInfo, intern};
use crate::real::Scalar;
use std::sync::Arc;

/// The name of the domain with one row that holds the constants and the time.
pub const SCENE: &str = "scene";

/// Anything that names a property: a property type's value (`Position`), or a [`PropertyInfo`] made at run time.
pub trait AsProperty {
    /// The property as data.
    fn info(&self) -> PropertyInfo;
}

impl<Q: Property> AsProperty for Q {
    fn info(&self) -> PropertyInfo {
        Q::INFO
    }
}

impl AsProperty for PropertyInfo {
    fn info(&self) -> PropertyInfo {
        *self
    }
}

/// One column as given.
#[derive(Clone, Debug)]
pub(crate) struct Given<P: Scalar> {
    pub(crate) info: PropertyInfo,
    /// The unit of the values; `None` where they are in the property's own.
    pub(crate) unit: Option<&'static str>,
    pub(crate) subset: Option<Vec<u32>>,
    pub(crate) values: GivenValues<P>,
}

impl<P: Scalar> Given<P> {
    /// From the unit of the values to the property's own; `None` where that cannot be.
    pub(crate) fn factor(&self) -> Option<f64> {
        self.unit.map_or(Some(1.0), |unit| Unit::parse(unit).ok()?.factor_to(self.info.size))
    }
}

#[derive(Clone, Debug)]
pub(crate) enum GivenValues<P: Scalar> {
    Numbers(Values),
    Lent(Arc<dyn LentMemory<P>>),
    Links { target: String, arity: usize, rows: Vec<u32> },
}

/// A set of rows and their columns, as the client gives them.
///
/// ```
/// use vesper::prelude::*;
/// let bodies = Domain::<f64>::new("bodies")
///     .with(Position, [[-10.0, 5.0, 0.0], [10.0, 5.0, 0.0]])
///     .with_unit(Velocity, "km/s", [[0.0, 0.0, 0.0], [0.0, 0.01, 0.0]])
///     .with(Mass, [1.0, 1.0])
///     .subset(Charge, [1], [0.02]);
/// let springs = Domain::<f64>::new("springs").link(Ends, "bodies", [[0, 1]]).with(Stiffness, [100.0]);
/// ```
#[derive(Clone, Debug)]
pub struct Domain<P: Scalar> {
    pub(crate) name: String,
    pub(crate) rows: Option<usize>,
    pub(crate) columns: Vec<Given<P>>,
}

impl<P: Scalar> Domain<P> {
    /// A domain of this name; its number of rows is that of its columns.
    pub fn new(name: &str) -> Self {
        Domain { name: name.to_owned(), rows: None, columns: Vec::new() }
    }

    /// States the number of rows, where no column has a value for every row.
    #[must_use]
    pub fn rows(mut self, rows: usize) -> Self {
        self.rows = Some(rows);
        self
    }

    /// A column with a value for every row, in the property's own unit.
    #[must_use]
    pub fn with(self, property: impl AsProperty, values: impl Into<Values>) -> Self {
        self.column(property.info(), None, None, GivenValues::Numbers(values.into()))
    }

    /// A column in another unit of the same dimension; it is converted on entry.
    #[must_use]
    pub fn with_unit(self, property: impl AsProperty, unit: &str, values: impl Into<Values>) -> Self {
        self.column(property.info(), Some(intern(unit)), None, GivenValues::Numbers(values.into()))
    }

    /// A column with values for some rows only.
    #[must_use]
    pub fn subset(
        self,
        property: impl AsProperty,
        rows: impl IntoIterator<Item = u32>,
        values: impl Into<Values>,
    ) -> Self {
        let rows = rows.into_iter().collect();
        self.column(property.info(), None, Some(rows), GivenValues::Numbers(values.into()))
    }

    /// A column in the client's own memory, used in place.
    #[must_use]
    pub fn lend<const N: usize>(self, property: impl AsProperty, memory: &Lent<P, N>) -> Self {
        self.column(property.info(), None, None, GivenValues::Lent(Arc::new(memory.clone())))
    }

    /// A link: for every row, rows of the domain `target`.
    #[must_use]
    pub fn link<const N: usize>(
        self,
        property: impl AsProperty,
        target: &str,
        rows: impl IntoIterator<Item = [u32; N]>,
    ) -> Self {
        let rows: Vec<u32> = rows.into_iter().flatten().collect();
        self.column(property.info(), None, None, GivenValues::Links { target: target.to_owned(), arity: N, rows })
    }

    /// A column of a scene file: any unit, any subset.
    #[must_use]
    pub fn with_column(
        self,
        property: PropertyInfo,
        unit: Option<&str>,
        subset: Option<Vec<u32>>,
        values: Values,
    ) -> Self {
        self.column(property, unit.map(intern), subset, GivenValues::Numbers(values))
    }

    /// A link of a scene file, whose arity is known at run time: for every row, as many rows of the domain `target` as
    /// the property's kind says, one after the other.
    #[must_use]
    pub fn with_link(self, property: PropertyInfo, target: &str, rows: Vec<u32>) -> Self {
        let arity = property.kind.width();
        self.column(property, None, None, GivenValues::Links { target: target.to_owned(), arity, rows })
    }

    fn column(
        mut self,
        info: PropertyInfo,
        unit: Option<&'static str>,
        subset: Option<Vec<u32>>,
        values: GivenValues<P>,
    ) -> Self {
        self.columns.push(Given { info, unit, subset, values });
        self
    }
}
