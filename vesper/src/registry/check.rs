//! What a list of laws may not say, alone, against the state, and together.

use super::{Entry, Registry, Tie, computes, nearest_property, start_of};
use crate::error::Fault;
use crate::law::{Mode, Place, Port, Shape};
use crate::property::{Kind, PropertyInfo};
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
        let numbers = entry.signature.ports.iter().map(|port| port.property.kind.width()).sum();
        if numbers > crate::law::MAX_SLOTS {
            faults.push(Fault::TooWide { law: law(), numbers });
        }
        for port in entry.signature.ports {
            let fault = |allowed: &str| Fault::Shape {
                law: law(),
                does: port.mode.does().to_owned(),
                property: port.property.name.to_owned(),
                shape: entry.shape.word().to_owned(),
                allowed: allowed.to_owned(),
            };
            match (entry.shape, port.mode) {
                _ if matches!(port.property.kind, Kind::Link(_)) => {
                    faults.push(fault("a link is followed by a link law or a column law, `link(..)`"));
                }
                (Shape::Pair | Shape::Link, Mode::Sets | Mode::Rates | Mode::Amends) => {
                    faults.push(fault("it may only add; write a row law or a column law"));
                }
                (Shape::Link, Mode::Adds) if port.place == Place::Own => {
                    faults.push(fault("it adds to the rows it links to, `link(.., adds(..))`"));
                }
                (Shape::Pair | Shape::Column | Shape::Link, _) if port.place == Place::Field => {
                    faults.push(fault("fields are sampled by row laws"));
                }
                _ => {}
            }
            let known =
                faults.iter().any(|fault| matches!(fault, Fault::EveryOutput { law, .. } if law == entry.label()));
            if every > 1 && !port.mode.is_input() && port.mode != Mode::Adds && !known {
                faults.push(Fault::EveryOutput {
                    law: law(),
                    every,
                    does: port.mode.does().to_owned(),
                    property: port.property.name.to_owned(),
                });
            }
            let looks_back = |other: &Port| other.mode == Mode::Previous && other.property.name == port.property.name;
            if port.mode == Mode::Adds && entry.signature.ports.iter().any(looks_back) {
                faults.push(Fault::PreviousOfSum { law: law(), property: port.property.name.to_owned() });
            }
            if port.place == Place::Field && port.property.kind != Kind::Vector {
                let kind = port.property.kind.to_string();
                faults.push(Fault::FieldKind { field: port.property.name.to_owned(), kind });
            }
            if port.mode == Mode::Adds && !port.property.role.is_sum() {
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
    // What a client gives need not say what integrators and adding laws make of it; laws must agree.
    let mut declare =
        |info: PropertyInfo, by: String, law: bool| match known.iter().find(|(other, _)| other.name == info.name) {
            None => known.push((info, by)),
            Some((other, other_by))
                if other.kind != info.kind || other.size != info.size || law && other.role != info.role =>
            {
                let roles = law && other.role != info.role;
                let said = |info: &PropertyInfo| {
                    if roles { format!("{}, {}", info.measured(), info.role.word()) } else { info.measured() }
                };
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
            declare(port.property, format!("law {}", entry.signature.name), true);
        }
        if let Some(link) = entry.signature.link {
            declare(link, format!("law {}", entry.signature.name), true);
        }
    }
    for domain in &state.domains {
        for column in &domain.columns {
            declare(column.info, format!("domain {}", domain.name), false);
        }
    }
    for (field, _) in &state.fields {
        declare(*field, "the fields".to_owned(), false);
    }
    for (field, _) in state.fields.iter().filter(|(field, _)| field.kind != Kind::Vector) {
        let fault = Fault::FieldKind { field: field.name.to_owned(), kind: field.kind.to_string() };
        if !faults.contains(&fault) {
            faults.push(fault);
        }
    }
}

/// Faults of seated laws together.
pub(super) fn seats<P: Scalar>(entries: &[Entry], registry: &Registry, state: &State<P>, faults: &mut Vec<Fault>) {
    twice(entries, registry, state, faults);
    starts(registry, state, faults);
    let outputs: Vec<((&str, usize), &Port, usize)> = registry
        .seats
        .iter()
        .enumerate()
        .flat_map(|(number, seat)| {
            let entry = &entries[seat.law];
            entry.signature.ports.iter().zip(&seat.ties).filter_map(move |(port, tie)| match tie {
                // Adding to what is no sum is a fault of its own.
                _ if port.mode == Mode::Adds && !port.property.role.is_sum() => None,
                Tie::Quantity(id) if !port.mode.is_input() => Some(((entry.label(), number), port, *id)),
                _ => None,
            })
        })
        .collect();
    for (index, ((law, seat), port, id)) in outputs.iter().enumerate() {
        let name = || registry.name(*id, state);
        // A law that is listed twice is a fault already; so are two outputs of one law to one property.
        let others = outputs[..index].iter().filter(|((other, _), _, other_id)| other_id == id && other != law);
        let again = outputs[..index].iter().any(|((_, other), _, other_id)| other == seat && other_id == id);
        if again && port.place != Place::End {
            faults.push(Fault::OutputTwice { law: law.to_string(), property: name() });
        }
        for ((other, _), other_port, _) in others {
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
                    does: mode.does().to_owned(),
                }),
                (mode, Mode::Rates) if computes(mode) => faults.push(Fault::RateOfComputed {
                    law: two.1,
                    property: name(),
                    other: two.0,
                    does: mode.does().to_owned(),
                }),
                _ => {}
            }
        }
        if computes(port.mode) && registry.quantities[*id].given {
            faults.push(Fault::SetGiven { law: law.to_string(), does: port.mode.does().to_owned(), property: name() });
        }
    }
}

