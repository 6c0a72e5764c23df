//! A group of row laws of one domain: block by block, all laws of the group before the next block.

mod build;

pub(super) use build::GroupBuilder;

use super::bind::Transfer;
use super::chain::{ChainCall, Fixed};
use super::run::Context;
use super::switches::{Phase, RegionsAt};
use crate::backend::{AHEAD, RowCall, RowKernel};
use crate::column::Aligned;
use crate::law::Part;
use crate::real::Scalar;
use core::ops::Range;
use std::sync::Arc;

/// Where a component is during a block.
#[derive(Clone, Copy, Debug)]
enum Slot<P> {
    /// In a column: the block's first row is this many rows on.
    Moving(*mut P),
    /// One number.
    Fixed(*mut P),
    /// In the thread's own memory.
    Scratch(usize),
}

/// What a sum begins from.
#[derive(Clone, Debug)]
enum Start {
    Number(f64),
    Slots(Range<usize>),
}

/// One operation on a block.
enum BlockOp<P: Scalar> {
    Start {
        to: Range<usize>,
        from: Start,
    },
    Sample {
        field: usize,
        at: Range<usize>,
        to: Range<usize>,
        /// Where the field has some.
        regions: Option<RegionsAt<P>>,
    },
    Law(BlockLaw<P>),
    /// All laws of a chain in one loop.
    Fused {
        chain: usize,
        slots: Range<usize>,
        fixed: Fixed,
        momenta: Option<usize>,
        coordinates: Option<usize>,
    },
}

/// A row law in a group.
struct BlockLaw<P: Scalar> {
    law: usize,
    kernel: Arc<dyn RowKernel<P>>,
    slots: Range<usize>,
    /// Which of them are of a uniform field: one set of lanes; a bit each.
    uniform: u64,
    part: Part,
    advance: Option<usize>,
    /// The stage of the coordinates, where the same loop advances them after the momenta.
    drift: Option<usize>,
    energy: bool,
    /// Whether the sums it adds to begin with it.
    first: bool,
}

impl<P: Scalar> BlockLaw<P> {
    /// The call of its kernel on a block.
    #[inline(always)]
    fn on<'a>(
        &self,
        rows: usize,
        pointers: &'a [*mut P],
        ahead: [*const P; AHEAD],
        context: &Context<'_, P>,
    ) -> RowCall<'a, P> {
        let [advance, drift] = [self.advance, self.drift].map(|stage| stage.map(|stage| context.steps[stage]).into());
        let BlockLaw { uniform, part, first, .. } = *self;
        RowCall { slots: pointers[self.slots.clone()].into(), uniform, rows, part, advance, drift, first, ahead }
    }
}

/// The memory of one thread.
struct Desk<P: Scalar> {
    scratch: Aligned<P>,
    /// Where each slot begins.
    starts: Vec<*mut P>,
    /// Where each slot is in the block at hand.
    pointers: Vec<*mut P>,
    /// How many numbers behind their own place those of rates are.
    rates: usize,
    /// Whether `pointers` are those of the only block.
    ready: bool,
}

/// A group, ready to run.
pub(crate) struct Group<P: Scalar> {
    pub(crate) rows: usize,
    /// Rows that all operations take before the next ones.
    block: usize,
    pub(crate) fused: bool,
    /// By slot: all ones where it moves on from block to block, or zero.
    moves: Vec<usize>,
    /// The slots of rates that are written in place.
    pub(super) rates: Vec<usize>,
    /// Where the columns begin that are read or written in place.
    columns: Vec<*mut P>,
    ops: Vec<BlockOp<P>>,
    transfers: Vec<Transfer<P>>,
    desks: Vec<Desk<P>>,
    /// Keeps the constants that `slots` points to.
    _defaults: Vec<Aligned<P>>,
}

impl<P: Scalar> Group<P> {
    /// How many threads take part.
    pub(crate) fn threads(&self) -> usize {
        self.desks.len()
    }

