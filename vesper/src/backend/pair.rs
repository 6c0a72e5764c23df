//! The loop of a pair law: rows i in lanes, row j the same in all of them, the sums of i in registers.
//!
//! Every i has one owner and takes its j in the order of the rows, so the bits do not depend on the width of the lanes
//! or on the number of threads.

use super::apart::{self, Apart, coordinate_slots};
use super::pointers::{
    MAX_SLOTS, RateRule, Rows, RowsMut, SUMS, Slots, Splat, StoreAll, StoreFirst, Sums, first_output, slot_count,
    slots_at,
};
use super::tangent::{self, TangentCall};
use super::within::Within;
use super::{Compiled, Kernel};
use crate::law::{Declared, PairFamily, PairLaw, Place, Signature, Sink};
use crate::real::{Isa, Lanes, Scalar, WithLanes};
use core::ops::Range;
use std::sync::Arc;

/// One call of a pair kernel.
pub(crate) struct PairCall<'a, P> {
    /// A pointer for every component: to the first row, or to the one number of a constant, or null.
    pub(crate) slots: &'a [*mut P],
    /// By slot, what rounding added to each row's coordinate, or null; or none at all.
    pub(crate) rests: &'a [*mut P],
    /// All rows: the j of every pair.
    pub(crate) rows: usize,
    /// The rows i that this call sums for.
    pub(crate) from: usize,
    pub(crate) to: usize,
    /// Whether the sums begin with this law: its shares are stored, whatever is there.
    pub(crate) first: bool,
}

/// A pair law with its loop.
pub(crate) trait PairKernel<P>: Send + Sync {
    /// # Safety
    /// Every slot is null where its port is absent, or points to `rows` numbers (one for a constant) that are valid, with
    /// room behind them ([`crate::column::whole`]), and so do rests, as many as slots or none; nobody else touches rows `from..to`
    /// of what the law adds to, or that room. Only the last call ends between multiples of the lanes.
    unsafe fn run(&self, isa: Isa, call: &PairCall<'_, P>);
    /// Whether the law gives the same where it is told differences of coordinates only, as it says.
    ///
    /// # Safety
    /// As for `run`.
    unsafe fn is_invariant(&self, call: &PairCall<'_, P>) -> bool;
    /// Runs the body over dual numbers.
    ///
    /// # Safety
    /// The call keeps its promises.
    unsafe fn tangent(&self, call: &TangentCall<'_, P>);
    /// The energy of all pairs, where the law knows it.
    ///
    /// # Safety
    /// As for `run`.
    unsafe fn energy(&self, call: &PairCall<'_, P>) -> Option<f64>;
}

/// Makes the loop of a pair law.
pub fn pair<P: Scalar, F: PairFamily>(law: &F) -> Compiled<P> {
    const { assert!(added(&F::SIGNATURE) <= SUMS, "a pair law adds to at most 12 numbers") };
    Compiled {
        signature: F::SIGNATURE,
        energy: F::ENERGY,
        parameters: law.parameters(),
        kernel: Kernel::Pair(Arc::new(law.clone())),
    }
}

const fn added(signature: &Signature) -> usize {
    let slots = slot_count(signature.ports);
    assert!(slots <= MAX_SLOTS, "a law touches at most 64 numbers");
    slots - first_output(signature.ports)
}

impl<P: Scalar, F: PairFamily> PairKernel<P> for F {
    unsafe fn run(&self, isa: Isa, call: &PairCall<'_, P>) {
        // SAFETY: the caller promises the same.
        let task = unsafe { Task::new(self, call) };
        if const { F::SIGNATURE.translation_invariant && coordinate_slots(F::SIGNATURE.ports) != 0 }
            && !call.rests.is_empty()
        {
            return P::with_lanes(isa, Apart(task));
        }
        P::with_lanes(isa, task);
    }

    unsafe fn is_invariant(&self, call: &PairCall<'_, P>) -> bool {
        if const { !F::SIGNATURE.translation_invariant } || call.rests.is_empty() {
            return true;
        }
        // SAFETY: the caller promises the same.
        unsafe { apart::is_invariant(self, call) }
    }

    unsafe fn tangent(&self, call: &TangentCall<'_, P>) {
        // SAFETY: the caller promises the same.
        unsafe { tangent::pairs(self, call) }
    }

    unsafe fn energy(&self, call: &PairCall<'_, P>) -> Option<f64> {
        if !F::ENERGY {
            return None;
        }
        // SAFETY: the caller promises the slots.
        let slots = unsafe { Task::<P, F>::slots(call) };
        let law = self.kernel::<P>();
        // SAFETY: the caller promises the rows.
        let load =
            |row| unsafe { <F::Kernel<P> as Declared<P>>::load(&Within::<_, F>::new(Rows::<P>::new(&slots, row))) };
        let mut energy = 0.0;
        for i in 0..call.rows {
            let row = load(i);
            for j in i + 1..call.rows {
                energy += law.energy(row, load(j)).to_f64();
            }
        }
        Some(energy)
    }
}

type RowOf<F, R> = <<F as PairFamily>::Kernel<R> as Declared<R>>::Row;

pub(super) struct Task<'a, P, F> {
    pub(super) law: &'a F,
    pub(super) call: &'a PairCall<'a, P>,
}

impl<P: Scalar, F: PairFamily> Task<'_, P, F> {
    pub(super) const FIRST: usize = first_output(F::SIGNATURE.ports);
    pub(super) const ADDED: usize = added(&F::SIGNATURE);
    pub(super) const COUNT: usize = slot_count(F::SIGNATURE.ports);
    const CONSTANTS: u64 = slots_at(F::SIGNATURE.ports, Place::Scene);

    /// # Safety
    /// As for [`PairKernel::run`], as long as it lives. Rows that its functions are given are rows of the call.
    pub(super) unsafe fn new<'a>(law: &'a F, call: &'a PairCall<'a, P>) -> Task<'a, P, F> {
        Task { law, call }
    }

