//! From what the client gave to a state, or to all that is wrong with it.

use super::{DomainState, State, fresh_identity};
use crate::column::{Aligned, Column, Storage};
use crate::dimension::Unit;
use crate::domain::{AsProperty, Domain, Given, GivenValues, SCENE};
use crate::error::{Fault, Faults, nearest, per_row};
use crate::field::Field;
use crate::property::{Kind, PropertyInfo, Time};
use crate::real::{Scalar, Vector};
use std::sync::Arc;

impl<P: Scalar> State<P> {
    /// Checks what the client gave and makes a state of it.
    ///
    /// # Errors
    /// Everything that is wrong: twice given, wrong kind, wrong unit, wrong length, not finite, out of range.
    pub fn new(
        domains: impl IntoIterator<Item = Domain<P>>,
        fields: impl IntoIterator<Item = (PropertyInfo, Arc<dyn Field<P>>)>,
    ) -> Result<Self, Faults> {
        Self::checked(domains, fields, None)
    }

    /// The same; `before` says how many rows a domain already has, before those given, for links to it.
    pub(super) fn checked(
        domains: impl IntoIterator<Item = Domain<P>>,
        fields: impl IntoIterator<Item = (PropertyInfo, Arc<dyn Field<P>>)>,
        before: Option<(&str, usize)>,
    ) -> Result<Self, Faults> {
        let mut faults = Vec::new();
        let mut scene = Domain::new(SCENE).rows(1).with(Time, [0.0]);
        let mut given: Vec<Domain<P>> = Vec::new();
        let mut clock_given = false;
        for domain in domains {
            if domain.name == SCENE {
                for column in domain.columns {
                    // The time is there from the start, so that laws may always read it; a client may set its start.
                    // It stays the first column.
                    if column.info.name == Time.info().name && !clock_given {
                        clock_given = true;
                        scene.columns[0] = column;
                    } else {
                        scene.columns.push(column);
                    }
                }
            } else if given.iter().any(|other| other.name == domain.name) {
                faults.push(Fault::DomainTwice { domain: domain.name.clone() });
            } else {
                given.push(domain);
            }
        }
        given.insert(0, scene);

        let mut rows: Vec<(String, usize)> =
            given.iter().map(|domain| (domain.name.clone(), rows_of(domain).0)).collect();
        for (name, rows) in &mut rows {
            *rows = rows.saturating_add(before.filter(|(known, _)| known == name).map_or(0, |(_, rows)| rows));
        }
        let large = |rows: &usize| u32::try_from(*rows).is_err();
        let too_many = rows.iter().filter(|(_, rows)| large(rows));
        faults.extend(too_many.map(|(name, rows)| Fault::TooManyRows { domain: name.clone(), rows: *rows }));
        if rows.iter().any(|(_, rows)| large(rows)) {
            // Columns of such a domain cannot even be made.
            Faults::unless_empty(core::mem::take(&mut faults), ())?;
        }
        lent_twice(&given, &mut faults);
        let mut stream = 0;
        let states = given
            .into_iter()
            .map(|domain| {
                let (count, by) = rows_of(&domain);
                let mut state =
                    DomainState { name: domain.name.clone(), rows: count, columns: Vec::new(), previous: Vec::new() };
                for column in domain.columns {
                    if state.find(column.info.name).is_some() {
                        faults.push(Fault::ColumnTwice {
                            domain: domain.name.clone(),
                            property: column.info.name.to_owned(),
                        });
                        continue;
                    }
                    let check = Check { domain: &domain.name, rows: count, by: &by, all: &rows };
                    match check.column(column, stream, &mut faults) {
                        Some(column) => {
                            stream += column.info.kind.width();
                            state.columns.push(column);
                        }
                        None => debug_assert!(!faults.is_empty(), "a column is refused with a reason"),
                    }
                }
                state
            })
            .collect();
        let mut kept: Vec<(PropertyInfo, Arc<dyn Field<P>>)> = Vec::new();
        for (property, field) in fields {
            if kept.iter().any(|(other, _)| other.name == property.name) {
                faults.push(Fault::FieldTwice { field: property.name.to_owned() });
            } else {
                let value = field.uniform().map(|value| [value.x(), value.y(), value.z()]);
                if let Some(number) = value.into_iter().flatten().find(|number| !number.is_finite()) {
                    faults.push(Fault::FieldNotFinite { field: property.name.to_owned(), value: number.to_f64() });
                }
                kept.push((property, field));
            }
        }
        Faults::unless_empty(
            faults,
            State { domains: states, fields: kept, origin: None, identity: fresh_identity(), version: 0 },
        )
    }
}

