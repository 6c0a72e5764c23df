//! Which domain a law stands on, whether it has its data there, and on which rows it runs.

use super::{Entry, Missing, Quantity, Tie, link_target, nearest_property};
use crate::domain::SCENE;
use crate::error::{Fault, nearest};
use crate::law::{Mode, Place, Port, Shape};
use crate::property::{Property, PropertyInfo};
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
            || property.role.is_sum()
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
    let stand = Standing::new(entries, state);
    let domains: Vec<Option<usize>> =
        (0..entries.len()).map(|law| domain(law, entries, &stand, state, faults)).collect();
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
fn domain<P: Scalar>(
    law: usize,
    entries: &[Entry],
    stand: &Standing,
    state: &State<P>,
    faults: &mut Vec<Fault>,
) -> Option<usize> {
    let entry = &entries[law];
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
    let candidates: Vec<usize> = (1..state.domains.len()).collect();
    let fitting: Vec<usize> = candidates.iter().copied().filter(|&domain| stand.can[law][domain]).collect();
    if let [_, _, ..] = fitting.as_slice()
        && entry.options.enabled
    {
        faults.push(Fault::WhichDomain {
            law: entry.label().to_owned(),
            domains: fitting.iter().map(|&domain| state.domains[domain].name.clone()).collect(),
        });
        return None;
    }
    let lacks = |domain: &usize| stand.lacks(law, *domain, entries, state);
    fitting.first().copied().or_else(|| candidates.into_iter().min_by_key(lacks))
}

/// Which laws could stand on which domains.
struct Standing {
    /// By law and domain.
    can: Vec<Vec<bool>>,
}

impl Standing {
    /// Every law may stand where it is asked to; then, until nothing changes, none stands where it would lack something
    /// that neither the client gives nor a law sets that may stand there.
    fn new<P: Scalar>(entries: &[Entry], state: &State<P>) -> Self {
        let may = |entry: &Entry| -> Vec<bool> {
            let asked = entry.options.domain.as_deref().or(entry.signature.domain);
            state.domains.iter().map(|domain| asked.is_none_or(|name| name == domain.name)).collect()
        };
        let mut stand = Standing { can: entries.iter().map(may).collect() };
        loop {
            let lacking =
                |law: usize, domain: usize| stand.can[law][domain] && stand.lacks(law, domain, entries, state) > 0;
            let found: Vec<(usize, usize)> = (0..entries.len())
                .flat_map(|law| (0..state.domains.len()).map(move |domain| (law, domain)))
                .filter(|&(law, domain)| lacking(law, domain))
                .collect();
            if found.is_empty() {
                return stand;
            }
            for (law, domain) in found {
                stand.can[law][domain] = false;
            }
        }
    }

    /// How many things a law would lack on a domain.
    fn lacks<P: Scalar>(&self, law: usize, domain: usize, entries: &[Entry], state: &State<P>) -> usize {
        let signature = &entries[law].signature;
        let has = |property: &str| {
            given(state, domain, property).is_some()
                || entries.iter().zip(&self.can).any(|(other, can)| {
                    let sets = |port: &Port| port.mode == Mode::Sets && port.property.name == property;
                    other.options.enabled && can[domain] && other.signature.ports.iter().any(sets)
                })
        };
        let own = signature.ports.iter().filter(|port| port.place == Place::Own && needed(port));
        let link = signature.link.filter(|link| link_target(state, domain, link).is_none());
        own.filter(|port| !port.property.role.is_sum() && !has(port.property.name)).count()
            + usize::from(link.is_some())
            + usize::from(signature.samples_fields() && !has(crate::property::Position::NAME))
    }
}

/// Whether a law cannot run without what this port touches being there.
fn needed(port: &Port) -> bool {
    match port.mode {
        Mode::Reads | Mode::Previous => !port.optional && port.default.is_none(),
        Mode::Rates | Mode::Amends => true,
        Mode::Sets | Mode::Adds => false,
    }
}

fn missing_of<P: Scalar>(law: usize, entries: &[Entry], placed: &Placed, state: &State<P>) -> Vec<Missing> {
    let signature = &entries[law].signature;
    let Some(domain) = placed.domains[law] else {
        let names = state.domains.iter().skip(1).map(|domain| domain.name.as_str());
        return vec![Missing {
            does: "stands on".to_owned(),
            property: signature.domain.map_or_else(|| "a domain of rows".to_owned(), |name| format!("domain {name}")),
            place: "the state".to_owned(),
            nearest: signature.domain.and_then(|name| nearest(name, names)),
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
                        does: port.mode.does().to_owned(),
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
        let known = missing.iter().any(|known: &Missing| known.property == port.property.described());
        if !there && !known {
            missing.push(lack(port.mode.does(), &port.property, on, law, entries, placed, state));
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
    (domain, target): (usize, Option<usize>),
    ties: &[Tie],
    place: Option<usize>,
    quantities: &[Quantity],
    state: &State<P>,
    faults: &mut Vec<Fault>,
) -> Option<Vec<u32>> {
    let part_of = |on: usize, id: usize| {
        let at = state.domains[on].find(quantities[id].info.name).filter(|_| quantities[id].domain == on)?;
        state.domains[on].columns[at].part_of(state.domains[on].rows)
    };
    let all = state.domains[domain].rows;
    let mut refuse = |property: &str, given: usize, rows: usize, mend: &str| {
        faults.push(Fault::Subset {
            law: entry.label().to_owned(),
            subset: property.to_owned(),
            given,
            rows,
            mend: mend.to_owned(),
        });
    };
    let ports = || entry.signature.ports.iter().zip(ties);
    let tied = |tie: &Tie| if let Tie::Quantity(id) = tie { Some(*id) } else { None };
    let own = ports().filter(|(port, _)| port.place == Place::Own && !port.optional).filter_map(|(_, tie)| tied(tie));
    let mut shared: Option<Vec<u32>> = None;
    let mut by = None;
    for id in own.chain(place) {
        let Some(rows) = part_of(domain, id) else { continue };
        by = by.or(Some((quantities[id].info.name, rows.len())));
        shared = Some(match shared {
            None => rows.to_vec(),
            Some(kept) => kept.into_iter().filter(|row| rows.binary_search(row).is_ok()).collect(),
        });
    }
    for (port, tie) in ports() {
        let name = port.property.name;
        if port.place == Place::Own && port.optional {
            let Some(rows) = tied(tie).and_then(|id| part_of(domain, id)) else { continue };
            let covered = shared.as_ref().is_some_and(|kept| kept.iter().all(|row| rows.binary_search(row).is_ok()));
            if !covered {
                refuse(name, rows.len(), all, "it is optional, so give it to all rows, or to none");
            }
        }
        if let (Place::End, Some(target)) = (port.place, target)
            && let Some(rows) = tied(tie).and_then(|id| part_of(target, id))
        {
            let all = state.domains[target].rows;
            refuse(name, rows.len(), all, "any row may be linked to, so give all of them a value");
        }
    }
    let (rows, (subset, given)) = shared.zip(by)?;
    if entry.shape == Shape::Column || entry.shape == Shape::Link {
        let mend = format!("a {} law gets whole columns, so give all rows a value", entry.shape.word());
        refuse(subset, given, all, &mend);
        return Some(rows);
    }
    for port in entry.signature.ports.iter().filter(|port| port.mode == Mode::Sets) {
        faults.push(Fault::SetOnSubset {
            law: entry.label().to_owned(),
            property: port.property.name.to_owned(),
            subset: subset.to_owned(),
            given,
            rows: all,
        });
    }
    Some(rows)
}
