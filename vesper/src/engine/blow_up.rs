//! Finds numbers that are no numbers any more, once a frame, of those on a device when they come back; and, where that is asked for, the step and the first law
//! that made one.

use super::{Engine, with_runner};
use crate::column::{Aligned, Column, Storage};
use crate::error::{Fault, Faults};
use crate::integrate::{Part, System};
use crate::law::Shape;
use crate::pipeline::{Pipeline, Watch};
use crate::real::{Isa, Lanes, Scalar, WithLanes, prefetch};
use crate::state::State;
use std::sync::Arc;

/// Looks through every state that laws move. `at`: the step and the time that the state is of.
pub(super) fn check<P: Scalar>(
    pipeline: &Pipeline<P>,
    state: &State<P>,
    isa: Isa,
    (step, time): (u64, f64),
) -> Result<(), Faults> {
    let mut faults = Vec::new();
    for moved in &pipeline.vectors.states {
        let known = &pipeline.registry.quantities[moved.quantity];
        let domain = &state.domains()[known.domain];
        let Some(column) = domain.find(known.info.name).map(|at| &domain.columns[at]) else { continue };
        // What is on a device is looked at when it comes back.
        if column.is_away() {
            continue;
        }
        let Some((index, value)) = first_bad(column, known.info.kind.width(), isa) else { continue };
        let row = column.subset().map_or(index, |rows| rows[index] as usize);
        faults.push(Fault::BlowUp {
            traced: false,
            step,
            time,
            domain: domain.name.clone(),
            property: known.info.name.to_owned(),
            row,
            value,
            first: format!("{}; trace_blow_ups(true) finds the step and the law", pipeline.drivers(moved.quantity)),
        });
    }
    Faults::unless_empty(faults, ())
}

/// The first value of a column that is not finite.
fn first_bad<P: Scalar>(column: &Column<P>, width: usize, isa: Isa) -> Option<(usize, f64)> {
    let bad = |numbers: &[P]| -> Option<(usize, f64)> {
        if P::with_lanes(isa, AllFinite(numbers)) {
            return None;
        }
        numbers.iter().position(|number| !number.is_finite()).map(|at| (at, numbers[at].to_f64()))
    };
    match &column.storage {
        Storage::Split(components) => {
            components.iter().filter_map(|numbers| bad(numbers.as_slice())).min_by_key(|(row, _)| *row)
        }
        Storage::Lent(memory) => {
            let mut found = None;
            memory.look(&mut |numbers| found = bad(numbers).map(|(at, value)| (at / width, value)));
            found
        }
        Storage::Link { .. } => None,
    }
}

/// Looks for a number that is none: `x - x` is 0 for every finite number, and sums of zeros tell in one pass without
/// branches.
struct AllFinite<'a, P>(&'a [P]);

impl<P: Scalar> WithLanes<P> for AllFinite<'_, P> {
    type Output = bool;
    #[inline(always)]
    fn with<R: Lanes<P>>(self) -> bool {
        // Several sums, so that one addition need not wait for the one before.
        const SUMS: usize = 4;
        let mut sums = [R::lit(0.0); SUMS];
        let itself = |number: R| number;
        let mut chunks = self.0.chunks_exact(SUMS * R::WIDTH);
        for chunk in &mut chunks {
            // Across the end of the page, where the processor does not foresee the stream.
            prefetch(chunk.as_ptr().wrapping_byte_add(AHEAD));
            prefetch(chunk.as_ptr().wrapping_byte_add(AHEAD + size_of_val(chunk) / 2));
            for (k, sum) in sums.iter_mut().enumerate() {
                // SAFETY: a chunk has that many numbers.
                let number = unsafe { R::load(chunk.as_ptr().add(k * R::WIDTH)) };
                *sum += number - itself(number);
            }
        }
        let zero = |sum: R| (0..R::WIDTH).all(|lane| sum.lane(lane) == P::default());
        sums.into_iter().all(zero) && chunks.remainder().iter().all(|number| number.is_finite())
    }
}

/// Bytes between what is looked at and what is asked for: about what memory needs to answer.
const AHEAD: usize = 1536;

/// Everything that steps change, as it was.
#[derive(Debug)]
pub(super) struct Kept<P> {
    /// The numbers of every state that laws move.
    states: Vec<Vec<P>>,
    /// Shares of laws that are not evaluated on every step, and results that laws look back at.
    others: Vec<Vec<P>>,
    filled: Vec<bool>,
}

impl<P> Default for Kept<P> {
    fn default() -> Self {
        Kept { states: Vec::new(), others: Vec::new(), filled: Vec::new() }
    }
}

/// Results that outlive a step, besides states.
fn others<'a, P: Scalar>(
    pipeline: &'a mut Pipeline<P>,
    state: &'a mut State<P>,
) -> impl Iterator<Item = &'a mut Aligned<P>> {
    let held = pipeline.vectors.held.iter_mut().flat_map(|(_, shares)| shares.iter_mut().map(|(_, share)| share));
    let previous = state.domains.iter_mut().flat_map(|domain| &mut domain.previous);
    held.chain(previous.flat_map(|column| match &mut column.storage {
        Storage::Split(components) => components.as_mut_slice(),
        Storage::Lent(_) | Storage::Link { .. } => &mut [],
    }))
}

