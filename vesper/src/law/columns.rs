//! Whole columns, for a law that has an algorithm of its own.
//!
//! Values are read and written row by row through raw pointers, because a column may be the client's interleaved
//! memory, and because a law may look at a column that it amends.

use crate::property::{Numeric, Property, ValueOf};
use crate::real::Scalar;
use core::marker::PhantomData;

/// Says which columns a column law gets. Implemented by `#[derive(Law)]`.
pub trait DeclaredColumns {
    /// The columns, a field for each.
    type Columns<'a, P: Scalar>;
    /// The columns from their places.
    ///
    /// # Safety
    /// `access` was made for this law's signature.
    unsafe fn columns<'a, P: Scalar>(access: &ColumnAccess<'a, P>) -> Self::Columns<'a, P>;
}

/// Where one port's values are: component `c` of row `i` at `components[c] + i * stride`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PortView<P> {
    pub(crate) components: [*mut P; 4],
    pub(crate) stride: usize,
    pub(crate) rows: usize,
}

/// Where all ports of a law are. Backends make it, the derive takes it apart.
#[derive(Debug)]
pub struct ColumnAccess<'a, P> {
    ports: &'a [PortView<P>],
    link: Option<(&'a [u32], usize)>,
}

impl<'a, P: Scalar> ColumnAccess<'a, P> {
    /// # Safety
    /// Every view's components point to `rows` numbers at its stride (1 row where the port is a constant), valid and
    /// not touched by others for `'a`; views of ports that only read may overlap one that writes.
    pub(crate) unsafe fn new(ports: &'a [PortView<P>], link: Option<(&'a [u32], usize)>) -> Self {
        ColumnAccess { ports, link }
    }

    /// Where the ports are, in declared order.
    pub(crate) fn ports(&self) -> &'a [PortView<P>] {
        self.ports
    }

    /// The values of a port.
    ///
    /// # Panics
    /// The port's property is of another kind.
    pub fn slice<Q: Property<Kind: Numeric>>(&self, port: usize) -> Slice<'a, Q, P> {
        Slice { view: self.view::<Q>(port), marker: PhantomData }
    }

    /// The values of a port, where there are any.
    pub fn optional_slice<Q: Property<Kind: Numeric>>(&self, port: usize) -> Option<Slice<'a, Q, P>> {
        (!self.ports[port].components[0].is_null()).then(|| self.slice(port))
    }

    /// The values of a port, to change.
    ///
    /// # Panics
    /// The port's property is of another kind.
    pub fn slice_mut<Q: Property<Kind: Numeric>>(&self, port: usize) -> SliceMut<'a, Q, P> {
        SliceMut { view: self.view::<Q>(port), marker: PhantomData }
    }

    fn view<Q: Property<Kind: Numeric>>(&self, port: usize) -> PortView<P> {
        let view = self.ports[port];
        let there = view.components.iter().take_while(|component| !component.is_null()).count();
        assert!(view.rows == 0 || there >= Q::INFO.kind.width(), "port {port} is no {}", Q::NAME);
        view
    }

    /// A constant of the scene.
    pub fn constant<Q: Property<Kind: Numeric>>(&self, port: usize) -> ValueOf<Q, P> {
        value::<Q, P>(&self.view::<Q>(port), 0)
    }

    /// A constant of the scene, where there is one.
    pub fn optional_constant<Q: Property<Kind: Numeric>>(&self, port: usize) -> Option<ValueOf<Q, P>> {
        (!self.ports[port].components[0].is_null()).then(|| self.constant::<Q>(port))
    }

    /// The rows that each row links to.
    pub fn link(&self) -> LinkSlice<'a> {
        let (rows, arity) = self.link.unwrap_or((&[], 1));
        LinkSlice { rows, arity }
    }
}

fn value<Q: Property<Kind: Numeric>, P: Scalar>(view: &PortView<P>, row: usize) -> ValueOf<Q, P> {
    assert!(row < view.rows, "row {row} of {}, which has {}", Q::NAME, view.rows);
    // SAFETY: `ColumnAccess::new` was promised `rows` numbers for each component, and the row is one of them.
    <Q::Kind as Numeric>::from_components(|c: usize| unsafe { *view.components[c].add(row * view.stride) })
}

/// The values of property `Q` of all rows.
#[derive(Clone, Copy, Debug)]
pub struct Slice<'a, Q, P> {
    view: PortView<P>,
    marker: PhantomData<(&'a [P], Q)>,
}

impl<Q: Property<Kind: Numeric>, P: Scalar> Slice<'_, Q, P> {
    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.view.rows
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The value of one row.
    ///
    /// # Panics
    /// There is no such row.
    #[inline]
    pub fn get(&self, row: usize) -> ValueOf<Q, P> {
        value::<Q, P>(&self.view, row)
    }
}

/// The values of property `Q` of all rows, to change.
#[derive(Debug)]
pub struct SliceMut<'a, Q, P> {
    view: PortView<P>,
    marker: PhantomData<(&'a mut [P], Q)>,
}

impl<Q: Property<Kind: Numeric>, P: Scalar> SliceMut<'_, Q, P> {
    /// How many rows there are.
    pub fn len(&self) -> usize {
        self.view.rows
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Gives one row a value.
    ///
    /// # Panics
    /// There is no such row.
    #[inline]
    pub fn set(&mut self, row: usize, value: ValueOf<Q, P>) {
        assert!(row < self.view.rows, "row {row} of {}, which has {}", Q::NAME, self.view.rows);
        let view = self.view;
        // SAFETY: `ColumnAccess::new` was promised `rows` numbers for each component, and the row is one of them.
        <Q::Kind as Numeric>::each_component(value, |c: usize, number| unsafe {
            *view.components[c].add(row * view.stride) = number;
        });
    }

    /// Adds to the value of one row.
    ///
    /// # Panics
    /// There is no such row.
    #[inline]
    pub fn add(&mut self, row: usize, share: ValueOf<Q, P>) {
        assert!(row < self.view.rows, "row {row} of {}, which has {}", Q::NAME, self.view.rows);
        let view = self.view;
        // SAFETY: as in `set`.
        <Q::Kind as Numeric>::each_component(share, |c: usize, number| unsafe {
            *view.components[c].add(row * view.stride) += number;
        });
    }
}

/// The rows that each row of a link domain links to.
#[derive(Clone, Copy, Debug)]
pub struct LinkSlice<'a> {
    rows: &'a [u32],
    arity: usize,
}

impl LinkSlice<'_> {
    /// How many links there are.
    pub fn len(&self) -> usize {
        self.rows.len() / self.arity
    }

    /// Whether there is no link.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The rows of one link.
    ///
    /// # Panics
    /// There is no such link.
    pub fn get(&self, link: usize) -> &[u32] {
        &self.rows[link * self.arity..][..self.arity]
    }
}
