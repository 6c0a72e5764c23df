//! A number that records what is done to it.
//!
//! In: a computation that is generic in its numbers. Out: a [`Record`] of its operations, each one after those it needs. Never: a value.
//!
//! A body of a law cannot ask a number for its value, only whether lanes of it are larger than another's, and choose; so one run over
//! these numbers meets every operation that a run over others does, in the same order, whatever functions, loops and traits the body is
//! made of. The one way around is [`Mask::bits`], which no number here can answer: the record says so.

use crate::real::{Mask, Real, Vec3};
use core::cell::RefCell;
use core::ops::{Add, AddAssign, BitAnd, BitOr, Div, Mul, Neg, Not, Sub, SubAssign};
use std::collections::HashMap;

/// The number of an operation in the record.
pub(super) type At = u32;

/// One operation. Equal ones are recorded once: they have no effects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Node {
    Input(Input),
    /// A constant, by its bits in f64.
    Number(u64),
    Unary(Unary, At),
    Binary(Binary, At, At),
    /// Comparisons give masks, and so do the three after them.
    Compare(Compare, At, At),
    Both(At, At),
    Either(At, At),
    Not(At),
    /// By a mask: the second where it holds, the third elsewhere.
    Choose(At, At, At),
}

/// Where a value comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Input {
    pub(super) of: Of,
    /// The number of the component among all of the law's.
    pub(super) slot: usize,
}

