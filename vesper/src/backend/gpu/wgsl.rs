//! The text of a program.
//!
//! In: a recorded body, and where its numbers are. Out: WGSL of one entry point, `main`, with a loop of the law's shape around the body.
//! Never: a device.
//!
//! Every operation is a `let` of its own, in the order of the body. Drivers may still fuse a product with a sum, or draw a factor out of
//! one, and then round elsewhere: WGSL has no word against it. A `let` is no
//! constant expression either: nothing is computed when the text is read, where a division by 0 would be an error. What depends on one
//! row of a pair alone stands before the loop over the other.
//!
//! The numbers that come with a call are an `immediate`: constants of the scene, the step, then the rows and the strides of the buffers,
//! in the order of [`Program::call`].

use super::layout::{Access, Layout, Slot, Store};
use super::trace::{ResultOf, Trace};
use super::traced::{At, Binary, Input, Node, Of, Unary};
use core::fmt::Write;

/// Invocations of one workgroup.
pub(crate) const GROUP: u32 = 64;
/// Workgroups in the first dimension, at most: what every device has.
pub(crate) const ACROSS: u32 = 65_535;

/// The numbers of a text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Numbers {
    F32,
    F64,
}

impl Numbers {
    fn name(self) -> &'static str {
        match self {
            Numbers::F32 => "f32",
            Numbers::F64 => "f64",
        }
    }

    /// Bytes of a number.
    pub(crate) fn bytes(self) -> u32 {
        match self {
            Numbers::F32 => 4,
            Numbers::F64 => 8,
        }
    }
}

/// The loop around a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Loop {
    /// One invocation for each row.
    Rows,
    /// One invocation for each row, which goes through all others, tile by tile.
    Pairs,
    /// One invocation for each row that links end at, which goes through these, in their order. So many ends has a link.
    Links(usize),
}

/// A number that comes with a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Word {
    /// The constant of this slot.
    Constant(usize),
    /// The step by which rates advance states.
    Step,
    /// How many rows there are.
    Rows,
    /// How far apart the components of this binding are.
    Stride(usize),
}

/// A program, as text.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    pub(crate) text: String,
    pub(crate) layout: Layout,
    pub(crate) precision: Numbers,
    pub(crate) shape: Loop,
    /// What comes with a call, in order.
    pub(crate) call: Vec<Word>,
}

impl Program {
    /// Bytes that come with a call.
    pub(crate) fn call_bytes(&self) -> u32 {
        let size = |word: &Word| match word {
            Word::Constant(_) | Word::Step => self.precision.bytes(),
            Word::Rows | Word::Stride(_) => 4,
        };
        self.call.iter().map(size).sum::<u32>().next_multiple_of(self.precision.bytes())
    }

    /// Whether the buffer of this number, of the layout's or behind them, is only read.
    pub(crate) fn is_read_only(&self, binding: usize) -> bool {
        self.layout.bindings.get(binding).is_none_or(|binding| binding.access == Access::Read)
    }
}

impl Loop {
    /// Buffers of whole numbers behind those of the layout.
    pub(crate) fn lists(self) -> &'static [&'static str] {
        match self {
            Loop::Rows | Loop::Pairs => &[],
            // The rows of each link; for each row, where its part of the list begins; the links and ends in order.
            Loop::Links(_) => &["link_rows", "row_starts", "row_links"],
        }
    }
}

/// Why a body has no text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Refused {
    #[error("its body asks for the bits of a mask, which a device has no answer to: choose with `select`")]
    AsksForBits,
    #[error("f64 has no `{0}` on devices: run it in f32, or on the host")]
    NotInF64(&'static str),
}

