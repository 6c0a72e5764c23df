//! The loop that gives each row what all others do to it: rows i in lanes, row j the same in all of them, the sums of i in
//! registers.
//!
//! In: a call. Out: sums in their columns. Never: a sum that two calls share.
//!
//! Every i has one owner and takes its j in the order of the rows, tile by tile, so the bits do not depend on the width of the
//! lanes or on the number of threads.

use super::sight::Sight;
use super::{PairCall, Pairs};
use crate::backend::pointers::{RateRule, RowsMut, Slots, StoreAll, StoreFirst, Sums};
use crate::law::{PairFamily, Sink};
use crate::real::{Lanes, Real, Scalar, WithLanes};
use core::ops::Range;

/// Rows j whose shares are summed before that sum is added to those of the tiles before. In f32 smaller ones do not make the
/// error smaller, and larger ones do not make the loop faster.
pub(super) const TILE: usize = 256;

/// The work of one call, by one way to see rows.
pub(super) struct Each<'a, P, F, S, const N: usize> {
    law: &'a F,
    call: &'a PairCall<'a, P>,
    sight: S,
}

/// Sums of tiles, with what rounding leaves of every addition (Knuth, The Art of Computer Programming 2, 4.2.2, theorem B), so
/// that the error does not grow with the number of tiles.
#[derive(Clone, Copy)]
pub(super) struct Tiles<R, const N: usize> {
    sums: [R; N],
    rests: [R; N],
}

impl<R: Real, const N: usize> Tiles<R, N> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Tiles { sums: [R::lit(0.0); N], rests: [R::lit(0.0); N] }
    }

    #[inline(always)]
    pub(super) fn take(&mut self, tile: &Sums<R, N>, count: usize) {
        for k in 0..count {
            let (sum, rest) = super::two_sum(self.sums[k], tile.values[k]);
            self.sums[k] = sum;
            self.rests[k] += rest;
        }
    }

    #[inline(always)]
    pub(super) fn sum(&self, to: &mut Sums<R, N>, count: usize) {
        for k in 0..count {
            to.values[k] = self.sums[k] + self.rests[k];
        }
    }
}

impl<'a, P: Scalar, F: PairFamily, S: Sight<P, F>, const N: usize> Each<'a, P, F, S, N> {
    /// # Safety
    /// As for [`super::PairKernel::run`], as long as it lives. Rows that its functions are given are rows of the call.
    pub(super) unsafe fn new(law: &'a F, call: &'a PairCall<'a, P>, sight: S) -> Self {
        Each { law, call, sight }
    }

    /// What all others do to `count` rows, in `B` sets of lanes, of which only the last one may not be full. False where an
    /// estimate has no number to give: then nothing is stored.
    #[inline(always)]
    fn block<R: Lanes<P>, const B: usize>(&self, law: &F::Kernel<R>, slots: &Slots<P>, i: usize, count: usize) -> bool {
        // SAFETY: `new` was promised the rows; the same for all blocks here.
        let mut own = [unsafe { self.sight.own::<R>(slots, i) }; B];
        for (set, own) in own.iter_mut().enumerate().skip(1) {
            // SAFETY: see above.
            *own = unsafe { self.sight.own::<R>(slots, i + set * R::WIDTH) };
        }
        let Range { start, end } = self.call.others.clone();
        let mut tiles = [Tiles::<R, N>::zero(); B];
        let mut from = start;
        loop {
            let to = end.min(from + TILE);
            let mut sums = self.tile::<R, B>(law, slots, &own, i..i + count, from..to);
            if from > start {
                for (tiles, sums) in tiles.iter_mut().zip(&sums) {
                    tiles.take(sums, Pairs::<P, F>::ADDED);
                }
            } else if to < end {
                for (tiles, sums) in tiles.iter_mut().zip(&sums) {
                    tiles.sums = sums.values;
                }
            }
            if to == end {
                if from > start {
                    for (sums, tiles) in sums.iter_mut().zip(&tiles) {
                        tiles.sum(sums, Pairs::<P, F>::ADDED);
                    }
                }
                return self.give(slots, (i, count), &sums);
            }
            from = to;
        }
    }

    /// What some others do to the rows.
    #[inline(always)]
    fn tile<R: Lanes<P>, const B: usize>(
        &self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        own: &[S::Own<R>; B],
        rows: Range<usize>,
        others: Range<usize>,
    ) -> [Sums<R, N>; B] {
        let mut sums = [Sums::<R, N>::zero(Pairs::<P, F>::FIRST); B];
        let (first, last) = (rows.start.clamp(others.start, others.end), rows.end.clamp(others.start, others.end));
        for j in others.start..first {
            self.shares(law, slots, own, &mut sums, j);
        }
        if R::WIDTH > 1 || B > 1 {
            for j in first..last {
                self.shares_but_its_own(law, slots, own, &mut sums, (rows.start, j));
            }
        }
        for j in last..others.end {
            self.shares(law, slots, own, &mut sums, j);
        }
        sums
    }

