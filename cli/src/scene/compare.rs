//! Section `[compare]`: positions known from elsewhere, to print distances from.
//!
//! In: nodes of the tree. Out: [`Compare`]. Never: reads the file it names.

use super::data::{Compare, CompareTime};
use super::tree::{Node, Table, Value};
use super::walk::Walk;
use crate::fault::{Span, Spanned};

const KEYS: [&str; 9] = ["csv", "time", "position", "unit", "name", "domain", "without", "barycentres", "relative"];

/// `[compare]`.
pub(crate) fn compare(walk: &mut Walk, span: Span, node: &Node) -> Option<Compare> {
    let table = walk.table(node, "a table")?;
    walk.known_keys(table, "[compare]", &KEYS);
    let text = |walk: &mut Walk, key| walk.required(table, key, span, "[compare]").and_then(|node| walk.text(node));
    let csv = text(walk, "csv");
    let name = text(walk, "name");
    let domain = text(walk, "domain");
    let time = walk.required(table, "time", span, "[compare]").and_then(|node| time(walk, node));
    let position = walk.required(table, "position", span, "[compare]").and_then(|node| {
        let columns = walk.texts(node)?;
        if columns.len() != 3 {
            walk.fault(node.span, format!("expected 3 columns, found {}", columns.len()), None);
            return None;
        }
        Some(columns)
    });
    let unit = match table.get("unit") {
        Some(unit) => walk.unit(unit).map(|unit| walk.factor(&unit, "m").map(|_| Some(unit))).unwrap_or(None),
        None => Some(None),
    };
    let without = table.get("without").map_or(Some(Vec::new()), |node| walk.texts(node));
    let barycentres = named_lists(walk, table, "barycentres");
    let relative = named_lists(walk, table, "relative").and_then(|lists| {
        let pairs: Vec<_> = lists
            .into_iter()
            .map(|(name, labels)| match <[Spanned<String>; 2]>::try_from(labels) {
                Ok(pair) => Some((name, pair)),
                Err(labels) => {
                    let text = format!("expected 2 labels, a row and the row it is seen from, found {}", labels.len());
                    walk.fault(name.span, text, None);
                    None
                }
            })
            .collect();
        pairs.into_iter().collect::<Option<Vec<_>>>()
    });
    Some(Compare {
        csv: csv?,
        time: time?,
        position: position?,
        unit: unit?,
        name: name?,
        domain: domain?,
        without: without?,
        barycentres: barycentres?,
        relative: relative?,
    })
}

fn time(walk: &mut Walk, node: &Node) -> Option<CompareTime> {
    let Value::Table(table) = &node.value else {
        return Some(CompareTime { column: walk.text(node)?, unit: None, origin: 0.0 });
    };
    walk.known_keys(table, "`time`", &["column", "unit", "origin"]);
    let column = walk.required(table, "column", node.span, "`time`").and_then(|column| walk.text(column));
    let unit = match table.get("unit") {
        Some(unit) => walk.unit(unit).map(|unit| walk.factor(&unit, "s").map(|_| Some(unit))).unwrap_or(None),
        None => Some(None),
    };
    let origin = table.get("origin").map_or(Some(0.0), |origin| walk.number(origin));
    Some(CompareTime { column: column?, unit: unit?, origin: origin? })
}

type NamedLists = Vec<(Spanned<String>, Vec<Spanned<String>>)>;

fn named_lists(walk: &mut Walk, table: &Table, key: &str) -> Option<NamedLists> {
    let Some(node) = table.get(key) else { return Some(Vec::new()) };
    let lists = walk.table(node, "a table of lists of labels")?;
    let read: Vec<_> = lists
        .entries
        .iter()
        .map(|entry| {
            let labels = walk.texts(&entry.node)?;
            Some((Spanned::new(entry.key.clone(), entry.key_span), labels))
        })
        .collect();
    read.into_iter().collect()
}
