//! Who runs, who does not, and why; what nobody uses.

use super::seat::Placed;
use super::{Entry, Registry, Tie};
use crate::domain::SCENE;
use crate::error::counted;
use crate::property::{Property, Time};
use crate::real::Scalar;
use crate::state::State;
use core::fmt;

/// What became of every law and of every column.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// The laws, in the order in which they were listed.
    pub laws: Vec<LawReport>,
    /// Given columns, constants and fields that no running law touches and no link follows: "bodies.colour".
    pub unused: Vec<String>,
}

/// What became of one law.
#[derive(Clone, Debug, PartialEq)]
pub struct LawReport {
    /// The law's name.
    pub name: String,
    /// Its label, or else its name.
    pub label: String,
    /// The domain it stands on; empty where none fits.
    pub domain: String,
    /// What became of it.
    pub status: Status,
}

/// What became of a law.
#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    /// It runs.
    Active {
        /// On this many rows.
        rows: usize,
    },
    /// It lacks data, and wakes when they are added.
    Dormant(Dormancy),
    /// Nobody needs its results: neither the integrator nor an observer.
    Pruned {
        /// The results that nobody needs.
        results: Vec<String>,
        /// What every evaluation is spared: "1000 rows", "499500 pairs".
        saving: String,
    },
    /// It is switched off.
    Off,
    /// It failed while it ran, and is switched off for good.
    Failed {
        /// Why.
        reason: String,
    },
}

impl Status {
    /// "active", "dormant", "pruned", "off" or "failed".
    pub const fn word(&self) -> &'static str {
        match self {
            Status::Active { .. } => "active",
            Status::Dormant(_) => "dormant",
            Status::Pruned { .. } => "pruned",
            Status::Off => "off",
            Status::Failed { .. } => "failed",
        }
    }
}

/// Why a law sleeps.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Dormancy {
    /// What it lacks.
    pub missing: Vec<Missing>,
}

/// One thing that a law lacks.
#[derive(Clone, Debug, PartialEq)]
pub struct Missing {
    /// "reads", "rates", ...
    pub does: String,
    /// "mass \[kg\]"
    pub property: String,
    /// Where it was looked for: "domain bodies", "the scene", "the fields".
    pub place: String,
    /// The nearest name that is there.
    pub nearest: Option<String>,
    /// Listed laws that would set it, if they had their own data.
    pub starved_by: Vec<String>,
}

impl fmt::Display for Missing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "it {} {}, which {} does not have", self.does, self.property, self.place)?;
        let name = self.property.split(" [").next().unwrap_or_default();
        match (&self.nearest, self.starved_by.as_slice()) {
            (_, laws @ [_, ..]) => write!(f, ": add {name}, or what {} lacks, which would set it", laws.join(", ")),
            (Some(nearest), []) => write!(f, "; there is {nearest}: rename it, or add {name}"),
            (None, []) => write!(f, ": add {name}"),
        }
    }
}

impl fmt::Display for Dormancy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, missing) in self.missing.iter().enumerate() {
            if index > 0 {
                write!(f, "; ")?;
            }
            missing.fmt(f)?;
        }
        Ok(())
    }
}

impl fmt::Display for LawReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}", self.label, self.status.word())?;
        match &self.status {
            Status::Active { rows } => write!(f, " on {} of {}", counted(*rows, "row"), self.domain),
            Status::Dormant(why) => write!(f, ": {why}"),
            Status::Pruned { results, saving } => {
                let results = results.join(", ");
                write!(f, ": neither the integrator nor an observer needs {results}; {saving} saved per evaluation")
            }
            Status::Off => Ok(()),
            Status::Failed { reason } => write!(f, ": {reason}"),
        }
    }
}

impl Report {
    /// The laws that lack data.
    pub fn dormant(&self) -> impl Iterator<Item = (&LawReport, &Dormancy)> {
        self.laws.iter().filter_map(|law| match &law.status {
            Status::Dormant(why) => Some((law, why)),
            Status::Active { .. } | Status::Pruned { .. } | Status::Off | Status::Failed { .. } => None,
        })
    }

    /// The law of this label.
    pub fn law(&self, label: &str) -> Option<&LawReport> {
        self.laws.iter().find(|law| law.label == label)
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let laws = self.laws.iter().map(ToString::to_string);
        let unused = self.unused.iter().map(|unused| format!("{unused} is unused: no running law touches it"));
        f.write_str(&laws.chain(unused).collect::<Vec<_>>().join("\n"))
    }
}

/// Puts together what became of everything; pruning is noted later, when the graph is known.
pub(super) fn report<P: Scalar>(entries: &[Entry], placed: &Placed, state: &State<P>, registry: &Registry) -> Report {
    let laws = entries
        .iter()
        .enumerate()
        .map(|(law, entry)| {
            let domain = placed.domains[law].map_or(String::new(), |at| state.domains[at].name.clone());
            let seat = registry.seats.iter().find(|seat| seat.law == law);
            let status = match seat {
                _ if entry.failed.is_some() => Status::Failed { reason: entry.failed.clone().unwrap_or_default() },
                _ if !entry.options.enabled => Status::Off,
                Some(seat) => {
                    Status::Active { rows: seat.rows.as_ref().map_or(state.domains[seat.domain].rows, Vec::len) }
                }
                None => Status::Dormant(Dormancy { missing: placed.missing[law].clone() }),
            };
            LawReport { name: entry.signature.name.to_owned(), label: entry.label().to_owned(), domain, status }
        })
        .collect();
    Report { laws, unused: unused(entries, state, registry) }
}

fn unused<P: Scalar>(entries: &[Entry], state: &State<P>, registry: &Registry) -> Vec<String> {
    let follows = |domain: usize, name: &str| {
        registry
            .seats
            .iter()
            .any(|seat| seat.domain == domain && entries[seat.law].signature.link.is_some_and(|link| link.name == name))
    };
    let mut unused = Vec::new();
    for (index, domain) in state.domains.iter().enumerate() {
        for column in domain.columns.iter().filter(|column| column.given) {
            let name = column.info.name;
            let kept_by_engine = domain.name == SCENE && name == Time::NAME;
            if !kept_by_engine && registry.find(index, name).is_none() && !follows(index, name) {
                unused.push(format!("{}.{name}", domain.name));
            }
        }
    }
    for (index, (field, _)) in state.fields.iter().enumerate() {
        if !registry.seats.iter().any(|seat| seat.ties.contains(&Tie::Field(index))) {
            unused.push(format!("fields.{}", field.name));
        }
    }
    unused
}
