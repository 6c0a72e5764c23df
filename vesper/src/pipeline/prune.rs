//! Laws whose results nobody looks at. In: the order of the laws, and what is observed. Out: their status in the report.
//! Never: a plan; those leave out such laws by themselves.

use crate::error::counted;
use crate::graph::Graph;
use crate::law::{Part, Shape};
use crate::real::Scalar;
use crate::registry::{Entry, QuantityId, Registry, Status};
use crate::state::State;

/// Notes in the report which laws nobody needs, and what that saves.
pub(crate) fn prune<P: Scalar>(
    entries: &[Entry],
    registry: &mut Registry,
    graph: &Graph,
    observed: &[QuantityId],
    state: &State<P>,
) {
    let (raters, mut needs) = graph.raters(Part::All, entries, registry);
    let (amenders, more) = graph.amenders(entries, registry);
    needs.extend(more);
    needs.extend(observed);
    let makers = graph.makers(&needs, entries, registry);
    let mut pruned = Vec::new();
    for (index, seat) in registry.seats.iter().enumerate() {
        if raters.contains(&index) || amenders.contains(&index) || makers.contains(&index) {
            continue;
        }
        let results: Vec<String> =
            crate::graph::outputs(&entries[seat.law].signature, seat).map(|(_, id)| registry.name(id, state)).collect();
        let rows = seat.rows.as_ref().map_or(state.domains[seat.domain].rows, Vec::len);
        let saving = match entries[seat.law].shape {
            Shape::Pair => format!("{} pairs", rows * rows.saturating_sub(1) / 2),
            Shape::Row | Shape::Link | Shape::Column => counted(rows, "row"),
        };
        pruned.push((seat.law, Status::Pruned { results, saving }));
    }
    for (law, status) in pruned {
        registry.report.laws[law].status = status;
    }
}
