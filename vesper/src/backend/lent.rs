//! Laws that somebody else calls: the other side of [`super::foreign`].
//!
//! In: a kernel of rows, lent to a host that was compiled apart. Out: a function as C has them, from which no panic comes. Never: what
//! the host is told of a panic.

use super::row::{RowCall, RowKernel};
use crate::real::Isa;
use core::any::Any;
use core::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Computes a [`RowCall`] in the instructions of this number; not 0 where it panicked. `this` begins with a [`Lent`].
pub(crate) type LentRows = unsafe extern "C" fn(this: *mut c_void, call: *const c_void, isa: u32) -> i32;

/// Places for sets of instructions: a power of two.
const INSTRUCTIONS: usize = 8;

/// What a law begins with that a host calls.
#[repr(C)]
pub(crate) struct Lent {
    /// Its kernels of rows, in single and in double precision.
    kernels: [*const c_void; 2],
    /// By their numbers; scalar ones for those that are not there.
    instructions: [Isa; INSTRUCTIONS],
    /// What is done after a panic, and what the host is told.
    panicked: fn(&Lent, &(dyn Any + Send)) -> i32,
}

impl Lent {
    pub(crate) fn new(kernels: [*const c_void; 2], panicked: fn(&Lent, &(dyn Any + Send)) -> i32) -> Self {
        let mut instructions = [Isa::Scalar; INSTRUCTIONS];
        for (to, isa) in instructions.iter_mut().zip(Isa::available()) {
            *to = isa;
        }
        Lent { kernels, instructions, panicked }
    }

    /// The instructions of this number. Whoever says nothing of them promises no room behind the last row either.
    #[inline(always)]
    pub(crate) fn isa(&self, number: u32) -> Isa {
        self.instructions[number as usize % INSTRUCTIONS]
    }
}

/// The function of a kernel of type `K`. A virtual call inside of it would cost as much again (2 ns).
///
/// # Safety
/// `this` begins with a [`Lent`] whose kernel of this precision is a `K`; for the rest as for [`RowKernel::run`].
pub(crate) unsafe extern "C" fn lent_rows<P, K: RowKernel<P>>(this: *mut c_void, call: *const c_void, isa: u32) -> i32 {
    // SAFETY: passed on to the caller.
    let lent = unsafe { &*this.cast_const().cast::<Lent>() };
    // SAFETY: as above.
    let went = catch_unwind(AssertUnwindSafe(|| unsafe {
        let kernel = &*lent.kernels[usize::from(size_of::<P>() == 8)].cast::<K>();
        kernel.run(lent.isa(isa), &*call.cast::<RowCall<'_, P>>());
    }));
    // Apart, so that a call saves no more registers than it needs.
    went.map_or_else(|panic| panicked(lent, panic), |()| 0)
}

#[cold]
#[inline(never)]
fn panicked(lent: &Lent, panic: Box<dyn Any + Send>) -> i32 {
    (lent.panicked)(lent, &*panic)
}
