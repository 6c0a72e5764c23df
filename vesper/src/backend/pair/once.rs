//! The loop that looks at each pair once: what row j adds to row i is taken from row j.
//!
//! In: a call, blocks of rows that meet. Out: sums of these rows. Never: two calls at once that share a row.
//!
//! Two rows i are each the same in all lanes, rows j in lanes; the sums of j wait in the first cache. Every row gets its sums
//! block by block in an order that the number of rows alone decides ([`rounds`]), so the bits do not depend on the number of
//! threads. They do depend on the width of lanes, in which the sums of i are taken: laws that allow `estimates` only.

use super::sight::{RowOf, load, share};
use super::{PairCall, Pairs};
use crate::backend::pointers::{Rows, RowsMut, SUMS, Slots, Splat, StoreAll, StoreFirst, Sums};
use crate::law::{PairFamily, Sink};
use crate::real::{Lanes, Scalar, WithLanes};
use core::ops::Range;

/// Rows that meet at a time.
pub(crate) const BLOCK: usize = 512;
/// Rows of a strip within a block: those of one are each given what the others do, twice for every pair.
const STRIP: usize = 64;
/// Rows from which on looking at each pair once is faster.
pub(crate) const PAYS: usize = BLOCK;

/// Who meets whom, round by round: in each round every block at most once, so that threads can share a round. The first one
/// is of every block with itself; then a round-robin tournament by the circle method (Kirkman 1847).
pub(crate) fn rounds(rows: usize) -> impl Iterator<Item = Vec<[usize; 2]>> {
    let blocks = rows.div_ceil(BLOCK);
    // An odd number gets one more, whose opponent rests.
    let players = blocks.next_multiple_of(2);
    let alone = (0..blocks).map(|block| [block, block]).collect();
    core::iter::once(alone).chain((1..players).map(move |round| {
        let circle = players - 1;
        let pairs = (0..players / 2).map(move |k| match k {
            0 => [round - 1, circle],
            k => [(round - 1 + k) % circle, (round - 1 + circle - k) % circle],
        });
        pairs.filter(|pair| pair.iter().all(|block| *block < blocks)).map(|[a, b]| [a.min(b), a.max(b)]).collect()
    }))
}

/// The rows of a block.
fn rows_of(block: usize, rows: usize) -> Range<usize> {
    block * BLOCK..((block + 1) * BLOCK).min(rows)
}

/// Sums of all rows: of the blocks that have met, what rounding left of them, and of the two that meet.
pub(crate) struct Tally<P> {
    /// By number that the law adds to: sums, rests, and sums of the meeting, of all rows each, with room behind them.
    pub(crate) numbers: Vec<[*mut P; 3]>,
}

/// Two blocks that meet, or one alone.
pub(super) struct Meet<'a, P, F, const N: usize> {
    law: &'a F,
    call: &'a PairCall<'a, P>,
    tally: &'a Tally<P>,
    /// The sums of the meeting, by number that the law adds to: copied, so that no store can be thought to change them.
    meeting: [*mut P; N],
    blocks: [Range<usize>; 2],
}

impl<'a, P: Scalar, F: PairFamily, const N: usize> Meet<'a, P, F, N> {
    /// # Safety
    /// As for [`super::PairKernel::meet`], as long as it lives. Rows that its functions are given are rows of the blocks.
    pub(super) unsafe fn new(law: &'a F, call: &'a PairCall<'a, P>, tally: &'a Tally<P>, blocks: [usize; 2]) -> Self {
        let mut meeting = [core::ptr::null_mut(); N];
        for (to, numbers) in meeting[..Pairs::<P, F>::ADDED].iter_mut().zip(&tally.numbers) {
            *to = numbers[2];
        }
        Meet { law, call, tally, meeting, blocks: blocks.map(|block| rows_of(block, call.rows.end)) }
    }

    /// The sums of the meeting of `R::WIDTH` rows.
    #[inline(always)]
    fn sums<R: Lanes<P>>(&self, row: usize) -> Sums<R, N> {
        let mut sums = Sums::zero(Pairs::<P, F>::FIRST);
        for (sum, meeting) in sums.values[..Pairs::<P, F>::ADDED].iter_mut().zip(&self.meeting) {
            // SAFETY: `new` was promised the rows; the same for all blocks here.
            *sum = unsafe { R::load(meeting.add(row)) };
        }
        sums
    }

    #[inline(always)]
    fn keep<R: Lanes<P>>(&self, row: usize, sums: &Sums<R, N>) {
        for (sum, meeting) in sums.values[..Pairs::<P, F>::ADDED].iter().zip(&self.meeting) {
            // SAFETY: see above.
            unsafe { sum.store(meeting.add(row)) };
        }
    }

