//! From the plan of derivatives to places: each computed quantity gets arrays of its own, each state the direction.

use super::difference::{Difference, PortOf};
use super::{Place, Step, Tangent};
use crate::backend::{Kernel, Reach};
use crate::column::{Aligned, Storage};
use crate::law::Mode;
use crate::pipeline::bind::{Base, Located, locate_column};
use crate::pipeline::operand::Operand;
use crate::pipeline::plan::{Key, Op, Placed, plan};
use crate::pipeline::{Listed, Pipeline};
use crate::real::Scalar;
use crate::registry::QuantityId;
use crate::state::State;

/// What a program of derivatives is made from, and what is made.
struct Binder<'a, P: Scalar> {
    pipeline: &'a Pipeline<P>,
    laws: &'a [Listed<P>],
    state: &'a State<P>,
    states: Vec<QuantityId>,
    along: *mut P,
    rates: *mut P,
    /// Where the values of computed quantities and of samples are, and those of their derivatives.
    own: Vec<(Operand, [*mut P; 2])>,
    arrays: Vec<Aligned<P>>,
    indices: Vec<Vec<u32>>,
}

impl<P: Scalar> Tangent<P> {
    /// The program of a pipeline whose vectors are laid out.
    pub(crate) fn new(pipeline: &Pipeline<P>, laws: &[Listed<P>], state: &State<P>) -> Self {
        let count = pipeline.vectors.len();
        let [along, rates] = [1, 2].map(|stream| Aligned::zeros(count, stream));
        let mut binder = Binder {
            pipeline,
            laws,
            state,
            states: pipeline.states(),
            along: along.pointer(),
            rates: rates.pointer(),
            own: Vec::new(),
            arrays: Vec::new(),
            indices: Vec::new(),
        };
        let plan = plan(Key::Tangent, pipeline);
        let steps: Vec<Step<P>> = plan.passes.iter().flatten().filter_map(|op| binder.step(op)).collect();
        let widest = steps.iter().map(|step| if let Step::Law { slots, .. } = step { slots.len() } else { 0 }).max();
        Tangent {
            steps,
            along,
            rates,
            resolved: Vec::with_capacity(widest.unwrap_or(0)),
            _arrays: binder.arrays,
            _indices: binder.indices,
        }
    }
}

