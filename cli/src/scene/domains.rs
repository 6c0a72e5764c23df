//! Sections `[domains]` and `[generate]`: columns as they are written, and who else fills them.
//!
//! In: nodes of the tree. Out: [`DomainData`] and [`GenerateRequest`]. Never: knows a property; any key of a domain
//! except `from`, `units` and `name` is a column, and columns that no law uses are no fault.

use super::data::{ColumnData, CsvColumn, DomainData, FromCsv, GenerateRequest};
use super::tree::{Node, Table, Value};
use super::walk::Walk;
use crate::fault::{Span, Spanned, help_for};
use crate::generate;

/// A column in which everything is wrong is not listed item by item.
const MOST_FAULTS_OF_A_COLUMN: usize = 20;

/// All of `[domains]`.
pub(crate) fn domains(walk: &mut Walk, node: &Node) -> Vec<DomainData> {
    let Some(table) = walk.table(node, "a table of domains") else { return Vec::new() };
    table.entries.iter().map(|entry| domain(walk, &entry.key, entry.key_span, &entry.node)).collect()
}

/// One domain; it is there even where its columns are wrong, so that links to it are not faulted as well.
fn domain(walk: &mut Walk, name: &str, span: Span, node: &Node) -> DomainData {
    let mut data = DomainData::new(Spanned::new(name.to_owned(), span));
    let Some(table) = walk.table(node, "a table of columns") else { return data };
    for entry in &table.entries {
        match entry.key.as_str() {
            "from" => data.from = from_csv(walk, table, entry.key_span, &entry.node),
            "units" if table.get("from").is_some() => {}
            "units" => {
                let help = "write `{ value = [..], unit = \"..\" }` in the column".to_owned();
                walk.fault(entry.key_span, "`units` belongs to `from`, which is not here", Some(help));
            }
            "name" => {
                data.labels_span = entry.node.span;
                data.labels = walk.texts(&entry.node).map(|labels| labels.into_iter().map(|l| l.value).collect());
            }
            _ => data.columns.extend(column(walk, &entry.key, entry.key_span, &entry.node)),
        }
    }
    data
}

/// One column: a list, or a table with `value` and `unit`, `rows` (a subset) or `domain` (a link).
fn column(walk: &mut Walk, name: &str, name_span: Span, node: &Node) -> Option<ColumnData> {
    let mut data = ColumnData {
        name: Spanned::new(name.to_owned(), name_span),
        width: 1,
        rows: 0,
        values: Vec::new(),
        subset: None,
        link: None,
        unit: None,
        span: node.span,
        row_spans: Vec::new(),
    };
    let list = match &node.value {
        Value::Table(table) => {
            let place = format!("column `{name}`");
            walk.known_keys(table, &place, &["value", "unit", "rows", "domain"]);
            let before = walk.count();
            data.unit = table.get("unit").and_then(|unit| walk.unit(unit));
            data.link = table.get("domain").and_then(|domain| walk.text(domain));
            data.subset = table.get("rows").and_then(|rows| subset(walk, rows));
            if let (Some(unit), Some(_)) = (table.get("unit"), &data.link) {
                walk.fault(unit.span, "a link has no unit", None);
            }
            let value = walk.required(table, "value", name_span, &place)?;
            if walk.count() > before {
                // The values are still read for their own faults.
                read_rows(walk, value, &mut data);
                return None;
            }
            value
        }
        _ => node,
    };
    read_rows(walk, list, &mut data)?;
    match &data.subset {
        Some(subset) if subset.len() != data.rows => {
            let text =
                format!("`rows` names {}, `value` has {}", plural(subset.len(), "row"), plural(data.rows, "row"));
            walk.fault(list.span, text, None);
            None
        }
        _ => Some(data),
    }
}

fn subset(walk: &mut Walk, node: &Node) -> Option<Vec<Spanned<usize>>> {
    let items = walk.list(node, "a list of row numbers")?;
    let read: Vec<Option<Spanned<usize>>> = items.iter().map(|item| walk.count_from(item, 0)).collect();
    let rows: Vec<Spanned<usize>> = read.into_iter().collect::<Option<_>>()?;
    let mut order: Vec<&Spanned<usize>> = rows.iter().collect();
    order.sort_by_key(|row| (row.value, row.span));
    if let Some(pair) = order.windows(2).find(|pair| pair[0].value == pair[1].value) {
        walk.fault(pair[1].span, format!("row {} is named twice", pair[1].value), None);
        return None;
    }
    Some(rows)
}