/// The number of rows, and what says so: the statement, or else the first column that has a value for every row.
fn rows_of<P: Scalar>(domain: &Domain<P>) -> (usize, String) {
    if let Some(rows) = domain.rows {
        let by = if domain.name == SCENE { "one value of each constant" } else { "as stated" };
        return (rows, by.to_owned());
    }
    domain
        .columns
        .iter()
        .find(|column| column.subset.is_none())
        .map_or((0, "for no column counts them".to_owned()), |column| {
            (values_in(column), format!("counted by {}", column.info.name))
        })
}

fn values_in<P: Scalar>(column: &Given<P>) -> usize {
    match &column.values {
        GivenValues::Numbers(values) => values.rows(),
        GivenValues::Lent(memory) => memory.rows(),
        GivenValues::Links { arity, rows, .. } => rows.len() / (*arity).max(1),
    }
}

/// Memory that is lent to two columns: laws could not tell whose numbers they change.
fn lent_twice<P: Scalar>(domains: &[Domain<P>], faults: &mut Vec<Fault>) {
    let mut known: Vec<(*const (), String)> = Vec::new();
    for (domain, column) in domains.iter().flat_map(|domain| domain.columns.iter().map(move |column| (domain, column)))
    {
        let GivenValues::Lent(memory) = &column.values else { continue };
        let name = column.info.name;
        if domain.name == SCENE {
            faults.push(Fault::client_memory(
                SCENE,
                name,
                "hold a constant",
                "can change while laws run: give the value",
            ));
        }
        if let Some((_, first)) = known.iter().find(|(other, _)| *other == memory.identity()) {
            faults.push(Fault::lent_twice(&domain.name, name, first));
        }
        known.push((memory.identity(), format!("{}.{name}", domain.name)));
    }
}

/// Checks of one domain's columns.
struct Check<'a> {
    domain: &'a str,
    rows: usize,
    by: &'a str,
    all: &'a [(String, usize)],
}

