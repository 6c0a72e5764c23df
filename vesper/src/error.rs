//! What can be wrong, and how it is said.
//!
//! In: names and numbers from whoever found it. Out: [`Fault`], one thing wrong, and [`Faults`], all of them at once.
//! A fault says who, what, where, and what to do. Never: a panic, a catch-all.

use thiserror::Error;

/// All things that are wrong, in the order in which they were declared.
#[derive(Clone, Debug, PartialEq)]
pub struct Faults(Vec<Fault>);

impl Faults {
    /// The faults, or `value` where there are none.
    ///
    /// # Errors
    /// There is at least one fault.
    pub fn unless_empty<T>(faults: Vec<Fault>, value: T) -> Result<T, Faults> {
        if faults.is_empty() { Ok(value) } else { Err(Faults(faults)) }
    }

    /// These faults behind others.
    pub(crate) fn after(self, mut others: Vec<Fault>) -> Faults {
        others.extend(self.0);
        Faults(others)
    }

    /// Each fault.
    pub fn iter(&self) -> core::slice::Iter<'_, Fault> {
        self.0.iter()
    }

    /// How many there are; never 0.
    #[allow(clippy::len_without_is_empty, reason = "it is never empty")]
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

impl From<Fault> for Faults {
    fn from(fault: Fault) -> Self {
        Faults(vec![fault])
    }
}

impl<'a> IntoIterator for &'a Faults {
    type Item = &'a Fault;
    type IntoIter = core::slice::Iter<'a, Fault>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl core::fmt::Display for Faults {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        for (index, fault) in self.0.iter().enumerate() {
            if index > 0 {
                writeln!(f)?;
            }
            write!(f, "{fault}")?;
        }
        Ok(())
    }
}

impl std::error::Error for Faults {}

