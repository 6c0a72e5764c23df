//! What operations of a plan are on: places of numbers, by name. Never: a pointer.

use crate::registry::QuantityId;

/// A place of numbers, by name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operand {
    Quantity(QuantityId, usize),
    Rate(QuantityId, usize),
    /// By what a momentum is turned.
    Turned(QuantityId, usize),
    /// The share of a law that is evaluated on some steps only: (seat, slot).
    Held(usize, usize),
    /// A field at the place of the row: (field, component).
    Field(usize, usize),
    /// What the last evaluation left.
    Previous(QuantityId, usize),
    Constant(QuantityId, usize),
    /// Nothing but zeros, in every row.
    Zero,
    Default(f64),
    Absent,
}

impl Operand {
    /// The quantity whose value it is, as it is now.
    pub(super) fn quantity(self) -> Option<QuantityId> {
        match self {
            Operand::Quantity(id, _) | Operand::Constant(id, _) => Some(id),
            Operand::Rate(..)
            | Operand::Turned(..)
            | Operand::Zero
            | Operand::Held(..)
            | Operand::Previous(..)
            | Operand::Field(..)
            | Operand::Default(_)
            | Operand::Absent => None,
        }
    }
}
