//! Sums of vectors on a device: what integrators are written in, so that a whole step stays there.
//!
//! In: registers, and which states have their rates there. Out: the same sums, in the host's order as far as a program has buffers for the
//! terms. Never: a state whose rates the host computes; that one's vectors are the host's.

use super::ledger::{Touch, then};
use super::residency::{Residency, What};
use crate::backend::gpu::{self, Access, BindGroup, Binding, Layout, Prepared, Slot, Store, Word, Work};
use crate::integrate::{Combination, Register, Terms};
use crate::pipeline::bind::{Base, Located};
use crate::pipeline::vectors::{Component, Vectors};
use crate::real::Scalar;
use std::sync::Arc;

/// A sum: where it goes, whether it is added to what is there, and what is summed.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Key {
    to: usize,
    adds: bool,
    from: Vec<usize>,
}

/// A sum, ready to run.
pub(crate) struct SumOf {
    prepared: Arc<Prepared>,
    group: BindGroup,
    rows: u32,
}

/// A sum of columns that somebody asks for.
pub(super) struct Sum {
    key: Key,
    factors: Vec<f64>,
    touches: Vec<Touch>,
}

impl Sum {
    fn of(to: usize, adds: bool, terms: &[(f64, usize)]) -> Self {
        let from: Vec<usize> = terms.iter().map(|(_, column)| *column).collect();
        let mut touches = Vec::new();
        from.iter().for_each(|&column| then(&mut touches, Touch { column, access: Access::Read }));
        let access = if adds { Access::Update } else { Access::Write };
        then(&mut touches, Touch { column: to, access });
        Sum { key: Key { to, adds, from }, factors: terms.iter().map(|(factor, _)| *factor).collect(), touches }
    }
}

/// What of a combination is the host's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Left {
    Nothing,
    /// The states whose vectors are not on the device.
    Others,
    All,
}

/// Who does what of a combination.
#[derive(Default)]
pub(super) struct Share {
    /// On the device, one after the other.
    pub(super) sums: Vec<Sum>,
    /// What the host touches of what the device knows.
    pub(super) host: Vec<Touch>,
    /// Whether the host has anything to do.
    pub(super) rest: bool,
}

impl Share {
    /// What the device touches, in order.
    pub(super) fn touches(&self) -> impl Iterator<Item = &[Touch]> {
        self.sums.iter().map(|sum| sum.touches.as_slice())
    }
}

