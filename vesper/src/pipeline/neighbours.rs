//! Keeps the lists of neighbours of a pair law that ends at a distance, and runs it over them. In: a pass that is tied to a state.
//! Out: sums in their columns, or an energy. Never: a search for neighbours, or a body.

use super::bind::PairPass;
use super::run::Context;
use super::threads::in_parts;
use crate::backend::{ListReach, Lists, PairCall, Unfit, box_slot, distance_slot};
use crate::column::Aligned;
use crate::law::{Place, Signature};
use crate::property::{PeriodicBox, Property};
use crate::real::Scalar;
use core::ops::Range;

/// Rows from which on lists are looked at: fewer meet each other sooner.
const MANY: usize = 256;
/// Evaluations after which lists are tried again that did not pay.
const LATER: u32 = 32;
/// Evaluations that lists of a dense fluid hold for.
const HOLDS: f64 = 10.0;
/// Rows from which on threads copy to the entries.
const PARALLEL_ENTRIES: usize = super::bind::PARALLEL_ROWS;

/// What a pass keeps for a law with a cut-off.
pub(crate) struct Neighbours<P: Scalar> {
    cutoff: f64,
    square: P,
    /// The first slot of the coordinate that distances are taken of, and of the lengths of a periodic box.
    place: usize,
    lengths_at: Option<usize>,
    /// The slots of rows that the law reads, one bit each.
    read: u64,
    lengths: [f64; 3],
    lists: Option<Lists<P>>,
    /// Numbers of the entries, by slot; none where rows are their own entries.
    entries: Vec<Aligned<P>>,
    slots: Vec<*mut P>,
    /// Whether lists are less work than all pairs, as they were made last; and evaluations before they are tried again.
    pays: bool,
    later: u32,
}

// SAFETY: its pointers are into its own memory, and those of the pass that owns it.
unsafe impl<P: Scalar> Send for Neighbours<P> {}

impl<P: Scalar> Neighbours<P> {
    /// For a law with a cut-off of this length; `None` for one without.
    pub(super) fn new(signature: &Signature, parameters: &[f64]) -> Option<Self> {
        let cutoff = *parameters.get(signature.cutoff?)?;
        let slots = signature.slots();
        let of_rows = signature.ports.iter().zip(slots.windows(2)).filter(|(port, _)| port.mode.is_input());
        let of_rows = of_rows.filter(|(port, _)| port.place == Place::Own).flat_map(|(_, at)| at[0]..at[1]);
        Some(Neighbours {
            cutoff,
            square: P::from_f64(cutoff) * P::from_f64(cutoff),
            place: distance_slot(signature.ports)?,
            lengths_at: box_slot(signature.ports),
            read: of_rows.filter(|slot| *slot < 64).fold(0, |read, slot| read | 1 << slot),
            lengths: [0.0; 3],
            lists: None,
            entries: Vec::new(),
            slots: Vec::new(),
            pays: true,
            later: 0,
        })
    }

    /// The square of the cut-off.
    pub(super) fn square(&self) -> P {
        self.square
    }

    /// Why nothing would be near, with a box of these lengths.
    fn unfit(&self, lengths: [f64; 3]) -> Option<String> {
        Lists::<P>::new(ListReach::new(self.cutoff, lengths)).err().map(|unfit| unfit.to_string())
    }

    /// Whether there is a direction in which everything comes again.
    fn is_periodic(&self) -> bool {
        self.lengths.iter().any(|length| *length != 0.0 && *length != f64::INFINITY)
    }
}

/// What is wrong with a law's cut-off: its unit, its length, or the box.
pub(super) fn fault<P: Scalar>(pass: &PairPass<P>, signature: &Signature) -> Option<String> {
    let near = pass.near.as_ref()?;
    let mut components = 0;
    let said = signature.parameters.iter().find(|parameter| {
        components += parameter.width;
        Some(components) > signature.cutoff
    })?;
    let coordinate = signature.slots().iter().position(|slot| *slot == near.place)?;
    let coordinate = signature.ports[coordinate].property;
    if said.unit != coordinate.unit {
        let (name, unit) = (said.name, said.unit);
        return Some(format!(
            "{name} is in {unit}, and {} in {}: declare it in that unit",
            coordinate.name, coordinate.unit
        ));
    }
    let lengths = lengths(near, &pass.slots);
    if lengths != [0.0; 3] && coordinate.unit != PeriodicBox::INFO.unit {
        let unit = PeriodicBox::INFO.unit;
        return Some(format!(
            "{} is in {}, and the periodic box in {unit}: declare it in that unit",
            coordinate.name, coordinate.unit
        ));
    }
    near.unfit(lengths)
}

/// The lengths of the box as they are now.
fn lengths<P: Scalar>(near: &Neighbours<P>, slots: &[*mut P]) -> [f64; 3] {
    near.lengths_at.map_or([0.0; 3], |slot| {
        // SAFETY: a constant of the scene, or its default, has a number for each slot.
        [0, 1, 2].map(|side| unsafe { (*slots[slot + side]).to_f64() })
    })
}

/// The rows' coordinates, from slot `place` on.
pub(super) fn places<'a, P: Scalar>(slots: &[*mut P], place: usize, rows: usize) -> [&'a [P]; 3] {
    // SAFETY: a pass has a number for each row of what its law reads, and nobody changes it while laws are evaluated.
    [0, 1, 2].map(|side| unsafe { core::slice::from_raw_parts(slots[place + side], rows) })
}

