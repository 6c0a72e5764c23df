//! The loops around the bodies.
//!
//! In: a law's body and pointers to columns. Out: kernels, one object for each law, whose body is compiled for one row
//! at a time and for lanes, and chosen at run time. Every one of them gives the same bits: lanes round as scalars do,
//! and the terms of a sum are added in the order of the rows; but for pair laws that allow estimates, for far fields, and on
//! graphics processors. Never: an order of laws, an integrator.

mod column;
mod dynamic;
#[cfg(feature = "modules")]
mod entry;
mod far;
mod foreign;
#[cfg(feature = "gpu")]
pub mod gpu;
mod link;
mod near;
mod pair;
mod pointers;
mod row;
mod tangent;
mod whole;
mod within;

pub use column::column;
pub use link::link;
pub use pair::pair;
pub use row::row;

pub(crate) use column::ColumnKernel;
#[cfg(feature = "modules")]
pub(crate) use dynamic::by_differences;
#[cfg(feature = "modules")]
pub(crate) use entry::{Entries, RowFunction};
pub(crate) use far::{Accuracy, Effort, Far, Parts, pays as far_pays};
pub(crate) use foreign::Foreign;
pub(crate) use link::{LinkCall, LinkKernel, Links, Strided};
pub(crate) use near::{Lists, Reach as ListReach, Unfit};
pub(crate) use pair::{
    PAYS, PairCall, PairKernel, Tally, box_slot, coordinate_slots, distance_slot, meeting_block, rounds,
};
pub(crate) use pointers::{MAX_SLOTS, row_of, wants};
pub(crate) use row::{AHEAD, RowCall, RowKernel};
pub(crate) use tangent::{DualReach, Reach, TangentCall};

use crate::law::{Shape, Signature};
use crate::real::{DoubleDouble, InPrecision, Scalar};
use std::sync::Arc;

/// Rows that a group of row laws takes at a time, of columns of so many bytes together: all laws of the group, then the next
/// block. Half a page of each column, so that ten columns and their sums stay in the first cache; a quarter where the
/// columns come from memory, so that those of the next block fit in beside them. `cargo bench --bench rows` tells other sizes
/// apart by 5 to 10 %.
pub(crate) const fn block<P>(bytes: usize) -> usize {
    let of_each = if bytes > 16 << 20 { 1024 } else { 2048 };
    of_each / size_of::<P>()
}

/// Stops the compiler at a law that is not of pairs, and says what only those can.
const fn says_nothing_of_pairs(signature: &Signature) {
    assert!(!signature.translation_invariant, "`translation_invariant` is for laws of pairs: leave the word out");
    assert!(!signature.antisymmetric, "`antisymmetric` is for laws of pairs: leave the word out");
    assert!(signature.cutoff.is_none(), "`cutoff` is for laws of pairs: leave the word out");
    assert!(!signature.estimates, "`estimates` is for laws of pairs: leave the word out");
}

/// A law whose body is known. Implemented by `#[kernel]`.
#[diagnostic::on_unimplemented(
    message = "law `{Self}` has no kernel",
    label = "no `#[kernel] impl`",
    note = "write `#[kernel] impl<R: Real> RowLaw<R> for ...` (or PairLaw, LinkLaw, ColumnLaw) beside the struct"
)]
pub trait Compile {
    /// The law with its loops, in f32. Not generic, so that a law's loops are made once, in the law's own crate, and not
    /// again in every program that uses it.
    fn compile_f32(&self) -> Compiled<f32>;
    /// The law with its loops, in f64.
    fn compile_f64(&self) -> Compiled<f64>;
    /// The law with its loops, in double-double numbers.
    fn compile_double_double(&self) -> Compiled<DoubleDouble>;
    /// The law with its loops, in precision `P`.
    fn compile<P: Scalar>(&self) -> Compiled<P> {
        P::choose::<CompiledIn>(|| self.compile_f32(), || self.compile_f64(), || self.compile_double_double())
    }
}

/// [`Compiled`] for each precision.
struct CompiledIn;

impl InPrecision for CompiledIn {
    type Of<P: Scalar> = Compiled<P>;
}

/// A law with its loops.
pub struct Compiled<P: Scalar> {
    pub(crate) signature: Signature,
    pub(crate) kernel: Kernel<P>,
    pub(crate) energy: bool,
    /// The values of the law's parameters, component by component.
    pub(crate) parameters: Vec<f64>,
    /// What else there is to know where the body was compiled elsewhere.
    pub(crate) foreign: Option<Arc<dyn Foreign>>,
}

impl<P: Scalar> core::fmt::Debug for Compiled<P> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Compiled").field("law", &self.signature.name).field("shape", &self.shape()).finish()
    }
}

impl<P: Scalar> Compiled<P> {
    /// What the law touches.
    pub fn signature(&self) -> &Signature {
        &self.signature
    }

    /// Whether its body knows its energy.
    pub fn knows_energy(&self) -> bool {
        self.energy
    }

    /// The shape of its body.
    pub fn shape(&self) -> Shape {
        match self.kernel {
            Kernel::Row(_) => Shape::Row,
            Kernel::Pair(_) => Shape::Pair,
            Kernel::Link(_) => Shape::Link,
            Kernel::Column(_) => Shape::Column,
        }
    }
}

pub(crate) enum Kernel<P: Scalar> {
    /// Shared with the operations that run it: they go from block to block without a look at the list of laws.
    Row(Arc<dyn RowKernel<P>>),
    /// Shared with the passes that run it.
    Pair(Arc<dyn PairKernel<P>>),
    Link(Box<dyn LinkKernel<P>>),
    Column(Box<dyn ColumnKernel<P>>),
}

impl<P: Scalar> Kernel<P> {
    /// What the numbers of its body are uncertain by.
    pub(crate) fn rounding(&self) -> f64 {
        match self {
            Kernel::Row(_) => P::EPSILON,
            Kernel::Pair(kernel) => kernel.rounding(),
            Kernel::Link(kernel) => kernel.rounding(),
            Kernel::Column(kernel) => kernel.rounding(),
        }
    }

    /// Whether it has a body over dual numbers; differences stand for it where not.
    pub(crate) fn differentiates(&self) -> bool {
        match self {
            Kernel::Row(_) => true,
            Kernel::Pair(kernel) => kernel.differentiates(),
            Kernel::Link(kernel) => kernel.differentiates(),
            Kernel::Column(_) => false,
        }
    }
}
