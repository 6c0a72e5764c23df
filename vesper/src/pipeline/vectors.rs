//! Vectors over the whole state: rates, and what integrators keep. Owned by the pipeline, laid out like the state.

use super::Pipeline;
use super::bind::{Base, Located, locate_column};
use crate::column::{Aligned, Storage};
use crate::integrate::Register;
use crate::law::{Part, Place, Port};
use crate::property::Role;
use crate::real::Scalar;
use crate::registry::QuantityId;
use crate::state::State;

/// One property that laws give rates of.
pub(crate) struct StateProperty<P: Scalar> {
    pub(crate) quantity: QuantityId,
    pub(crate) role: Role,
    /// Its number among all components of all states.
    pub(crate) first: usize,
    pub(crate) len: usize,
    /// Where the state's own components are.
    pub(crate) places: Vec<Located<P>>,
}

/// The shares of one seat: an array for each slot that it writes.
pub(crate) type Held<P> = (usize, Vec<(usize, Aligned<P>)>);

/// The vectors of a pipeline.
pub(crate) struct Vectors<P: Scalar> {
    pub(crate) states: Vec<StateProperty<P>>,
    /// Rates first, then the integrator's own; each has one array for each component.
    pub(crate) registers: Vec<Vec<Aligned<P>>>,
    /// Shares that are held between steps, for each seat that has any: one array for each slot it writes.
    pub(crate) held: Vec<Held<P>>,
    /// Whether the shares have been computed since the pipeline was made.
    pub(crate) filled: Vec<bool>,
}

impl<P: Scalar> Default for Vectors<P> {
    fn default() -> Self {
        Vectors { states: Vec::new(), registers: Vec::new(), held: Vec::new(), filled: Vec::new() }
    }
}

impl<P: Scalar> Vectors<P> {
    /// Zeros for every state, and `work` vectors besides the rates.
    pub(crate) fn new(pipeline: &Pipeline<P>, state: &State<P>, work: usize) -> Self {
        let mut states = Vec::new();
        let mut first = 0;
        for quantity in pipeline.states() {
            let known = &pipeline.registry.quantities[quantity];
            let width = known.info.kind.width();
            let places: Vec<Located<P>> =
                (0..width).filter_map(|c| locate_column(state, known.domain, known.info.name, c)).collect();
            let len = places.first().map_or(0, |place| place.len);
            states.push(StateProperty { quantity, role: known.info.role, first, len, places });
            first += width;
        }
        let register = |register: usize| -> Vec<Aligned<P>> {
            states
                .iter()
                .flat_map(|state| (0..state.places.len()).map(move |c| Aligned::zeros(state.len, register * 3 + c + 7)))
                .collect()
        };
        let registers = (0..=work).map(register).collect();
        let held = held(pipeline, state);
        let filled = vec![false; held.len()];
        Vectors { states, registers, held, filled }
    }

    /// The components of a state's rates.
    pub(crate) fn rate(&self, quantity: QuantityId, component: usize) -> Option<*mut P> {
        let state = self.states.iter().find(|state| state.quantity == quantity)?;
        Some(self.registers.first()?.get(state.first + component)?.pointer())
    }

    /// Runs `each` on every component of a part: start and stride of `to`, of `from`, and how many numbers.
    pub(crate) fn for_each(
        &self,
        to: Register,
        from: Register,
        part: Part,
        lent: &[*mut P],
        mut each: impl FnMut((*mut P, usize), (*mut P, usize), usize),
    ) {
        for state in self.states.iter().filter(|state| part.holds(&state.role)) {
            for (component, place) in state.places.iter().enumerate() {
                let at = |register| match register {
                    Register::State => (place.base.resolve(lent), place.stride),
                    Register::Rates => (self.registers[0][state.first + component].pointer(), 1),
                    Register::Work(index) => (self.registers[1 + index][state.first + component].pointer(), 1),
                };
                each(at(to), at(from), state.len);
            }
        }
    }
}

/// Memory for the shares of laws that are not evaluated on every step.
fn held<P: Scalar>(pipeline: &Pipeline<P>, state: &State<P>) -> Vec<Held<P>> {
    let mut held = Vec::new();
    for (index, seat) in pipeline.registry.seats.iter().enumerate() {
        let entry = &pipeline.entries[seat.law];
        if entry.options.every <= 1 {
            continue;
        }
        let slots = entry.signature.slots();
        let rows = |port: &Port| {
            let domain = if port.place == Place::End { seat.target } else { None };
            state.domains[domain.unwrap_or(seat.domain)].rows
        };
        let shares = entry
            .signature
            .outputs()
            .flat_map(|(port, declared)| (slots[port]..slots[port + 1]).map(move |slot| (slot, declared)))
            .map(|(slot, port)| (slot, Aligned::zeros(rows(port), slot)))
            .collect();
        held.push((index, shares));
    }
    held
}

/// The columns that the client's memory is behind, in the order in which it is held while the engine runs.
pub(crate) fn lent_columns<P: Scalar>(state: &State<P>) -> impl Iterator<Item = (usize, usize)> {
    state.domains.iter().enumerate().flat_map(|(d, domain)| {
        let lent = domain.columns.iter().enumerate().filter(|(_, column)| matches!(column.storage, Storage::Lent(_)));
        lent.map(move |(c, _)| (d, c))
    })
}

impl<P> Base<P> {
    /// The address, given the addresses of lent memory.
    #[inline]
    pub(crate) fn resolve(&self, lent: &[*mut P]) -> *mut P {
        match *self {
            Base::Owned(start) => start,
            // An address of one of a row's components: the row is as wide as the property, so it is inside.
            Base::Lent { memory, component } => lent[memory].wrapping_add(component),
        }
    }
}
