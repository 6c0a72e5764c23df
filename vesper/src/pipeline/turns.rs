//! Blocks that meet two by two, on any number of threads. In: who meets whom, in order. Out: every meeting, once. Never: a block in
//! two meetings at once, or one that meets others in another order than on one thread; what happens when they meet.

use core::sync::atomic::{AtomicUsize, Ordering};

/// Meetings, and how far they have come.
#[derive(Debug)]
pub(super) struct Turns {
    meetings: Vec<Meeting>,
    /// How many meetings of each block have ended.
    ended: Vec<AtomicUsize>,
    /// The first meeting that nobody has taken.
    next: AtomicUsize,
    /// Whether meetings have begun of which not all have ended.
    open: bool,
}

/// Two blocks, or one alone, meet when so many meetings of each have ended.
#[derive(Clone, Copy, Debug)]
struct Meeting {
    blocks: [usize; 2],
    after: [usize; 2],
}

impl Turns {
    /// In rounds, in each of which no block meets two others: so that those of a round can be taken at once.
    pub(super) fn new(blocks: usize, rounds: impl Iterator<Item = Vec<[usize; 2]>>) -> Self {
        let mut counts = vec![0; blocks];
        let in_order = rounds.flatten().map(|blocks| {
            let meeting = Meeting { blocks, after: blocks.map(|block| counts[block]) };
            for block in both(blocks) {
                counts[block] += 1;
            }
            meeting
        });
        let meetings = in_order.collect();
        let ended = (0..blocks).map(|_| AtomicUsize::new(0)).collect();
        Turns { meetings, ended, next: AtomicUsize::new(0), open: false }
    }

    /// How many can be held at once, after the first round of blocks alone.
    pub(super) fn at_once(&self) -> usize {
        self.ended.len().div_ceil(2)
    }

    /// All are to be held again. False where those before were not: somebody has panicked.
    pub(super) fn begin(&mut self) -> bool {
        self.ended.iter_mut().for_each(|ended| *ended.get_mut() = 0);
        *self.next.get_mut() = 0;
        !core::mem::replace(&mut self.open, true)
    }

    /// All have been held, by all threads that [`Turns::hold`] them.
    pub(super) fn end(&mut self) {
        self.open = false;
    }

    /// Takes meetings in their order, until none is left, and holds them: `meet` is told the blocks, and then `leave` each block that
    /// has met all. What was done in meetings of a block before is seen in the next one.
    ///
    /// A meeting waits for those that its blocks have before: the first one that has not ended waits for none, so that all end, if no
    /// `meet` waits for another thread.
    pub(super) fn hold(&self, meet: impl Fn([usize; 2]), leave: impl Fn(usize)) {
        while let Some(meeting) = self.meetings.get(self.next.fetch_add(1, Ordering::Relaxed)) {
            let Meeting { blocks, after } = *meeting;
            for (block, after) in both(blocks).zip(after) {
                wait(|| self.ended[block].load(Ordering::Acquire) == after);
            }
            let _ends = Ends { turns: self, meeting };
            meet(blocks);
            for (block, after) in both(blocks).zip(after) {
                // With itself, and with all others.
                if after + 1 == self.ended.len() {
                    leave(block);
                }
            }
        }
    }
}

/// The blocks of a meeting, each once.
fn both([a, b]: [usize; 2]) -> impl Iterator<Item = usize> {
    [a, b].into_iter().take(if a == b { 1 } else { 2 })
}

/// A meeting has ended when this goes, even if somebody panics in it: the other threads end theirs before that is passed on.
struct Ends<'a> {
    turns: &'a Turns,
    meeting: &'a Meeting,
}

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        // One store for each block: as soon as it is seen, the next meeting of that block may end, too.
        for (block, after) in both(self.meeting.blocks).zip(self.meeting.after) {
            self.turns.ended[block].store(after + 1, Ordering::Release);
        }
    }
}

/// Turns that are spun before the core is offered to others, who may be those that are waited for.
const SPINS: usize = 1 << 8;

fn wait(until: impl Fn() -> bool) {
    let mut turns = 0;
    while !until() {
        turns += 1;
        if turns < SPINS { core::hint::spin_loop() } else { std::thread::yield_now() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::rounds;
    use core::cell::UnsafeCell;

    /// What meets whom, block by block; nothing but the turns keeps threads apart.
    struct Books(Vec<UnsafeCell<Vec<usize>>>);

    // SAFETY: no two threads have a block at once; that is what is looked at, under Miri.
    unsafe impl Sync for Books {}

    impl Books {
        fn note([a, b]: [usize; 2], books: &Books) {
            for (own, other) in [(a, b), (b, a)] {
                // SAFETY: as above.
                unsafe { (*books.0[own].get()).push(other) };
                if a == b {
                    break;
                }
            }
        }

        fn close(block: usize, books: &Books) {
            // SAFETY: as above.
            unsafe { (*books.0[block].get()).push(usize::MAX) };
        }
    }

    fn books(turns: &mut Turns, blocks: usize, threads: usize) -> Vec<Vec<usize>> {
        assert!(turns.begin());
        let books = Books((0..blocks).map(|_| UnsafeCell::default()).collect());
        std::thread::scope(|scope| {
            for _ in 0..threads {
                scope.spawn(|| turns.hold(|blocks| Books::note(blocks, &books), |block| Books::close(block, &books)));
            }
        });
        turns.end();
        books.0.into_iter().map(UnsafeCell::into_inner).collect()
    }

    #[test]
    fn every_block_meets_all_in_the_same_order_on_any_number_of_threads() {
        let (most, times) = if cfg!(miri) { (5, 2) } else { (9, 200) };
        for blocks in 0..=most {
            let mut turns = Turns::new(blocks, rounds(blocks));
            let alone = books(&mut turns, blocks, 1);
            assert!(alone.iter().all(|met| met.len() == blocks + 1 && met[blocks] == usize::MAX), "{alone:?}");
            for threads in [2, 3, 7] {
                for _ in 0..times {
                    assert_eq!(books(&mut turns, blocks, threads), alone, "{blocks} blocks, {threads} threads");
                }
            }
        }
    }

    #[test]
    fn who_panics_holds_up_nobody_and_is_noted() {
        let mut turns = Turns::new(6, rounds(6));
        assert!(turns.begin());
        let threads = std::thread::scope(|scope| {
            let hold = || turns.hold(|blocks| assert_ne!(blocks, [0, 0], "this one gives up"), |_| ());
            [scope.spawn(hold), scope.spawn(hold)].map(|thread| thread.join().is_err())
        });
        assert_eq!(threads.iter().filter(|panicked| **panicked).count(), 1);
        assert!(turns.ended.iter().all(|ended| ended.load(Ordering::Relaxed) == 6), "all others have met");
        assert!(!turns.begin(), "and it is known that one has not");
        turns.end();
        assert!(turns.begin());
    }
}