    /// # Safety
    /// As for [`PairKernel::run`].
    #[inline(always)]
    pub(super) unsafe fn slots(call: &PairCall<'_, P>) -> Slots<P> {
        // SAFETY: passed on to the caller.
        unsafe { Slots::copied(call.slots, Self::COUNT, Self::CONSTANTS, 0) }
    }

    /// What all other rows do to `count` rows, at most as many as there are lanes.
    #[inline(always)]
    fn sum<R: Lanes<P>>(&self, law: &F::Kernel<R>, slots: &Slots<P>, i: usize, count: usize) {
        // SAFETY: `Task::new` was promised the rows; the same for all blocks here.
        let source = Within::<_, F>::new(unsafe { Rows::<P>::new(slots, i) });
        let row_i = <F::Kernel<R> as Declared<R>>::load(&source);
        let mut sums = Sums::zero(Self::FIRST);
        Self::sum_others(law, slots, row_i, &mut sums, 0..i);
        Self::sum_own(law, slots, row_i, &mut sums, i..i + count);
        Self::sum_others(law, slots, row_i, &mut sums, i + count..self.call.rows);
        self.give(slots, i, &sums);
    }

    /// Adds sums to the columns of the rows of the lanes, or begins the columns with them.
    #[inline(always)]
    pub(super) fn give<R: Lanes<P>>(&self, slots: &Slots<P>, i: usize, sums: &Sums<R>) {
        if self.call.first {
            Self::give_by::<R, StoreFirst>(slots, i, sums);
        } else {
            Self::give_by::<R, StoreAll>(slots, i, sums);
        }
    }

