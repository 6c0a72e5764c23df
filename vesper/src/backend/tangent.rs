//! The loops of derivatives: a law's body, unchanged, over dual numbers, one row, pair or link at a time.
//!
//! In: where the numbers of every component are, and where those of their derivatives along one direction. Out: the values
//! that a law adds and sets, with the derivatives of all that it gives; of rates the derivatives only. Never lanes: these
//! loops are made once for each law and precision, so that laws which nobody differentiates cost no time to compile.

use super::pair::{box_slot, distance_slot, images};
use super::pointers::{SUMS, Sums, first_output, slots_at};
use super::within::Within;
use crate::law::{Declared, LinkFamily, LinkLaw, PairFamily, PairLaw, Place, RowFamily, RowLaw, Sink, Source};
use crate::real::{Dual, Scalar};

/// Numbers of a component: that of row `i` is `stride` times `i` behind the first one, or times the i-th of an index.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach<P> {
    /// Null where there are none.
    pub(crate) start: *mut P,
    pub(crate) stride: usize,
    /// Null where rows are counted as they are.
    pub(crate) index: *const u32,
}

impl<P> Reach<P> {
    /// No numbers.
    pub(crate) const NONE: Self = Reach { start: core::ptr::null_mut(), stride: 0, index: core::ptr::null() };

    /// Where the number of a row is.
    ///
    /// # Safety
    /// There are numbers, and the row has one.
    #[inline(always)]
    pub(crate) unsafe fn at(self, row: usize) -> *mut P {
        // SAFETY: passed on to the caller.
        unsafe {
            let row = if self.index.is_null() { row } else { *self.index.add(row) as usize };
            self.start.add(row * self.stride)
        }
    }
}

/// Where the numbers of a component are, and those of their derivatives: null where they do not change.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DualReach<P> {
    pub(crate) value: Reach<P>,
    pub(crate) derivative: Reach<P>,
}

impl<P: Scalar> DualReach<P> {
    /// The number of a row; NaN where there is none, so that a dependency which was not declared shows.
    ///
    /// # Safety
    /// The row has a number, where there are any.
    #[inline(always)]
    pub(crate) unsafe fn load(self, row: usize) -> Dual<P> {
        if self.value.start.is_null() {
            return Dual::constant(P::from_f64(f64::NAN));
        }
        // SAFETY: passed on to the caller.
        unsafe {
            let derivative = if self.derivative.start.is_null() { P::default() } else { *self.derivative.at(row) };
            Dual::new(*self.value.at(row), derivative)
        }
    }

    /// Writes the number of a row, and its derivative, as far as there are places for them.
    ///
    /// # Safety
    /// The row has a number, where there are any, and nobody else touches it.
    #[inline(always)]
    pub(crate) unsafe fn store(self, row: usize, number: Dual<P>) {
        // SAFETY: passed on to the caller.
        unsafe {
            if !self.value.start.is_null() {
                *self.value.at(row) = number.value;
            }
            if !self.derivative.start.is_null() {
                *self.derivative.at(row) = number.derivative;
            }
        }
    }
}

/// One call of a loop of derivatives. Whoever makes one promises: every slot has a number for each of the rows, or none for
/// any; ends are rows of the target domain; nobody else touches what is written.
pub(crate) struct TangentCall<'a, P> {
    /// Where every component is: of rows, of the rows linked to, or one constant.
    pub(crate) slots: &'a [DualReach<P>],
    /// Rows, or links.
    pub(crate) rows: usize,
    /// The rows linked to.
    pub(crate) ends: &'a [u32],
}

/// One row, or one row linked to.
struct Row<'a, P> {
    slots: &'a [DualReach<P>],
    row: usize,
    /// The slots of rows linked to, one bit each, and the one linked to.
    ends: u64,
    end: usize,
}

impl<P: Scalar> Row<'_, P> {
    #[inline(always)]
    fn number(&self, slot: usize) -> Dual<P> {
        let row = if self.ends >> slot & 1 == 1 { self.end } else { self.row };
        // SAFETY: whoever makes a row has a call that has it.
        unsafe { self.slots[slot].load(row) }
    }
}