impl<P: Scalar> Binder<'_, P> {
    fn step(&mut self, op: &Placed) -> Option<Step<P>> {
        let rows = op.rows.as_ref().map_or(self.state.domains[op.domain].rows, Vec::len);
        if rows == 0 {
            return None;
        }
        match op.op {
            Op::Start { sum, .. } => {
                let width = self.pipeline.registry.quantities[sum].info.kind.width();
                let places: Vec<Place<P>> = op.operands.iter().map(|operand| self.place(*operand, op)).collect();
                let (to, from) = places.split_at(width);
                Some(Step::Start { to: to.to_vec(), from: from.to_vec(), rows })
            }
            Op::Sample { field } => {
                let at = op.operands[..3].iter().map(|operand| self.place(*operand, op)).collect();
                // Each pass has samples of its own.
                self.own.retain(|(known, _)| !matches!(known, Operand::Field(other, _) if *other == field));
                let to = op.operands[3..].iter().map(|operand| self.place(*operand, op)).collect();
                let regions = self.pipeline.switches.at(field, op.domain, op.rows.as_ref());
                Some(Step::Sample { field, at, to, rows, regions })
            }
            Op::Law { seat, .. } => self.law(op, seat, rows),
            // What laws look back at, they look back at in the columns.
            Op::Keep | Op::Axpy { .. } | Op::Release { .. } | Op::Hold { .. } => None,
        }
    }

    fn law(&mut self, op: &Placed, seat: usize, rows: usize) -> Option<Step<P>> {
        let seat = &self.pipeline.registry.seats[seat];
        let entry = &self.pipeline.entries[seat.law];
        let signature = &entry.signature;
        let linked = signature.link.and_then(|link| {
            let domain = &self.state.domains[op.domain];
            match &domain.columns[domain.find(link.name)?].storage {
                Storage::Link { rows, arity, .. } => Some((rows.as_ptr(), rows.len(), *arity)),
                Storage::Split(_) | Storage::Lent(_) => None,
            }
        });
        let slots: Vec<Place<P>> = op.operands.iter().map(|operand| self.place(*operand, op)).collect();
        let kernel = &self.laws[seat.law].compiled.kernel;
        if kernel.differentiates() {
            let ends = linked.map_or((core::ptr::null(), 0), |(start, count, _)| (start, count));
            return Some(Step::Law { law: seat.law, slots, rows, ends });
        }
        let at = signature.slots();
        let ports = signature.ports.iter().enumerate().map(|(number, port)| {
            let range = at[number]..at[number + 1];
            let operand = op.operands[range.start];
            // Whole columns, but for pairs, which may be of some rows.
            let rows = match (kernel, operand) {
                (Kernel::Pair(_), Operand::Quantity(..)) => rows,
                _ => self.rows_of(operand),
            };
            let adds = port.mode == Mode::Adds;
            PortOf::new(slots[range].to_vec(), rows, port.mode.is_input(), adds)
        });
        Some(Step::Difference(Difference::new(seat.law, ports.collect(), linked)))
    }

    /// How many rows of an operand a column law sees.
    fn rows_of(&self, operand: Operand) -> usize {
        match operand {
            Operand::Quantity(id, _) | Operand::Rate(id, _) | Operand::Previous(id, _) => {
                let known = &self.pipeline.registry.quantities[id];
                let there = locate_column(self.state, known.domain, known.info.name, 0);
                there.map_or(self.state.domains[known.domain].rows, |there| there.len)
            }
            Operand::Constant(..) | Operand::Default(_) => 1,
            Operand::Field(..) | Operand::Held(..) | Operand::Turned(..) | Operand::Zero | Operand::Absent => 0,
        }
    }

    /// Where an operand's numbers are, and those of their derivatives, as an operation reaches them.
    fn place(&mut self, operand: Operand, op: &Placed) -> Place<P> {
        match operand {
            Operand::Absent | Operand::Held(..) | Operand::Turned(..) | Operand::Zero => Place::NONE,
            Operand::Default(value) => {
                let mut number = Aligned::zeros(1, 0);
                number.as_mut_slice()[0] = P::from_f64(value);
                let value = Base::Owned(number.pointer());
                self.arrays.push(number);
                Place { value, ..Place::NONE }
            }
            Operand::Field(..) => {
                let rows = op.rows.as_ref().map_or(self.state.domains[op.domain].rows, Vec::len);
                let [value, derivative] = self.own(operand, rows);
                let derivative = Reach { start: derivative, stride: 1, index: core::ptr::null() };
                Place { value: Base::Owned(value), stride: 1, index: core::ptr::null(), derivative }
            }
            Operand::Previous(id, component) => {
                let known = &self.pipeline.registry.quantities[id];
                let columns = &self.state.domains[known.domain].previous;
                let Some(column) = columns.iter().find(|column| column.info.name == known.info.name) else {
                    return Place::NONE;
                };
                let Storage::Split(components) = &column.storage else { return Place::NONE };
                let index = self.index(op.rows.as_deref(), None);
                Place { value: Base::Owned(components[component].pointer()), stride: 1, index, ..Place::NONE }
            }
            Operand::Rate(id, component) => {
                let index = self.index_of(id, op);
                let Some(start) = self.in_vector(self.rates, id, component) else { return Place::NONE };
                Place { derivative: Reach { start, stride: 1, index }, ..Place::NONE }
            }
            Operand::Constant(id, component) => {
                let Place { value, derivative, .. } = self.quantity(id, component, core::ptr::null());
                Place { value, derivative: Reach { stride: 0, ..derivative }, ..Place::NONE }
            }
            // A link law's rows are those of its links, or of the rows linked to.
            Operand::Quantity(id, component) => {
                let index = self.index_of(id, op);
                self.quantity(id, component, index)
            }
        }
    }

    /// Given by the client, moved by laws, or computed.
    fn quantity(&mut self, id: QuantityId, component: usize, index: *const u32) -> Place<P> {
        let known = &self.pipeline.registry.quantities[id];
        let moves = self.states.contains(&id);
        if !known.given && !moves {
            let rows = self.state.domains[known.domain].rows;
            let [value, derivative] = self.own(Operand::Quantity(id, component), rows);
            let derivative = Reach { start: derivative, stride: 1, index };
            return Place { value: Base::Owned(value), stride: 1, index, derivative };
        }
        let Some(Located { base, stride, .. }) = locate_column(self.state, known.domain, known.info.name, component)
        else {
            return Place::NONE;
        };
        let along = if moves { self.in_vector(self.along, id, component) } else { None };
        let derivative = along.map_or(Reach::NONE, |start| Reach { start, stride: 1, index });
        Place { value: base, stride, index, derivative }
    }

    /// The component of a state in one of the vectors.
    fn in_vector(&self, vector: *mut P, id: QuantityId, component: usize) -> Option<*mut P> {
        let state = self.pipeline.vectors.states.iter().find(|state| state.quantity == id)?;
        Some(vector.wrapping_add(state.components.get(component)?.at))
    }

    /// The arrays of what laws compute.
    fn own(&mut self, operand: Operand, rows: usize) -> [*mut P; 2] {
        if let Some((_, known)) = self.own.iter().find(|(known, _)| *known == operand) {
            return *known;
        }
        let made = [0, 1].map(|half| Aligned::zeros(rows, 2 * self.own.len() + half));
        let pointers = [made[0].pointer(), made[1].pointer()];
        self.arrays.extend(made);
        self.own.push((operand, pointers));
        pointers
    }

    /// Where in a quantity's column the rows of an operation are.
    fn index_of(&mut self, id: QuantityId, op: &Placed) -> *const u32 {
        let known = &self.pipeline.registry.quantities[id];
        let computed = !known.given && !self.states.contains(&id);
        let subset = if computed {
            None
        } else {
            locate_column(self.state, known.domain, known.info.name, 0).and_then(|there| there.subset)
        };
        self.index(op.rows.as_deref(), subset.as_deref())
    }

    fn index(&mut self, rows: Option<&[u32]>, subset: Option<&[u32]>) -> *const u32 {
        let Some(rows) = rows else { return core::ptr::null() };
        let index: Vec<u32> = match subset {
            None => rows.to_vec(),
            Some(subset) => {
                let at = |row: &u32| u32::try_from(subset.binary_search(row).unwrap_or_default()).unwrap_or_default();
                rows.iter().map(at).collect()
            }
        };
        let start = index.as_ptr();
        self.indices.push(index);
        start
    }
}
