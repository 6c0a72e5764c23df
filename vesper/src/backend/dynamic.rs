//! The loops of laws made at run time: one call of the closure for each row, or for all of them, in f64.

use super::row::{RowCall, RowKernel};
use super::tangent::TangentCall;
use super::whole::Whole;
use super::{Compile, Compiled, Kernel, MAX_SLOTS};
use crate::law::{DynBody, DynLaw, DynRow, Mode, Part, Place, Signature};
use crate::property::Role;
use crate::real::{DoubleDouble, Dual, Isa, Scalar};
use std::sync::Arc;

impl Compile for DynLaw {
    fn compile_f32(&self) -> Compiled<f32> {
        compiled(self)
    }
    fn compile_f64(&self) -> Compiled<f64> {
        compiled(self)
    }
    fn compile_double_double(&self) -> Compiled<DoubleDouble> {
        compiled(self)
    }
}

fn compiled<P: Scalar>(law: &DynLaw) -> Compiled<P> {
    let signature = law.signature;
    let kernel = match &law.body {
        DynBody::Row(body) => {
            Kernel::Row(Arc::new(Closure { signature, body: body.clone(), slots: signature.slots() }))
        }
        DynBody::Whole(body) => Kernel::Column(Box::new(Whole { signature, body: body.clone() })),
    };
    Compiled { signature, energy: false, parameters: Vec::new(), foreign: None, kernel }
}

struct Closure {
    signature: Signature,
    body: Arc<DynRow>,
    slots: Vec<usize>,
}

impl<P: Scalar> RowKernel<P> for Closure {
    #[cfg(feature = "gpu")]
    fn trace(&self, _there: u64) -> Option<super::gpu::Trace> {
        None
    }

    unsafe fn run(&self, _isa: Isa, call: &RowCall<'_, P>) {
        // SAFETY: passed on to the caller.
        unsafe { self.rows(call) };
        if call.drift.get().is_some() {
            // A row's drift needs no other row's kick, so all kicks may come first.
            let drift = RowCall { part: Part::Coordinates, advance: call.drift, drift: None.into(), ..*call };
            // SAFETY: as above.
            unsafe { self.rows(&drift) };
        }
    }

    unsafe fn tangent(&self, call: &TangentCall<'_, P>) {
        // SAFETY: the caller promises the same.
        unsafe { by_differences(&self.signature, call, f64::EPSILON, &*self.body) }
    }

    unsafe fn energy(&self, _call: &RowCall<'_, P>) -> Option<f64> {
        None
    }
}

/// The loop of derivatives of a body that is not generic in its numbers: central differences, by one number after the other. Each
/// is moved by the cube root of the body's rounding times its own magnitude, where the errors of the difference and of rounding
/// are alike (Dennis, Schnabel, Numerical Methods for Unconstrained Optimization and Nonlinear Equations, 5.4); where it is 0, by
/// that of its property in this row, or else of 1.
///
/// # Safety
/// The call keeps its promises.
pub(crate) unsafe fn by_differences<P: Scalar>(
    signature: &Signature,
    call: &TangentCall<'_, P>,
    rounding: f64,
    body: impl Fn(&[f64], &mut [f64]),
) {
    let slots = signature.slots();
    let first = signature.inputs().count();
    let (inputs, all) = (slots[first], slots[slots.len() - 1]);
    let outputs = all - inputs;
    let body = |given: &[f64], results: &mut [f64; MAX_SLOTS]| {
        results[..outputs].fill(0.0);
        body(given, &mut results[..outputs]);
    };
    let (mut given, mut along) = ([0.0; MAX_SLOTS], [0.0; MAX_SLOTS]);
    for row in 0..call.rows {
        for slot in 0..inputs {
            // SAFETY: the caller promises the rows.
            let number = unsafe { call.slots[slot].load(row) };
            let there = !call.slots[slot].value.start.is_null();
            given[slot] = if there { number.value.to_f64() } else { 0.0 };
            along[slot] = number.derivative.to_f64();
        }
        let mut values = [0.0; MAX_SLOTS];
        body(&given[..inputs], &mut values);
        let mut derivatives = [0.0; MAX_SLOTS];
        for port in slots[..=first].windows(2) {
            let of_port = given[port[0]..port[1]].iter().fold(0.0, |most, number| f64::max(most, number.abs()));
            for slot in (port[0]..port[1]).filter(|&slot| along[slot] != 0.0) {
                let own = given[slot];
                let size = [own.abs(), of_port].into_iter().find(|size| *size > 0.0).unwrap_or(1.0);
                let by = rounding.max(f64::EPSILON).cbrt() * size;
                let ([low, high], mut results) = ([own - by, own + by], [[0.0; MAX_SLOTS]; 2]);
                for (at, results) in [low, high].into_iter().zip(&mut results) {
                    given[slot] = at;
                    body(&given[..inputs], results);
                }
                given[slot] = own;
                let [below, above] = results;
                for (sum, (below, above)) in derivatives[..outputs].iter_mut().zip(below.into_iter().zip(above)) {
                    *sum += (above - below) / (high - low) * along[slot];
                }
            }
        }
        for (port, at) in signature.ports[first..].iter().zip(&slots[first..]) {
            for slot in *at..at + port.property.kind.width() {
                let to = call.slots[slot];
                let [value, derivative] = [values, derivatives].map(|numbers| P::from_f64(numbers[slot - inputs]));
                let share = Dual::new(value, derivative);
                // SAFETY: as above.
                unsafe { to.store(row, if port.mode == Mode::Adds { to.load(row) + share } else { share }) };
            }
        }
    }
}

impl Closure {
    /// # Safety
    /// As for [`RowKernel::run`].
    unsafe fn rows<P: Scalar>(&self, call: &RowCall<'_, P>) {
        let Closure { signature, body: law, slots } = self;
        let mut numbers = [0.0; MAX_SLOTS];
        let first = signature.inputs().count();
        let (inputs, all) = (slots[first], slots[slots.len() - 1]);
        for row in 0..call.rows {
            for (port, slot) in signature.ports[..first].iter().zip(slots) {
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
            law(given, &mut results[..all - inputs]);
            for (port, slot) in signature.ports[first..].iter().zip(&slots[first..]) {
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
        match (mode, call.advance.get()) {
            (Mode::Adds, _) if !call.first => *to.add(row) += value,
            (Mode::Rates, _) if !call.part.holds(&role) => {}
            (Mode::Rates, Some(step)) => *to.add(row) += value * step,
            _ => *to.add(row) = value,
        }
    }
}