    /// Runs all blocks.
    ///
    /// # Safety
    /// The state has the layout that the group was tied to, and nobody else touches it.
    pub(crate) unsafe fn run(&mut self, context: &Context<'_, P>) -> f64 {
        let Group { rows, block, moves, rates, columns, ops, transfers, desks, .. } = self;
        if let ([desk], []) = (desks.as_mut_slice(), transfers.as_slice())
            && desk.ready
        {
            // One block that has been here before, with all in place: with few rows the rest would take longer than the laws.
            desk.move_rates(rates, context.rates);
            let ahead = [desk.scratch.pointer().cast_const(); AHEAD];
            let mut energy = 0.0;
            for op in &*ops {
                // SAFETY: passed on to the caller; the pointers are those of the only block.
                energy += unsafe {
                    match op {
                        BlockOp::Law(call) if !call.energy && context.is_unwatched() => {
                            let isa = context.isa.for_few::<P>(*rows);
                            call.kernel.run(isa, &call.on(*rows, &desk.pointers, ahead, context));
                            0.0
                        }
                        _ => run_op(context, op, 0..*rows, &desk.pointers, ahead),
                    }
                };
            }
            return energy;
        }
        let body = Body { rows: *rows, block: *block, moves, rates, columns, ops, transfers, context };
        if let [desk] = desks.as_mut_slice() {
            // SAFETY: passed on to the caller.
            return unsafe { body.blocks(0..rows.div_ceil(*block), desk) };
        }
        let blocks = rows.div_ceil(*block);
        let each = blocks.div_ceil(desks.len());
        super::threads::on_desks(context, desks, |thread, desk| {
            // SAFETY: passed on to the caller; threads get different blocks, which are different rows.
            unsafe { body.blocks((thread * each).min(blocks)..((thread + 1) * each).min(blocks), desk) };
        });
        0.0
    }

    /// The memory that lent columns begin at may have changed: pointers are made anew in the next run.
    pub(crate) fn unready(&mut self) {
        self.desks.iter_mut().for_each(|desk| desk.ready = false);
    }
}

impl<P: Scalar> Desk<P> {
    /// Lets the rates at these slots go where they are wanted: so many numbers behind their own place.
    #[inline(always)]
    fn move_rates(&mut self, slots: &[usize], wanted: usize) {
        if self.rates != wanted {
            for slot in slots {
                let pointer = &mut self.pointers[*slot];
                *pointer = pointer.wrapping_sub(self.rates).wrapping_add(wanted);
            }
            self.rates = wanted;
        }
    }
}

// SAFETY: a desk's pointers are made and followed by the one thread that has it.
unsafe impl<P: Scalar> Send for Desk<P> {}

/// What threads share of a group.
struct Body<'a, P: Scalar> {
    rows: usize,
    block: usize,
    moves: &'a [usize],
    rates: &'a [usize],
    columns: &'a [*mut P],
    ops: &'a [BlockOp<P>],
    transfers: &'a [Transfer<P>],
    context: &'a Context<'a, P>,
}

// SAFETY: shared by threads that follow its pointers at disjoint rows only.
unsafe impl<P: Scalar> Sync for Body<'_, P> {}

