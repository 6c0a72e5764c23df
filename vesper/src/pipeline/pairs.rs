//! Runs the pass of a pair law. In: a pass that is tied to a state. Out: sums in their columns, or an energy. Never: a body.

use super::bind::{Base, PairPass};
use super::pass::first_result;
use super::run::{Context, among_threads, in_parts};
use crate::backend::{BLOCK, PairCall, Tally, rounds};
use crate::column::Aligned;
use crate::real::Scalar;
use core::ops::Range;

/// Rows that a thread takes at a time: a multiple of every width of lanes.
pub(super) const PAIR_GRAIN: usize = 64;

/// What is kept to look at each pair once.
pub(crate) struct Once<P: Scalar> {
    tally: Tally<P>,
    /// Rows that meet; those behind them, which do not fill lanes, are given what the others do row by row.
    rows: usize,
    rounds: Vec<Vec<[usize; 2]>>,
    /// What the tally points to.
    _numbers: Vec<Aligned<P>>,
}

// SAFETY: its pointers are into its own memory.
unsafe impl<P: Scalar> Send for Once<P> {}

impl<P: Scalar> Once<P> {
    pub(super) fn new(rows: usize, added: usize) -> Self {
        let rows = rows - rows % PAIR_GRAIN;
        let numbers: Vec<_> = (0..3 * added).map(|stream| Aligned::zeros(rows, stream)).collect();
        let of = |numbers: &[Aligned<P>]| core::array::from_fn(|which| numbers[which].pointer());
        let tally = Tally { numbers: numbers.chunks(3).map(of).collect() };
        Once { tally, rows, rounds: rounds(rows).collect(), _numbers: numbers }
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
fn meet<P: Scalar>(pass: &PairPass<P>, once: &Once<P>, context: &Context<'_, P>) {
    let (isa, kernel) = (context.isa, &pass.kernel);
    let call = PairCall { others: 0..once.rows, ..pass.call(0..once.rows) };
    among_threads(context, pass.threads, || {
        for round in &once.rounds {
            in_parts(context, pass.threads, round.len(), 1, |meetings| {
                for &blocks in &round[meetings] {
                    // SAFETY: the slots and the tally have numbers for every row, and in one round no block meets two others.
                    unsafe { kernel.meet(isa, &call, &once.tally, blocks) };
                }
            });
        }
    });
    in_parts(context, pass.threads, once.rows, BLOCK, |rows| {
        // SAFETY: as above; parts are of different rows.
        unsafe { kernel.give(isa, &PairCall { rows, ..call.clone() }, &once.tally) };
    });
    if once.rows == pass.rows {
        return;
    }
    in_parts(context, pass.threads, once.rows, PAIR_GRAIN, |rows| {
        let left = PairCall { rows, others: once.rows..pass.rows, first: false, ..call.clone() };
        // SAFETY: as above.
        unsafe { kernel.run(isa, &left) };
    });
    // SAFETY: as above.
    unsafe { kernel.run(isa, &pass.call(once.rows..pass.rows)) };
}
