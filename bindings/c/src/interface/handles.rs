//! Handles: numbers that stand for values, looked up on every call.
//!
//! In: a value, and the number that it is known by from then on. Out: the value, to the one thread that has it, while no other
//! call on it is under way; words for every other case. Never: a lock, or an instruction that other processors wait for, on the
//! way to a value; the value of a number that was freed, also where its place is taken again.
//!
//! A value belongs to the thread that made it, until that thread lets go of it or ends: the next one that calls has it then. So
//! a call looks at memory that only its own thread writes, and takes no lock: an atomic exchange would add 9 ns to each call
//! instead of 4 (`cargo run --release --example step_cost`).

use super::engine::Held;
use super::failure::{
    Failure, VESPER_ERROR_HANDLE, VESPER_ERROR_LIMIT, VESPER_ERROR_PANIC, VESPER_ERROR_THREAD, caught,
};
use crate::session::Assembly;
use core::ptr;
use std::cell::{Cell, UnsafeCell};
use std::sync::atomic::{AtomicPtr, AtomicU32, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

/// All that are being put together.
pub(super) static ASSEMBLIES: Table<Assembly> = Table::new("builder");
/// All engines.
pub(super) static ENGINES: Table<Held> = Table::new("engine");

/// Slots that are made at a time, and how often.
const CHUNK: usize = 256;
const CHUNKS: usize = 256;

/// In place of a thread's number: nobody has the value, the next thread that calls does.
const NOBODY: u64 = u64::MAX - 1;
/// The same of a value that can only be freed.
const NOBODY_BROKEN: u64 = u64::MAX - 2;
/// In place of a thread's number: there is no value.
const EMPTY: u64 = u64::MAX;
/// Beside a thread's number: a call is under way.
const BUSY: u64 = 1 << 62;
/// Beside a thread's number: a call ended in a panic, the value can only be freed.
const BROKEN: u64 = 1 << 61;

/// A place for values, one after the other.
struct Slot<T> {
    /// How often a value came and went: odd while there is one. The upper half of a handle says which one is meant.
    generation: AtomicU32,
    /// The number of the thread that has the value, which alone changes it, but from [`NOBODY`] and [`EMPTY`].
    owner: AtomicU64,
    /// The value; only the owner touches it, and it goes from one to the next by a release of the one and an acquire of the
    /// other.
    value: UnsafeCell<Option<Box<T>>>,
}

/// Slots that are free, and how many were made.
struct Free {
    list: Vec<u32>,
    made: u32,
}

/// Values by their handles.
pub(super) struct Table<T: 'static> {
    what: &'static str,
    /// Each null, or so many slots, which stay for the life of the program.
    chunks: [AtomicPtr<Slot<T>>; CHUNKS],
    free: Mutex<Free>,
}

impl<T: Send> Table<T> {
    const fn new(what: &'static str) -> Self {
        let free = Mutex::new(Free { list: Vec::new(), made: 0 });
        Table { what, chunks: [const { AtomicPtr::new(ptr::null_mut()) }; CHUNKS], free }
    }

    /// Keeps a value for this thread.
    pub(super) fn insert(&'static self, value: T) -> Result<u64, Failure> {
        let index = self.free_slot()?;
        let Some(slot) = self.slot(index.into()) else { return Err(self.unknown(index.into())) };
        // SAFETY: the slot is free, and this thread took it from the list: nobody else touches it.
        unsafe { *slot.value.get() = Some(Box::new(value)) };
        slot.owner.store(this_thread(), Ordering::Relaxed);
        let generation = slot.generation.load(Ordering::Relaxed) + 1;
        slot.generation.store(generation, Ordering::Release);
        Ok(u64::from(generation) << 32 | u64::from(index))
    }

