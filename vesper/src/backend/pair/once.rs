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
use core::marker::PhantomData;
use core::ops::Range;

/// Rows of a strip within a block: those of one are each given what the others do, twice for every pair.
const STRIP: usize = 32;
/// Rows from which on looking at each pair once is faster; for Miri, which is slow, as many as make two blocks.
pub(crate) const PAYS: usize = if cfg!(miri) { SMALLEST + STRIP } else { 512 };
/// Rows of the blocks that meet: of more, those of a meeting would not stay in the first cache.
const LARGEST: usize = 512;
/// The fewest: of fewer, most of a meeting would be its beginning and its end.
const SMALLEST: usize = 128;
/// Blocks that there should be, so that threads can share a round (measured: with 16 one thread takes 1.05 times as long).
const ENOUGH: usize = 8;

/// Rows of the blocks that meet, where there are so many: these alone decide, so that the bits do not depend on the threads.
pub(crate) fn meeting_block(rows: usize) -> usize {
    (rows / ENOUGH).next_multiple_of(STRIP).clamp(SMALLEST, LARGEST)
}

/// Who meets whom, round by round: in each round every block at most once, so that threads can share a round. The first one
/// is of every block with itself; then a round-robin tournament by the circle method (Kirkman 1847).
pub(crate) fn rounds(blocks: usize) -> impl Iterator<Item = Vec<[usize; 2]>> {
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

/// Sums of all rows, of the blocks that have met.
pub(crate) struct Tally<P> {
    /// Rows of a block; the last one may have fewer.
    pub(crate) block: usize,
    /// By number that the law adds to: sums, and what rounding left of them, of all rows each, with room behind them.
    pub(crate) numbers: Vec<[*mut P; 2]>,
}

impl<P> Tally<P> {
    /// The rows of a block, where the last row that meets is before `end`.
    pub(crate) fn rows_of(&self, block: usize, end: usize) -> Range<usize> {
        block * self.block..((block + 1) * self.block).min(end)
    }
}

/// The sums of a block in one meeting, by number that the law adds to: where that of row 0 would be. They are the thread's own, so
/// that they stay in its first cache.
struct Sheet<P, F, const N: usize> {
    numbers: [*mut P; N],
    law: PhantomData<F>,
}

impl<P: Scalar, F: PairFamily, const N: usize> Sheet<P, F, N> {
    /// Takes the places from `scratch` on for rows from `first` on.
    fn new(scratch: &[*mut P], from: usize, first: usize) -> Self {
        let mut numbers = [core::ptr::null_mut(); N];
        for (to, numbers) in numbers[..Pairs::<P, F>::ADDED].iter_mut().zip(scratch) {
            *to = numbers.wrapping_add(from).wrapping_sub(first);
        }
        Sheet { numbers, law: PhantomData }
    }

    /// The sums of `R::WIDTH` rows.
    ///
    /// # Safety
    /// They are rows of the block; the same for all of these.
    #[inline(always)]
    unsafe fn sums<R: Lanes<P>>(&self, row: usize) -> Sums<R, N> {
        let mut sums = Sums::zero(Pairs::<P, F>::FIRST);
        for (sum, numbers) in sums.values[..Pairs::<P, F>::ADDED].iter_mut().zip(&self.numbers) {
            // SAFETY: passed on to the caller.
            *sum = unsafe { R::load(numbers.wrapping_add(row)) };
        }
        sums
    }

    #[inline(always)]
    unsafe fn keep<R: Lanes<P>>(&self, row: usize, sums: &Sums<R, N>) {
        for (sum, numbers) in sums.values[..Pairs::<P, F>::ADDED].iter().zip(&self.numbers) {
            // SAFETY: as above.
            unsafe { sum.store(numbers.wrapping_add(row)) };
        }
    }

    /// One row gets the sums of all lanes.
    #[inline(always)]
    unsafe fn add<R: Lanes<P>>(&self, row: usize, sums: &Sums<R, N>) {
        for (sum, numbers) in sums.values[..Pairs::<P, F>::ADDED].iter().zip(&self.numbers) {
            // SAFETY: as above.
            unsafe { *numbers.wrapping_add(row) += sum.sum() };
        }
    }
}

/// Two blocks that meet, or one alone.
pub(super) struct Meet<'a, P, F, const N: usize> {
    law: &'a F,
    call: &'a PairCall<'a, P>,
    tally: &'a Tally<P>,
    blocks: [Range<usize>; 2],
    sheets: [Sheet<P, F, N>; 2],
}

