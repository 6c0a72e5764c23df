//! Arguments from Java as Rust has them, each looked at before it is used.
//!
//! In: texts, arrays, buffers, any of them null. Out: texts, numbers, memory, or trouble that names the argument. Never: an array
//! in place, which the collector of garbage may move; a buffer that lies in the heap.

use crate::failure::{Failure, argument};
use core::ptr::NonNull;
use core::slice;
use jni::Env;
use jni::objects::{JByteBuffer, JDoubleArray, JIntArray, JObjectArray, JString};
use jni::refs::IntoAuto;
use vesper_c::session::{Memory, NumberType, NumbersMut, Trouble};

/// A text.
pub(crate) fn text(env: &Env<'_>, text: &JString<'_>, what: &str) -> Result<String, Failure> {
    if text.is_null() {
        return argument(format!("{what} is null: give a text"));
    }
    Ok(text.try_to_string(env)?)
}

/// A text, or the empty one for null.
pub(crate) fn text_or_empty(env: &Env<'_>, from: &JString<'_>, what: &str) -> Result<String, Failure> {
    if from.is_null() { Ok(String::new()) } else { text(env, from, what) }
}

/// The numbers of an array, copied.
pub(crate) fn numbers(env: &Env<'_>, array: &JDoubleArray<'_>, what: &str) -> Result<Vec<f64>, Failure> {
    let mut numbers = room(env, array, what)?;
    array.get_region(env, 0, &mut numbers)?;
    Ok(numbers)
}

/// As many zeros as an array holds.
pub(crate) fn room(env: &Env<'_>, array: &JDoubleArray<'_>, what: &str) -> Result<Vec<f64>, Failure> {
    if array.is_null() {
        return argument(format!("{what} is null: give an array"));
    }
    Ok(vec![0.0; array.len(env)?])
}

/// The rows that an array names, copied.
pub(crate) fn rows(env: &Env<'_>, array: &JIntArray<'_>, what: &str) -> Result<Vec<u32>, Failure> {
    if array.is_null() {
        return argument(format!("{what} is null: give an array of rows"));
    }
    let mut rows = vec![0; array.len(env)?];
    array.get_region(env, 0, &mut rows)?;
    let row = |row: i32| u32::try_from(row).or_else(|_| argument(format!("{what} names row {row}: rows count from 0")));
    rows.into_iter().map(row).collect()
}

/// The texts of an array.
pub(crate) fn texts(
    env: &mut Env<'_>,
    array: &JObjectArray<'_, JString<'_>>,
    what: &str,
) -> Result<Vec<String>, Failure> {
    let mut texts = Vec::new();
    for place in 0..array.len(env)? {
        let element = array.get_element(env, place)?.auto();
        texts.push(text(env, &element, what)?);
    }
    Ok(texts)
}

/// Where a direct buffer begins, and how many bytes it holds.
fn bytes(env: &Env<'_>, buffer: &JByteBuffer<'_>, what: &str) -> Result<(NonNull<u8>, usize), Failure> {
    if buffer.is_null() {
        return argument(format!("{what} is null: give a direct buffer"));
    }
    let capacity = env.get_direct_buffer_capacity(buffer);
    let start = env.get_direct_buffer_address(buffer).ok().and_then(NonNull::new);
    match (start, capacity) {
        (Some(start), Ok(capacity)) => Ok((start, capacity)),
        (None, Ok(0)) => Ok((NonNull::<f64>::dangling().cast(), 0)),
        _ => argument(format!("{what} is no direct buffer: make it by ByteBuffer.allocateDirect")),
    }
}

/// The memory of a direct buffer as numbers of a type.
pub(crate) fn memory(
    env: &Env<'_>,
    buffer: &JByteBuffer<'_>,
    precision: NumberType,
    what: &str,
) -> Result<Memory, Failure> {
    let (start, count) = bytes(env, buffer, what)?;
    let size = if precision == NumberType::F32 { 4 } else { 8 };
    if count % size != 0 {
        let name = precision.name();
        return argument(format!("{what} has {count} bytes, which are no numbers in {name} of {size} bytes each"));
    }
    Ok(match precision {
        NumberType::F32 => Memory::F32(start.cast(), count / size),
        _ => Memory::F64(start.cast(), count / size),
    })
}

/// The addresses of memory.
pub(crate) fn range(memory: Memory) -> core::ops::Range<usize> {
    let (first, bytes) = match memory {
        Memory::F32(start, count) => (start.addr().get(), count * size_of::<f32>()),
        Memory::F64(start, count) => (start.addr().get(), count * size_of::<f64>()),
    };
    first..first + bytes
}

/// Room in memory of a buffer.
///
/// # Safety
/// The memory is there during `'a`, and nobody else looks there meanwhile.
pub(crate) unsafe fn room_in<'a>(memory: Memory, what: &str) -> Result<NumbersMut<'a>, Trouble> {
    let odd = || Trouble::Argument(format!("{what} begins at an odd address: align it as its numbers are"));
    // SAFETY: it is aligned; the caller promised the rest.
    unsafe {
        Ok(match memory {
            Memory::F32(start, _) if !start.is_aligned() => return Err(odd()),
            Memory::F64(start, _) if !start.is_aligned() => return Err(odd()),
            Memory::F32(start, count) => NumbersMut::F32(slice::from_raw_parts_mut(start.as_ptr(), count)),
            Memory::F64(start, count) => NumbersMut::F64(slice::from_raw_parts_mut(start.as_ptr(), count)),
        })
    }
}
