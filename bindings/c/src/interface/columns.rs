//! Columns as C sees them: types of numbers, arrays for new rows, and where the numbers of a column are.

use super::declare::{constants, records};
use crate::session::{NumberType, View};
use core::ffi::{c_char, c_void};

/// The type of the numbers of an array: `vesper_type`.
pub type Type = u32;

constants! {
    /// The types of numbers.
    TYPES: Type;
    /// `float`.
    VESPER_F32 = 1;
    /// `double`.
    VESPER_F64 = 2;
    /// `uint32_t`: rows of a domain.
    VESPER_U32 = 3;
}

constants! {
    /// What a view is for.
    ACCESSES: u32;
    /// To look at.
    VESPER_READ = 0;
    /// To change.
    VESPER_WRITE = 1;
}

records! {
    /// The structures of columns.
    COLUMN_RECORDS;

    /// Where the numbers of a column are.
    struct ColumnView = vesper_column {
        /// Where each component begins.
        component: [*mut c_void; 4],
        /// The rows that have a value; null where all have.
        subset: *const u32,
        /// How many values there are.
        rows: usize,
        /// From one value to the next, in numbers.
        stride: usize,
        /// Numbers in a value.
        width: u32,
        /// Their type.
        type_: Type,
    }

    /// Values for new rows.
    struct Values = vesper_values {
        /// The property, with a unit or without.
        property: *const c_char,
        /// The numbers, row after row.
        numbers: *const c_void,
        /// How many numbers.
        count: usize,
        /// Their type.
        type_: Type,
    }
}

impl ColumnView {
    /// What stands there before a call, and after one that failed.
    pub(super) const EMPTY: ColumnView = ColumnView {
        component: [core::ptr::null_mut(); 4],
        subset: core::ptr::null(),
        rows: 0,
        stride: 0,
        width: 0,
        type_: 0,
    };
}

impl From<View> for ColumnView {
    fn from(view: View) -> Self {
        ColumnView {
            component: view.components,
            subset: view.subset,
            rows: view.rows,
            stride: view.stride,
            width: u32::try_from(view.width).unwrap_or(u32::MAX),
            type_: code(view.numbers),
        }
    }
}

/// The code of a type of numbers.
pub(super) const fn code(numbers: NumberType) -> Type {
    match numbers {
        NumberType::F32 => VESPER_F32,
        NumberType::F64 => VESPER_F64,
        NumberType::Rows => VESPER_U32,
    }
}
