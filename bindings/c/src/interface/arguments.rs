//! Pointers from C as Rust has them, each looked at before it is followed.
//!
//! In: pointers, counts, codes. Out: texts, slices, places, or trouble that names the argument. Never: a null pointer that is
//! followed; an odd address.

use super::columns::{Type, VESPER_F32, VESPER_F64, VESPER_U32};
use crate::session::{NumberType, Numbers, NumbersMut, Trouble};
use core::ffi::{CStr, c_char, c_void};
use core::{ptr, slice};

pub(super) fn argument<T>(text: impl Into<String>) -> Result<T, Trouble> {
    Err(Trouble::Argument(text.into()))
}

/// A text.
///
/// # Safety
/// `text` is null, or ends with a NUL and lives for `'a`.
pub(super) unsafe fn text<'a>(text: *const c_char, what: &str) -> Result<&'a str, Trouble> {
    if text.is_null() {
        return argument(format!("{what} is null: give a text"));
    }
    // SAFETY: not null, so it is a text that ends.
    let text = unsafe { CStr::from_ptr(text) };
    text.to_str().or_else(|error| argument(format!("{what} is no UTF-8: see byte {}", error.valid_up_to())))
}

/// A text, or the empty one for null.
///
/// # Safety
/// As [`text`].
pub(super) unsafe fn text_or_empty<'a>(from: *const c_char, what: &str) -> Result<&'a str, Trouble> {
    // SAFETY: promised by the caller.
    if from.is_null() { Ok("") } else { unsafe { text(from, what) } }
}

/// Where a result goes.
///
/// # Safety
/// `place` is null, or may be written to for `'a`, by nobody else; what is there need not be a value yet.
pub(super) unsafe fn place<'a, T: Copy>(place: *mut T, empty: T, what: &str) -> Result<&'a mut T, Trouble> {
    if place.is_null() || !place.is_aligned() {
        return argument(format!("{what} is null, or at an odd address: give the address of a variable"));
    }
    // SAFETY: not null, and aligned; it is written before it is looked at.
    unsafe {
        place.write(empty);
        Ok(&mut *place)
    }
}

/// The type of numbers that a code stands for.
pub(super) fn number_type(code: Type) -> Result<NumberType, Trouble> {
    match code {
        VESPER_F32 => Ok(NumberType::F32),
        VESPER_F64 => Ok(NumberType::F64),
        VESPER_U32 => Ok(NumberType::Rows),
        other => argument(format!("the type is {other}: give VESPER_F32, VESPER_F64 or VESPER_U32")),
    }
}

/// Whether `count` values of type `T` can be at `start`; then where they begin.
fn checked<T>(start: *const c_void, count: usize, what: &str) -> Result<*const T, Trouble> {
    if count == 0 {
        return Ok(ptr::dangling());
    }
    let start = start.cast::<T>();
    if start.is_null() {
        return argument(format!("{what} is null, and not {count} values: give an array"));
    }
    if !start.is_aligned() {
        return argument(format!("{what} is at {start:p}: align it to {} bytes", align_of::<T>()));
    }
    if count.checked_mul(size_of::<T>()).is_none_or(|bytes| isize::try_from(bytes).is_err()) {
        return argument(format!("{what} has {count} values, which no memory has: say how many there are"));
    }
    Ok(start)
}

/// An array.
///
/// # Safety
/// `start` is null, or holds `count` values of type `T` that nobody changes during `'a`.
pub(super) unsafe fn array<'a, T>(start: *const c_void, count: usize, what: &str) -> Result<&'a [T], Trouble> {
    let start = checked::<T>(start, count, what)?;
    // SAFETY: it is aligned, and so large; the caller promised the rest.
    Ok(unsafe { slice::from_raw_parts(start, count) })
}

/// Numbers of some type.
///
/// # Safety
/// As [`array`], for the type of `code`.
pub(super) unsafe fn numbers<'a>(
    code: Type,
    start: *const c_void,
    count: usize,
    what: &str,
) -> Result<Numbers<'a>, Trouble> {
    // SAFETY: promised by the caller.
    unsafe {
        Ok(match number_type(code)? {
            NumberType::F32 => Numbers::F32(array(start, count, what)?),
            NumberType::F64 => Numbers::F64(array(start, count, what)?),
            NumberType::Rows => Numbers::Rows(array(start, count, what)?),
        })
    }
}

/// Room for values.
///
/// # Safety
/// As [`array`], and nobody else looks there during `'a`.
unsafe fn array_mut<'a, T>(start: *mut c_void, count: usize, what: &str) -> Result<&'a mut [T], Trouble> {
    let start = checked::<T>(start, count, what)?;
    // SAFETY: it is aligned, and so large; the caller promised the rest.
    Ok(unsafe { slice::from_raw_parts_mut(start.cast_mut(), count) })
}

/// Room for numbers of some type.
///
/// # Safety
/// As [`array_mut`], for the type of `code`.
pub(super) unsafe fn room<'a>(
    code: Type,
    start: *mut c_void,
    count: usize,
    what: &str,
) -> Result<NumbersMut<'a>, Trouble> {
    // SAFETY: promised by the caller.
    unsafe {
        Ok(match number_type(code)? {
            NumberType::F32 => NumbersMut::F32(array_mut(start, count, what)?),
            NumberType::F64 => NumbersMut::F64(array_mut(start, count, what)?),
            NumberType::Rows => NumbersMut::Rows(array_mut(start, count, what)?),
        })
    }
}
