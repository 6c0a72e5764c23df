//! Runs the pass of a pair law. In: a pass that is tied to a state. Out: sums in their columns, or an energy. Never: a body.

use super::bind::{Base, PairPass};
use super::pass::first_result;
use super::run::Context;
use super::threads::{in_parts, together};
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
    meetings: Vec<Meeting>,
    /// How many meetings each block has had.
    had: Vec<AtomicUsize>,
    /// How many it has.
    has: usize,
    /// What the tally and the scratch point to.
    _numbers: Vec<Aligned<P>>,
}

/// Two blocks meet, or one alone, when each has had so many meetings.
struct Meeting {
    blocks: [usize; 2],
    after: [usize; 2],
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
        let blocks = rows.div_ceil(tally.block);
        let mut after = vec![0; blocks];
        let in_turn = rounds(blocks).flatten().map(|blocks| {
            let meeting = Meeting { blocks, after: blocks.map(|block| after[block]) };
            let [a, b] = blocks;
            after[a] += 1;
            after[b] += usize::from(a != b);
            meeting
        });
        let meetings = in_turn.collect();
        let had = after.iter().map(|_| AtomicUsize::new(0)).collect();
        Once { tally, scratch, rows, meetings, had, has: blocks, _numbers: numbers }
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
        match &pass.once {
            Some(once) => meet(pass, once, context),
            None => in_parts(context, pass.threads, pass.rows, PAIR_GRAIN, |rows| {
                // SAFETY: the slots have a number for every row; parts sum for different rows.
                unsafe { pass.kernel.run(context.isa, &pass.call(rows)) };
            }),
        }
    });
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
///
/// Meetings are taken in their order by whoever is free, and wait for those that their blocks have before: the first one that has
/// not ended waits for none, so that all end. A round need not end before the next one begins.
fn meet<P: Scalar>(pass: &PairPass<P>, once: &Once<P>, context: &Context<'_, P>) {
    once.had.iter().for_each(|had| had.store(0, Ordering::Relaxed));
    let (next, came) = (AtomicUsize::new(0), AtomicUsize::new(0));
    together(context, pass.threads, || {
        let Some(scratch) = once.scratch.get(came.fetch_add(1, Ordering::Relaxed)) else { return };
        loop {
            let ticket = next.fetch_add(1, Ordering::Relaxed);
            match once.meetings.get(ticket) {
                Some(meeting) => meet_two(pass, (once, scratch), context, meeting),
                None if ticket == once.meetings.len() && once.rows < pass.rows => {
                    // SAFETY: the slots have a number for every row; nobody else sums for those that do not fill lanes.
                    unsafe { pass.kernel.run(context.isa, &pass.call(once.rows..pass.rows)) };
                }
                None => return,
            }
        }
    });
}

/// Two blocks meet when it is their turn; one that has met all others is given what it is due.
fn meet_two<P: Scalar>(
    pass: &PairPass<P>,
    (once, scratch): (&Once<P>, &[*mut P]),
    context: &Context<'_, P>,
    meeting: &Meeting,
) {
    let Meeting { blocks: [a, b], after } = *meeting;
    let [mine, others] = [a, b].map(|block| &once.had[block]);
    wait_for(mine, after[0]);
    wait_for(others, after[1]);
    let _ended = [Ended { had: mine, now: after[0] + 1 }, Ended { had: others, now: after[1] + 1 }];
    let call = PairCall { others: 0..once.rows, ..pass.call(0..once.rows) };
    // SAFETY: the slots and the tally have numbers for every row, and the blocks meet nobody else now.
    unsafe { pass.kernel.meet(context.isa, &call, (&once.tally, scratch), [a, b]) };
    let there = if a == b { 1 } else { 2 };
    for (block, after) in [a, b].into_iter().zip(after).take(there) {
        if after + 1 == once.has {
            give(pass, once, context, block);
        }
    }
}

/// A block is given what it is due, and what rows that do not fill lanes do to it.
fn give<P: Scalar>(pass: &PairPass<P>, once: &Once<P>, context: &Context<'_, P>, block: usize) {
    let rows = once.tally.rows_of(block, once.rows);
    let due = pass.call(rows);
    // SAFETY: the slots and the tally have numbers for every row; the block meets nobody any more.
    unsafe { pass.kernel.give(context.isa, &due, &once.tally) };
    if once.rows < pass.rows {
        let left = PairCall { others: once.rows..pass.rows, first: false, ..due };
        // SAFETY: as above.
        unsafe { pass.kernel.run(context.isa, &left) };
    }
}

/// A block has had so many meetings when this goes, even where a body panics: the others end theirs before that is passed on.
struct Ended<'a> {
    had: &'a AtomicUsize,
    now: usize,
}

impl Drop for Ended<'_> {
    fn drop(&mut self) {
        self.had.store(self.now, Ordering::Release);
    }
}

/// Turns that are spun before the core is offered to others: meetings take some ten microseconds.
const SPINS: usize = 1 << 12;

fn wait_for(had: &AtomicUsize, meetings: usize) {
    let mut turns = 0;
    while had.load(Ordering::Acquire) != meetings {
        turns += 1;
        if turns < SPINS { core::hint::spin_loop() } else { std::thread::yield_now() }
    }
}
