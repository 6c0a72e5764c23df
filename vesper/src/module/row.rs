//! The loop of a row law that a module made: the law's own, called for as many rows as the host has at a time.
//!
//! In: a call, as the host's loops have it. Out: a call, as `vesper_law.h` has it. Where the two agree, which is where a law gives no
//! rates, and takes numbers of the engine's precision, pointers are passed on; elsewhere rows go over a desk. Never: a body.

use super::abi;
use super::instance::{Instance, Slot};
use super::numbers::{Numbers, no_call, numbers, precision, rounding};
use crate::backend::{RowCall, RowKernel, TangentCall, by_differences};
use crate::law::{MAX_SLOTS, Mode, Part, Place};
use crate::property::Role;
use crate::real::{Isa, Scalar};
use core::ffi::c_void;
use core::mem::MaybeUninit;
use std::sync::Arc;

/// Rows that go over a desk at a time.
const DESK: usize = 128;

/// How a law is called by an engine of one precision.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Way {
    /// With the pointers as they are: there are no rates, fields or turns, which not every call has places for.
    Plain,
    /// With what lies on a desk.
    Desk(Numbers),
}

/// A row law of a module, for engines of one precision.
pub(super) struct Rows {
    law: Arc<Instance>,
    way: Way,
}

/// The numbers of some rows, by slot.
struct Desk<Q> {
    numbers: [[MaybeUninit<Q>; DESK]; MAX_SLOTS],
    slots: [*mut c_void; MAX_SLOTS],
    strides: [usize; MAX_SLOTS],
}

impl<Q: Scalar> Desk<Q> {
    fn new() -> Self {
        let numbers = [const { [const { MaybeUninit::uninit() }; DESK] }; MAX_SLOTS];
        Desk { numbers, slots: [core::ptr::null_mut(); MAX_SLOTS], strides: [1; MAX_SLOTS] }
    }

    /// Puts these numbers on the desk.
    fn put(&mut self, slot: usize, numbers: impl Iterator<Item = Q>) {
        for (to, number) in self.numbers[slot].iter_mut().zip(numbers) {
            to.write(number);
        }
        self.slots[slot] = self.numbers[slot].as_mut_ptr().cast();
    }

    /// Whether the law wrote to the desk.
    fn has(&self, slot: usize) -> bool {
        core::ptr::eq(self.slots[slot].cast_const(), self.numbers[slot].as_ptr().cast())
    }
}

impl Rows {
    pub(super) fn new<P: Scalar>(law: Arc<Instance>) -> Self {
        let of_all = |slot: &Slot| {
            let turns = matches!(slot.port.property.role, Role::Turn { .. });
            slot.port.mode != Mode::Rates && slot.port.place != Place::Field && !turns
        };
        let way = match numbers::<P>(&law) {
            Numbers::Own if law.slots.iter().all(of_all) => Way::Plain,
            numbers => Way::Desk(numbers),
        };
        Rows { law, way }
    }

    /// Not in one function with calls that need no desk: its stack would be touched page by page in each of them.
    ///
    /// # Safety
    /// As for [`RowKernel::run`].
    #[inline(never)]
    unsafe fn over_desk<P: Scalar, Q: Scalar>(&self, call: &RowCall<'_, P>) {
        let mut desk = Desk::<Q>::new();
        let mut from = 0;
        while from < call.rows {
            let count = DESK.min(call.rows - from);
            // SAFETY: the caller promises the rows.
            unsafe {
                self.some::<P, Q>(call, from, count, &mut desk);
                if call.drift.get().is_some() {
                    // A row's drift needs no other row's kick.
                    let drift = RowCall { part: Part::Coordinates, advance: call.drift, drift: None.into(), ..*call };
                    self.some::<P, Q>(&drift, from, count, &mut desk);
                }
            }
            from += count;
        }
    }

