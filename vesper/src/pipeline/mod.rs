//! The composed run: what an integrator asks, as passes over memory.
//!
//! In: the order of the laws, their kernels, a state. Out: `Pipeline`, which evaluates any part of the rates, any
//! number of times, at any state and time. Never: a time of its own, a step.
//!
//! A *program* is made once for each thing that can be asked: the laws that it needs, in order, as *passes*. A pair, a
//! link or a column law is a pass of its own. Neighbouring row laws of one domain are one pass: block by block, all laws
//! of the group before the next block, with sums that nobody else reads in a scratch that stays in the first cache.

mod bind;
mod chain;
mod columns;
#[cfg_attr(not(feature = "gpu"), path = "without_device.rs")]
mod device;
mod dot;
mod explain;
mod far_field;
mod group;
mod linear;
mod linearised;
mod magnitudes;
mod merge;
mod neighbours;
mod operand;
mod pairs;
mod pass;
mod plan;
mod prune;
mod quantities;
mod rotation;
mod run;
mod sum;
mod switches;
mod tangent;
mod threads;
mod turning;
mod turns;
mod vectors;

pub(crate) use bind::{Program, program};
pub(crate) use chain::FusedChain;
pub use chain::{Chain, ChainPart, Chained, Layout, List, Registers};
pub(crate) use device::Opened;
pub(crate) use plan::Key;
use plan::Plan;
pub(crate) use run::{Runner, Watch};
pub(crate) use tangent::Tangent;
pub(crate) use vectors::{Vectors, lent_columns};

use crate::backend::{Compiled, Kernel};
use crate::column::Column;
use crate::error::{Fault, Faults, PairWord};
use crate::graph::Graph;
use crate::integrate::{Integrator, Structure};
use crate::law::{Mode, Part, Shape};
use crate::property::{Kind, PropertyInfo, Role};
use crate::real::{Isa, Scalar};
use crate::registry::{Entry, QuantityId, Registry, Tie};
use crate::state::State;
use far_field::Fit;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex};
use switches::Switches;
use turning::{Turning, turnings, without_turning};

/// Watches how long laws take. Runs start no clock: whoever wants times brings one.
pub trait Probe: Send + Sync {
    /// The time now, in any unit.
    fn now(&self) -> u64;
    /// The law of this number in the list ran from `from` until now, on one thread.
    fn ran(&self, law: usize, from: u64);
}

/// A law as listed, with its loops.
pub(crate) struct Listed<P: Scalar> {
    pub(crate) entry: Entry,
    pub(crate) compiled: Compiled<P>,
}

/// How passes are run.
#[derive(Clone)]
pub(crate) struct Machine {
    pub(crate) isa: Isa,
    /// Whether laws that allow it are computed with estimates.
    pub(crate) estimates: bool,
    /// What calibrations of far fields have found, by law: kept where laws, rows or columns come and go.
    pub(crate) fits: Arc<Mutex<Vec<(String, Fit)>>>,
    /// The graphics processor that laws were asked to run on, or why there is none.
    pub(crate) device: Opened,
    /// Cores to use.
    pub(crate) threads: usize,
    #[cfg(feature = "parallel")]
    pub(crate) pool: Option<Arc<rayon::ThreadPool>>,
    pub(crate) probe: Option<Arc<dyn Probe>>,
    /// Once it is true, adaptive integrators come back.
    pub(crate) stop: Option<Arc<AtomicBool>>,
}

/// What a builder says of a whole run.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Settings {
    /// Whether a dormant law is a fault.
    pub(crate) strict: bool,
    /// Whether the rounding errors of the state are kept.
    pub(crate) compensated: bool,
    /// Whether steps go across jumps.
    pub(crate) across_jumps: bool,
}

