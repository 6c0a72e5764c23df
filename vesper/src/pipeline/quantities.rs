//! Rows of single properties, for integrators that use the structure of their problem.
//!
//! In: a runner, a name. Out: numbers in f64, component by component, copied from where they are, and back. Never: a place
//! in memory that outlives the call.

use super::bind::{Located, locate_column};
use super::run::Runner;
use super::vectors::StateProperty;
use crate::integrate::{At, Quantity, Register};
use crate::real::Scalar;

impl<P: Scalar> Runner<'_, P> {
    /// A property of a domain that all rows have.
    pub(super) fn quantity(&self, name: &str) -> Option<Quantity> {
        let (domain, property) = name.rsplit_once('.')?;
        let domain = self.state.domain_index(domain)?;
        let column = self.state.domains[domain].find(property)?;
        let info = self.state.domains[domain].columns[column].info;
        let first = locate_column(self.state, domain, property, 0)?;
        if first.subset.is_some() {
            return None;
        }
        let known = self.pipeline.registry.find(domain, property);
        let state = |known| self.pipeline.vectors.states.iter().position(|state| state.quantity == known);
        let at = known.and_then(state).map_or(At::Column { domain, column }, At::State);
        Some(Quantity { at, rows: first.len, width: info.kind.width() })
    }

    pub(super) fn read_quantity(&self, quantity: Quantity, from: Register, to: &mut [f64]) {
        let mut to = to.iter_mut();
        match quantity.at {
            At::State(number) => {
                let Some(state) = self.pipeline.vectors.states.get(number) else { return };
                for component in &state.components {
                    let place = match self.pipeline.vectors.vector(from) {
                        Some(vector) => (vector.wrapping_add(component.at), 1),
                        None => self.start(&component.place),
                    };
                    // SAFETY: there are `len` numbers, and the runner holds the state.
                    unsafe { copy(place, to.by_ref().take(state.len)) };
                }
            }
            At::Column { domain, column } => {
                let Some(known) = self.state.domains.get(domain) else { return };
                let Some(column) = known.columns.get(column) else { return };
                for component in 0..quantity.width {
                    let Some(place) = locate_column(self.state, domain, column.info.name, component) else { return };
                    // SAFETY: as above.
                    unsafe { copy(self.start(&place), to.by_ref().take(place.len)) };
                }
            }
        }
    }

    pub(super) fn write_quantity(&mut self, quantity: Quantity, from: &[f64]) {
        let At::State(number) = quantity.at else { return };
        let Some(StateProperty { components, len, .. }) = self.pipeline.vectors.states.get(number) else { return };
        for (component, from) in components.iter().zip(from.chunks_exact((*len).max(1))) {
            let (start, stride) = self.start(&component.place);
            for (row, number) in from.iter().enumerate() {
                // SAFETY: it has `len` numbers, and so has the chunk; the runner holds the state.
                unsafe { *start.add(row * stride) = P::from_f64(*number) };
                if let Some(rests) = self.pipeline.vectors.rests {
                    // SAFETY: rests have a place for every number of the state.
                    unsafe { *rests.add(component.at + row) = P::default() };
                }
            }
        }
    }

    fn start(&self, place: &Located<P>) -> (*mut P, usize) {
        (place.base.resolve(self.context.lent), place.stride)
    }
}

/// Reads numbers that lie so far apart, one for each of these.
///
/// # Safety
/// There are as many, and nobody else touches them.
unsafe fn copy<'a, P: Scalar>((start, stride): (*mut P, usize), to: impl Iterator<Item = &'a mut f64>) {
    for (row, to) in to.enumerate() {
        // SAFETY: the caller promises the numbers.
        *to = unsafe { *start.add(row * stride) }.to_f64();
    }
}
