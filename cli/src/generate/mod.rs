//! Starting data that is computed: spheres, galaxies, lattices, webs, shells.
//!
//! In: a kind, options, a seed. Out: named columns in SI, the same bits for the same seed. Never: reads a clock, asks
//! the system for randomness, or uses a crate for it, whose next version may draw other numbers.

mod deviates;
mod galaxy;
mod icosahedron;
mod lattice;
mod plummer;
mod uniform;
mod web;

pub use deviates::SplitMix64;

use crate::fault::help_for;

/// A column that a generator fills.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneratedColumn {
    /// The property.
    pub name: String,
    /// Components of a row.
    pub width: usize,
    /// Row by row, in SI; for a link, row numbers.
    pub values: Vec<f64>,
    /// For a link, the domain whose rows it names.
    pub link: Option<String>,
}

/// What a generator made: domains by name, each with its columns.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Generated {
    /// The domains.
    pub domains: Vec<(String, Vec<GeneratedColumn>)>,
}

impl Generated {
    /// The column `property` of `domain`.
    pub fn column(&self, domain: &str, property: &str) -> Option<&GeneratedColumn> {
        let (_, columns) = self.domains.iter().find(|(name, _)| name == domain)?;
        columns.iter().find(|column| column.name == property)
    }
}

/// Which values an option may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bound {
    /// All.
    Any,
    /// 0 or more.
    NotNegative,
    /// More than 0.
    Positive,
    /// At least the first, less than the second.
    Within(f64, f64),
    /// Whole numbers from the first to the second.
    Whole(f64, f64),
}

/// One option of a generator.
#[derive(Clone, Copy, Debug)]
pub struct OptionInfo {
    /// Its key.
    pub name: &'static str,
    /// Its unit; empty for a plain number.
    pub unit: &'static str,
    /// Its default: one component or three; empty where it follows from other options, as `about` says.
    pub default: &'static [f64],
    /// What it may be.
    pub bound: Bound,
    /// What it means.
    pub about: &'static str,
}

/// A generator.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Its name, the value of `kind`.
    pub name: &'static str,
    /// What it makes.
    pub about: &'static str,
    /// Its options.
    pub options: &'static [OptionInfo],
    /// Domains that it fills beside the one that asks for it.
    pub also_fills: &'static [&'static str],
    make: fn(&Options) -> Result<Generated, GenerateFault>,
}

/// All generators.
pub const KINDS: &[Kind] = &[plummer::KIND, galaxy::KIND, lattice::KIND, web::KIND, icosahedron::KIND, uniform::KIND];

/// The generator named `name`.
pub fn kind(name: &str) -> Option<&'static Kind> {
    KINDS.iter().find(|kind| kind.name == name)
}

/// One thing wrong with the options of a generator.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GenerateFault {
    /// The option.
    pub option: Option<String>,
    /// Whether its name is wrong, not its value.
    pub of_name: bool,
    /// What is wrong.
    pub text: String,
    /// What to do.
    pub help: Option<String>,
}

impl GenerateFault {
    fn of_value(option: &str, text: impl Into<String>) -> Self {
        Self { option: Some(option.to_owned()), of_name: false, text: text.into(), help: None }
    }
}

/// More rows than this are a slip of the finger, and would end the program for want of memory.
const MOST_ROWS: f64 = 1e8;

const fn count(default: &'static [f64], least: f64, about: &'static str) -> OptionInfo {
    OptionInfo { name: "count", unit: "", default, bound: Bound::Whole(least, MOST_ROWS), about }
}

const SEED: OptionInfo = OptionInfo {
    name: "seed",
    unit: "",
    default: &[1.0],
    bound: Bound::Whole(0.0, 9_007_199_254_740_992.0),
    about: "another seed, another draw",
};

const GRAVITATION: OptionInfo = OptionInfo {
    name: "g",
    unit: "m^3 kg^-1 s^-2",
    default: &[6.674_30e-11],
    bound: Bound::Positive,
    about: "constant of gravitation that the speeds are made for; the law has the same default",
};

/// The options of one run, checked.
#[derive(Debug)]
struct Options<'a> {
    kind: &'static Kind,
    domain: &'a str,
    given: &'a [(String, Vec<f64>)],
}

impl Options<'_> {
    /// The components of an option, where it is given or has a default.
    fn components(&self, name: &str) -> Option<&[f64]> {
        debug_assert!(self.kind.options.iter().any(|info| info.name == name), "{name} is no option");
        let given = self.given.iter().find(|(given, _)| given == name).map(|(_, value)| value.as_slice());
        let default = || self.kind.options.iter().find(|info| info.name == name).map(|info| info.default);
        given.or_else(default).filter(|components| !components.is_empty())
    }

    fn number(&self, name: &str) -> f64 {
        self.number_or(name, 0.0)
    }

    fn number_or(&self, name: &str, derived: f64) -> f64 {
        self.components(name).map_or(derived, |components| components[0])
    }

    fn whole(&self, name: &str) -> usize {
        self.number(name) as usize
    }

    fn vector(&self, name: &str) -> [f64; 3] {
        match self.components(name) {
            Some(&[x, y, z]) => [x, y, z],
            _ => [0.0; 3],
        }
    }

    fn deviates(&self) -> SplitMix64 {
        SplitMix64::new(self.number("seed") as u64)
    }
}