/// The laws of a run, ordered and tied to a state's layout.
pub(crate) struct Pipeline<P: Scalar> {
    pub(crate) entries: Vec<Entry>,
    pub(crate) registry: Registry,
    pub(crate) graph: Graph,
    pub(crate) structure: Structure,
    pub(crate) observed: Vec<QuantityId>,
    pub(crate) programs: Vec<Program<P>>,
    pub(crate) vectors: Vectors<P>,
    /// Momenta that forces turn.
    pub(crate) turnings: Vec<Turning>,
    /// Where what is turned is, component by component, where it is not the momentum itself.
    turners_at: Vec<(QuantityId, bind::Located<P>)>,
    /// Of derivatives, for integrators that ask for them.
    pub(crate) tangent: Option<Box<Tangent<P>>>,
    /// What steps end at.
    pub(crate) switches: Switches<P>,
    /// The layout of the state that the programs' pointers were taken from.
    pub(crate) layout: (u64, u64),
    /// Whether a step changes nothing.
    pub(crate) idle: bool,
    /// Whether there are laws that amend.
    pub(crate) amends: bool,
    /// Whether computed quantities are observed.
    pub(crate) observes: bool,
    /// Whether columns are the client's memory.
    pub(crate) lends: bool,
    /// Where columns are, if some can be on a graphics processor.
    pub(crate) residency: Option<device::Shared<P>>,
    /// What frames will move, where that can be foreseen.
    #[cfg(feature = "gpu")]
    pub(crate) foresight: Option<device::Foresight>,
}

// SAFETY: its pointers are into its own memory, and into columns of the state that it was made for, which are followed
// only while `Runner` holds that state; both move to another thread together, with the engine that owns them, and
// columns stay where they are in memory.
unsafe impl<P: Scalar> Send for Pipeline<P> {}

impl<P: Scalar> Pipeline<P> {
    /// Orders the laws, and makes the programs that this integrator and these observers will ask for.
    pub(crate) fn new(
        laws: &[Listed<P>],
        chains: &[FusedChain<P>],
        state: &mut State<P>,
        integrator: &dyn Integrator,
        observe: &[(String, String)],
        settings: Settings,
        machine: &Machine,
    ) -> Result<Self, Faults> {
        let Settings { strict, compensated, across_jumps } = settings;
        // Whoever had its numbers elsewhere, this pipeline is not who.
        let columns = state.domains.iter_mut().flat_map(|domain| domain.columns.iter_mut().chain(&mut domain.previous));
        columns.for_each(Column::come_back);
        let entries: Vec<Entry> = laws.iter().map(|law| law.entry.clone().with_own_switches()).collect();
        let mut registry = Registry::new(&entries, state, observe, strict)?;
        let graph = Graph::new(&entries, &registry, state)?;
        let at = |(domain, property): &(String, String)| registry.find(state.domain_index(domain)?, property);
        let observed: Vec<QuantityId> = observe.iter().filter_map(at).collect();
        let turnings = turnings(&entries, &registry, &graph);
        let mut structure = structure(&entries, &registry, &graph, &turnings, state);
        structure.parameters = parameters(laws, &registry);
        integrator.accept(&structure)?;
        Self::check_far_fields(&entries, laws)?;
        // Results of laws that no longer run must not be taken for results.
        for (index, domain) in state.domains.iter_mut().enumerate() {
            domain.columns.retain(|column| column.given || registry.find(index, column.info.name).is_some());
            domain.previous.retain(|column| registry.find(index, column.info.name).is_some());
        }
        state.changed_layout();
        prune::prune(&entries, &mut registry, &graph, &observed, state);
        let mut pipeline = Pipeline {
            entries,
            registry,
            graph,
            structure,
            observed,
            programs: Vec::new(),
            vectors: Vectors::default(),
            turnings,
            turners_at: Vec::new(),
            tangent: None,
            switches: Switches::default(),
            layout: state.layout(),
            idle: false,
            amends: false,
            observes: false,
            lends: lent_columns(state).next().is_some(),
            residency: device::residency(machine),
            #[cfg(feature = "gpu")]
            foresight: None,
        };
        let rotates = integrator.rotates();
        let asked = |key: &Key| rotates || !matches!(key, Key::Unturned | Key::Turners);
        let plan = |key| if asked(&key) { plan::plan(key, &pipeline) } else { Plan::nothing(key) };
        let plans: Vec<_> = Key::ALL.into_iter().map(plan).collect();
        for plan in &plans {
            columns::materialise(plan, &pipeline, state);
        }
        for (index, domain) in state.domains.iter_mut().enumerate() {
            for column in domain.columns.iter_mut().filter(|column| !column.given) {
                let id = pipeline.registry.find(index, column.info.name);
                column.shown = id.is_some_and(|id| pipeline.observed.contains(&id));
            }
        }
        if !across_jumps {
            pipeline.switches = Switches::new(&plans, &pipeline, state);
        }
        // To take a step again, of those that do not choose their own, which keep what they need.
        let again = usize::from(pipeline.switches.any() && !integrator.is_adaptive());
        let work = integrator.work_vectors() + again;
        let differences = pipeline.registry.seats.iter().any(|seat| pipeline.takes_differences(seat.law));
        // Numbers with more digits than f64 have what rounding errors would be kept for.
        let keeps = P::EPSILON >= f64::EPSILON && (compensated || integrator.compensates(P::EPSILON));
        let keeps = (keeps, rotates, differences);
        vectors::lay_together(&pipeline, state);
        pipeline.vectors = Vectors::new(&pipeline, state, work, keeps);
        pipeline.turners_at = pipeline.turners().flat_map(|by| pipeline.components(by, state)).collect();
        pipeline.programs =
            plans.into_iter().map(|plan| program(plan, laws, chains, &pipeline, state, machine)).collect();
        pipeline.check_pairs()?;
        pipeline.let_go(state);
        if integrator.needs_derivatives() {
            pipeline.tangent = Some(Box::new(Tangent::new(&pipeline, laws, state)));
        }
        pipeline.layout = state.layout();
        pipeline.amends = !pipeline.programs[Key::Amend.index()].passes.is_empty();
        pipeline.observes = !pipeline.programs[Key::Observe.index()].passes.is_empty();
        pipeline.idle = pipeline.programs.iter().all(|program| program.passes.is_empty());
        Ok(pipeline)
    }