/// Reads the items of a column into `data`: numbers or vectors, all of one width.
fn read_rows(walk: &mut Walk, node: &Node, data: &mut ColumnData) -> Option<()> {
    let Value::List(items) = &node.value else {
        let help = match node.value {
            Value::Number { .. } => Some("one entry for each row: [..]".to_owned()),
            _ => None,
        };
        let text = format!("expected a list with an entry for each row, found {}", node.value.described());
        walk.fault(node.span, text, help);
        return None;
    };
    let before = walk.count();
    let width_of = |item: &Node| match &item.value {
        Value::List(components) => components.len(),
        _ => 1,
    };
    data.width = items.first().map_or(1, width_of);
    data.rows = items.len();
    for item in items {
        if walk.count() >= before + MOST_FAULTS_OF_A_COLUMN {
            break;
        }
        data.row_spans.push(item.span);
        let components = match &item.value {
            Value::List(components) => components.as_slice(),
            _ => std::slice::from_ref(item),
        };
        if components.is_empty() {
            walk.fault(item.span, "expected a number or a vector, found an empty list", None);
        } else if components.len() != data.width && data.width > 0 {
            let text = format!("this item has {}, the first has {}", plural(components.len(), "component"), data.width);
            walk.fault(item.span, text, None);
        }
        for component in components {
            if data.link.is_some() {
                data.values.extend(walk.count_from(component, 0).map(|row| row.value as f64));
            } else {
                data.values.extend(walk.number(component));
            }
        }
    }
    (walk.count() == before).then_some(())
}

/// `from` and `units`.
fn from_csv(walk: &mut Walk, domain: &Table, span: Span, node: &Node) -> Option<FromCsv> {
    let table = walk.table(node, "a table like { csv = \"..\", position = [..] }")?;
    let csv = walk.required(table, "csv", span, "`from`").and_then(|csv| walk.text(csv));
    let mut columns = Vec::new();
    let mut label = None;
    let mut whole = true;
    for entry in table.entries.iter().filter(|entry| entry.key != "csv") {
        let texts = walk.texts(&entry.node);
        whole &= texts.is_some();
        let Some(mut cells) = texts else { continue };
        if cells.is_empty() {
            walk.fault(entry.node.span, "expected the columns of the file, found an empty list", None);
            whole = false;
        } else if entry.key == "name" {
            if cells.len() > 1 {
                walk.fault(entry.node.span, "expected one column of the file, for `name` is one text", None);
                whole = false;
            }
            label = cells.pop();
        } else {
            let property = Spanned::new(entry.key.clone(), entry.key_span);
            columns.push(CsvColumn { property, cells, unit: None });
        }
    }
    if let Some(units) = domain.get("units") {
        for entry in walk.table(units, "a table of units").map_or(&[][..], |units| &units.entries) {
            let unit = walk.unit(&entry.node);
            match columns.iter_mut().find(|column| column.property.value == entry.key) {
                Some(column) => {
                    whole &= unit.is_some();
                    column.unit = unit;
                }
                None => {
                    let known = columns.iter().map(|column| column.property.value.as_str());
                    let help = help_for(&entry.key, known);
                    walk.fault(entry.key_span, format!("`from` fills no column `{}`", entry.key), help);
                }
            }
        }
    }
    whole.then_some(FromCsv { csv: csv?, columns, label })
}

/// All of `[generate]`.
pub(crate) fn generates(walk: &mut Walk, node: &Node) -> Vec<GenerateRequest> {
    let Some(table) = walk.table(node, "a table of generators") else { return Vec::new() };
    table
        .entries
        .iter()
        .filter_map(|entry| {
            let domain = Spanned::new(entry.key.clone(), entry.key_span);
            let options = walk.table(&entry.node, "a table like { kind = \"galaxy\", count = 100 }")?;
            let place = format!("[generate.{}]", entry.key);
            let parameters: Vec<_> = options
                .entries
                .iter()
                .filter(|option| option.key != "kind")
                .map(|option| walk.parameter(&option.key, option.key_span, &option.node))
                .collect();
            let kind = walk.required(options, "kind", entry.key_span, &place).and_then(|kind| walk.text(kind))?;
            if generate::kind(&kind.value).is_none() {
                let help = help_for(&kind.value, generate::KINDS.iter().map(|kind| kind.name));
                walk.fault(kind.span, format!("no generator is named `{}`", kind.value), help);
                return None;
            }
            Some(GenerateRequest { domain, kind, options: parameters.into_iter().collect::<Option<_>>()? })
        })
        .collect()
}

/// "1 row", "2 rows".
pub(crate) fn plural(n: usize, noun: &str) -> String {
    if n == 1 { format!("1 {noun}") } else { format!("{n} {noun}s") }
}
