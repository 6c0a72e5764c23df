//! Ties a pass to a device. In: the operations of a pass, and where columns are. Out: a [`DevicePass`], or why there is none.
//! Never runs anything.

use super::ledger::{Touch, then};
use super::residency::{Residency, What, lock};
use super::{Call, Constant, DevicePass};
use crate::backend::gpu::{self, Access, Binding, Buffer, Device, Ends, Layout, Loop, Program, Slot, Store};
use crate::column::Storage;
use crate::law::{Mode, Shape};
use crate::pipeline::bind::{Binder, Located, Pass};
use crate::pipeline::merge::NOTHING;
use crate::pipeline::operand::Operand;
use crate::pipeline::plan::{Key, Op, Placed};
use crate::property::{Property, Time};
use crate::real::{Scalar, Vector};
use crate::registry::{Backend, QuantityId, Tie};
use std::sync::Arc;

impl<P: Scalar> Binder<'_, P> {
    /// The pass on the device, where its laws are to run there; with the reason where it stays on the host.
    pub(in crate::pipeline) fn on_device(&self, host: Pass<P>, ops: &[Placed]) -> (Pass<P>, Option<String>) {
        let asked = ops.iter().any(|op| op.backend == Backend::Gpu && matches!(op.op, Op::Law { .. }));
        if !asked || self.plan.key == Key::Energy {
            return (host, None);
        }
        let shared = match (&self.pipeline.residency, &self.machine.device) {
            (Some(shared), _) => shared,
            (None, Some(Err(reason))) => return (host, Some(reason.clone())),
            (None, _) => return (host, Some("no device was opened".to_owned())),
        };
        let on_host = self.touched(ops);
        let mut residency = lock(shared);
        let device = Arc::clone(&residency.device);
        let (residency, calls) = (&mut *residency, Vec::new());
        let mut builder =
            Builder { binder: self, device, residency, touches: Vec::new(), constants: Vec::new(), calls };
        match builder.build(ops) {
            Ok(()) => {
                let Builder { touches, constants, calls, .. } = builder;
                (Pass::Device(DevicePass { host: Box::new(host), on_host, touches, constants, calls }), None)
            }
            Err(reason) => (host, Some(reason)),
        }
    }

    /// What the host's pass touches, of what could be on a device.
    pub(in crate::pipeline) fn touched(&self, ops: &[Placed]) -> Vec<Touch> {
        let Some(shared) = &self.pipeline.residency else { return Vec::new() };
        let mut residency = lock(shared);
        let mut touches = Vec::new();
        let mut touch = |operand: Operand, access| {
            let constant = if let Operand::Constant(id, c) = operand { Some((What::Quantity(id), c)) } else { None };
            let Some((what, _)) = what(operand).or(constant) else { return };
            // What lives in the scratch of a block is nowhere; what some rows only have stays on the host.
            let Some(components) = self.components(what) else { return };
            let column = residency.column(what, || components);
            then(&mut touches, Touch { column, access });
        };
        for op in ops {
            let signature = match op.op {
                Op::Law { seat, .. } | Op::Release { seat } | Op::Hold { seat } => {
                    let known = &self.pipeline.registry.seats[seat];
                    Some((known, &self.pipeline.entries[known.law]))
                }
                Op::Start { .. } | Op::Sample { .. } | Op::Axpy { .. } | Op::Keep => None,
            };
            let ports = signature.iter().flat_map(|(seat, entry)| entry.signature.ports.iter().zip(&seat.ties));
            let slots = ports.flat_map(|(port, tie)| core::iter::repeat_n((port, tie), port.property.kind.width()));
            let slots = slots.map(Some).chain(core::iter::repeat(None));
            for ((operand, writes), slot) in op.operands.iter().zip(&op.writes).zip(slots) {
                match op.op {
                    Op::Release { .. } if matches!(operand, Operand::Held(..)) => touch(*operand, Access::Write),
                    Op::Hold { .. } if matches!(operand, Operand::Held(..)) => {
                        touch(*operand, Access::Read);
                        if let Some((_, Tie::Quantity(id))) = slot {
                            touch(Operand::Quantity(*id, 0), Access::Update);
                        }
                    }
                    Op::Release { .. } | Op::Hold { .. } => {}
                    _ if !writes => touch(*operand, Access::Read),
                    Op::Start { .. } | Op::Keep => touch(*operand, Access::Write),
                    Op::Axpy { .. } | Op::Sample { .. } => touch(*operand, Access::Update),
                    Op::Law { advance, first, .. } => {
                        let by_row = signature.is_some_and(|(_, entry)| entry.shape == Shape::Row);
                        let whole = op.rows.is_none()
                            && match slot.map(|(port, _)| port.mode) {
                                Some(Mode::Sets) => by_row,
                                Some(Mode::Rates) => by_row && advance.is_none(),
                                Some(Mode::Adds) => first,
                                _ => false,
                            };
                        touch(*operand, if whole { Access::Write } else { Access::Update });
                    }
                }
            }
        }
        touches
    }

    /// Where the components of a column are; `None` where it is nowhere, or only some rows have it.
    fn components(&self, what: What) -> Option<Vec<Located<P>>> {
        let width = match what {
            What::Quantity(id) | What::Rate(id) | What::Turned(id) | What::Previous(id) | What::Work(_, id) => {
                self.pipeline.registry.quantities[id].info.kind.width()
            }
            What::Held(..) => 1,
        };
        let component = |component| {
            self.locate(match what {
                What::Quantity(id) => Operand::Quantity(id, component),
                What::Rate(id) => Operand::Rate(id, component),
                What::Turned(id) => Operand::Turned(id, component),
                What::Previous(id) => Operand::Previous(id, component),
                What::Held(seat, slot) => Operand::Held(seat, slot),
                What::Work(..) => Operand::Absent,
            })
        };
        let components: Option<Vec<Located<P>>> = (0..width).map(component).collect();
        components.filter(|components| components.iter().all(|located| located.subset.is_none()))
    }
}

