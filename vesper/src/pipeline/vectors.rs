//! Vectors over the whole state: rates, what integrators keep, and the rounding errors of a compensated state. Owned by
//! the pipeline.
//!
//! A vector is one array: coordinates first, then momenta in the order of the coordinates that they move, then other
//! states, component by component. Short components stand behind one another, with no more than room for the rest of a register
//! between them, so that a sum over a small state is one loop; long ones are staggered in memory, as columns are. What is
//! in the room behind a component is anything.

use super::Pipeline;
use super::bind::{Base, Located, locate_column};
use super::sum;
use crate::column::{Aligned, Block, Storage, is_long, staggered, whole};
use crate::integrate::Register;
use crate::law::{Part, Place, Port};
use crate::property::Role;
use crate::real::Scalar;
use crate::registry::QuantityId;
use crate::state::State;
use core::ops::Range;

/// One property that laws give rates of.
pub(crate) struct StateProperty<P: Scalar> {
    pub(crate) quantity: QuantityId,
    pub(crate) role: Role,
    /// Rows that have it.
    pub(crate) len: usize,
    /// Where its components are.
    pub(crate) components: Vec<Component<P>>,
    /// Whether its rates are given on a device, where its vectors are then.
    pub(crate) on_device: bool,
}

/// One component of a state.
pub(crate) struct Component<P: Scalar> {
    /// Where it begins in every vector.
    pub(crate) at: usize,
    /// Where it is in the state itself.
    pub(crate) place: Located<P>,
}

/// The shares of one seat: an array for each slot that it writes.
pub(crate) type Held<P> = (usize, Vec<(usize, Aligned<P>)>);

/// The vectors of a pipeline.
pub(crate) struct Vectors<P: Scalar> {
    pub(crate) states: Vec<StateProperty<P>>,
    /// The state itself, where its columns stand as the numbers of a vector do.
    state: Option<*mut P>,
    /// Where the vectors of registers begin: that of the state, or its image, or null; the rates; the integrator's own.
    starts: Vec<*mut P>,
    /// Rates first, then the integrator's own; where the state is compensated, its rounding errors; what a trial is more than
    /// meant, where laws look at that; and last, where there are no gaps, an image of the state.
    pub(crate) registers: Vec<Aligned<P>>,
    /// Whether rounding errors are kept.
    pub(crate) compensated: bool,
    /// What rounding added to the state as it is, where laws look at that, too: its rounding errors, or those of a trial. The
    /// number that is meant is less by so much. Only where the state stands as a vector does.
    pub(crate) rests: Option<*mut P>,
    /// Whether components are staggered, with gaps between them.
    gaps: bool,
    /// By what momenta are turned, and what they were before, where an integrator rotates them.
    pub(crate) rotation: Vec<Aligned<P>>,
    /// Rounding errors before a step that may be taken again.
    kept_errors: Vec<P>,
    /// How many vectors the integrator asked for.
    work: usize,
    /// Where coordinates end, and momenta, and all.
    ends: [usize; 3],
    /// How far behind its coordinate a momentum is, if every coordinate has one that laws move too.
    pub(crate) momentum_behind: Option<usize>,
    /// Shares that are held between steps, for each seat that has any: one array for each slot it writes.
    pub(crate) held: Vec<Held<P>>,
    /// Whether the shares have been computed since the pipeline was made.
    pub(crate) filled: Vec<bool>,
}

impl<P: Scalar> Default for Vectors<P> {
    fn default() -> Self {
        Vectors {
            states: Vec::new(),
            state: None,
            starts: Vec::new(),
            registers: Vec::new(),
            compensated: false,
            rests: None,
            gaps: false,
            rotation: Vec::new(),
            kept_errors: Vec::new(),
            work: 0,
            ends: [0; 3],
            momentum_behind: None,
            held: Vec::new(),
            filled: Vec::new(),
        }
    }
}

