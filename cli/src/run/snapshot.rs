//! The columns that a run shows: observed ones, or else every state.
//!
//! In: a scene, an engine. Out: names of columns, and their numbers at a moment. Never: a file.

use crate::assemble::law_of;
use vesper::law::{Mode, Place};
use vesper::prelude::*;
use vesper::property::Role;

use crate::scene::Scene;

/// A column at a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// The property.
    pub property: PropertyInfo,
    /// The rows that have a value, where not all have.
    pub subset: Option<Vec<u32>>,
    /// The numbers in SI, `width` for each value; rows linked to, for a link.
    pub numbers: Vec<f64>,
}

impl Shown {
    /// Numbers in one value.
    pub fn width(&self) -> usize {
        self.property.kind.width()
    }

    /// The numbers of `row`, where it has some.
    pub fn row(&self, row: usize) -> Option<&[f64]> {
        let index = match &self.subset {
            None => row,
            Some(rows) => rows.binary_search(&u32::try_from(row).ok()?).ok()?,
        };
        self.numbers.get(index * self.width()..(index + 1) * self.width())
    }
}

/// The columns of one domain at a moment.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownDomain {
    /// The domain.
    pub name: String,
    /// Its number of rows.
    pub rows: usize,
    /// Its shown columns.
    pub columns: Vec<Shown>,
}

/// Names of the columns to show, as (domain, property).
pub fn shown_columns<P: Precision>(scene: &Scene, engine: &Engine<P>) -> Vec<(String, String)> {
    let state = engine.state();
    let mut shown: Vec<(String, String)> = Vec::new();
    let mut show = |domain: &str, property: &str| {
        let known = shown.iter().any(|(on, name)| on == domain && name == property);
        if !known && state.column(domain, property).is_ok() {
            shown.push((domain.to_owned(), property.to_owned()));
        }
    };
    if let Some(observe) = &scene.engine.observe {
        for (domain, property) in observe.iter().filter_map(|entry| entry.value.split_once('.')) {
            show(domain, property);
        }
        return shown;
    }
    for domain in state.domains() {
        // What a running law moves, and what it would move if there were one.
        let rated = |name: &str| {
            engine.report().laws.iter().any(|law| {
                matches!(law.status, Status::Active { .. })
                    && law.domain == domain.name()
                    && law_of(scene, &law.name).is_some_and(|law| {
                        let ports = law.ports.iter();
                        ports
                            .filter(|port| port.mode == Mode::Rates && port.place == Place::Own)
                            .any(|port| port.property.name == name)
                    })
            })
        };
        for column in domain.columns().iter().filter(|column| column.is_given()) {
            let property = column.property();
            if matches!(property.role, Role::Coordinate | Role::Momentum(_)) || rated(property.name) {
                show(domain.name(), property.name);
            }
        }
    }
    shown
}

/// The numbers of `columns` as they are now, domain by domain.
pub fn snapshot<P: Precision>(engine: &Engine<P>, columns: &[(String, String)]) -> Vec<ShownDomain> {
    let state = engine.state();
    let mut domains: Vec<ShownDomain> = Vec::new();
    for (domain, property) in columns {
        let (Ok(on), Ok(column)) = (state.domain(domain), state.column(domain, property)) else { continue };
        let numbers = match column.links() {
            Some((_, _, rows)) => rows.iter().map(|&row| f64::from(row)).collect(),
            None => {
                let scale = column.property().size.scale;
                let numbers = state.numbers(domain, *column.property()).unwrap_or_default();
                if scale == 1.0 { numbers } else { numbers.into_iter().map(|number| number * scale).collect() }
            }
        };
        let shown = Shown { property: *column.property(), subset: column.subset().map(<[u32]>::to_vec), numbers };
        match domains.iter_mut().find(|known| known.name == *domain) {
            Some(known) => known.columns.push(shown),
            None => domains.push(ShownDomain { name: domain.clone(), rows: on.rows(), columns: vec![shown] }),
        }
    }
    domains
}