    /// Whether laws of pairs are what they say they are, where loops rely on it.
    fn check_pairs(&mut self) -> Result<(), Faults> {
        let passes = self.programs.iter_mut().flat_map(|program| &mut program.passes);
        let mut broken: Vec<(usize, PairWord)> = Vec::new();
        let mut faults = Vec::new();
        for bound in passes {
            let bind::Pass::Pair(pair) = bound.pass.on_host() else { continue };
            // Rows of lent memory are not there yet.
            if !pair.load_owned() {
                continue;
            }
            if !pair.is_invariant() {
                broken.push((pair.law, PairWord::TranslationInvariant));
            }
            if !pair.is_antisymmetric() {
                broken.push((pair.law, PairWord::Antisymmetric));
            }
            if !pair.is_as_inverse_square() {
                broken.push((pair.law, PairWord::InverseSquare));
            }
            let signature = &self.entries[pair.law].signature;
            faults.extend(neighbours::fault(pair, signature).map(|reason| (pair.law, reason)));
        }
        broken.sort_unstable();
        broken.dedup();
        let label = |law: usize| self.entries[law].label().to_owned();
        faults.sort_unstable();
        faults.dedup();
        let faults = faults.into_iter().map(|(law, reason)| Fault::Cutoff { law: label(law), reason });
        let broken = broken.into_iter().map(|(law, word)| Fault::NotAsSaid { law: label(law), word });
        Faults::unless_empty(broken.chain(faults).collect(), ())
    }

