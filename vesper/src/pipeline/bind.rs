//! From named places to pointers: a plan, tied to the layout of one state.

mod link;
mod pair;

pub(crate) use link::LinkPass;
pub(crate) use pair::PairPass;

use super::device::{DevicePass, Touch};
use super::group::{Group, GroupBuilder};
use super::operand::Operand;
use super::plan::{Op, Placed, Plan};
use super::vectors::lent_columns;
use super::{FusedChain, Listed, Machine, Pipeline};
use crate::backend::Kernel;
use crate::column::{Aligned, Storage};
use crate::integrate::Register;
use crate::property::Role;
use crate::real::Scalar;
use crate::registry::Backend;
use crate::state::State;

/// Where an array of numbers begins.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Base<P> {
    /// In an owned column.
    Owned(*mut P),
    /// In the client's memory of this number, whose address is known while the engine runs.
    Lent { memory: usize, component: usize },
}

/// Where the numbers of one component are.
#[derive(Clone, Debug)]
pub(crate) struct Located<P> {
    pub(crate) base: Base<P>,
    pub(crate) stride: usize,
    pub(crate) len: usize,
    /// The rows that have a number; `None` for all.
    pub(crate) subset: Option<Vec<u32>>,
}

/// Numbers that are brought to a scratch before a pass over rows, and back after it.
#[derive(Clone, Debug)]
pub(crate) struct Transfer<P> {
    pub(crate) base: Base<P>,
    pub(crate) stride: usize,
    /// Where each row of the pass is in the column; `None` where it is the row's own number.
    pub(crate) index: Option<Vec<u32>>,
    pub(crate) scratch: usize,
    pub(crate) save: bool,
}

impl<P: Scalar> Transfer<P> {
    fn at(&self, row: usize) -> usize {
        self.index.as_ref().map_or(row, |index| index[row] as usize) * self.stride
    }

    /// # Safety
    /// The rows exist, and `to` points to `rows.len()` numbers.
    pub(crate) unsafe fn load(&self, lent: &[*mut P], rows: core::ops::Range<usize>, to: *mut P) {
        let base = self.base.resolve(lent);
        for (k, row) in rows.enumerate() {
            // SAFETY: the caller promises the rows and the numbers.
            unsafe { *to.add(k) = *base.add(self.at(row)) };
        }
    }

    /// # Safety
    /// As for `load`, and nobody else touches the rows.
    pub(crate) unsafe fn store(&self, lent: &[*mut P], rows: core::ops::Range<usize>, from: *const P) {
        let base = self.base.resolve(lent);
        for (k, row) in rows.enumerate() {
            // SAFETY: the caller promises the rows and the numbers.
            unsafe { *base.add(self.at(row)) = *from.add(k) };
        }
    }
}

/// What is asked, ready to run.
pub(crate) struct Program<P: Scalar> {
    pub(crate) passes: Vec<BoundPass<P>>,
    /// Where the rates begin that laws write to; `None` where they cannot go to another vector, since not all of them are
    /// written in place.
    pub(crate) rates: Option<*mut P>,
}

/// A pass, and on which steps it runs.
pub(crate) struct BoundPass<P: Scalar> {
    pub(crate) every: u32,
    /// The number of the held shares that this pass fills, or empties first.
    pub(crate) fills: Option<usize>,
    pub(crate) pass: Pass<P>,
    /// The laws that run in it, for `explain`.
    pub(crate) laws: Vec<usize>,
    /// What it touches on the host, of what could be on a device.
    pub(crate) touches: Vec<Touch>,
    /// Why it is not on the device that it was asked for.
    pub(crate) refused: Option<String>,
}

/// One pass over memory.
pub(crate) enum Pass<P: Scalar> {
    Group(Group<P>),
    Pair(PairPass<P>),
    Link(LinkPass<P>),
    Column(ColumnPass<P>),
    /// On a graphics processor.
    #[cfg_attr(not(feature = "gpu"), expect(dead_code, reason = "without the feature there is none"))]
    Device(DevicePass<P>),
    /// `to += step * from`, by component: (to, from, numbers).
    Axpy {
        parts: Vec<(Located<P>, *mut P)>,
        stage: usize,
    },
    /// Numbers set to zero: (start, how many).
    Release(Vec<(*mut P, usize)>),
    /// Held shares added: (to, from).
    Hold(Vec<(Located<P>, *mut P)>),
    /// Numbers copied: (to, from, how many).
    Keep {
        parts: Vec<(*mut P, *mut P, usize)>,
        /// Of a switch, which is held while a step is taken.
        switch: bool,
    },
}