/// The column of an operand, and the component.
fn what(operand: Operand) -> Option<(What, usize)> {
    match operand {
        Operand::Quantity(id, component) => Some((What::Quantity(id), component)),
        Operand::Rate(id, component) => Some((What::Rate(id), component)),
        Operand::Turned(id, component) => Some((What::Turned(id), component)),
        Operand::Previous(id, component) => Some((What::Previous(id), component)),
        Operand::Held(seat, slot) => Some((What::Held(seat, slot), 0)),
        Operand::Zero | Operand::Default(_) | Operand::Constant(..) | Operand::Field(..) | Operand::Absent => None,
    }
}

/// Slots, tied to columns.
struct Tied<P> {
    layout: Layout,
    /// By binding.
    columns: Vec<usize>,
    constants: Vec<(usize, Constant<P>)>,
    /// Which slots are there, a bit each.
    there: u64,
}

/// A pass while it is being tied to a device.
struct Builder<'a, P: Scalar> {
    binder: &'a Binder<'a, P>,
    device: Arc<Device>,
    residency: &'a mut Residency<P>,
    touches: Vec<Touch>,
    constants: Vec<Touch>,
    calls: Vec<Call<P>>,
}

impl<P: Scalar> Builder<'_, P> {
    fn build(&mut self, ops: &[Placed]) -> Result<(), String> {
        for op in ops {
            match op.op {
                Op::Law { seat, advance, first, .. } => self.law(op, seat, advance, first)?,
                // A field that is the same everywhere is a constant of its laws.
                Op::Sample { field } if self.uniform(field).is_some() => {}
                Op::Sample { field } => {
                    let name = self.binder.state.fields[field].0.name;
                    return Err(format!("field {name} is sampled at the place of each row, which the host does"));
                }
                Op::Start { from, .. } => self.start(op, from)?,
                Op::Axpy { .. } | Op::Release { .. } | Op::Hold { .. } | Op::Keep => {
                    return Err("it is no law".to_owned());
                }
            }
        }
        Ok(())
    }

    fn uniform(&self, field: usize) -> Option<[P; 3]> {
        let value = self.binder.state.fields[field].1.uniform()?;
        Some([value.x(), value.y(), value.z()])
    }

    /// A sum begins from a number, or from another quantity.
    fn start(&mut self, op: &Placed, from: Option<QuantityId>) -> Result<(), String> {
        let begins = if self.binder.plan.key == Key::Observe { 0.0 } else { NOTHING };
        let width = if from.is_some() { op.operands.len() / 2 } else { op.operands.len() };
        let operands = (0..2 * width).map(|slot| op.operands.get(slot).copied().unwrap_or(Operand::Default(begins)));
        let tied =
            self.tie(operands.enumerate().map(|(slot, operand)| (operand, (slot < width).then_some(Store::Set))))?;
        let program = gpu::copied::<P>(width, tied.layout.clone()).map_err(|error| error.to_string())?;
        self.push(None, program, tied, Vec::new(), self.binder.state.domains[op.domain].rows, None)
    }

    fn law(&mut self, op: &Placed, seat: usize, advance: Option<usize>, first: bool) -> Result<(), String> {
        if op.rows.is_some() {
            return Err("it runs on some rows only".to_owned());
        }
        let binder = self.binder;
        let known = &binder.pipeline.registry.seats[seat];
        let compiled = &binder.laws[known.law].compiled;
        if binder.pipeline.entries[known.law].options.far_field.is_some() {
            return Err("far fields are the host's".to_owned());
        }
        if binder.pipeline.vectors.rests.is_some() && binder.pipeline.takes_differences(known.law) {
            return Err("what rounding took from the state is kept on the host".to_owned());
        }
        let signature = &compiled.signature;
        let store = |mode| match mode {
            Mode::Rates if advance.is_some() => Store::Advance,
            Mode::Adds if !first => Store::Add,
            _ => Store::Set,
        };
        let modes = signature.ports.iter().flat_map(|port| core::iter::repeat_n(port.mode, port.property.kind.width()));
        let slots = op.operands.iter().zip(&op.writes).zip(modes);
        let tied = self.tie(slots.map(|((operand, writes), mode)| (*operand, writes.then(|| store(mode)))))?;
        let program = compiled
            .program_in(tied.layout.clone(), tied.there, binder.machine.estimates)
            .map_err(|error| error.to_string())?;
        let (lists, rows) = match program.shape {
            Loop::Rows | Loop::Pairs => (Vec::new(), binder.state.domains[op.domain].rows),
            Loop::Links(_) => {
                let target = known.target.ok_or("its links end nowhere")?;
                let rows = binder.state.domains[target].rows;
                let ends = self.ends(op, signature.link.map(|link| link.name)).ok_or("its links are nowhere")?;
                (Ends::of(ends.to_vec(), rows).lists().map(|list| self.list(list)).into(), rows)
            }
        };
        self.push(Some(known.law), program, tied, lists, rows, advance)
    }

    /// Ties operands to columns, by slot, each with what becomes of a result.
    fn tie(&mut self, slots: impl Iterator<Item = (Operand, Option<Store>)>) -> Result<Tied<P>, String> {
        let (mut layout, mut columns, mut constants) = (Layout::default(), Vec::new(), Vec::new());
        let mut there = u64::MAX;
        for (slot, (operand, store)) in slots.enumerate() {
            let constant = match operand {
                Operand::Absent => {
                    there &= !(1 << slot);
                    layout.slots.push(Slot::Absent);
                    continue;
                }
                Operand::Zero => Some(Constant::Number(P::from_f64(0.0))),
                Operand::Default(number) => Some(Constant::Number(P::from_f64(number))),
                Operand::Field(field, component) => {
                    let value = self.uniform(field).ok_or("a field is sampled at the place of each row")?;
                    Some(Constant::Number(value[component]))
                }
                // It comes with the call, which is made before the pass runs.
                Operand::Constant(id, _) if self.sets(id) => {
                    return Err("it reads a constant that a law of the same pass sets".to_owned());
                }
                Operand::Constant(id, _) => {
                    let located = self.binder.locate(operand).ok_or("a constant is nowhere")?;
                    let column = self.column(What::Quantity(id))?;
                    then(&mut self.constants, Touch { column, access: Access::Read });
                    Some(Constant::At(located.base))
                }
                Operand::Quantity(..)
                | Operand::Rate(..)
                | Operand::Turned(..)
                | Operand::Previous(..)
                | Operand::Held(..) => None,
            };
            if let Some(constant) = constant {
                constants.push((slot, constant));
                layout.slots.push(Slot::Constant);
                continue;
            }
            let (what, component) = what(operand).ok_or("a column is nowhere")?;
            if let What::Quantity(id) = what
                && self.binder.pipeline.registry.quantities[id].domain == 0
                && self.binder.pipeline.registry.quantities[id].info.name == Time::NAME
            {
                return Err("it looks at the time as at a row's, and the clock is the host's".to_owned());
            }
            let access = match store {
                None => Access::Read,
                Some(Store::Set) => Access::Write,
                Some(Store::Add | Store::Advance) => Access::Update,
            };
            let column = self.column(what)?;
            let binding = columns.iter().position(|known| *known == column).unwrap_or_else(|| {
                columns.push(column);
                layout.bindings.push(Binding::new(&self.name(what), access, columns.len() - 1));
                columns.len() - 1
            });
            let known = &mut layout.bindings[binding].access;
            if *known != access {
                *known = Access::Update;
            }
            layout.slots.push(match store {
                None => Slot::Input { binding, component },
                Some(store) => Slot::Output { binding, component, store },
            });
        }
        Ok(Tied { layout, columns, constants, there })
    }

    /// Adds a program to the pass.
    fn push(
        &mut self,
        law: Option<usize>,
        program: Program,
        tied: Tied<P>,
        lists: Vec<Buffer>,
        rows: usize,
        advance: Option<usize>,
    ) -> Result<(), String> {
        let rows = u32::try_from(rows).map_err(|_| "there are more rows than devices count")?;
        let prepared = self.device.prepare(program).map_err(|fault| fault.to_string())?;
        let Tied { columns, constants, .. } = tied;
        for (&column, binding) in columns.iter().zip(&prepared.program.layout.bindings) {
            then(&mut self.touches, Touch { column, access: binding.access });
            self.residency.buffer(column).map_err(|fault| fault.to_string())?;
        }
        let rooms = columns.iter().filter_map(|column| self.residency.room(*column));
        let buffers: Vec<&Buffer> = rooms.chain(&lists).collect();
        let group = self.device.bind(&prepared, &buffers);
        let strides = columns.iter().map(|column| self.residency.rows(*column) as u32).collect();
        self.calls.push(Call { law, prepared, group, strides, _lists: lists, constants, rows, advance });
        Ok(())
    }

    /// Whether the pass sets a quantity.
    fn sets(&self, id: QuantityId) -> bool {
        self.touches
            .iter()
            .any(|touch| touch.access != Access::Read && self.residency.what(touch.column) == What::Quantity(id))
    }

    /// The rows that the links of an operation end at.
    fn ends(&self, op: &Placed, link: Option<&str>) -> Option<&[u32]> {
        let domain = &self.binder.state.domains[op.domain];
        match &domain.columns[domain.find(link?)?].storage {
            Storage::Link { rows, .. } => Some(rows),
            _ => None,
        }
    }

    fn list(&self, numbers: &[u32]) -> Buffer {
        let buffer = self.device.buffer(size_of_val(numbers) as u64);
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.device.write(&buffer, 0, &bytes);
        buffer
    }

    /// The name of a column in a program.
    fn name(&self, what: What) -> String {
        let of = |id: QuantityId, kind: &str| {
            let name = self.binder.pipeline.registry.quantities[id].info.name;
            format!("{name}_{kind}")
        };
        match what {
            What::Quantity(id) => of(id, "now"),
            What::Rate(id) => of(id, "rate"),
            What::Turned(id) => of(id, "turned"),
            What::Previous(id) => of(id, "before"),
            What::Held(_, slot) => format!("held_{slot}"),
            What::Work(number, id) => of(id, &format!("work_{number}")),
        }
    }

    /// The number of a column, which is made if it is not known.
    fn column(&mut self, what: What) -> Result<usize, String> {
        if let Some(known) = self.residency.find(what) {
            return Ok(known);
        }
        let components = self.binder.components(what).ok_or("it reads what some rows only have")?;
        Ok(self.residency.column(what, || components))
    }
}
