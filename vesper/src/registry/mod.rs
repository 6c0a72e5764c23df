//! Names, types, units, rows: what the laws declare against what the state has.
//!
//! In: the laws as listed, and a state. Out: `Registry`: the laws that can run, each seated on its domain with every
//! port tied to a quantity; why the others cannot; or all faults at once. Never: an order of laws, a loop over rows.

mod check;
mod report;
mod seat;

pub use report::{Dormancy, LawReport, Missing, Report, Status};

use crate::column::Storage;
use crate::error::{Fault, Faults, nearest};
use crate::law::{Mode, Place, Port, Shape, Signature};
use crate::property::{PropertyInfo, Role, intern};
use crate::real::Scalar;
use crate::state::State;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

/// Where a law runs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// What the builder says; if that says nothing either, on one core or all of them, by size. Never on a graphics processor.
    #[default]
    Auto,
    /// On one core.
    Cpu,
    /// On all cores; the same bits as on one.
    Parallel,
    /// On a graphics processor (feature `gpu`), where there is one that can; else on the host, and `explain` says why. Sums of pairs
    /// are in another order there.
    Gpu,
    /// Where a step takes least: when the engine is built, whole steps are timed with the law on the host and on the graphics processor, and
    /// `explain` says what was found. As `Auto` without the feature `gpu`, without a device, or where the client lends memory. The choice
    /// may be another one in the next run, and with it the last bits of sums of pairs: a run that is to be repeated says where its laws run.
    Fastest,
}

/// How a law is listed: everything about its use that is not its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// The domain it stands on; else the declaration's, else the one that fits.
    pub domain: Option<String>,
    /// A name of its own, where one law is listed twice on one domain.
    pub label: Option<String>,
    /// It is evaluated on every n-th step, and held between.
    pub every: u32,
    /// Whether it is switched on.
    pub enabled: bool,
    /// Whether dormancy is a fault.
    pub required: bool,
    /// Where it runs.
    pub backend: Backend,
    /// The root of the mean square of the relative error that far rows may be summed together with; all pairs where there is none.
    pub far_field: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        let (every, enabled, required, backend) = (1, true, false, Backend::Auto);
        Options { domain: None, label: None, every, enabled, required, backend, far_field: None }
    }
}

/// A law as listed.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// Its declaration.
    pub signature: Signature,
    /// The shape of its body.
    pub shape: Shape,
    /// How it is used.
    pub options: Options,
    /// Why it runs no more, where it failed.
    pub failed: Option<String>,
}

impl Entry {
    /// The same with switches of its own: named after the law too, so that two laws of one kind have one each.
    #[must_use]
    pub(crate) fn with_own_switches(mut self) -> Self {
        let own = |port: &&Port| port.property.role == Role::Switch;
        if self.signature.ports.iter().any(|port| own(&port)) {
            self.signature.ports = own_switches(self.signature.ports, self.label());
        }
        self
    }

    /// The label, or else the law's name.
    pub fn label(&self) -> &str {
        self.options.label.as_deref().unwrap_or(self.signature.name)
    }
}

/// Ports whose switches are named after a law of this label. Kept for the life of the program, once for each label.
fn own_switches(ports: &'static [Port], label: &str) -> &'static [Port] {
    static KNOWN: Mutex<BTreeMap<(usize, String), &'static [Port]>> = Mutex::new(BTreeMap::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    known.entry((ports.as_ptr().addr(), label.to_owned())).or_insert_with(|| {
        let renamed = |port: &Port| match port.property.role {
            Role::Switch => {
                let name = intern(&format!("{label}_{}", port.property.name));
                Port { property: PropertyInfo { name, ..port.property }, ..*port }
            }
            _ => *port,
        };
        Box::leak(ports.iter().map(renamed).collect())
    })
}

/// The number of a quantity in [`Registry::quantities`].
pub(crate) type QuantityId = usize;

/// One property on one domain.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Quantity {
    pub(crate) domain: usize,
    pub(crate) info: PropertyInfo,
    /// Whether the client gave it.
    pub(crate) given: bool,
}

/// What a port is tied to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Tie {
    Quantity(QuantityId),
    /// The number of a field of the state.
    Field(usize),
    /// A constant that the scene does not give.
    Default([f64; 3]),
    /// An optional property that is not there.
    Absent,
}

/// A law that can run, in its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Seat {
    /// The number of the law in the list.
    pub(crate) law: usize,
    pub(crate) domain: usize,
    /// The domain that a link leads to.
    pub(crate) target: Option<usize>,
    /// The rows it runs on; `None` for all.
    pub(crate) rows: Option<Vec<u32>>,
    pub(crate) ties: Vec<Tie>,
    /// Where fields are sampled: the position of the row.
    pub(crate) place: Option<QuantityId>,
}

/// The laws against the state.
#[derive(Clone, Debug)]
pub(crate) struct Registry {
    pub(crate) quantities: Vec<Quantity>,
    /// The laws that can run, sorted by name, so that nothing depends on the order of the list.
    pub(crate) seats: Vec<Seat>,
    pub(crate) report: Report,
}

