//! Holds a body to its declaration: [`Within`] gives and takes each slot only as the signature says.
//!
//! The loops follow raw pointers that were placed by the signature. Derived laws ask with constants, so that every check
//! is decided when the law is compiled, and costs nothing; whoever writes `Declared` by hand and asks for another slot
//! gets a panic, and never another's memory.

use crate::law::{Law, Mode, Place, Port, Sink, Source};
use crate::property::Role;
use crate::real::Real;
use core::marker::PhantomData;

/// A source or a sink, seen through the signature of law `F`.
pub(super) struct Within<S, F> {
    inner: S,
    law: PhantomData<F>,
}

impl<S, F: Law> Within<S, F> {
    const TABLE: Table = Table::new(F::SIGNATURE.ports);

    #[inline(always)]
    pub(super) fn new(inner: S) -> Self {
        Within { inner, law: PhantomData }
    }
}

/// What a slot is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    Nothing,
    Value,
    Constant,
    Field,
    Set,
    Add,
    Drift,
    Kick,
}

/// By slot: its use, its port, the first slot of that port, and whether the port may be absent.
struct Table {
    uses: [Use; SLOTS],
    port: [usize; SLOTS],
    first: [usize; SLOTS],
    optional: [bool; SLOTS],
}

/// Laws that touch more are refused when they are compiled or listed.
const SLOTS: usize = crate::law::MAX_SLOTS;

impl Table {
    const fn new(ports: &[Port]) -> Table {
        let mut table =
            Table { uses: [Use::Nothing; SLOTS], port: [0; SLOTS], first: [0; SLOTS], optional: [false; SLOTS] };
        let (mut port, mut slot) = (0, 0);
        while port < ports.len() {
            let first = slot;
            while slot < first + ports[port].property.kind.width() && slot < SLOTS {
                table.uses[slot] = use_of(&ports[port]);
                (table.port[slot], table.first[slot]) = (port, first);
                table.optional[slot] = ports[port].optional;
                slot += 1;
            }
            port += 1;
        }
        table
    }
}

const fn use_of(port: &Port) -> Use {
    match port.mode {
        Mode::Reads | Mode::Previous => match port.place {
            Place::Own | Place::End => Use::Value,
            Place::Scene => Use::Constant,
            Place::Field => Use::Field,
        },
        Mode::Sets | Mode::Amends => Use::Set,
        Mode::Adds => Use::Add,
        Mode::Rates => match port.property.role {
            Role::Coordinate => Use::Drift,
            Role::Momentum(_) | Role::Plain | Role::Switch | Role::Sum { .. } | Role::Turn { .. } => Use::Kick,
        },
    }
}

impl<S, F: Law> Within<S, F> {
    #[inline(always)]
    fn check(slot: usize, asked: Use) {
        let table = const { &Self::TABLE };
        assert!(
            slot < SLOTS && table.uses[slot] as u8 == asked as u8,
            "law {} does not declare this",
            F::SIGNATURE.name
        );
    }

    #[inline(always)]
    fn check_there<R>(&self, slot: usize, asked: Use)
    where
        S: Source<R>,
    {
        Self::check(slot, asked);
        let table = const { &Self::TABLE };
        let there = !table.optional[slot] || self.inner.has(table.first[slot]);
        assert!(there && self.inner.wants(table.port[slot]), "law {} has no such value here", F::SIGNATURE.name);
    }
}

impl<R: Real, S: Source<R>, F: Law> Source<R> for Within<S, F> {
    #[inline(always)]
    fn wants(&self, port: usize) -> bool {
        self.inner.wants(port)
    }
    #[inline(always)]
    fn has(&self, slot: usize) -> bool {
        self.inner.has(slot)
    }
    #[inline(always)]
    fn component(&self, slot: usize) -> R {
        self.check_there(slot, Use::Value);
        self.inner.component(slot)
    }
    #[inline(always)]
    fn constant(&self, slot: usize) -> R {
        self.check_there(slot, Use::Constant);
        self.inner.constant(slot)
    }
    #[inline(always)]
    fn field(&self, slot: usize) -> R {
        self.check_there(slot, Use::Field);
        self.inner.field(slot)
    }
}

impl<R: Real, K: Sink<R>, F: Law> Sink<R> for Within<K, F> {
    #[inline(always)]
    fn set(&mut self, slot: usize, value: R) {
        Self::check(slot, Use::Set);
        self.inner.set(slot, value);
    }
    #[inline(always)]
    fn add(&mut self, slot: usize, value: R) {
        Self::check(slot, Use::Add);
        self.inner.add(slot, value);
    }
    #[inline(always)]
    fn turn(&mut self, slot: usize, value: R) {
        Self::check(slot, Use::Add);
        self.inner.turn(slot, value);
    }
    #[inline(always)]
    fn rate(&mut self, coordinate: bool, slot: usize, value: R) {
        Self::check(slot, if coordinate { Use::Drift } else { Use::Kick });
        self.inner.rate(coordinate, slot, value);
    }
}
