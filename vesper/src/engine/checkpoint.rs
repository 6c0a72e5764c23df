//! The complete state of a run as plain data: stop, save, load, go on, the same bits.

use super::{Clock, Engine};
use crate::column::{Aligned, Column, Storage};
use crate::domain::SCENE;
use crate::error::{Fault, Faults};
use crate::pipeline::Listed;
use crate::real::{Scalar, compiled_here};
use crate::state::State;

/// Everything that decides how a run goes on, as plain data; whoever saves it chooses the format.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// "f32", "f64" or "double-double".
    pub precision: String,
    /// The integrator's name.
    pub integrator: String,
    /// Time, in s.
    pub time: f64,
    /// Steps taken.
    pub steps: u64,
    /// The part of past frames that no step has covered, in s.
    pub remainder: f64,
    /// Time from which steps are counted, in s; the number of that step; the length of a step, in s.
    pub clock: (f64, u64, f64),
    /// Evaluations of the laws.
    pub evaluations: u64,
    /// Where an origin that moves is, and what that is further beyond its last digit; else empty.
    pub origin: Vec<f64>,
    /// What the integrator remembers from step to step besides its vectors.
    pub memory: Vec<f64>,
    /// The domains with their given columns.
    pub domains: Vec<DomainData>,
    /// The laws that are listed.
    pub laws: Vec<LawData>,
    /// Rates, the integrator's vectors, and the rounding errors of a compensated state.
    pub registers: Vec<Vec<f64>>,
    /// Shares of laws that are not evaluated on every step.
    pub held: Vec<Vec<Vec<f64>>>,
    /// Whether each of these has been computed.
    pub filled: Vec<bool>,
}

/// One domain of a checkpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct DomainData {
    /// Its name.
    pub name: String,
    /// How many rows it has.
    pub rows: usize,
    /// Its given columns.
    pub columns: Vec<ColumnData>,
    /// Results of the last evaluation that laws look back at, `reads(previous ...)`.
    pub previous: Vec<ColumnData>,
}

/// One law of a checkpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct LawData {
    /// Its label, or else its name.
    pub label: String,
    /// What it touched, and its parameters, [`Signature::declaration`](crate::law::Signature::declaration): a law that says something
    /// else now is another one.
    pub declaration: String,
    /// What it remembers from step to step; nothing, but for laws of modules that say so.
    pub memory: Vec<u8>,
}

/// One column of a checkpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnData {
    /// The property's name.
    pub property: String,
    /// The rows that have a value, where not all have.
    pub subset: Option<Vec<u32>>,
    /// The numbers, one value after the other; an f32 is exact in f64. Behind double-double numbers stand the second parts of all.
    pub numbers: Vec<f64>,
    /// The rows linked to, for a link.
    pub links: Vec<u32>,
}

impl<P: Scalar> Engine<P> {
    /// Everything that decides how the run goes on.
    ///
    /// # Errors
    /// The client is changing memory that it lends.
    pub fn checkpoint(&self) -> Result<Checkpoint, Faults> {
        compiled_here!(<P> |engine: &Engine<P>| -> Result<Checkpoint, Faults> { engine.saved() })(self)
    }

    fn saved(&self) -> Result<Checkpoint, Faults> {
        for domain in self.state.domains() {
            domain.columns().iter().try_for_each(|column| column.free(&domain.name, false))?;
        }
        self.pipeline.come_home(false);
        self.pipeline.tell_loss()?;
        // What the integrator had on a device that is gone, it does not remember.
        let forgets = self.touched || self.stale || self.pipeline.has_unseen_loss();
        let vectors = &self.pipeline.vectors;
        let numbers = |array: &Aligned<P>| told(array.as_slice().iter().copied());
        Ok(Checkpoint {
            precision: P::NAME.to_owned(),
            integrator: self.integrator.name().to_owned(),
            time: self.time(),
            steps: self.steps,
            remainder: self.remainder,
            clock: (self.clock.time, self.clock.since, self.clock.step),
            evaluations: self.evaluations,
            origin: self.state.origin.map_or(Vec::new(), |origin| origin.numbers()),
            memory: if forgets { Vec::new() } else { self.integrator.memory() },
            domains: (0..self.state.domains().len()).map(|domain| self.domain_data(domain)).collect(),
            laws: self.laws.iter().map(law_data).collect::<Result<_, _>>()?,
            registers: vectors.kept().iter().map(|array| told(vectors.packed(array))).collect(),
            held: vectors
                .held
                .iter()
                .map(|(_, shares)| shares.iter().map(|(_, share)| numbers(share)).collect())
                .collect(),
            filled: vectors.filled.clone(),
        })
    }

