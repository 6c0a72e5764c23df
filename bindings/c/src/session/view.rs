//! Where the numbers of a column are.

use super::NumberType;
use super::lending::overlap;
use core::ffi::c_void;
use core::ops::Range;
use core::ptr;

/// A column in place: number `component` of value `index` is at `components[component]`, `index * stride` numbers further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct View {
    /// Where each component begins: x, y, z, w; null beyond the width. Of a link with more than four ends the rest follow the
    /// fourth.
    pub components: [*mut c_void; 4],
    /// The rows that have a value, ascending, as many as there are values; null where all rows have one.
    pub subset: *const u32,
    /// How many values there are.
    pub rows: usize,
    /// From one value to the next, in numbers.
    pub stride: usize,
    /// Numbers in a value.
    pub width: usize,
    /// Their type.
    pub numbers: NumberType,
}

impl View {
    /// Of arrays for each component.
    pub(super) fn split<T>(starts: impl IntoIterator<Item = *mut T>, rows: usize, numbers: NumberType) -> View {
        let mut components = [ptr::null_mut(); 4];
        let mut width = 0;
        for (place, start) in components.iter_mut().zip(starts) {
            *place = start.cast();
            width += 1;
        }
        View { components, subset: ptr::null(), rows, stride: 1, width, numbers }
    }

    /// Of values that stand one behind the other.
    pub(super) fn interleaved<T>(start: *mut T, rows: usize, width: usize, numbers: NumberType) -> View {
        let starts = (0..width.min(4)).map(|component| start.wrapping_add(component));
        View { stride: width, width, ..View::split(starts, rows, numbers) }
    }

    pub(super) fn of_rows(mut self, subset: Option<&[u32]>) -> View {
        self.subset = subset.map_or(ptr::null(), <[u32]>::as_ptr);
        self
    }

    /// What a client's numbers of this type, at these addresses, are to the column.
    pub(super) fn meets(&self, (bytes, numbers): &(Range<usize>, NumberType)) -> Met {
        let size = if self.numbers == NumberType::F64 { 8 } else { 4 };
        let (pieces, length) =
            if self.stride == 1 { (self.width.min(4), self.rows) } else { (1, self.rows * self.stride) };
        let piece = |start: &*mut c_void| start.addr()..start.addr() + length * size;
        let own = self.components[..pieces].iter().map(piece);
        if pieces == 1 && *numbers == self.numbers && own.clone().all(|own| own == *bytes) {
            return Met::Itself;
        }
        if own.into_iter().any(|own| overlap(&own, bytes)) { Met::Partly } else { Met::Apart }
    }
}

/// What numbers of a client are to a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Met {
    /// Other memory.
    Apart,
    /// The column itself.
    Itself,
    /// Some of the column's memory.
    Partly,
}