/// Writes the program of a recorded body. `estimates`: whether the law allows roots that are estimated.
pub(crate) fn write(
    trace: &Trace,
    layout: Layout,
    shape: Loop,
    precision: Numbers,
    estimates: bool,
) -> Result<Program, Refused> {
    if trace.record.asks_for_bits {
        return Err(Refused::AsksForBits);
    }
    let results: Vec<ResultOf> = trace.results.iter().copied().filter(|result| layout.output(result.slot)).collect();
    let live = live(&trace.record.nodes, results.iter().map(|result| result.value));
    let nodes = trace.record.nodes.iter().zip(&live).filter(|(_, live)| **live).map(|(node, _)| *node);
    if precision == Numbers::F64
        && let Some(function) = nodes.clone().find_map(only_f32)
    {
        return Err(Refused::NotInF64(function));
    }
    let call = call(&layout, nodes.clone());
    let writer = Writer { trace, layout: &layout, precision, estimates, live: &live, call: &call };
    let mut text = writer.head(shape, nodes.clone().any(|node| matches!(node, Node::Binary(Binary::Pow, ..))));
    match shape {
        Loop::Rows => writer.rows(&mut text, &results),
        Loop::Pairs => writer.pairs(&mut text, &results),
        Loop::Links(ends) => writer.links(&mut text, &results, ends),
    }
    Ok(Program { text, layout, precision, shape, call })
}

/// A function that devices have in f32 only.
fn only_f32(node: Node) -> Option<&'static str> {
    match node {
        Node::Unary(Unary::Sin, _) => Some("sin"),
        Node::Unary(Unary::Cos, _) => Some("cos"),
        Node::Unary(Unary::Exp, _) => Some("exp"),
        Node::Unary(Unary::Ln, _) => Some("ln"),
        Node::Binary(Binary::Pow, ..) => Some("powf"),
        _ => None,
    }
}

/// Which operations the results need.
fn live(nodes: &[Node], results: impl Iterator<Item = At>) -> Vec<bool> {
    let mut live = vec![false; nodes.len()];
    results.for_each(|at| live[at as usize] = true);
    for at in (0..nodes.len()).rev() {
        if live[at] {
            nodes[at].needs().for_each(|need| live[need as usize] = true);
        }
    }
    live
}

/// What comes with a call: numbers of the law's precision first, so that each stands at a multiple of its size.
fn call(layout: &Layout, nodes: impl Iterator<Item = Node>) -> Vec<Word> {
    let mut constants: Vec<usize> = nodes
        .filter_map(|node| match node {
            Node::Input(Input { slot, .. }) if layout.slots[slot] == Slot::Constant => Some(slot),
            _ => None,
        })
        .collect();
    constants.sort_unstable();
    let mut call: Vec<Word> = constants.into_iter().map(Word::Constant).collect();
    let advances = |slot: &Slot| matches!(slot, Slot::Output { store: Store::Advance, .. });
    call.extend(layout.slots.iter().any(advances).then_some(Word::Step));
    call.push(Word::Rows);
    // Buffers of one component have none apart.
    let several = |binding: &usize| {
        layout.slots.iter().any(|slot| match slot {
            Slot::Input { binding: at, component } | Slot::Output { binding: at, component, .. } => {
                at == binding && *component > 0
            }
            Slot::Absent | Slot::Constant => false,
        })
    };
    call.extend((0..layout.bindings.len()).filter(several).map(Word::Stride));
    call
}

impl Layout {
    /// Whether there is a place for a result of this slot.
    fn output(&self, slot: usize) -> bool {
        matches!(self.slots[slot], Slot::Output { .. })
    }
}

pub(super) struct Writer<'a> {
    pub(super) trace: &'a Trace,
    pub(super) layout: &'a Layout,
    pub(super) precision: Numbers,
    pub(super) estimates: bool,
    /// Operations that results need.
    pub(super) live: &'a [bool],
    call: &'a [Word],
}

/// Appends a line. Writing to a `String` cannot fail.
macro_rules! line {
    ($text:expr, $indent:expr, $($arguments:tt)*) => {{
        $text.extend(core::iter::repeat_n("    ", $indent));
        let _ = writeln!($text, $($arguments)*);
    }};
}

pub(super) use line;

