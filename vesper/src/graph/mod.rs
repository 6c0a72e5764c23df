//! Who runs before whom, and who need not run.
//!
//! In: seated laws. Out: [`Graph`]: an order that the declarations alone decide, the edges with the property on each,
//! levels of laws that could run together, and, for any wanted results, the laws that make them. Never: a number of a
//! column, a loop.
//!
//! Within one evaluation a property is first set, then added to, then read; a reader of the previous value stands
//! before both. Ties are broken by name, so the order of registration never shows.

mod cycle;

use crate::law::{Mode, Part, Place, Shape, Signature};
use crate::property::{Property, Role, Time};
use crate::registry::{Entry, QuantityId, Registry, Seat, Tie, computes, start_of};

use crate::error::{Fault, Faults};
use crate::real::Scalar;
use crate::state::State;

/// One law before another, and why.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Edge {
    /// The number of the seat that runs first.
    pub(crate) from: usize,
    pub(crate) to: usize,
    pub(crate) quantity: QuantityId,
    pub(crate) from_mode: Mode,
    pub(crate) to_mode: Mode,
}

/// The order of the laws.
#[derive(Clone, Debug)]
pub(crate) struct Graph {
    /// Seats in the order of one evaluation; laws that amend come last.
    pub(crate) order: Vec<usize>,
    pub(crate) edges: Vec<Edge>,
    /// For each seat, how many laws at least must have run before it.
    pub(crate) level: Vec<usize>,
}

impl Graph {
    /// Orders the laws.
    pub(crate) fn new<P: Scalar>(entries: &[Entry], registry: &Registry, state: &State<P>) -> Result<Self, Faults> {
        let edges = edges(entries, registry);
        match sort(entries, registry, &edges) {
            Ok((order, level)) => Ok(Graph { order, edges, level }),
            Err(stuck) => Err(Fault::Cycle { path: cycle::path(&stuck, &edges, entries, registry, state) }.into()),
        }
    }

    /// The seats that are needed for these quantities, in order.
    pub(crate) fn makers(&self, wanted: &[QuantityId], entries: &[Entry], registry: &Registry) -> Vec<usize> {
        self.makers_by(wanted, &|_| u64::MAX, entries, registry)
    }

    /// The same, where each seat looks only at some of its ports, one bit each.
    fn makers_by(
        &self,
        wanted: &[QuantityId],
        mask: &dyn Fn(usize) -> u64,
        entries: &[Entry],
        registry: &Registry,
    ) -> Vec<usize> {
        let mut needed = vec![false; registry.seats.len()];
        let mut open: Vec<QuantityId> = wanted.to_vec();
        let mut seen = vec![false; registry.quantities.len()];
        while let Some(quantity) = open.pop() {
            if core::mem::replace(&mut seen[quantity], true) {
                continue;
            }
            for (index, seat) in registry.seats.iter().enumerate() {
                let signature = &entries[seat.law].signature;
                if !needed[index] && outputs(signature, seat).any(|(mode, id)| id == quantity && computes(mode)) {
                    needed[index] = true;
                    open.extend(inputs(signature, seat, mask(index)));
                }
            }
            open.extend(start_of(quantity, registry));
        }
        self.order.iter().copied().filter(|&seat| needed[seat]).collect()
    }

    /// The seats that give rates of a part of the state, in order, and the quantities they need for it.
    pub(crate) fn raters(&self, part: Part, entries: &[Entry], registry: &Registry) -> (Vec<usize>, Vec<QuantityId>) {
        let mut raters = Vec::new();
        let mut needs = Vec::new();
        for &index in &self.order {
            let seat = &registry.seats[index];
            let signature = &entries[seat.law].signature;
            if let Some(mask) = wanted_inputs(signature, part) {
                raters.push(index);
                needs.extend(inputs(signature, seat, mask));
            }
        }
        (raters, needs)
    }

    /// The seats that amend, in order, and the quantities they need for it.
    pub(crate) fn amenders(&self, entries: &[Entry], registry: &Registry) -> (Vec<usize>, Vec<QuantityId>) {
        let mut amenders = Vec::new();
        let mut needs = Vec::new();
        for &index in &self.order {
            let seat = &registry.seats[index];
            let signature = &entries[seat.law].signature;
            if amends(signature) {
                amenders.push(index);
                needs.extend(inputs(signature, seat, u64::MAX));
            }
        }
        (amenders, needs)
    }

    /// A momentum that the rates of the momenta depend on: a force that depends on the velocity. `mask`: the ports that
    /// each seat looks at, one bit each.
    pub(crate) fn momenta_depend_on_momentum(
        &self,
        mask: &dyn Fn(usize) -> u64,
        entries: &[Entry],
        registry: &Registry,
    ) -> Option<QuantityId> {
        let needs = self.all_needs(Part::Momenta, mask, entries, registry);
        needs.into_iter().find(|&id| matches!(registry.quantities[id].info.role, Role::Momentum(_)))
    }

    /// What the rates of the coordinates depend on besides momenta: a coordinate, or the time.
    pub(crate) fn coordinates_depend_on(&self, entries: &[Entry], registry: &Registry) -> Option<QuantityId> {
        self.all_needs(Part::Coordinates, &|_| u64::MAX, entries, registry).into_iter().find(|&id| {
            let info = registry.quantities[id].info;
            matches!(info.role, Role::Coordinate) || info.name == Time::NAME && registry.quantities[id].domain == 0
        })
    }