/// One thing wrong.
#[derive(Clone, Debug, PartialEq, Error)]
#[allow(missing_docs, reason = "each variant's message names every field")]
#[non_exhaustive]
pub enum Fault {
    #[error("{place}: {reason}")]
    Unit { place: String, unit: String, reason: String },
    #[error(
        "{domain}.{property} is given in {}, but it is measured in {}: give it in a unit of that dimension",
        in_words(given),
        in_words(expected)
    )]
    Dimension { domain: String, property: String, given: String, expected: String },
    #[error("{domain}.{property} is a {expected}, but it is {given}: give {mend}")]
    Kind { domain: String, property: String, expected: String, given: String, mend: String },
    #[error(
        "property {property} is declared as {one} by {one_by} and as {other} by {other_by}: declare it alike, or rename one of them"
    )]
    Declared { property: String, one: String, one_by: String, other: String, other_by: String },
    #[error(
        "{domain}.{property} has {}, but domain {domain} has {}, {expected_by}: give one value per row",
        counted(*given, "value"),
        counted(*expected, "row")
    )]
    Length { domain: String, property: String, given: usize, expected: usize, expected_by: String },
    #[error(
        "{domain}.{property} has {} for a subset of {}: give one value per row",
        counted(*given, "value"),
        counted(*expected, "row")
    )]
    SubsetLength { domain: String, property: String, given: usize, expected: usize },
    #[error("{domain}.{property}: row {row} is given twice: a subset names each row once")]
    SubsetTwice { domain: String, property: String, row: u32 },
    #[error("{domain}.{property}: row {row} is outside domain {domain}, which has {}, counted from 0", counted(*rows, "row"))]
    SubsetRange { domain: String, property: String, row: u32, rows: usize },
    #[error(
        "{domain}.{property}: row {row} links to row {target_row} of {target}, which has {}, counted from 0",
        counted(*rows, "row")
    )]
    LinkRange { domain: String, property: String, row: usize, target: String, target_row: u32, rows: usize },
    #[error("{domain}.{property} links to domain {target}, which does not exist{}", hint(nearest, "add the domain"))]
    LinkTarget { domain: String, property: String, target: String, nearest: Option<String> },
    #[error("{domain}.{property} links to no row: declare it as a link to at least one")]
    LinkToNone { domain: String, property: String },
    #[error("{domain}.{property}: row {row} is {value}: give a finite number")]
    NotFinite { domain: String, property: String, row: usize, value: f64 },
    #[error(
        "{domain}.{property}: row {row} is {value:e}, which is beyond {precision}: take f64, or a property with a larger unit"
    )]
    OutOfPrecision { domain: String, property: String, row: usize, value: f64, precision: String },
    #[error("domain {domain} has {rows} rows: at most 4294967295 can be numbered")]
    TooManyRows { domain: String, rows: usize },
    #[error("domain scene has always one row, which holds the constants: {mend}")]
    SceneRow { mend: String },
    #[error("{domain}.{property} has a value for every row: give one for every new row, not for a subset of them")]
    NewRowsSubset { domain: String, property: String },
    #[error("{domain}.{property} links to {target}, but the new rows link to {given}: link them to {target}")]
    NewRowsTarget { domain: String, property: String, target: String, given: String },
    #[error("{domain}.{property} is given twice: keep one")]
    ColumnTwice { domain: String, property: String },
    #[error("domain {domain} is given twice: keep one")]
    DomainTwice { domain: String },
    #[error("field {field} is given twice: keep one")]
    FieldTwice { field: String },
    #[error("field {field} is {value} everywhere: give finite numbers")]
    FieldNotFinite { field: String, value: f64 },
    #[error("field {field} is declared as a {kind}, but a field gives vectors: declare the property as a vector")]
    FieldKind { field: String, kind: String },
    #[error("domain {domain} does not exist{}", hint(nearest, "add it to the builder"))]
    NoDomain { domain: String, nearest: Option<String> },
    #[error(
        "{domain} has no property {property}{}",
        hint(nearest, "give it as a column, or observe it where a law computes it")
    )]
    NoProperty { domain: String, property: String, nearest: Option<String> },
    #[error("{domain} has no row {row}: it has {}, counted from 0", counted(*rows, "row"))]
    NoRow { domain: String, row: usize, rows: usize },
    #[error("{domain}.{property} has no value for row {row}: only {given} of {rows} rows have one")]
    NoValue { domain: String, property: String, row: usize, given: usize, rows: usize },
    #[error("the new rows of {domain} lack {property}, which all rows have: give it for them too")]
    NewRowsLack { domain: String, property: String },
    #[error("no law {law}{}", hint(nearest, "list it in the builder"))]
    NoLaw { law: String, nearest: Option<String> },
    #[error("{law} stands on domain {domain}, which does not exist{}", hint(nearest, "add the domain"))]
    LawDomain { law: String, domain: String, nearest: Option<String> },
    #[error("{law} can stand on {}: say on which, `.on(\"{}\")`", domains.join(" or "), domains[0])]
    WhichDomain { law: String, domains: Vec<String> },
    #[error("{law} is given twice on domain {domain}: keep one, or give each a label of its own, `.label(\"...\")`")]
    LawTwice { law: String, domain: String },
    #[error("{law} declares two outputs of {property}: keep one")]
    OutputTwice { law: String, property: String },
    #[error("{law} and {other} both set {property}: keep one; several laws may add, one may set")]
    TwoSet { law: String, other: String, property: String },
    #[error("{law} and {other} both give the rate of {property}: keep one")]
    TwoRates { law: String, other: String, property: String },
    #[error(
        "{law} gives the rate of {property}, which {other} {does}: a state belongs to the integrator, so keep one of the two laws"
    )]
    RateOfComputed { law: String, property: String, other: String, does: String },
    #[error("{law} adds to {property}, which is no sum: declare the property with `sum`, or set it")]
    AddToPlain { law: String, property: String },
    #[error("{law} {does} {property}, which the client gives: take the column away, or switch {law} off")]
    SetGiven { law: String, does: String, property: String },
    #[error(
        "{law} sets {property} for all rows, but reads {subset}, which only {given} of {rows} rows have: give the others a value"
    )]
    SetOnSubset { law: String, property: String, subset: String, given: usize, rows: usize },
    #[error(
        "{law} adds to {property} and reads its previous value, which is gone when the sum begins anew: let one law set a property of its own from it, and another one add that"
    )]
    PreviousOfSum { law: String, property: String },
    #[error("{law} {does} {property}, but it is a {shape} law: {allowed}")]
    Shape { law: String, does: String, property: String, shape: String, allowed: String },
    #[error("the laws close a circle: {}: let one of them read the value before, `reads(previous ...)`", path.join(", "))]
    Cycle { path: Vec<String> },
    #[error("{law} must run, but is dormant: {reason}")]
    Dormant { law: String, reason: String },
    #[error("{law} stands on domain {domain}, which has no rows: add rows, or take the law away")]
    EmptyDomain { law: String, domain: String },
    #[error("{law} cannot use {subset}, which only {given} of {rows} rows have: {mend}")]
    Subset { law: String, subset: String, given: usize, rows: usize, mend: String },
    #[error(
        "{sum} starts from {start}, which only {given} of {rows} rows have: give all rows a value, 0 where there is none"
    )]
    SubsetStart { sum: String, start: String, given: usize, rows: usize },
    #[error("{law} touches {numbers} numbers of a row: 64 are possible, split it into several laws")]
    TooWide { law: String, numbers: usize },
    #[error("{law} is to be evaluated every {every} steps: give at least 1")]
    Every { law: String, every: u32 },
    #[error(
        "{law} is evaluated every {every} steps, but it {does} {property}: only a law that only adds can be held between steps"
    )]
    EveryOutput { law: String, every: u32, does: String, property: String },
    #[error("{law}: parameter {parameter} is {value}: give a finite number")]
    ParameterNotFinite { law: String, parameter: String, value: f64 },
    #[error("{what} is {value:?} s: give {allowed}")]
    Step { what: String, value: f64, allowed: &'static str },
    #[error("a frame of {frame:e} s in steps of {step:e} s is more steps than can be counted: take longer steps")]
    TooManySteps { frame: f64, step: f64 },
    #[error("threads is {given}: give 1 to {most}, or leave it out for all cores")]
    Threads { given: usize, most: usize },
    #[error("the thread pool cannot start: {reason}")]
    ThreadPool { reason: String },
    #[error(
        "backend parallel is asked for, but vesper was built without the feature `parallel`: turn it on, or ask for cpu"
    )]
    NoParallel,
    #[error(
        "backend gpu is asked for, but vesper was built without the feature `gpu`: turn it on (`features = [\"gpu\"]` for vesper, `--features gpu` for \
         vesper-cli), or ask for cpu"
    )]
    NoGpu,
    #[error(
        "the graphics processor is gone, and with it numbers that only it had ({reason}): they are NaN now. Restore a checkpoint \
         (`Engine::restore`), or set these columns again; laws run on the host from now on"
    )]
    DeviceLost { reason: String },
    #[error(
        "{integrator} finds no step that meets its tolerance at {time:e} s, down to {step:e} s: look at what is close to \
         infinite there, allow a larger error, or take an integrator of fixed steps"
    )]
    StepTooShort { integrator: String, time: f64, step: f64 },
    #[error(
        "{integrator} is down to steps of {step:e} s at {time:e} s, and would need more than {most:e} for a frame of {span:e} s: \
         a law jumps or is stiff there; allow a larger error, take an integrator of fixed steps, or ask for shorter frames"
    )]
    TooManyTries { integrator: String, time: f64, step: f64, span: f64, most: f64 },
    #[error(
        "{integrator} cannot solve its equation for the step of {step:e} s at {time:e} s: {residual:.1e} of it is left; take a \
         shorter step, or look for a law that jumps there without a switch"
    )]
    NotSolved { integrator: String, time: f64, step: f64, residual: f64 },
    #[error("{integrator} was stopped at {time:e} s, inside a frame")]
    Stopped { integrator: String, time: f64 },
    #[error("{integrator} needs {need}, but {found}: {mend}")]
    Integrator { integrator: String, need: String, found: String, mend: String },
    #[error("{domain}.{property} is borrowed by the client: let go of it first")]
    Borrowed { domain: String, property: String },
    #[error("{domain}.{property} is the client's own memory, which cannot {cannot}: {mend}")]
    ClientMemory { domain: String, property: String, cannot: String, mend: String },
    #[error("{place} {domain}.{property} of row {row} is {value}; {first}", place = blown_up(*traced, *step, *time))]
    BlowUp {
        traced: bool,
        step: u64,
        time: f64,
        domain: String,
        property: String,
        row: usize,
        value: f64,
        first: String,
    },
    #[error("{who} does not let the origin move: {reason}")]
    OriginStays { who: String, reason: String },
    #[error("{law} says {word}, {}, or leave the word out", word.advice())]
    NotAsSaid { law: String, word: PairWord },
    #[error("{law} has no cut-off that neighbours can be found within: {reason}")]
    Cutoff { law: String, reason: String },
    #[error("{law} has no far field: {reason}")]
    FarField { law: String, reason: String },
    #[error("the checkpoint does not fit: {reason}")]
    Checkpoint { reason: String },
    #[error("module {module}: {reason}")]
    Module { module: String, reason: String },
    #[error("{law}: {reason}")]
    Parameter { law: String, reason: String },
    #[error("{law} cannot be made: {reason}")]
    LawNotMade { law: String, reason: String },
    #[error(
        "{law} failed and is switched off: {reason}; all else goes on without it. Mend it, and build the engine again"
    )]
    LawFailed { law: String, reason: String },
}

