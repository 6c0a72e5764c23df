//! Finds numbers that are no numbers any more, once a frame.

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
        let Ok(column) = state.column(&domain.name, known.info.name) else { continue };
        let width = known.info.kind.width();
        let bad = match column.components() {
            // `x - x` is 0 for every finite number, and the sum of zeros tells in one pass without branches.
            Some(components) => {
                let clean = components.iter().all(|numbers| {
                    let sum = numbers.iter().fold(P::default(), |sum, &number| sum + (number - number));
                    sum == P::default()
                });
                if clean { None } else { first_bad(column, width) }
            }
            None => first_bad(column, width),
        };
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

fn first_bad<P: Scalar>(column: &crate::column::Column<P>, width: usize) -> Option<(usize, f64)> {
    (0..column.len() * width)
        .map(|k| (k / width, column.number(k / width, k % width).to_f64()))
        .find(|(_, value)| !value.is_finite())
}
