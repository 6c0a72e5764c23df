//! Distances from positions that are known from elsewhere.
//!
//! In: section `[compare]` and the table it names. Out: what is to be compared when, and the distance of a state from it.
//! Never: a step; whoever runs brings a state of the right time.

use vesper::prelude::*;
use vesper_dimension::Unit;

use crate::csv::Table;
use crate::fault::{SceneFault, Spanned};
use crate::scene::{Compare, DomainData, Scene};

/// Which position a row of the table means.
#[derive(Clone, Debug, PartialEq)]
enum Body {
    Row(usize),
    /// Rows and their shares of the mass.
    Barycentre(Vec<(usize, f64)>),
    /// The first row seen from the second.
    Relative(usize, usize),
}

/// One row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    /// The name in the table.
    pub name: String,
    /// The time as the table says it.
    pub date: f64,
    /// The time of the scene, in s.
    pub time: f64,
    /// Its row in the table.
    pub row: usize,
    body: Body,
    position: [f64; 3],
}

/// The table, by time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Targets {
    /// The domain compared.
    pub domain: String,
    /// The rows that can be compared, by time, then as in the table.
    pub list: Vec<Target>,
    /// Names in the table that the scene does not have.
    pub skipped: Vec<String>,
}

impl Target {
    /// Distance of the state from the position known, in m; NaN where the state has no such position.
    pub fn distance<P: Precision>(&self, state: &State<P>, domain: &str) -> f64 {
        let at = |row: usize| match state.numbers(domain, Position) {
            Ok(numbers) => numbers.get(3 * row..3 * row + 3).map_or(DVec3::NAN, DVec3::from_slice),
            Err(_) => DVec3::NAN,
        };
        let place = match &self.body {
            Body::Row(row) => at(*row),
            Body::Barycentre(members) => members.iter().map(|&(row, share)| at(row) * share).sum(),
            Body::Relative(row, from) => at(*row) - at(*from),
        };
        (place - DVec3::from_array(self.position)).length()
    }
}

/// Reads the table of `scene.compare`, whose times count from `start`, in s.
///
/// # Errors
/// The table cannot be read, lacks a column, or names no row of the domain.
pub fn targets(scene: &Scene, compare: &Compare, start: f64) -> Result<Targets, Vec<SceneFault>> {
    let csv = &compare.csv;
    let at = |text: String, help| vec![scene.fault(csv.span, text, help)];
    let text =
        scene.files.read(&csv.value).map_err(|error| at(format!("cannot read `{}`: {error}", csv.value), None))?;
    let table = Table::parse(&csv.value, &text)?;
    let mut faults = Vec::new();
    let mut find = |column: &Spanned<String>| match table.find(&column.value) {
        Ok(place) => Some(place),
        Err((text, help)) => {
            faults.push(scene.fault(column.span, text, help));
            None
        }
    };
    let name = find(&compare.name);
    let time = find(&compare.time.column);
    let position: Vec<_> = compare.position.iter().map(&mut find).collect();
    let mut numbers = |place: Option<usize>| match table.numbers(place?) {
        Ok(numbers) => Some(numbers),
        Err(more) => {
            faults.extend(more);
            None
        }
    };
    let time = numbers(time);
    let position: Vec<_> = position.into_iter().map(&mut numbers).collect();
    let domain = scene.domain(&compare.domain.value);
    let bodies = domain.map(|domain| bodies(scene, compare, domain)).transpose();
    let bodies = bodies.map_err(|more| faults.extend(more)).ok().flatten();
    if !faults.is_empty() {
        return Err(faults);
    }
    let (Some(name), Some(time), Some(bodies)) = (name, time, bodies) else {
        return Err(at("there is nothing to compare".to_owned(), None));
    };
    let [Some(x), Some(y), Some(z)] = &position[..] else {
        return Err(at("expected 3 columns of a position".to_owned(), None));
    };
    let size = |unit: &Option<Spanned<String>>| {
        unit.as_ref().and_then(|unit| Unit::parse(&unit.value).ok()).map_or(1.0, |unit| unit.scale)
    };
    let (second, metre) = (size(&compare.time.unit), size(&compare.unit));
    let mut targets = Targets { domain: compare.domain.value.clone(), ..Targets::default() };
    for (row, name) in table.texts(name).into_iter().enumerate() {
        match bodies.iter().find(|(known, _)| known == name) {
            Some((_, body)) => targets.list.push(Target {
                name: name.to_owned(),
                date: time[row],
                time: start + (time[row] - compare.time.origin) * second,
                row,
                body: body.clone(),
                position: [x[row] * metre, y[row] * metre, z[row] * metre],
            }),
            None if targets.skipped.iter().any(|known| known == name) => {}
            None => targets.skipped.push(name.to_owned()),
        }
    }
    if targets.list.is_empty() {
        let known: Vec<&str> = bodies.iter().map(|(name, _)| name.as_str()).collect();
        let help = format!("the scene has {}", known.join(", "));
        return Err(at(format!("`{}` names no row of `{}`", csv.value, compare.domain.value), Some(help)));
    }
    targets.list.sort_by(|a, b| a.time.total_cmp(&b.time));
    Ok(targets)
}

/// What each name means: labels of rows, centres of mass, relative positions.
fn bodies(scene: &Scene, compare: &Compare, domain: &DomainData) -> Result<Vec<(String, Body)>, Vec<SceneFault>> {
    let labels = domain.labels.as_deref().unwrap_or_default();
    let row = |label: &Spanned<String>| labels.iter().position(|known| *known == label.value);
    let mut bodies: Vec<(String, Body)> = Vec::new();
    let masses = ["mass", "standard_gravitational_parameter"].iter().find_map(|name| domain.column(name));
    for (name, members) in &compare.barycentres {
        let rows: Vec<usize> = members.iter().filter_map(row).collect();
        let mass = |row: usize| masses.and_then(|column| column.values.get(row).copied()).unwrap_or(0.0);
        let total: f64 = rows.iter().map(|&row| mass(row)).sum();
        if total == 0.0 {
            let text = format!("the rows of `{}` have no mass and no standard_gravitational_parameter", name.value);
            return Err(vec![scene.fault(name.span, text, None)]);
        }
        let shares = rows.iter().map(|&row| (row, mass(row) / total)).collect();
        bodies.push((name.value.clone(), Body::Barycentre(shares)));
    }
    for (name, [label, from]) in &compare.relative {
        if let (Some(label), Some(from)) = (row(label), row(from)) {
            bodies.push((name.value.clone(), Body::Relative(label, from)));
        }
    }
    // A name of the scene's own goes before a label.
    for (row, label) in labels.iter().enumerate() {
        bodies.push((label.clone(), Body::Row(row)));
    }
    Ok(bodies)
}
