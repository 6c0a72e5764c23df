//! A column law that a module made gets whole columns, as one that is compiled here.

use super::abi;
use super::instance::Instance;
use super::numbers::{Numbers, native, no_call, numbers, precision};
use crate::backend::ColumnKernel;
use crate::law::{ColumnAccess, MAX_SLOTS};
use crate::real::{Isa, Scalar};
use core::ffi::c_void;
use std::sync::Arc;

/// A column law of a module.
pub(super) struct Columns(pub(super) Arc<Instance>);

/// A component of a port: where its numbers are, how far apart, and how many.
type Numbered<P> = (*mut P, usize, usize);

impl Columns {
    fn components<P: Scalar>(&self, access: &ColumnAccess<'_, P>) -> [Numbered<P>; MAX_SLOTS] {
        let mut components = [(core::ptr::null_mut(), 0, 0); MAX_SLOTS];
        let mut slot = 0;
        for (port, view) in self.0.declared.signature.ports.iter().zip(access.ports()) {
            for component in &view.components[..port.property.kind.width()] {
                let stride = if self.0.slots[slot].one { 0 } else { view.stride };
                components[slot] = (*component, stride, view.rows);
                slot += 1;
            }
        }
        components
    }

    /// # Safety
    /// As for [`ColumnKernel::run`].
    unsafe fn converted<P: Scalar, Q: Scalar>(&self, access: &ColumnAccess<'_, P>) {
        let count = self.0.slots.len();
        let components = self.components(access);
        let copy = |(start, stride, rows): &Numbered<P>| -> Vec<Q> {
            let rows = if start.is_null() { 0 } else { *rows };
            // SAFETY: the views reach all rows.
            (0..rows).map(|row| Q::from_f64(unsafe { *start.add(row * stride) }.to_f64())).collect()
        };
        let mut copies: Vec<Vec<Q>> = components[..count].iter().map(copy).collect();
        let numbered = |copy: &mut Vec<Q>| {
            (if copy.is_empty() { core::ptr::null_mut() } else { copy.as_mut_ptr() }, 1, copy.len())
        };
        let own: Vec<Numbered<Q>> = copies.iter_mut().map(numbered).collect();
        // SAFETY: passed on to the caller.
        if !unsafe { self.call(&own, access) } {
            return;
        }
        let all = components[..count].iter().zip(&copies).zip(&self.0.slots);
        for (((start, stride, _), copy), _) in all.filter(|(_, slot)| !slot.port.mode.is_input()) {
            for (row, number) in copy.iter().enumerate() {
                // SAFETY: as above, and nobody else touches what the law writes.
                unsafe { *start.add(row * stride) = P::from_f64(number.to_f64()) };
            }
        }
    }

    /// # Safety
    /// As for [`ColumnKernel::run`].
    unsafe fn call<P: Scalar, Q: Scalar>(&self, components: &[Numbered<Q>], access: &ColumnAccess<'_, P>) -> bool {
        let mut slots = [core::ptr::null_mut::<c_void>(); MAX_SLOTS];
        let (mut strides, mut rows) = ([0; MAX_SLOTS], [0; MAX_SLOTS]);
        for (slot, component) in components.iter().enumerate().take(self.0.slots.len()) {
            (slots[slot], strides[slot], rows[slot]) = (component.0.cast(), component.1, component.2);
        }
        let link = access.link();
        let most = self.0.slots.iter().zip(&rows).filter(|(slot, _)| !slot.one).map(|(_, rows)| *rows).max();
        let native = native(Isa::Baseline);
        let knows = self.0.declared.table.native == abi::NATIVE;
        let to_law = abi::Call {
            precision: precision::<Q>(),
            end: most.unwrap_or(1),
            others_end: link.len(),
            slots: slots.as_ptr(),
            strides: strides.as_ptr(),
            rows: rows.as_ptr(),
            links: if link.is_empty() { core::ptr::null() } else { link.get(0).as_ptr() },
            native: if knows { &raw const native } else { core::ptr::null() },
            ..no_call()
        };
        // SAFETY: passed on to the caller.
        unsafe { self.0.call(&to_law) }
    }
}

impl<P: Scalar> ColumnKernel<P> for Columns {
    unsafe fn run(&self, access: &ColumnAccess<'_, P>) {
        // SAFETY: the caller promises the same.
        unsafe {
            match numbers::<P>(&self.0) {
                Numbers::Own => _ = self.call(&self.components(access), access),
                Numbers::Double => self.converted::<P, f64>(access),
                Numbers::Single => self.converted::<P, f32>(access),
            }
        }
    }
}
