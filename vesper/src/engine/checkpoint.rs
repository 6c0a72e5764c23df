//! The complete state of a run as plain data: stop, save, load, go on, the same bits.

use super::{Clock, Engine};
use crate::column::{Aligned, Storage};
use crate::error::{Fault, Faults};
use crate::real::Scalar;

/// Everything that decides how a run goes on, as plain data; whoever saves it chooses the format.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// "f32" or "f64".
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
    /// Whether the integrator goes on from the last step's rates.
    pub remembers: bool,
    /// The domains with their given columns.
    pub domains: Vec<DomainData>,
    /// Rates and the integrator's vectors: one list of numbers for each component.
    pub registers: Vec<Vec<Vec<f64>>>,
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
}

/// One column of a checkpoint.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnData {
    /// The property's name.
    pub property: String,
    /// The rows that have a value, where not all have.
    pub subset: Option<Vec<u32>>,
    /// The numbers, one value after the other; an f32 is exact in f64.
    pub numbers: Vec<f64>,
    /// The rows linked to, for a link.
    pub links: Vec<u32>,
}

impl<P: Scalar> Engine<P> {
    /// Everything that decides how the run goes on.
    pub fn checkpoint(&self) -> Checkpoint {
        let vectors = &self.pipeline.vectors;
        let numbers = |array: &Aligned<P>| array.as_slice().iter().map(|number| number.to_f64()).collect();
        Checkpoint {
            precision: P::NAME.to_owned(),
            integrator: self.integrator.name().to_owned(),
            time: self.time(),
            steps: self.steps,
            remainder: self.remainder,
            clock: (self.clock.time, self.clock.since, self.clock.step),
            evaluations: self.evaluations,
            remembers: self.integrator.memory() && !self.touched && !self.stale,
            domains: self.state.domains().iter().map(domain_data).collect(),
            registers: vectors.registers.iter().map(|register| register.iter().map(numbers).collect()).collect(),
            held: vectors
                .held
                .iter()
                .map(|(_, shares)| shares.iter().map(|(_, share)| numbers(share)).collect())
                .collect(),
            filled: vectors.filled.clone(),
        }
    }

    /// Goes on from a checkpoint of an engine with the same domains, properties, laws, integrator and precision; rows
    /// may differ.
    ///
    /// # Errors
    /// It does not fit; the engine is unchanged then.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), Faults> {
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
        let mut state = self.state.clone();
        for data in &checkpoint.domains {
            let place = state.domain_index(&data.name).ok_or_else(|| misfit(format!("no domain {}", data.name)))?;
            let domain = &mut state.domains[place];
            domain.columns.retain(|column| column.given);
            domain.rows = data.rows;
            if domain.columns.len() != data.columns.len() {
                return Err(misfit(format!("domain {} has other columns", data.name)));
            }
            for column in &data.columns {
                let at = domain.find(&column.property);
                let at = at.ok_or_else(|| misfit(format!("no property {}.{}", data.name, column.property)))?;
                fill(&mut domain.columns[at], column, data.rows)
                    .map_err(|reason| misfit(format!("{}.{} {reason}", data.name, column.property)))?;
            }
        }
        state.changed_layout();
        let before = core::mem::replace(&mut self.state, state);
        if let Err(faults) = self.rebuild() {
            self.state = before;
            self.stale = true;
            return Err(faults);
        }
        self.clock = Clock { time: since_time, since, step };
        self.steps = checkpoint.steps;
        self.remainder = checkpoint.remainder;
        self.evaluations = checkpoint.evaluations;
        self.touched = false;
        let vectors = &mut self.pipeline.vectors;
        let registers = vectors.registers.iter_mut().flatten().zip(checkpoint.registers.iter().flatten());
        let held = vectors.held.iter_mut().flat_map(|(_, shares)| shares.iter_mut().map(|(_, share)| share));
        let mut whole = true;
        for (array, numbers) in registers.chain(held.zip(checkpoint.held.iter().flatten())) {
            whole &= array.as_slice().len() == numbers.len();
            for (number, value) in array.as_mut_slice().iter_mut().zip(numbers) {
                *number = P::from_f64(*value);
            }
        }
        if whole && vectors.filled.len() == checkpoint.filled.len() {
            vectors.filled.clone_from(&checkpoint.filled);
            self.integrator.set_memory(checkpoint.remembers);
        }
        Ok(())
    }
}

fn domain_data<P: Scalar>(domain: &crate::state::DomainState<P>) -> DomainData {
    let columns = domain.columns().iter().filter(|column| column.is_given()).map(|column| {
        let links = column.links().map_or(Vec::new(), |(_, _, rows)| rows.to_vec());
        let width = column.property().kind.width();
        let count = if links.is_empty() { column.len() * width } else { 0 };
        ColumnData {
            property: column.property().name.to_owned(),
            subset: column.subset().map(<[u32]>::to_vec),
            numbers: (0..count).map(|k| column.number(k / width, k % width).to_f64()).collect(),
            links,
        }
    });
    DomainData { name: domain.name().to_owned(), rows: domain.rows(), columns: columns.collect() }
}

fn fill<P: Scalar>(column: &mut crate::column::Column<P>, data: &ColumnData, rows: usize) -> Result<(), &'static str> {
    let width = column.info.kind.width();
    let expected = data.subset.as_ref().map_or(rows, Vec::len);
    match &mut column.storage {
        Storage::Split(components) => {
            if data.numbers.len() != expected * width {
                return Err("has another number of values");
            }
            for (c, component) in components.iter_mut().enumerate() {
                component.resize(expected);
                for (number, value) in
                    component.as_mut_slice().iter_mut().zip(data.numbers.iter().skip(c).step_by(width))
                {
                    *number = P::from_f64(*value);
                }
            }
        }
        Storage::Lent(memory) => {
            if data.numbers.len() != memory.rows() * width {
                return Err("is the client's memory, with another number of rows");
            }
            for (k, value) in data.numbers.iter().enumerate() {
                memory.set(k / width, k % width, P::from_f64(*value));
            }
        }
        Storage::Link { rows: links, .. } => {
            if data.links.len() != expected * width {
                return Err("has another number of links");
            }
            links.clone_from(&data.links);
        }
    }
    column.subset.clone_from(&data.subset);
    Ok(())
}