/// Runs the generator `kind` for `domain` with `options` in SI; what is not given has its default.
pub fn build(
    kind: &'static Kind,
    domain: &str,
    options: &[(String, Vec<f64>)],
) -> Result<Generated, Vec<GenerateFault>> {
    let faults: Vec<GenerateFault> = options.iter().filter_map(|(name, value)| check(kind, name, value)).collect();
    if !faults.is_empty() {
        return Err(faults);
    }
    (kind.make)(&Options { kind, domain, given: options }).map_err(|fault| vec![fault])
}

fn check(kind: &Kind, name: &str, value: &[f64]) -> Option<GenerateFault> {
    let Some(info) = kind.options.iter().find(|info| info.name == name) else {
        return Some(GenerateFault {
            option: Some(name.to_owned()),
            of_name: true,
            text: format!("generator `{}` has no option `{name}`", kind.name),
            help: help_for(name, kind.options.iter().map(|info| info.name)),
        });
    };
    let width = info.default.len().max(1);
    if value.len() != width {
        let text =
            format!("`{name}` has {width} component{}, found {}", if width == 1 { "" } else { "s" }, value.len());
        return Some(GenerateFault::of_value(name, text));
    }
    let (holds, words): (fn(f64, Bound) -> bool, String) = match info.bound {
        Bound::Any => return None,
        Bound::NotNegative => (|x, _| x >= 0.0, "0 or more".to_owned()),
        Bound::Positive => (|x, _| x > 0.0, "more than 0".to_owned()),
        Bound::Within(low, high) => {
            (|x, b| matches!(b, Bound::Within(l, h) if (l..h).contains(&x)), format!("from {low} to below {high}"))
        }
        Bound::Whole(low, high) => (
            |x, b| matches!(b, Bound::Whole(l, h) if (l..=h).contains(&x) && x.fract() == 0.0),
            format!("a whole number from {low} to {high}"),
        ),
    };
    let bad = value.iter().find(|&&x| !holds(x, info.bound))?;
    Some(GenerateFault::of_value(name, format!("expected {words} for `{name}`, found {bad}")))
}

fn scalar(name: &str, values: Vec<f64>) -> GeneratedColumn {
    GeneratedColumn { name: name.to_owned(), width: 1, values, link: None }
}

fn vector(name: &str, rows: &[[f64; 3]]) -> GeneratedColumn {
    GeneratedColumn { name: name.to_owned(), width: 3, values: rows.concat(), link: None }
}

fn link<const N: usize>(name: &str, domain: &str, rows: &[[usize; N]]) -> GeneratedColumn {
    let values = rows.iter().flatten().map(|&row| row as f64).collect();
    GeneratedColumn { name: name.to_owned(), width: N, values, link: Some(domain.to_owned()) }
}

fn bodies(domain: &str, mass: Vec<f64>, position: &[[f64; 3]], velocity: &[[f64; 3]]) -> Generated {
    let columns = vec![scalar("mass", mass), vector("position", position), vector("velocity", velocity)];
    Generated { domains: vec![(domain.to_owned(), columns)] }
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    let square = |axis: usize| (a[axis] - b[axis]) * (a[axis] - b[axis]);
    (square(0) + square(1) + square(2)).sqrt()
}

/// Takes the mean, weighted by `mass`, off all rows: then the centre of mass rests, or momentum is zero.
fn centre(mass: &[f64], rows: &mut [[f64; 3]]) {
    let total: f64 = mass.iter().sum();
    if total > 0.0 {
        for axis in 0..3 {
            let mean = mass.iter().zip(rows.iter()).map(|(m, row)| m * row[axis]).sum::<f64>() / total;
            rows.iter_mut().for_each(|row| row[axis] -= mean);
        }
    }
}

/// `n` velocities with normal components of standard deviation `speed`, of bodies of equal mass without momentum.
fn thermal(n: usize, speed: f64, deviates: &mut SplitMix64) -> Vec<[f64; 3]> {
    let mut velocity = vec![[0.0; 3]; n];
    if speed > 0.0 {
        velocity.fill_with(|| deviates.normal_vector().map(|x| x * speed));
        centre(&vec![1.0; n], &mut velocity);
    }
    velocity
}

#[cfg(test)]
mod tests;
