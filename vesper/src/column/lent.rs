//! The client's own memory, used in place: interleaved, as clients and graphics interfaces have it.
//!
//! In: a vector of values, or raw memory. Out: a handle that client and engine share; the engine holds it while it
//! advances, the client between frames. Never: a copy.

use crate::error::Fault;
use crate::real::Scalar;
use core::ptr::NonNull;
use core::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard, TryLockError};

/// Values that the client keeps and lends to a column, `N` numbers per row, one row after the other.
///
/// ```
/// use vesper::prelude::*;
/// let positions = Lent::new(vec![[0.0_f32, 0.0, 10.0]; 3]);
/// let bodies = Domain::new("bodies").lend(Position, &positions);
/// assert_eq!(positions.read()[2], [0.0, 0.0, 10.0]);
/// ```
#[derive(Debug)]
pub struct Lent<P, const N: usize>(Arc<Shared<P, N>>);

#[derive(Debug)]
struct Shared<P, const N: usize> {
    memory: RwLock<Memory<P, N>>,
    /// How often the client asked to change it.
    changes: AtomicU64,
    /// Rows, as they were when somebody last could look.
    rows: AtomicUsize,
}

impl<P, const N: usize> Clone for Lent<P, N> {
    fn clone(&self) -> Self {
        Lent(Arc::clone(&self.0))
    }
}

/// A vector that moved in, or memory that somebody else owns.
#[derive(Debug)]
pub enum Memory<P, const N: usize> {
    /// A vector that moved in; rows can be added and removed.
    Vector(Vec<[P; N]>),
    /// Memory of somebody else; its rows are fixed.
    Raw(RawRows<P, N>),
}

/// Rows in memory of somebody else; only [`Lent::from_raw`] makes them.
#[derive(Debug)]
pub struct RawRows<P, const N: usize> {
    start: NonNull<[P; N]>,
    rows: usize,
}

// SAFETY: whoever made a `Raw` promised that nobody else touches the memory while a guard is out.
unsafe impl<P: Send, const N: usize> Send for Memory<P, N> {}
// SAFETY: as above.
unsafe impl<P: Sync, const N: usize> Sync for Memory<P, N> {}

impl<P, const N: usize> core::ops::Deref for Memory<P, N> {
    type Target = [[P; N]];
    fn deref(&self) -> &[[P; N]] {
        match self {
            Memory::Vector(rows) => rows,
            // SAFETY: `from_raw` was promised this many readable rows.
            Memory::Raw(raw) => unsafe { core::slice::from_raw_parts(raw.start.as_ptr(), raw.rows) },
        }
    }
}

impl<P, const N: usize> core::ops::DerefMut for Memory<P, N> {
    fn deref_mut(&mut self) -> &mut [[P; N]] {
        match self {
            Memory::Vector(rows) => rows,
            // SAFETY: `from_raw` was promised this many writable rows.
            Memory::Raw(raw) => unsafe { core::slice::from_raw_parts_mut(raw.start.as_ptr(), raw.rows) },
        }
    }
}

impl<P, const N: usize> Lent<P, N> {
    /// Lends the values of a vector, which moves in without being copied.
    pub fn new(rows: Vec<[P; N]>) -> Self {
        Lent::of(Memory::Vector(rows))
    }

    /// Lends memory that somebody else owns.
    ///
    /// # Safety
    /// `start` points to `rows` rows of `N` numbers, which stay valid while this handle, a clone of it, or a handle that
    /// the memory is swapped into lives, and which nobody touches while the engine advances or a guard is out.
    pub unsafe fn from_raw(start: NonNull<[P; N]>, rows: usize) -> Self {
        Lent::of(Memory::Raw(RawRows { start, rows }))
    }

    fn of(memory: Memory<P, N>) -> Self {
        let rows = AtomicUsize::new(memory.len());
        Lent(Arc::new(Shared { memory: RwLock::new(memory), changes: AtomicU64::new(0), rows }))
    }

    /// The memory to look at, unless somebody changes it: whoever waited for a guard of their own thread would wait
    /// forever.
    fn try_read(&self) -> Option<RwLockReadGuard<'_, Memory<P, N>>> {
        match self.0.memory.try_read() {
            Ok(memory) => Some(memory),
            Err(TryLockError::Poisoned(memory)) => Some(memory.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    fn try_write(&self) -> Option<RwLockWriteGuard<'_, Memory<P, N>>> {
        match self.0.memory.try_write() {
            Ok(memory) => Some(memory),
            Err(TryLockError::Poisoned(memory)) => Some(memory.into_inner()),
            Err(TryLockError::WouldBlock) => None,
        }
    }

    /// The values, to look at. While the guard lives the engine answers [`Fault::Borrowed`].
    pub fn read(&self) -> RwLockReadGuard<'_, Memory<P, N>> {
        self.0.memory.read().unwrap_or_else(PoisonError::into_inner)
    }

