//! Laws on graphics processors: the text of a kernel is made from the law's own body.
//!
//! In: the body that all other backends run. Out: a program in WGSL with a loop of the law's shape, and the buffers that it reads and
//! writes. Never: a second text of a law.
//!
//! The way: `trace` runs the body once over numbers that record what is done to them (`traced`); `layout` says from the signature
//! which buffers there are, and what may be done to each; `wgsl` writes the text; `check` has it parsed, validated, and compared with
//! the signature.

mod check;
mod compare;
mod device;
mod layout;
mod links;
#[cfg(test)]
mod tests;
mod trace;
mod traced;
mod wgsl;

pub(crate) use check::{Wrong, check};
pub use compare::{Comparison, NotCompared, compare};
pub use device::{Device, DeviceFault, NoDevice};
pub(crate) use device::{Prepared, Work};
pub(crate) use layout::{Access, Binding, Layout, Slot, Store};
pub(crate) use links::Ends;
pub(crate) use trace::{Trace, link, pair, row};
pub(crate) use wgpu::{BindGroup, Buffer};
pub(crate) use wgsl::{Loop, Numbers, Program, Refused, Word, write};

use super::{Compiled, Kernel};
use crate::real::{InPrecision, Scalar};

/// Why a law has no program for devices.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("law {law} has no kernel for devices: {reason}")]
pub struct NoKernel {
    law: &'static str,
    reason: Reason,
}

#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
enum Reason {
    #[error("it is of whole columns, with an algorithm of its own")]
    Columns,
    #[error("it is a closure, which only the host can call")]
    Closure,
    #[error("it ends at a distance, and lists of neighbours are the host's")]
    Cutoff,
    #[error("devices have no double-double numbers")]
    DoubleDouble,
    #[error(transparent)]
    Refused(#[from] Refused),
    #[error(transparent)]
    Wrong(#[from] Wrong),
}

/// The precision of a text for each precision of an engine.
struct OnDevice;

impl InPrecision for OnDevice {
    type Of<P: Scalar> = Option<Numbers>;
}

impl<P: Scalar> Compiled<P> {
    /// The law's program, where those optional components are there whose bits are set, with its buffers as the signature has them.
    pub(crate) fn program(&self, there: u64) -> Result<Program, NoKernel> {
        self.program_in(Layout::of(&self.signature, there), there)
    }

    /// The same, with its buffers as they are laid out here.
    pub(crate) fn program_in(&self, layout: Layout, there: u64) -> Result<Program, NoKernel> {
        let fail = |reason| NoKernel { law: self.signature.name, reason };
        let precision = P::choose::<OnDevice>(|| Some(Numbers::F32), || Some(Numbers::F64), || None);
        let precision = precision.ok_or(fail(Reason::DoubleDouble))?;
        let (trace, shape) = self.traced(there).map_err(fail)?;
        let program = write(&trace, layout, shape, precision, self.signature.estimates);
        let program = program.map_err(|refused| fail(refused.into()))?;
        check(&program).map_err(|wrong| fail(wrong.into()))?;
        Ok(program)
    }

    fn traced(&self, there: u64) -> Result<(Trace, Loop), Reason> {
        let (trace, shape) = match &self.kernel {
            Kernel::Row(kernel) => (kernel.trace(there), Loop::Rows),
            Kernel::Pair(_) if self.signature.cutoff.is_some() => return Err(Reason::Cutoff),
            Kernel::Pair(kernel) => (kernel.trace(there), Loop::Pairs),
            Kernel::Link(kernel) => (kernel.trace(there), Loop::Links(kernel.arity())),
            Kernel::Column(_) => return Err(Reason::Columns),
        };
        Ok((trace.ok_or(Reason::Closure)?, shape))
    }
}

/// A program that copies numbers: the first so many slots of the layout get those of the slots behind them.
pub(crate) fn copied<P: Scalar>(width: usize, layout: Layout) -> Result<Program, NoKernel> {
    let fail = |reason| NoKernel { law: "the start of a sum", reason };
    let numbers = P::choose::<OnDevice>(|| Some(Numbers::F32), || Some(Numbers::F64), || None);
    let numbers = numbers.ok_or(fail(Reason::DoubleDouble))?;
    let program = write(&trace::copy(width), layout, Loop::Rows, numbers, false);
    let program = program.map_err(|refused| fail(refused.into()))?;
    check(&program).map_err(|wrong| fail(wrong.into()))?;
    Ok(program)
}

/// The bits of all components.
const ALL: u64 = u64::MAX;

/// The kernel of a law, as a text in WGSL: what a device runs, made from the law's own body. All optional values are there.
///
/// # Errors
/// Devices cannot run the law; the error says why.
pub fn wgsl_of<P: Scalar>(law: &Compiled<P>) -> Result<String, NoKernel> {
    Ok(law.program(ALL)?.text)
}
