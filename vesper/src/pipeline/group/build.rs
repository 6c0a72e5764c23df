//! Ties a group to a state. In: the operations of a pass, and where columns are. Out: a [`Group`]: slots, scratches, and
//! operations on blocks; or one loop, where a chain was listed that has just these laws. Never runs anything.

use super::{BlockLaw, BlockOp, Desk, Group, Slot, Start};
use crate::backend::{Kernel, block};
use crate::column::Aligned;
use crate::law::Part;
use crate::pipeline::bind::{Base, Binder, PARALLEL_ROWS, Transfer, threads};
use crate::pipeline::chain::FusedChain;
use crate::pipeline::merge::{NOTHING, kick_and_drift};
use crate::pipeline::operand::Operand;
use crate::pipeline::plan::{Key, Op, Placed};
use crate::real::{MAX_WIDTH, Scalar, Vector};
use crate::registry::Backend;
use core::ops::Range;

/// A group while it is being tied.
pub(in crate::pipeline) struct GroupBuilder<'a, P: Scalar> {
    binder: &'a Binder<'a, P>,
    row_list: Option<&'a [u32]>,
    pub(in crate::pipeline) rows: usize,
    slots: Vec<Slot<P>>,
    rates: Vec<usize>,
    ops: Vec<BlockOp<P>>,
    transfers: Vec<Transfer<P>>,
    /// Scratches by what they hold.
    scratches: Vec<Operand>,
    defaults: Vec<Aligned<P>>,
}

impl<'a, P: Scalar> GroupBuilder<'a, P> {
    pub(in crate::pipeline) fn new(binder: &'a Binder<'a, P>, ops: &'a [Placed]) -> Option<Self> {
        let first = ops.first()?;
        Some(GroupBuilder {
            binder,
            row_list: first.rows.as_deref(),
            rows: first.rows.as_ref().map_or(binder.state.domains[first.domain].rows, Vec::len),
            slots: Vec::new(),
            rates: Vec::new(),
            ops: Vec::new(),
            transfers: Vec::new(),
            scratches: Vec::new(),
            defaults: Vec::new(),
        })
    }

    pub(in crate::pipeline) fn build(mut self, ops: &[Placed]) -> Group<P> {
        let fused = self.fuse(ops);
        if !fused {
            let mut rest = ops;
            while let Some((op, after)) = rest.split_first() {
                match after.split_first().and_then(|(next, after)| Some((kick_and_drift(op, next)?, after))) {
                    Some((joined, after)) => {
                        self.op(&joined);
                        rest = after;
                    }
                    None => {
                        self.op(op);
                        rest = after;
                    }
                }
            }
        }
        // An energy is one sum over all rows, in their order.
        let energy = ops.iter().any(|op| matches!(op.op, Op::Law { energy: true, .. }));
        let backend = if energy { Backend::Cpu } else { ops[0].backend };
        let moving = |slot: &Slot<P>| if let Slot::Moving(start) = *slot { Some(start) } else { None };
        let mut columns: Vec<*mut P> = self.slots.iter().filter_map(moving).collect();
        columns.sort_unstable();
        columns.dedup();
        let block = block::<P>(columns.len() * self.rows * size_of::<P>());
        let alone = self.ops.iter().any(|op| matches!(op, BlockOp::Law(law) if !law.kernel.splits()));
        let most = if alone { 1 } else { self.rows.div_ceil(block) };
        let threads = threads(backend, self.rows, PARALLEL_ROWS, self.binder.machine).min(most).max(1);
        // One operation that keeps nothing between rows runs through all of a thread's rows.
        let block = match (self.ops.len(), self.scratches.len()) {
            (0 | 1, 0) => self.rows.div_ceil(threads).next_multiple_of(MAX_WIDTH),
            _ => block,
        };
        debug_assert!(block.is_multiple_of(MAX_WIDTH), "only the last block may end between multiples of the lanes");
        let desks = (0..threads)
            .map(|_| {
                let scratch = Aligned::<P>::zeros(self.scratches.len() * block, 0);
                let start = |slot: &Slot<P>| match *slot {
                    Slot::Moving(start) | Slot::Fixed(start) => start,
                    Slot::Scratch(at) => scratch.pointer().wrapping_add(at * block),
                };
                let starts: Vec<_> = self.slots.iter().map(start).collect();
                Desk { scratch, pointers: starts.clone(), rates: 0, starts, ready: false }
            })
            .collect();
        Group {
            rows: self.rows,
            block,
            columns,
            fused,
            moves: self.slots.iter().map(|slot| if matches!(slot, Slot::Moving(_)) { usize::MAX } else { 0 }).collect(),
            rates: self.rates,
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
                // What the client looks at shall not be a zero with a minus sign.
                None if self.binder.plan.key == Key::Observe => BlockOp::Start { to: slots, from: Start::Number(0.0) },
                None => BlockOp::Start { to: slots, from: Start::Number(NOTHING) },
                Some(_) => BlockOp::Start { to: slots.start..half, from: Start::Slots(half..slots.end) },
            },
            Op::Sample { field, .. } => {
                let regions = self.binder.pipeline.switches.at(field, op.domain, op.rows.as_ref());
                BlockOp::Sample { field, at: slots.start..half, to: half..slots.end, regions }
            }
            Op::Law { seat, part, advance, drift, energy, first } => {
                let law = self.binder.pipeline.registry.seats[seat].law;
                // Whoever made the group looked at the shape.
                let Kernel::Row(kernel) = &self.binder.laws[law].compiled.kernel else { return };
                let (kernel, uniform) = (kernel.clone(), self.uniform_slots(&op.operands));
                BlockOp::Law(BlockLaw { law, kernel, slots, uniform, part, advance, drift, energy, first })
            }
            Op::Axpy { .. } | Op::Release { .. } | Op::Hold { .. } | Op::Keep => return,
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
            if matches!((operand, &slot), (Operand::Rate(..), Slot::Moving(_))) {
                self.rates.push(self.slots.len());
            }
            self.slots.push(slot);
        }
        from..self.slots.len()
    }

    fn slot(&mut self, operand: Operand, writes: bool) -> Slot<P> {
        let located = match operand {
            Operand::Absent => return Slot::Fixed(core::ptr::null_mut()),
            // Scratches begin as zeros, and nobody writes to this one.
            Operand::Zero => return Slot::Scratch(self.scratch(operand)),
            Operand::Default(value) => return self.fixed(P::from_f64(value), 1),
            Operand::Field(field, component) => match self.uniform(field) {
                Some(value) => return self.fixed(value[component], MAX_WIDTH),
                None => return Slot::Scratch(self.scratch(operand)),
            },
            Operand::Quantity(..)
            | Operand::Rate(..)
            | Operand::Turned(..)
            | Operand::Held(..)
            | Operand::Previous(..)
            | Operand::Constant(..) => {
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
