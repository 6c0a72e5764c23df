//! The client's memory, held while laws run on it.
//!
//! In: a state, some columns of which are the client's own. Out: a runner that has them all, or a fault for one that the
//! client still borrows. Never: a list of guards, so no allocation.

use crate::column::Storage;
use crate::error::{Fault, Faults};
use crate::pipeline::{FusedChain, Listed, Machine, Pipeline, Runner, borrowed, lent_columns};
use crate::real::Scalar;
use crate::state::State;

/// Holds all lent memory, and runs `work` with a runner on the state.
pub(super) fn with_runner<P: Scalar, T>(
    pipeline: &mut Pipeline<P>,
    state: &State<P>,
    (laws, chains, machine): (&[Listed<P>], &[FusedChain<P>], &Machine),
    (time, step): (f64, u64),
    work: impl FnOnce(&mut Runner<'_, P>) -> T,
) -> Result<T, Faults> {
    let mut result = None;
    let mut work = Some(work);
    let mut addresses = [core::ptr::null_mut(); MAX_LENT];
    hold(state, 0, &mut addresses, &mut |lent| {
        if let Some(work) = work.take() {
            let mut runner = Runner::new(pipeline, state, (laws, chains, machine), lent, (time, step));
            result = Some(work(&mut runner));
        }
    })?;
    pipeline.tell_loss()?;
    // `hold` either ran the closure or gave a fault.
    result.ok_or_else(|| Fault::Borrowed { domain: "scene".to_owned(), property: "time".to_owned() }.into())
}

/// Columns that may be lent at one time.
const MAX_LENT: usize = 64;

/// Takes hold of one lent column after the other, then goes on; all are held until it comes back. No list of guards, so
/// no allocation.
fn hold<P: Scalar>(
    state: &State<P>,
    next: usize,
    addresses: &mut [*mut P; MAX_LENT],
    then: &mut dyn FnMut(&[*mut P]),
) -> Result<(), Faults> {
    let Some((domain, column)) = lent_columns(state).nth(next) else {
        then(&addresses[..next]);
        return Ok(());
    };
    let domain = &state.domains()[domain];
    let column = &domain.columns[column];
    let Storage::Lent(memory) = &column.storage else { return Ok(()) };
    if next >= MAX_LENT {
        let (name, property) = (domain.name.as_str(), column.property().name);
        return Err(
            Fault::client_memory(name, property, "be lent", "is one column more than the 64 that can be").into()
        );
    }
    let mut inner = Ok(());
    let held = memory.hold(&mut |start, rows| {
        if rows != domain.rows {
            inner = Err(Fault::Length {
                domain: domain.name.clone(),
                property: column.property().name.to_owned(),
                given: rows,
                expected: domain.rows,
                expected_by: "as added and removed through the state".to_owned(),
            }
            .into());
            return;
        }
        addresses[next] = start;
        inner = hold(state, next + 1, addresses, then);
    });
    if held { inner } else { Err(borrowed(&domain.name, column.property().name).into()) }
}