    #[inline(always)]
    fn shares<R: Lanes<P>, const B: usize>(
        &self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        own: &[S::Own<R>; B],
        sums: &mut [Sums<R, N>; B],
        j: usize,
    ) {
        for (own, sums) in own.iter().zip(sums) {
            // SAFETY: see above.
            sums.take(&unsafe { self.sight.share(law, slots, own, j) }, Pairs::<P, F>::ADDED);
        }
    }

    /// The same, where row j is one of the rows of the lanes: the sum of that lane stays as it is.
    #[inline(always)]
    fn shares_but_its_own<R: Lanes<P>, const B: usize>(
        &self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        own: &[S::Own<R>; B],
        sums: &mut [Sums<R, N>; B],
        (i, j): (usize, usize),
    ) {
        for (set, (own, sums)) in own.iter().zip(sums).enumerate() {
            let behind = j as f64 - (i + set * R::WIDTH) as f64;
            let itself = R::from_lanes(|lane| P::from_f64(lane as f64)).equal(R::lit(behind));
            // SAFETY: see above.
            sums.take_but(itself, &unsafe { self.sight.share(law, slots, own, j) }, Pairs::<P, F>::ADDED);
        }
    }

    /// Adds sums to the columns of the rows of the lanes, or begins the columns with them.
    #[inline(always)]
    fn give<R: Lanes<P>, const B: usize>(
        &self,
        slots: &Slots<P>,
        (i, count): (usize, usize),
        sums: &[Sums<R, N>; B],
    ) -> bool {
        for (set, sums) in sums.iter().enumerate() {
            let there = count - set * R::WIDTH;
            if R::ESTIMATES && !sums.are_finite::<P>(Pairs::<P, F>::ADDED, there) {
                return false;
            }
        }
        for (set, sums) in sums.iter().enumerate() {
            if self.call.first {
                Self::give_by::<R, StoreFirst>(slots, i + set * R::WIDTH, sums);
            } else {
                Self::give_by::<R, StoreAll>(slots, i + set * R::WIDTH, sums);
            }
        }
        true
    }

    #[inline(always)]
    fn give_by<R: Lanes<P>, Rule: RateRule>(slots: &Slots<P>, i: usize, sums: &Sums<R, N>) {
        for (k, sum) in sums.values[..Pairs::<P, F>::ADDED].iter().enumerate() {
            // SAFETY: `new` was promised the rows.
            unsafe { RowsMut::<P, R, Rule>::new(slots, i, R::lit(0.0)) }.add(Pairs::<P, F>::FIRST + k, *sum);
        }
    }

    /// Blocks of `B` sets of lanes from row i on, as many as are full; the first row that none has. An error is the block that
    /// estimates gave no numbers for.
    #[inline(always)]
    fn blocks<R: Lanes<P>, const B: usize>(
        &self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        mut i: usize,
    ) -> Result<usize, Range<usize>> {
        let count = B * R::WIDTH;
        while self.call.rows.end - i >= count {
            if !self.block::<R, B>(law, slots, i, count) {
                return Err(i..i + count);
            }
            i += count;
        }
        Ok(i)
    }
}

impl<P: Scalar, F: PairFamily, S: Sight<P, F>, const N: usize> WithLanes<P> for Each<'_, P, F, S, N> {
    /// The rows that estimates gave no numbers for, where the work ended.
    type Output = Option<Range<usize>>;
    #[inline(always)]
    fn with<R: Lanes<P>>(self) -> Option<Range<usize>> {
        // SAFETY: `new` was promised the slots.
        let slots = unsafe { Pairs::<P, F>::slots(self.call.slots) };
        let Range { start: mut i, end: to } = self.call.rows;
        let narrow = <R::Narrow as Lanes<P>>::WIDTH;
        if R::WIDTH > 1 && to - i > narrow {
            let law = self.law.kernel::<R>();
            // Row j is loaded once for two sets of lanes, where that counts beside roots and divisions.
            if R::ESTIMATES {
                match self.blocks::<R, 2>(&law, &slots, i) {
                    Ok(left) => i = left,
                    Err(rows) => return Some(rows),
                }
            }
            // Lanes that are half empty are still faster than narrower ones, twice.
            while to - i > narrow {
                let count = R::WIDTH.min(to - i);
                if !self.block::<R, 1>(&law, &slots, i, count) {
                    return Some(i..i + count);
                }
                i += count;
            }
        }
        if narrow > 1 && to - i > 1 {
            let done = self.block::<R::Narrow, 1>(&self.law.kernel::<R::Narrow>(), &slots, i, to - i);
            return (!done).then_some(i..to);
        }
        let law = self.law.kernel::<P>();
        while i < to {
            self.block::<P, 1>(&law, &slots, i, 1);
            i += 1;
        }
        None
    }
}