    /// Goes on from a checkpoint of an engine with the same domains, properties, laws, integrator and precision; rows
    /// may differ.
    ///
    /// # Errors
    /// It does not fit; the engine is unchanged then.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), Faults> {
        compiled_here!(<P> |engine: &mut Engine<P>, from: &Checkpoint| -> Result<(), Faults> { engine.go_on(from) })(
            self, checkpoint,
        )
    }

    fn go_on(&mut self, checkpoint: &Checkpoint) -> Result<(), Faults> {
        let misfit = |reason: String| Faults::from(Fault::Checkpoint { reason });
        if checkpoint.precision != P::NAME {
            return Err(misfit(format!("it is in {}, the engine in {}", checkpoint.precision, P::NAME)));
        }
        if checkpoint.integrator != self.integrator.name() {
            return Err(misfit(format!(
                "it is of {}, the engine has {}",
                checkpoint.integrator,
                self.integrator.name()
            )));
        }
        let (since_time, since, step) = checkpoint.clock;
        if since > checkpoint.steps || !since_time.is_finite() || !step.is_finite() || !checkpoint.remainder.is_finite()
        {
            return Err(misfit("its clock makes no sense".to_owned()));
        }
        self.declared_alike(checkpoint).map_err(misfit)?;
        let state = restored(&self.state, checkpoint).map_err(misfit)?;
        self.quiet = f64::NAN;
        let before = core::mem::replace(&mut self.state, state);
        if let Err(faults) = self.rebuild() {
            self.state = before;
            self.stale = true;
            return Err(faults);
        }
        // The client's memory, and what only laws make, come last, when nothing can go wrong any more.
        for data in &checkpoint.domains {
            let Some(place) = self.state.domain_index(&data.name) else { continue };
            let domain = &mut self.state.domains[place];
            let lent = domain.columns.iter_mut().filter(|column| matches!(column.storage, Storage::Lent(_)));
            for (to, all) in
                lent.map(|to| (to, &data.columns)).chain(domain.previous.iter_mut().map(|to| (to, &data.previous)))
            {
                let from = all.iter().find(|from| from.property == to.info.name);
                let width = to.info.kind.width();
                let values = from.iter().flat_map(|from| untold(&from.numbers));
                for (k, value) in values.enumerate().take(to.len() * width) {
                    to.set_number(k / width, k % width, value);
                }
            }
        }
        self.remember(checkpoint).map_err(misfit)?;
        self.clock = Clock { time: since_time, since, step };
        self.steps = checkpoint.steps;
        self.remainder = checkpoint.remainder;
        self.evaluations = checkpoint.evaluations;
        self.touched = false;
        let vectors = &mut self.pipeline.vectors;
        let mut whole = vectors.kept().len() == checkpoint.registers.len();
        for (register, numbers) in checkpoint.registers.iter().enumerate().take(vectors.kept().len()) {
            whole &= vectors.unpack(register, untold(numbers));
        }
        let mut fill = |array: &mut Aligned<P>, numbers: &[f64]| {
            whole &= array.as_slice().len() * P::PARTS == numbers.len();
            for (number, value) in array.as_mut_slice().iter_mut().zip(untold(numbers)) {
                *number = value;
            }
        };
        let held = vectors.held.iter_mut().flat_map(|(_, shares)| shares.iter_mut().map(|(_, share)| share));
        held.zip(checkpoint.held.iter().flatten()).for_each(|(array, numbers)| fill(array, numbers));
        vectors.look_at_errors(vectors.whole());
        if whole && vectors.filled.len() == checkpoint.filled.len() {
            vectors.filled.clone_from(&checkpoint.filled);
            self.integrator.set_memory(&checkpoint.memory);
        }
        self.lent_memory_changed();
        self.observe()
    }

    /// Whether laws of the same labels declare the same; else the difference.
    fn declared_alike(&self, checkpoint: &Checkpoint) -> Result<(), String> {
        for (listed, data) in self.with_data(checkpoint) {
            let now = listed.compiled.signature.declaration();
            if now != data.declaration {
                let difference = difference(&data.declaration, &now);
                return Err(format!("law {} has changed (- then, + now):\n{difference}", data.label));
            }
        }
        Ok(())
    }

    /// Laws remember what they did.
    fn remember(&self, checkpoint: &Checkpoint) -> Result<(), String> {
        for (listed, data) in self.with_data(checkpoint) {
            if let Some(foreign) = &listed.compiled.foreign {
                foreign.load(&data.memory).map_err(|reason| format!("law {}: {reason}", data.label))?;
            }
        }
        Ok(())
    }

    /// Laws, and what a checkpoint has of them: by label, and of several, which stand on different domains, in the order of the list.
    fn with_data<'a>(&'a self, checkpoint: &'a Checkpoint) -> impl Iterator<Item = (&'a Listed<P>, &'a LawData)> {
        self.laws.iter().enumerate().filter_map(|(number, listed)| {
            let label = listed.entry.label();
            let before = self.laws[..number].iter().filter(|other| other.entry.label() == label).count();
            Some((listed, checkpoint.laws.iter().filter(|data| data.label == label).nth(before)?))
        })
    }

    fn domain_data(&self, index: usize) -> DomainData {
        let domain = &self.state.domains()[index];
        let given = domain.columns().iter().filter(|column| column.is_given());
        DomainData {
            name: domain.name().to_owned(),
            rows: domain.rows(),
            columns: given.map(column_data).collect(),
            previous: domain.previous.iter().map(column_data).collect(),
        }
    }
}

