//! Passes on a graphics processor, and where their columns are.
//!
//! In: the operations of a pass, where columns are, a device. Out: the same results in the same columns, wherever somebody looks for them:
//! what a pass reads is brought to the device if it is not there, its laws run there one after the other, and what they wrote stays until
//! somebody on the host needs it ([`Residency`]). Never: a law that the device cannot run; then the pass stays on the host, and says why.
//! The host's pass stands by for a device that is lost.

mod build;
mod foresight;
mod ledger;
mod residency;
mod vectors;

pub(crate) use foresight::Foresight;
pub(crate) use ledger::Touch;
pub(crate) use residency::{Residency, Shared, What, lock};
pub(crate) use vectors::Left;

use super::bind::{Base, BoundPass, Pass};
use super::run::{Context, Runner};
use super::{Machine, Pipeline};
use crate::backend::gpu::{Access, BindGroup, Buffer, Device, Prepared, Transfers, Word, Work};
use crate::integrate::{Combination, Register, Terms};
use crate::law::Part;
use crate::real::Scalar;
use crate::registry::QuantityId;
use crate::state::State;
use std::sync::{Arc, Mutex};

/// A pass, ready to run on a device.
pub(crate) struct DevicePass<P: Scalar> {
    /// The same on the host.
    host: Box<Pass<P>>,
    /// What the host's pass touches.
    pub(super) on_host: Vec<Touch>,
    /// What it touches on the device.
    pub(super) touches: Vec<Touch>,
    /// Constants that it looks at, on the host: they come with the call.
    pub(super) constants: Vec<Touch>,
    calls: Vec<Call<P>>,
}

/// A program of the pass.
struct Call<P> {
    /// The law, where it is one: sums begin by none.
    law: Option<usize>,
    prepared: Arc<Prepared>,
    group: BindGroup,
    /// How far apart the components of each binding are.
    strides: Vec<u32>,
    /// Links and the rows that they end at.
    _lists: Vec<Buffer>,
    /// The constants, by slot.
    constants: Vec<(usize, Constant<P>)>,
    rows: u32,
    /// The stage whose step its rates advance states by.
    advance: Option<usize>,
}

/// A number that is the same for all rows.
#[derive(Clone, Copy)]
enum Constant<P> {
    Number(P),
    At(Base<P>),
}

/// A device that laws were asked to run on, or why there is none.
pub(crate) type Opened = Option<Result<Arc<Device>, String>>;

impl<P: Scalar> DevicePass<P> {
    /// The pass as the host runs it.
    pub(super) fn host(&self) -> &Pass<P> {
        &self.host
    }

    /// The same, to run.
    pub(super) fn host_mut(&mut self) -> &mut Pass<P> {
        &mut self.host
    }

    /// Runs the pass on the device; false where the host has to: its columns are there then.
    pub(super) fn run(&self, context: &Context<'_, P>) -> bool {
        let Some(shared) = &context.residency else { return false };
        {
            let mut residency = lock(shared);
            residency.bring(&self.constants, context.lent);
            // Whoever looks for the first law that gives no number looks after each of them, and so does the host.
            if residency.is_lost() || context.is_watched() {
                residency.on_host(&self.on_host, context.lent);
                return false;
            }
            residency.on_device(&self.touches, context.lent);
            if residency.is_lost() {
                residency.on_host(&self.on_host, context.lent);
                return false;
            }
        }
        let first = self.calls.iter().find_map(|call| call.law).unwrap_or_default();
        context.timed(first, || {
            let mut residency = lock(shared);
            for call in &self.calls {
                let (prepared, group) = (&call.prepared, &call.group);
                residency.record(&Work { prepared, group, call: call.words(context), rows: call.rows });
            }
            if !context.is_unwatched() {
                // Who takes the time of laws wants that of their work, not of its recording.
                residency.finish();
            }
        });
        true
    }
}

/// Appends a number as devices have it.
fn number<P: Scalar>(bytes: &mut Vec<u8>, number: P) {
    match size_of::<P>() {
        4 => bytes.extend((number.to_f64() as f32).to_le_bytes()),
        _ => bytes.extend(number.to_f64().to_le_bytes()),
    }
}

