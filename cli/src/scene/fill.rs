//! Columns that a scene asks for and does not write: from CSV files and generators.
//!
//! In: domains and requests as read. Out: the domains with their columns added. Never: puts a column in the place of one
//! that is there; two sources of one column are a fault.

use super::data::{ColumnData, DomainData, FromCsv, GenerateRequest};
use super::files::Files;
use super::walk::Walk;
use crate::csv;
use crate::fault::{SceneFault, Span, Spanned};
use crate::generate;

/// Reads the CSV file of every domain that has one. Domains that could not be filled are named in `incomplete`.
pub(crate) fn from_files(walk: &mut Walk, domains: &mut [DomainData], files: &Files, incomplete: &mut Vec<String>) {
    for domain in domains {
        let Some(from) = domain.from.clone() else { continue };
        let before = walk.count();
        if let Some(table) = read_table(walk, &from.csv, files) {
            columns_of(walk, domain, &from, &table);
        }
        if walk.count() > before {
            incomplete.push(domain.name.value.clone());
        }
    }
}

fn read_table(walk: &mut Walk, csv: &Spanned<String>, files: &Files) -> Option<csv::Table> {
    let text = match files.read(&csv.value) {
        Ok(text) => text,
        Err(error) => {
            walk.fault(csv.span, format!("cannot read `{}`: {error}", csv.value), None);
            return None;
        }
    };
    match csv::Table::parse(&csv.value, &text) {
        Ok(table) => Some(table),
        Err(faults) => {
            foreign(walk, csv.span, faults);
            None
        }
    }
}

fn foreign(walk: &mut Walk, span: Span, faults: Vec<SceneFault>) {
    for fault in faults {
        walk.foreign_fault(span, fault);
    }
}

fn columns_of(walk: &mut Walk, domain: &mut DomainData, from: &FromCsv, table: &csv::Table) {
    let find = |walk: &mut Walk, cell: &Spanned<String>| match table.find(&cell.value) {
        Ok(place) => Some(place),
        Err((text, help)) => {
            walk.fault(cell.span, text, help);
            None
        }
    };
    if let Some(label) = &from.label
        && let Some(place) = find(walk, label)
    {
        if domain.labels.is_some() {
            walk.fault(domain.labels_span, "`name` is written here and in `from`", None);
        }
        domain.labels = Some(table.texts(place).into_iter().map(str::to_owned).collect());
        domain.labels_span = label.span;
    }
    for wanted in &from.columns {
        let mut parts = Vec::new();
        for cell in &wanted.cells {
            let Some(place) = find(walk, cell) else { continue };
            match table.numbers(place) {
                Ok(numbers) => parts.push(numbers),
                Err(faults) => foreign(walk, cell.span, faults),
            }
        }
        if parts.len() < wanted.cells.len() {
            continue;
        }
        let width = parts.len();
        let values = (0..table.rows()).flat_map(|row| parts.iter().map(move |part| part[row])).collect();
        add(
            walk,
            domain,
            ColumnData {
                name: wanted.property.clone(),
                width,
                rows: table.rows(),
                values,
                subset: None,
                link: None,
                unit: wanted.unit.clone(),
                span: wanted.property.span,
                row_spans: Vec::new(),
            },
        );
    }
}

/// Adds a column, unless the domain has it.
fn add(walk: &mut Walk, domain: &mut DomainData, column: ColumnData) {
    if let Some(there) = domain.column(&column.name.value) {
        let text = format!("column `{}` of `{}` has two sources", column.name.value, domain.name.value);
        let span = if there.row_spans.is_empty() { column.span } else { there.name.span };
        walk.fault(span, text, Some("write it, or read it from a file, or generate it".to_owned()));
        return;
    }
    domain.columns.push(column);
}

/// Runs every generator. Domains that could not be filled are named in `incomplete`.
pub(crate) fn from_generators(
    walk: &mut Walk,
    domains: &mut Vec<DomainData>,
    requests: &[GenerateRequest],
    incomplete: &mut Vec<String>,
) {
    for request in requests {
        let before = walk.count();
        let generated = run(walk, request);
        for (name, columns) in generated.map_or_else(Vec::new, |generated| generated.domains) {
            let index = domains.iter().position(|domain| domain.name.value == name).unwrap_or_else(|| {
                domains.push(DomainData::new(Spanned::new(name, request.domain.span)));
                domains.len() - 1
            });
            for column in columns {
                let span = request.kind.span;
                let column = ColumnData {
                    rows: column.values.len() / column.width.max(1),
                    name: Spanned::new(column.name, span),
                    width: column.width,
                    values: column.values,
                    subset: None,
                    link: column.link.map(|link| Spanned::new(link, span)),
                    unit: None,
                    span,
                    row_spans: Vec::new(),
                };
                add(walk, &mut domains[index], column);
            }
        }
        if walk.count() > before {
            let kind = generate::kind(&request.kind.value);
            incomplete.push(request.domain.value.clone());
            incomplete.extend(kind.iter().flat_map(|kind| kind.also_fills).map(|name| (*name).to_owned()));
        }
    }
}

fn run(walk: &mut Walk, request: &GenerateRequest) -> Option<generate::Generated> {
    let kind = generate::kind(&request.kind.value)?;
    let before = walk.count();
    let mut options = Vec::new();
    for option in &request.options {
        let mut value = option.value.clone();
        let info = kind.options.iter().find(|info| info.name == option.name.value);
        if let (Some(unit), Some(info)) = (&option.unit, info)
            && let Some(factor) = walk.factor(unit, info.unit)
        {
            value.iter_mut().for_each(|component| *component *= factor);
        }
        options.push((option.name.value.clone(), value));
    }
    let generated = generate::build(kind, &request.domain.value, &options);
    for fault in generated.as_ref().err().into_iter().flatten() {
        let option = request.options.iter().find(|option| Some(&option.name.value) == fault.option.as_ref());
        let span = match option {
            Some(option) if fault.of_name => option.name.span,
            Some(option) => option.value_span,
            None => request.kind.span,
        };
        walk.fault(span, fault.text.clone(), fault.help.clone());
    }
    if walk.count() > before { None } else { generated.ok() }
}