impl<P: Scalar> Pass<P> {
    /// The pass as the host runs it.
    pub(crate) fn on_host(&mut self) -> &mut Pass<P> {
        match self {
            Pass::Device(pass) => pass.host_mut(),
            own => own,
        }
    }
}

/// A port of a column law: base of every component, stride, rows.
pub(crate) type BoundPort<P> = ([Option<Base<P>>; 4], usize, usize);

/// A column law.
pub(crate) struct ColumnPass<P: Scalar> {
    pub(crate) law: usize,
    /// Base of every component, stride, rows; by port.
    pub(crate) ports: Vec<BoundPort<P>>,
    pub(crate) views: Vec<crate::law::PortView<P>>,
    pub(crate) link: Option<(*const u32, usize, usize)>,
    pub(crate) _defaults: Aligned<P>,
}

/// Rows from which on a pass over rows is worth the threads (measured: below, waking them costs more than it saves).
pub(super) const PARALLEL_ROWS: usize = 32_768;
/// Pairs from which on a pair law is worth the threads (measured: two share 768 rows in 0.8 to 0.95 of the time, 512 in 1.0 to 1.3).
const PARALLEL_PAIRS: usize = 1 << 19;

pub(super) fn threads(backend: Backend, work: usize, enough: usize, machine: &Machine) -> usize {
    match backend {
        // What stays on the host is not what was asked for, so it is as fast as it can be.
        Backend::Gpu if work >= enough => machine.threads,
        Backend::Cpu | Backend::Gpu => 1,
        Backend::Parallel => machine.threads,
        Backend::Auto | Backend::Fastest if work >= enough => machine.threads,
        Backend::Auto | Backend::Fastest => 1,
    }
}

/// Ties a plan to the state as it is laid out now.
pub(crate) fn program<P: Scalar>(
    plan: Plan,
    laws: &[Listed<P>],
    chains: &[FusedChain<P>],
    pipeline: &Pipeline<P>,
    state: &State<P>,
    machine: &Machine,
) -> Program<P> {
    let binder = Binder { plan: &plan, laws, chains, pipeline, state, machine };
    let mut in_place = true;
    let bound = |ops: &Vec<Placed>| {
        let pass = binder.pass(ops)?;
        let rates = ops.iter().flat_map(|op| &op.operands).filter(|operand| matches!(operand, Operand::Rate(..)));
        in_place &= rates.count() == if let Pass::Group(group) = &pass.pass { group.rates.len() } else { 0 };
        Some(pass)
    };
    let passes = plan.passes.iter().filter_map(bound).collect();
    Program { passes, rates: pipeline.vectors.vector(Register::Rates).filter(|_| in_place) }
}

pub(super) struct Binder<'a, P: Scalar> {
    pub(super) plan: &'a Plan,
    pub(super) laws: &'a [Listed<P>],
    pub(super) chains: &'a [FusedChain<P>],
    pub(super) pipeline: &'a Pipeline<P>,
    pub(super) state: &'a State<P>,
    pub(super) machine: &'a Machine,
}

