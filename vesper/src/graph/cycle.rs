//! Says how laws close a circle.

use super::Edge;
use crate::real::Scalar;
use crate::registry::{Entry, Registry};
use crate::state::State;

/// One circle among the laws that wait for each other, with the property on every edge:
/// "a sets bodies.p, which b reads", ..., back to the first.
pub(super) fn path<P: Scalar>(
    stuck: &[usize],
    edges: &[Edge],
    entries: &[Entry],
    registry: &Registry,
    state: &State<P>,
) -> Vec<String> {
    let Some(&start) = stuck.first() else { return Vec::new() };
    // Every law that is stuck waits for a stuck one: going back along the edges must meet a law twice.
    let mut back: Vec<(usize, Option<Edge>)> = vec![(start, None)];
    let circle = loop {
        let here = back[back.len() - 1].0;
        let Some(edge) = edges.iter().find(|edge| edge.to == here && stuck.contains(&edge.from)) else {
            return Vec::new();
        };
        back.push((edge.from, Some(*edge)));
        if let Some(first) = back[..back.len() - 1].iter().position(|(seat, _)| *seat == edge.from) {
            break back[first + 1..].iter().rev().filter_map(|(_, edge)| *edge).collect::<Vec<_>>();
        }
    };
    let label = |seat: usize| entries[registry.seats[seat].law].label();
    circle
        .iter()
        .map(|edge| {
            format!(
                "{} {} {}, which {} {}",
                label(edge.from),
                edge.from_mode.does(),
                registry.name(edge.quantity, state),
                label(edge.to),
                edge.to_mode.does()
            )
        })
        .collect()
}