impl Writer<'_> {
    /// Everything before the entry point.
    fn head(&self, shape: Loop, power: bool) -> String {
        let number = self.precision.name();
        let mut text = String::new();
        text.push_str("struct Call {\n");
        for word in self.call {
            match word {
                Word::Constant(slot) => line!(text, 1, "constant_{slot}: {number},"),
                Word::Step => line!(text, 1, "step: {number},"),
                Word::Rows => line!(text, 1, "rows: u32,"),
                Word::Stride(binding) => line!(text, 1, "stride_{binding}: u32,"),
            }
        }
        text.push_str("}\nvar<immediate> call: Call;\n");
        for (at, binding) in self.layout.bindings.iter().enumerate() {
            let access = if binding.access == Access::Read { "read" } else { "read_write" };
            line!(text, 0, "@group(0) @binding({at}) var<storage, {access}> {}: array<{number}>;", binding.name);
        }
        for (at, list) in (self.layout.bindings.len()..).zip(shape.lists()) {
            line!(text, 0, "@group(0) @binding({at}) var<storage, read> {list}: array<u32>;");
        }
        if power {
            text.push_str(POWER);
        }
        text
    }

    fn rows(&self, text: &mut String, results: &[ResultOf]) {
        text.push_str(ENTRY);
        text.push_str("    if row >= call.rows {\n        return;\n    }\n");
        self.operations(text, 1, |_| true, |input| self.place(input, "row"));
        for result in results {
            self.store(text, 1, result.slot, "row", &name(result.value));
        }
        text.push_str("}\n");
    }

    fn pairs(&self, text: &mut String, results: &[ResultOf]) {
        let number = self.precision.name();
        let others = self.others();
        line!(text, 0, "var<workgroup> tile: array<{number}, {}>;", GROUP as usize * others.len().max(1));
        text.push_str(&ENTRY.replace(") {", ",\n    @builtin(local_invocation_index) lane: u32) {"));
        // No invocation leaves before the last barrier: those beyond the rows work on the last one, and store nothing.
        line!(text, 1, "let own = min(row, call.rows - 1u);");
        let of_pair = self.of_pair();
        self.operations(text, 1, |at| !of_pair[at as usize], |input| self.place(input, "own"));
        for result in results {
            line!(text, 1, "var sum_{}: {number} = 0.0;", result.slot);
        }
        line!(text, 1, "for (var first = 0u; first < call.rows; first = first + {GROUP}u) {{");
        line!(text, 2, "let other = min(first + lane, call.rows - 1u);");
        line!(text, 2, "workgroupBarrier();");
        for (number, slot) in others.iter().enumerate() {
            let from = self.place(Input { of: Of::Other, slot: *slot }, "other");
            line!(text, 2, "tile[lane + {}u] = {from};", number as u32 * GROUP);
        }
        line!(text, 2, "workgroupBarrier();");
        // A sum for each tile: it rounds with the size of few terms, and the sum of all with that of few tiles.
        for result in results {
            line!(text, 2, "var part_{}: {number} = 0.0;", result.slot);
        }
        line!(text, 2, "let count = min({GROUP}u, call.rows - first);");
        line!(text, 2, "for (var k = 0u; k < count; k = k + 1u) {{");
        line!(text, 3, "if first + k != row {{");
        let in_tile = |slot: usize| others.iter().position(|other| *other == slot).unwrap_or_default() as u32 * GROUP;
        self.operations(
            text,
            4,
            |at| of_pair[at as usize],
            |input| match input.of {
                Of::Other => format!("tile[k + {}u]", in_tile(input.slot)),
                _ => self.place(input, "own"),
            },
        );
        for ResultOf { slot, value, .. } in results {
            line!(text, 4, "part_{slot} = part_{slot} + {};", name(*value));
        }
        text.push_str("            }\n        }\n");
        for ResultOf { slot, .. } in results {
            line!(text, 2, "sum_{slot} = sum_{slot} + part_{slot};");
        }
        text.push_str("    }\n    if row < call.rows {\n");
        for ResultOf { slot, .. } in results {
            self.store(text, 2, *slot, "row", &format!("sum_{slot}"));
        }
        text.push_str("    }\n}\n");
    }

    fn links(&self, text: &mut String, results: &[ResultOf], ends: usize) {
        let number = self.precision.name();
        text.push_str(ENTRY);
        text.push_str("    if row >= call.rows {\n        return;\n    }\n");
        let mut slots: Vec<usize> = results.iter().map(|result| result.slot).collect();
        slots.sort_unstable();
        slots.dedup();
        for &slot in &slots {
            // Shares are added one by one to what is there, as on the host.
            match self.layout.slots[slot] {
                Slot::Output { binding, component, store: Store::Add } => {
                    line!(text, 1, "var sum_{slot} = {};", self.at(binding, component, "row"));
                }
                _ => line!(text, 1, "var sum_{slot}: {number} = 0.0;"),
            }
        }
        line!(text, 1, "for (var at = row_starts[row]; at < row_starts[row + 1u]; at = at + 1u) {{");
        line!(text, 2, "let link = row_links[at] / {ends}u;");
        line!(text, 2, "let end = row_links[at] % {ends}u;");
        for end in 0..ends {
            line!(text, 2, "let row_{end} = link_rows[link * {ends}u + {end}u];");
        }
        self.operations(
            text,
            2,
            |_| true,
            |input| match input.of {
                Of::End(end) => self.place(input, &format!("row_{end}")),
                _ => self.place(input, "link"),
            },
        );
        for &slot in &slots {
            // The share of the last end, or of whichever it is.
            let mut share = String::new();
            for result in results.iter().filter(|result| result.slot == slot) {
                let Of::End(end) = result.of else { continue };
                let value = name(result.value);
                share = if share.is_empty() { value } else { format!("select({share}, {value}, end == {end}u)") };
            }
            line!(text, 2, "sum_{slot} = sum_{slot} + {share};");
        }
        text.push_str("    }\n");
        for slot in slots {
            if let Slot::Output { binding, component, .. } = self.layout.slots[slot] {
                line!(text, 1, "{} = sum_{slot};", self.at(binding, component, "row"));
            }
        }
        text.push_str("}\n");
    }

    /// Components of the other row that pairs need.
    fn others(&self) -> Vec<usize> {
        let nodes = self.trace.record.nodes.iter().zip(self.live);
        let mut slots: Vec<usize> = nodes
            .filter_map(|(node, live)| match node {
                Node::Input(Input { of: Of::Other, slot }) if *live && self.layout.slots[*slot] != Slot::Constant => {
                    Some(*slot)
                }
                _ => None,
            })
            .collect();
        slots.sort_unstable();
        slots
    }

    /// Which operations need the other row.
    fn of_pair(&self) -> Vec<bool> {
        let mut of_pair = Vec::with_capacity(self.trace.record.nodes.len());
        for node in &self.trace.record.nodes {
            let own = matches!(node, Node::Input(Input { of: Of::Other, .. }));
            let inherited = node.needs().any(|need| of_pair[need as usize]);
            of_pair.push(own || inherited);
        }
        of_pair
    }

    /// The expression of an input, at the row of this name.
    fn place(&self, input: Input, row: &str) -> String {
        match self.layout.slots[input.slot] {
            Slot::Input { binding, component } | Slot::Output { binding, component, .. } => {
                self.at(binding, component, row)
            }
            Slot::Constant | Slot::Absent => format!("call.constant_{}", input.slot),
        }
    }

    /// A component of a buffer, at the row of this name.
    fn at(&self, binding: usize, component: usize, row: &str) -> String {
        let name = &self.layout.bindings[binding].name;
        match component {
            0 => format!("{name}[{row}]"),
            1 => format!("{name}[{row} + call.stride_{binding}]"),
            _ => format!("{name}[{row} + {component}u * call.stride_{binding}]"),
        }
    }

    fn store(&self, text: &mut String, indent: usize, slot: usize, row: &str, value: &str) {
        let Slot::Output { binding, component, store } = self.layout.slots[slot] else { return };
        let place = self.at(binding, component, row);
        match store {
            Store::Set => line!(text, indent, "{place} = {value};"),
            Store::Add => line!(text, indent, "{place} = {place} + {value};"),
            Store::Advance => line!(text, indent, "{place} = {place} + {value} * call.step;"),
        }
    }
}

/// The name of an operation's result.
pub(super) fn name(at: At) -> String {
    format!("v{at}")
}

/// Where a program begins; its number among all invocations.
const ENTRY: &str = "@compute @workgroup_size(64)
fn main(
    @builtin(global_invocation_id) id: vec3<u32>) {
    let row = id.x + id.y * 4194240u;
";

/// WGSL leaves powers of negative numbers undefined; laws have those of whole exponents.
const POWER: &str = "fn power(x: f32, y: f32) -> f32 {
    if y == 0.0 {
        return 1.0;
    }
    let size = pow(abs(x), y);
    if x >= 0.0 {
        return size;
    }
    let half = 0.5 * y;
    if floor(half) == half {
        return size;
    }
    if floor(y) == y {
        return -size;
    }
    let zero = y - y;
    return zero / zero;
}
";

const _: () = assert!(GROUP == 64 && GROUP * ACROSS == 4_194_240, "the texts above say so, too");