/// Whose value it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Of {
    /// The row's own; of a pair, that of the row which gets the result.
    Row,
    /// That of the other row of a pair.
    Other,
    /// That of an end of the link.
    End(usize),
    /// A constant of the scene.
    Scene,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Unary {
    Neg,
    Sqrt,
    Rsqrt,
    Abs,
    Sin,
    Cos,
    Exp,
    Ln,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Min,
    Max,
    Pow,
    OverRootCubed,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Compare {
    Less,
    LessOrEqual,
    Equal,
}

impl Node {
    /// The operations that it needs.
    pub(super) fn needs(self) -> impl Iterator<Item = At> {
        let needs = match self {
            Node::Input(_) | Node::Number(_) => [None; 3],
            Node::Unary(_, a) | Node::Not(a) => [Some(a), None, None],
            Node::Binary(_, a, b) | Node::Compare(_, a, b) | Node::Both(a, b) | Node::Either(a, b) => {
                [Some(a), Some(b), None]
            }
            Node::Choose(mask, yes, no) => [Some(mask), Some(yes), Some(no)],
        };
        needs.into_iter().flatten()
    }
}

/// What was done.
#[derive(Debug, Default)]
pub(super) struct Record {
    pub(super) nodes: Vec<Node>,
    known: HashMap<Node, At>,
    /// Whether somebody asked for the bits of a mask.
    pub(super) asks_for_bits: bool,
}

thread_local! {
    static RECORD: RefCell<Record> = RefCell::default();
}

/// Runs a computation over traced numbers; what it gives, and what was done.
pub(super) fn record<T>(computation: impl FnOnce() -> T) -> (T, Record) {
    let before = RECORD.take();
    let result = computation();
    (result, RECORD.replace(before))
}

fn push(node: Node) -> At {
    RECORD.with_borrow_mut(|record| {
        *record.known.entry(node).or_insert_with(|| {
            record.nodes.push(node);
            // A law of more operations than that is not written.
            (record.nodes.len() - 1) as At
        })
    })
}

/// A number of a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct Traced(pub(super) At);

/// A truth value of a record.
#[derive(Clone, Copy, Debug)]
pub(super) struct TracedMask(At);

impl Traced {
    pub(super) fn input(of: Of, slot: usize) -> Self {
        Traced(push(Node::Input(Input { of, slot })))
    }

    fn unary(self, operation: Unary) -> Self {
        Traced(push(Node::Unary(operation, self.0)))
    }

    fn binary(self, operation: Binary, other: Self) -> Self {
        Traced(push(Node::Binary(operation, self.0, other.0)))
    }

    fn compare(self, operation: Compare, other: Self) -> TracedMask {
        TracedMask(push(Node::Compare(operation, self.0, other.0)))
    }
}

macro_rules! operators {
    ($($operator:ident $method:ident,)*) => {$(
        impl $operator for Traced {
            type Output = Self;
            fn $method(self, other: Self) -> Self {
                self.binary(Binary::$operator, other)
            }
        }
    )*};
}
operators! { Add add, Sub sub, Mul mul, Div div, }

impl Neg for Traced {
    type Output = Self;
    fn neg(self) -> Self {
        self.unary(Unary::Neg)
    }
}

impl AddAssign for Traced {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Traced {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl Real for Traced {
    type Vec3 = Vec3<Self>;
    type Mask = TracedMask;

    fn lit(value: f64) -> Self {
        Traced(push(Node::Number(value.to_bits())))
    }
    fn sqrt(self) -> Self {
        self.unary(Unary::Sqrt)
    }
    fn rsqrt(self) -> Self {
        self.unary(Unary::Rsqrt)
    }
    fn over_root_cubed(self, square: Self) -> Self {
        self.binary(Binary::OverRootCubed, square)
    }
    fn abs(self) -> Self {
        self.unary(Unary::Abs)
    }
    fn min(self, other: Self) -> Self {
        self.binary(Binary::Min, other)
    }
    fn max(self, other: Self) -> Self {
        self.binary(Binary::Max, other)
    }
    fn sin(self) -> Self {
        self.unary(Unary::Sin)
    }
    fn cos(self) -> Self {
        self.unary(Unary::Cos)
    }
    fn exp(self) -> Self {
        self.unary(Unary::Exp)
    }
    fn ln(self) -> Self {
        self.unary(Unary::Ln)
    }
    fn powf(self, exponent: Self) -> Self {
        self.binary(Binary::Pow, exponent)
    }
    fn less(self, other: Self) -> TracedMask {
        self.compare(Compare::Less, other)
    }
    fn less_or_equal(self, other: Self) -> TracedMask {
        self.compare(Compare::LessOrEqual, other)
    }
    fn equal(self, other: Self) -> TracedMask {
        self.compare(Compare::Equal, other)
    }
    fn select(mask: TracedMask, yes: Self, no: Self) -> Self {
        Traced(push(Node::Choose(mask.0, yes.0, no.0)))
    }
}

impl BitAnd for TracedMask {
    type Output = Self;
    fn bitand(self, other: Self) -> Self {
        TracedMask(push(Node::Both(self.0, other.0)))
    }
}

impl BitOr for TracedMask {
    type Output = Self;
    fn bitor(self, other: Self) -> Self {
        TracedMask(push(Node::Either(self.0, other.0)))
    }
}

impl Not for TracedMask {
    type Output = Self;
    fn not(self) -> Self {
        TracedMask(push(Node::Not(self.0)))
    }
}

impl Mask for TracedMask {
    fn bits(self) -> u32 {
        RECORD.with_borrow_mut(|record| record.asks_for_bits = true);
        0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing but what the trait lets a body do: a function with a loop, a vector, a choice.
    fn body<R: Real>(x: R, y: R) -> R {
        let mut sum = R::lit(0.0);
        for _ in 0..2 {
            sum += x * y;
        }
        R::select(x.less(y) & !y.equal(sum), sum, x.max(y))
    }

    #[test]
    fn a_record_has_each_operation_once_and_after_what_it_needs() {
        let (result, record) = record(|| body(Traced::input(Of::Row, 0), Traced::input(Of::Row, 1)));
        for (at, node) in record.nodes.iter().enumerate() {
            assert!(node.needs().all(|need| (need as usize) < at), "{node:?} at {at}");
        }
        let products = record.nodes.iter().filter(|node| matches!(node, Node::Binary(Binary::Mul, ..)));
        assert_eq!(products.count(), 1);
        assert!(matches!(record.nodes[result.0 as usize], Node::Choose(..)) && !record.asks_for_bits);
    }

    #[test]
    fn whoever_asks_for_bits_is_noted_and_records_do_not_mix() {
        let (inner, outer) = record(|| {
            let (_, inner) = record(|| Traced::lit(1.0).less(Traced::lit(2.0)).bits());
            Traced::lit(3.0);
            inner
        });
        assert!(inner.asks_for_bits && inner.nodes.len() == 3);
        assert!(!outer.asks_for_bits && outer.nodes == [Node::Number(3f64.to_bits())]);
    }
}
