//! The loop of a pair law: rows i in lanes, row j the same in all of them, the sums of i in registers.
//!
//! Every i has one owner and takes its j in the order of the rows, so the bits do not depend on the width of the lanes
//! or on the number of threads.

use super::pointers::{
    MAX_SLOTS, Rows, RowsMut, SUMS, Slots, Splat, StoreAll, StoreFirst, Sums, first_output, slot_count, slots_at,
};
use super::tangent::{self, TangentCall};
use super::within::Within;
use super::{Compiled, Kernel};
use crate::law::{Declared, PairFamily, PairLaw, Place, Signature};
use crate::real::{Isa, Lanes, Scalar, WithLanes};
use core::ops::Range;

/// One call of a pair kernel.
pub(crate) struct PairCall<'a, P> {
    /// A pointer for every component: to the first row, or to the one number of a constant, or null.
    pub(crate) slots: &'a [*mut P],
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
    /// Every slot is null where its port is absent, or points to `rows` numbers (one for a constant) that are valid;
    /// nobody else touches rows `from..to` of what the law adds to.
    unsafe fn run(&self, isa: Isa, call: &PairCall<'_, P>);
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
        kernel: Kernel::Pair(Box::new(law.clone())),
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
        P::with_lanes(isa, unsafe { Task::new(self, call) });
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

struct Task<'a, P, F> {
    law: &'a F,
    call: &'a PairCall<'a, P>,
}

impl<P: Scalar, F: PairFamily> Task<'_, P, F> {
    const FIRST: usize = first_output(F::SIGNATURE.ports);
    const ADDED: usize = added(&F::SIGNATURE);
    const COUNT: usize = slot_count(F::SIGNATURE.ports);
    const CONSTANTS: u64 = slots_at(F::SIGNATURE.ports, Place::Scene);

    /// # Safety
    /// As for [`PairKernel::run`], as long as it lives. Rows that its functions are given are rows of the call.
    unsafe fn new<'a>(law: &'a F, call: &'a PairCall<'a, P>) -> Task<'a, P, F> {
        Task { law, call }
    }

    /// # Safety
    /// As for [`PairKernel::run`].
    #[inline(always)]
    unsafe fn slots(call: &PairCall<'_, P>) -> Slots<P> {
        // SAFETY: passed on to the caller.
        unsafe { Slots::copied(call.slots, Self::COUNT, Self::CONSTANTS, 0) }
    }

    /// What all other rows do to the rows of one set of lanes.
    #[inline(always)]
    fn sum<R: Lanes<P>>(law: &F::Kernel<R>, slots: &Slots<P>, i: usize, (rows, first): (usize, bool)) {
        // SAFETY: `Task::new` was promised the rows; the same for all blocks here.
        let source = Within::<_, F>::new(unsafe { Rows::<P>::new(slots, i) });
        let row_i = <F::Kernel<R> as Declared<R>>::load(&source);
        let mut sums = Sums::zero(Self::FIRST);
        Self::sum_others(law, slots, row_i, &mut sums, 0..i);
        Self::sum_own(law, slots, row_i, &mut sums, i..i + R::WIDTH);
        Self::sum_others(law, slots, row_i, &mut sums, i + R::WIDTH..rows);
        Self::give(slots, i, &sums, first);
    }

    /// Adds sums to the columns of their rows, or begins the columns with them.
    #[inline(always)]
    fn give<R: Lanes<P>>(slots: &Slots<P>, i: usize, sums: &Sums<R>, first: bool) {
        let sums = sums.values[..Self::ADDED].iter().enumerate();
        if first {
            // SAFETY: see above.
            let mut sink = unsafe { RowsMut::<P, R, StoreFirst>::new(slots, i, R::lit(0.0)) };
            sums.for_each(|(k, sum)| crate::law::Sink::add(&mut sink, Self::FIRST + k, *sum));
        } else {
            // SAFETY: see above.
            let mut sink = unsafe { RowsMut::<P, R, StoreAll>::new(slots, i, R::lit(0.0)) };
            sums.for_each(|(k, sum)| crate::law::Sink::add(&mut sink, Self::FIRST + k, *sum));
        }
    }

    /// What row j does to the rows of the lanes.
    #[inline(always)]
    fn share<R: Lanes<P>>(law: &F::Kernel<R>, slots: &Slots<P>, row_i: RowOf<F, R>, j: usize) -> Sums<R> {
        // SAFETY: see above.
        let row_j = <F::Kernel<R> as Declared<R>>::load(&Within::<_, F>::new(unsafe { Splat::new(slots, j) }));
        let mut share = Sums::zero(Self::FIRST);
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
            let share = Self::share(law, slots, row_i, j);
            for (sum, share) in sums.values[..Self::ADDED].iter_mut().zip(share.values) {
                *sum += share;
            }
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
        let lane = R::from_lanes(|lane| P::from_f64(lane as f64));
        for (index, j) in own.enumerate() {
            let itself = lane.equal(R::lit(index as f64));
            let share = Self::share(law, slots, row_i, j);
            for (sum, share) in sums.values[..Self::ADDED].iter_mut().zip(share.values) {
                *sum = R::select(itself, *sum, *sum + share);
            }
        }
    }
}

impl<P: Scalar, F: PairFamily> WithLanes<P> for Task<'_, P, F> {
    type Output = ();
    #[inline(always)]
    fn with<R: Lanes<P>>(self) {
        // SAFETY: `Task::new` was promised the slots.
        let slots = unsafe { Self::slots(self.call) };
        let mut i = self.call.from;
        if R::WIDTH > 1 && i + R::WIDTH <= self.call.to {
            let law = self.law.kernel::<R>();
            while i + R::WIDTH <= self.call.to {
                Self::sum::<R>(&law, &slots, i, (self.call.rows, self.call.first));
                i += R::WIDTH;
            }
        }
        let law = self.law.kernel::<P>();
        while i < self.call.to {
            Self::sum_one(&law, &slots, i, (self.call.rows, self.call.first));
            i += 1;
        }
    }
}

impl<P: Scalar, F: PairFamily> Task<'_, P, F> {
    /// The same for one row that no lanes are left for; the body is not called for the row itself.
    #[inline(always)]
    fn sum_one(law: &F::Kernel<P>, slots: &Slots<P>, i: usize, (rows, first): (usize, bool)) {
        // SAFETY: `Task::new` was promised the rows; the same for all blocks here.
        let source = Within::<_, F>::new(unsafe { Rows::<P>::new(slots, i) });
        let row_i = <F::Kernel<P> as Declared<P>>::load(&source);
        let mut sums = Sums::zero(Self::FIRST);
        for j in (0..i).chain(i + 1..rows) {
            // SAFETY: see above.
            let row_j = <F::Kernel<P> as Declared<P>>::load(&Within::<_, F>::new(unsafe { Rows::<P>::new(slots, j) }));
            <F::Kernel<P> as Declared<P>>::store(law.pair(row_i, row_j), &mut sums);
        }
        Self::give(slots, i, &sums, first);
    }
}
