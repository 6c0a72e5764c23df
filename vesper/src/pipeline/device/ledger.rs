//! Where the numbers of each column are valid, and what has to move before somebody touches them.
//!
//! In: who touches which columns, in order. Out: the moves that this takes, and no other. Never: a number, a device: what is planned and
//! what is done go by the same book.

use crate::backend::gpu::Access;

/// Where laws run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Host,
    Device,
}

/// What is done to a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Touch {
    pub(crate) column: usize,
    pub(crate) access: Access,
}

/// Adds what is done to a column after all that was done before in the same pass.
pub(crate) fn then(touches: &mut Vec<Touch>, touch: Touch) {
    match touches.iter_mut().find(|known| known.column == touch.column) {
        // What was written whole is known, whatever is done to it then; what was looked at first was needed.
        Some(known) if known.access == Access::Read && touch.access != Access::Read => known.access = Access::Update,
        Some(_) => {}
        None => touches.push(touch),
    }
}

/// Two bits for each column: whether the host's numbers are the newest, and whether the device's are. One of them always is.
#[derive(Clone, Debug, Default)]
pub(crate) struct Ledger {
    valid: Vec<[bool; 2]>,
}

impl Side {
    const fn other(self) -> Self {
        match self {
            Side::Host => Side::Device,
            Side::Device => Side::Host,
        }
    }
}

impl Ledger {
    /// A column that is on the host: its number.
    pub(crate) fn add(&mut self) -> usize {
        self.valid.push([true, false]);
        self.valid.len() - 1
    }

    /// How many columns there are.
    pub(crate) fn len(&self) -> usize {
        self.valid.len()
    }

    /// Whether the newest numbers of a column are here.
    pub(crate) fn is_valid(&self, side: Side, column: usize) -> bool {
        self.valid[column][side as usize]
    }

    /// Whether a column has to be brought here first.
    pub(crate) fn is_missing(&self, side: Side, touch: Touch) -> bool {
        touch.access != Access::Write && !self.is_valid(side, touch.column)
    }

    /// A column is touched here. What was missing has been brought.
    pub(crate) fn touch(&mut self, side: Side, touch: Touch) {
        let valid = &mut self.valid[touch.column];
        valid[side as usize] = true;
        valid[side.other() as usize] &= touch.access == Access::Read;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_column_moves_when_somebody_needs_it_and_only_then() {
        let mut ledger = Ledger::default();
        let column = ledger.add();
        let touch = |access| Touch { column, access };
        let mut step = |side, access| {
            let missing = ledger.is_missing(side, touch(access));
            ledger.touch(side, touch(access));
            missing
        };
        // What is overwritten is not brought; what was read is in both places; what was changed, in one.
        assert!(!step(Side::Device, Access::Write));
        assert!(step(Side::Host, Access::Read) && !step(Side::Host, Access::Read) && !step(Side::Device, Access::Read));
        assert!(!step(Side::Device, Access::Update) && step(Side::Host, Access::Update));
        assert!(step(Side::Device, Access::Read));
    }

    #[test]
    fn what_a_pass_does_is_what_it_does_first() {
        for (first, second, both) in [
            (Access::Read, Access::Write, Access::Update),
            (Access::Read, Access::Read, Access::Read),
            (Access::Write, Access::Read, Access::Write),
            (Access::Write, Access::Update, Access::Write),
            (Access::Update, Access::Write, Access::Update),
        ] {
            let mut touches = Vec::new();
            then(&mut touches, Touch { column: 3, access: first });
            then(&mut touches, Touch { column: 3, access: second });
            assert_eq!(touches, [Touch { column: 3, access: both }]);
        }
    }
}
