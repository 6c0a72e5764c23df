//! How row i sees row j. In: pointers to columns. Out: what the body of a pair law says of the two, in any lanes. Never: a loop.

use crate::backend::pointers::{Rows, Slots, Splat, Sums, first_output};
use crate::backend::within::Within;
use crate::law::{Declared, PairFamily, PairLaw, Source};
use crate::real::{Lanes, Scalar};

pub(super) type RowOf<F, R> = <<F as PairFamily>::Kernel<R> as Declared<R>>::Row;

/// What a loop asks of a pair.
pub(super) trait Sight<P: Scalar, F: PairFamily>: Copy {
    /// What is kept of the rows i of the lanes.
    type Own<R: Lanes<P>>: Copy;
    /// The rows i of the lanes.
    ///
    /// # Safety
    /// They are rows of the slots, or room behind the last one.
    unsafe fn own<R: Lanes<P>>(self, slots: &Slots<P>, i: usize) -> Self::Own<R>;
    /// What row j does to the rows of the lanes.
    ///
    /// # Safety
    /// It is a row of the slots.
    unsafe fn share<R: Lanes<P>, const N: usize>(
        self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        own: &Self::Own<R>,
        j: usize,
    ) -> Sums<R, N>;
}

/// Rows as they stand in their columns.
#[derive(Clone, Copy)]
pub(super) struct Plain;

impl<P: Scalar, F: PairFamily> Sight<P, F> for Plain {
    type Own<R: Lanes<P>> = RowOf<F, R>;
    #[inline(always)]
    unsafe fn own<R: Lanes<P>>(self, slots: &Slots<P>, i: usize) -> RowOf<F, R> {
        // SAFETY: the caller promises the rows.
        load::<F, R>(unsafe { Rows::<P>::new(slots, i) })
    }
    #[inline(always)]
    unsafe fn share<R: Lanes<P>, const N: usize>(
        self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        own: &RowOf<F, R>,
        j: usize,
    ) -> Sums<R, N> {
        // SAFETY: the caller promises the row.
        share::<F, R, N>(law, *own, load::<F, R>(unsafe { Splat::<P>::new(slots, j) }))
    }
}

/// The row that a source gives.
#[inline(always)]
pub(super) fn load<F: PairFamily, R: crate::real::Real>(source: impl Source<R>) -> RowOf<F, R> {
    <F::Kernel<R> as Declared<R>>::load(&Within::<_, F>::new(source))
}

/// What the body gives for two rows.
#[inline(always)]
pub(super) fn share<F: PairFamily, R: crate::real::Real, const N: usize>(
    law: &F::Kernel<R>,
    i: RowOf<F, R>,
    j: RowOf<F, R>,
) -> Sums<R, N> {
    let mut share = Sums::nothing(const { first_output(F::SIGNATURE.ports) });
    <F::Kernel<R> as Declared<R>>::store(law.pair(i, j), &mut share);
    share
}
