//! What an integrator that uses the structure of its problem looks at: the numbers of one property of one domain.
//!
//! In: what a system has found. Out: a key to it, and how many numbers there are. Never: a place in memory.

/// A property of a domain, as [`super::System::find`] found it. It holds until the integrator is restarted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quantity {
    pub(crate) at: At,
    pub(crate) rows: usize,
    pub(crate) width: usize,
}

/// Where it is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum At {
    /// Among the states, by number.
    State(usize),
    /// In a column of this domain.
    Column { domain: usize, column: usize },
}

impl Quantity {
    /// How many rows there are.
    pub fn rows(self) -> usize {
        self.rows
    }

    /// Numbers in a row: 3 of a vector.
    pub fn width(self) -> usize {
        self.width
    }
}