impl<P: Scalar> Engine<P> {
    /// Keeps the state as it is.
    pub(super) fn keep(&mut self) -> Result<(), Faults> {
        let Some(kept) = &mut self.kept else { return Ok(()) };
        self.pipeline.come_home(false);
        let moved = &self.pipeline.vectors.states;
        kept.states.resize_with(moved.len(), Vec::new);
        for (numbers, moved) in kept.states.iter_mut().zip(moved) {
            let known = &self.pipeline.registry.quantities[moved.quantity];
            let domain = &self.state.domains[known.domain];
            let width = known.info.kind.width();
            numbers.clear();
            if let Some(column) = domain.find(known.info.name).map(|at| &domain.columns[at]) {
                column.free(&domain.name, false)?;
                numbers.extend((0..column.len() * width).map(|k| column.number(k / width, k % width)));
            }
        }
        kept.filled.clone_from(&self.pipeline.vectors.filled);
        kept.others.clear();
        kept.others.extend(others(&mut self.pipeline, &mut self.state).map(|numbers| numbers.as_slice().to_vec()));
        Ok(())
    }

    /// Takes the state back to what was kept.
    fn go_back(&mut self, steps: u64) {
        let Some(kept) = &self.kept else { return };
        self.pipeline.come_home(true);
        for (numbers, moved) in kept.states.iter().zip(&self.pipeline.vectors.states) {
            let known = &self.pipeline.registry.quantities[moved.quantity];
            let domain = &mut self.state.domains[known.domain];
            let width = known.info.kind.width();
            if let Some(at) = domain.find(known.info.name) {
                for (k, number) in numbers.iter().enumerate() {
                    domain.columns[at].set_number(k / width, k % width, *number);
                }
            }
        }
        for (to, from) in others(&mut self.pipeline, &mut self.state).zip(&kept.others) {
            to.as_mut_slice().copy_from_slice(from);
        }
        self.pipeline.vectors.filled.clone_from(&kept.filled);
        self.steps = steps;
        let time = P::from_f64(self.time());
        self.state.set_time(time);
        self.restart();
    }

    /// Goes through the frame again, step by step, up to the one that blows up, and names the first law that does.
    pub(super) fn trace(&mut self, faults: Faults, first: u64, step: f64) -> Faults {
        if !faults.iter().any(|fault| matches!(fault, Fault::BlowUp { .. })) {
            return faults;
        }
        let last = self.steps;
        self.go_back(first);
        if let Err(found) = check(&self.pipeline, &self.state, self.machine.isa, (first, self.time())) {
            return reworded(found, |_| "it was so before the step: the client set it, or lent it".to_owned());
        }
        while self.steps < last {
            if let Err(borrowed) = self.keep() {
                return borrowed;
            }
            let before = self.steps;
            let Err(found) = self.take(1, step) else { continue };
            self.go_back(before);
            let law = self.first_law();
            let stable = if law.is_none() { self.stable_step().ok().flatten() } else { None };
            let limit = stable.filter(|stable| step > stable.usable).map_or_else(String::new, |stable| {
                let (name, longest) = (self.integrator.name(), stable.usable);
                format!(
                    ", and {name} is stable there up to {longest:.3e} s, or take implicit_midpoint or implicit_euler"
                )
            });
            return reworded(found, |drivers| match &law {
                Some((law, hint)) => {
                    format!(
                        "{law} is the first law whose result is not finite{hint}; the state is that before the step"
                    )
                }
                None => format!(
                    "all laws are finite at the start of the step, so {step:?} s is too long for it: {drivers}{limit}; the state \
                     is that before the step"
                ),
            });
        }
        faults
    }

    /// The first law whose result is not finite at the state as it is, and what that is often due to.
    fn first_law(&mut self) -> Option<(String, &'static str)> {
        let watch = Arc::new(Watch::default());
        let (time, step) = (self.time(), self.steps);
        let shared = (self.laws.as_slice(), self.chains.as_slice(), &self.machine);
        with_runner(&mut self.pipeline, &self.state, shared, (time, step), |runner| {
            runner.set_watch(Arc::clone(&watch));
            runner.evaluate(Part::All);
        })
        .ok()?;
        let entry = &self.laws[watch.law()?].entry;
        let hint = match entry.shape {
            Shape::Pair | Shape::Link => " (are two rows at one place?)",
            Shape::Row | Shape::Column => "",
        };
        Some((entry.label().to_owned(), hint))
    }
}

/// Traced faults, with what is known now; it is given what the fault said of the laws.
fn reworded(faults: Faults, word: impl Fn(&str) -> String) -> Faults {
    let mut all: Vec<Fault> = faults.iter().cloned().collect();
    for fault in &mut all {
        if let Fault::BlowUp { traced, first, .. } = fault {
            *traced = true;
            let drivers = first.split(';').next().unwrap_or_default();
            *first = word(drivers);
        }
    }
    Faults::unless_empty(all, ()).err().unwrap_or(faults)
}