    /// # Safety
    /// As for [`RowKernel::run`]; the call has these rows.
    unsafe fn some<P: Scalar, Q: Scalar>(&self, call: &RowCall<'_, P>, from: usize, count: usize, desk: &mut Desk<Q>) {
        let same = precision::<P>() == precision::<Q>();
        // SAFETY: passed on to the caller.
        unsafe { self.inputs(call, from, count, desk) };
        for (number, slot) in self.law.slots.iter().enumerate().filter(|(_, slot)| !slot.port.mode.is_input()) {
            let to = call.slots[number].wrapping_add(from);
            let there = !call.slots[number].is_null();
            let nothing = core::iter::repeat_n(Q::default(), count);
            match slot.port.mode {
                Mode::Rates => {
                    let wanted = there && call.part.holds(&slot.port.property.role);
                    if wanted && same && call.advance.get().is_none() {
                        desk.slots[number] = to.cast();
                    } else {
                        desk.put(number, nothing);
                    }
                }
                _ if !there => desk.put(number, nothing),
                Mode::Adds => {
                    if !same {
                        desk.put(number, nothing);
                        continue;
                    }
                    if call.first {
                        // SAFETY: the rows are this call's.
                        unsafe { core::slice::from_raw_parts_mut(to, count) }.fill(P::default());
                    }
                    desk.slots[number] = to.cast();
                }
                _ if same => desk.slots[number] = to.cast(),
                // SAFETY: as above.
                _ => desk.put(number, (0..count).map(|row| Q::from_f64(unsafe { *to.add(row) }.to_f64()))),
            }
        }
        let to_law = abi::Call {
            precision: precision::<Q>(),
            end: count,
            slots: desk.slots.as_ptr(),
            strides: desk.strides.as_ptr(),
            ..no_call()
        };
        // SAFETY: the slots have so many numbers, here or on the desk.
        let went = unsafe { self.law.call(&to_law) };
        for (number, slot) in self.law.slots.iter().enumerate().filter(|(_, slot)| !slot.port.mode.is_input()) {
            let to = call.slots[number].wrapping_add(from);
            if !desk.has(number) {
                if !went && slot.port.mode == Mode::Rates {
                    // SAFETY: as above.
                    unsafe { core::slice::from_raw_parts_mut(to, count) }.fill(P::default());
                }
                continue;
            }
            if call.slots[number].is_null()
                || slot.port.mode == Mode::Rates && !call.part.holds(&slot.port.property.role)
            {
                continue;
            }
            for (row, found) in desk.numbers[number][..count].iter().enumerate() {
                // SAFETY: they were put there; the rows are this call's.
                unsafe {
                    let found = if went { P::from_f64(found.assume_init().to_f64()) } else { P::default() };
                    let to = to.add(row);
                    let same = Q::from_f64((*to).to_f64()).bits() == Q::from_f64(found.to_f64()).bits();
                    match (slot.port.mode, call.advance.get()) {
                        (Mode::Adds, _) if !call.first => *to += found,
                        (Mode::Rates, Some(step)) => *to += found * step,
                        // What the law left as it was keeps its digits.
                        (Mode::Sets | Mode::Amends, _) if !went || same => {}
                        _ => *to = found,
                    }
                }
            }
        }
    }

    /// Ties the slots that the law looks at.
    ///
    /// # Safety
    /// As for [`RowKernel::run`]; the call has these rows.
    unsafe fn inputs<P: Scalar, Q: Scalar>(
        &self,
        call: &RowCall<'_, P>,
        from: usize,
        count: usize,
        desk: &mut Desk<Q>,
    ) {
        let same = precision::<P>() == precision::<Q>();
        for (number, slot) in self.law.slots.iter().enumerate() {
            let start = call.slots[number];
            desk.slots[number] = core::ptr::null_mut();
            desk.strides[number] = usize::from(!slot.one);
            if !slot.port.mode.is_input() || start.is_null() && slot.port.optional {
                continue;
            }
            let of = |row: usize| {
                // SAFETY: the caller promises the rows, and one number of a constant.
                Q::from_f64(unsafe { *start.add(row) }.to_f64())
            };
            if start.is_null() {
                // What no wanted rate depends on has no place.
                desk.put(number, core::iter::repeat_n(Q::default(), count));
            } else if slot.one {
                desk.put(number, core::iter::once(of(0)));
            } else if call.uniform >> number & 1 == 1 {
                desk.put(number, core::iter::repeat_n(of(0), count));
            } else if same {
                desk.slots[number] = start.wrapping_add(from).cast();
            } else {
                desk.put(number, (from..from + count).map(of));
            }
        }
    }

    /// # Safety
    /// As for [`RowKernel::run`].
    #[inline(never)]
    unsafe fn energy_of<P: Scalar, Q: Scalar>(&self, call: &RowCall<'_, P>) -> f64 {
        let mut desk = Desk::<Q>::new();
        let mut sum = 0.0;
        for from in (0..call.rows).step_by(DESK) {
            let count = DESK.min(call.rows - from);
            // SAFETY: the caller promises the rows.
            sum += unsafe {
                self.inputs(call, from, count, &mut desk);
                let to_law = abi::Call {
                    precision: precision::<Q>(),
                    end: count,
                    slots: desk.slots.as_ptr(),
                    strides: desk.strides.as_ptr(),
                    ..no_call()
                };
                self.law.energy(&to_law)
            };
        }
        sum
    }
}

/// Where a law of modules is not called with pointers as they are.
macro_rules! in_numbers {
    ($law:expr, $of:ident, $call:expr) => {
        // SAFETY: whoever uses this was promised what the function asks for.
        unsafe {
            match $law.numbers() {
                Numbers::Own => $law.$of::<P, P>($call),
                Numbers::Double => $law.$of::<P, f64>($call),
                Numbers::Single => $law.$of::<P, f32>($call),
            }
        }
    };
}

