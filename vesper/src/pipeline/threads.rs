//! Shares work among threads. In: work in pieces, and how many threads are worth it. Out: all pieces done. Never: a piece that
//! two threads do, or an order of pieces that results depend on.
//!
//! The thread that calls takes part: it begins at once, while others still wake, which takes them longer than many a pass.

use super::run::Context;
use crate::real::Scalar;
use core::ops::Range;
use core::sync::atomic::{AtomicUsize, Ordering};
use std::sync::Mutex;

/// So many threads do this at once, each until there is nothing left to do. Comes back when all of them have: those, too, that came
/// when all was done. Asks for memory, a little for each thread.
///
/// # Safety
/// What threads do at once may be done at once: they write to different rows, and nobody reads what another one writes.
pub(super) unsafe fn together<P: Scalar>(context: &Context<'_, P>, threads: usize, work: impl Fn()) {
    #[cfg(feature = "parallel")]
    if threads > 1 {
        let work = Shared(work);
        return match &context.machine.pool {
            Some(pool) => pool.in_place_scope(|scope| work.among(scope, threads)),
            None => rayon::in_place_scope(|scope| work.among(scope, threads)),
        };
    }
    #[cfg(not(feature = "parallel"))]
    let _ = (context, threads);
    work();
}

/// Gives each desk to one of as many threads; one that is done sooner takes another desk.
pub(super) fn on_desks<P: Scalar, D: Send>(
    context: &Context<'_, P>,
    desks: &mut [D],
    work: impl Fn(usize, &mut D) + Sync,
) {
    let threads = desks.len();
    let free = Mutex::new(desks.iter_mut().enumerate());
    let take = || free.lock().unwrap_or_else(std::sync::PoisonError::into_inner).next();
    let work = || {
        while let Some((number, desk)) = take() {
            work(number, desk);
        }
    };
    // SAFETY: the work may be shared, as its type says, and a desk is taken once.
    unsafe { together(context, threads, work) };
}

/// Parts for each thread: to take one costs no more than the access to a shared number.
const PARTS: usize = 16;

/// Calls `work` with the parts of `0..count`, on as many threads; parts begin at multiples of `grain`.
///
/// # Safety
/// Different parts may be worked on at once: they are of different rows.
#[inline]
pub(super) unsafe fn in_parts<P: Scalar>(
    context: &Context<'_, P>,
    threads: usize,
    count: usize,
    grain: usize,
    work: impl Fn(Range<usize>),
) {
    if threads <= 1 || count <= grain {
        return work(0..count);
    }
    // More parts than threads, so that a thread that is late does not hold up the others: it has one of them at most. No sum
    // crosses a part, so that any number of threads gives the same bits.
    let parts = count.div_ceil(grain);
    let each = parts.div_ceil((threads * PARTS).min(parts)) * grain;
    let next = AtomicUsize::new(0);
    let work = || {
        loop {
            let start = next.fetch_add(each, Ordering::Relaxed);
            if start >= count {
                return;
            }
            work(start..(start + each).min(count));
        }
    };
    // SAFETY: each part is taken once; else passed on to the caller.
    unsafe { together(context, threads.min(count.div_ceil(each)), work) };
}

/// Work that threads share, which follows pointers.
#[cfg(feature = "parallel")]
struct Shared<F>(F);

// SAFETY: `together`, the only one who makes it, is promised that threads may do the work at once.
#[cfg(feature = "parallel")]
unsafe impl<F> Sync for Shared<F> {}

#[cfg(feature = "parallel")]
impl<F: Fn()> Shared<F> {
    fn among<'scope>(&'scope self, scope: &rayon::Scope<'scope>, threads: usize) {
        for _ in 1..threads {
            scope.spawn(|_| self.run());
        }
        self.run();
    }

    fn run(&self) {
        (self.0)();
    }
}