impl<P: Scalar> Vectors<P> {
    /// Zeros for every state, `work` vectors besides the rates, the rounding errors where they are kept, and what rotating
    /// needs.
    pub(crate) fn new(
        pipeline: &Pipeline<P>,
        state: &State<P>,
        work: usize,
        (compensated, rotates, differences): (bool, bool, bool),
    ) -> Self {
        let ordered = ordered(pipeline);
        let rows = |id: QuantityId| {
            let known = &pipeline.registry.quantities[id];
            locate_column(state, known.domain, known.info.name, 0).map_or(0, |place| place.len)
        };
        let gaps = ordered.iter().any(|&id| is_long::<P>(rows(id)));
        let (mut states, mut ends, mut at) = (Vec::new(), [0; 3], 0);
        for id in ordered {
            let known = &pipeline.registry.quantities[id];
            let len = rows(id);
            let mut components = Vec::new();
            for component in 0..known.info.kind.width() {
                let Some(place) = locate_column(state, known.domain, known.info.name, component) else { continue };
                components.push(Component { at, place });
                at += if gaps { staggered::<P>(len) } else { whole::<P>(len) };
            }
            let role = known.info.role;
            let from = match role {
                Role::Coordinate => 0,
                Role::Momentum(_) => 1,
                Role::Plain | Role::Switch | Role::Sum { .. } | Role::Turn { .. } => 2,
            };
            ends[from..].fill(at);
            states.push(StateProperty { quantity: id, role, len, components, on_device: false });
        }
        let one = as_one(&states).filter(|_| !gaps);
        let looks = compensated && differences && one.is_some();
        let count = 1 + work + usize::from(looks) + usize::from(compensated) + usize::from(!gaps);
        let held = held(pipeline, state);
        let filled = vec![false; held.len()];
        let momentum_behind = paired(&states, pipeline).then_some(ends[0]);
        let registers = in_one_block(count, if gaps { staggered::<P>(at) } else { at });
        let rests = registers.get(2 + work).filter(|_| looks).map(Aligned::pointer);
        let image = registers.last().filter(|_| !gaps).map_or(core::ptr::null_mut(), Aligned::pointer);
        let own = registers[..1 + work].iter().map(Aligned::pointer);
        let starts = [one.unwrap_or(image)].into_iter().chain(own).collect();
        let turned = if rotates && !pipeline.turnings.is_empty() { 2 } else { 0 };
        let rotation = (0..turned).map(|stream| Aligned::zeros(at, stream)).collect();
        Vectors {
            states,
            state: one,
            starts,
            registers,
            compensated,
            rests,
            gaps,
            rotation,
            kept_errors: Vec::new(),
            work,
            ends,
            momentum_behind,
            held,
            filled,
        }
    }

    /// The components of a state's rates.
    pub(crate) fn rate(&self, quantity: QuantityId, component: usize) -> Option<*mut P> {
        let state = self.states.iter().find(|state| state.quantity == quantity)?;
        let at = state.components.get(component)?.at;
        Some(self.registers.first()?.pointer().wrapping_add(at))
    }

    /// What rounding added to the components of a state as it is.
    pub(crate) fn rest(&self, quantity: QuantityId, component: usize) -> Option<*mut P> {
        let state = self.states.iter().find(|state| state.quantity == quantity)?;
        Some(self.rests?.wrapping_add(state.components.get(component)?.at))
    }

    /// The components of what a momentum is turned by.
    pub(crate) fn turned(&self, quantity: QuantityId, component: usize) -> Option<*mut P> {
        let state = self.states.iter().find(|state| state.quantity == quantity)?;
        Some(self.rotation.first()?.pointer().wrapping_add(state.components.get(component)?.at))
    }

    /// The vector of a register; `None` for the state, where it is not one array.
    pub(crate) fn vector(&self, register: Register) -> Option<*mut P> {
        if register == Register::State { self.state } else { Some(self.start(register)) }
    }

    /// The vector of a register; of a state that is not one array its image, where there is one.
    #[inline]
    pub(super) fn start(&self, register: Register) -> *mut P {
        sum::start(&self.starts, register)
    }

