//! A law's kernel on a device beside the one on the host.
//!
//! In: a law. Out: how far the two are apart, on rows of numbers that a fixed sequence gives. Never: an engine.

use super::device::{Device, DeviceFault};
use super::layout::{Access, Slot, Store};
use super::links::Ends;
use super::stream::Work;
use super::wgsl::{Loop, Program, Word};
use super::{NoKernel, Numbers, OnDevice};
use crate::backend::{Compiled, Kernel, LinkCall, Links, PairCall, RowCall, Strided};
use crate::column::Aligned;
use crate::law::{Mode, Part, Place};
use crate::real::{Isa, Scalar};

/// How far a law's results on a device are from those on the host.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Numbers that were compared.
    pub numbers: usize,
    /// Those that have the same bits.
    pub same: usize,
    /// Those that are 0 on the host: they tell nothing.
    pub zeros: usize,
    /// The largest difference, in parts of the largest number of the same component on the host; infinite where one is NaN and the other
    /// is not.
    pub largest: f64,
}

/// Why a law was not compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotCompared {
    /// Devices cannot run it.
    #[error(transparent)]
    NoKernel(#[from] NoKernel),
    /// This one cannot.
    #[error(transparent)]
    Device(#[from] DeviceFault),
}

/// Runs a law once over so many rows, on the device and on the host, one row after the other: each pair from both sides, all optional
/// values there, the numbers between 0.5 and 1.5 with any sign in vectors.
///
/// # Errors
/// The law has no kernel for devices, or the device cannot run it.
pub fn compare<P: Scalar>(device: &Device, law: &Compiled<P>, rows: usize) -> Result<Comparison, NotCompared> {
    compare_program(device, law, law.program(super::ALL)?, rows)
}

/// The same with a program that may be another than the law's.
pub(super) fn compare_program<P: Scalar>(
    device: &Device,
    law: &Compiled<P>,
    program: Program,
    rows: usize,
) -> Result<Comparison, NotCompared> {
    let prepared = device.prepare(program)?;
    let program = &prepared.program;
    let ends = match program.shape {
        Loop::Links(arity) => Ends::of((0..rows * arity).map(|at| end(at, arity, rows)).collect(), rows),
        Loop::Rows | Loop::Pairs => Ends::default(),
    };
    let mut given = given(law, rows);
    // Sums begin at half of what will be added to them: whatever is wrong with either shows.
    let mut shares: Vec<Aligned<P>> = given.iter().map(copy).collect();
    run_on_host(law, &mut shares, &ends, rows);
    for (slot, place) in program.layout.slots.iter().enumerate() {
        if matches!(place, Slot::Output { store: Store::Add, .. }) {
            for (to, share) in given[slot].as_mut_slice().iter_mut().zip(shares[slot].as_slice()) {
                *to = P::from_f64(0.5) * *share;
            }
        }
    }
    let mut expected: Vec<Aligned<P>> = given.iter().map(copy).collect();
    run_on_host(law, &mut expected, &ends, rows);

    let bindings = program.layout.bindings.len();
    let columns: Vec<Vec<usize>> = (0..bindings).map(|binding| slots_of(program, binding)).collect();
    let mut buffers: Vec<wgpu::Buffer> = Vec::new();
    for slots in &columns {
        // What is read and amended is one buffer, and two slots have the same numbers.
        let numbers = slots.iter().flat_map(|slot| given[*slot].as_slice().iter().copied());
        buffers.push(filled(device, &bytes(numbers)));
    }
    for list in ends.lists().iter().take(program.shape.lists().len()) {
        buffers.push(filled(device, &list.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>()));
    }
    let tied: Vec<&wgpu::Buffer> = buffers.iter().collect();
    let group = device.bind(&prepared, &tied);
    let work = Work { prepared: &prepared, group: &group, call: call(program, &given, rows), rows: rows as u32 };
    let back: Vec<(&wgpu::Buffer, usize)> =
        columns.iter().zip(&buffers).map(|(slots, buffer)| (buffer, slots.len() * rows * size_of::<P>())).collect();
    let mut found: Vec<P> = Vec::new();
    device.run([work].into_iter(), &back, |bytes| found = numbers(bytes))?;
    let mut comparison = Comparison { numbers: 0, same: 0, zeros: 0, largest: 0.0 };
    let mut found = found.chunks_exact(rows.max(1));
    for (slots, binding) in columns.iter().zip(&program.layout.bindings) {
        for (slot, found) in slots.iter().zip(found.by_ref()) {
            if binding.access == Access::Read {
                continue;
            }
            let output = |slot: &usize| matches!(program.layout.slots[*slot], Slot::Output { .. });
            let written =
                (0..program.layout.slots.len()).filter(output).find(|written| same_place(program, *written, *slot));
            comparison.add(found, expected[written.unwrap_or(*slot)].as_slice());
        }
    }
    Ok(comparison)
}

impl Comparison {
    fn add<P: Scalar>(&mut self, found: &[P], expected: &[P]) {
        let most = expected.iter().fold(0.0, |most, number| f64::max(most, number.to_f64().abs()));
        for (found, expected) in found.iter().zip(expected).map(|(a, b)| (a.to_f64(), b.to_f64())) {
            self.numbers += 1;
            self.zeros += usize::from(expected == 0.0);
            if found == expected || found.is_nan() && expected.is_nan() {
                self.same += usize::from(found.is_nan() || found.to_bits() == expected.to_bits());
                continue;
            }
            let apart = (found - expected).abs() / most;
            self.largest = self.largest.max(if apart.is_nan() { f64::INFINITY } else { apart });
        }
    }
}

/// Numbers of a fixed sequence, from 0 to 1 (splitmix64: Steele, Lea, Flood, OOPSLA 2014).
fn number(at: usize) -> f64 {
    let mut bits = (at as u64).wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ bits >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

/// The row that a link ends at, all different where there are enough.
fn end(at: usize, arity: usize, rows: usize) -> u32 {
    let (link, end) = (at / arity, at % arity);
    ((link + end * (1 + link % 5)) % rows) as u32
}

/// A number for every row of every component, and one for constants; 0 where sums begin.
fn given<P: Scalar>(law: &Compiled<P>, rows: usize) -> Vec<Aligned<P>> {
    let mut columns: Vec<Aligned<P>> = Vec::new();
    let mut of_property: Vec<(&str, Place, usize)> = Vec::new();
    for port in law.signature.ports {
        let first = columns.len();
        // What is read and amended is one column.
        let known = of_property.iter().find(|(name, place, _)| *name == port.property.name && *place == port.place);
        let from = known.map_or(first, |(_, _, first)| *first);
        of_property.push((port.property.name, port.place, first));
        let width = port.property.kind.width();
        for component in 0..width {
            let count = if port.place == Place::Scene { 1 } else { rows };
            let mut column = Aligned::zeros(count, columns.len());
            if port.mode == Mode::Adds {
                columns.push(column);
                continue;
            }
            for (row, to) in column.as_mut_slice().iter_mut().enumerate() {
                let at = 2 * ((from + component) * rows.max(1) + row);
                let sign = if width > 1 && number(at + 1) < 0.5 { -1.0 } else { 1.0 };
                *to = P::from_f64(sign * (0.5 + number(at)));
            }
            columns.push(column);
        }
    }
    columns
}

fn copy<P: Scalar>(column: &Aligned<P>) -> Aligned<P> {
    let mut own = Aligned::zeros(column.as_slice().len(), 0);
    own.as_mut_slice().copy_from_slice(column.as_slice());
    own
}

fn run_on_host<P: Scalar>(law: &Compiled<P>, columns: &mut [Aligned<P>], ends: &Ends, rows: usize) {
    let slots: Vec<*mut P> = columns.iter().map(Aligned::pointer).collect();
    // Each slot has a column of its own with a number for each row, or one for a constant, and the room that columns have; nobody else
    // knows them.
    match &law.kernel {
        Kernel::Row(kernel) => {
            let (slots, part, ahead) = (slots[..].into(), Part::All, Default::default());
            let (advance, drift) = (None.into(), None.into());
            let call = RowCall { slots, uniform: 0, rows, part, advance, drift, first: false, ahead };
            // SAFETY: as above.
            unsafe { kernel.run(Isa::Scalar, &call) };
        }
        Kernel::Pair(kernel) => {
            let (slots, square) = (&slots[..], P::from_f64(f64::INFINITY));
            let call =
                PairCall { slots, rests: &[], rows: 0..rows, others: 0..rows, first: false, estimates: false, square };
            // SAFETY: as above.
            unsafe { kernel.run(Isa::Scalar, &call) };
        }
        Kernel::Link(kernel) => {
            let slots: Vec<Strided<P>> = slots.iter().map(|&start| Strided { start, stride: 1 }).collect();
            let call = LinkCall { slots: &slots, ends: &ends.rows, links: Links::First(rows), rows: 0..u32::MAX };
            // SAFETY: as above; ends are rows.
            unsafe { kernel.run(Isa::Scalar, &call) };
        }
        Kernel::Column(_) => {}
    }
}

/// Whether two slots are the same component of one buffer.
fn same_place(program: &Program, a: usize, b: usize) -> bool {
    let place = |slot: usize| match program.layout.slots[slot] {
        Slot::Input { binding, component } | Slot::Output { binding, component, .. } => Some((binding, component)),
        Slot::Absent | Slot::Constant => None,
    };
    place(a) == place(b)
}

/// The slots of a buffer's components, in order; of those that two slots have, the first.
fn slots_of(program: &Program, wanted: usize) -> Vec<usize> {
    let mut slots: Vec<usize> = Vec::new();
    for (slot, place) in program.layout.slots.iter().enumerate() {
        if let Slot::Input { binding, component } | Slot::Output { binding, component, .. } = *place
            && binding == wanted
            && component == slots.len()
        {
            slots.push(slot);
        }
    }
    slots
}

/// The bytes that come with a call.
fn call<P: Scalar>(program: &Program, given: &[Aligned<P>], rows: usize) -> Vec<u8> {
    let mut call = Vec::new();
    for word in &program.call {
        match *word {
            Word::Constant(slot) => call.extend(bytes(given[slot].as_slice().iter().copied())),
            Word::Step => call.extend(bytes([P::from_f64(0.0)].into_iter())),
            Word::Rows | Word::Stride(_) => call.extend((rows as u32).to_le_bytes()),
        }
    }
    call.resize(program.call_bytes() as usize, 0);
    call
}

fn filled(device: &Device, bytes: &[u8]) -> wgpu::Buffer {
    let buffer = device.buffer(bytes.len() as u64);
    device.write(&buffer, 0, bytes);
    buffer
}

/// Numbers as the device has them.
fn bytes<P: Scalar>(numbers: impl Iterator<Item = P>) -> Vec<u8> {
    let mut bytes = Vec::new();
    for number in numbers {
        match P::choose::<OnDevice>(|| Some(Numbers::F32), || Some(Numbers::F64), || None) {
            Some(Numbers::F32) => bytes.extend((number.to_f64() as f32).to_le_bytes()),
            _ => bytes.extend(number.to_f64().to_le_bytes()),
        }
    }
    bytes
}

fn numbers<P: Scalar>(bytes: &[u8]) -> Vec<P> {
    let four = bytes.chunks_exact(4).map(|bytes| f64::from(f32::from_le_bytes(bytes.try_into().unwrap_or_default())));
    let eight = bytes.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap_or_default()));
    match P::choose::<OnDevice>(|| Some(Numbers::F32), || Some(Numbers::F64), || None) {
        Some(Numbers::F32) => four.map(P::from_f64).collect(),
        _ => eight.map(P::from_f64).collect(),
    }
}
