//! The loops of a pair law that a module made. Each row gets what all others do to it; cut-offs, far fields and pairs that are looked
//! at once are for laws whose bodies are here.

use super::abi;
use super::instance::Instance;
use super::numbers::{Numbers, native, no_call, numbers, precision, rounding};
use crate::backend::{Lists, PairCall, PairKernel, Tally, TangentCall};
use crate::real::{Isa, Scalar};
use core::ffi::c_void;
use core::ops::Range;
use std::sync::Arc;

/// A pair law of a module.
pub(super) struct Pairs(pub(super) Arc<Instance>);

impl Pairs {
    fn to_law<P>(&self, call: &PairCall<'_, P>) -> abi::Call {
        abi::Call {
            begin: call.rows.start,
            end: call.rows.end,
            others_begin: call.others.start,
            others_end: call.others.end,
            strides: self.0.strides.as_ptr(),
            ..no_call()
        }
    }

    /// The slots of what the law adds to, with their numbers.
    fn sums(&self) -> impl Iterator<Item = usize> {
        (0..self.0.slots.len()).filter(|&slot| !self.0.slots[slot].port.mode.is_input())
    }

    /// Calls the law with copies in other numbers.
    ///
    /// # Safety
    /// As for [`PairKernel::run`].
    unsafe fn converted<P: Scalar, Q: Scalar, T>(
        &self,
        call: &PairCall<'_, P>,
        then: impl FnOnce(&abi::Call, &[Vec<Q>]) -> T,
    ) -> T {
        let rows = call.rows.end.max(call.others.end);
        let copy = |(slot, of): (usize, &super::instance::Slot)| -> Vec<Q> {
            let start = call.slots[slot];
            match (of.port.mode.is_input(), start.is_null()) {
                (true, true) => Vec::new(),
                // SAFETY: the caller promises a number for each row, or one.
                (true, false) => (0..if of.one { 1 } else { rows })
                    .map(|row| Q::from_f64(unsafe { *start.add(row) }.to_f64()))
                    .collect(),
                (false, _) => vec![Q::default(); rows],
            }
        };
        let mut copies: Vec<Vec<Q>> = self.0.slots.iter().enumerate().map(copy).collect();
        let slots: Vec<*mut c_void> = copies
            .iter_mut()
            .map(|copy| if copy.is_empty() { core::ptr::null_mut() } else { copy.as_mut_ptr().cast() })
            .collect();
        then(&abi::Call { precision: precision::<Q>(), slots: slots.as_ptr(), ..self.to_law(call) }, &copies)
    }

    /// # Safety
    /// As for [`PairKernel::run`].
    unsafe fn run_converted<P: Scalar, Q: Scalar>(&self, call: &PairCall<'_, P>) {
        // SAFETY: the caller promises the same; copies have a number for each row.
        unsafe {
            self.converted::<P, Q, _>(call, |to_law, copies| {
                let went = self.0.call(to_law);
                for slot in self.sums().filter(|&slot| !call.slots[slot].is_null()) {
                    for row in call.rows.clone() {
                        let share = if went { P::from_f64(copies[slot][row].to_f64()) } else { P::default() };
                        let to = call.slots[slot].add(row);
                        *to = if call.first { share } else { *to + share };
                    }
                }
            });
        }
    }
}

impl<P: Scalar> PairKernel<P> for Pairs {
    fn added(&self) -> usize {
        self.sums().count()
    }

    unsafe fn run(&self, isa: Isa, call: &PairCall<'_, P>) {
        let all_there = self.sums().all(|slot| !call.slots[slot].is_null());
        match numbers::<P>(&self.0) {
            Numbers::Own if all_there => {}
            // SAFETY: the caller promises the same.
            Numbers::Own => return unsafe { self.run_converted::<P, P>(call) },
            // SAFETY: as above.
            Numbers::Double => return unsafe { self.run_converted::<P, f64>(call) },
            // SAFETY: as above.
            Numbers::Single => return unsafe { self.run_converted::<P, f32>(call) },
        }
        let to_law = abi::Call { precision: precision::<P>(), slots: call.slots.as_ptr().cast(), ..self.to_law(call) };
        let knows = self.0.declared.table.native == abi::NATIVE && !self.0.has_failed();
        if call.first && !knows {
            for slot in self.sums() {
                // SAFETY: the rows are this call's.
                unsafe { core::slice::from_raw_parts_mut(call.slots[slot].add(call.rows.start), call.rows.len()) }
                    .fill(P::default());
            }
        }
        let first = if call.first { abi::FIRST } else { 0 };
        let estimates = if call.estimates { abi::ESTIMATES } else { 0 };
        let native = abi::Native { flags: first | estimates, ..native(isa) };
        let native = if knows { &raw const native } else { core::ptr::null() };
        // SAFETY: the caller promises the slots.
        unsafe { self.0.call(&abi::Call { native, ..to_law }) };
    }

    unsafe fn run_listed(&self, _isa: Isa, _call: &PairCall<'_, P>, _lists: &Lists<P>, _clusters: Range<usize>) {}

    unsafe fn energy_listed(&self, _call: &PairCall<'_, P>, _lists: &Lists<P>) -> Option<f64> {
        None
    }

    unsafe fn meet(&self, _isa: Isa, _call: &PairCall<'_, P>, _to: (&Tally<P>, &[*mut P]), _blocks: [usize; 2]) {}

    unsafe fn give(&self, _isa: Isa, _call: &PairCall<'_, P>, _tally: &Tally<P>) {}

    fn is_inverse_square(&self) -> bool {
        false
    }

    unsafe fn inverse_square(&self, _call: &PairCall<'_, P>, _source: *mut P, _response: *mut P) -> P {
        P::default()
    }

    unsafe fn is_as_inverse_square(&self, _call: &PairCall<'_, P>) -> bool {
        false
    }

    unsafe fn is_invariant(&self, _call: &PairCall<'_, P>) -> bool {
        true
    }

    unsafe fn is_antisymmetric(&self, _call: &PairCall<'_, P>) -> bool {
        true
    }

    fn splits(&self) -> bool {
        self.0.declared.table.state_size == 0
    }

    fn differentiates(&self) -> bool {
        false
    }

    fn rounding(&self) -> f64 {
        rounding::<P>(&self.0)
    }

    unsafe fn tangent(&self, _call: &TangentCall<'_, P>) {}

    unsafe fn energy(&self, call: &PairCall<'_, P>) -> Option<f64> {
        self.0.declared.table.energy?;
        // SAFETY: the caller promises the same.
        unsafe {
            Some(match numbers::<P>(&self.0) {
                Numbers::Own => self.converted::<P, P, _>(call, |to_law, _| self.0.energy(to_law)),
                Numbers::Double => self.converted::<P, f64, _>(call, |to_law, _| self.0.energy(to_law)),
                Numbers::Single => self.converted::<P, f32, _>(call, |to_law, _| self.0.energy(to_law)),
            })
        }
    }

    #[cfg(feature = "gpu")]
    fn trace(&self, _there: u64) -> Option<crate::backend::gpu::Trace> {
        None
    }
}