/// What a law of pairs may say of its body.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PairWord {
    /// It looks at differences of coordinates only.
    TranslationInvariant,
    /// Row j loses what row i gets.
    Antisymmetric,
    /// What a pair gives has the form of inverse squares that it says.
    InverseSquare,
}

impl core::fmt::Display for PairWord {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            PairWord::TranslationInvariant => "translation_invariant",
            PairWord::Antisymmetric => "antisymmetric",
            PairWord::InverseSquare => "inverse_square",
        })
    }
}

impl PairWord {
    fn advice(self) -> &'static str {
        match self {
            PairWord::TranslationInvariant => {
                "but what it gives changes where both rows of a pair move alike: look at differences of coordinates only"
            }
            PairWord::Antisymmetric => {
                "but what row j does to row i is not the opposite of what row i does to row j: give i and j opposite shares"
            }
            PairWord::InverseSquare => {
                "but `pair` gives something else than response_i source_j d / (d^2 + softening^2)^(3/2), d = x_j - x_i: make them agree"
            }
        }
    }
}

fn blown_up(traced: bool, step: u64, time: f64) -> String {
    let (place, end) = if traced { ("at", "") } else { ("somewhere up to", ", the end of the frame") };
    format!("{place} step {step} (time {time:?} s{end})")
}

