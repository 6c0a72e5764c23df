//! What a list of laws may not say, alone, against the state, and together.

use super::{Entry, Registry, Tie, computes, nearest_property};
use crate::error::Fault;
use crate::law::{Mode, Place, Port, Shape};
use crate::property::{PropertyInfo, Role};
use crate::real::Scalar;
use crate::state::State;

/// Faults of single entries.
pub(super) fn entries(entries: &[Entry]) -> Vec<Fault> {
    let mut faults = Vec::new();
    for entry in entries {
        let law = || entry.label().to_owned();
        let every = entry.options.every;
        if every == 0 {
            faults.push(Fault::Every { law: law(), every });
        }
        for port in entry.signature.ports {
            let fault = |allowed: &str| Fault::Shape {
                law: law(),
                does: port.mode.word().to_owned(),
                property: port.property.name.to_owned(),
                shape: entry.shape.word().to_owned(),
                allowed: allowed.to_owned(),
            };
            match (entry.shape, port.mode) {
                (Shape::Pair | Shape::Link, Mode::Sets | Mode::Rates | Mode::Amends) => {
                    faults.push(fault("it may only add; write a row law or a column law"));
                }
                (Shape::Link, Mode::Adds) if port.place == Place::Own => {
                    faults.push(fault("it adds to the rows it links to, `link(.., adds(..))`"));
                }
                (Shape::Pair, _) if port.place == Place::Field => {
                    faults.push(fault("fields are sampled by row laws"));
                }
                (Shape::Column | Shape::Link, _) if port.place == Place::Field => {
                    faults.push(fault("fields are sampled by row laws"));
                }
                _ => {}
            }
            if every > 1 && !port.mode.is_input() && port.mode != Mode::Adds {
                faults.push(Fault::EveryOutput {
                    law: law(),
                    every,
                    does: port.mode.word().to_owned(),
                    property: port.property.name.to_owned(),
                });
            }
            if port.mode == Mode::Adds && !matches!(port.property.role, Role::Sum { .. }) {
                faults.push(Fault::AddToPlain { law: law(), property: port.property.name.to_owned() });
            }
        }
        if (entry.shape == Shape::Link) != entry.signature.link.is_some() && entry.shape != Shape::Column {
            faults.push(Fault::Shape {
                law: law(),
                does: "follows".to_owned(),
                property: entry.signature.link.map_or("no link", |link| link.name).to_owned(),
                shape: entry.shape.word().to_owned(),
                allowed: "a link law, and only a link law, declares `link(..)`".to_owned(),
            });
        }
    }
    faults
}

/// One property must mean one thing: every declaration of a name agrees with every other, and with the columns.
pub(super) fn declarations<P: Scalar>(entries: &[Entry], state: &State<P>, faults: &mut Vec<Fault>) {
    let mut known: Vec<(PropertyInfo, String)> = Vec::new();
    let mut declare = |info: PropertyInfo, by: String| match known.iter().find(|(other, _)| other.name == info.name) {
        None => known.push((info, by)),
        Some((other, other_by)) if other.kind != info.kind || other.size != info.size => {
            let fault = Fault::Declared {
                property: info.name.to_owned(),
                one: said(other),
                one_by: other_by.clone(),
                other: said(&info),
                other_by: by,
            };
            if !faults.contains(&fault) {
                faults.push(fault);
            }
        }
        Some(_) => {}
    };
    for entry in entries.iter().filter(|entry| entry.options.enabled) {
        for port in entry.signature.ports {
            declare(port.property, format!("law {}", entry.signature.name));
        }
        if let Some(link) = entry.signature.link {
            declare(link, format!("law {}", entry.signature.name));
        }
    }
    for domain in &state.domains {
        for column in &domain.columns {
            declare(column.info, format!("domain {}", domain.name));
        }
    }
    for (field, _) in &state.fields {
        declare(*field, "the fields".to_owned());
    }
}

fn said(info: &PropertyInfo) -> String {
    if info.unit.is_empty() { info.kind.to_string() } else { format!("{} [{}]", info.kind, info.unit) }
}

/// Faults of seated laws together.
pub(super) fn seats<P: Scalar>(entries: &[Entry], registry: &Registry, state: &State<P>, faults: &mut Vec<Fault>) {
    twice(entries, registry, state, faults);
    let outputs: Vec<(&str, &Port, usize)> = registry
        .seats
        .iter()
        .flat_map(|seat| {
            let entry = &entries[seat.law];
            entry.signature.ports.iter().zip(&seat.ties).filter_map(move |(port, tie)| match tie {
                Tie::Quantity(id) if !port.mode.is_input() => Some((entry.label(), port, *id)),
                _ => None,
            })
        })
        .collect();
    for (index, (law, port, id)) in outputs.iter().enumerate() {
        let name = || registry.name(*id, state);
        for (other, other_port, _) in outputs[..index].iter().filter(|(_, _, other)| other == id) {
            let two = (other.to_string(), law.to_string());
            match (other_port.mode, port.mode) {
                (Mode::Sets, Mode::Sets) => faults.push(Fault::TwoSet { law: two.0, other: two.1, property: name() }),
                (Mode::Rates, Mode::Rates) => {
                    faults.push(Fault::TwoRates { law: two.0, other: two.1, property: name() });
                }
                (Mode::Rates, mode) if computes(mode) => faults.push(Fault::RateOfComputed {
                    law: two.0,
                    property: name(),
                    other: two.1,
                    does: mode.word().to_owned(),
                }),
                (mode, Mode::Rates) if computes(mode) => faults.push(Fault::RateOfComputed {
                    law: two.1,
                    property: name(),
                    other: two.0,
                    does: mode.word().to_owned(),
                }),
                _ => {}
            }
        }
        if computes(port.mode) && registry.quantities[*id].given {
            faults.push(Fault::SetGiven { law: law.to_string(), property: name() });
        }
    }
}

fn twice<P: Scalar>(entries: &[Entry], registry: &Registry, state: &State<P>, faults: &mut Vec<Fault>) {
    for (index, seat) in registry.seats.iter().enumerate() {
        let same = |other: &&super::Seat| {
            other.domain == seat.domain
                && entries[other.law].signature.name == entries[seat.law].signature.name
                && entries[other.law].label() == entries[seat.law].label()
        };
        if registry.seats[..index].iter().any(|other| same(&other)) {
            faults.push(Fault::LawTwice {
                law: entries[seat.law].label().to_owned(),
                domain: state.domains[seat.domain].name.clone(),
            });
        }
    }
}

/// The observed columns that exist or that a law computes; a fault for each other one.
pub(crate) fn observed<P: Scalar>(
    observe: &[(String, String)],
    registry: &Registry,
    state: &State<P>,
    faults: &mut Vec<Fault>,
) -> Vec<usize> {
    let mut found = Vec::new();
    for (domain, property) in observe {
        let Some(at) = state.domain_index(domain) else {
            faults.push(state.no_domain(domain));
            continue;
        };
        if let Some(id) = registry.find(at, property) {
            found.push(id);
        } else if state.domains[at].find(property).is_none() {
            faults.push(Fault::NoProperty {
                domain: domain.clone(),
                property: property.clone(),
                nearest: nearest_property(state, at, property),
            });
        }
    }
    found
}