    /// Each row of a strip gets what the others of it do.
    #[inline(always)]
    fn within<R: Lanes<P>>(&self, law: &F::Kernel<R>, slots: &Slots<P>, strip: Range<usize>) {
        for j in strip.clone().step_by(R::WIDTH) {
            // SAFETY: see above.
            let row_j = load::<F, R>(unsafe { Rows::<P>::new(slots, j) });
            let mut sums = self.sums::<R>(j);
            for i in strip.clone() {
                let itself = R::from_lanes(|lane| P::from_f64(lane as f64)).equal(R::lit(i as f64 - j as f64));
                // SAFETY: see above.
                let row_i = load::<F, R>(unsafe { Splat::<P>::new(slots, i) });
                sums.lose_but(itself, &share::<F, R, N>(law, row_i, row_j), Pairs::<P, F>::ADDED);
            }
            self.keep(j, &sums);
        }
    }

    /// Rows i and rows j, which are others, meet.
    ///
    /// The two rows i are written out: the compiler does not unroll a loop over them, and would keep them in memory.
    #[inline(always)]
    fn between<R: Lanes<P>>(&self, law: &F::Kernel<R>, slots: &Slots<P>, is: Range<usize>, js: Range<usize>) {
        // SAFETY: see above.
        let row_i = |i| load::<F, R>(unsafe { Splat::<P>::new(slots, i) });
        for i in is.step_by(2) {
            let (a, b) = (row_i(i), row_i(i + 1));
            let zero = Sums::<R, N>::zero(Pairs::<P, F>::FIRST);
            let (mut of_a, mut of_b) = (zero, zero);
            let mut j = js.start;
            while j < js.end {
                // SAFETY: see above.
                let row_j = load::<F, R>(unsafe { Rows::<P>::new(slots, j) });
                let mut sums = self.sums::<R>(j);
                Self::meet(law, a, row_j, &mut of_a, &mut sums);
                Self::meet(law, b, row_j, &mut of_b, &mut sums);
                self.keep(j, &sums);
                j += R::WIDTH;
            }
            self.end_of_row(i, &of_a);
            self.end_of_row(i + 1, &of_b);
        }
    }

    #[inline(always)]
    fn meet<R: Lanes<P>>(
        law: &F::Kernel<R>,
        row_i: RowOf<F, R>,
        row_j: RowOf<F, R>,
        of_i: &mut Sums<R, N>,
        of_j: &mut Sums<R, N>,
    ) {
        let share = share::<F, R, N>(law, row_i, row_j);
        of_i.take(&share, Pairs::<P, F>::ADDED);
        of_j.lose(&share, Pairs::<P, F>::ADDED);
    }

    #[inline(always)]
    fn end_of_row<R: Lanes<P>>(&self, i: usize, sums: &Sums<R, N>) {
        for (sum, meeting) in sums.values[..Pairs::<P, F>::ADDED].iter().zip(&self.meeting) {
            // SAFETY: see above.
            unsafe { *meeting.add(i) += sum.sum() };
        }
    }

    /// Whether the sums of the meeting of a block are numbers.
    #[inline(always)]
    fn are_finite<R: Lanes<P>>(&self, block: &Range<usize>) -> bool {
        let mut row = block.start;
        while row < block.end {
            if !self.sums::<R>(row).are_finite::<P>(Pairs::<P, F>::ADDED, R::WIDTH) {
                return false;
            }
            row += R::WIDTH;
        }
        true
    }

    /// The sums of the meeting of a block are zero.
    #[inline(always)]
    fn begin<R: Lanes<P>>(&self, block: &Range<usize>) {
        let mut row = block.start;
        while row < block.end {
            self.keep(row, &Sums::<R, N>::zero(Pairs::<P, F>::FIRST));
            row += R::WIDTH;
        }
    }

    /// The sums of the meeting of a block are added to those of the meetings before.
    #[inline(always)]
    fn end<R: Lanes<P>>(&self, block: &Range<usize>) {
        for [sums, rests, meeting] in &self.tally.numbers[..Pairs::<P, F>::ADDED] {
            let mut row = block.start;
            while row < block.end {
                // SAFETY: see above.
                unsafe {
                    let (sum, rest) = super::two_sum(R::load(sums.add(row)), R::load(meeting.add(row)));
                    sum.store(sums.add(row));
                    (R::load(rests.add(row)) + rest).store(rests.add(row));
                }
                row += R::WIDTH;
            }
        }
    }
}

