//! Which domain a law stands on, whether it has its data there, and on which rows it runs.

use super::{Entry, Missing, Quantity, Tie, link_target, nearest_property};
use crate::domain::SCENE;
use crate::error::{Fault, nearest};
use crate::law::{Mode, Place, Port, Shape};
use crate::property::{Property, PropertyInfo, Role};
use crate::real::Scalar;
use crate::state::State;

/// Where the laws of a list stand.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub(super) domains: Vec<Option<usize>>,
    pub(super) targets: Vec<Option<usize>>,
    pub(super) awake: Vec<bool>,
    pub(super) missing: Vec<Vec<Missing>>,
    /// Properties that laws which are awake set.
    provided: Vec<(usize, &'static str)>,
}

impl Placed {
    /// Whether a domain has values of a property: given, a sum, or set by a law that is awake.
    pub(super) fn has<P: Scalar>(&self, domain: usize, property: &PropertyInfo, state: &State<P>) -> bool {
        given(state, domain, property.name).is_some()
            || matches!(property.role, Role::Sum { .. })
            || self.provided.contains(&(domain, property.name))
    }
}

/// The column of a property that the client gave.
fn given<P: Scalar>(state: &State<P>, domain: usize, property: &str) -> Option<usize> {
    let columns = &state.domains[domain].columns;
    state.domains[domain].find(property).filter(|&at| columns[at].given)
}

/// Places every enabled law, then puts to sleep, until nothing changes, those that lack something.
pub(super) fn place<P: Scalar>(entries: &[Entry], state: &State<P>, faults: &mut Vec<Fault>) -> Placed {
    let domains: Vec<Option<usize>> = entries.iter().map(|entry| domain(entry, entries, state, faults)).collect();
    let targets = entries
        .iter()
        .zip(&domains)
        .map(|(entry, domain)| link_target(state, (*domain)?, entry.signature.link.as_ref()?))
        .collect();
    let awake = entries.iter().zip(&domains).map(|(entry, domain)| entry.options.enabled && domain.is_some()).collect();
    let missing = vec![Vec::new(); entries.len()];
    let mut placed = Placed { domains, targets, awake, missing, provided: Vec::new() };
    loop {
        placed.provided = provided(entries, &placed);
        let lacking: Vec<usize> = (0..entries.len())
            .filter(|&law| placed.awake[law] && !missing_of(law, entries, &placed, state).is_empty())
            .collect();
        if lacking.is_empty() {
            break;
        }
        for law in lacking {
            placed.awake[law] = false;
        }
    }
    for (law, entry) in entries.iter().enumerate() {
        if entry.options.enabled && !placed.awake[law] {
            placed.missing[law] = missing_of(law, entries, &placed, state);
        }
    }
    placed
}

fn provided(entries: &[Entry], placed: &Placed) -> Vec<(usize, &'static str)> {
    let mut provided = Vec::new();
    for (law, entry) in entries.iter().enumerate().filter(|(law, _)| placed.awake[*law]) {
        for port in entry.signature.ports.iter().filter(|port| port.mode == Mode::Sets) {
            let on = if port.place == Place::End { placed.targets[law] } else { placed.domains[law] };
            provided.extend(on.map(|on| (on, port.property.name)));
        }
    }
    provided
}

/// The domain of a law: the one asked for, the one declared, or the only one that may have what it needs.
fn domain<P: Scalar>(entry: &Entry, all: &[Entry], state: &State<P>, faults: &mut Vec<Fault>) -> Option<usize> {
    if let Some(name) = &entry.options.domain {
        let found = state.domain_index(name);
        if found.is_none() {
            faults.push(Fault::LawDomain {
                law: entry.label().to_owned(),
                domain: name.clone(),
                nearest: nearest(name, state.domains.iter().map(|domain| domain.name.as_str())),
            });
        }
        return found;
    }
    if let Some(name) = entry.signature.domain {
        return state.domain_index(name);
    }
    let lacks = |domain: usize| {
        let own = entry.signature.ports.iter().filter(|port| port.place == Place::Own && needed(port));
        let link = entry.signature.link.filter(|link| link_target(state, domain, link).is_none());
        let field_place =
            entry.signature.samples_fields() && !could_have(domain, crate::property::Position::NAME, all, state);
        own.filter(|port| {
            !matches!(port.property.role, Role::Sum { .. }) && !could_have(domain, port.property.name, all, state)
        })
        .count()
            + usize::from(link.is_some())
            + usize::from(field_place)
    };
    let candidates: Vec<usize> = (1..state.domains.len()).collect();
    let fitting: Vec<usize> = candidates.iter().copied().filter(|&domain| lacks(domain) == 0).collect();
    if let [_, _, ..] = fitting.as_slice()
        && entry.options.enabled
    {
        faults.push(Fault::WhichDomain {
            law: entry.label().to_owned(),
            domains: fitting.iter().map(|&domain| state.domains[domain].name.clone()).collect(),
        });
        return None;
    }
    fitting.first().copied().or_else(|| candidates.into_iter().min_by_key(|&domain| lacks(domain)))
}

/// Whether a law cannot run without what this port touches being there.
fn needed(port: &Port) -> bool {
    match port.mode {
        Mode::Reads | Mode::Previous => !port.optional && port.default.is_none(),
        Mode::Rates | Mode::Amends => true,
        Mode::Sets | Mode::Adds => false,
    }
}

fn could_have<P: Scalar>(domain: usize, property: &str, all: &[Entry], state: &State<P>) -> bool {
    given(state, domain, property).is_some()
        || all.iter().filter(|other| other.options.enabled).any(|other| {
            let stands = other.options.domain.as_deref().or(other.signature.domain);
            let sets = |port: &&Port| port.mode == Mode::Sets && port.property.name == property;
            stands.is_none_or(|name| name == state.domains[domain].name)
                && other.signature.ports.iter().any(|port| sets(&port))
        })
}

