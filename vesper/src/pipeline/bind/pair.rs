//! Ties a pair law to a state. In: the operation, and where columns are. Out: a [`PairPass`]. Never runs anything.

use super::{Base, Binder, PARALLEL_PAIRS, Transfer, defaults, threads};
use crate::backend::{PAYS, PairKernel, coordinate_slots};
use crate::column::Aligned;
use crate::pipeline::far_field::FarField;
use crate::pipeline::neighbours::Neighbours;
use crate::pipeline::operand::Operand;
use crate::pipeline::pairs::{Once, PAIR_GRAIN};
use crate::pipeline::plan::{Op, Placed};
use crate::real::Scalar;
use std::sync::Arc;

/// Rows from which on a law that allows estimates is computed with them: with fewer, most of the time goes elsewhere, and the
/// digits count.
const MANY: usize = 64;

/// A pair law over the rows of its seat.
pub(crate) struct PairPass<P: Scalar> {
    pub(crate) law: usize,
    pub(crate) kernel: Arc<dyn PairKernel<P>>,
    pub(crate) rows: usize,
    pub(crate) slots: Vec<*mut P>,
    /// By slot, what rounding added to a coordinate, or null; none where the law does not look at that.
    pub(crate) rests: Vec<*mut P>,
    pub(crate) transfers: Vec<Transfer<P>>,
    pub(crate) packed: Vec<Aligned<P>>,
    pub(crate) energy: bool,
    /// Whether the sums that it adds to begin with it: its shares are stored.
    pub(crate) first: bool,
    pub(crate) threads: usize,
    /// Whether the law is computed with estimates.
    pub(crate) estimates: bool,
    /// What looking at each pair once takes, where it pays.
    pub(crate) once: Option<Once<P>>,
    /// What a law that ends at a distance keeps.
    pub(crate) near: Option<Box<Neighbours<P>>>,
    /// What a law with a far field keeps.
    pub(crate) far: Option<Box<FarField<P>>>,
    /// Whether it is one call of the kernel, on numbers where they stand.
    pub(crate) is_one_call: bool,
    /// Keeps the constants that `slots` points to.
    pub(crate) _defaults: Aligned<P>,
}

impl<P: Scalar> Binder<'_, P> {
    /// Ties a pair law to the columns of its rows; what is not in one piece there is packed.
    pub(super) fn pair(&self, op: &Placed, kernel: &Arc<dyn PairKernel<P>>) -> Option<PairPass<P>> {
        let Op::Law { seat, energy, first, .. } = op.op else { return None };
        let law = self.pipeline.registry.seats[seat].law;
        let rows = op.rows.as_ref().map_or(self.state.domains[op.domain].rows, Vec::len);
        if rows == 0 {
            return None;
        }
        let defaults = defaults::<P>(&op.operands);
        let mut pass = PairPass {
            law,
            kernel: kernel.clone(),
            rows,
            slots: Vec::new(),
            rests: Vec::new(),
            transfers: Vec::new(),
            packed: Vec::new(),
            energy,
            first,
            threads: if kernel.splits() { threads(op.backend, rows * rows, PARALLEL_PAIRS, self.machine) } else { 1 },
            estimates: false,
            once: None,
            near: None,
            far: None,
            is_one_call: false,
            _defaults: defaults,
        };
        for (slot, operand) in op.operands.iter().enumerate() {
            let pointer = match operand {
                Operand::Default(_) => pass._defaults.pointer().wrapping_add(slot),
                Operand::Absent | Operand::Zero | Operand::Field(..) => core::ptr::null_mut(),
                Operand::Constant(..) => match self.locate(*operand)?.base {
                    Base::Owned(pointer) => pointer,
                    Base::Lent { .. } => return None,
                },
                Operand::Quantity(..)
                | Operand::Rate(..)
                | Operand::Turned(..)
                | Operand::Held(..)
                | Operand::Previous(..) => {
                    let located = self.locate(*operand)?;
                    match located.base {
                        Base::Owned(pointer) if op.rows.is_none() && located.stride == 1 => pointer,
                        _ => {
                            let scratch = pass.packed.len();
                            pass.packed.push(Aligned::zeros(rows, slot));
                            pass.transfers.push(Self::transfer(&located, op.rows.as_deref(), scratch, op.writes[slot]));
                            pass.packed[scratch].pointer()
                        }
                    }
                }
            };
            pass.slots.push(pointer);
        }
        let signature = &self.pipeline.entries[law].signature;
        pass.near = Neighbours::new(signature, &self.laws[law].compiled.parameters).map(Box::new);
        let far = self.pipeline.entries[law].options.far_field.filter(|_| kernel.is_inverse_square());
        pass.far = far.and_then(|error| FarField::new(signature, rows, error)).map(Box::new);
        if pass.near.is_none()
            && pass.far.is_none()
            && self.pipeline.takes_differences(law)
            && pass.packed.is_empty()
            && !energy
        {
            let rest = |operand: &Operand| match *operand {
                Operand::Quantity(id, component) => self.pipeline.vectors.rest(id, component),
                _ => None,
            };
            let rests = op.operands.iter().map(rest);
            pass.rests = rests.map(|rest| rest.unwrap_or(core::ptr::null_mut())).collect();
            // Coordinates that laws do not move have none.
            let coordinates = coordinate_slots(self.pipeline.entries[law].signature.ports);
            if pass.rests.iter().enumerate().any(|(slot, rest)| rest.is_null() && coordinates >> slot & 1 == 1) {
                pass.rests.clear();
            }
        }
        pass.estimates = signature.estimates && self.machine.estimates && pass.rests.is_empty() && rows >= MANY;
        let once = pass.estimates
            && signature.antisymmetric
            && pass.near.is_none()
            && pass.far.is_none()
            && rows >= PAYS
            && !energy;
        pass.once = once.then(|| Once::new(rows, pass.kernel.added(), pass.threads));
        let plain =
            pass.once.is_none() && pass.near.is_none() && pass.far.is_none() && pass.transfers.is_empty() && !energy;
        pass.is_one_call = plain && (pass.threads == 1 || rows <= PAIR_GRAIN);
        Some(pass)
    }
}
