//! Fewer operations on a block. In: the operations of a pass. Out: the same results from fewer loops: where a sum begins
//! from nothing and a row law of the same pass is the first to add to it, that law stores its share, and so does a pair law
//! that is the first in a later pass; where a law kicks and drifts, one loop does both. Never changes a bit.

use super::Pipeline;
use super::operand::Operand;
use super::plan::{Op, Placed};
use crate::law::{Mode, Part, Port, Shape};
use crate::real::Scalar;
use crate::registry::{QuantityId, Tie};

/// What a sum begins from that nothing else starts: the one number that leaves every other as it is, zeros with a minus
/// sign, too.
pub(crate) const NOTHING: f64 = -0.0;

/// Lets laws begin the sums that they are the first to add to.
pub(super) fn begin_with_laws<P: Scalar>(pass: &mut Vec<Placed>, pipeline: &Pipeline<P>) {
    let mut needless = Vec::new();
    for at in 0..pass.len() {
        let Some(starts) = starts_of_sums(pass, at, pipeline) else { continue };
        if let Op::Law { first, .. } = &mut pass[at].op {
            *first = true;
            needless.extend(starts);
        }
    }
    let mut at = 0;
    pass.retain(|_| {
        at += 1;
        !needless.contains(&(at - 1))
    });
}

/// Lets pair laws begin the sums that they are the first to add to: with few rows a pass that does nothing but begin them
/// costs as much as the pairs.
pub(super) fn begin_with_pairs<P: Scalar>(passes: &mut Vec<Vec<Placed>>, pipeline: &Pipeline<P>) {
    for at in 0..passes.len() {
        let Some(mut starts) = starts_of_pair(passes, at, pipeline) else { continue };
        if let Some(Placed { op: Op::Law { first, .. }, .. }) = passes[at].first_mut() {
            *first = true;
        }
        // From the last one, so that the others stay where they are.
        starts.sort_unstable();
        starts.into_iter().rev().for_each(|(pass, start)| _ = passes[pass].remove(start));
    }
    passes.retain(|pass| !pass.is_empty());
}

/// Where the sums of a pair law begin, by pass and operation, if all of them begin from nothing and it is the first to
/// touch them; it has to run for all rows, since they begin in all.
fn starts_of_pair<P: Scalar>(passes: &[Vec<Placed>], at: usize, pipeline: &Pipeline<P>) -> Option<Vec<(usize, usize)>> {
    let [pair] = passes[at].as_slice() else { return None };
    let Op::Law { seat, energy: false, .. } = pair.op else { return None };
    let seat = &pipeline.registry.seats[seat];
    let entry = &pipeline.entries[seat.law];
    if entry.shape != Shape::Pair || pair.rows.is_some() {
        return None;
    }
    let mut slot = 0;
    let mut starts = Vec::new();
    for port in entry.signature.ports {
        let operands = &pair.operands[slot..slot + port.property.kind.width()];
        slot += operands.len();
        if port.mode.is_input() {
            continue;
        }
        // Shares that are held are added by an operation of their own.
        let Operand::Quantity(sum, _) = operands[0] else { return None };
        let (pass, start) = passes[..at].iter().enumerate().rev().find_map(|(number, pass)| {
            let last = pass.iter().rposition(|op| touches(op, sum, pipeline))?;
            Some((number, last))
        })?;
        let begins = matches!(passes[pass][start].op, Op::Start { from: None, .. });
        if !begins || starts.contains(&(pass, start)) {
            return None;
        }
        starts.push((pass, start));
    }
    Some(starts)
}

/// Whether an operation looks at a sum, or adds to it. Shares that are held name only where they are kept.
fn touches<P: Scalar>(op: &Placed, sum: QuantityId, pipeline: &Pipeline<P>) -> bool {
    if let Op::Hold { seat } = op.op {
        let seat = &pipeline.registry.seats[seat];
        return crate::graph::outputs(&pipeline.entries[seat.law].signature, seat).any(|(_, id)| id == sum);
    }
    op.operands.iter().any(|operand| operand.quantity() == Some(sum))
}

/// A kick and the drift that follows, by one law on the same rows, as one operation.
pub(super) fn kick_and_drift(kick: &Placed, drift: &Placed) -> Option<Placed> {
    let (Op::Law { seat, part: Part::Momenta, .. }, Op::Law { seat: same, part: Part::Coordinates, advance, .. }) =
        (&kick.op, &drift.op)
    else {
        return None;
    };
    let mut joined = kick.clone();
    let Op::Law { advance: Some(_), drift: then, .. } = &mut joined.op else { return None };
    if seat != same || advance.is_none() {
        return None;
    }
    *then = *advance;
    for (slot, operand) in drift.operands.iter().enumerate().filter(|(_, operand)| **operand != Operand::Absent) {
        joined.operands[slot] = *operand;
    }
    Some(joined)
}

/// Where the sums of a row law begin in its pass, if all of them begin from nothing and it is the first to touch them.
fn starts_of_sums<P: Scalar>(pass: &[Placed], at: usize, pipeline: &Pipeline<P>) -> Option<Vec<usize>> {
    let Op::Law { seat, .. } = pass[at].op else { return None };
    let seat = &pipeline.registry.seats[seat];
    let ports = pipeline.entries[seat.law].signature.ports;
    if !pass[at].row_local || ports.iter().any(|port| port.mode == Mode::Rates) {
        return None;
    }
    let mut slot = 0;
    let there = |(port, _): &(&Port, &Tie)| {
        slot += port.property.kind.width();
        port.mode == Mode::Adds && pass[at].operands[slot - 1] != Operand::Absent
    };
    let sums = ports.iter().zip(&seat.ties).filter(there);
    let starts: Option<Vec<usize>> = sums
        .map(|(_, tie)| {
            let Tie::Quantity(sum) = *tie else { return None };
            let start = pass[..at].iter().rposition(|op| touches(op, sum, pipeline))?;
            matches!(pass[start].op, Op::Start { from: None, .. }).then_some(start)
        })
        .collect();
    starts.filter(|starts| !starts.is_empty())
}
