//! A group of row laws of one domain: block by block, all laws of the group before the next block.

use super::bind::{Base, Binder, Transfer, threads};
use super::chain::{ChainCall, Fixed, FusedChain};
use super::plan::{Op, Operand, Placed};
use super::run::Context;
use crate::backend::{BLOCK, Kernel, RowCall};
use crate::column::Aligned;
use crate::law::Part;
use crate::real::{MAX_WIDTH, Scalar, Vector, prefetch};
use crate::registry::Backend;
use core::ops::Range;

/// Cache lines of each column that are asked for ahead of a block.
const ANNOUNCED: usize = 8;

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

/// One operation on a block.
#[derive(Clone, Debug)]
enum BlockOp {
    Start {
        to: Range<usize>,
        from: Option<Range<usize>>,
    },
    Sample {
        field: usize,
        at: Range<usize>,
        to: Range<usize>,
    },
    Law {
        law: usize,
        slots: Range<usize>,
        /// Which of them are of a uniform field: one set of lanes; a bit each.
        uniform: u64,
        part: Part,
        advance: Option<usize>,
        energy: bool,
    },
    /// All laws of a chain in one loop.
    Fused {
        chain: usize,
        slots: Range<usize>,
        fixed: Fixed,
        momenta: Option<usize>,
        coordinates: Option<usize>,
    },
}

/// The memory of one thread.
struct Desk<P: Scalar> {
    scratch: Aligned<P>,
    pointers: Vec<*mut P>,
    /// Whether `pointers` are those of the only block.
    ready: bool,
}

/// A group, ready to run.
pub(crate) struct Group<P: Scalar> {
    pub(crate) rows: usize,
    /// Rows that all operations take before the next ones.
    block: usize,
    pub(crate) fused: bool,
    slots: Vec<Slot<P>>,
    /// Where the columns begin that are read or written in place.
    columns: Vec<*mut P>,
    ops: Vec<BlockOp>,
    transfers: Vec<Transfer<P>>,
    desks: Vec<Desk<P>>,
    /// Keeps the constants that `slots` points to.
    _defaults: Vec<Aligned<P>>,
}

// SAFETY: its pointers are into columns of the state and into its own memory; they are followed only by
// `Runner`, which holds the state exclusively, and threads get disjoint rows and a desk each.
unsafe impl<P: Scalar> Send for Group<P> {}
// SAFETY: as above; nothing is followed through a shared reference.
unsafe impl<P: Scalar> Sync for Group<P> {}

/// A group while it is being tied.
pub(super) struct GroupBuilder<'a, P: Scalar> {
    binder: &'a Binder<'a, P>,
    row_list: Option<&'a [u32]>,
    pub(super) rows: usize,
    slots: Vec<Slot<P>>,
    ops: Vec<BlockOp>,
    transfers: Vec<Transfer<P>>,
    /// Scratches by what they hold.
    scratches: Vec<Operand>,
    defaults: Vec<Aligned<P>>,
}

impl<'a, P: Scalar> GroupBuilder<'a, P> {
    pub(super) fn new(binder: &'a Binder<'a, P>, ops: &'a [Placed]) -> Option<Self> {
        let first = ops.first()?;
        Some(GroupBuilder {
            binder,
            row_list: first.rows.as_deref(),
            rows: first.rows.as_ref().map_or(binder.state.domains[first.domain].rows, Vec::len),
            slots: Vec::new(),
            ops: Vec::new(),
            transfers: Vec::new(),
            scratches: Vec::new(),
            defaults: Vec::new(),
        })
    }