impl<P: Scalar> Source<Dual<P>> for Row<'_, P> {
    #[inline(always)]
    fn wants(&self, _port: usize) -> bool {
        true
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        !self.slots[slot].value.start.is_null()
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> Dual<P> {
        self.number(slot)
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> Dual<P> {
        self.number(slot)
    }
}

/// One row, to write.
struct RowMut<'a, P> {
    slots: &'a [DualReach<P>],
    row: usize,
}

impl<P: Scalar> Sink<Dual<P>> for RowMut<'_, P> {
    #[inline(always)]
    fn set(&mut self, slot: usize, value: Dual<P>) {
        // SAFETY: whoever makes a row has a call that has it.
        unsafe { self.slots[slot].store(self.row, value) };
    }
    #[inline(always)]
    fn add(&mut self, slot: usize, value: Dual<P>) {
        let to = self.slots[slot];
        // SAFETY: as above.
        unsafe { to.store(self.row, to.load(self.row) + value) };
    }
    #[inline(always)]
    fn turn(&mut self, _slot: usize, _value: Dual<P>) {
        // Nobody asks for its derivative: the force has it already.
    }
    #[inline(always)]
    fn rate(&mut self, _coordinate: bool, slot: usize, value: Dual<P>) {
        self.set(slot, value);
    }
}

/// The loop over rows.
///
/// # Safety
/// The call keeps its promises.
pub(super) unsafe fn rows<P: Scalar, F: RowFamily>(law: &F, call: &TangentCall<'_, P>) {
    let law = law.kernel::<Dual<P>>();
    let slots = call.slots;
    for row in 0..call.rows {
        let source = Within::<_, F>::new(Row { slots, row, ends: 0, end: 0 });
        let output = law.row(<F::Kernel<Dual<P>> as Declared<Dual<P>>>::load(&source));
        <F::Kernel<Dual<P>> as Declared<Dual<P>>>::store(output, &mut Within::<_, F>::new(RowMut { slots, row }));
    }
}

/// The loop over pairs: each row sums what all others do to it.
///
/// # Safety
/// The call keeps its promises.
pub(super) unsafe fn pairs<P: Scalar, F: PairFamily>(law: &F, call: &TangentCall<'_, P>) {
    if let Some(cutoff) = F::SIGNATURE.cutoff {
        // SAFETY: passed on to the caller.
        return unsafe { near_pairs(law, call, law.parameters()[cutoff]) };
    }
    let law = law.kernel::<Dual<P>>();
    let slots = call.slots;
    let load = |row| load::<P, F>(Row { slots, row, ends: 0, end: 0 });
    // Loaded once: each row meets all others.
    let all: Vec<_> = (0..call.rows).map(load).collect();
    for (i, row) in all.iter().enumerate() {
        let mut sums = Sums::<Dual<P>, SUMS>::zero(first_output(F::SIGNATURE.ports));
        for other in all[..i].iter().chain(&all[i + 1..]) {
            take::<P, F>(&mut sums, law.pair(*row, *other));
        }
        give::<P, F>(slots, i, &sums);
    }
}