impl Check<'_> {
    fn column<P: Scalar>(&self, column: Given<P>, stream: usize, faults: &mut Vec<Fault>) -> Option<Column<P>> {
        let before = faults.len();
        let given = values_in(&column);
        self.kind(&column, faults);
        // A constant is there for its one row, or not at all.
        let subset = column.subset.as_ref().filter(|_| self.domain != SCENE);
        let expected = subset.map_or(self.rows, Vec::len);
        if faults.len() == before && given != expected {
            let (domain, property) = (self.domain.to_owned(), column.info.name.to_owned());
            faults.push(match subset {
                Some(_) => Fault::SubsetLength { domain, property, given, expected },
                None => Fault::Length { domain, property, given, expected, expected_by: self.by.to_owned() },
            });
        }
        let order = self.subset(&column, faults);
        let scale = self.scale(&column, faults);
        if faults.len() > before {
            return None;
        }
        let width = column.info.kind.width();
        let storage = match column.values {
            GivenValues::Numbers(values) => {
                self.finite(&column.info, &values.numbers, width, faults);
                let mut components: Vec<Aligned<P>> =
                    (0..width).map(|c| Aligned::zeros(expected, stream + c)).collect();
                for (to, &from) in order.iter().enumerate() {
                    for (c, component) in components.iter_mut().enumerate() {
                        component.as_mut_slice()[to] = P::from_f64(values.numbers[from * width + c] * scale);
                    }
                }
                self.in_range(&column.info, &values.numbers, scale, &components, &order, faults);
                Storage::Split(components)
            }
            GivenValues::Lent(memory) => {
                if memory.busy(false) {
                    let (domain, property) = (self.domain.to_owned(), column.info.name.to_owned());
                    faults.push(Fault::Borrowed { domain, property });
                }
                Storage::Lent(memory)
            }
            GivenValues::Links { target, rows, .. } => {
                self.links(&column.info, &target, &rows, faults);
                Storage::Link { target, arity: width, rows }
            }
        };
        let subset = column.subset.map(|mut rows| {
            rows.sort_unstable();
            rows
        });
        (faults.len() == before).then_some(Column {
            away: None,
            info: column.info,
            storage,
            subset,
            given: true,
            shown: true,
        })
    }

    fn kind<P: Scalar>(&self, column: &Given<P>, faults: &mut Vec<Fault>) {
        let expected = column.info.kind;
        let is_link = matches!(expected, Kind::Link(_));
        if expected == Kind::Link(0) {
            let (domain, property) = (self.domain.to_owned(), column.info.name.to_owned());
            faults.push(Fault::LinkToNone { domain, property });
            return;
        }
        let given = match &column.values {
            GivenValues::Numbers(values) if is_link || values.width != expected.width() => per_row(values.width),
            GivenValues::Numbers(values) if values.numbers.len() % values.width != 0 => {
                format!("{} numbers in all", values.numbers.len())
            }
            GivenValues::Lent(memory) if is_link || memory.width() != expected.width() => per_row(memory.width()),
            GivenValues::Links { arity, .. } if expected != Kind::Link(*arity) => {
                format!("a {}", Kind::Link(*arity))
            }
            GivenValues::Links { arity, rows, .. } if rows.len() % arity != 0 => format!("{} rows in all", rows.len()),
            _ => return,
        };
        faults.push(Fault::Kind {
            domain: self.domain.to_owned(),
            property: column.info.name.to_owned(),
            expected: expected.to_string(),
            given: format!("given as {given}"),
            mend: match expected {
                Kind::Link(arity) => format!("{arity} rows of a domain for each row, `.link(..)`"),
                _ => per_row(expected.width()),
            },
        });
    }

    /// Where each value of a subset goes: the order of its rows.
    fn subset<P: Scalar>(&self, column: &Given<P>, faults: &mut Vec<Fault>) -> Vec<usize> {
        let Some(rows) = &column.subset else { return (0..self.rows).collect() };
        let mut order: Vec<usize> = (0..rows.len()).collect();
        order.sort_by_key(|&index| rows[index]);
        for pair in order.windows(2) {
            if rows[pair[0]] == rows[pair[1]] {
                faults.push(Fault::SubsetTwice {
                    domain: self.domain.to_owned(),
                    property: column.info.name.to_owned(),
                    row: rows[pair[0]],
                });
            }
        }
        for &row in rows.iter().filter(|&&row| row as usize >= self.rows) {
            faults.push(Fault::SubsetRange {
                domain: self.domain.to_owned(),
                property: column.info.name.to_owned(),
                row,
                rows: self.rows,
            });
        }
        order
    }

    /// Takes the given unit to the property's own.
    fn scale<P: Scalar>(&self, column: &Given<P>, faults: &mut Vec<Fault>) -> f64 {
        let Some(text) = column.unit else { return 1.0 };
        match Unit::parse(text) {
            Err(error) => faults.push(Fault::Unit {
                place: format!("{}.{}", self.domain, column.info.name),
                unit: text.to_owned(),
                reason: error.message(text),
            }),
            Ok(unit) => match unit.factor_to(column.info.size) {
                Some(factor) => return factor,
                None => faults.push(Fault::Dimension {
                    domain: self.domain.to_owned(),
                    property: column.info.name.to_owned(),
                    given: text.to_owned(),
                    expected: column.info.unit.to_owned(),
                }),
            },
        }
        1.0
    }

    fn finite(&self, info: &PropertyInfo, numbers: &[f64], width: usize, faults: &mut Vec<Fault>) {
        if let Some(at) = numbers.iter().position(|number| !number.is_finite()) {
            faults.push(Fault::NotFinite {
                domain: self.domain.to_owned(),
                property: info.name.to_owned(),
                row: at / width.max(1),
                value: numbers[at],
            });
        }
    }

    /// A finite number that is infinite in the state's precision.
    fn in_range<P: Scalar>(
        &self,
        info: &PropertyInfo,
        numbers: &[f64],
        scale: f64,
        components: &[Aligned<P>],
        order: &[usize],
        faults: &mut Vec<Fault>,
    ) {
        let width = components.len();
        let lost = |k: usize| !components[k % width].as_slice()[k / width].is_finite();
        let Some(at) = (0..order.len() * width).find(|&k| lost(k)) else { return };
        let from = order[at / width];
        let value = numbers[from * width + at % width];
        if value.is_finite() {
            faults.push(Fault::OutOfPrecision {
                domain: self.domain.to_owned(),
                property: info.name.to_owned(),
                row: from,
                value: value * scale,
                precision: P::NAME.to_owned(),
            });
        }
    }

    fn links(&self, info: &PropertyInfo, target: &str, links: &[u32], faults: &mut Vec<Fault>) {
        let Some((_, rows)) = self.all.iter().find(|(name, _)| name == target) else {
            faults.push(Fault::LinkTarget {
                domain: self.domain.to_owned(),
                property: info.name.to_owned(),
                target: target.to_owned(),
                nearest: nearest(target, self.all.iter().map(|(name, _)| name.as_str())),
            });
            return;
        };
        if let Some(at) = links.iter().position(|&row| row as usize >= *rows) {
            faults.push(Fault::LinkRange {
                domain: self.domain.to_owned(),
                property: info.name.to_owned(),
                row: at / info.kind.width(),
                target: target.to_owned(),
                target_row: links[at],
                rows: *rows,
            });
        }
    }
}
