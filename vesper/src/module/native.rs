//! The loop of a row law that [`export_laws!`](crate::export_laws) made: a call goes there as it is.
//!
//! In: a call, as the host's loops have it. Out: the same call, to the module. Never: a copy, or more than is needed in every call: what
//! is rare is [`Rows`].

use super::instance::Instance;
use super::row::Rows;
use crate::backend::{RowCall, RowFunction, RowKernel, TangentCall};
use crate::real::{Isa, Scalar};
use std::sync::Arc;

/// A row law of a module, for engines of the precision that its function is of.
pub(super) struct NativeRows {
    law: Arc<Instance>,
    function: RowFunction,
    rows: Rows,
}

impl NativeRows {
    /// None for a law of another making.
    pub(super) fn new<P: Scalar>(law: &Arc<Instance>) -> Option<Self> {
        let function = law.native_rows::<P>()?;
        Some(NativeRows { law: law.clone(), function, rows: Rows::new::<P>(law.clone()) })
    }
}

impl NativeRows {
    /// # Safety
    /// As for [`RowKernel::run`].
    #[cold]
    #[inline(never)]
    unsafe fn nothing<P: Scalar>(&self, isa: Isa, call: &RowCall<'_, P>) {
        // SAFETY: passed on to the caller.
        unsafe { self.rows.run(isa, call) };
    }
}

impl<P: Scalar> RowKernel<P> for NativeRows {
    fn splits(&self) -> bool {
        RowKernel::<P>::splits(&self.rows)
    }

    unsafe fn run(&self, isa: Isa, call: &RowCall<'_, P>) {
        // SAFETY: the caller promises the slots, and nobody else touches their rows.
        unsafe {
            if !self.law.call_rows(self.function, call, isa) {
                // What a law that failed leaves is nothing.
                self.nothing(isa, call);
            }
        }
    }

    unsafe fn tangent(&self, call: &TangentCall<'_, P>) {
        // SAFETY: passed on to the caller.
        unsafe { self.rows.tangent(call) };
    }

    unsafe fn energy(&self, call: &RowCall<'_, P>) -> Option<f64> {
        // SAFETY: passed on to the caller.
        unsafe { self.rows.energy(call) }
    }

    #[cfg(feature = "gpu")]
    fn trace(&self, _there: u64) -> Option<crate::backend::gpu::Trace> {
        None
    }
}