impl<P: Scalar> Body<'_, P> {
    /// # Safety
    /// As for [`Group::run`]; nobody else touches the rows of these blocks, or the desk.
    unsafe fn blocks(&self, blocks: Range<usize>, desk: &mut Desk<P>) -> f64 {
        let mut energy = 0.0;
        for block in blocks {
            let first = block * self.block;
            let rows = first..(first + self.block).min(self.rows);
            if !desk.ready {
                self.point(first, desk);
                desk.ready = self.rows <= self.block;
            }
            desk.move_rates(self.rates, self.context.rates);
            let scratch = |at: usize| desk.scratch.pointer().wrapping_add(at * self.block);
            for transfer in self.transfers {
                // SAFETY: the rows exist, and a scratch holds a block.
                unsafe { transfer.load(self.context.lent, rows.clone(), scratch(transfer.scratch)) };
            }
            let next = rows.end;
            let mut unannounced = if next < self.rows { self.columns } else { &[] };
            for op in self.ops {
                let ahead = core::array::from_fn(|_| match unannounced.split_first() {
                    Some((column, rest)) if matches!(op, BlockOp::Law(_)) => {
                        unannounced = rest;
                        column.wrapping_add(next).cast_const()
                    }
                    _ => desk.scratch.pointer().cast_const(),
                });
                // SAFETY: the pointers are those of this block.
                energy += unsafe { run_op(self.context, op, rows.clone(), &desk.pointers, ahead) };
            }
            for transfer in self.transfers.iter().filter(|transfer| transfer.save) {
                // SAFETY: as above, and the rows are this thread's.
                unsafe { transfer.store(self.context.lent, rows.clone(), scratch(transfer.scratch)) };
            }
        }
        energy
    }

    /// One sum for each slot, without a branch: a group of five laws has sixty.
    fn point(&self, first: usize, desk: &mut Desk<P>) {
        for ((pointer, start), moves) in desk.pointers.iter_mut().zip(&desk.starts).zip(self.moves) {
            *pointer = start.wrapping_add(first & moves);
        }
        desk.rates = 0;
    }
}

/// # Safety
/// `pointers` are those of the block, which has these rows.
#[inline(never)]
unsafe fn run_op<P: Scalar>(
    context: &Context<'_, P>,
    op: &BlockOp<P>,
    block: Range<usize>,
    pointers: &[*mut P],
    ahead: [*const P; AHEAD],
) -> f64 {
    let rows = block.len();
    match op {
        BlockOp::Start { to, from: Start::Number(number) } => {
            for &to in &pointers[to.clone()] {
                // SAFETY: a sum has a number for every row.
                unsafe { core::slice::from_raw_parts_mut(to, rows) }.fill(P::from_f64(*number));
            }
        }
        BlockOp::Start { to, from: Start::Slots(from) } => {
            for (&to, &from) in pointers[to.clone()].iter().zip(&pointers[from.clone()]) {
                // SAFETY: both have a number for every row, and are different columns.
                unsafe { to.copy_from_nonoverlapping(from, rows) };
            }
        }
        BlockOp::Sample { field, at, to, regions } => {
            let at = core::array::from_fn(|c| pointers[at.start + c]);
            let to = core::array::from_fn(|c| pointers[to.start + c]);
            // SAFETY: places are columns or scratches of the block, samples are scratches of their own.
            let (at, to) = unsafe {
                (
                    at.map(|start| core::slice::from_raw_parts(start, rows)),
                    to.map(|start| core::slice::from_raw_parts_mut(start, rows)),
                )
            };
            let field = &context.fields[*field].1;
            match regions.filter(|_| context.phase != Phase::Free) {
                None => field.sample_block(at, context.time, to),
                Some(regions) => {
                    // SAFETY: the rows are this thread's own.
                    unsafe { regions.sample((&**field, context.phase, context.time), block.start, at, to) };
                }
            }
        }
        BlockOp::Law(law) => {
            let call = law.on(rows, pointers, ahead, context);
            if law.energy {
                // SAFETY: passed on to the caller.
                return unsafe { law.kernel.energy(&call) }.unwrap_or_default();
            }
            context.timed(law.law, || {
                // SAFETY: passed on to the caller.
                unsafe { law.kernel.run(context.isa, &call) };
            });
            let first = || law.slots.start + super::pass::first_result(context, law.law);
            context.watch(law.law, || pointers[first()..law.slots.end].iter().map(|start| (*start, 1, rows)));
        }
        BlockOp::Fused { chain, slots, fixed, momenta, coordinates } => {
            let chain = &context.chains[*chain];
            let step = |stage: &Option<usize>| stage.map(|stage| context.steps[stage]);
            context.timed(chain.last_law(), || {
                // SAFETY: passed on to the caller.
                unsafe {
                    chain.run(&ChainCall {
                        isa: context.isa,
                        slots: &pointers[slots.clone()],
                        fixed: *fixed,
                        rows,
                        kick: step(momenta),
                        drift: step(coordinates),
                    });
                }
            });
        }
    }
    0.0
}