/// Has lists of neighbours for the rows where they are, if the law ends at a distance and lists pay.
pub(super) fn follow<P: Scalar>(pass: &mut PairPass<P>, context: &Context<'_, P>) -> bool {
    let Some(near) = &mut pass.near else { return false };
    let lengths = lengths(near, &pass.slots);
    if lengths != near.lengths {
        (near.lengths, near.lists, near.later) = (lengths, None, 0);
    }
    // Only lists find images.
    let free = !near.is_periodic();
    if free && (pass.rows < MANY || near.later > 0) {
        near.later = near.later.saturating_sub(1);
        return false;
    }
    let places = places(&pass.slots, near.place, pass.rows);
    let isa = context.isa;
    if near.lists.as_mut().is_some_and(|lists| lists.follow(isa, places)) {
        // They hold.
    } else if let Err(unfit) = build(near, places, pass.threads, context) {
        let label = context.laws[pass.law].entry.label();
        log::error!("{label}: {unfit}");
        near.later = LATER;
        return !free;
    }
    if free && !near.pays {
        near.later = LATER;
        return false;
    }
    fill(pass, context);
    true
}

fn build<P: Scalar>(
    near: &mut Neighbours<P>,
    places: [&[P]; 3],
    threads: usize,
    context: &Context<'_, P>,
) -> Result<(), Unfit> {
    let mut lists = match near.lists.take() {
        Some(lists) => lists,
        None => Lists::new(ListReach::new(near.cutoff, near.lengths))?,
    };
    lists.build(context.isa, places, &|parts, work| {
        // SAFETY: the work may be shared, as its type says.
        unsafe { in_parts(context, threads, parts, 1, work) };
    })?;
    near.pays = lists.pays(HOLDS);
    near.lists = Some(lists);
    Ok(())
}

/// Brings what the law reads to the entries.
fn fill<P: Scalar>(pass: &mut PairPass<P>, context: &Context<'_, P>) {
    let Some(near) = &mut pass.near else { return };
    let Some(lists) = &near.lists else { return };
    near.slots.clear();
    near.slots.extend(&pass.slots);
    if lists.is_plain() {
        return;
    }
    let count = lists.entries();
    near.entries.resize_with(pass.slots.len(), || Aligned::zeros(0, 0));
    let read = near.read;
    let there = |slot: usize, from: *mut P| slot < 64 && read >> slot & 1 == 1 && !from.is_null();
    for slot in (0..pass.slots.len()).filter(|slot| there(*slot, pass.slots[*slot])) {
        if near.entries[slot].as_slice().len() != count {
            near.entries[slot].resize(count);
        }
        near.slots[slot] = near.entries[slot].pointer();
    }
    let threads = if pass.rows >= PARALLEL_ENTRIES { pass.threads } else { 1 };
    let (slots, place) = (&near.slots, near.place);
    let bring = |rows: Range<usize>| {
        let entries = lists.entries_of(rows.clone());
        // SAFETY: there is a number for each entry, and parts are of different rows, whose entries are different ones.
        let of =
            |slot: usize| unsafe { core::slice::from_raw_parts_mut(slots[slot].add(entries.start), entries.len()) };
        lists.place(rows.clone(), [of(place), of(place + 1), of(place + 2)]);
        for (slot, from) in pass.slots.iter().enumerate().filter(|(slot, from)| there(*slot, **from)) {
            if !(place..place + 3).contains(&slot) {
                // SAFETY: a pass has a number for each row of what its law reads.
                let from = unsafe { core::slice::from_raw_parts(from.add(rows.start), rows.len()) };
                lists.spread(rows.clone(), from, of(slot));
            }
        }
    };
    // SAFETY: as above.
    unsafe { in_parts(context, threads, pass.rows, 1024, bring) };
}

/// Runs the law over the lists that [`follow`] has made.
pub(super) fn run<P: Scalar>(pass: &PairPass<P>, context: &Context<'_, P>) {
    let Some(near) = &pass.near else { return };
    let Some(lists) = &near.lists else { return lose(pass) };
    let call = PairCall { slots: &near.slots, ..pass.all() };
    let isa = context.isa;
    // SAFETY: the slots have a number for every entry of what the law reads, and for every row of what it adds to; each row is in
    // one cluster.
    unsafe {
        in_parts(context, pass.threads, lists.clusters(), 8, |clusters| {
            pass.kernel.run_listed(isa, &call, lists, clusters);
        });
    };
}

/// The energy of all pairs within the cut-off.
pub(super) fn energy<P: Scalar>(pass: &PairPass<P>) -> Option<f64> {
    let near = pass.near.as_ref()?;
    let Some(lists) = &near.lists else { return Some(f64::NAN) };
    // SAFETY: as in `run`.
    unsafe { pass.kernel.energy_listed(&PairCall { slots: &near.slots, ..pass.all() }, lists) }
}

/// Where a periodic box has no lists, there are no sums: they are no numbers, so that the run ends.
fn lose<P: Scalar>(pass: &PairPass<P>) {
    let first = pass.slots.len() - pass.kernel.added();
    for start in pass.slots[first..].iter().filter(|start| !start.is_null()) {
        // SAFETY: a pass has a number for each row of what its law adds to.
        unsafe { core::slice::from_raw_parts_mut(*start, pass.rows) }.fill(P::from_f64(f64::NAN));
    }
}
