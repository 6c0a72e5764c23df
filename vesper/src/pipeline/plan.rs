//! What is asked, as a list of operations over named places; no pointer yet.

use super::Pipeline;
use super::operand::Operand;
use super::turning::{hold_still, turned};
use crate::graph::wanted_inputs;
use crate::law::{Mode, Part, Place, Port, Shape};
use crate::property::Role;
use crate::real::Scalar;
use crate::registry::{Backend, Entry, QuantityId, Seat, Status, Tie, computes, start_of};

/// What can be asked of a pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Key {
    /// The rates of a part, stored.
    Evaluate(Part),
    /// The states of a part, advanced.
    Advance(Part),
    /// The momenta advanced, then the coordinates.
    KickDrift,
    /// The rates of the momenta without what turns them, and beside them what turns them.
    Unturned,
    /// What is turned, where it is not the momentum itself.
    Turners,
    /// The amending laws, after a step.
    Amend,
    /// The computed quantities that the client looks at.
    Observe,
    /// The energies of all laws.
    Energy,
    /// The derivatives of all rates along a direction, which have a program of their own (`tangent`).
    Tangent,
}

impl Key {
    pub(crate) const ALL: [Key; 12] = [
        Key::Evaluate(Part::All),
        Key::Evaluate(Part::Coordinates),
        Key::Evaluate(Part::Momenta),
        Key::Advance(Part::All),
        Key::Advance(Part::Coordinates),
        Key::Advance(Part::Momenta),
        Key::KickDrift,
        Key::Unturned,
        Key::Turners,
        Key::Amend,
        Key::Observe,
        Key::Energy,
    ];

    /// Where the key's program is among a pipeline's; that of derivatives stands behind them.
    pub(crate) fn index(self) -> usize {
        match self {
            Key::Evaluate(part) => part_index(part),
            Key::Advance(part) => 3 + part_index(part),
            Key::KickDrift => 6,
            Key::Unturned => 7,
            Key::Turners => 8,
            Key::Amend => 9,
            Key::Observe => 10,
            Key::Energy => 11,
            Key::Tangent => Key::ALL.len(),
        }
    }

    /// The parts that are evaluated in turn.
    fn stages(self) -> Vec<Part> {
        match self {
            Key::Evaluate(part) | Key::Advance(part) => vec![part],
            Key::KickDrift => vec![Part::Momenta, Part::Coordinates],
            Key::Unturned => vec![Part::Momenta],
            Key::Turners | Key::Amend | Key::Observe | Key::Energy | Key::Tangent => vec![Part::All],
        }
    }
}

fn part_index(part: Part) -> usize {
    match part {
        Part::All => 0,
        Part::Coordinates => 1,
        Part::Momenta => 2,
    }
}

/// One operation.
#[derive(Clone, Debug)]
pub(crate) enum Op {
    /// A sum begins: from zero, or from the values of another quantity.
    Start { sum: QuantityId, from: Option<QuantityId> },
    /// A field is sampled at the place of every row.
    Sample { field: usize },
    /// A law runs. `advance`: the stage whose step its rates advance the states by, at once.
    /// `drift`: the stage of the coordinates, where the same loop advances them after the momenta. `first`: its shares
    /// are stored, since the sums that it adds to begin with it.
    Law { seat: usize, part: Part, advance: Option<usize>, drift: Option<usize>, energy: bool, first: bool },
    /// States advance by stored rates.
    Axpy { stage: usize },
    /// Shares that are held begin from zero again.
    Release { seat: usize },
    /// Held shares are added.
    Hold { seat: usize },
    /// Results are kept for laws that look back at them in the next evaluation.
    Keep,
}

/// An operation where it runs.
#[derive(Clone, Debug)]
pub(crate) struct Placed {
    pub(crate) op: Op,
    pub(crate) domain: usize,
    pub(crate) rows: Option<Vec<u32>>,
    /// Whether it may share a pass with its neighbours.
    pub(crate) row_local: bool,
    pub(crate) backend: Backend,
    /// It runs on every n-th step, or adds what ran then.
    pub(crate) every: u32,
    /// What it reads and writes; for a law, by slot.
    pub(crate) operands: Vec<Operand>,
    pub(crate) writes: Vec<bool>,
}