impl<'a, P: Scalar, F: PairFamily, const N: usize> Meet<'a, P, F, N> {
    /// # Safety
    /// As for [`super::PairKernel::meet`], as long as it lives. Rows that its functions are given are rows of the blocks.
    pub(super) unsafe fn new(
        law: &'a F,
        call: &'a PairCall<'a, P>,
        (tally, scratch): (&'a Tally<P>, &[*mut P]),
        blocks: [usize; 2],
    ) -> Self {
        let blocks = blocks.map(|block| tally.rows_of(block, call.rows.end));
        let sheets = [(0, &blocks[0]), (tally.block, &blocks[1])];
        let sheets = sheets.map(|(from, block)| Sheet::new(scratch, from, block.start));
        Meet { law, call, tally, blocks, sheets }
    }

    /// Each row of a strip of the first block gets what the others of it do.
    #[inline(always)]
    fn within<R: Lanes<P>>(&self, law: &F::Kernel<R>, slots: &Slots<P>, strip: Range<usize>) {
        for j in strip.clone().step_by(R::WIDTH) {
            // SAFETY: `new` was promised the rows; the same for all blocks here.
            let row_j = load::<F, R>(unsafe { Rows::<P>::new(slots, j) });
            // SAFETY: see above.
            let mut sums = unsafe { self.sheets[0].sums::<R>(j) };
            for i in strip.clone() {
                let itself = R::from_lanes(|lane| P::from_f64(lane as f64)).equal(R::lit(i as f64 - j as f64));
                // SAFETY: see above.
                let row_i = load::<F, R>(unsafe { Splat::<P>::new(slots, i) });
                sums.lose_but(itself, &share::<F, R, N>(law, row_i, row_j), Pairs::<P, F>::ADDED);
            }
            // SAFETY: see above.
            unsafe { self.sheets[0].keep(j, &sums) };
        }
    }

    /// Rows i of the first block and rows j, which are others, of that of `sheet`, meet.
    ///
    /// The two rows i are written out: the compiler does not unroll a loop over them, and would keep them in memory.
    #[inline(always)]
    fn between<R: Lanes<P>>(
        &self,
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        is: Range<usize>,
        (js, sheet): (Range<usize>, &Sheet<P, F, N>),
    ) {
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
                // SAFETY: see above.
                let mut sums = unsafe { sheet.sums::<R>(j) };
                Self::meet(law, a, row_j, &mut of_a, &mut sums);
                Self::meet(law, b, row_j, &mut of_b, &mut sums);
                // SAFETY: see above.
                unsafe { sheet.keep(j, &sums) };
                j += R::WIDTH;
            }
            // SAFETY: see above.
            unsafe {
                self.sheets[0].add(i, &of_a);
                self.sheets[0].add(i + 1, &of_b);
            }
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

    /// The blocks that are there, with their sheets: one, or two.
    #[inline(always)]
    fn there(&self) -> impl Iterator<Item = (Range<usize>, &Sheet<P, F, N>)> {
        let count = if self.blocks[0] == self.blocks[1] { 1 } else { 2 };
        self.blocks.iter().cloned().zip(&self.sheets).take(count)
    }

    /// All sums of the meeting are zero.
    #[inline(always)]
    fn begin<R: Lanes<P>>(&self) {
        for (block, sheet) in self.there() {
            for row in block.step_by(R::WIDTH) {
                // SAFETY: see above.
                unsafe { sheet.keep(row, &Sums::<R, N>::zero(Pairs::<P, F>::FIRST)) };
            }
        }
    }

    /// Whether all sums of the meeting are numbers.
    #[inline(always)]
    fn are_finite<R: Lanes<P>>(&self) -> bool {
        self.there().all(|(block, sheet)| {
            block.step_by(R::WIDTH).all(|row| {
                // SAFETY: see above.
                let sums = unsafe { sheet.sums::<R>(row) };
                sums.are_finite::<P>(Pairs::<P, F>::ADDED, R::WIDTH)
            })
        })
    }

    /// The sums of the meeting are added to those of the meetings before.
    #[inline(always)]
    fn end<R: Lanes<P>>(&self) {
        for (block, sheet) in self.there() {
            for ([sums, rests], meeting) in self.tally.numbers[..Pairs::<P, F>::ADDED].iter().zip(&sheet.numbers) {
                for row in block.clone().step_by(R::WIDTH) {
                    // SAFETY: see above.
                    unsafe {
                        let (sum, rest) = super::two_sum(R::load(sums.add(row)), R::load(meeting.wrapping_add(row)));
                        sum.store(sums.add(row));
                        (R::load(rests.add(row)) + rest).store(rests.add(row));
                    }
                }
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
        self.begin::<R>();
        if a == b {
            for start in a.clone().step_by(STRIP) {
                let strip = start..start + STRIP;
                self.within::<R>(&law, &slots, strip.clone());
                self.between::<R>(&law, &slots, strip.clone(), (strip.end..a.end, &self.sheets[0]));
            }
        } else {
            self.between::<R>(&law, &slots, a, (b, &self.sheets[1]));
        }
        if R::ESTIMATES && !self.are_finite::<R>() {
            return false;
        }
        self.end::<R>();
        true
    }
}

/// Gives rows what is their due of a tally.
pub(super) struct Give<'a, P, F> {
    pub(super) call: &'a PairCall<'a, P>,
    pub(super) tally: &'a Tally<P>,
    pub(super) law: PhantomData<F>,
}

impl<P: Scalar, F: PairFamily> WithLanes<P> for Give<'_, P, F> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        // SAFETY: the caller of `PairKernel::give` promises the slots, and the rows of the call.
        let slots = unsafe { Pairs::<P, F>::slots(self.call.slots) };
        for row in self.call.rows.clone().step_by(R::WIDTH) {
            for (k, [sums, rests]) in self.tally.numbers[..Pairs::<P, F>::ADDED].iter().enumerate() {
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
        for blocks in 0..40 {
            let mut met = vec![0; blocks * blocks];
            for round in rounds(blocks) {
                let mut busy = vec![false; blocks];
                for [a, b] in round {
                    met[a * blocks + b] += 1;
                    assert!(a <= b && !core::mem::replace(&mut busy[a], true));
                    assert!(a == b || !core::mem::replace(&mut busy[b], true));
                }
            }
            let once = |at: usize| usize::from(at / blocks <= at % blocks);
            assert!(met.iter().enumerate().all(|(at, times)| *times == once(at)), "{blocks} blocks");
        }
    }

    #[test]
    fn blocks_are_of_whole_strips() {
        for rows in (0..40_000).step_by(STRIP) {
            let block = meeting_block(rows);
            assert!(block.is_multiple_of(STRIP) && (SMALLEST..=LARGEST).contains(&block), "{rows} rows");
        }
    }
}
