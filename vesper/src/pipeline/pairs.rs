//! Runs the pass of a pair law. In: a pass that is tied to a state. Out: sums in their columns, or an energy. Never: a body.

use super::bind::{Base, PairPass};
use super::pass::first_result;
use super::run::Context;
use super::threads::{in_parts, together};
use super::turns::Turns;
use crate::backend::{PairCall, Tally, meeting_block, rounds};
use crate::column::Aligned;
use crate::real::Scalar;
use core::ops::Range;
use core::sync::atomic::{AtomicUsize, Ordering};

/// Rows that a thread takes at a time: a multiple of every width of lanes.
pub(super) const PAIR_GRAIN: usize = 64;

/// What is kept to look at each pair once.
pub(crate) struct Once<P: Scalar> {
    tally: Tally<P>,
    /// By thread, and number that the law adds to: sums of a meeting, of two blocks.
    scratch: Vec<Vec<*mut P>>,
    /// Rows that meet; those behind them, which do not fill lanes, are given what the others do row by row.
    rows: usize,
    turns: Turns,
    /// What the tally and the scratch point to.
    _numbers: Vec<Aligned<P>>,
}

// SAFETY: its pointers are into its own memory.
unsafe impl<P: Scalar> Send for Once<P> {}

impl<P: Scalar> Once<P> {
    pub(super) fn new(rows: usize, added: usize, threads: usize) -> Self {
        let rows = rows - rows % PAIR_GRAIN;
        let block = meeting_block(rows);
        let columns = |count: usize, rows| (0..count).map(move |stream| Aligned::zeros(rows, stream));
        let numbers: Vec<_> = columns(2 * added, rows).chain(columns(threads * added, 2 * block)).collect();
        let pointers: Vec<_> = numbers.iter().map(Aligned::pointer).collect();
        let (sums, scratch) = pointers.split_at(2 * added);
        let tally = Tally { block, numbers: sums.chunks_exact(2).map(|two| [two[0], two[1]]).collect() };
        let scratch = scratch.chunks_exact(added.max(1)).map(<[_]>::to_vec).collect();
        let blocks = rows.div_ceil(block);
        Once { tally, scratch, rows, turns: Turns::new(blocks, rounds(blocks)), _numbers: numbers }
    }

    /// Begins to look at pairs. Where a body panicked before, what it left goes.
    fn begin(&mut self) {
        if self.turns.begin() {
            return;
        }
        for number in self.tally.numbers.iter().flatten() {
            // SAFETY: the tally has a number for each row, and nobody else looks at them now.
            unsafe { core::slice::from_raw_parts_mut(*number, self.rows) }.fill(P::default());
        }
    }
}

impl<P: Scalar> PairPass<P> {
    /// For these rows, and all others.
    #[inline]
    pub(super) fn call(&self, rows: Range<usize>) -> PairCall<'_, P> {
        let PairPass { slots, rests, first, estimates, .. } = self;
        let square = self.near.as_ref().map_or(P::default(), |near| near.square());
        PairCall { slots, rests, rows, others: 0..self.rows, first: *first, estimates: *estimates, square }
    }

    /// For all rows.
    #[inline]
    pub(super) fn all(&self) -> PairCall<'_, P> {
        self.call(0..self.rows)
    }

    /// Brings what is packed to where the law reads it; false where that is lent memory, which only a run has.
    pub(super) fn load_owned(&mut self) -> bool {
        if self.transfers.iter().any(|transfer| matches!(transfer.base, Base::Lent { .. })) {
            return false;
        }
        for transfer in &self.transfers {
            // SAFETY: packed arrays have a number for every row.
            unsafe { transfer.load(&[], 0..self.rows, self.packed[transfer.scratch].pointer()) };
        }
        true
    }

    /// Whether the law gives the same where it is told differences of coordinates only.
    pub(super) fn is_invariant(&self) -> bool {
        // SAFETY: the slots have a number for every row.
        self.rests.is_empty() || unsafe { self.kernel.is_invariant(&self.all()) }
    }

    /// How pairs are found, for `explain`.
    pub(super) fn way(&self) -> String {
        if let Some(far) = &self.far {
            let found = match far.accuracy {
                Some(found) => format!(", measured {:.1e}, at most {:.1e}", found.measured, found.largest),
                None => String::new(),
            };
            return format!(", far ones together, error {:e}{found}", far.requested());
        }
        match (&self.near, &self.once) {
            (Some(_), _) => ", lists of neighbours".to_owned(),
            (None, Some(_)) => ", each pair once".to_owned(),
            (None, None) => String::new(),
        }
    }

    /// Whether pairs have the form of inverse squares, where that counts.
    pub(super) fn is_as_inverse_square(&self) -> bool {
        // SAFETY: as above.
        self.far.is_none() || unsafe { self.kernel.is_as_inverse_square(&self.all()) }
    }

    /// Whether row j loses what row i gets, where that counts.
    pub(super) fn is_antisymmetric(&self) -> bool {
        // SAFETY: as above.
        self.once.is_none() || unsafe { self.kernel.is_antisymmetric(&self.all()) }
    }
}