/// What is asked, in order, cut into passes.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(crate) key: Key,
    pub(crate) passes: Vec<Vec<Placed>>,
}

impl Plan {
    /// Of what nobody asks.
    pub(crate) fn nothing(key: Key) -> Self {
        Plan { key, passes: Vec::new() }
    }
}

/// Makes the plan of a key.
pub(crate) fn plan<P: Scalar>(key: Key, pipeline: &Pipeline<P>) -> Plan {
    let mut ops = Vec::new();
    for (stage, part) in key.stages().into_iter().enumerate() {
        Stage { pipeline, key, stage, part, ops: &mut ops, started: Vec::new(), sampled: Vec::new() }.emit();
    }
    let mut passes: Vec<Vec<Placed>> = Vec::new();
    for op in ops {
        let joins = passes.last().and_then(|pass| pass.first()).is_some_and(|first| {
            first.row_local
                && op.row_local
                && first.domain == op.domain
                && first.rows == op.rows
                && first.backend == op.backend
        });
        match passes.last_mut() {
            Some(pass) if joins => pass.push(op),
            _ => passes.push(vec![op]),
        }
    }
    // What is looked at begins from a plain zero, and so do derivatives.
    if !matches!(key, Key::Observe | Key::Tangent) {
        passes.iter_mut().for_each(|pass| super::merge::begin_with_laws(pass, pipeline));
        super::merge::begin_with_pairs(&mut passes, pipeline);
    }
    Plan { key, passes }
}

/// One stage of a key while its operations are listed.
struct Stage<'a, P: Scalar> {
    pipeline: &'a Pipeline<P>,
    key: Key,
    stage: usize,
    part: Part,
    ops: &'a mut Vec<Placed>,
    started: Vec<QuantityId>,
    sampled: Vec<(usize, usize)>,
}