impl<P: Scalar> Binder<'_, P> {
    fn pass(&self, ops: &[Placed]) -> Option<BoundPass<P>> {
        let first = ops.first()?;
        let laws = ops
            .iter()
            .filter_map(|op| match op.op {
                Op::Law { seat, .. } | Op::Hold { seat } | Op::Release { seat } => {
                    Some(self.pipeline.registry.seats[seat].law)
                }
                Op::Start { .. } | Op::Sample { .. } | Op::Axpy { .. } | Op::Keep => None,
            })
            .collect();
        let fills = match first.op {
            Op::Law { seat, .. } | Op::Release { seat } => {
                self.pipeline.vectors.held.iter().position(|(held, _)| *held == seat)
            }
            _ => None,
        };
        let pass = match first.op {
            Op::Release { seat } => Pass::Release(
                self.held(seat).map(|(_, numbers)| (numbers.pointer(), numbers.as_slice().len())).collect(),
            ),
            Op::Hold { seat } => Pass::Hold(self.hold(seat)),
            Op::Keep => {
                let (to, from) = first.operands.split_at(first.operands.len() / 2);
                let parts =
                    to.iter().zip(from).filter_map(|(to, from)| match (self.locate(*to)?, self.locate(*from)?) {
                        (Located { base: Base::Owned(to), len, .. }, Located { base: Base::Owned(from), .. }) => {
                            Some((to, from, len))
                        }
                        _ => None,
                    });
                let switch = matches!(first.operands.first(), Some(Operand::Previous(id, _))
                    if self.pipeline.registry.quantities[*id].info.role == Role::Switch);
                Pass::Keep { parts: parts.collect(), switch }
            }
            Op::Axpy { stage, .. } => {
                let (to, from) = first.operands.split_at(first.operands.len() / 2);
                let parts = to.iter().zip(from).filter_map(|(to, from)| {
                    let from = self.locate(*from)?;
                    let Base::Owned(from) = from.base else { return None };
                    Some((self.locate(*to)?, from))
                });
                Pass::Axpy { parts: parts.collect(), stage }
            }
            Op::Law { seat, energy, .. } => match &self.laws[self.pipeline.registry.seats[seat].law].compiled.kernel {
                Kernel::Row(_) => Pass::Group(self.group(ops)?),
                Kernel::Pair(kernel) => Pass::Pair(self.pair(first, kernel)?),
                Kernel::Link(kernel) => Pass::Link(self.link(first, energy, kernel.arity(), kernel.splits())?),
                Kernel::Column(_) if energy => return None,
                Kernel::Column(_) => Pass::Column(self.column(first)?),
            },
            Op::Start { .. } | Op::Sample { .. } => Pass::Group(self.group(ops)?),
        };
        let (pass, refused) = self.on_device(pass, ops);
        Some(BoundPass {
            every: first.every,
            fills,
            touches: if let Pass::Device(_) = pass { Vec::new() } else { self.touched(ops) },
            pass,
            laws,
            refused,
        })
    }

    fn group(&self, ops: &[Placed]) -> Option<Group<P>> {
        GroupBuilder::new(self, ops).filter(|group| group.rows > 0).map(|group| group.build(ops))
    }

    fn held(&self, seat: usize) -> impl Iterator<Item = (usize, &Aligned<P>)> {
        let held = self.pipeline.vectors.held.iter().find(|(held, _)| *held == seat);
        held.into_iter().flat_map(|(_, shares)| shares.iter().map(|(slot, numbers)| (*slot, numbers)))
    }

    fn hold(&self, seat: usize) -> Vec<(Located<P>, *mut P)> {
        let known = &self.pipeline.registry.seats[seat];
        let signature = &self.pipeline.entries[known.law].signature;
        let slots = signature.slots();
        self.held(seat)
            .filter_map(|(slot, numbers)| {
                let port = (0..signature.ports.len()).find(|&port| (slots[port]..slots[port + 1]).contains(&slot))?;
                let crate::registry::Tie::Quantity(id) = known.ties[port] else { return None };
                Some((self.locate(Operand::Quantity(id, slot - slots[port]))?, numbers.pointer()))
            })
            .collect()
    }

    /// Where an operand's numbers are, if they are in memory that outlives a pass.
    pub(super) fn locate(&self, operand: Operand) -> Option<Located<P>> {
        match operand {
            Operand::Quantity(id, component) | Operand::Constant(id, component) => {
                let known = &self.pipeline.registry.quantities[id];
                locate_column(self.state, known.domain, known.info.name, component)
            }
            Operand::Previous(id, component) => {
                let known = &self.pipeline.registry.quantities[id];
                let columns = &self.state.domains[known.domain].previous;
                let column = columns.iter().find(|column| column.info.name == known.info.name)?;
                let Storage::Split(components) = &column.storage else { return None };
                let base = Base::Owned(components.get(component)?.pointer());
                Some(Located { base, stride: 1, len: column.len(), subset: None })
            }
            Operand::Rate(id, component) => {
                let known = &self.pipeline.registry.quantities[id];
                let like = locate_column(self.state, known.domain, known.info.name, component)?;
                Some(Located { base: Base::Owned(self.pipeline.vectors.rate(id, component)?), stride: 1, ..like })
            }
            Operand::Held(seat, slot) => {
                let (_, numbers) = self.held(seat).find(|(held, _)| *held == slot)?;
                let len = numbers.as_slice().len();
                Some(Located { base: Base::Owned(numbers.pointer()), stride: 1, len, subset: None })
            }
            Operand::Turned(id, component) => {
                let known = &self.pipeline.registry.quantities[id];
                let like = locate_column(self.state, known.domain, known.info.name, component)?;
                Some(Located { base: Base::Owned(self.pipeline.vectors.turned(id, component)?), stride: 1, ..like })
            }
            Operand::Field(..) | Operand::Default(_) | Operand::Zero | Operand::Absent => None,
        }
    }

    /// How the rows of a pass reach a column: a transfer's base, stride and index.
    pub(super) fn transfer(located: &Located<P>, rows: Option<&[u32]>, scratch: usize, save: bool) -> Transfer<P> {
        let index = match (rows, &located.subset) {
            (None, _) => None,
            (Some(rows), None) => Some(rows.to_vec()),
            (Some(rows), Some(subset)) => Some(
                rows.iter()
                    .map(|row| u32::try_from(subset.binary_search(row).unwrap_or_default()).unwrap_or_default())
                    .collect(),
            ),
        };
        Transfer { base: located.base, stride: located.stride, index, scratch, save }
    }

    fn column(&self, op: &Placed) -> Option<ColumnPass<P>> {
        let Op::Law { seat, .. } = op.op else { return None };
        let seat = &self.pipeline.registry.seats[seat];
        let signature = &self.pipeline.entries[seat.law].signature;
        let defaults = defaults::<P>(&op.operands);
        let slots = signature.slots();
        let mut ports = Vec::new();
        for port in 0..signature.ports.len() {
            let mut bases = [None; 4];
            let (mut stride, mut rows) = (0, 0);
            for slot in slots[port]..slots[port + 1] {
                bases[slot - slots[port]] = match op.operands[slot] {
                    Operand::Default(_) => {
                        rows = 1;
                        Some(Base::Owned(defaults.pointer().wrapping_add(slot)))
                    }
                    Operand::Absent | Operand::Zero | Operand::Field(..) => None,
                    operand => {
                        let located = self.locate(operand)?;
                        (stride, rows) = (located.stride, located.len);
                        Some(located.base)
                    }
                };
            }
            ports.push((bases, stride, rows));
        }
        let link = signature.link.and_then(|link| {
            let domain = &self.state.domains[op.domain];
            let Storage::Link { rows, arity, .. } = &domain.columns[domain.find(link.name)?].storage else {
                return None;
            };
            Some((rows.as_ptr(), rows.len(), *arity))
        });
        let views = Vec::with_capacity(ports.len());
        Some(ColumnPass { law: seat.law, ports, views, link, _defaults: defaults })
    }
}

/// The constants that the scene does not give, at their slots. Not in a box, which may not be moved while others point
/// into it.
fn defaults<P: Scalar>(operands: &[Operand]) -> Aligned<P> {
    let mut defaults = Aligned::zeros(operands.len(), 0);
    for (number, operand) in defaults.as_mut_slice().iter_mut().zip(operands) {
        if let Operand::Default(value) = operand {
            *number = P::from_f64(*value);
        }
    }
    defaults
}

/// Where a component of a column of numbers is.
pub(crate) fn locate_column<P: Scalar>(
    state: &State<P>,
    domain: usize,
    property: &str,
    component: usize,
) -> Option<Located<P>> {
    let at = state.domains[domain].find(property)?;
    let column = &state.domains[domain].columns[at];
    let (base, stride) = match &column.storage {
        Storage::Split(components) => (Base::Owned(components.get(component)?.pointer()), 1),
        Storage::Lent(memory) => {
            let number = lent_columns(state).position(|place| place == (domain, at))?;
            (Base::Lent { memory: number, component }, memory.width())
        }
        Storage::Link { .. } => return None,
    };
    Some(Located { base, stride, len: column.len(), subset: column.subset.clone() })
}