impl<P: Scalar> Call<P> {
    /// What comes with the call.
    fn words(&self, context: &Context<'_, P>) -> Vec<u8> {
        let mut bytes = Vec::new();
        for word in &self.prepared.program.call {
            match *word {
                Word::Constant(slot) => {
                    let constant = self.constants.iter().find(|(own, _)| *own == slot);
                    number(
                        &mut bytes,
                        match constant {
                            Some((_, Constant::Number(number))) => *number,
                            // SAFETY: the runner holds the state, where a constant has one number.
                            Some((_, Constant::At(base))) => unsafe { *base.resolve(context.lent) },
                            None => P::from_f64(f64::NAN),
                        },
                    );
                }
                Word::Step => number(&mut bytes, self.advance.map_or(P::default(), |stage| context.steps[stage])),
                Word::Rows => bytes.extend(self.rows.to_le_bytes()),
                Word::Stride(binding) => bytes.extend(self.strides[binding].to_le_bytes()),
            }
        }
        bytes.resize(self.prepared.program.call_bytes() as usize, 0);
        bytes
    }
}

/// Where columns are, if laws may run on a device.
pub(super) fn residency<P: Scalar>(machine: &Machine) -> Option<Shared<P>> {
    let device = machine.device.as_ref()?.as_ref().ok()?;
    Some(Arc::new(Mutex::new(Residency::new(Arc::clone(device)))))
}

impl<P: Scalar> Context<'_, P> {
    /// Something on the host is about to touch these columns.
    pub(super) fn bring(&self, touches: &[Touch]) {
        if let Some(residency) = self.residency.as_ref().filter(|_| !touches.is_empty()) {
            lock(residency).on_host(touches, self.lent);
        }
    }
}

impl<P: Scalar> Drop for Runner<'_, P> {
    /// The client's memory is what it was lent for, when the client gets it back: also after a panic.
    fn drop(&mut self) {
        if let Some(residency) = &self.context.residency {
            lock(residency).end(self.context.lent);
        }
    }
}

impl<P: Scalar> Drop for Pipeline<P> {
    fn drop(&mut self) {
        if let Some(residency) = &self.residency {
            lock(residency).forget_vectors();
        }
    }
}

impl<P: Scalar> Runner<'_, P> {
    /// Everything is looked at on the host, or changed there.
    pub(super) fn come_home(&self, changes: bool) {
        if let Some(residency) = &self.context.residency {
            lock(residency).all_on_host(changes, self.context.lent);
        }
    }

    /// A vector in the place of another, on a device; whether nothing is left for the host.
    pub(super) fn copy_on_device(&mut self, (to, from): (Register, Register), part: Part) -> bool {
        let whole = [(1.0, from)];
        let (terms, momenta) = (Terms::of(&whole), Terms::NONE);
        self.linear_on_device(&Combination { to, adds: false, part, terms, momenta })
    }

    /// Sums vectors that are on a device; whether nothing is left for the host.
    pub(super) fn linear_on_device(&mut self, combination: &Combination<'_>) -> bool {
        let Some(residency) = &self.context.residency else { return false };
        let vectors = &self.pipeline.vectors;
        vectors.check_momenta(combination);
        match lock(residency).linear(vectors, combination, self.context.lent) {
            Left::Nothing => true,
            Left::All => false,
            Left::Others => {
                // SAFETY: `Runner` is only made for a state with the layout that the vectors were made for, held exclusively.
                unsafe { vectors.linear_on_host(combination, self.context.lent, self.context.isa) };
                true
            }
        }
    }
}

impl<P: Scalar> Pipeline<P> {
    /// Passes run from now on; where columns are.
    pub(super) fn begin(&self) -> Option<Shared<P>> {
        let residency = self.residency.as_ref()?;
        lock(residency).begin();
        Some(Arc::clone(residency))
    }

    /// Brings all numbers to the host, which looks at them, or changes them.
    pub(crate) fn come_home(&self, changes: bool) {
        if let Some(residency) = &self.residency {
            lock(residency).all_on_host(changes, &[]);
        }
    }