fn law_data<P: Scalar>(listed: &Listed<P>) -> Result<LawData, Fault> {
    let memory = listed.compiled.foreign.as_ref().map_or(Ok(Vec::new()), |foreign| foreign.save());
    let label = listed.entry.label().to_owned();
    let memory = memory.map_err(|reason| Fault::Checkpoint { reason: format!("law {label}: {reason}") })?;
    Ok(LawData { label, declaration: listed.compiled.signature.declaration(), memory })
}

/// The lines that only one of two declarations has, those of the first with a minus.
fn difference(then: &str, now: &str) -> String {
    let only = |sign: &str, these: &str, others: &str| -> String {
        let missing = |line: &&str| !others.lines().any(|other| other == *line);
        these.lines().filter(missing).map(|line| format!("  {sign} {line}\n")).collect()
    };
    (only("-", then, now) + &only("+", now, then)).trim_end().to_owned()
}

/// Numbers as f64, and behind them what these leave out, where they do.
fn told<P: Scalar>(numbers: impl Iterator<Item = P> + Clone) -> Vec<f64> {
    let rests = numbers.clone().map(Scalar::rest).filter(|_| P::PARTS > 1);
    numbers.map(Scalar::to_f64).chain(rests).collect()
}

/// The same numbers again.
fn untold<P: Scalar>(all: &[f64]) -> impl ExactSizeIterator<Item = P> {
    let count = all.len() / P::PARTS;
    (0..count).map(move |k| P::from_parts(all[k], if P::PARTS > 1 { all[count + k] } else { 0.0 }))
}