/// Sums that start from values which only some rows have.
fn starts<P: Scalar>(registry: &Registry, state: &State<P>, faults: &mut Vec<Fault>) {
    for (id, sum) in registry.quantities.iter().enumerate() {
        let Some(start) = start_of(id, registry) else { continue };
        let domain = &state.domains[sum.domain];
        let name = registry.quantities[start].info.name;
        if let Some(rows) = domain.find(name).and_then(|at| domain.columns[at].part_of(domain.rows)) {
            faults.push(Fault::SubsetStart {
                sum: registry.name(id, state),
                start: name.to_owned(),
                given: rows.len(),
                rows: domain.rows,
            });
        }
    }
}

fn twice<P: Scalar>(entries: &[Entry], registry: &Registry, state: &State<P>, faults: &mut Vec<Fault>) {
    for (index, seat) in registry.seats.iter().enumerate() {
        let same = |other: &&super::Seat| {
            other.domain == seat.domain && entries[other.law].label() == entries[seat.law].label()
        };
        if registry.seats[..index].iter().any(|other| same(&other)) {
            faults.push(Fault::LawTwice {
                law: entries[seat.law].label().to_owned(),
                domain: state.domains[seat.domain].name.clone(),
            });
        }
    }
}

/// A fault for each observed column that neither exists nor is computed by a law, were it awake.
pub(super) fn observed<P: Scalar>(
    observe: &[(String, String)],
    entries: &[Entry],
    state: &State<P>,
    faults: &mut Vec<Fault>,
) {
    let computed = |name: &str| {
        let mut ports = entries.iter().flat_map(|entry| entry.signature.ports);
        let made = |port: &Port| computes(port.mode) || port.property.role.is_sum();
        ports.any(|port| port.property.name == name && made(port))
    };
    for (domain, property) in observe {
        let Some(at) = state.domain_index(domain) else {
            faults.push(state.no_domain(domain));
            continue;
        };
        if state.domains[at].find(property).is_none() && !computed(property) {
            faults.push(Fault::NoProperty {
                domain: domain.clone(),
                property: property.clone(),
                nearest: nearest_property(state, at, property),
            });
        }
    }
}