    /// The number of a slot that nobody else has.
    fn free_slot(&'static self) -> Result<u32, Failure> {
        let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(index) = free.list.pop() {
            return Ok(index);
        }
        let index = free.made;
        let Some(chunk) = self.chunks.get(index as usize / CHUNK) else {
            let text = format!("there are {index} {}s: free some first", self.what);
            return Err(Failure::new(VESPER_ERROR_LIMIT, text));
        };
        if (index as usize).is_multiple_of(CHUNK) {
            let slots: Vec<Slot<T>> = (0..CHUNK).map(|_| Slot::new()).collect();
            chunk.store(slots.leak().as_mut_ptr(), Ordering::Release);
        }
        free.made += 1;
        Ok(index)
    }

    /// The slot of this number, in the lower half of a handle, where it was made.
    #[inline(always)]
    fn slot(&'static self, handle: u64) -> Option<&'static Slot<T>> {
        let index = handle as u32 as usize;
        let chunk = self.chunks.get(index / CHUNK)?.load(Ordering::Acquire);
        // SAFETY: a chunk that is there has so many slots, for the life of the program.
        (!chunk.is_null()).then(|| unsafe { &*chunk.add(index % CHUNK) })
    }

    /// Runs a call with the value, which nobody else can touch meanwhile. After a panic the value can only be freed.
    #[inline]
    pub(super) fn with<R>(
        &'static self,
        handle: u64,
        call: impl FnOnce(&mut T) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        let me = THREAD.get();
        // The owner knows that there is a value, so a generation that agrees is that of one.
        let mine = |slot: &&Slot<T>| {
            slot.owner.load(Ordering::Relaxed) == me && slot.generation.load(Ordering::Relaxed) == (handle >> 32) as u32
        };
        let Some(slot) = self.slot(handle).filter(mine) else { return self.with_others(handle, call) };
        // SAFETY: this thread has the value, and no call on it is under way.
        let Some(value) = (unsafe { &mut *slot.value.get() }) else { return Err(self.unknown(handle)) };
        slot.owner.store(me | BUSY, Ordering::Relaxed);
        let done = caught(|| call(value));
        slot.owner.store(if done.is_ok() { me } else { me | BROKEN }, Ordering::Relaxed);
        done?
    }

    /// The same for a value that this thread does not have, if it can have it.
    #[cold]
    fn with_others<R>(
        &'static self,
        handle: u64,
        call: impl FnOnce(&mut T) -> Result<R, Failure>,
    ) -> Result<R, Failure> {
        self.whole(handle)?;
        self.with(handle, call)
    }

    /// The slot of a handle that is this thread's, or becomes so, and whose value no panic left half done.
    fn whole(&'static self, handle: u64) -> Result<&'static Slot<T>, Failure> {
        let slot = self.mine(handle)?;
        if slot.owner.load(Ordering::Relaxed) & BROKEN == 0 {
            return Ok(slot);
        }
        Err(self.half_done())
    }

    #[cold]
    fn half_done(&self) -> Failure {
        let text = format!("an earlier call left this {} half done when it panicked: free it", self.what);
        Failure::new(VESPER_ERROR_PANIC, text)
    }

    /// Takes a value away that no panic left half done: its handle is none any more, whatever comes of it.
    pub(super) fn remove_whole(&'static self, handle: u64) -> Result<Box<T>, Failure> {
        let slot = self.mine(handle)?;
        let broken = slot.owner.load(Ordering::Relaxed) & BROKEN != 0;
        let value = self.remove(handle)?;
        if broken { Err(self.half_done()) } else { Ok(value) }
    }

    /// Takes a value away: its handle is none any more.
    pub(super) fn remove(&'static self, handle: u64) -> Result<Box<T>, Failure> {
        let slot = self.mine(handle)?;
        // SAFETY: this thread has the value, and no call on it is under way.
        let Some(value) = (unsafe { (*slot.value.get()).take() }) else { return Err(self.unknown(handle)) };
        let generation = slot.generation.load(Ordering::Relaxed).wrapping_add(1);
        slot.generation.store(generation, Ordering::Release);
        slot.owner.store(EMPTY, Ordering::Release);
        // A slot whose generations have all been used is left alone.
        if generation < u32::MAX - 1 {
            let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
            free.list.push(handle as u32);
        }
        Ok(value)
    }

    /// Lets the next thread that calls have the value.
    pub(super) fn let_go(&'static self, handle: u64) -> Result<(), Failure> {
        self.whole(handle)?.owner.store(NOBODY, Ordering::Release);
        Ok(())
    }

    /// Lets go of everything that a thread has.
    fn let_go_of_all(&'static self, thread: u64) {
        let made = self.free.lock().unwrap_or_else(PoisonError::into_inner).made;
        for slot in (0..made).filter_map(|index| self.slot(index.into())) {
            match slot.owner.load(Ordering::Relaxed) {
                owner if owner == thread => slot.owner.store(NOBODY, Ordering::Release),
                owner if owner == thread | BROKEN => slot.owner.store(NOBODY_BROKEN, Ordering::Release),
                _ => {}
            }
        }
    }

    /// Whether there is a value of this handle, whoever has it.
    fn is_known(slot: &Slot<T>, handle: u64) -> bool {
        let generation = (handle >> 32) as u32;
        generation % 2 == 1 && slot.generation.load(Ordering::Acquire) == generation
    }

    /// The slot of a handle that is this thread's, or becomes so, while no call on it is under way.
    fn mine(&'static self, handle: u64) -> Result<&'static Slot<T>, Failure> {
        let slot = self.slot(handle).filter(|slot| Self::is_known(slot, handle));
        let Some(slot) = slot else { return Err(self.unknown(handle)) };
        let (me, owner) = (this_thread(), slot.owner.load(Ordering::Relaxed));
        if owner == me || owner == me | BROKEN {
            return Ok(slot);
        }
        if owner == me | BUSY {
            let text = format!("a call on this {} is under way: wait until it is done, also in a callback", self.what);
            return Err(Failure::new(VESPER_ERROR_THREAD, text));
        }
        let take = |from, to| slot.owner.compare_exchange(from, to, Ordering::Acquire, Ordering::Relaxed).is_ok();
        let left = [(NOBODY, me), (NOBODY_BROKEN, me | BROKEN)].into_iter().find(|&(from, to)| take(from, to));
        // It may have been freed, and the slot used anew, since the generation was looked at.
        match (left, Self::is_known(slot, handle)) {
            (Some(_), true) => Ok(slot),
            (Some((from, _)), false) => {
                slot.owner.store(from, Ordering::Release);
                Err(self.unknown(handle))
            }
            (None, true) => {
                let text = format!("this {} belongs to another thread: let go of it there first", self.what);
                Err(Failure::new(VESPER_ERROR_THREAD, text))
            }
            (None, false) => Err(self.unknown(handle)),
        }
    }

    #[cold]
    fn unknown(&self, handle: u64) -> Failure {
        let text = match handle {
            0 => format!("the {} is null: it was never made, or could not be", self.what),
            handle => format!("the {} {handle:#x} was freed, or never was one", self.what),
        };
        Failure::new(VESPER_ERROR_HANDLE, text)
    }
}

impl<T> Slot<T> {
    fn new() -> Self {
        Slot { generation: AtomicU32::new(0), owner: AtomicU64::new(EMPTY), value: UnsafeCell::new(None) }
    }
}

/// Lets go of what a thread has when it ends.
struct Leaving(u64);

impl Drop for Leaving {
    fn drop(&mut self) {
        ASSEMBLIES.let_go_of_all(self.0);
        ENGINES.let_go_of_all(self.0);
    }
}

thread_local! {
    /// The number of this thread; 0 while it has none, which owns nothing.
    static THREAD: Cell<u64> = const { Cell::new(0) };
    static LEAVING: Cell<Option<Leaving>> = const { Cell::new(None) };
}

/// The number of this thread, which no other one has or had.
fn this_thread() -> u64 {
    match THREAD.get() {
        0 => number_thread(),
        number => number,
    }
}

fn number_thread() -> u64 {
    static NEXT: AtomicU64 = AtomicU64::new(1);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    THREAD.set(number);
    // A thread that is ending cannot be told of its end: what it makes now stays its own.
    _ = LEAVING.try_with(|leaving| leaving.set(Some(Leaving(number))));
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values that know their own number, and how often they were used.
    static TABLE: Table<Box<(u64, u64)>> = Table::new("box");
    /// Handles that were ever made, with the number of their value.
    static MADE: Mutex<Vec<(u64, u64)>> = Mutex::new(Vec::new());

    fn at_random(state: &mut u64) -> u64 {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        *state >> 33
    }

    #[test]
    fn a_handle_never_leads_to_another_value() {
        let turns = if cfg!(miri) { 200 } else { 20_000 };
        let totals = std::thread::scope(|scope| {
            let threads = [1_u64, 2, 3, 4].map(|thread| {
                scope.spawn(move || {
                    let (mut chance, mut used, mut seen) = (thread, 0, 0);
                    for turn in 0..turns {
                        let number = thread << 32 | turn;
                        let known = MADE.lock().unwrap().clone();
                        let pick = known.get(at_random(&mut chance) as usize % known.len().max(1)).copied();
                        match (at_random(&mut chance) % 8, pick) {
                            (0, _) | (_, None) => {
                                let handle = TABLE.insert(Box::new((number, 0))).unwrap();
                                let mut made = MADE.lock().unwrap();
                                if made.len() >= 32 {
                                    made.remove(at_random(&mut chance) as usize % 32);
                                }
                                made.push((handle, number));
                            }
                            (1, Some((handle, _))) => seen += TABLE.remove(handle).map_or(0, |value| value.1),
                            (2, Some((handle, _))) => _ = TABLE.let_go(handle),
                            (_, Some((handle, number))) => {
                                let with = |value: &mut Box<(u64, u64)>| {
                                    assert_eq!(value.0, number, "the value of another handle");
                                    value.1 += 1;
                                    Ok(())
                                };
                                used += u64::from(TABLE.with(handle, with).is_ok());
                            }
                        }
                    }
                    (used, seen)
                })
            });
            threads.map(|thread| thread.join().unwrap())
        });
        let (used, seen) = totals.iter().fold((0, 0), |sum, total| (sum.0 + total.0, sum.1 + total.1));
        assert!(used > 0 && seen <= used, "{used} uses, {seen} of them in values that were freed");
    }

    #[test]
    fn what_panicked_can_only_be_freed() {
        let handle = TABLE.insert(Box::new((0, 0))).unwrap();
        let broken = TABLE.with(handle, |_| -> Result<(), Failure> { panic!("on purpose") }).unwrap_err();
        assert_eq!(broken.status, VESPER_ERROR_PANIC);
        assert!(broken.text.ends_with("panicked: on purpose"), "{}", broken.text);
        let after = TABLE.with(handle, |_| Ok(())).unwrap_err();
        assert_eq!(after.text, "an earlier call left this box half done when it panicked: free it");
        assert!(TABLE.remove(handle).is_ok());
        assert_eq!(TABLE.with(handle, |_| Ok(())).unwrap_err().status, VESPER_ERROR_HANDLE);
    }

    #[test]
    fn what_panicked_is_not_built_and_can_be_freed_when_its_thread_has_ended() {
        let broken = || {
            let handle = ASSEMBLIES.insert(Assembly::new(crate::session::NumberType::F64).unwrap()).unwrap();
            ASSEMBLIES.with(handle, |_| -> Result<(), Failure> { panic!("on purpose") }).unwrap_err();
            handle
        };
        let handle = broken();
        assert_eq!(ASSEMBLIES.remove_whole(handle).unwrap_err().status, VESPER_ERROR_PANIC);
        assert_eq!(ASSEMBLIES.remove(handle).unwrap_err().status, VESPER_ERROR_HANDLE);
        let left = std::thread::spawn(broken).join().unwrap();
        assert_eq!(ASSEMBLIES.with(left, |_| Ok(())).unwrap_err().status, VESPER_ERROR_PANIC);
        assert!(ASSEMBLIES.remove(left).is_ok());
    }
}