/// The same for a law that ends at a distance: with all images of a row that are within it.
///
/// # Safety
/// The call keeps its promises.
unsafe fn near_pairs<P: Scalar, F: PairFamily>(law: &F, call: &TangentCall<'_, P>, cutoff: f64) {
    let law = law.kernel::<Dual<P>>();
    let slots = call.slots;
    let first = distance_slot(F::SIGNATURE.ports).unwrap_or_default();
    let number = |slot: usize, row: usize| {
        // SAFETY: the caller promises the rows.
        unsafe { slots[slot].load(row) }.value.to_f64()
    };
    let place = |row| [0, 1, 2].map(|side| number(first + side, row));
    let lengths = match box_slot(F::SIGNATURE.ports) {
        Some(slot) => [0, 1, 2].map(|side| number(slot + side, 0)),
        None => [0.0; 3],
    };
    for i in 0..call.rows {
        let (row, at) = (load::<P, F>(Row { slots, row: i, ends: 0, end: 0 }), place(i));
        let mut sums = Sums::<Dual<P>, SUMS>::zero(first_output(F::SIGNATURE.ports));
        for j in 0..call.rows {
            let other = place(j);
            for by in images([0, 1, 2].map(|side| other[side] - at[side]), lengths, cutoff) {
                if i == j && by == [0.0; 3] {
                    continue;
                }
                let moved = Moved { row: Row { slots, row: j, ends: 0, end: 0 }, first, by };
                take::<P, F>(&mut sums, law.pair(row, load::<P, F>(moved)));
            }
        }
        give::<P, F>(slots, i, &sums);
    }
}

type RowOf<P, F> = <<F as PairFamily>::Kernel<Dual<P>> as Declared<Dual<P>>>::Row;
type OutputOf<P, F> = <<F as PairFamily>::Kernel<Dual<P>> as Declared<Dual<P>>>::Output;

fn load<P: Scalar, F: PairFamily>(source: impl Source<Dual<P>>) -> RowOf<P, F> {
    <F::Kernel<Dual<P>> as Declared<Dual<P>>>::load(&Within::<_, F>::new(source))
}

fn take<P: Scalar, F: PairFamily>(sums: &mut Sums<Dual<P>, SUMS>, output: OutputOf<P, F>) {
    let mut share = Sums::nothing(first_output(F::SIGNATURE.ports));
    <F::Kernel<Dual<P>> as Declared<Dual<P>>>::store(output, &mut share);
    sums.take(&share, SUMS);
}

fn give<P: Scalar, F: PairFamily>(slots: &[DualReach<P>], row: usize, sums: &Sums<Dual<P>, SUMS>) {
    let first = first_output(F::SIGNATURE.ports);
    let mut sink = RowMut { slots, row };
    for (slot, sum) in (first..slots.len()).zip(sums.values) {
        sink.add(slot, sum);
    }
}

/// A row of which the coordinate from slot `first` on is moved.
struct Moved<'a, P> {
    row: Row<'a, P>,
    first: usize,
    by: [f64; 3],
}

impl<P: Scalar> Source<Dual<P>> for Moved<'_, P> {
    fn wants(&self, port: usize) -> bool {
        self.row.wants(port)
    }
    fn has(&self, slot: usize) -> bool {
        self.row.has(slot)
    }
    fn component(&self, slot: usize) -> Dual<P> {
        let number = self.row.component(slot);
        match slot.checked_sub(self.first).and_then(|side| self.by.get(side)) {
            Some(by) => number + Dual::constant(P::from_f64(*by)),
            None => number,
        }
    }
    fn constant(&self, slot: usize) -> Dual<P> {
        self.row.constant(slot)
    }
}

/// The loop over links.
///
/// # Safety
/// The call keeps its promises.
pub(super) unsafe fn links<P: Scalar, F: LinkFamily<N>, const N: usize>(law: &F, call: &TangentCall<'_, P>) {
    let law = law.kernel::<Dual<P>>();
    let slots = call.slots;
    let at_ends = const { slots_at(F::SIGNATURE.ports, Place::End) };
    for link in 0..call.rows {
        let end_of = |end: usize| call.ends[link * N + end] as usize;
        let at = |end| Within::<_, F>::new(Row { slots, row: link, ends: at_ends, end: end_of(end) });
        let row = <F::Kernel<Dual<P>> as Declared<Dual<P>>>::load(&at(0));
        let ends = core::array::from_fn(|end| <F::Kernel<Dual<P>> as Declared<Dual<P>>>::load_end(&at(end)));
        for (end, output) in law.link(row, ends).into_iter().enumerate() {
            let mut sink = RowMut { slots, row: end_of(end) };
            <F::Kernel<Dual<P>> as Declared<Dual<P>>>::store_end(output, &mut sink);
        }
    }
}
