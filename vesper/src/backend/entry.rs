//! Laws that somebody else calls: the other side of [`super::foreign`].
//!
//! In: the kernels of a law of rows, for a host that was compiled apart. Out: functions as C has them, from which no panic comes, and what
//! they are given. Never: what the host is told of a panic.

use super::Kernel;
use super::row::{RowCall, RowKernel};
use crate::real::{Isa, Scalar};
use core::any::Any;
use core::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;

/// Computes a [`RowCall`] in the instructions of this number; not 0 where it panicked. `this` begins with [`Entries`].
pub(crate) type RowFunction = unsafe extern "C" fn(this: *mut c_void, call: *const c_void, isa: u32) -> i32;

/// Places for sets of instructions: a power of two.
const INSTRUCTIONS: usize = 8;

/// What a law begins with that a host calls: what comes first is looked at by the host.
#[repr(C)]
pub(crate) struct Entries {
    /// Of laws of rows, in single and in double precision.
    functions: [Option<RowFunction>; 2],
    /// The kernels that the functions are of.
    kernels: [*const c_void; 2],
    /// By their numbers; scalar ones for those that are not there.
    instructions: [Isa; INSTRUCTIONS],
    /// What is done after a panic, and what the host is told.
    panicked: unsafe fn(this: *mut c_void, panic: &(dyn Any + Send)) -> i32,
}

impl Entries {
    /// The kernels live as long.
    pub(crate) fn new(
        single: &Kernel<f32>,
        double: &Kernel<f64>,
        panicked: unsafe fn(*mut c_void, &(dyn Any + Send)) -> i32,
    ) -> Self {
        let mut instructions = [Isa::Scalar; INSTRUCTIONS];
        for (to, isa) in instructions.iter_mut().zip(Isa::available()) {
            *to = isa;
        }
        let (single, double) = (rows(single), rows(double));
        Entries { functions: [single.0, double.0], kernels: [single.1, double.1], instructions, panicked }
    }

    /// The instructions of this number. Whoever says nothing of them promises no room behind the last row either.
    #[inline(always)]
    pub(crate) fn isa(&self, number: u32) -> Isa {
        self.instructions[number as usize % INSTRUCTIONS]
    }

    /// What a host calls for rows in this precision.
    ///
    /// # Safety
    /// `this` begins with entries.
    pub(crate) unsafe fn rows_of<P>(this: *const c_void) -> Option<RowFunction> {
        // SAFETY: passed on to the caller.
        let functions = unsafe { (*this.cast::<Entries>()).functions };
        functions[place::<P>()?]
    }
}

/// Where things of this precision are.
const fn place<P>() -> Option<usize> {
    match size_of::<P>() {
        4 => Some(0),
        8 => Some(1),
        _ => None,
    }
}

/// The function of a law of rows, and its kernel.
fn rows<P>(kernel: &Kernel<P>) -> (Option<RowFunction>, *const c_void)
where
    P: Scalar,
{
    match kernel {
        Kernel::Row(kernel) => (kernel.entry(), Arc::as_ptr(kernel).cast()),
        _ => (None, core::ptr::null()),
    }
}

/// The function of a kernel of this type, in the precisions that cross.
pub(super) fn row_function<P: Scalar, K: RowKernel<P>>() -> Option<RowFunction> {
    if place::<P>().is_some() { Some(run_rows::<P, K>) } else { None }
}

/// Of one type, since a virtual call in here, and a look at the precision, took 1.5 ns of each call (`cargo bench --bench modules`).
///
/// # Safety
/// `this` begins with [`Entries`] whose kernel of this precision is a `K`; for the rest as for [`RowKernel::run`].
unsafe extern "C" fn run_rows<P, K: RowKernel<P>>(this: *mut c_void, call: *const c_void, isa: u32) -> i32 {
    // SAFETY: passed on to the caller.
    let went = catch_unwind(AssertUnwindSafe(|| unsafe {
        let entries = &*this.cast_const().cast::<Entries>();
        let kernel = &*entries.kernels[place::<P>().unwrap_or(0)].cast::<K>();
        kernel.run(entries.isa(isa), &*call.cast::<RowCall<'_, P>>());
    }));
    // Apart, so that a call saves no more registers than it needs.
    // SAFETY: as above.
    went.map_or_else(|panic| unsafe { panicked(this, panic) }, |()| 0)
}

/// # Safety
/// `this` begins with [`Entries`].
#[cold]
#[inline(never)]
unsafe fn panicked(this: *mut c_void, panic: Box<dyn Any + Send>) -> i32 {
    // SAFETY: passed on to the caller.
    unsafe { ((*this.cast::<Entries>()).panicked)(this, &*panic) }
}