impl<P: Scalar> RowKernel<P> for Rows {
    fn splits(&self) -> bool {
        self.law.declared.table.state_size == 0
    }

    unsafe fn run(&self, _isa: Isa, call: &RowCall<'_, P>) {
        if self.way != Way::Plain {
            return in_numbers!(self, over_desk, call);
        }
        let (slots, strides) = (call.slots.as_ptr().cast(), self.law.strides.as_ptr());
        let plain = abi::Call { precision: precision::<P>(), end: call.rows, slots, strides, ..no_call() };
        // SAFETY: the caller promises the slots, and nobody else touches their rows.
        unsafe {
            if call.first {
                self.nothing(call);
            }
            self.law.call(&plain);
        }
    }

    unsafe fn tangent(&self, call: &TangentCall<'_, P>) {
        let signature = &self.law.declared.signature;
        let inputs = signature.slots()[signature.inputs().count()];
        let absent = |slot: usize| {
            let port = self.law.slots[slot].port;
            port.optional && call.slots[slot].value.start.is_null()
        };
        let single = self.law.declared.table.precisions & abi::F64 == 0;
        let body = |given: &[f64], results: &mut [f64]| {
            let (mut narrow, mut slots) = ([0.0_f32; MAX_SLOTS], [core::ptr::null_mut::<c_void>(); MAX_SLOTS]);
            for (slot, number) in given.iter().chain(results.iter()).enumerate() {
                narrow[slot] = *number as f32;
            }
            for slot in (0..self.law.slots.len()).filter(|&slot| slot >= inputs || !absent(slot)) {
                slots[slot] = match slot.checked_sub(inputs) {
                    _ if single => (&raw mut narrow[slot]).cast(),
                    None => (&raw const given[slot]).cast_mut().cast(),
                    Some(result) => (&raw mut results[result]).cast(),
                };
            }
            let precision = if single { abi::F32 } else { abi::F64 };
            let to_law =
                abi::Call { precision, end: 1, slots: slots.as_ptr(), strides: self.law.strides.as_ptr(), ..no_call() };
            // SAFETY: each slot has a number; what the law says it reads it does not write.
            unsafe { self.law.call(&to_law) };
            if single {
                results.iter_mut().zip(&narrow[inputs..]).for_each(|(to, number)| *to = f64::from(*number));
            }
        };
        // SAFETY: the caller promises the same.
        unsafe { by_differences(signature, call, rounding::<P>(&self.law), body) };
    }

    unsafe fn energy(&self, call: &RowCall<'_, P>) -> Option<f64> {
        self.law.declared.table.energy?;
        if self.numbers() == Numbers::Own {
            // One sum over all rows, in their order, as of any law: a field that is the same in all of them stands in each.
            let mut slots: Vec<*mut P> = call.slots.to_vec();
            let mut fields = Vec::new();
            for (number, slot) in slots.iter_mut().enumerate().filter(|(number, _)| call.uniform >> number & 1 == 1) {
                // SAFETY: a uniform field has its number, but where it is absent.
                let field = (!slot.is_null()).then(|| vec![unsafe { **slot }; call.rows]);
                fields.extend(field);
                if let Some(field) = fields.last_mut().filter(|_| !call.slots[number].is_null()) {
                    *slot = field.as_mut_ptr();
                }
            }
            let (slots, strides) = (slots.as_ptr().cast(), self.law.strides.as_ptr());
            let whole = abi::Call { precision: precision::<P>(), end: call.rows, slots, strides, ..no_call() };
            // SAFETY: the caller promises the slots.
            return Some(unsafe { self.law.energy(&whole) });
        }
        Some(in_numbers!(self, energy_of, call))
    }

    #[cfg(feature = "gpu")]
    fn trace(&self, _there: u64) -> Option<crate::backend::gpu::Trace> {
        None
    }
}

impl Rows {
    /// What rows are called with on a desk.
    fn numbers(&self) -> Numbers {
        if let Way::Desk(numbers) = self.way { numbers } else { Numbers::Own }
    }

    /// Begins sums.
    ///
    /// # Safety
    /// As for [`RowKernel::run`].
    unsafe fn nothing<P: Scalar>(&self, call: &RowCall<'_, P>) {
        for (to, slot) in call.slots.iter().zip(&self.law.slots) {
            if slot.port.mode == Mode::Adds && !to.is_null() {
                // SAFETY: passed on to the caller.
                unsafe { core::slice::from_raw_parts_mut(*to, call.rows) }.fill(P::default());
            }
        }
    }
}