fn hint(nearest: &Option<String>, otherwise: &str) -> String {
    nearest.as_ref().map_or_else(|| format!(": {otherwise}"), |name| format!("; did you mean {name}?"))
}

/// A unit, or what the empty text says.
fn in_words(unit: &str) -> &str {
    if unit.is_empty() { "no unit" } else { unit }
}

/// "1 row", "2 rows"
pub(crate) fn counted(count: usize, what: &str) -> String {
    if count == 1 { format!("1 {what}") } else { format!("{count} {what}s") }
}

/// "1 number per row"
pub(crate) fn per_row(numbers: usize) -> String {
    format!("{} per row", counted(numbers, "number"))
}

/// The name in `known` nearest to `name`, where one is near enough to be a slip of the pen.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let allowed = name.chars().count() / 4 + 1;
    known
        .into_iter()
        .map(|candidate| (distance(name, candidate), candidate))
        .filter(|(distance, _)| *distance <= allowed)
        .min()
        .map(|(_, candidate)| candidate.to_owned())
}

/// Slips between two names; a name that the other one begins with counts as one slip ("mas", "mass_of_body").
fn distance(name: &str, candidate: &str) -> usize {
    let slips = strsim::damerau_levenshtein(name, candidate);
    let shorter = name.len().min(candidate.len());
    if shorter >= 3 && (candidate.starts_with(name) || name.starts_with(candidate)) { slips.min(1) } else { slips }
}