    /// Whether laws that far fields are asked of have any.
    fn check_far_fields(entries: &[Entry], laws: &[Listed<P>]) -> Result<(), Faults> {
        let fault = |(entry, law): (&Entry, &Listed<P>)| {
            let is_inverse_square = match &law.compiled.kernel {
                Kernel::Pair(kernel) => kernel.is_inverse_square(),
                Kernel::Row(_) | Kernel::Link(_) | Kernel::Column(_) => false,
            };
            let reason =
                far_field::fault(entry.options.far_field?, is_inverse_square, entry.signature.cutoff.is_some())?;
            Some(Fault::FarField { law: entry.label().to_owned(), reason })
        };
        Faults::unless_empty(entries.iter().zip(laws).filter_map(fault).collect(), ())
    }

    /// Whether a law is of pairs, and looks at differences of coordinates only.
    pub(crate) fn takes_differences(&self, law: usize) -> bool {
        let entry = &self.entries[law];
        entry.shape == Shape::Pair && entry.signature.translation_invariant
    }

    /// The numbers of steps of laws that are not evaluated on every one, each once.
    fn paces(&self) -> Vec<u32> {
        let all = self.programs[Key::Evaluate(Part::Momenta).index()].passes.iter().map(|pass| pass.every);
        let mut paces: Vec<u32> = all.filter(|pace| *pace > 1).collect();
        paces.sort_unstable();
        paces.dedup();
        paces
    }

    /// A fault where numbers were lost with a device, and nobody was told.
    pub(crate) fn tell_loss(&self) -> Result<(), Fault> {
        self.loss().map_or(Ok(()), |reason| Err(Fault::DeviceLost { reason }))
    }

    /// Lent memory may begin elsewhere than in the last run.
    pub(crate) fn forget_addresses(&mut self) {
        for pass in self.programs.iter_mut().flat_map(|program| &mut program.passes) {
            if let bind::Pass::Group(group) = pass.pass.on_host() {
                group.unready();
            }
        }
    }

    /// Whether a step would change nothing.
    #[inline]
    pub(crate) fn is_idle(&self) -> bool {
        self.idle
    }

    /// The laws that drive a state, for a message: its rate's law, and the laws that feed that one.
    pub(crate) fn drivers(&self, state: QuantityId) -> String {
        let label = |seat: &usize| self.entries[self.registry.seats[*seat].law].label();
        let rates = |seat: &&usize| {
            let seat = &self.registry.seats[**seat];
            let signature = &self.entries[seat.law].signature;
            crate::graph::outputs(signature, seat).any(|(mode, id)| mode == Mode::Rates && id == state)
        };
        let Some(rater) = self.graph.order.iter().find(rates) else { return "no law moves it".to_owned() };
        let seat = &self.registry.seats[*rater];
        let needs: Vec<QuantityId> = crate::graph::inputs(&self.entries[seat.law].signature, seat, u64::MAX).collect();
        let makers = self.graph.makers(&needs, &self.entries, &self.registry);
        let fed: Vec<&str> = makers.iter().map(label).collect();
        let fed = if fed.is_empty() { String::new() } else { format!(", fed by {}", fed.join(", ")) };
        format!("{} moves it{fed}: take a smaller step, or look at its parameters", label(rater))
    }

    /// What is turned, where it is not the momentum itself.
    fn turners(&self) -> impl Iterator<Item = QuantityId> {
        self.turnings.iter().filter(|turning| turning.by != turning.state).map(|turning| turning.by)
    }

    /// Where the components of a vector quantity are.
    fn components(&self, id: QuantityId, state: &State<P>) -> impl Iterator<Item = (QuantityId, bind::Located<P>)> {
        let known = &self.registry.quantities[id];
        (0..3).filter_map(move |c| Some((id, bind::locate_column(state, known.domain, known.info.name, c)?)))
    }

    /// The quantities whose rates laws give.
    pub(crate) fn states(&self) -> Vec<QuantityId> {
        let mut states: Vec<QuantityId> = self
            .registry
            .seats
            .iter()
            .flat_map(|seat| {
                self.entries[seat.law].signature.ports.iter().zip(&seat.ties).filter_map(|(port, tie)| match tie {
                    Tie::Quantity(id) if port.mode == Mode::Rates => Some(*id),
                    _ => None,
                })
            })
            .collect();
        states.sort_unstable();
        states.dedup();
        states
    }
}