    pub(super) fn build(mut self, ops: &[Placed]) -> Group<P> {
        let fused = self.fuse(ops);
        if !fused {
            for op in ops {
                self.op(op);
            }
        }
        // An energy is one sum over all rows, in their order.
        let energy = ops.iter().any(|op| matches!(op.op, Op::Law { energy: true, .. }));
        let backend = if energy { Backend::Cpu } else { ops[0].backend };
        let threads = threads(backend, self.rows, super::bind::PARALLEL_ROWS, self.binder.machine)
            .min(self.rows.div_ceil(BLOCK))
            .max(1);
        // One operation that keeps nothing between rows runs through all of a thread's rows.
        let block = match (self.ops.len(), self.scratches.len()) {
            (0 | 1, 0) => self.rows.div_ceil(threads).next_multiple_of(MAX_WIDTH),
            _ => BLOCK,
        };
        let desks = (0..threads)
            .map(|_| {
                let scratch = Aligned::zeros(self.scratches.len() * block, 0);
                Desk { scratch, pointers: vec![core::ptr::null_mut(); self.slots.len()], ready: false }
            })
            .collect();
        let moving = |slot: &Slot<P>| if let Slot::Moving(start) = *slot { Some(start) } else { None };
        let mut columns: Vec<*mut P> = self.slots.iter().filter_map(moving).collect();
        columns.sort_unstable();
        columns.dedup();
        Group {
            rows: self.rows,
            block,
            columns,
            fused,
            slots: self.slots,
            ops: self.ops,
            transfers: self.transfers,
            desks,
            _defaults: self.defaults,
        }
    }

    fn op(&mut self, op: &Placed) {
        if matches!(op.op, Op::Sample { field } if self.uniform(field).is_some()) {
            return;
        }
        let slots = self.slots(op);
        let half = slots.start + slots.len() / 2;
        self.ops.push(match op.op {
            Op::Start { from, .. } => match from {
                None => BlockOp::Start { to: slots, from: None },
                Some(_) => BlockOp::Start { to: slots.start..half, from: Some(half..slots.end) },
            },
            Op::Sample { field, .. } => BlockOp::Sample { field, at: slots.start..half, to: half..slots.end },
            Op::Law { seat, part, advance, energy } => {
                let law = self.binder.pipeline.registry.seats[seat].law;
                BlockOp::Law { law, slots, uniform: self.uniform_slots(&op.operands), part, advance, energy }
            }
            Op::Axpy { .. } | Op::Release { .. } | Op::Hold { .. } => return,
        });
    }

    /// The value of a field that has the same one everywhere.
    fn uniform(&self, field: usize) -> Option<[P; 3]> {
        let value = self.binder.state.fields[field].1.uniform()?;
        Some([value.x(), value.y(), value.z()])
    }