impl<P: Scalar> Residency<P> {
    /// Splits a combination between both sides.
    pub(super) fn share(&mut self, vectors: &Vectors<P>, combination: &Combination<'_>) -> Share {
        let Combination { to, adds, part, terms, momenta } = *combination;
        let mut share = Share::default();
        // A program has a buffer for the sum, and one for each term.
        let most = self.device.buffers() - 1;
        let coordinates = vectors.coordinates();
        for (number, state) in vectors.part(part) {
            let own = row(terms).map(|(factor, from)| (factor, from, number));
            let moved = row(momenta).map(|(factor, from)| (factor, from, coordinates + number));
            let single = |terms: Terms<'_>, of| -> Vec<_> {
                terms.others.iter().map(|(factor, from)| (*factor, *from, of)).collect()
            };
            let all = moved.chain(own).chain(single(momenta, coordinates + number)).chain(single(terms, number));
            if !state.on_device || self.refuses_sums {
                share.rest = true;
                let access = if adds { Access::Update } else { Access::Write };
                let looked_at = all.map(|(_, from, of)| (from, of, Access::Read));
                for (register, of, access) in looked_at.chain([(to, number, access)]) {
                    let column = self.find(place(vectors, register, of));
                    column.into_iter().for_each(|c| then(&mut share.host, Touch { column: c, access }));
                }
                continue;
            }
            let to = self.register(vectors, to, number);
            let mut terms: Vec<(f64, usize)> =
                all.map(|(factor, from, of)| (factor, self.register(vectors, from, of))).collect();
            if terms.len() > most {
                // What is written is looked at before it is.
                terms.sort_by_key(|(_, column)| *column != to);
            }
            let (first, later) = terms.split_at(terms.len().min(most));
            share.sums.push(Sum::of(to, adds, first));
            share.sums.extend(later.chunks(most).map(|terms| Sum::of(to, true, terms)));
        }
        share
    }

    /// The column of a state in a register.
    fn register(&mut self, vectors: &Vectors<P>, register: Register, number: usize) -> usize {
        let state = &vectors.states[number];
        self.column(place(vectors, register, number), || {
            let component = |component: &Component<P>| match register {
                Register::State => component.place.clone(),
                Register::Rates | Register::Work(_) => Located {
                    base: Base::Owned(vectors.start(register).wrapping_add(component.at)),
                    stride: 1,
                    ..component.place.clone()
                },
            };
            state.components.iter().map(component).collect()
        })
    }

    /// Sums vectors, those that are on the device; what the host has to do itself.
    pub(crate) fn linear(&mut self, vectors: &Vectors<P>, combination: &Combination<'_>, lent: &[*mut P]) -> Left {
        let share = self.share(vectors, combination);
        if share.sums.is_empty() {
            self.on_host(&share.host, lent);
            return Left::All;
        }
        let ready = share.sums.iter().all(|sum| self.is_ready(&sum.key));
        for sum in &share.sums {
            if self.is_lost() || !ready {
                break;
            }
            self.on_device(&sum.touches, lent);
            if !self.is_lost() {
                self.sum(sum);
            }
        }
        // If it was lost on the way, what it had is no number, and neither is the sum.
        if self.is_lost() || !ready {
            self.all_on_host(true, lent);
            return Left::All;
        }
        if !share.rest {
            return Left::Nothing;
        }
        self.on_host(&share.host, lent);
        Left::Others
    }

    /// Whether the device has room for a state.
    pub(super) fn has_room(&mut self, vectors: &Vectors<P>, number: usize) -> bool {
        let column = self.register(vectors, Register::State, number);
        self.buffer(column).is_ok()
    }

    /// Makes the program of a sum, where it is not known; whether there is one.
    fn is_ready(&mut self, key: &Key) -> bool {
        if self.sums.contains_key(key) {
            return true;
        }
        match self.prepare(key) {
            Ok(sum) => _ = self.sums.insert(key.clone(), sum),
            Err(reason) => {
                log::warn!("vectors are summed on the host: {reason}");
                self.refuses_sums = true;
                return false;
            }
        }
        true
    }

    fn sum(&mut self, sum: &Sum) {
        let Some(SumOf { prepared, group, rows }) = self.sums.get(&sum.key) else { return };
        let mut call = Vec::new();
        for word in &prepared.program.call {
            match *word {
                Word::Constant(slot) => {
                    super::number(&mut call, P::from_f64(sum.factors[slot - 1 - sum.factors.len()]));
                }
                Word::Rows => call.extend(rows.to_le_bytes()),
                Word::Step | Word::Stride(_) => {}
            }
        }
        call.resize(prepared.program.call_bytes() as usize, 0);
        let (prepared, group, rows) = (Arc::clone(prepared), group.clone(), *rows);
        self.record(&Work { prepared: &prepared, group: &group, call, rows });
    }

    /// Makes the program of a sum.
    fn prepare(&mut self, key: &Key) -> Result<SumOf, String> {
        let Key { to, adds, from } = key;
        let (mut layout, mut columns) = (Layout::default(), vec![*to]);
        let store = if *adds { Store::Add } else { Store::Set };
        let read = from.contains(to) || *adds;
        layout.bindings.push(Binding::new("sum", if read { Access::Update } else { Access::Write }, 0));
        layout.slots.push(Slot::Output { binding: 0, component: 0, store });
        for column in from {
            let binding = columns.iter().position(|known| known == column).unwrap_or_else(|| {
                columns.push(*column);
                layout.bindings.push(Binding::new("term", Access::Read, columns.len() - 1));
                columns.len() - 1
            });
            layout.slots.push(Slot::Input { binding, component: 0 });
        }
        layout.slots.extend(from.iter().map(|_| Slot::Constant));
        // One component stands behind the other, in all columns alike.
        let rows = u32::try_from(self.bytes(*to) / size_of::<P>()).map_err(|_| "too many numbers".to_owned())?;
        let program = gpu::summed::<P>(from.len(), layout).map_err(|error| error.to_string())?;
        let device = Arc::clone(&self.device);
        let prepared = device.prepare(program).map_err(|fault| fault.to_string())?;
        for &column in &columns {
            self.buffer(column).map_err(|fault| fault.to_string())?;
        }
        let buffers: Vec<_> = columns.iter().filter_map(|column| self.room(*column)).collect();
        let group = device.bind(&prepared, &buffers);
        Ok(SumOf { prepared, group, rows })
    }
}

/// Vectors of a row of weights that have one, with their factors as the host multiplies them.
fn row<'a>(terms: Terms<'a>) -> impl Iterator<Item = (f64, Register)> + 'a {
    let registers = (terms.first..).map(Register::Work);
    let weighed = terms.weights.iter().zip(registers).filter(|(weight, _)| **weight != 0.0);
    weighed.map(move |(weight, from)| (weight * terms.factor, from))
}

/// What a register has of a state.
fn place<P: Scalar>(vectors: &Vectors<P>, register: Register, number: usize) -> What {
    let state = vectors.states[number].quantity;
    match register {
        Register::State => What::Quantity(state),
        Register::Rates => What::Rate(state),
        Register::Work(work) => What::Work(work, state),
    }
}
