//! Reading values out of the parse tree: what was expected, what was found, where.
//!
//! In: nodes of the tree. Out: plain values, or `None` with a fault noted. Never: stops, so that one run finds all.

use vesper_dimension::Unit;

use super::data::Parameter;
use super::tree::{Node, Table, Value};
use super::unit_names;
use crate::fault::{SceneFault, Sources, Span, Spanned, help_for, nearest, number};

/// The faults found so far, and the texts they point into.
#[derive(Debug, Default)]
pub(crate) struct Walk {
    pub(crate) sources: Sources,
    faults: Vec<(Span, SceneFault)>,
    /// Lines with syntax faults: what was recovered from them is not worth faulting again.
    broken_lines: Vec<(usize, usize)>,
}

impl Walk {
    /// Notes the fault `text` at `span`.
    pub(crate) fn fault(&mut self, span: Span, text: impl Into<String>, help: Option<String>) {
        if self.is_broken(span) {
            return;
        }
        let fault = self.sources.fault(span, text, help);
        self.faults.push((span, fault));
    }

    /// Notes a fault of another file, which `span` asked for.
    pub(crate) fn foreign_fault(&mut self, span: Span, fault: SceneFault) {
        self.faults.push((span, fault));
    }

    /// Notes a syntax fault: the first of each line, for the parser finds the same mistake in several ways.
    pub(crate) fn syntax_fault(&mut self, span: Span, text: String) {
        let line = self.sources.line_key(span);
        if !self.broken_lines.contains(&line) {
            self.fault(span, text, None);
            self.broken_lines.push(line);
        }
    }

    /// Whether the file was TOML at all; else the tree has gaps, and names that seem missing may only be lost.
    pub(crate) fn is_whole(&self) -> bool {
        self.broken_lines.is_empty()
    }

    /// Whether `span` begins on a line with a syntax fault.
    pub(crate) fn is_broken(&self, span: Span) -> bool {
        !self.broken_lines.is_empty() && self.broken_lines.contains(&self.sources.line_key(span))
    }

    /// Number of faults so far.
    pub(crate) fn count(&self) -> usize {
        self.faults.len()
    }

    /// All faults, by their place in the texts.
    pub(crate) fn into_faults(mut self) -> Vec<SceneFault> {
        self.faults.sort_by_key(|(span, _)| *span);
        self.faults.dedup_by(|b, a| a == b);
        self.faults.into_iter().map(|(_, fault)| fault).collect()
    }

    fn expected<T>(&mut self, what: &str, node: &Node) -> Option<T> {
        self.fault(node.span, format!("expected {what}, found {}", node.value.described()), None);
        None
    }