impl Registry {
    /// Ties every law to the state.
    pub(crate) fn new<P: Scalar>(
        entries: &[Entry],
        state: &State<P>,
        observe: &[(String, String)],
        strict: bool,
    ) -> Result<Self, Faults> {
        let mut faults = check::entries(entries);
        check::observed(observe, entries, state, &mut faults);
        check::declarations(entries, state, &mut faults);
        let placed = seat::place(entries, state, &mut faults);
        let mut registry = Registry { quantities: Vec::new(), seats: Vec::new(), report: Report::default() };
        let mut order: Vec<usize> = (0..entries.len()).collect();
        order.sort_by_key(|&law| {
            let domain = placed.domains[law].map(|domain| state.domains[domain].name.as_str());
            (entries[law].signature.name, domain, entries[law].label())
        });
        for law in order {
            if placed.awake[law] {
                let seat = registry.seat(law, &entries[law], &placed, state, &mut faults);
                registry.seats.extend(seat);
            }
        }
        check::seats(entries, &registry, state, &mut faults);
        registry.report = report::report(entries, &placed, state, &registry);
        for (law, entry) in registry.report.laws.iter().zip(entries) {
            match &law.status {
                Status::Dormant(why) if strict || entry.options.required => {
                    faults.push(Fault::Dormant { law: law.label.clone(), reason: why.to_string() });
                }
                Status::Active { rows: 0 } if strict || entry.options.required => {
                    faults.push(Fault::EmptyDomain { law: law.label.clone(), domain: law.domain.clone() });
                }
                _ => {}
            }
        }
        faults.dedup();
        Faults::unless_empty(faults, registry)
    }

    /// The quantity of a property on a domain, noted where it is new.
    fn quantity<P: Scalar>(&mut self, domain: usize, info: PropertyInfo, state: &State<P>) -> QuantityId {
        if let Some(known) = self.find(domain, info.name) {
            return known;
        }
        let given = state.domains[domain].find(info.name).is_some_and(|at| state.domains[domain].columns[at].given);
        self.quantities.push(Quantity { domain, info, given });
        self.quantities.len() - 1
    }

    pub(crate) fn find(&self, domain: usize, property: &str) -> Option<QuantityId> {
        self.quantities.iter().position(|known| known.domain == domain && known.info.name == property)
    }

    /// "bodies.position"
    pub(crate) fn name<P: Scalar>(&self, quantity: QuantityId, state: &State<P>) -> String {
        let quantity = &self.quantities[quantity];
        format!("{}.{}", state.domains[quantity.domain].name, quantity.info.name)
    }

    fn seat<P: Scalar>(
        &mut self,
        law: usize,
        entry: &Entry,
        placed: &seat::Placed,
        state: &State<P>,
        faults: &mut Vec<Fault>,
    ) -> Option<Seat> {
        let domain = placed.domains[law]?;
        let target = placed.targets[law];
        let mut ties = Vec::new();
        for port in entry.signature.ports {
            let on = match port.place {
                Place::Own => Some(domain),
                Place::Scene => Some(0),
                Place::End => target,
                Place::Field => None,
            };
            let tie = match on {
                None => state
                    .fields
                    .iter()
                    .position(|(field, _)| field.name == port.property.name)
                    .map_or(Tie::Absent, Tie::Field),
                Some(on) if !port.mode.is_input() || placed.has(on, &port.property, state) => {
                    Tie::Quantity(self.quantity(on, port.property, state))
                }
                Some(_) => port.default.map_or(Tie::Absent, Tie::Default),
            };
            ties.push(tie);
        }
        // A sum starts from another property where the domain has that one: then it is read.
        for (port, tie) in entry.signature.ports.iter().zip(ties.clone()) {
            let (Role::Sum { start: Some(start) }, Tie::Quantity(sum)) = (port.property.role, tie) else { continue };
            let on = self.quantities[sum].domain;
            if let Some(at) = state.domains[on].find(start).filter(|&at| state.domains[on].columns[at].given) {
                self.quantity(on, state.domains[on].columns[at].info, state);
            }
        }
        let place = entry.signature.samples_fields().then(|| self.place(domain, state)).flatten();
        let rows = seat::rows(entry, (domain, target), &ties, place, &self.quantities, state, faults);
        Some(Seat { law, domain, target, rows, ties, place })
    }

    fn place<P: Scalar>(&mut self, domain: usize, state: &State<P>) -> Option<QuantityId> {
        let position = <crate::property::Position as crate::property::Property>::INFO;
        Some(self.quantity(domain, position, state))
    }
}

/// The quantity that a sum starts from, where the domain has it.
pub(crate) fn start_of(sum: QuantityId, registry: &Registry) -> Option<QuantityId> {
    let quantity = &registry.quantities[sum];
    match quantity.info.role {
        Role::Sum { start: Some(start) } => registry.find(quantity.domain, start),
        _ => None,
    }
}

/// Links of a column, where it is one.
pub(crate) fn link_target<P: Scalar>(state: &State<P>, domain: usize, link: &PropertyInfo) -> Option<usize> {
    let column = &state.domains[domain].columns[state.domains[domain].find(link.name)?];
    match &column.storage {
        Storage::Link { target, .. } => state.domain_index(target),
        Storage::Split(_) | Storage::Lent(_) => None,
    }
}

/// The nearest name of a property on a domain.
pub(crate) fn nearest_property<P: Scalar>(state: &State<P>, domain: usize, property: &str) -> Option<String> {
    nearest(property, state.domains[domain].columns.iter().map(|column| column.info.name))
}

/// Whether laws give values of the property in every evaluation.
pub(crate) fn computes(mode: Mode) -> bool {
    matches!(mode, Mode::Sets | Mode::Adds)
}
