//! The four shapes of a body. A body is what happens to one row, one pair, one link, or to whole columns; the loop
//! around it belongs to the backends.

use super::{Declared, DeclaredColumns, Law, Shape, Sink, Source};
use crate::real::{Real, Scalar};

/// A body for one row of a domain.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no row body",
    note = "write `#[kernel] impl<R: Real> RowLaw<R> for ...`",
    note = "a law that is declared as `Name<R = f64>` is `Name<R>` there"
)]
pub trait RowLaw<R: Real>: Declared<R> {
    /// What one row gets.
    fn row(&self, row: Self::Row) -> Self::Output;
    /// The row's energy, in J, where the law knows it. Report only: no result depends on it.
    fn energy(&self, _row: Self::Row) -> R {
        R::lit(0.0)
    }
}

/// A body for one ordered pair of rows of a domain: what row `j` does to row `i`.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no pair body",
    note = "write `#[kernel] impl<R: Real> PairLaw<R> for ...`",
    note = "a law that is declared as `Name<R = f64>` is `Name<R>` there"
)]
pub trait PairLaw<R: Real>: Declared<R> {
    /// What row `j` adds to row `i`. Called for `i != j` only.
    fn pair(&self, i: Self::Row, j: Self::Row) -> Self::Output;
    /// The energy of the pair, in J, counted once for the two. Report only.
    fn energy(&self, _i: Self::Row, _j: Self::Row) -> R {
        R::lit(0.0)
    }
    /// The form of a law of inverse squares, of which [`Configure::far_field`](crate::engine::Configure::far_field) sums far rows
    /// together. It says what `pair` gives; where it does not, a far field is refused.
    fn inverse_square(&self, _row: Self::Row) -> InverseSquare<R> {
        InverseSquare { source: R::lit(0.0), response: R::lit(0.0), softening: R::lit(0.0) }
    }
}

/// How a row takes part in a law of inverse squares: row j adds `response_i source_j d / (|d|^2 + softening^2)^(3/2)` to row i, where
/// `d` is `x_j - x_i` and the softening that of all rows; the energy of the two is `-response_i source_j / (|d|^2 + softening^2)^(1/2)`.
#[derive(Clone, Copy, Debug)]
pub struct InverseSquare<R> {
    /// What it does to others.
    pub source: R,
    /// What others do to it.
    pub response: R,
    /// The softening length, in the unit of the coordinate.
    pub softening: R,
}

/// A body for one row that links to `N` rows of another domain.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no link body",
    note = "write `#[kernel] impl<R: Real> LinkLaw<R, 2> for ...`",
    note = "a law that is declared as `Name<R = f64>` is `Name<R>` there"
)]
pub trait LinkLaw<R: Real, const N: usize = 2>: Declared<R> {
    /// What the rows linked to get.
    fn link(&self, row: Self::Row, ends: [Self::End; N]) -> [Self::EndOutput; N];
    /// The energy of the link, in J. Report only.
    fn energy(&self, _row: Self::Row, _ends: [Self::End; N]) -> R {
        R::lit(0.0)
    }
}

/// An algorithm of its own over whole columns.
#[diagnostic::on_unimplemented(
    message = "`{Self}` has no column body",
    note = "write `#[kernel] impl<P: Precision> ColumnLaw<P> for ...`",
    note = "a law that is declared as `Name<R = f64>` is `Name<P>` there"
)]
pub trait ColumnLaw<P: Scalar>: DeclaredColumns {
    /// Reads and changes the columns.
    fn columns(&self, columns: <Self as DeclaredColumns>::Columns<'_, P>);
}

/// A row body for every kind of number. Implemented by `#[kernel]`.
pub trait RowFamily: Law {
    /// The body over the numbers `R`.
    type Kernel<R: Real>: RowLaw<R> + Send + Sync;
    /// Whether the body knows its energy.
    const ENERGY: bool;
    /// The body over the numbers `R`.
    fn kernel<R: Real>(&self) -> Self::Kernel<R>;
}

/// A pair body for every kind of number. Implemented by `#[kernel]`.
pub trait PairFamily: Law {
    /// The body over the numbers `R`.
    type Kernel<R: Real>: PairLaw<R> + Send + Sync;
    /// Whether the body has the form of inverse squares.
    const INVERSE_SQUARE: bool;
    /// Whether the body knows its energy.
    const ENERGY: bool;
    /// The body over the numbers `R`.
    fn kernel<R: Real>(&self) -> Self::Kernel<R>;
}

/// A link body for every kind of number. Implemented by `#[kernel]`.
pub trait LinkFamily<const N: usize>: Law {
    /// The body over the numbers `R`.
    type Kernel<R: Real>: LinkLaw<R, N> + Send + Sync;
    /// Whether the body knows its energy.
    const ENERGY: bool;
    /// The body over the numbers `R`.
    fn kernel<R: Real>(&self) -> Self::Kernel<R>;
}

/// A column body for all precisions. Implemented by `#[kernel]`.
pub trait ColumnFamily: Law {
    /// The body in precision `P`.
    type Kernel<P: Scalar>: ColumnLaw<P> + Send + Sync;
    /// The body in precision `P`.
    fn kernel<P: Scalar>(&self) -> Self::Kernel<P>;
}

/// A law as one of several in a loop that was composed at compile time. Implemented by `#[kernel]`.
pub trait Stepped: Law {
    /// The shape of the body.
    const SHAPE: Shape;
    /// Loads a row, runs the body, stores its results; nothing for a body that is no row body.
    fn step<R: Real, S: Source<R>, K: Sink<R>>(body: &Self::Body<R>, source: &S, sink: &mut K);
}