    fn uniform_slots<'b>(&self, operands: impl IntoIterator<Item = &'b Operand>) -> u64 {
        let uniform = |operand: &Operand| matches!(*operand, Operand::Field(field, _) if self.uniform(field).is_some());
        operands.into_iter().enumerate().map(|(slot, operand)| u64::from(uniform(operand)) << slot).sum()
    }

    fn slots(&mut self, op: &Placed) -> Range<usize> {
        let from = self.slots.len();
        for (operand, writes) in op.operands.iter().zip(&op.writes) {
            let slot = self.slot(*operand, *writes);
            self.slots.push(slot);
        }
        from..self.slots.len()
    }

    fn slot(&mut self, operand: Operand, writes: bool) -> Slot<P> {
        let located = match operand {
            Operand::Absent => return Slot::Fixed(core::ptr::null_mut()),
            Operand::Default(value) => return self.fixed(P::from_f64(value), 1),
            Operand::Field(field, component) => match self.uniform(field) {
                Some(value) => return self.fixed(value[component], MAX_WIDTH),
                None => return Slot::Scratch(self.scratch(operand)),
            },
            Operand::Quantity(..) | Operand::Rate(..) | Operand::Held(..) | Operand::Constant(..) => {
                let transient = match operand {
                    Operand::Quantity(id, _) => self.binder.plan.is_transient(id, self.binder.pipeline),
                    _ => false,
                };
                match self.binder.locate(operand).filter(|_| !transient) {
                    None => return Slot::Scratch(self.scratch(operand)),
                    Some(located) => located,
                }
            }
        };
        match (operand, located.base) {
            (Operand::Constant(..), Base::Owned(pointer)) => Slot::Fixed(pointer),
            (_, Base::Owned(pointer)) if self.row_list.is_none() && located.stride == 1 => Slot::Moving(pointer),
            _ => {
                let known = self.scratches.iter().position(|other| *other == operand);
                let scratch = self.scratch(operand);
                match known {
                    None => self.transfers.push(Binder::transfer(&located, self.row_list, scratch, writes)),
                    Some(_) => {
                        let transfer = self.transfers.iter_mut().find(|transfer| transfer.scratch == scratch);
                        transfer.into_iter().for_each(|transfer| transfer.save |= writes);
                    }
                }
                Slot::Scratch(scratch)
            }
        }
    }

    fn fixed(&mut self, value: P, copies: usize) -> Slot<P> {
        let mut numbers = Aligned::zeros(copies, 0);
        numbers.as_mut_slice().fill(value);
        let pointer = numbers.pointer();
        self.defaults.push(numbers);
        Slot::Fixed(pointer)
    }

    fn scratch(&mut self, operand: Operand) -> usize {
        self.scratches.iter().position(|other| *other == operand).unwrap_or_else(|| {
            self.scratches.push(operand);
            self.scratches.len() - 1
        })
    }

    /// Runs the group as one loop, where a chain was listed that has just these laws.
    fn fuse(&mut self, ops: &[Placed]) -> bool {
        let Some((chain, steps)) = self.matching_chain(ops) else { return false };
        let Some(operands) = chain.operands(self.binder, ops) else { return false };
        let from = self.slots.len();
        let fixed = chain.fixed(&operands, self.uniform_slots(operands.iter().map(|(operand, _)| operand)));
        for operand in operands {
            let slot = self.slot(operand.0, operand.1);
            self.slots.push(slot);
        }
        // Fields that are functions must be sampled before the loop; samples stand before their laws, and depend on the
        // place alone, which no law of a chain changes before the last stage.
        for op in ops.iter().filter(|op| matches!(op.op, Op::Sample { .. })) {
            self.op(op);
        }
        let slots = from..from + chain.slots();
        self.ops.push(BlockOp::Fused { chain: steps.0, slots, fixed, momenta: steps.1, coordinates: steps.2 });
        true
    }

    /// The chain, its number, and the stages whose steps advance momenta and coordinates.
    #[allow(clippy::type_complexity, reason = "one use, taken apart at once")]
    fn matching_chain(&self, ops: &[Placed]) -> Option<(&'a FusedChain<P>, (usize, Option<usize>, Option<usize>))> {
        let laws = |part: Part| -> Vec<usize> {
            let of_part = ops.iter().filter_map(|op| match op.op {
                Op::Law { seat, part: own, .. } if own == part => Some(self.binder.pipeline.registry.seats[seat].law),
                _ => None,
            });
            of_part.collect()
        };
        let stage = |part: Part| {
            ops.iter().find_map(|op| match op.op {
                Op::Law { part: own, advance, .. } if own == part => advance,
                _ => None,
            })
        };
        let (momenta, coordinates) = (stage(Part::Momenta), stage(Part::Coordinates));
        momenta?;
        // A state that another law of its stage looks at advances after the stage, by rates that the loop keeps nowhere.
        if ops.iter().flat_map(|op| &op.operands).any(|operand| matches!(operand, Operand::Rate(..))) {
            return None;
        }
        let listed = laws(Part::Momenta);
        self.binder.chains.iter().enumerate().find_map(|(number, chain)| {
            let same = chain.laws_in_order() == listed
                && laws(Part::Coordinates).iter().all(|law| listed.contains(law))
                && laws(Part::All).is_empty();
            (same && self.row_list.is_none()).then_some((chain, (number, momenta, coordinates)))
        })
    }
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
        let Group { rows, block, slots, columns, ops, transfers, desks, .. } = self;
        let body = Body { rows: *rows, block: *block, slots, columns, ops, transfers, context };
        if let [desk] = desks.as_mut_slice() {
            // SAFETY: passed on to the caller.
            return unsafe { body.blocks(0..rows.div_ceil(*block), desk) };
        }
        let blocks = rows.div_ceil(*block);
        let each = blocks.div_ceil(desks.len());
        super::run::on_threads(context, desks, |thread, desk| {
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

// SAFETY: a desk's pointers are made and followed by the one thread that has it.
unsafe impl<P: Scalar> Send for Desk<P> {}

/// What threads share of a group.
struct Body<'a, P: Scalar> {
    rows: usize,
    block: usize,
    slots: &'a [Slot<P>],
    columns: &'a [*mut P],
    ops: &'a [BlockOp],
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
            let scratch = |at: usize| desk.scratch.pointer().wrapping_add(at * self.block);
            for transfer in self.transfers {
                // SAFETY: the rows exist, and a scratch holds a block.
                unsafe { transfer.load(self.context.lent, rows.clone(), scratch(transfer.scratch)) };
            }
            if rows.end < self.rows {
                self.announce(rows.end);
            }
            for op in self.ops {
                // SAFETY: the pointers are those of this block.
                energy += unsafe { self.op(op, rows.len(), &desk.pointers) };
            }
            for transfer in self.transfers.iter().filter(|transfer| transfer.save) {
                // SAFETY: as above, and the rows are this thread's.
                unsafe { transfer.store(self.context.lent, rows.clone(), scratch(transfer.scratch)) };
            }
        }
        energy
    }

    /// Asks for the beginnings of the next block's columns: the processor foresees a stream only once it has begun, and
    /// no further than to the end of a page, which is about the end of a block.
    fn announce(&self, first: usize) {
        for &column in self.columns {
            for line in 0..ANNOUNCED {
                prefetch(column.wrapping_add(first).wrapping_byte_add(line * 64));
            }
        }
    }

    fn point(&self, first: usize, desk: &mut Desk<P>) {
        let scratch = desk.scratch.pointer();
        for (pointer, slot) in desk.pointers.iter_mut().zip(self.slots) {
            *pointer = match *slot {
                Slot::Moving(start) => start.wrapping_add(first),
                Slot::Fixed(number) => number,
                Slot::Scratch(at) => scratch.wrapping_add(at * self.block),
            };
        }
    }

    /// # Safety
    /// `pointers` are those of the block, which has `rows` rows.
    unsafe fn op(&self, op: &BlockOp, rows: usize, pointers: &[*mut P]) -> f64 {
        let context = self.context;
        match op {
            BlockOp::Start { to, from: None } => {
                for &to in &pointers[to.clone()] {
                    // SAFETY: a sum has a number for every row.
                    unsafe { core::slice::from_raw_parts_mut(to, rows) }.fill(P::default());
                }
            }
            BlockOp::Start { to, from: Some(from) } => {
                for (&to, &from) in pointers[to.clone()].iter().zip(&pointers[from.clone()]) {
                    // SAFETY: both have a number for every row, and are different columns.
                    unsafe { to.copy_from_nonoverlapping(from, rows) };
                }
            }
            BlockOp::Sample { field, at, to } => {
                let at = core::array::from_fn(|c| pointers[at.start + c]);
                let to = core::array::from_fn(|c| pointers[to.start + c]);
                // SAFETY: places are columns or scratches of the block, samples are scratches of their own.
                let (at, to) = unsafe {
                    (
                        at.map(|start| core::slice::from_raw_parts(start, rows)),
                        to.map(|start| core::slice::from_raw_parts_mut(start, rows)),
                    )
                };
                context.fields[*field].1.sample_block(at, context.time, to);
            }
            BlockOp::Law { law, slots, uniform, part, advance, energy } => {
                let Kernel::Row(kernel) = &context.laws[*law].compiled.kernel else { return 0.0 };
                let advance = advance.map(|stage| context.steps[stage]);
                let call = RowCall { slots: &pointers[slots.clone()], uniform: *uniform, rows, part: *part, advance };
                if *energy {
                    // SAFETY: passed on to the caller.
                    return unsafe { kernel.energy(&call) }.unwrap_or_default();
                }
                context.timed(*law, || {
                    // SAFETY: passed on to the caller.
                    unsafe { kernel.run(context.isa, &call) };
                });
                let first = || slots.start + super::run::first_result(context, *law);
                context.watch(*law, || pointers[first()..slots.end].iter().map(|start| (*start, 1, rows)));
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
}