    /// The values, to change. While the guard lives the engine answers [`Fault::Borrowed`].
    pub fn write(&self) -> RwLockWriteGuard<'_, Memory<P, N>> {
        self.0.changes.fetch_add(1, Ordering::Relaxed);
        self.0.memory.write().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A lent column of any width, as a column sees it.
pub(crate) trait LentMemory<P>: Send + Sync + core::fmt::Debug {
    fn rows(&self) -> usize;
    fn width(&self) -> usize;
    /// How often the client asked to change it; `None` where it can change without asking.
    fn changes(&self) -> Option<u64>;
    /// Runs `then` with the numbers, one row after the other, unless the client changes them.
    fn look(&self, then: &mut dyn FnMut(&[P]));
    /// Runs `then` with the numbers and the count of rows, while nobody else can touch them. False if somebody does.
    fn hold(&self, then: &mut dyn FnMut(*mut P, usize)) -> bool;
    /// Adds rows of these numbers, if the memory can grow.
    fn extend(&self, numbers: &[P]) -> Result<(), &'static str>;
    /// Keeps the rows that `keep` says, if the memory can shrink.
    fn retain(&self, keep: &[bool]) -> Result<(), &'static str>;
    /// Why rows cannot be added or removed: `None` inside where the client has a guard out.
    fn fixed(&self) -> Result<(), Option<&'static str>>;
    /// Whether the client has a guard out that keeps others from looking, or from changing.
    fn busy(&self, change: bool) -> bool;
    /// Where the memory is known: the same for all columns that it is lent to.
    fn identity(&self) -> *const ();
    /// A number; 0 while the client changes them: whoever must know asks `busy` first.
    fn get(&self, row: usize, component: usize) -> P;
    /// Changes a number, unless the client looks at them.
    fn set(&self, row: usize, component: usize, value: P);
}

const FIXED: &str = "is raw memory of a fixed number of rows";
const HELD: &str = "is held: let go of it first";

impl<P: Scalar, const N: usize> LentMemory<P> for Lent<P, N> {
    fn rows(&self) -> usize {
        if let Some(memory) = self.try_read() {
            self.0.rows.store(memory.len(), Ordering::Relaxed);
        }
        self.0.rows.load(Ordering::Relaxed)
    }
    fn changes(&self) -> Option<u64> {
        let raw = self.try_read().is_some_and(|memory| matches!(*memory, Memory::Raw(..)));
        (!raw).then(|| self.0.changes.load(Ordering::Relaxed))
    }
    fn look(&self, then: &mut dyn FnMut(&[P])) {
        if let Some(memory) = self.try_read() {
            then(memory.as_flattened());
        }
    }
    fn width(&self) -> usize {
        N
    }
    fn hold(&self, then: &mut dyn FnMut(*mut P, usize)) -> bool {
        let Some(mut memory) = self.try_write() else { return false };
        let (start, rows) = (memory.as_mut_ptr().cast(), memory.len());
        then(start, rows);
        true
    }
    fn extend(&self, numbers: &[P]) -> Result<(), &'static str> {
        let Some(mut memory) = self.try_write() else { return Err(HELD) };
        match &mut *memory {
            Memory::Vector(rows) => {
                rows.extend(numbers.as_chunks::<N>().0);
                Ok(())
            }
            Memory::Raw(..) => Err(FIXED),
        }
    }
    fn retain(&self, keep: &[bool]) -> Result<(), &'static str> {
        let Some(mut memory) = self.try_write() else { return Err(HELD) };
        match &mut *memory {
            Memory::Vector(rows) => {
                let mut kept = keep.iter();
                rows.retain(|_| kept.next().copied().unwrap_or(true));
                Ok(())
            }
            Memory::Raw(..) => Err(FIXED),
        }
    }
    fn fixed(&self) -> Result<(), Option<&'static str>> {
        match self.try_write() {
            None => Err(None),
            Some(memory) if matches!(*memory, Memory::Raw(..)) => Err(Some(FIXED)),
            Some(_) => Ok(()),
        }
    }
    fn busy(&self, change: bool) -> bool {
        if change { self.try_write().is_none() } else { self.try_read().is_none() }
    }
    fn identity(&self) -> *const () {
        Arc::as_ptr(&self.0).cast()
    }
    fn get(&self, row: usize, component: usize) -> P {
        self.try_read().and_then(|memory| Some(memory.get(row)?[component])).unwrap_or_default()
    }
    fn set(&self, row: usize, component: usize, value: P) {
        if let Some(to) = self.try_write().as_mut().and_then(|memory| memory.get_mut(row)) {
            to[component] = value;
        }
    }
}

impl Fault {
    pub(crate) fn lent_twice(domain: &str, property: &str, first: &str) -> Fault {
        let why = format!("is lent to {first} already: lend each column memory of its own");
        Fault::client_memory(domain, property, "be lent twice", &why)
    }

    pub(crate) fn client_memory(domain: &str, property: &str, cannot: &str, why: &str) -> Fault {
        Fault::ClientMemory {
            domain: domain.to_owned(),
            property: property.to_owned(),
            cannot: cannot.to_owned(),
            mend: format!("it {why}"),
        }
    }
}
