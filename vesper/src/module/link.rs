//! The loop of a link law that a module made. A law that is written against `vesper_law.h` is called once, for all links: it adds to rows
//! that others may add to; those that `export_laws!` makes share rows out among threads, as the framework's own.

use super::abi;
use super::instance::Instance;
use super::numbers::{Numbers, native, no_call, numbers, precision};
use crate::backend::{LinkCall, LinkKernel, Links, Strided, TangentCall};
use crate::law::{MAX_SLOTS, Place};
use crate::real::{Isa, Scalar};
use core::ffi::c_void;
use std::sync::Arc;

/// A link law of a module.
pub(super) struct LinkLaws(pub(super) Arc<Instance>);

impl LinkLaws {
    fn all(&self) -> usize {
        self.0.declared.signature.link.map_or(1, |link| link.kind.width())
    }

    fn to_law<P>(&self, call: &LinkCall<'_, P>) -> abi::Call {
        let links = call.ends.len() / self.all();
        let end = if let Links::First(count) = call.links { count } else { links };
        abi::Call { end, others_end: links, links: call.ends.as_ptr(), ..no_call() }
    }

    /// Calls the law with copies in other numbers.
    ///
    /// # Safety
    /// As for [`LinkKernel::run`].
    unsafe fn converted<P: Scalar, Q: Scalar, T>(
        &self,
        call: &LinkCall<'_, P>,
        then: impl FnOnce(&abi::Call, &[Vec<Q>], usize) -> T,
    ) -> T {
        let targets = call.ends.iter().max().map_or(0, |last| *last as usize + 1);
        let links = call.ends.len() / self.all();
        let mut copies: Vec<Vec<Q>> = Vec::with_capacity(self.0.slots.len());
        for (slot, Strided { start, stride }) in self.0.slots.iter().zip(call.slots) {
            let rows = match slot.port.place {
                Place::End => targets,
                Place::Scene => 1,
                Place::Own | Place::Field => links,
            };
            copies.push(match (slot.port.mode.is_input(), start.is_null()) {
                (true, true) => Vec::new(),
                (true, false) => {
                    // SAFETY: the caller promises a number for each row.
                    (0..rows).map(|row| Q::from_f64(unsafe { *start.add(row * stride) }.to_f64())).collect()
                }
                (false, _) => vec![Q::default(); rows],
            });
        }
        let pointer = |copy: &mut Vec<Q>| -> *mut c_void {
            if copy.is_empty() { core::ptr::null_mut() } else { copy.as_mut_ptr().cast() }
        };
        let slots: Vec<*mut c_void> = copies.iter_mut().map(pointer).collect();
        let strides = self.0.strides.as_ptr();
        then(
            &abi::Call { precision: precision::<Q>(), slots: slots.as_ptr(), strides, ..self.to_law(call) },
            &copies,
            targets,
        )
    }

    /// # Safety
    /// As for [`LinkKernel::run`].
    unsafe fn run_converted<P: Scalar, Q: Scalar>(&self, call: &LinkCall<'_, P>) {
        // SAFETY: the caller promises the same; copies have a number for each row.
        unsafe {
            self.converted::<P, Q, _>(call, |to_law, copies, targets| {
                if !self.0.call(to_law) {
                    return;
                }
                let sums = self.0.slots.iter().zip(call.slots).zip(copies);
                for ((_, to), shares) in
                    sums.filter(|((slot, to), _)| !slot.port.mode.is_input() && !to.start.is_null())
                {
                    for (row, share) in shares[..targets].iter().enumerate() {
                        *to.start.add(row * to.stride) += P::from_f64(share.to_f64());
                    }
                }
            });
        }
    }
}

impl<P: Scalar> LinkKernel<P> for LinkLaws {
    fn arity(&self) -> usize {
        self.all()
    }

    fn splits(&self) -> bool {
        self.0.declared.table.native == abi::NATIVE && numbers::<P>(&self.0) == Numbers::Own
    }

    unsafe fn run(&self, isa: Isa, call: &LinkCall<'_, P>) {
        let knows = self.0.declared.table.native == abi::NATIVE;
        let all_there =
            self.0.slots.iter().zip(call.slots).all(|(slot, at)| slot.port.mode.is_input() || !at.start.is_null());
        match numbers::<P>(&self.0) {
            Numbers::Own if all_there || knows => {}
            // SAFETY: the caller promises the same.
            Numbers::Own => return unsafe { self.run_converted::<P, P>(call) },
            // SAFETY: as above.
            Numbers::Double => return unsafe { self.run_converted::<P, f64>(call) },
            // SAFETY: as above.
            Numbers::Single => return unsafe { self.run_converted::<P, f32>(call) },
        }
        let (mut slots, mut strides) = ([core::ptr::null_mut::<c_void>(); MAX_SLOTS], [0; MAX_SLOTS]);
        for (slot, Strided { start, stride }) in call.slots.iter().enumerate() {
            (slots[slot], strides[slot]) = (start.cast(), *stride);
        }
        let mut native = abi::Native { own_begin: call.rows.start, own_end: call.rows.end, ..native(isa) };
        if let Links::Listed(list) = call.links {
            (native.list, native.list_length) = (list.as_ptr(), list.len());
        }
        let native = if knows { &raw const native } else { core::ptr::null() };
        let (precision, slots, strides) = (precision::<P>(), slots.as_ptr(), strides.as_ptr());
        // SAFETY: the caller promises the slots.
        unsafe { self.0.call(&abi::Call { precision, slots, strides, native, ..self.to_law(call) }) };
    }

    fn differentiates(&self) -> bool {
        false
    }

    unsafe fn tangent(&self, _call: &TangentCall<'_, P>) {}

    unsafe fn energy(&self, call: &LinkCall<'_, P>) -> Option<f64> {
        self.0.declared.table.energy?;
        // SAFETY: the caller promises the same.
        unsafe {
            Some(match numbers::<P>(&self.0) {
                Numbers::Own => self.converted::<P, P, _>(call, |to_law, _, _| self.0.energy(to_law)),
                Numbers::Double => self.converted::<P, f64, _>(call, |to_law, _, _| self.0.energy(to_law)),
                Numbers::Single => self.converted::<P, f32, _>(call, |to_law, _, _| self.0.energy(to_law)),
            })
        }
    }

    #[cfg(feature = "gpu")]
    fn trace(&self, _there: u64) -> Option<crate::backend::gpu::Trace> {
        None
    }
}
