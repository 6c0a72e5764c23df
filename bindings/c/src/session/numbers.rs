//! Arrays of a client: numbers of one of three types, interleaved, a row after the other.

use core::ops::Range;
use core::ptr::NonNull;

/// The type of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NumberType {
    /// `f32`, `float` in C.
    F32,
    /// `f64`, `double` in C.
    F64,
    /// Numbers of rows, `u32`.
    Rows,
}

impl NumberType {
    /// "f32", "f64" or "u32".
    pub const fn name(self) -> &'static str {
        match self {
            NumberType::F32 => "f32",
            NumberType::F64 => "f64",
            NumberType::Rows => "u32",
        }
    }
}

/// Numbers to be read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Numbers<'a> {
    /// In f32.
    F32(&'a [f32]),
    /// In f64.
    F64(&'a [f64]),
    /// Rows.
    Rows(&'a [u32]),
}

impl Numbers<'_> {
    /// How many there are.
    pub const fn len(&self) -> usize {
        match self {
            Numbers::F32(numbers) => numbers.len(),
            Numbers::F64(numbers) => numbers.len(),
            Numbers::Rows(rows) => rows.len(),
        }
    }

    /// Whether there is none.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The addresses that they take up, and their type.
    pub(super) fn place(&self) -> (Range<usize>, NumberType) {
        match self {
            Numbers::F32(numbers) => (addresses(numbers), NumberType::F32),
            Numbers::F64(numbers) => (addresses(numbers), NumberType::F64),
            Numbers::Rows(rows) => (addresses(rows), NumberType::Rows),
        }
    }

    /// In f64, which holds each of them exactly.
    pub(super) fn each(&self) -> Box<dyn Iterator<Item = f64> + '_> {
        match self {
            Numbers::F32(numbers) => Box::new(numbers.iter().map(|&number| f64::from(number))),
            Numbers::F64(numbers) => Box::new(numbers.iter().copied()),
            Numbers::Rows(rows) => Box::new(rows.iter().map(|&row| f64::from(row))),
        }
    }
}

/// Where the numbers of a slice are.
fn addresses<T>(numbers: &[T]) -> Range<usize> {
    let Range { start, end } = numbers.as_ptr_range();
    start.addr()..end.addr()
}

/// Room for numbers.
#[derive(Debug)]
pub enum NumbersMut<'a> {
    /// In f32.
    F32(&'a mut [f32]),
    /// In f64.
    F64(&'a mut [f64]),
    /// Rows.
    Rows(&'a mut [u32]),
}

impl NumbersMut<'_> {
    /// How many there is room for.
    pub const fn len(&self) -> usize {
        match self {
            NumbersMut::F32(numbers) => numbers.len(),
            NumbersMut::F64(numbers) => numbers.len(),
            NumbersMut::Rows(rows) => rows.len(),
        }
    }

    /// The addresses of the room, and the type of its numbers.
    pub(super) fn place(&self) -> (Range<usize>, NumberType) {
        match self {
            NumbersMut::F32(numbers) => Numbers::F32(numbers).place(),
            NumbersMut::F64(numbers) => Numbers::F64(numbers).place(),
            NumbersMut::Rows(rows) => Numbers::Rows(rows).place(),
        }
    }

    /// Whether there is room for none.
    pub const fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Memory that a client lends: where it begins, and how many numbers it holds.
#[derive(Clone, Copy, Debug)]
pub enum Memory {
    /// Numbers in f32.
    F32(NonNull<f32>, usize),
    /// Numbers in f64.
    F64(NonNull<f64>, usize),
}