impl<P: Scalar, F: PairFamily, const N: usize> WithLanes<P> for Meet<'_, P, F, N> {
    /// Whether all sums are numbers; else nothing is added.
    type Output = bool;
    #[inline(always)]
    fn with<R: Lanes<P>>(self) -> bool {
        // SAFETY: `new` was promised the slots.
        let slots = unsafe { Pairs::<P, F>::slots(self.call.slots) };
        let law = self.law.kernel::<R>();
        let [a, b] = self.blocks.clone();
        self.begin::<R>(&a);
        if a == b {
            for start in a.clone().step_by(STRIP) {
                let strip = start..start + STRIP;
                self.within::<R>(&law, &slots, strip.clone());
                self.between::<R>(&law, &slots, strip.clone(), strip.end..a.end);
            }
        } else {
            self.begin::<R>(&b);
            self.between::<R>(&law, &slots, a.clone(), b.clone());
        }
        if R::ESTIMATES && !(self.are_finite::<R>(&a) && self.are_finite::<R>(&b)) {
            return false;
        }
        self.end::<R>(&a);
        if a != b {
            self.end::<R>(&b);
        }
        true
    }
}

/// Gives rows what is their due of a tally.
pub(super) struct Give<'a, P, F> {
    pub(super) call: &'a PairCall<'a, P>,
    pub(super) tally: &'a Tally<P>,
    pub(super) law: core::marker::PhantomData<F>,
}

impl<P: Scalar, F: PairFamily> WithLanes<P> for Give<'_, P, F> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        // SAFETY: the caller of `PairKernel::give` promises the slots, and the rows of the call.
        let slots = unsafe { Pairs::<P, F>::slots(self.call.slots) };
        for row in self.call.rows.clone().step_by(R::WIDTH) {
            for (k, [sums, rests, _]) in self.tally.numbers[..Pairs::<P, F>::ADDED].iter().enumerate() {
                // SAFETY: as above.
                unsafe {
                    let (sum, rest) = (R::load(sums.add(row)), R::load(rests.add(row)));
                    R::lit(0.0).store(sums.add(row));
                    R::lit(0.0).store(rests.add(row));
                    let slot = Pairs::<P, F>::FIRST + k;
                    if self.call.first {
                        RowsMut::<P, R, StoreFirst>::new(&slots, row, R::lit(0.0)).add(slot, sum + rest);
                    } else {
                        RowsMut::<P, R, StoreAll>::new(&slots, row, R::lit(0.0)).add(slot, sum + rest);
                    }
                }
            }
        }
    }
}

/// Rows that are looked at.
const LOOKED_AT: usize = 4;
/// Roundings that two results may differ by.
const ROUNDINGS: f64 = 1e3;

/// Whether row j loses what row i gets, in all pairs of the first rows.
///
/// # Safety
/// As for [`super::PairKernel::run`].
pub(super) unsafe fn is_antisymmetric<P: Scalar, F: PairFamily>(law: &F, call: &PairCall<'_, P>) -> bool {
    // SAFETY: passed on to the caller.
    let slots = unsafe { Pairs::<P, F>::slots(call.slots) };
    let law = law.kernel::<P>();
    let rows = call.others.end.min(LOOKED_AT);
    // SAFETY: as above.
    let row = |row| load::<F, P>(unsafe { Rows::<P>::new(&slots, row) });
    (0..rows).all(|i| {
        (i + 1..rows).all(|j| {
            let [got, lost] = [(i, j), (j, i)].map(|(i, j)| share::<F, P, SUMS>(&law, row(i), row(j)).values);
            super::agree(&got.map(Scalar::to_f64), &lost.map(|lost| -lost.to_f64()), ROUNDINGS * P::EPSILON)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_two_blocks_meet_once_and_in_one_round_none_meets_two() {
        for rows in (0..40 * BLOCK).step_by(STRIP) {
            let blocks = rows.div_ceil(BLOCK);
            let mut met = vec![0; blocks * blocks];
            for round in rounds(rows) {
                let mut busy = vec![false; blocks];
                for [a, b] in round {
                    met[a * blocks + b] += 1;
                    assert!(a <= b && !core::mem::replace(&mut busy[a], true));
                    assert!(a == b || !core::mem::replace(&mut busy[b], true));
                }
            }
            let once = |at: usize| usize::from(at / blocks <= at % blocks);
            assert!(met.iter().enumerate().all(|(at, times)| *times == once(at)), "{rows} rows");
        }
    }
}
