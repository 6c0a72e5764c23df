//! The memory of Java that engines use at the moment.
//!
//! In: addresses of buffers as they are lent. Out: a fault where another engine has some of them: two engines may run on two
//! threads, and each believes that its memory is its own. Never: a look at the memory.

use core::ops::Range;
use std::sync::{Mutex, PoisonError};
use vesper_c::session::Trouble;

/// All ranges in use.
static IN_USE: Mutex<Vec<Range<usize>>> = Mutex::new(Vec::new());

fn overlap(one: &Range<usize>, other: &Range<usize>) -> bool {
    one.start < other.end && other.start < one.end
}

/// Whether an engine has some of this memory.
pub(crate) fn in_use(range: &Range<usize>) -> bool {
    IN_USE.lock().unwrap_or_else(PoisonError::into_inner).iter().any(|other| overlap(range, other))
}

/// The ranges of one engine; given back when dropped.
#[derive(Debug, Default)]
pub(crate) struct Ranges(Vec<Range<usize>>);

impl Ranges {
    /// Takes a range. What this engine has itself is not its business: the session looks at that.
    pub(crate) fn take(&mut self, what: &str, range: Range<usize>) -> Result<(), Trouble> {
        if range.is_empty() {
            return Ok(());
        }
        let mut in_use = IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
        if in_use.iter().any(|other| overlap(&range, other) && !self.0.contains(other)) {
            let text = format!("{what} cannot be lent: another engine has this memory: close that one first");
            return Err(Trouble::Fault(text));
        }
        in_use.push(range.clone());
        self.0.push(range);
        Ok(())
    }
}

impl Drop for Ranges {
    fn drop(&mut self) {
        let mut in_use = IN_USE.lock().unwrap_or_else(PoisonError::into_inner);
        for range in &self.0 {
            if let Some(place) = in_use.iter().position(|other| other == range) {
                in_use.swap_remove(place);
            }
        }
    }
}
