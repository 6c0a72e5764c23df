//! Momenta that forces turn without changing their magnitude. In: seated laws, some of which add to a sum of turns. Out:
//! which momenta those are, and, in a plan, the operations that give their rates without the turning, and what turns them.
//! Never: a number.
//!
//! A law that adds to a turn promises that its share of the force is one without the velocity, and velocity x its share
//! of the turn. So with the velocity zero the same law gives the first alone; and the law that makes a rate of a force
//! makes of the turn, in the force's place, by what the momentum is turned: rate = k force, so momentum' = k velocity x
//! turn = velocity x (k turn).

use super::operand::Operand;
use super::plan::{Op, Placed};
use crate::graph::{Graph, inputs};
use crate::law::{Mode, Part, Place, Port, Shape};
use crate::property::{Kind, Role};
use crate::registry::{Entry, QuantityId, Registry, Seat, Tie};

/// A momentum that is turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Turning {
    pub(crate) state: QuantityId,
    /// The seat of the law that gives its rate.
    pub(crate) rater: usize,
    /// The sum of forces, and that of turns.
    sum: QuantityId,
    turn: QuantityId,
    /// What is turned: the momentum itself, or a velocity along it.
    pub(crate) by: QuantityId,
}

/// What one law adds to a force by turning.
struct Share {
    sum: QuantityId,
    turn: QuantityId,
    by: QuantityId,
}

impl Share {
    /// The first one of a seat.
    fn of(entry: &Entry, seat: &Seat, registry: &Registry) -> Option<Share> {
        let ports = || entry.signature.ports.iter().zip(&seat.ties);
        let quantity = |tie: &Tie| if let Tie::Quantity(id) = tie { Some(*id) } else { None };
        let adds = |port: &Port| entry.shape == Shape::Row && port.mode == Mode::Adds && port.place == Place::Own;
        ports().filter(|(port, _)| adds(port)).find_map(|(port, tie)| {
            let Role::Turn { of, by } = port.property.role else { return None };
            let mut sums = ports().filter(|(port, _)| adds(port) && port.property.name == of);
            let sum = sums.find_map(|(_, tie)| quantity(tie))?;
            Some(Share { sum, turn: quantity(tie)?, by: registry.find(seat.domain, by)? })
        })
    }
}

/// Whether a port of a law that turns is the velocity that it turns.
fn is_turned(port: &Port, entry: &Entry) -> bool {
    let turns = |other: &Port| matches!(other.property.role, Role::Turn { by, .. } if other.mode == Mode::Adds && by == port.property.name);
    entry.shape == Shape::Row
        && port.mode == Mode::Reads
        && port.place == Place::Own
        && entry.signature.ports.iter().any(turns)
}

/// The ports that a seat looks at, one bit each, where the turning is left out.
pub(crate) fn without_turning(entry: &Entry) -> u64 {
    let turned = entry.signature.ports.iter().take(64).enumerate().filter(|(_, port)| is_turned(port, entry));
    !turned.map(|(number, _)| 1 << number).sum::<u64>()
}

/// The momenta that are turned; none where a turned force goes another way than into their rates, so that the turning
/// cannot be told from the rest.
pub(crate) fn turnings(entries: &[Entry], registry: &Registry, graph: &Graph) -> Vec<Turning> {
    let shares: Vec<Share> =
        registry.seats.iter().filter_map(|seat| Share::of(&entries[seat.law], seat, registry)).collect();
    let mut turnings = Vec::new();
    for (rater, seat) in registry.seats.iter().enumerate().filter(|(_, seat)| entries[seat.law].shape == Shape::Row) {
        let signature = &entries[seat.law].signature;
        for (port, tie) in signature.ports.iter().zip(&seat.ties) {
            let (Mode::Rates, Role::Momentum(_), Kind::Vector, Tie::Quantity(state)) =
                (port.mode, port.property.role, port.property.kind, tie)
            else {
                continue;
            };
            let mut read = inputs(signature, seat, port.from);
            if let Some(share) = read.find_map(|id| shares.iter().find(|share| share.sum == id)) {
                turnings.push(Turning { state: *state, rater, sum: share.sum, turn: share.turn, by: share.by });
            }
        }
    }
    let (raters, needs) = graph.raters(Part::Momenta, entries, registry);
    let mut looking = graph.makers(&needs, entries, registry);
    looking.extend(raters);
    let elsewhere = looking.into_iter().any(|index| {
        let seat = &registry.seats[index];
        inputs(&entries[seat.law].signature, seat, u64::MAX).any(|id| {
            let turned = shares.iter().any(|share| share.sum == id);
            turned && !turnings.iter().any(|turning| turning.rater == index && turning.sum == id)
        })
    });
    if elsewhere { Vec::new() } else { turnings }
}

/// Takes the velocity of a law that turns as zero.
pub(super) fn hold_still(op: &mut Placed, entry: &Entry) {
    let slots = entry.signature.slots();
    for (number, _) in entry.signature.ports.iter().enumerate().filter(|(_, port)| is_turned(port, entry)) {
        op.operands[slots[number]..slots[number + 1]].fill(Operand::Zero);
    }
}

/// The law that gives rates of forces, once more: of turns, in the place of forces.
pub(super) fn turned(op: &Placed, turning: &Turning) -> Placed {
    let operand = |operand: &Operand| match *operand {
        Operand::Quantity(id, component) if id == turning.sum => Operand::Quantity(turning.turn, component),
        // Other rates of the same law go there too, and nobody looks at them.
        Operand::Rate(id, component) => Operand::Turned(id, component),
        other => other,
    };
    debug_assert!(matches!(op.op, Op::Law { .. }), "only laws give rates");
    Placed { operands: op.operands.iter().map(operand).collect(), ..op.clone() }
}
