//! A law made at run time over whole columns: one call of the closure for an evaluation, in f64.
//!
//! In: the columns of the law's ports. Out: copies of what the law looks at, handed to the closure, and its results written
//! back. Never: a column that the closure sees in place: it may keep what it is given.

use super::ColumnKernel;
use crate::law::{ColumnAccess, DynWhole, Mode, PortView, Signature};
use crate::real::Scalar;
use std::sync::Arc;

/// A closure over all rows.
pub(super) struct Whole {
    pub(super) signature: Signature,
    pub(super) body: Arc<DynWhole>,
}

impl<P: Scalar> ColumnKernel<P> for Whole {
    unsafe fn run(&self, access: &ColumnAccess<'_, P>) {
        let (mut given, mut results) = (Vec::new(), Vec::new());
        let ports = || self.signature.ports.iter().zip(access.ports());
        for (port, view) in ports() {
            let width = port.property.kind.width();
            let mut numbers = vec![0.0; view.rows * width];
            if port.mode.is_input() {
                // SAFETY: the access was made for this signature, passed on from the caller.
                unsafe { each(view, width, &mut numbers, |place, number| *number = place.to_f64()) };
                given.push(numbers);
            } else {
                results.push(numbers);
            }
        }
        (self.body)(&given, &mut results);
        let outputs = ports().filter(|(port, _)| !port.mode.is_input());
        for ((port, view), numbers) in outputs.zip(&mut results) {
            let adds = port.mode == Mode::Adds;
            // A closure may shorten what it is given; what is missing then stays as it was.
            // SAFETY: as above.
            unsafe {
                each(view, port.property.kind.width(), numbers, |place, number| {
                    let value = P::from_f64(*number);
                    *place = if adds { *place + value } else { value };
                });
            }
        }
    }
}

/// Brings numbers, row after row, together with their places. A component that nobody wants has no place.
///
/// # Safety
/// Components of the view point to its rows, at its stride, which nobody else touches.
unsafe fn each<P>(view: &PortView<P>, width: usize, numbers: &mut [f64], mut meet: impl FnMut(&mut P, &mut f64)) {
    for (row, numbers) in numbers.chunks_mut(width).enumerate().take(view.rows) {
        for (component, number) in view.components.iter().zip(numbers) {
            if !component.is_null() {
                // SAFETY: the row is one of the view's.
                meet(unsafe { &mut *component.add(row * view.stride) }, number);
            }
        }
    }
}