    pub(crate) fn table<'t>(&mut self, node: &'t Node, what: &str) -> Option<&'t Table> {
        match &node.value {
            Value::Table(table) => Some(table),
            _ => self.expected(what, node),
        }
    }

    /// Faults every key of `table` that is not in `known`.
    pub(crate) fn known_keys(&mut self, table: &Table, place: &str, known: &[&str]) {
        for entry in &table.entries {
            if !known.contains(&entry.key.as_str()) {
                let help = help_for(&entry.key, known.iter().copied());
                self.fault(entry.key_span, format!("`{}` is not known in {place}", entry.key), help);
            }
        }
    }

    /// The node under `key`, or a fault at `span`.
    pub(crate) fn required<'t>(&mut self, table: &'t Table, key: &str, span: Span, place: &str) -> Option<&'t Node> {
        let found = table.get(key);
        if found.is_none() {
            // A misspelt key that is already faulted has this one as its help.
            let near = table.entries.iter().find(|entry| nearest(&entry.key, [key]).is_some());
            let faulted = near.is_some_and(|near| self.faults.iter().any(|(span, _)| *span == near.key_span));
            if !faulted {
                let help = near.map(|near| format!("`{}` stands here: did you mean `{key}`?", near.key));
                self.fault(span, format!("{place} needs `{key}`"), help);
            }
        }
        found
    }

    pub(crate) fn text(&mut self, node: &Node) -> Option<Spanned<String>> {
        match &node.value {
            Value::Text(text) => Some(Spanned::new(text.clone(), node.span)),
            _ => self.expected("text", node),
        }
    }

    pub(crate) fn flag(&mut self, node: &Node) -> Option<Spanned<bool>> {
        match &node.value {
            Value::Flag(flag) => Some(Spanned::new(*flag, node.span)),
            _ => self.expected("true or false", node),
        }
    }

    pub(crate) fn number(&mut self, node: &Node) -> Option<f64> {
        match &node.value {
            Value::Number { value, .. } if value.is_finite() => Some(*value),
            Value::Number { value, .. } if value.is_infinite() => self.expected("a finite number", node),
            _ => self.expected("a number", node),
        }
    }

    /// A number that may be infinite: a bound of a box.
    pub(crate) fn bound(&mut self, node: &Node) -> Option<f64> {
        match &node.value {
            Value::Number { value, .. } if !value.is_nan() => Some(*value),
            _ => self.expected("a number", node),
        }
    }

    /// A whole number, at least `least`.
    pub(crate) fn count_from(&mut self, node: &Node, least: usize) -> Option<Spanned<usize>> {
        let what = format!("a whole number, {least} or more");
        match &node.value {
            Value::Number { whole: Some(whole), .. } => match usize::try_from(*whole) {
                Ok(count) if count >= least => Some(Spanned::new(count, node.span)),
                _ => {
                    self.fault(node.span, format!("expected {what}, found {whole}"), None);
                    None
                }
            },
            Value::Number { value, .. } if value.is_finite() => {
                self.fault(node.span, format!("expected {what}, found {}", number(*value)), None);
                None
            }
            _ => self.expected(&what, node),
        }
    }

    pub(crate) fn list<'t>(&mut self, node: &'t Node, what: &str) -> Option<&'t [Node]> {
        match &node.value {
            Value::List(items) => Some(items),
            _ => self.expected(what, node),
        }
    }

    /// A list of texts; a single text is a list of one.
    pub(crate) fn texts(&mut self, node: &Node) -> Option<Vec<Spanned<String>>> {
        match &node.value {
            Value::Text(text) => Some(vec![Spanned::new(text.clone(), node.span)]),
            _ => {
                let items = self.list(node, "a list of texts")?;
                let read: Vec<Option<Spanned<String>>> = items.iter().map(|item| self.text(item)).collect();
                read.into_iter().collect()
            }
        }
    }

    pub(crate) fn vector(&mut self, node: &Node, infinite: bool) -> Option<[f64; 3]> {
        let items = self.list(node, "a list of 3 numbers")?;
        let read: Vec<Option<f64>> =
            items.iter().map(|item| if infinite { self.bound(item) } else { self.number(item) }).collect();
        if let [x, y, z] = read[..] {
            return Some([x?, y?, z?]);
        }
        self.fault(node.span, format!("expected 3 numbers, found {}", items.len()), None);
        None
    }

    /// A number, or a list of numbers.
    pub(crate) fn components(&mut self, node: &Node) -> Option<Vec<f64>> {
        match &node.value {
            Value::List(items) if items.is_empty() => {
                self.fault(node.span, "expected a number or a vector, found an empty list", None);
                None
            }
            Value::List(items) => {
                let read: Vec<Option<f64>> = items.iter().map(|item| self.number(item)).collect();
                read.into_iter().collect()
            }
            Value::Number { .. } => Some(vec![self.number(node)?]),
            _ => self.expected("a number or a vector", node),
        }
    }

    /// One of a few words.
    pub(crate) fn choice<T: Copy>(&mut self, node: &Node, words: &[(&str, T)]) -> Option<Spanned<T>> {
        let text = self.text(node)?;
        if let Some((_, value)) = words.iter().find(|(word, _)| *word == text.value) {
            return Some(Spanned::new(*value, node.span));
        }
        let list: Vec<String> = words.iter().map(|(word, _)| format!("\"{word}\"")).collect();
        let near = nearest(&text.value, words.iter().map(|(word, _)| *word));
        let help = near.map(|near| format!("did you mean `{near}`?"));
        self.fault(node.span, format!("expected {}, found \"{}\"", list.join(" or "), text.value), help);
        None
    }

    /// A text that must read as a unit.
    pub(crate) fn unit(&mut self, node: &Node) -> Option<Spanned<String>> {
        let text = self.text(node)?;
        match Unit::parse(&text.value) {
            Ok(_) => Some(text),
            Err(error) => {
                let (text, help) = unit_names::message(error, &text.value);
                self.fault(node.span, text, help);
                None
            }
        }
    }

    /// A number or vector, or `{ value, unit }` of one.
    pub(crate) fn parameter(&mut self, key: &str, key_span: Span, node: &Node) -> Option<Parameter> {
        let name = Spanned::new(key.to_owned(), key_span);
        let Value::Table(table) = &node.value else {
            let value = self.components(node)?;
            return Some(Parameter { name, value, value_span: node.span, unit: None });
        };
        self.known_keys(table, &format!("`{key}`"), &["value", "unit"]);
        let unit = table.get("unit").map(|unit| self.unit(unit));
        let inner = self.required(table, "value", key_span, &format!("`{key}`"))?;
        let value = self.components(inner)?;
        let unit = match unit {
            Some(unit) => Some(unit?),
            None => None,
        };
        Some(Parameter { name, value, value_span: inner.span, unit })
    }

    /// A number, or `{ value, unit }` of one, in the unit `si`.
    pub(crate) fn quantity(&mut self, key: &str, key_span: Span, node: &Node, si: &str) -> Option<Spanned<f64>> {
        if !matches!(node.value, Value::Table(_)) {
            return Some(Spanned::new(self.number(node)?, node.span));
        }
        let parameter = self.parameter(key, key_span, node)?;
        let [value] = parameter.value[..] else {
            return self.expected("a number", node);
        };
        let factor = match &parameter.unit {
            None => 1.0,
            Some(unit) => self.factor(unit, si)?,
        };
        Some(Spanned::new(value * factor, parameter.value_span))
    }

    /// What to multiply numbers in `unit` with to have them in `si`.
    pub(crate) fn factor(&mut self, unit: &Spanned<String>, si: &str) -> Option<f64> {
        let from = Unit::parse(&unit.value).ok()?;
        let to = Unit::parse(si).ok()?;
        let factor = from.factor_to(to);
        if factor.is_none() {
            let si = if si.is_empty() { "no unit" } else { si };
            self.fault(unit.span, format!("expected a unit like {si}, found {}", unit.value), None);
        }
        factor
    }
}
