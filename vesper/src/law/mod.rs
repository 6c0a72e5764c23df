//! What a law is: a declaration and a body.
//!
//! In: structs with `#[derive(Law)]`. Out: [`Signature`], the declaration as data; the four shapes of a body
//! ([`RowLaw`], [`PairLaw`], [`LinkLaw`], [`ColumnLaw`]); and the traits by which the derive says how a body's values
//! are loaded and stored. Never: a loop over rows, an order of laws.

mod access;
mod columns;
mod dynamic;
mod shape;
mod signature;

pub use access::{Declared, Sink, Source, read, read_optional, slots, write};
pub(crate) use columns::PortView;
pub use columns::{ColumnAccess, DeclaredColumns, LinkSlice, Slice, SliceMut};
pub(crate) use dynamic::DynBody;
pub use dynamic::{DynLaw, DynLawBuilder, DynRow, DynWhole};
pub use shape::{
    ColumnFamily, ColumnLaw, InverseSquare, LinkFamily, LinkLaw, PairFamily, PairLaw, RowFamily, RowLaw, Stepped,
};
pub use signature::{Mode, Parameter, Part, Place, Port, Shape, Signature};

use crate::real::Real;

/// Numbers of a row that one law may touch.
pub(crate) const MAX_SLOTS: usize = 64;

/// A law of physics. Implemented by `#[derive(Law)]`; the body is one of the four shapes, under `#[kernel]`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a law",
    note = "declare it: `#[derive(Law, Clone)] #[law(reads(..), adds(..))] struct {Self}`"
)]
pub trait Law: Clone + Send + Sync + Sized + 'static {
    /// What the law touches, and its parameters.
    const SIGNATURE: Signature;
    /// The same law with its parameters in the numbers `R`.
    type Body<R: Real>: Declared<R>;
    /// The law with its parameters in the numbers `R`.
    fn body<R: Real>(&self) -> Self::Body<R>;
    /// The law from its parameters' components, in declared order; missing ones have their defaults, or are NaN.
    fn from_parameters(values: &[f64]) -> Self;
    /// Its parameters' components, in declared order.
    fn parameters(&self) -> Vec<f64>;
}