fn column_data<P: Scalar>(column: &Column<P>) -> ColumnData {
    let links = column.links().map_or(Vec::new(), |(_, _, rows)| rows.to_vec());
    let width = column.property().kind.width();
    let count = if column.links().is_some() { 0 } else { column.len() * width };
    ColumnData {
        property: column.property().name.to_owned(),
        subset: column.subset().map(<[u32]>::to_vec),
        numbers: told((0..count).map(|k| column.number(k / width, k % width))),
        links,
    }
}

/// The state with the given columns of a checkpoint, but for lent memory, which is left as it is; or why they do not
/// fit.
fn restored<P: Scalar>(state: &State<P>, checkpoint: &Checkpoint) -> Result<State<P>, String> {
    let mut state = state.clone();
    state.origin = match state.origin {
        None if checkpoint.origin.is_empty() => None,
        None => return Err("its origin moves, and that of the engine does not".to_owned()),
        Some(origin) => {
            let at = origin.at(&checkpoint.origin);
            Some(at.ok_or_else(|| "its origin does not move, and that of the engine does".to_owned())?)
        }
    };
    if checkpoint.domains.len() != state.domains.len() {
        return Err(format!("it has {} domains, the engine {}", checkpoint.domains.len(), state.domains.len()));
    }
    for domain in &mut state.domains {
        let data = checkpoint.domains.iter().find(|data| data.name == domain.name);
        let data = data.ok_or_else(|| format!("it lacks domain {}", domain.name))?;
        domain.columns.retain(|column| column.given);
        domain.previous.clear();
        if u32::try_from(data.rows).is_err() {
            return Err(format!("domain {} has {} rows, more than can be numbered", data.name, data.rows));
        }
        domain.rows = data.rows;
        if domain.columns.len() != data.columns.len() || domain.name == SCENE && data.rows != 1 {
            return Err(format!("domain {} has other columns or rows", data.name));
        }
        for column in &mut domain.columns {
            let values = data.columns.iter().find(|values| values.property == column.info.name);
            let values = values.ok_or_else(|| format!("it lacks {}.{}", data.name, column.info.name))?;
            fill(column, values, &checkpoint.domains, data.rows)
                .map_err(|reason| format!("{}.{} {reason}", data.name, column.info.name))?;
        }
    }
    state.changed_layout();
    Ok(state)
}

fn fill<P: Scalar>(
    column: &mut Column<P>,
    data: &ColumnData,
    domains: &[DomainData],
    rows: usize,
) -> Result<(), &'static str> {
    let width = column.info.kind.width();
    let expected = data.subset.as_ref().map_or(rows, Vec::len);
    if let Some(subset) = &data.subset
        && !(subset.is_sorted_by(|one, next| one < next) && subset.last().is_none_or(|&last| (last as usize) < rows))
    {
        return Err("has values for rows that do not exist, or not in their order");
    }
    match &mut column.storage {
        Storage::Split(components) => {
            if data.numbers.len() != expected * width * P::PARTS {
                return Err("has another number of values");
            }
            for (c, component) in components.iter_mut().enumerate() {
                component.resize(expected);
                let values = untold(&data.numbers).skip(c).step_by(width);
                component.as_mut_slice().iter_mut().zip(values).for_each(|(number, value)| *number = value);
            }
        }
        Storage::Lent(memory) if memory.busy(true) => return Err("is borrowed by the client: let go of it first"),
        Storage::Lent(memory) => {
            if data.numbers.len() != memory.rows() * width * P::PARTS || expected != memory.rows() {
                return Err("is the client's memory, with another number of rows");
            }
        }
        Storage::Link { target, arity, rows: links } => {
            let target = domains.iter().find(|domain| domain.name == *target).map_or(0, |domain| domain.rows);
            if data.links.len() != rows * *arity || data.subset.is_some() {
                return Err("has another number of links");
            }
            if data.links.iter().any(|&end| end as usize >= target) {
                return Err("links to rows that do not exist");
            }
            links.clone_from(&data.links);
        }
    }
    column.subset.clone_from(&data.subset);
    Ok(())
}
