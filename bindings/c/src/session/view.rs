//! Where the numbers of a column are.

use super::NumberType;
use core::ffi::c_void;
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
}