    /// What the rates of a part depend on, through all laws between.
    fn all_needs(
        &self,
        part: Part,
        mask: &dyn Fn(usize) -> u64,
        entries: &[Entry],
        registry: &Registry,
    ) -> Vec<QuantityId> {
        let (_, mut needs) = self.raters(part, entries, registry);
        for seat in self.makers_by(&needs, mask, entries, registry) {
            needs.extend(inputs(&entries[registry.seats[seat].law].signature, &registry.seats[seat], mask(seat)));
        }
        needs
    }
}

/// Whether a law corrects the state after a step.
pub(crate) fn amends(signature: &Signature) -> bool {
    signature.ports.iter().any(|port| port.mode == Mode::Amends)
}

/// The ports that the law's rates of this part depend on, one bit each; `None` where it gives no such rate.
pub(crate) fn wanted_inputs(signature: &Signature, part: Part) -> Option<u64> {
    let rates = signature.ports.iter().filter(|port| port.mode == Mode::Rates && part.holds(&port.property.role));
    rates.map(|port| port.from).reduce(|one, other| one | other)
}

pub(crate) fn inputs(signature: &Signature, seat: &Seat, mask: u64) -> impl Iterator<Item = QuantityId> {
    let wanted = move |port: usize| port >= 64 || mask >> port & 1 == 1;
    let own = signature.ports.iter().zip(&seat.ties).enumerate().filter_map(move |(index, (port, tie))| match tie {
        Tie::Quantity(id) if port.mode.is_input() && wanted(index) => Some(*id),
        _ => None,
    });
    own.chain(seat.place).collect::<Vec<_>>().into_iter()
}

pub(crate) fn outputs<'a>(signature: &'a Signature, seat: &'a Seat) -> impl Iterator<Item = (Mode, QuantityId)> + 'a {
    signature.ports.iter().zip(&seat.ties).filter_map(|(port, tie)| match tie {
        Tie::Quantity(id) if !port.mode.is_input() => Some((port.mode, *id)),
        _ => None,
    })
}

fn edges(entries: &[Entry], registry: &Registry) -> Vec<Edge> {
    // Every access of every quantity: (seat, mode). A sum's start is read by whoever adds to or reads the sum.
    let mut accesses: Vec<Vec<(usize, Mode)>> = vec![Vec::new(); registry.quantities.len()];
    for (index, seat) in registry.seats.iter().enumerate() {
        let signature = &entries[seat.law].signature;
        if amends(signature) {
            continue; // after the step: it takes no part in the order of an evaluation
        }
        for (port, tie) in signature.ports.iter().zip(&seat.ties) {
            let Tie::Quantity(id) = tie else { continue };
            if port.place == Place::Scene && registry.quantities[*id].given {
                continue; // a constant
            }
            accesses[*id].push((index, port.mode));
            if let Some(start) = start_of(*id, registry) {
                accesses[start].push((index, Mode::Reads));
            }
        }
        if let Some(place) = seat.place {
            accesses[place].push((index, Mode::Reads));
        }
    }
    let mut edges = Vec::new();
    for (quantity, accesses) in accesses.iter().enumerate() {
        for &(from, from_mode) in accesses {
            for &(to, to_mode) in accesses {
                let before = match (from_mode, to_mode) {
                    (Mode::Previous, after) => computes(after),
                    (Mode::Sets, Mode::Adds | Mode::Reads) | (Mode::Adds, Mode::Reads) => true,
                    _ => false,
                };
                let edge = Edge { from, to, quantity, from_mode, to_mode };
                // A law that waits for itself closes a circle; only its own previous value is another one.
                if before && (from != to || from_mode != Mode::Previous) && !edges.contains(&edge) {
                    edges.push(edge);
                }
            }
        }
    }
    edges
}

/// Kahn's algorithm. Among the laws that are free to run, one that can share its pass with the law before goes first,
/// then the first by name: seats are sorted by name already.
fn sort(entries: &[Entry], registry: &Registry, edges: &[Edge]) -> Result<(Vec<usize>, Vec<usize>), Vec<usize>> {
    let count = registry.seats.len();
    let mut waits = vec![0; count];
    for edge in edges {
        waits[edge.to] += 1;
    }
    let mut level = vec![0; count];
    let mut order: Vec<usize> = Vec::new();
    let mut done = vec![false; count];
    let last = |seat: usize| amends(&entries[registry.seats[seat].law].signature);
    let pass = |seat: usize| {
        let seat = &registry.seats[seat];
        let entry = &entries[seat.law];
        (entry.shape == Shape::Row && entry.options.every == 1).then_some((seat.domain, &seat.rows))
    };
    while order.len() < count {
        let free = |seat: &usize| !done[*seat] && waits[*seat] == 0;
        let goes_on = |seat: &usize| match (order.last(), pass(*seat)) {
            (Some(before), Some(mine)) => pass(*before) == Some(mine),
            _ => false,
        };
        let evaluating: Vec<usize> = (0..count).filter(free).filter(|seat| !last(*seat)).collect();
        let next = evaluating
            .iter()
            .copied()
            .find(goes_on)
            // Laws that reach across rows first: then the laws of single rows, which can share a pass, stand together.
            .or_else(|| evaluating.iter().copied().find(|seat| pass(*seat).is_none()))
            .or_else(|| evaluating.first().copied())
            .or_else(|| (0..count).find(free));
        let Some(next) = next else { return Err((0..count).filter(|seat| !done[*seat]).collect()) };
        done[next] = true;
        order.push(next);
        for edge in edges.iter().filter(|edge| edge.from == next) {
            waits[edge.to] -= 1;
            level[edge.to] = level[edge.to].max(level[next] + 1);
        }
    }
    Ok((order, level))
}
