//! The parse tree of a scene: what TOML says, with every value's place, in the order of the file.
//!
//! In: TOML text. Out: a [`Table`] that owns its text, so that `--set` arguments can be grafted into it. Never: knows
//! which keys a scene has. `toml`'s own tree iterates in alphabetical order and borrows one text; this one does neither.

use toml::de::{DeTable, DeValue};

use super::brackets::without_open_entries;
use crate::fault::{Span, nearest};

/// What stands in one place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Value {
    Text(String),
    /// A number; `whole` where it was written as an integer that fits.
    Number {
        value: f64,
        whole: Option<i64>,
    },
    Flag(bool),
    Date,
    List(Vec<Node>),
    Table(Table),
}

impl Value {
    /// What it is, for "expected a number, found text".
    pub(crate) fn described(&self) -> &'static str {
        match self {
            Value::Text(_) => "text",
            Value::Number { value, .. } if value.is_nan() => "nan",
            Value::Number { value, .. } if value.is_infinite() => "inf",
            Value::Number { .. } => "a number",
            Value::Flag(_) => "true or false",
            Value::Date => "a date",
            Value::List(_) => "a list",
            Value::Table(_) => "a table",
        }
    }
}

/// A value and its place.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Node {
    pub(crate) value: Value,
    pub(crate) span: Span,
}

/// A key, its place, and what it is set to.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Entry {
    pub(crate) key: String,
    pub(crate) key_span: Span,
    pub(crate) node: Node,
}

/// The entries of a table, in the order of the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Table {
    pub(crate) entries: Vec<Entry>,
}

impl Table {
    pub(crate) fn get(&self, key: &str) -> Option<&Node> {
        self.entries.iter().find(|entry| entry.key == key).map(|entry| &entry.node)
    }

    pub(crate) fn get_mut(&mut self, key: &str) -> Option<&mut Node> {
        self.entries.iter_mut().find(|entry| entry.key == key).map(|entry| &mut entry.node)
    }

    pub(crate) fn keys(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.key.as_str())
    }

    /// Puts `node` under `key`, in place of what was there.
    pub(crate) fn put(&mut self, key: &str, key_span: Span, node: Node) {
        match self.entries.iter_mut().find(|entry| entry.key == key) {
            Some(entry) => (entry.key_span, entry.node) = (key_span, node),
            None => self.entries.push(Entry { key: key.to_owned(), key_span, node }),
        }
    }
}

/// A syntax fault: place and words.
pub(crate) type SyntaxFault = (Span, String);

/// The tree of a whole file whose bytes begin at `base`, with everything that is not TOML in it.
pub(crate) fn document(text: &str, base: usize) -> (Table, Vec<SyntaxFault>) {
    let (table, errors) = DeTable::parse_recoverable(text);
    if errors.is_empty() {
        return (table_of(table.get_ref(), base), Vec::new());
    }
    let (text, open) = without_open_entries(text);
    let (table, errors) = DeTable::parse_recoverable(&text);
    let mut faults: Vec<SyntaxFault> = open.into_iter().map(|(range, text)| (shifted(range, base), text)).collect();
    faults.extend(errors.iter().map(|error| syntax_fault(&text, base, error)));
    (table_of(table.get_ref(), base), faults)
}

/// The tree of one value whose bytes begin at `base`, as in a `--set` argument.
pub(crate) fn value(text: &str, base: usize) -> Result<Node, Vec<SyntaxFault>> {
    let (value, errors) = DeValue::parse_recoverable(text);
    if errors.is_empty() {
        let range = value.span();
        return Ok(Node { value: value_of(value.get_ref(), base), span: shifted(range, base) });
    }
    Err(errors.iter().map(|error| syntax_fault(text, base, error)).collect())
}

fn syntax_fault(text: &str, base: usize, error: &toml::de::Error) -> SyntaxFault {
    let range = error.span().unwrap_or(0..0);
    let line_ends = text.get(range.end..).is_none_or(|rest| {
        let rest = rest.trim_start_matches([' ', '\t', '\r']);
        rest.is_empty() || rest.starts_with(['\n', '#'])
    });
    let message = error.message();
    // The parser calls every piece it cannot read a string without quotes, also where there is no piece at all.
    let message = match message.strip_prefix("string values must be quoted") {
        Some(_) if range.is_empty() && line_ends => "a value is missing here",
        Some(_) => "text must stand in quotes",
        // `precision = f64`: the parser takes a bare word with t or f for a slip in `true` or `false`.
        None if message.starts_with("invalid boolean") => {
            match text.get(range.clone()).and_then(|word| nearest(word, ["true", "false"])) {
                Some(near) => return (shifted(range, base), format!("expected `{near}`, or text in quotes")),
                None => "text must stand in quotes",
            }
        }
        None => message,
    };
    (shifted(range, base), message.to_owned())
}

fn shifted(range: std::ops::Range<usize>, base: usize) -> Span {
    Span { start: range.start + base, end: range.end + base }
}

fn table_of(table: &DeTable<'_>, base: usize) -> Table {
    let mut entries: Vec<Entry> = table
        .iter()
        .map(|(key, node)| Entry {
            key: key.get_ref().to_string(),
            key_span: shifted(key.span(), base),
            node: Node { value: value_of(node.get_ref(), base), span: shifted(node.span(), base) },
        })
        .collect();
    entries.sort_by_key(|entry| entry.key_span);
    Table { entries }
}

fn value_of(value: &DeValue<'_>, base: usize) -> Value {
    match value {
        DeValue::String(text) => Value::Text(text.to_string()),
        DeValue::Integer(integer) => {
            let whole = i64::from_str_radix(integer.as_str(), integer.radix()).ok();
            let wide = i128::from_str_radix(integer.as_str(), integer.radix()).ok();
            // Beyond 128 bits only decimal digits are left to read; f64 reads those of any length.
            let value = wide.map_or_else(|| integer.as_str().parse().unwrap_or(f64::NAN), |wide| wide as f64);
            Value::Number { value, whole }
        }
        // An exponent beyond f64 reads as inf, which is then faulted where inf may not stand.
        DeValue::Float(float) => Value::Number { value: float.as_str().parse().unwrap_or(f64::NAN), whole: None },
        DeValue::Boolean(flag) => Value::Flag(*flag),
        DeValue::Datetime(_) => Value::Date,
        DeValue::Array(items) => Value::List(
            items
                .iter()
                .map(|item| Node { value: value_of(item.get_ref(), base), span: shifted(item.span(), base) })
                .collect(),
        ),
        DeValue::Table(table) => Value::Table(table_of(table, base)),
    }
}