fn missing_of<P: Scalar>(law: usize, entries: &[Entry], placed: &Placed, state: &State<P>) -> Vec<Missing> {
    let signature = &entries[law].signature;
    let Some(domain) = placed.domains[law] else {
        let name = signature.domain.unwrap_or("of rows");
        return vec![Missing {
            does: "stands on".to_owned(),
            property: format!("domain {name}"),
            place: "the state".to_owned(),
            nearest: nearest(name, state.domains.iter().skip(1).map(|domain| domain.name.as_str())),
            starved_by: Vec::new(),
        }];
    };
    let mut missing = Vec::new();
    if let Some(link) = signature.link
        && placed.targets[law].is_none()
    {
        missing.push(lack("follows", &link, domain, law, entries, placed, state));
    }
    if signature.samples_fields() && !placed.has(domain, &crate::property::Position::INFO, state) {
        missing.push(lack("samples fields at", &crate::property::Position::INFO, domain, law, entries, placed, state));
    }
    for port in signature.ports.iter().filter(|port| needed(port)) {
        let on = match port.place {
            Place::Own => domain,
            Place::Scene => 0,
            Place::End => match placed.targets[law] {
                Some(target) => target,
                None => continue,
            },
            Place::Field => {
                if !state.fields.iter().any(|(field, _)| field.name == port.property.name) {
                    missing.push(Missing {
                        does: port.mode.word().to_owned(),
                        property: port.property.described(),
                        place: "the list of fields".to_owned(),
                        nearest: nearest(port.property.name, state.fields.iter().map(|(field, _)| field.name)),
                        starved_by: Vec::new(),
                    });
                }
                continue;
            }
        };
        // A rate or an amendment needs the state itself, which only the client can give.
        let there = if port.mode.is_input() {
            placed.has(on, &port.property, state)
        } else {
            given(state, on, port.property.name).is_some() || placed.provided.contains(&(on, port.property.name))
        };
        if !there {
            missing.push(lack(port.mode.word(), &port.property, on, law, entries, placed, state));
        }
    }
    missing
}

fn lack<P: Scalar>(
    does: &str,
    property: &PropertyInfo,
    on: usize,
    law: usize,
    entries: &[Entry],
    placed: &Placed,
    state: &State<P>,
) -> Missing {
    let does = match does {
        "rates" => "gives the rate of",
        word => word,
    };
    let starved_by = (0..entries.len())
        .filter(|&other| other != law && entries[other].options.enabled && !placed.awake[other])
        .filter(|&other| {
            let sets = |port: &Port| port.mode == Mode::Sets && port.property.name == property.name;
            entries[other].signature.ports.iter().any(sets)
        })
        .map(|other| entries[other].label().to_owned())
        .collect();
    let name = &state.domains[on].name;
    Missing {
        does: does.to_owned(),
        property: property.described(),
        place: if name == SCENE { "the scene".to_owned() } else { format!("domain {name}") },
        nearest: nearest_property(state, on, property.name),
        starved_by,
    }
}

/// The rows a law runs on: those that all its subset columns share; `None` for all.
pub(super) fn rows<P: Scalar>(
    entry: &Entry,
    domain: usize,
    ties: &[Tie],
    quantities: &[Quantity],
    state: &State<P>,
    faults: &mut Vec<Fault>,
) -> Option<Vec<u32>> {
    let mut shared: Option<Vec<u32>> = None;
    let mut by = String::new();
    let subset_of = |tie: &Tie| match tie {
        Tie::Quantity(id) if quantities[*id].domain == domain => {
            let at = state.domains[domain].find(quantities[*id].info.name)?;
            state.domains[domain].columns[at].subset.as_ref()
        }
        _ => None,
    };
    for (port, tie) in entry.signature.ports.iter().zip(ties) {
        let Some(rows) = subset_of(tie).filter(|_| port.place == Place::Own && !port.optional) else { continue };
        by = port.property.name.to_owned();
        shared = Some(match shared {
            None => rows.clone(),
            Some(kept) => kept.into_iter().filter(|row| rows.binary_search(row).is_ok()).collect(),
        });
    }
    let all = state.domains[domain].rows;
    for (port, tie) in entry.signature.ports.iter().zip(ties) {
        let Some(rows) = subset_of(tie).filter(|_| port.place == Place::Own && port.optional) else { continue };
        let covered = match &shared {
            Some(kept) => kept.iter().all(|row| rows.binary_search(row).is_ok()),
            None => rows.len() == all,
        };
        if !covered {
            faults.push(Fault::Subset {
                law: entry.label().to_owned(),
                subset: port.property.name.to_owned(),
                detail: format!(
                    "it is optional, but {} of {all} rows have it: give it to all rows, or to none",
                    rows.len()
                ),
            });
        }
    }
    let rows = shared?;
    if entry.shape == Shape::Column || entry.shape == Shape::Link {
        faults.push(Fault::Subset {
            law: entry.label().to_owned(),
            subset: by,
            detail: format!("a {} law gets whole columns: give all {all} rows a value", entry.shape.word()),
        });
        return Some(rows);
    }
    for port in entry.signature.ports.iter().filter(|port| port.mode == Mode::Sets) {
        faults.push(Fault::SetOnSubset {
            law: entry.label().to_owned(),
            property: port.property.name.to_owned(),
            subset: by.clone(),
            given: rows.len(),
            rows: all,
        });
    }
    Some(rows)
}