    /// Where all vectors begin.
    #[inline]
    pub(super) fn starts(&self) -> &[*mut P] {
        &self.starts
    }

    /// How many numbers behind the rates one of the integrator's vectors begins.
    pub(crate) fn behind_rates(&self, register: Register) -> usize {
        (self.start(register).addr().wrapping_sub(self.start(Register::Rates).addr())) / size_of::<P>()
    }

    /// Numbers of a vector, with gaps.
    pub(crate) fn len(&self) -> usize {
        self.registers[0].as_slice().len()
    }

    /// The last vector that was asked for.
    pub(crate) fn last_work(&self) -> usize {
        self.work.saturating_sub(1)
    }

    /// Keeps the rounding errors of the state, or brings them back.
    pub(crate) fn errors_again(&mut self, back: bool) {
        let Some(errors) = self.registers.get_mut(1 + self.work).filter(|_| self.compensated) else { return };
        if back {
            errors.as_mut_slice().copy_from_slice(&self.kept_errors);
        } else {
            self.kept_errors.clear();
            self.kept_errors.extend_from_slice(errors.as_slice());
        }
        self.look_at_errors(self.whole());
    }

    /// The rounding errors of the state.
    pub(crate) fn carry(&self) -> Option<*mut P> {
        self.registers.get(1 + self.work).filter(|_| self.compensated).map(Aligned::pointer)
    }

    /// Where the numbers of the state are laid out as in a vector while they are summed; only where there are no gaps.
    pub(crate) fn image(&self) -> Option<*mut P> {
        self.registers.last().filter(|_| !self.gaps).map(Aligned::pointer)
    }

    /// The vectors that a run goes on from: rates, the integrator's own, rounding errors.
    pub(crate) fn kept(&self) -> &[Aligned<P>] {
        &self.registers[..1 + self.work + usize::from(self.compensated)]
    }

    /// The numbers of one of them, without what is between components.
    pub(crate) fn packed(&self, array: &Aligned<P>) -> impl Iterator<Item = P> + Clone {
        let all = array.as_slice();
        let places: Vec<usize> = self.ranges(Part::All).flat_map(|(_, range)| range).collect();
        places.into_iter().map(move |at| all[at])
    }

    /// The same for numbers that are brought back to the vector of this number: whether there are as many as needed.
    /// [`Vectors::look_at_errors`] afterwards.
    pub(crate) fn unpack(&mut self, register: usize, numbers: impl ExactSizeIterator<Item = P>) -> bool {
        let places: Vec<usize> = self.ranges(Part::All).flat_map(|(_, range)| range).collect();
        let Some(array) = self.registers.get_mut(register).filter(|_| places.len() == numbers.len()) else {
            return false;
        };
        let all = array.as_mut_slice();
        places.into_iter().zip(numbers).for_each(|(at, number)| all[at] = number);
        true
    }

    /// How many states are coordinates: they come first.
    #[cfg(feature = "gpu")]
    pub(crate) fn coordinates(&self) -> usize {
        self.states.iter().filter(|state| state.role == Role::Coordinate).count()
    }

    /// All numbers of the state, and the gaps between them.
    pub(crate) fn whole(&self) -> Range<usize> {
        0..self.ends[2]
    }

    /// The numbers of a part, if they stand without longer gaps.
    pub(crate) fn span(&self, part: Part) -> Option<Range<usize>> {
        let range = match part {
            Part::All => 0..self.ends[2],
            Part::Coordinates => 0..self.ends[0],
            Part::Momenta => self.ends[0]..self.ends[1],
        };
        (!self.gaps).then_some(range)
    }

    /// The states of a part, with their numbers.
    pub(crate) fn part(&self, part: Part) -> impl Iterator<Item = (usize, &StateProperty<P>)> {
        self.states.iter().enumerate().filter(move |(_, state)| part.holds(&state.role))
    }

    /// The state was changed from outside: its rounding errors are gone.
    pub(crate) fn forget_errors(&mut self) {
        if let Some(errors) = self.registers.get_mut(1 + self.work).filter(|_| self.compensated) {
            errors.as_mut_slice().fill(P::default());
        }
        self.look_at_errors(self.whole());
    }
}