impl<P: Scalar> Stage<'_, P> {
    fn emit(mut self) {
        let Pipeline { entries, registry, graph, observed, .. } = self.pipeline;
        let first = self.ops.len();
        let (targets, needs) = match self.key {
            Key::Evaluate(_) | Key::Advance(_) | Key::KickDrift | Key::Unturned | Key::Tangent => {
                graph.raters(self.part, entries, registry)
            }
            Key::Turners => (Vec::new(), self.pipeline.turners().collect()),
            Key::Amend => graph.amenders(entries, registry),
            Key::Observe => (Vec::new(), observed.clone()),
            Key::Energy => {
                let needs = graph.order.iter().flat_map(|&seat| {
                    let seat = &registry.seats[seat];
                    crate::graph::inputs(&entries[seat.law].signature, seat, u64::MAX)
                });
                (Vec::new(), needs.collect())
            }
        };
        let makers = graph.makers(&needs, entries, registry);
        let mut advanced = Vec::new();
        for &seat in &graph.order {
            let rates = targets.contains(&seat);
            if rates || makers.contains(&seat) {
                self.law(seat, rates, &targets, &makers, &mut advanced);
                if self.key == Key::Unturned {
                    self.turned(seat);
                }
            }
        }
        if self.key == Key::Observe {
            // A sum that is looked at, but that nobody adds to, is still a sum from its start.
            for &quantity in observed {
                self.start(quantity, Backend::Auto);
            }
        }
        if self.key == Key::Energy {
            let runs =
                |seat: &usize| matches!(registry.report.laws[registry.seats[*seat].law].status, Status::Active { .. });
            for seat in graph.order.iter().copied().filter(runs).collect::<Vec<_>>() {
                let quantities: Vec<QuantityId> =
                    crate::graph::inputs(&entries[registry.seats[seat].law].signature, &registry.seats[seat], u64::MAX)
                        .collect();
                quantities.into_iter().for_each(|quantity| self.start(quantity, Backend::Auto));
                self.push_law(seat, Part::All, None, true);
            }
        }
        for state in advanced {
            self.axpy(state);
        }
        // Looking, and amending after a step, are no evaluations that a next one could look back at.
        if matches!(self.key, Key::Evaluate(_) | Key::Advance(_) | Key::KickDrift | Key::Unturned) {
            self.keep(first);
        }
    }

    /// Keeps what laws look back at, of what the operations from `first` on have made.
    fn keep(&mut self, first: usize) {
        let Pipeline { entries, registry, .. } = self.pipeline;
        let mut looked_back_at: Vec<QuantityId> = registry
            .seats
            .iter()
            .flat_map(|seat| entries[seat.law].signature.ports.iter().zip(&seat.ties))
            .filter_map(|(port, tie)| match tie {
                Tie::Quantity(id) if port.mode == Mode::Previous && !registry.quantities[*id].given => Some(*id),
                _ => None,
            })
            .collect();
        looked_back_at.sort_unstable();
        looked_back_at.dedup();
        for id in looked_back_at {
            let writes = |op: &Placed| {
                op.operands.iter().zip(&op.writes).any(|(to, writes)| *writes && to.quantity() == Some(id))
            };
            if !self.ops[first..].iter().any(writes) {
                continue;
            }
            let op = self.whole(Op::Keep, id, |c| Operand::Previous(id, c), Some(|c| Operand::Quantity(id, c)));
            self.ops.push(op);
        }
    }

    fn seat(&self, seat: usize) -> (&Seat, &Entry) {
        let seat = &self.pipeline.registry.seats[seat];
        (seat, &self.pipeline.entries[seat.law])
    }

    fn law(&mut self, index: usize, rates: bool, targets: &[usize], makers: &[usize], advanced: &mut Vec<QuantityId>) {
        let (seat, entry) = self.seat(index);
        let mask = if rates { wanted_inputs(&entry.signature, self.part).unwrap_or(u64::MAX) } else { u64::MAX };
        // A row law that sets a sum does so in all rows: there it begins.
        let begins = |port: &Port| port.mode == Mode::Sets && entry.shape == Shape::Row;
        let tied = |wanted: &dyn Fn(usize, &Port) -> bool| -> Vec<QuantityId> {
            let ports = entry.signature.ports.iter().enumerate().zip(&seat.ties);
            let wanted = ports.filter(|((number, port), _)| wanted(*number, port));
            wanted.filter_map(|(_, tie)| if let Tie::Quantity(id) = tie { Some(*id) } else { None }).collect()
        };
        let begun = tied(&|_, port| begins(port));
        let touched = tied(&|number, port| match port.mode {
            Mode::Adds => self.wants(entry, port, &seat.ties[number]),
            Mode::Sets => !begins(port),
            Mode::Reads => number >= 64 || mask >> number & 1 == 1,
            Mode::Rates | Mode::Previous | Mode::Amends => false,
        });
        let fields: Vec<usize> =
            seat.ties.iter().filter_map(|tie| if let Tie::Field(field) = tie { Some(*field) } else { None }).collect();
        let place = seat.place;
        let backend = entry.options.backend;
        touched.into_iter().for_each(|quantity| self.start(quantity, backend));
        self.started.extend(begun);
        if let Some(place) = place {
            fields.into_iter().for_each(|field| self.sample(index, field, place));
        }
        let advances = rates && matches!(self.key, Key::Advance(_) | Key::KickDrift);
        let direct = advances && self.may_advance_at_once(index, targets, makers);
        let advance = direct.then_some(self.stage);
        self.push_law(index, self.part, advance, false);
        if advances && !direct {
            let (seat, entry) = self.seat(index);
            for (port, tie) in entry.signature.ports.iter().zip(&seat.ties) {
                if let (Mode::Rates, Tie::Quantity(id)) = (port.mode, tie)
                    && self.part.holds(&port.property.role)
                {
                    advanced.push(*id);
                }
            }
        }
    }

    /// A row law may advance its states at once if no law that follows in this stage looks at them.
    fn may_advance_at_once(&self, index: usize, targets: &[usize], makers: &[usize]) -> bool {
        let (seat, entry) = self.seat(index);
        if entry.shape != Shape::Row {
            return false;
        }
        let states: Vec<QuantityId> = crate::graph::outputs(&entry.signature, seat)
            .filter(|(mode, _)| *mode == Mode::Rates)
            .map(|(_, id)| id)
            .collect();
        let order = &self.pipeline.graph.order;
        let after = order.iter().skip_while(|seat| **seat != index).skip(1);
        after.filter(|seat| targets.contains(seat) || makers.contains(seat)).all(|&later| {
            let (seat, entry) = self.seat(later);
            crate::graph::inputs(&entry.signature, seat, u64::MAX).all(|id| !states.contains(&id))
        })
    }

    /// A sum begins before the first law that adds to it or looks at it.
    fn start(&mut self, quantity: QuantityId, backend: Backend) {
        let registry = &self.pipeline.registry;
        let known = &registry.quantities[quantity];
        let is_sum = known.info.role.is_sum();
        if !is_sum || known.given || self.started.contains(&quantity) {
            return;
        }
        self.started.push(quantity);
        let from = start_of(quantity, registry);
        let op = Op::Start { sum: quantity, from };
        let other = from.map(|from| move |c| Operand::Quantity(from, c));
        let start = self.whole(op, quantity, |c| Operand::Quantity(quantity, c), other);
        self.ops.push(Placed { row_local: true, backend, ..start });
    }

    fn sample(&mut self, index: usize, field: usize, place: QuantityId) {
        let (seat, entry) = self.seat(index);
        let (domain, rows, backend) = (seat.domain, seat.rows.clone(), entry.options.backend);
        // A group samples a field once: the same rows, no other pass between. A new pass samples anew.
        let at = self.ops.iter().rposition(|op| matches!(op.op, Op::Sample { field: other, .. } if other == field));
        let same_pass = at.is_some_and(|at| {
            self.ops[at..].iter().all(|op| {
                op.row_local && op.domain == domain && op.rows == rows && op.backend == backend && op.every == 1
            })
        });
        if same_pass && self.sampled.contains(&(field, domain)) {
            return;
        }
        self.sampled.push((field, domain));
        self.ops.push(Placed {
            op: Op::Sample { field },
            domain,
            rows,
            row_local: true,
            backend,
            every: 1,
            operands: (0..3)
                .map(|c| Operand::Quantity(place, c))
                .chain((0..3).map(|c| Operand::Field(field, c)))
                .collect(),
            writes: vec![false, false, false, true, true, true],
        });
    }

    fn push_law(&mut self, index: usize, part: Part, advance: Option<usize>, energy: bool) {
        let (seat, entry) = self.seat(index);
        let registry = &self.pipeline.registry;
        let every = entry.options.every;
        // A derivative is that of the law as it is, on whatever steps.
        let held = every > 1 && !energy && self.key != Key::Tangent;
        let mask = wanted_inputs(&entry.signature, part);
        let mut operands = Vec::new();
        let mut writes = Vec::new();
        for (number, (port, tie)) in entry.signature.ports.iter().zip(&seat.ties).enumerate() {
            for component in 0..port.property.kind.width() {
                let slot = operands.len();
                let unwanted = port.mode.is_input()
                    && !energy
                    && entry.shape != Shape::Column
                    && mask.is_some_and(|mask| number < 64 && mask >> number & 1 == 0)
                    && !entry.signature.ports.iter().any(|other| computes(other.mode) || other.mode == Mode::Amends);
                operands.push(match (tie, port.mode) {
                    _ if unwanted || energy && !port.mode.is_input() => Operand::Absent,
                    _ if !self.wants(entry, port, tie) => Operand::Absent,
                    (Tie::Absent, _) => Operand::Absent,
                    (Tie::Default(value), _) => Operand::Default(value[component.min(2)]),
                    (Tie::Field(field), _) => Operand::Field(*field, component),
                    // A column law gives all its rates; those that are not wanted are rates all the same.
                    (Tie::Quantity(id), Mode::Rates) if entry.shape == Shape::Column => Operand::Rate(*id, component),
                    (Tie::Quantity(_), Mode::Rates) if !part.holds(&port.property.role) => Operand::Absent,
                    (Tie::Quantity(id), Mode::Rates) if advance.is_none() => Operand::Rate(*id, component),
                    (Tie::Quantity(_), Mode::Adds) if held => Operand::Held(index, slot),
                    (Tie::Quantity(id), Mode::Previous) if !registry.quantities[*id].given => {
                        Operand::Previous(*id, component)
                    }
                    (Tie::Quantity(id), _) if port.place == Place::Scene => Operand::Constant(*id, component),
                    (Tie::Quantity(id), _) => Operand::Quantity(*id, component),
                });
                writes.push(!port.mode.is_input());
            }
        }
        let mut placed = Placed {
            op: Op::Law { seat: index, part, advance, drift: None, energy, first: false },
            domain: seat.domain,
            rows: seat.rows.clone(),
            row_local: entry.shape == Shape::Row && !held && !energy,
            backend: entry.options.backend,
            every: if energy { 1 } else { every },
            operands,
            writes,
        };
        if self.key == Key::Unturned {
            hold_still(&mut placed, entry);
        }
        if !held {
            self.ops.push(placed);
            return;
        }
        let release = Placed { op: Op::Release { seat: index }, row_local: false, ..placed.clone() };
        let hold = Placed { op: Op::Hold { seat: index }, row_local: false, ..placed.clone() };
        self.ops.extend([release, placed, hold]);
    }

    /// Whether somebody looks at what a law gives: a turn, which most runs have no use for, is left out where nobody does.
    fn wants(&self, entry: &Entry, port: &Port, tie: &Tie) -> bool {
        let Pipeline { entries, registry, observed, .. } = self.pipeline;
        let (Role::Turn { .. }, Mode::Adds, Shape::Row, Tie::Quantity(id)) =
            (port.property.role, port.mode, entry.shape, tie)
        else {
            return true;
        };
        let reads =
            |seat: &Seat| crate::graph::inputs(&entries[seat.law].signature, seat, u64::MAX).any(|read| read == *id);
        self.key == Key::Unturned || observed.contains(id) || registry.seats.iter().any(reads)
    }

    /// What turns the momenta whose rates this law has just given.
    fn turned(&mut self, seat: usize) {
        let turnings = self.pipeline.turnings.iter().filter(|turning| turning.rater == seat);
        let Some(law) = self.ops.last().cloned() else { return };
        self.ops.extend(turnings.map(|turning| turned(&law, turning)));
    }

    fn axpy(&mut self, state: QuantityId) {
        let (to, from) = (|c| Operand::Quantity(state, c), |c| Operand::Rate(state, c));
        let op = self.whole(Op::Axpy { stage: self.stage }, state, to, Some(from));
        self.ops.push(op);
    }

    /// An operation on all rows of a quantity, alone in its pass: it writes some components, from others.
    fn whole(
        &self,
        op: Op,
        quantity: QuantityId,
        to: impl Fn(usize) -> Operand,
        from: Option<impl Fn(usize) -> Operand>,
    ) -> Placed {
        let known = &self.pipeline.registry.quantities[quantity];
        let width = known.info.kind.width();
        Placed {
            op,
            domain: known.domain,
            rows: None,
            row_local: false,
            backend: Backend::Auto,
            every: 1,
            operands: (0..width).map(to).chain(from.into_iter().flat_map(|from| (0..width).map(from))).collect(),
            writes: (0..2 * width).map(|k| k < width).collect(),
        }
    }
}
