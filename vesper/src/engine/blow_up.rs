//! Finds numbers that are no numbers any more, once a frame; and, where that is asked for, the step and the first law
//! that made one.

use super::{Engine, with_runner};
use crate::column::Storage;
use crate::error::{Fault, Faults};
use crate::integrate::{Part, System};
use crate::pipeline::{Pipeline, Watch};
use crate::real::{Isa, Lanes, Scalar, WithLanes, prefetch};
use crate::state::State;
use std::sync::Arc;

/// Looks through every state that laws move.
pub(super) fn check<P: Scalar>(
    pipeline: &Pipeline<P>,
    state: &State<P>,
    isa: Isa,
    step: u64,
    time: f64,
) -> Result<(), Faults> {
    let mut faults = Vec::new();
    for moved in &pipeline.vectors.states {
        let known = &pipeline.registry.quantities[moved.quantity];
        let domain = &state.domains()[known.domain];
        let Some(column) = domain.find(known.info.name).map(|at| &domain.columns[at]) else { continue };
        let clean = match &column.storage {
            Storage::Split(components) => {
                components.iter().all(|numbers| P::with_lanes(isa, AllFinite(numbers.as_slice())))
            }
            Storage::Lent(_) | Storage::Link { .. } => false,
        };
        let bad = if clean { None } else { first_bad(column, known.info.kind.width()) };
        let Some((index, value)) = bad else { continue };
        let row = column.subset().map_or(index, |rows| rows[index] as usize);
        faults.push(Fault::BlowUp {
            step,
            time,
            domain: domain.name.clone(),
            property: known.info.name.to_owned(),
            row,
            value,
            first: pipeline.drivers(moved.quantity),
        });
    }
    Faults::unless_empty(faults, ())
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

fn first_bad<P: Scalar>(column: &crate::column::Column<P>, width: usize) -> Option<(usize, f64)> {
    (0..column.len() * width)
        .map(|k| (k / width, column.number(k / width, k % width).to_f64()))
        .find(|(_, value)| !value.is_finite())
}

/// The numbers of every state that laws move, one list for each.
pub(super) type Kept<P> = Vec<Vec<P>>;

impl<P: Scalar> Engine<P> {
    /// Keeps the state as it is.
    pub(super) fn keep(&mut self) {
        let Some(kept) = &mut self.kept else { return };
        let moved = &self.pipeline.vectors.states;
        kept.resize_with(moved.len(), Vec::new);
        for (numbers, moved) in kept.iter_mut().zip(moved) {
            let known = &self.pipeline.registry.quantities[moved.quantity];
            let domain = &self.state.domains[known.domain];
            let width = known.info.kind.width();
            numbers.clear();
            if let Some(column) = domain.find(known.info.name).map(|at| &domain.columns[at]) {
                numbers.extend((0..column.len() * width).map(|k| column.number(k / width, k % width)));
            }
        }
    }

    /// Takes the state back to what was kept.
    fn go_back(&mut self, steps: u64) {
        for (numbers, moved) in self.kept.iter().flatten().zip(&self.pipeline.vectors.states) {
            let known = &self.pipeline.registry.quantities[moved.quantity];
            let domain = &mut self.state.domains[known.domain];
            let width = known.info.kind.width();
            if let Some(at) = domain.find(known.info.name) {
                for (k, number) in numbers.iter().enumerate() {
                    domain.columns[at].set_number(k / width, k % width, *number);
                }
            }
        }
        self.steps = steps;
        let time = P::from_f64(self.time());
        self.state.set_time(time);
        self.integrator.restart();
    }

    /// Goes through the frame again, step by step, up to the one that blows up, and names the first law that does.
    pub(super) fn trace(&mut self, faults: Faults, first: u64, step: f64) -> Faults {
        if !faults.iter().any(|fault| matches!(fault, Fault::BlowUp { .. })) {
            return faults;
        }
        let last = self.steps;
        self.go_back(first);
        while self.steps < last {
            self.keep();
            let before = self.steps;
            let Err(found) = self.take(1, step) else { continue };
            self.go_back(before);
            let law = self.first_law();
            let renamed = found.iter().cloned().map(|fault| match (fault, &law) {
                (Fault::BlowUp { step, time, domain, property, row, value, .. }, Some(law)) => {
                    let first =
                        format!("{law} is the first law whose result is not finite; the state is that before the step");
                    Fault::BlowUp { step, time, domain, property, row, value, first }
                }
                (Fault::BlowUp { step: number, time, domain, property, row, value, first }, None) => {
                    let first = format!(
                        "all laws are finite at the start of the step, so {step} s is too long for it: {first}; \
                         the state is that before the step"
                    );
                    Fault::BlowUp { step: number, time, domain, property, row, value, first }
                }
                (other, _) => other,
            });
            return Faults::unless_empty(renamed.collect(), ()).err().unwrap_or(found);
        }
        faults
    }

    /// The first law whose result is not finite at the state as it is.
    fn first_law(&mut self) -> Option<String> {
        let watch = Arc::new(Watch::default());
        let (time, step) = (self.time(), self.steps);
        let shared = (self.laws.as_slice(), self.chains.as_slice(), &self.machine);
        with_runner(&mut self.pipeline, &self.state, shared, (time, step), |runner| {
            runner.context.watch = Some(Arc::clone(&watch));
            runner.evaluate(Part::All);
        })
        .ok()?;
        watch.law().map(|law| self.laws[law].entry.label().to_owned())
    }
}
