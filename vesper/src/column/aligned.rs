//! Memory of one component of an owned column: aligned to the cache line, and staggered, so that blocks of the ten
//! columns that a law reads spread over all sets of the cache.
//!
//! Behind the last number there is room for the rest of a register ([`whole`]): loops take the last rows as they take all others,
//! and leave anything there.

use core::alloc::Layout;
use core::ptr::NonNull;
use std::alloc::{alloc_zeroed, dealloc, handle_alloc_error};
use std::sync::Arc;

const CACHE_LINE: usize = 64;
/// Lines from one address to the next one with the same set of the first cache: a page, on the machines that matter.
const SETS: usize = 64;
/// From one stream's first set to the next one's: by the golden ratio, any few neighbours lie far apart. With starts in
/// one eighth of the sets, blocks of half a page of ten columns evicted each other.
const STAGGER: usize = 39;

/// Whether so many numbers are worth staggering: an eighth of the sets of the first cache.
pub(crate) const fn is_long<P>(len: usize) -> bool {
    len >= SETS / 8 * (CACHE_LINE / size_of::<P>())
}

/// Numbers with those behind them that loops may touch: where the last ones do not fill a line, half a line or a whole one, the
/// widest registers that hold them. One number alone is taken alone.
pub(crate) const fn whole<P>(len: usize) -> usize {
    let line = CACHE_LINE / size_of::<P>();
    let over = len % line;
    let room = match over {
        0 | 1 => over,
        _ if over <= line / 2 => line / 2,
        _ => line,
    };
    (len - over).saturating_add(room)
}

/// From one component to the next in a vector of several long ones: whole lines, of which few neighbours share a set.
pub(crate) const fn staggered<P>(len: usize) -> usize {
    let line = CACHE_LINE / size_of::<P>();
    let lines = len.div_ceil(line);
    (lines + (STAGGER + SETS - lines % SETS) % SETS) * line
}

/// Numbers at an aligned address that only changes in [`Aligned::resize`], and where a [`Block`] takes them in.
///
/// All access goes through one raw pointer, so a pointer taken once stays good while slices come and go.
pub(crate) struct Aligned<P> {
    start: NonNull<P>,
    len: usize,
    capacity: usize,
    /// Numbers before the first one.
    lead: usize,
    stream: usize,
    /// The block that the numbers are in; else they have memory of their own.
    block: Option<Arc<Aligned<P>>>,
}

// SAFETY: it owns its memory, or a part of a block that nobody else touches; `P` is a plain number.
unsafe impl<P: Send> Send for Aligned<P> {}
// SAFETY: as above; shared access only reads.
unsafe impl<P: Sync> Sync for Aligned<P> {}

impl<P: Copy + Default> Aligned<P> {
    /// `len` zeros. `stream` is the number of the component among those that are read together.
    pub(crate) fn zeros(len: usize, stream: usize) -> Self {
        let mut numbers = Self::empty(stream);
        numbers.resize(len);
        numbers
    }

    fn empty(stream: usize) -> Self {
        Aligned { start: NonNull::dangling(), len: 0, capacity: 0, lead: 0, stream, block: None }
    }

    fn layout(numbers: usize) -> Layout {
        let bytes = numbers.saturating_mul(size_of::<P>());
        // A request beyond the address space cannot be met by any allocator: report it as out of memory.
        Layout::from_size_align(bytes, CACHE_LINE).unwrap_or_else(|_| handle_alloc_error(Layout::new::<P>()))
    }

    /// Numbers to leave before the first one. What allocators do with columns of nearly a page is worst, a line less than a
    /// page apart: what is written to one holds up what is read from the next. Those of a few lines lie well as they are.
    fn lead(&self, capacity: usize) -> usize {
        let line = CACHE_LINE / size_of::<P>();
        if is_long::<P>(capacity) { self.stream * STAGGER % SETS * line } else { 0 }
    }

    /// Keeps the first numbers, adds zeros.
    pub(crate) fn resize(&mut self, len: usize) {
        if len > self.capacity {
            let capacity = whole::<P>(len.max(self.capacity * 2));
            let lead = self.lead(capacity);
            let layout = Self::layout(capacity.saturating_add(lead));
            // SAFETY: the layout is not empty, because `len > 0`.
            let raw = unsafe { alloc_zeroed(layout) };
            let Some(base) = NonNull::new(raw.cast::<P>()) else { handle_alloc_error(layout) };
            // SAFETY: the block has `lead + capacity` numbers.
            let start = unsafe { base.add(lead) };
            // SAFETY: both hold `len` numbers and are different blocks.
            unsafe { start.copy_from_nonoverlapping(self.start, self.len) };
            self.free();
            (self.start, self.capacity, self.lead) = (start, capacity, lead);
        } else if len > self.len {
            let from = self.len;
            self.len = len;
            self.as_mut_slice()[from..].fill(P::default());
        }
        self.len = len;
    }
}

impl<P> Aligned<P> {
    fn free(&mut self) {
        if self.block.take().is_some() {
            self.capacity = 0;
        } else if self.capacity > 0 {
            let bytes = (self.capacity + self.lead) * size_of::<P>();
            // SAFETY: this is the layout that `resize` allocated with, and `start` is `lead` numbers into the block.
            unsafe {
                let base = self.start.sub(self.lead);
                dealloc(base.as_ptr().cast(), Layout::from_size_align_unchecked(bytes, CACHE_LINE));
            }
            self.capacity = 0;
        }
    }

    pub(crate) fn as_slice(&self) -> &[P] {
        // SAFETY: `len` numbers are initialised, by zeros at least.
        unsafe { core::slice::from_raw_parts(self.start.as_ptr(), self.len) }
    }