/// Whether a property is a switch of which the sign counts.
fn turns(property: &PropertyInfo) -> bool {
    property.role == Role::Switch && property.kind == Kind::Scalar
}

fn structure<P: Scalar>(
    entries: &[Entry],
    registry: &Registry,
    graph: &Graph,
    turnings: &[Turning],
    state: &State<P>,
) -> Structure {
    let mut structure = Structure::default();
    let mut second_order = true;
    for seat in &registry.seats {
        let entry = &entries[seat.law];
        for (port, tie) in entry.signature.ports.iter().zip(&seat.ties) {
            let (Tie::Quantity(id), Mode::Rates) = (tie, port.mode) else { continue };
            let name = registry.name(*id, state);
            match port.property.role {
                Role::Coordinate => {
                    structure.coordinates.push(name);
                    structure.rows.push(state.domains[registry.quantities[*id].domain].rows);
                    second_order &= entry.signature.second_order;
                }
                Role::Momentum(_) => structure.momenta.push(name),
                Role::Plain | Role::Switch | Role::Sum { .. } | Role::Turn { .. } => structure.others.push(name),
            }
        }
        for (port, tie) in entry.signature.ports.iter().zip(&seat.ties) {
            match tie {
                Tie::Quantity(id) if port.mode == Mode::Sets && turns(&port.property) => {
                    structure.jumps.push(registry.name(*id, state));
                }
                Tie::Field(field) if state.fields[*field].1.has_regions() => {
                    structure.jumps.push(format!("field {}", state.fields[*field].0.name));
                }
                _ => {}
            }
        }
        if crate::graph::amends(&entry.signature) && structure.amends.is_none() {
            structure.amends = Some(entry.label().to_owned());
        }
        if entry.options.every > 1 && structure.every.is_none() {
            structure.every = Some(entry.label().to_owned());
        }
    }
    let name = |id| registry.name(id, state);
    let all = |_| u64::MAX;
    let unturned = |seat: usize| without_turning(&entries[registry.seats[seat].law]);
    let depends = |mask: &dyn Fn(usize) -> u64| graph.momenta_depend_on_momentum(mask, entries, registry).map(name);
    structure.momenta_depend_on_momenta = depends(&all);
    structure.turned = turnings.iter().map(|turning| name(turning.state)).collect();
    structure.depends_beyond_turning = if turnings.is_empty() { depends(&all) } else { depends(&unturned) };
    structure.coordinates_depend_on = graph.coordinates_depend_on(entries, registry).map(name);
    structure.jumps.sort_unstable();
    structure.jumps.dedup();
    structure.second_order = second_order && structure.coordinates_depend_on.is_none();
    structure
}

/// The parameters of the laws that run, by law and name.
fn parameters<P: Scalar>(laws: &[Listed<P>], registry: &Registry) -> Vec<(String, f64)> {
    let runs = |index: &usize| registry.seats.iter().any(|seat| seat.law == *index);
    let of = |index: usize| {
        let law = &laws[index];
        let signature = &law.entry.signature;
        let starts = signature.parameters.iter().scan(0, |next, parameter| {
            let at = *next;
            *next += parameter.width;
            Some((parameter, at))
        });
        let numbers = starts.filter(|(parameter, _)| parameter.width == 1);
        numbers.filter_map(|(parameter, at)| {
            let value = law.compiled.parameters.get(at)?;
            Some((format!("{}.{}", signature.name, parameter.name), *value))
        })
    };
    (0..laws.len()).filter(runs).flat_map(of).collect()
}

/// A fault for memory that the client holds.
pub(crate) fn borrowed(domain: &str, property: &str) -> Fault {
    Fault::Borrowed { domain: domain.to_owned(), property: property.to_owned() }
}
