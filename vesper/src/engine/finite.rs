//! Finds numbers that are no numbers any more, once a frame.

use crate::column::Storage;
use crate::error::{Fault, Faults};
use crate::pipeline::Pipeline;
use crate::real::Scalar;
use crate::state::State;

/// Looks through every state that laws move.
pub(super) fn check<P: Scalar>(pipeline: &Pipeline<P>, state: &State<P>, step: u64, time: f64) -> Result<(), Faults> {
    let mut faults = Vec::new();
    for moved in &pipeline.vectors.states {
        let known = &pipeline.registry.quantities[moved.quantity];
        let domain = &state.domains()[known.domain];
        let Some(column) = domain.find(known.info.name).map(|at| &domain.columns[at]) else { continue };
        let clean = match &column.storage {
            Storage::Split(components) => components.iter().all(|numbers| all_finite(numbers.as_slice())),
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

/// `x - x` is 0 for every finite number, and sums of zeros in a few lanes tell in one pass without branches.
fn all_finite<P: Scalar>(numbers: &[P]) -> bool {
    let mut sums = [P::default(); 16];
    let itself = |number: P| number;
    let (chunks, rest) = numbers.as_chunks::<16>();
    for chunk in chunks {
        for (sum, &number) in sums.iter_mut().zip(chunk) {
            *sum += number - itself(number);
        }
    }
    sums.iter().all(|sum| *sum == P::default()) && rest.iter().all(|number| number.is_finite())
}

fn first_bad<P: Scalar>(column: &crate::column::Column<P>, width: usize) -> Option<(usize, f64)> {
    (0..column.len() * width)
        .map(|k| (k / width, column.number(k / width, k % width).to_f64()))
        .find(|(_, value)| !value.is_finite())
}
