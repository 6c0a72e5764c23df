//! Memory of the client, lent to columns and used in place.
//!
//! In: an address that the client vouches for. Out: the library's handle of it, of the width that is known at run time.
//! Never: a copy; a number that is looked at while laws run.

use core::ops::Range;
use core::ptr::NonNull;
use std::sync::{Mutex, PoisonError};
use vesper::prelude::*;

/// The memory that all engines of this process have at the moment: two may run on two threads, and each believes that its memory is
/// its own.
static IN_USE: Mutex<Vec<Range<usize>>> = Mutex::new(Vec::new());

/// Whether two pieces of memory have a byte in common.
pub(super) fn overlap(one: &Range<usize>, other: &Range<usize>) -> bool {
    one.start.max(other.start) < one.end.min(other.end)
}

/// Whether an engine has some of this memory.
pub fn is_lent(bytes: &Range<usize>) -> bool {
    IN_USE.lock().unwrap_or_else(PoisonError::into_inner).iter().any(|other| overlap(bytes, other))
}

/// Memory that one engine has; given back when dropped.
#[derive(Debug)]
pub(super) struct Taken(Range<usize>);

impl Taken {
    /// Takes these addresses, unless an engine has some of them.
    pub(super) fn new(bytes: Range<usize>) -> Option<Self> {
        let mut in_use = IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
        if in_use.iter().any(|other| overlap(&bytes, other)) {
            return None;
        }
        in_use.push(bytes.clone());
        Some(Taken(bytes))
    }

    pub(super) fn bytes(&self) -> &Range<usize> {
        &self.0
    }
}

impl Drop for Taken {
    fn drop(&mut self) {
        let mut in_use = IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(place) = in_use.iter().position(|other| *other == self.0) {
            in_use.swap_remove(place);
        }
    }
}

/// A column in memory of the client.
#[derive(Debug)]
pub(super) struct LentColumn<P: Precision> {
    pub(super) domain: String,
    pub(super) property: &'static str,
    pub(super) memory: OfWidth<P>,
    pub(super) taken: Taken,
}

/// Memory with so many numbers in a row.
#[derive(Debug)]
pub(super) enum OfWidth<P: Precision> {
    One(Lent<P, 1>),
    Three(Lent<P, 3>),
    Four(Lent<P, 4>),
}

impl<P: Precision> OfWidth<P> {
    /// Memory of `rows` rows; `None` for a width that no kind of property has.
    ///
    /// # Safety
    /// As for [`Lent::from_raw`]: `start` points to `rows` rows of `width` numbers, which stay valid while the memory is lent,
    /// and which nobody touches while the engine works with them.
    pub(super) unsafe fn new(start: NonNull<P>, rows: usize, width: usize) -> Option<Self> {
        // SAFETY: the caller promised it, for rows of this width.
        unsafe {
            Some(match width {
                1 => OfWidth::One(Lent::from_raw(start.cast(), rows)),
                3 => OfWidth::Three(Lent::from_raw(start.cast(), rows)),
                4 => OfWidth::Four(Lent::from_raw(start.cast(), rows)),
                _ => return None,
            })
        }
    }

    /// The domain with this memory as a column.
    pub(super) fn lend(&self, domain: Domain<P>, property: PropertyInfo) -> Domain<P> {
        match self {
            OfWidth::One(memory) => domain.lend(property, memory),
            OfWidth::Three(memory) => domain.lend(property, memory),
            OfWidth::Four(memory) => domain.lend(property, memory),
        }
    }

    /// Runs `then` with the numbers.
    pub(super) fn look<T>(&self, then: impl FnOnce(&[P]) -> T) -> T {
        match self {
            OfWidth::One(memory) => then(memory.read().as_flattened()),
            OfWidth::Three(memory) => then(memory.read().as_flattened()),
            OfWidth::Four(memory) => then(memory.read().as_flattened()),
        }
    }

    /// Runs `then` with the numbers, to change.
    pub(super) fn change<T>(&self, then: impl FnOnce(&mut [P]) -> T) -> T {
        match self {
            OfWidth::One(memory) => then(memory.write().as_flattened_mut()),
            OfWidth::Three(memory) => then(memory.write().as_flattened_mut()),
            OfWidth::Four(memory) => then(memory.write().as_flattened_mut()),
        }
    }
}
