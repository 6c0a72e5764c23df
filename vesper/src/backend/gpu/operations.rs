//! The operations of a body, as text.
//!
//! In: a record, and which of it is wanted. Out: lines of WGSL, a `let` for each operation. Never: a loop.

use super::layout::Slot;
use super::traced::{At, Binary, Compare, Input, Node, Unary};
use super::wgsl::{Numbers, Writer, line, name};
use core::fmt::Write;

impl Writer<'_> {
    /// Those operations that results need and that are meant, one `let` each.
    pub(super) fn operations(
        &self,
        text: &mut String,
        indent: usize,
        meant: impl Fn(At) -> bool,
        input: impl Fn(Input) -> String,
    ) {
        for (at, node) in self.trace.record.nodes.iter().enumerate() {
            if !self.live[at] || !meant(at as At) {
                continue;
            }
            let own = name(at as At);
            match *node {
                // A part of the state that is not asked for depends on nothing that is absent; if it does, it shows.
                Node::Input(from) if self.layout.slots[from.slot] == Slot::Absent => {
                    self.number(text, indent, &own, f64::NAN);
                }
                Node::Input(from) => line!(text, indent, "let {own} = {};", input(from)),
                Node::Number(bits) => self.number(text, indent, &own, f64::from_bits(bits)),
                Node::Unary(operation, a) => line!(text, indent, "let {own} = {};", self.unary(operation, &name(a))),
                Node::Binary(operation, a, b) => {
                    line!(text, indent, "let {own} = {};", self.binary(operation, &name(a), &name(b)));
                }
                Node::Compare(operation, a, b) => {
                    let sign = match operation {
                        Compare::Less => "<",
                        Compare::LessOrEqual => "<=",
                        Compare::Equal => "==",
                    };
                    line!(text, indent, "let {own} = {} {sign} {};", name(a), name(b));
                }
                Node::Both(a, b) => line!(text, indent, "let {own} = {} && {};", name(a), name(b)),
                Node::Either(a, b) => line!(text, indent, "let {own} = {} || {};", name(a), name(b)),
                Node::Not(a) => line!(text, indent, "let {own} = !{};", name(a)),
                Node::Choose(mask, yes, no) => {
                    line!(text, indent, "let {own} = select({}, {}, {});", name(no), name(yes), name(mask));
                }
            }
        }
    }

    fn number(&self, text: &mut String, indent: usize, own: &str, value: f64) {
        let (rounded, literal, suffix) = match self.precision {
            Numbers::F32 => (f64::from(value as f32), format!("{:?}f", value as f32), "f"),
            Numbers::F64 => (value, format!("{value:?}lf"), "lf"),
        };
        if rounded.is_finite() {
            return line!(text, indent, "let {own} = {literal};");
        }
        // There are no literals of these; nor may a constant expression have such a value.
        let above = u8::from(!rounded.is_nan());
        let sign = if rounded.is_sign_negative() { "-" } else { "" };
        line!(text, indent, "let zero_{own} = 0.0{suffix};");
        line!(text, indent, "let {own} = {sign}{above}.0{suffix} / zero_{own};");
    }

    fn unary(&self, operation: Unary, a: &str) -> String {
        let one = match self.precision {
            Numbers::F32 => "1.0f",
            Numbers::F64 => "1.0lf",
        };
        match operation {
            Unary::Neg => format!("-{a}"),
            Unary::Sqrt => format!("sqrt({a})"),
            Unary::Rsqrt if self.estimates => format!("inverseSqrt({a})"),
            Unary::Rsqrt => format!("{one} / sqrt({a})"),
            Unary::Abs => format!("abs({a})"),
            Unary::Sin => format!("sin({a})"),
            Unary::Cos => format!("cos({a})"),
            Unary::Exp => format!("exp({a})"),
            Unary::Ln => format!("log({a})"),
        }
    }

    fn binary(&self, operation: Binary, a: &str, b: &str) -> String {
        match operation {
            Binary::Add => format!("{a} + {b}"),
            Binary::Sub => format!("{a} - {b}"),
            Binary::Mul => format!("{a} * {b}"),
            Binary::Div => format!("{a} / {b}"),
            // What `min` and `max` of a device give for NaN is the device's own choice.
            Binary::Min => format!("select({b}, {a}, {a} < {b})"),
            Binary::Max => format!("select({b}, {a}, {b} < {a})"),
            Binary::Pow => format!("power({a}, {b})"),
            Binary::OverRootCubed if self.estimates => {
                format!("{a} * inverseSqrt({b}) * inverseSqrt({b}) * inverseSqrt({b})")
            }
            Binary::OverRootCubed => format!("{a} / ({b} * sqrt({b}))"),
        }
    }
}