    #[inline(always)]
    fn give_by<R: Lanes<P>, Rule: RateRule>(slots: &Slots<P>, i: usize, sums: &Sums<R>) {
        for (k, sum) in sums.values[..Self::ADDED].iter().enumerate() {
            // SAFETY: `Task::new` was promised the rows.
            unsafe { RowsMut::<P, R, Rule>::new(slots, i, R::lit(0.0)) }.add(Self::FIRST + k, *sum);
        }
    }

    /// What row j does to the rows of the lanes.
    #[inline(always)]
    fn share<R: Lanes<P>>(law: &F::Kernel<R>, slots: &Slots<P>, row_i: RowOf<F, R>, j: usize) -> Sums<R> {
        // SAFETY: see above.
        let row_j = <F::Kernel<R> as Declared<R>>::load(&Within::<_, F>::new(unsafe { Splat::new(slots, j) }));
        let mut share = Sums::nothing(Self::FIRST);
        <F::Kernel<R> as Declared<R>>::store(law.pair(row_i, row_j), &mut share);
        share
    }

    #[inline(always)]
    fn sum_others<R: Lanes<P>>(
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        row_i: RowOf<F, R>,
        sums: &mut Sums<R>,
        others: Range<usize>,
    ) {
        for j in others {
            sums.take(&Self::share(law, slots, row_i, j), Self::ADDED);
        }
    }

    /// What the rows of the lanes do to each other: in one lane i is j, and that lane's sum stays as it is.
    #[inline(always)]
    fn sum_own<R: Lanes<P>>(
        law: &F::Kernel<R>,
        slots: &Slots<P>,
        row_i: RowOf<F, R>,
        sums: &mut Sums<R>,
        own: Range<usize>,
    ) {
        // How far the row of each lane is behind row j.
        let mut behind = R::from_lanes(|lane| P::from_f64(lane as f64));
        for j in own {
            let itself = behind.equal(R::lit(0.0));
            behind -= R::lit(1.0);
            sums.take_but(itself, &Self::share(law, slots, row_i, j), Self::ADDED);
        }
    }
}

impl<P: Scalar, F: PairFamily> WithLanes<P> for Task<'_, P, F> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        // SAFETY: `Task::new` was promised the slots.
        let slots = unsafe { Self::slots(self.call) };
        let (mut i, to) = (self.call.from, self.call.to);
        if R::WIDTH > 1 && to - i > <R::Narrow as Lanes<P>>::WIDTH {
            let law = self.law.kernel::<R>();
            // Lanes that are half empty are still faster than narrower ones, twice.
            while to - i > <R::Narrow as Lanes<P>>::WIDTH {
                let count = R::WIDTH.min(to - i);
                self.sum::<R>(&law, &slots, i, count);
                i += count;
            }
        }
        if <R::Narrow as Lanes<P>>::WIDTH > 1 && to - i > 1 {
            self.sum::<R::Narrow>(&self.law.kernel::<R::Narrow>(), &slots, i, to - i);
            return;
        }
        let law = self.law.kernel::<P>();
        while i < to {
            self.sum_one(&law, &slots, i);
            i += 1;
        }
    }
}

impl<P: Scalar, F: PairFamily> Task<'_, P, F> {
    /// The same for one row alone; the body is not called for the row itself.
    #[inline(always)]
    fn sum_one(&self, law: &F::Kernel<P>, slots: &Slots<P>, i: usize) {
        // SAFETY: `Task::new` was promised the rows; the same for all blocks here.
        let source = Within::<_, F>::new(unsafe { Rows::<P>::new(slots, i) });
        let row_i = <F::Kernel<P> as Declared<P>>::load(&source);
        let mut sums = Sums::zero(Self::FIRST);
        for j in (0..i).chain(i + 1..self.call.rows) {
            // SAFETY: see above.
            let row_j = <F::Kernel<P> as Declared<P>>::load(&Within::<_, F>::new(unsafe { Rows::<P>::new(slots, j) }));
            <F::Kernel<P> as Declared<P>>::store(law.pair(row_i, row_j), &mut sums);
        }
        self.give(slots, i, &sums);
    }
}