    /// Lets columns go where they are needed: states whose rates are given on the device have their vectors there, and columns of the state
    /// know whom to ask for their numbers.
    pub(super) fn let_go(&mut self, state: &mut State<P>) {
        let Some(shared) = &self.residency else { return };
        let passes = || self.programs.iter().flat_map(|program| &program.passes);
        let mut residency = lock(shared);
        let written = |residency: &Residency<P>, what: What| {
            let column = residency.find(what)?;
            let writes = |touch: &Touch| touch.column == column && touch.access != Access::Read;
            let on_device =
                |pass: &BoundPass<P>| matches!(&pass.pass, Pass::Device(pass) if pass.touches.iter().any(writes));
            passes().any(on_device).then_some(())
        };
        // Rounding errors are kept on the host, beside the state that they are of.
        for number in (0..self.vectors.states.len()).filter(|_| !self.vectors.compensated) {
            let quantity = self.vectors.states[number].quantity;
            if written(&residency, What::Rate(quantity)).is_some() {
                self.vectors.states[number].on_device = residency.has_room(&self.vectors, number);
            }
        }
        let states = self.states();
        for id in 0..self.registry.quantities.len() {
            if self.registry.quantities[id].given || states.contains(&id) {
                residency.cannot_be_made_again(What::Quantity(id));
            }
            residency.cannot_be_made_again(What::Previous(id));
        }
        for (seat, shares) in &self.vectors.held {
            shares.iter().for_each(|(slot, _)| residency.cannot_be_made_again(What::Held(*seat, *slot)));
        }
        drop(residency);
        for (index, domain) in state.domains.iter_mut().enumerate() {
            let whats = [What::Quantity as fn(QuantityId) -> What, What::Previous];
            for (columns, what) in [&mut domain.columns, &mut domain.previous].into_iter().zip(whats) {
                for column in columns {
                    let id = self.registry.find(index, column.info.name);
                    column.away = id.and_then(|id| Residency::away(shared, what(id)));
                }
            }
        }
    }

    /// What frames move, for people.
    pub(super) fn moves(&self, state: &State<P>) -> Vec<String> {
        let passes = || self.programs.iter().flat_map(|program| &program.passes);
        if self.has_lost_device() || !passes().any(|pass| matches!(pass.pass, Pass::Device(_))) {
            return Vec::new();
        }
        let name = |id| self.registry.name(id, state);
        let what = |what| match what {
            What::Quantity(id) => name(id),
            What::Rate(id) => format!("rate of {}", name(id)),
            What::Turned(id) => format!("turn of {}", name(id)),
            What::Previous(id) => format!("previous {}", name(id)),
            What::Held(..) => "held shares".to_owned(),
            What::Work(number, id) => format!("{} in vector {number}", name(id)),
        };
        let unforeseen = || vec!["what moves in a frame depends on the numbers".to_owned()];
        let law = |law: usize| self.entries[law].label().to_owned();
        self.foresight.as_ref().map_or_else(unforeseen, |foresight| foresight.told(what, law))
    }

    /// A quantity without waiting for the device that has it.
    pub(crate) fn late(&self, id: QuantityId, step: u64, time: f64) -> Option<residency::Seen<P>> {
        lock(self.residency.as_ref()?).late(What::Quantity(id), step, time)
    }

    /// Waits for all that runs on a device.
    pub(crate) fn finish(&self) {
        if let Some(residency) = &self.residency {
            lock(residency).finish();
        }
    }

    /// Whether there was a device, and it is gone.
    pub(super) fn has_lost_device(&self) -> bool {
        self.residency.as_ref().is_some_and(|residency| lock(residency).is_lost())
    }

    /// What was moved so far.
    pub(crate) fn transfers(&self) -> Transfers {
        self.residency.as_ref().map_or_else(Transfers::default, |residency| lock(residency).moved())
    }

    /// Whether the device was lost since [`Pipeline::look_for_loss`].
    pub(crate) fn has_unseen_loss(&self) -> bool {
        self.residency.as_ref().is_some_and(|residency| lock(residency).has_unseen_loss())
    }

    /// Whether numbers have come from a device since this was last asked.
    pub(crate) fn have_returned(&self) -> bool {
        self.residency.as_ref().is_some_and(|residency| lock(residency).have_returned())
    }

    /// Whether the device was lost since this was last asked.
    pub(crate) fn look_for_loss(&self) -> bool {
        self.residency.as_ref().is_some_and(|residency| lock(residency).look_for_loss())
    }

    /// Why numbers were lost with a device, where that is so and nobody was told.
    pub(super) fn loss(&self) -> Option<String> {
        lock(self.residency.as_ref()?).loss()
    }
}