    pub(crate) fn as_mut_slice(&mut self) -> &mut [P] {
        // SAFETY: as above, and `&mut self` is the only access.
        unsafe { core::slice::from_raw_parts_mut(self.start.as_ptr(), self.len) }
    }

    /// The first number. Good until the next `resize`, and until a block takes the numbers in.
    pub(crate) fn pointer(&self) -> *mut P {
        self.start.as_ptr()
    }
}

impl<P> Drop for Aligned<P> {
    fn drop(&mut self) {
        self.free();
    }
}

impl<P: Copy + Default> Clone for Aligned<P> {
    fn clone(&self) -> Self {
        let mut copy = Self::empty(self.stream);
        copy.resize(self.len);
        copy.as_mut_slice().copy_from_slice(self.as_slice());
        copy
    }
}

/// Memory that arrays move into, one behind the other, with room behind each ([`whole`]): then all of them are one array, too.
pub(crate) struct Block<P> {
    numbers: Arc<Aligned<P>>,
    taken: usize,
}

impl<P: Copy + Default> Block<P> {
    /// For arrays of so many numbers together.
    pub(crate) fn new(len: usize) -> Self {
        Block { numbers: Arc::new(Aligned::zeros(len, 0)), taken: 0 }
    }

    /// The next zeros of the block, as an array in it.
    pub(crate) fn zeros(&mut self, len: usize) -> Aligned<P> {
        let room = self.numbers.len - self.taken;
        assert!(whole::<P>(len) <= room, "a block has room for the arrays that it was made for");
        // SAFETY: the block has room for the numbers from there on, and nobody else has that part of it.
        let start = unsafe { self.numbers.start.add(self.taken) };
        self.taken += whole::<P>(len);
        Aligned { start, len, capacity: len, lead: 0, stream: 0, block: Some(self.numbers.clone()) }
    }

    /// Moves an array in. One that grows later moves out again.
    pub(crate) fn take_in(&mut self, array: &mut Aligned<P>) {
        let room = self.numbers.len - self.taken;
        assert!(whole::<P>(array.len) <= room, "a block has room for the arrays that it was made for");
        // SAFETY: the block has room for the numbers from there on, and nobody else has that part of it.
        let start = unsafe { self.numbers.start.add(self.taken) };
        // SAFETY: both have `len` numbers; the array is not in this block yet, since its place is behind all that are.
        unsafe { start.copy_from_nonoverlapping(array.start, array.len) };
        array.free();
        self.taken += whole::<P>(array.len);
        (array.start, array.capacity, array.lead, array.block) = (start, array.len, 0, Some(self.numbers.clone()));
    }
}

#[cfg(test)]
mod tests {
    use super::{Aligned, Block, whole};

    #[test]
    fn arrays_in_a_block_are_one_array_until_they_grow() {
        let mut arrays = [2, 0, 3].map(|len| Aligned::<f64>::zeros(len, 1));
        arrays[0].as_mut_slice().copy_from_slice(&[1.0, 2.0]);
        arrays[2].as_mut_slice().copy_from_slice(&[3.0, 4.0, 5.0]);
        let mut block = Block::new(8);
        arrays.iter_mut().for_each(|array| block.take_in(array));
        drop(block);
        // SAFETY: the arrays keep the block, and no slice of them is there.
        let all = unsafe { core::slice::from_raw_parts(arrays[0].pointer(), 8) };
        assert_eq!(all, [1.0, 2.0, 0.0, 0.0, 3.0, 4.0, 5.0, 0.0]);
        let [mut first, _, last] = arrays;
        first.resize(4);
        first.as_mut_slice().fill(7.0);
        assert_eq!((last.as_slice(), last.clone().as_slice()), ([3.0, 4.0, 5.0].as_slice(), last.as_slice()));
        let mut again = Block::new(12);
        let zeros = again.zeros(2);
        [first, last].iter_mut().for_each(|array| again.take_in(array));
        assert_eq!(zeros.as_slice(), [0.0; 2]);
    }

    #[test]
    fn numbers_survive_growth_and_new_ones_are_zero() {
        let mut numbers = Aligned::<f64>::zeros(3, 5);
        numbers.as_mut_slice().copy_from_slice(&[1.0, 2.0, 3.0]);
        numbers.resize(2);
        numbers.resize(1000);
        assert_eq!(&numbers.as_slice()[..4], &[1.0, 2.0, 0.0, 0.0]);
        assert_eq!(numbers.pointer() as usize % 64, 0);
        let copy = numbers.clone();
        drop(numbers);
        assert_eq!(copy.as_slice().len(), 1000);
    }

    #[test]
    fn a_pointer_taken_once_outlives_slices() {
        let mut numbers = Aligned::<f32>::zeros(4, 0);
        let pointer = numbers.pointer();
        numbers.as_mut_slice()[1] = 2.0;
        // SAFETY: no resize since the pointer was taken.
        assert_eq!(unsafe { *pointer.add(1) }, 2.0);
    }

    #[test]
    fn behind_the_last_number_is_room_for_the_rest_of_a_register() {
        for (len, doubles, singles) in [(0, 0, 0), (1, 1, 1), (2, 4, 8), (4, 4, 8), (5, 8, 8), (9, 9, 16), (11, 12, 16)]
        {
            assert_eq!((whole::<f64>(len), whole::<f32>(len)), (doubles, singles), "{len}");
            assert!(Aligned::<f64>::zeros(len, 0).capacity >= doubles);
        }
    }

    #[test]
    fn an_empty_column_allocates_nothing() {
        let numbers = Aligned::<f32>::zeros(0, 3);
        assert!(numbers.as_slice().is_empty());
    }
}
