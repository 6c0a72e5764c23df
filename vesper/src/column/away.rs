//! Numbers that are not where they belong.
//!
//! In: whoever has taken a column's numbers somewhere else, to a device say. Out: the same numbers back in the column, as soon as somebody
//! looks at it. Never: a device.

use core::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

/// Who takes the numbers of columns somewhere else. Columns are known by numbers of its own.
pub(crate) trait Elsewhere: Send + Sync {
    /// Brings the numbers of a column back to where they belong; the flag of its [`Away`] is taken down before this returns.
    fn bring(&self, column: usize);
    /// The same, and they are going to be changed there: what is elsewhere no longer counts.
    fn hand_over(&self, column: usize);
    /// The column goes: its memory is not to be touched any more.
    fn forget(&self, column: usize);
}

/// A column's knowledge of whoever takes its numbers away.
pub(crate) struct Away {
    who: Arc<dyn Elsewhere>,
    column: usize,
    /// Whether newer numbers than the column's are elsewhere. Only changed while an engine runs, which nobody looks at then, and from
    /// true to false under the lock of `who`.
    stale: Arc<AtomicBool>,
}

impl Away {
    #[cfg(feature = "gpu")]
    pub(crate) fn new(who: Arc<dyn Elsewhere>, column: usize, stale: Arc<AtomicBool>) -> Self {
        Away { who, column, stale }
    }

    /// Whether newer numbers than the column's are elsewhere.
    pub(crate) fn is_stale(&self) -> bool {
        self.stale.load(Ordering::Acquire)
    }

    /// Has the numbers brought back, for somebody who looks at them.
    #[inline]
    pub(crate) fn bring(&self) {
        if self.is_stale() {
            self.who.bring(self.column);
        }
    }

    /// Has the numbers brought back, for somebody who changes them.
    pub(crate) fn hand_over(&self) {
        self.who.hand_over(self.column);
    }
}

impl Drop for Away {
    fn drop(&mut self) {
        self.who.forget(self.column);
    }
}
