//! In which numbers a law of a module is called, and calls of nothing, to be filled in.

use super::abi;
use super::instance::Instance;
use crate::real::{Isa, Scalar};

/// The precision of a call in numbers of this type; 0 for those that no law of a module takes.
pub(super) const fn precision<P>() -> u32 {
    match size_of::<P>() {
        4 => abi::F32,
        8 => abi::F64,
        _ => 0,
    }
}

/// What a law is called with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Numbers {
    /// The engine's.
    Own,
    /// f64, which the engine's are converted to.
    Double,
    /// f32.
    Single,
}

/// What this law is called with by an engine of this precision.
#[inline(always)]
pub(super) fn numbers<P: Scalar>(law: &Instance) -> Numbers {
    let known = law.declared.table.precisions;
    if known & precision::<P>() != 0 {
        Numbers::Own
    } else if known & abi::F64 != 0 {
        Numbers::Double
    } else {
        Numbers::Single
    }
}

/// A call of no rows.
#[inline(always)]
pub(super) const fn no_call() -> abi::Call {
    abi::Call {
        struct_size: size_of::<abi::Call>() as u32,
        precision: 0,
        begin: 0,
        end: 0,
        others_begin: 0,
        others_end: 0,
        slots: core::ptr::null(),
        strides: core::ptr::null(),
        rows: core::ptr::null(),
        links: core::ptr::null(),
        native: core::ptr::null(),
    }
}

/// What only laws of Vesper's own making look at.
#[inline(always)]
pub(super) fn native(isa: Isa) -> abi::Native {
    abi::Native {
        isa: isa.number(),
        flags: 0,
        list: core::ptr::null(),
        list_length: 0,
        own_begin: 0,
        own_end: u32::MAX,
    }
}

/// What its numbers are uncertain by.
pub(super) fn rounding<P: Scalar>(law: &Instance) -> f64 {
    match numbers::<P>(law) {
        Numbers::Own => P::EPSILON,
        Numbers::Double => P::EPSILON.max(f64::EPSILON),
        Numbers::Single => P::EPSILON.max(f64::from(f32::EPSILON)),
    }
}