#[inline(never)]
pub(super) fn run<P: Scalar>(pass: &mut PairPass<P>, context: &Context<'_, P>) -> f64 {
    for transfer in &pass.transfers {
        // SAFETY: packed arrays have a number for every row.
        unsafe { transfer.load(context.lent, 0..pass.rows, pass.packed[transfer.scratch].pointer()) };
    }
    if pass.energy {
        return energy(pass, context);
    }
    context.timed(pass.law, || {
        if pass.far.is_some() {
            return super::far_field::run(pass, context);
        }
        if super::neighbours::follow(pass, context) {
            return super::neighbours::run(pass, context);
        }
        if let Some(once) = &mut pass.once {
            once.begin();
        }
        match &pass.once {
            Some(once) => meet(pass, once, context),
            // SAFETY: the slots have a number for every row; parts sum for different rows.
            None => unsafe {
                in_parts(context, pass.threads, pass.rows, PAIR_GRAIN, |rows| {
                    pass.kernel.run(context.isa, &pass.call(rows));
                });
            },
        }
    });
    if let Some(once) = &mut pass.once {
        once.turns.end();
    }
    context.watch(pass.law, || {
        let first = first_result(context, pass.law);
        pass.slots[first..].iter().map(|start| (*start, 1, pass.rows))
    });
    for transfer in pass.transfers.iter().filter(|transfer| transfer.save) {
        // SAFETY: as above.
        unsafe { transfer.store(context.lent, 0..pass.rows, pass.packed[transfer.scratch].pointer()) };
    }
    0.0
}

fn energy<P: Scalar>(pass: &mut PairPass<P>, context: &Context<'_, P>) -> f64 {
    let energy = if pass.far.is_some() {
        super::far_field::energy(pass, context)
    } else if super::neighbours::follow(pass, context) {
        super::neighbours::energy(pass)
    } else {
        // SAFETY: the slots have a number for every row.
        unsafe { pass.kernel.energy(&pass.all()) }
    };
    energy.unwrap_or_default()
}

/// Each pair is looked at once.
fn meet<P: Scalar>(pass: &PairPass<P>, once: &Once<P>, context: &Context<'_, P>) {
    let (isa, kernel) = (context.isa, &pass.kernel);
    let Once { tally, scratch, rows, turns, .. } = once;
    let threads = pass.threads.min(turns.at_once());
    let call = PairCall { others: 0..*rows, ..pass.call(0..*rows) };
    let came = AtomicUsize::new(0);
    let work = || {
        let number = came.fetch_add(1, Ordering::Relaxed);
        if number == 0 && *rows < pass.rows {
            // SAFETY: the slots have a number for every row; nobody else sums for those that do not fill lanes.
            unsafe { kernel.run(isa, &pass.call(*rows..pass.rows)) };
        }
        let meet = |blocks| {
            // SAFETY: the slots and the tally have numbers for every row; the blocks meet nobody else now; the scratch is this
            // thread's.
            unsafe { kernel.meet(isa, &call, (tally, &scratch[number]), blocks) };
        };
        turns.hold(meet, |block| {
            let due = pass.call(tally.rows_of(block, *rows));
            // SAFETY: as above; the block meets nobody any more.
            unsafe { kernel.give(isa, &due, tally) };
            if *rows < pass.rows {
                let left = PairCall { others: *rows..pass.rows, first: false, ..due };
                // SAFETY: as above.
                unsafe { kernel.run(isa, &left) };
            }
        });
    };
    // SAFETY: in turns, threads touch the sums of different blocks, and what a law reads nobody writes.
    unsafe { together(context, threads, work) };
}
