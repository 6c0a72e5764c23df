//! Ties a pass to a device. In: the operations of a pass, and where columns are. Out: a [`DevicePass`], or why there is none.
//! Never runs anything.

use super::{Call, Column, Constant, DevicePass, What};
use crate::backend::gpu::{self, Access, Binding, Buffer, Device, Ends, Layout, Loop, Program, Slot, Store};
use crate::column::Storage;
use crate::law::Mode;
use crate::pipeline::bind::{Binder, Located, Pass};
use crate::pipeline::merge::NOTHING;
use crate::pipeline::operand::Operand;
use crate::pipeline::plan::{Key, Op, Placed};
use crate::real::{Scalar, Vector};
use crate::registry::{Backend, QuantityId};
use std::sync::{Arc, PoisonError};

impl<P: Scalar> Binder<'_, P> {
    /// The pass on the device, where its laws are to run there; with the reason where it stays on the host.
    pub(in crate::pipeline) fn on_device(&self, host: Pass<P>, ops: &[Placed]) -> (Pass<P>, Option<String>) {
        let asked = ops.iter().any(|op| op.backend == Backend::Gpu && matches!(op.op, Op::Law { .. }));
        if !asked || self.plan.key == Key::Energy {
            return (host, None);
        }
        let builder = match &self.machine.device {
            Some(Ok(device)) => Builder { binder: self, device, columns: Vec::new(), calls: Vec::new() },
            Some(Err(reason)) => return (host, Some(reason.clone())),
            None => return (host, Some("no device was opened".to_owned())),
        };
        match builder.build(ops) {
            Ok((device, columns, calls)) => {
                (Pass::Device(DevicePass { host: Box::new(host), device, columns, calls }), None)
            }
            Err(reason) => (host, Some(reason)),
        }
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
    device: &'a Arc<Device>,
    columns: Vec<Column<P>>,
    calls: Vec<Call<P>>,
}

type Built<P> = (Arc<Device>, Vec<Column<P>>, Vec<Call<P>>);

impl<P: Scalar> Builder<'_, P> {
    fn build(mut self, ops: &[Placed]) -> Result<Built<P>, String> {
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
        Ok((self.device.clone(), self.columns, self.calls))
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
                Operand::Constant(id, _) if self.columns.iter().any(|c| c.taken && c.what == What::Quantity(id)) => {
                    return Err("it reads a constant that a law of the same pass sets".to_owned());
                }
                Operand::Constant(..) => {
                    let located = self.binder.locate(operand).ok_or("a constant is nowhere")?;
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
            let access = match store {
                None => Access::Read,
                Some(Store::Set) => Access::Write,
                Some(Store::Add | Store::Advance) => Access::Update,
            };
            let column = self.column(what, operand)?;
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
        // Nothing comes back that no law has written, and nothing is brought that a law of the pass wrote before.
        for (&column, binding) in columns.iter().zip(&prepared.program.layout.bindings) {
            let column = &mut self.columns[column];
            column.brought |= binding.access != Access::Write && !column.taken;
            column.taken |= binding.access != Access::Read;
        }
        let buffers: Vec<&Buffer> = columns.iter().map(|column| &self.columns[*column].buffer).chain(&lists).collect();
        let group = self.device.bind(&prepared, &buffers);
        self.calls.push(Call { law, prepared, group, columns, _lists: lists, constants, rows, advance });
        Ok(())
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
        }
    }

    /// The number of a column, which is made if it is not known.
    fn column(&mut self, what: What, operand: Operand) -> Result<usize, String> {
        if let Some(known) = self.columns.iter().position(|column| column.what == what) {
            return Ok(known);
        }
        let width = match what {
            What::Quantity(id) | What::Rate(id) | What::Turned(id) | What::Previous(id) => {
                self.binder.pipeline.registry.quantities[id].info.kind.width()
            }
            What::Held(..) => 1,
        };
        let component = |component| match what {
            What::Quantity(id) => Operand::Quantity(id, component),
            What::Rate(id) => Operand::Rate(id, component),
            What::Turned(id) => Operand::Turned(id, component),
            What::Previous(id) => Operand::Previous(id, component),
            What::Held(..) => operand,
        };
        let components: Option<Vec<Located<P>>> = (0..width).map(|c| self.binder.locate(component(c))).collect();
        let components = components.ok_or("a column is nowhere")?;
        if components.iter().any(|located| located.subset.is_some()) {
            return Err("it reads what some rows only have".to_owned());
        }
        let buffer = self.buffer(what, &components)?;
        self.columns.push(Column { what, components, buffer, brought: false, taken: false });
        Ok(self.columns.len() - 1)
    }
}

impl<P: Scalar> Builder<'_, P> {
    /// Room for a column: all passes of a pipeline have the same.
    fn buffer(&self, what: What, components: &[Located<P>]) -> Result<Buffer, String> {
        let mut buffers = self.binder.pipeline.buffers.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, known)) = buffers.iter().find(|(known, _)| *known == what) {
            return Ok(known.clone());
        }
        let bytes = components.iter().map(|located| located.len * size_of::<P>()).sum::<usize>() as u64;
        let buffer = self.device.room(bytes).map_err(|fault| fault.to_string())?;
        buffers.push((what, buffer.clone()));
        Ok(buffer)
    }
}