/// Zeros for so many vectors, one behind the other, so that what laws write to the place of one can go to that of another.
fn in_one_block<P: Scalar>(count: usize, len: usize) -> Vec<Aligned<P>> {
    let mut block = Block::new(count * whole::<P>(len));
    (0..count).map(|_| block.zeros(len)).collect()
}

/// Moves the columns of a small state together, in the order of a vector: then sums go over the state itself, without an
/// image of it. Lent memory stays where it is.
pub(super) fn lay_together<P: Scalar>(pipeline: &Pipeline<P>, state: &mut State<P>) {
    let ordered = ordered(pipeline);
    let mut places = Vec::new();
    let mut count = 0;
    for id in ordered {
        let known = &pipeline.registry.quantities[id];
        let domain = &state.domains[known.domain];
        let Some(column) = domain.find(known.info.name) else { return };
        let len = domain.columns[column].len();
        if is_long::<P>(len) || !matches!(domain.columns[column].storage, Storage::Split(_)) {
            return;
        }
        count += whole::<P>(len) * known.info.kind.width();
        places.push((known.domain, column));
    }
    let mut block = Block::new(count);
    for (domain, column) in places {
        if let Storage::Split(components) = &mut state.domains[domain].columns[column].storage {
            components.iter_mut().for_each(|component| block.take_in(component));
        }
    }
    state.changed_layout();
}

/// Where all states begin, if they are one array.
fn as_one<P: Scalar>(states: &[StateProperty<P>]) -> Option<*mut P> {
    let mut all = states.iter().filter(|state| state.len > 0).flat_map(|state| &state.components);
    let Base::Owned(start) = all.clone().next()?.place.base else { return None };
    let stands = |component: &Component<P>| match component.place.base {
        Base::Owned(place) => place == start.wrapping_add(component.at) && component.place.stride == 1,
        Base::Lent { .. } => false,
    };
    all.all(stands).then_some(start)
}

/// Coordinates, then their momenta in the same order, other momenta, other states.
fn ordered<P: Scalar>(pipeline: &Pipeline<P>) -> Vec<QuantityId> {
    let states = pipeline.states();
    let known = |id: &QuantityId| &pipeline.registry.quantities[*id];
    let coordinates = || states.iter().filter(|id| known(id).info.role == Role::Coordinate);
    let mut ordered: Vec<QuantityId> = coordinates().copied().collect();
    let momentum_of = |coordinate: &QuantityId| {
        let (domain, name) = (known(coordinate).domain, known(coordinate).info.name);
        states.iter().copied().find(|id| known(id).domain == domain && known(id).info.role == Role::Momentum(name))
    };
    ordered.extend(coordinates().filter_map(momentum_of));
    let momentum = |id: &&QuantityId| matches!(known(id).info.role, Role::Momentum(_));
    for rest in [states.iter().filter(momentum).collect::<Vec<_>>(), states.iter().collect()] {
        for id in rest {
            if !ordered.contains(id) {
                ordered.push(*id);
            }
        }
    }
    ordered
}

/// Whether each coordinate has a momentum that laws move too, of as many numbers, just as far behind.
fn paired<P: Scalar>(states: &[StateProperty<P>], pipeline: &Pipeline<P>) -> bool {
    let coordinates: Vec<_> = states.iter().filter(|state| state.role == Role::Coordinate).collect();
    let momenta = states.iter().skip(coordinates.len());
    let fits = coordinates.iter().zip(momenta).filter(|(coordinate, momentum)| {
        let [of, moves] = [coordinate, momentum].map(|state| &pipeline.registry.quantities[state.quantity]);
        of.domain == moves.domain
            && moves.info.role == Role::Momentum(of.info.name)
            && coordinate.len == momentum.len
            && coordinate.components.len() == momentum.components.len()
    });
    !coordinates.is_empty() && fits.count() == coordinates.len()
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
