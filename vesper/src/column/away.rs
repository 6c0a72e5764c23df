//! Numbers that are not where they belong.
//!
//! In: whoever has taken a column's numbers somewhere else, to a device say. Out: the same numbers back in the column, as soon as somebody
//! looks at it. Never: a device.

use core::sync::atomic::{AtomicBool, Ordering};
use std::sync::Arc;

/// Who takes the numbers of columns somewhere else. Columns are known by numbers of its own.
pub(crate) trait Elsewhere: Send + Sync {
    /// Brings the numbers of a column back to where they belong; its [`Flags`] say so before this returns.
    fn bring(&self, column: usize);
    /// The same, and they are going to be changed there: what is elsewhere no longer counts.
    fn hand_over(&self, column: usize);
    /// The column goes: its memory is not to be touched any more.
    fn forget(&self, column: usize);
}

/// What is known of a column without asking who has its numbers. Who that is changes them: to true only while an engine runs, which nobody
/// looks at then.
#[derive(Debug, Default)]
pub(crate) struct Flags {
    /// Whether newer numbers than the column's are elsewhere.
    stale: AtomicBool,
    /// Whether its numbers are elsewhere, too.
    copied: AtomicBool,
}

impl Flags {
    #[cfg(feature = "gpu")]
    pub(crate) fn set(&self, stale: bool, copied: bool) {
        self.copied.store(copied, Ordering::Release);
        // Last: whoever sees that it is not stale sees its numbers.
        self.stale.store(stale, Ordering::Release);
    }
}

/// A column's knowledge of whoever takes its numbers away.
pub(crate) struct Away {
    who: Arc<dyn Elsewhere>,
    column: usize,
    flags: Arc<Flags>,
}

impl Away {
    #[cfg(feature = "gpu")]
    pub(crate) fn new(who: Arc<dyn Elsewhere>, column: usize, flags: Arc<Flags>) -> Self {
        Away { who, column, flags }
    }

    /// Whether newer numbers than the column's are elsewhere.
    pub(crate) fn is_stale(&self) -> bool {
        self.flags.stale.load(Ordering::Acquire)
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
        if self.is_stale() || self.flags.copied.load(Ordering::Acquire) {
            self.who.hand_over(self.column);
        }
    }
}

impl Drop for Away {
    fn drop(&mut self) {
        self.who.forget(self.column);
    }
}
