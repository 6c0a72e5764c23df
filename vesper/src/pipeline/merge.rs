//! Fewer operations on a block. In: the operations of a pass. Out: the same results from fewer loops: where a sum begins
//! from nothing and a row law of the same pass is the first to add to it, that law stores its share; where a law kicks
//! and drifts, one loop does both. Never changes a bit.

use super::Pipeline;
use super::operand::Operand;
use super::plan::{Op, Placed};
use crate::law::{Mode, Part, Port};
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
            let start = pass[..at].iter().rposition(|op| touches(op, sum))?;
            matches!(pass[start].op, Op::Start { from: None, .. }).then_some(start)
        })
        .collect();
    starts.filter(|starts| !starts.is_empty())
}

fn touches(op: &Placed, quantity: QuantityId) -> bool {
    op.operands.iter().any(|operand| matches!(*operand, Operand::Quantity(id, _) if id == quantity))
}
