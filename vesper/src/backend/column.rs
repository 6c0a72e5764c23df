//! A column law runs its own loops; this only hands it the columns.

use super::{Compiled, Kernel};
use crate::law::{ColumnAccess, ColumnFamily, ColumnLaw, DeclaredColumns};
use crate::real::Scalar;

/// A column law.
pub(crate) trait ColumnKernel<P: Scalar>: Send + Sync {
    /// # Safety
    /// `access` was made for this law's signature.
    unsafe fn run(&self, access: &ColumnAccess<'_, P>);
}

/// Makes a column law runnable.
pub fn column<P: Scalar, F: ColumnFamily>(law: &F) -> Compiled<P> {
    const { super::says_nothing_of_pairs(&F::SIGNATURE) };
    Compiled {
        signature: F::SIGNATURE,
        energy: false,
        parameters: law.parameters(),
        foreign: None,
        kernel: Kernel::Column(Box::new(law.clone())),
    }
}

impl<P: Scalar, F: ColumnFamily> ColumnKernel<P> for F {
    unsafe fn run(&self, access: &ColumnAccess<'_, P>) {
        let law = self.kernel::<P>();
        // SAFETY: passed on to the caller: the kernel and the law have one signature.
        let columns = unsafe { <F::Kernel<P> as DeclaredColumns>::columns::<P>(access) };
        law.columns(columns);
    }
}
