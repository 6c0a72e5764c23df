//! The loop of a row law made at run time: one call of the closure for each row, in f64.

use super::row::{RowCall, RowKernel};
use super::{Compile, Compiled, Kernel, MAX_SLOTS};
use crate::law::{DynLaw, Mode, Part, Place};
use crate::property::Role;
use crate::real::{Isa, Scalar};
use std::sync::Arc;

impl Compile for DynLaw {
    fn compile_f32(&self) -> Compiled<f32> {
        compiled(self)
    }
    fn compile_f64(&self) -> Compiled<f64> {
        compiled(self)
    }
}

fn compiled<P: Scalar>(law: &DynLaw) -> Compiled<P> {
    let kernel = Closure { slots: law.signature.slots(), law: law.clone() };
    Compiled { signature: law.signature, energy: false, parameters: Vec::new(), kernel: Kernel::Row(Arc::new(kernel)) }
}

struct Closure {
    law: DynLaw,
    slots: Vec<usize>,
}

impl<P: Scalar> RowKernel<P> for Closure {
    unsafe fn run(&self, _isa: Isa, call: &RowCall<'_, P>) {
        // SAFETY: passed on to the caller.
        unsafe { self.rows(call) };
        if call.drift.is_some() {
            // A row's drift needs no other row's kick, so all kicks may come first.
            let drift = RowCall { part: Part::Coordinates, advance: call.drift, drift: None, ..*call };
            // SAFETY: as above.
            unsafe { self.rows(&drift) };
        }
    }

    unsafe fn energy(&self, _call: &RowCall<'_, P>) -> Option<f64> {
        None
    }
}

impl Closure {
    /// # Safety
    /// As for [`RowKernel::run`].
    unsafe fn rows<P: Scalar>(&self, call: &RowCall<'_, P>) {
        let Closure { law, slots } = self;
        let mut numbers = [0.0; MAX_SLOTS];
        let first = law.signature.inputs().count();
        let (inputs, all) = (slots[first], slots[slots.len() - 1]);
        for row in 0..call.rows {
            for (port, slot) in law.signature.ports[..first].iter().zip(slots) {
                let uniform = port.place == Place::Field && call.uniform >> slot & 1 == 1;
                let at = if port.place == Place::Scene || uniform { 0 } else { row };
                let width = port.property.kind.width();
                for (number, from) in numbers[*slot..][..width].iter_mut().zip(&call.slots[*slot..]) {
                    // SAFETY: the caller promises the rows; what no wanted rate depends on has no place.
                    *number = if from.is_null() { 0.0 } else { unsafe { (*from.add(at)).to_f64() } };
                }
            }
            numbers[inputs..all].fill(0.0);
            let (given, results) = numbers.split_at_mut(inputs);
            (law.body)(given, &mut results[..all - inputs]);
            for (port, slot) in law.signature.ports[first..].iter().zip(&slots[first..]) {
                let width = port.property.kind.width();
                for (number, to) in numbers[*slot..][..width].iter().zip(&call.slots[*slot..]) {
                    // SAFETY: as above; a null slot belongs to a part that is not wanted.
                    unsafe { write(port.mode, port.property.role, call, *to, row, P::from_f64(*number)) };
                }
            }
        }
    }
}

/// # Safety
/// `to` points to the number of `row`, unless the value is a rate of a part that is not wanted.
unsafe fn write<P: Scalar>(mode: Mode, role: Role, call: &RowCall<'_, P>, to: *mut P, row: usize, value: P) {
    // SAFETY: passed on to the caller.
    unsafe {
        match (mode, call.advance) {
            (Mode::Adds, _) if !call.first => *to.add(row) += value,
            (Mode::Rates, _) if !call.part.holds(&role) => {}
            (Mode::Rates, Some(step)) => *to.add(row) += value * step,
            _ => *to.add(row) = value,
        }
    }
}
