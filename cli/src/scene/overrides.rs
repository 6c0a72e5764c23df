//! `--set PATH=VALUE`, and each value of `--vary`: changes to the parse tree before it is read, so that they are checked as the file is.
//!
//! In: the tree and an argument. Out: the changed tree, or a fault in the argument. Never: adds a constant, field,
//! domain or column that the file does not have, for that would be a typing mistake that runs.
//!
//! A path is names between dots: `engine.step`, `constants.gravity`, `domains.springs.stiffness`,
//! `laws.gravity.softening` (a law by its label, or by its name where that is clear), `domains.bodies.position.1` (a
//! row). A value is TOML; a single word may go without quotes. Where the file has `{ value = .., unit = .. }`, a number
//! or list replaces the value and the unit stays.

use super::tree::{Node, Table, Value, value};
use super::walk::Walk;
use crate::fault::{Span, help_for};

/// Sections, and whether `--set` may make names in them that the file lacks.
const SECTIONS: [(&str, bool); 8] = [
    ("title", true),
    ("engine", true),
    ("constants", false),
    ("fields", false),
    ("domains", false),
    ("generate", false),
    ("laws", false),
    ("compare", true),
];

/// A change of a scene: `--set PATH=VALUE`, or an option of its own, which faults name as it was written.
#[derive(Clone, Debug, PartialEq)]
pub enum Override {
    /// `--set`, with its argument.
    Set(String),
    /// One of the values of `--vary`.
    Vary {
        /// The path of the option, for faults.
        path: String,
        /// As `--set` has it.
        set: String,
    },
    /// An option for a setting of `[engine]`.
    Engine {
        /// The option: "--step".
        option: &'static str,
        /// The setting: "step".
        key: &'static str,
        /// What was written behind the option.
        text: String,
        /// What it must be.
        kind: OptionKind,
    },
}

/// What stands behind an option.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OptionKind {
    /// A name.
    Word,
    /// A number.
    Number,
    /// A number of seconds, whatever unit the scene has there.
    Seconds,
    /// Nothing: the option sets the flag.
    Flag,
}

impl Override {
    /// Its name in faults, and the text that their places point into.
    pub(crate) fn source(&self) -> (String, &str) {
        match self {
            Override::Set(argument) => (format!("--set {argument}"), argument),
            Override::Vary { path, set } => (format!("--vary {path}"), set),
            Override::Engine { option, text, .. } => (format!("{option} {text}").trim_end().to_owned(), text),
        }
    }
}

impl From<String> for Override {
    fn from(argument: String) -> Self {
        Override::Set(argument)
    }
}

impl From<&str> for Override {
    fn from(argument: &str) -> Self {
        Override::Set(argument.to_owned())
    }
}

/// Applies one change, whose text has been added to the sources at `base`.
pub(crate) fn apply(walk: &mut Walk, root: &mut Table, change: &Override, base: usize) {
    match change {
        Override::Set(argument) | Override::Vary { set: argument, .. } => set(walk, root, argument, base),
        Override::Engine { key, text, kind, .. } => {
            let span = Span { start: base, end: base + text.len() };
            let node = |value| Node { value, span };
            let number =
                || text.trim().parse().ok().map(|value| Value::Number { value, whole: text.trim().parse().ok() });
            let value = match kind {
                OptionKind::Word => Some(Value::Text(text.clone())),
                OptionKind::Flag => Some(Value::Flag(true)),
                OptionKind::Number => number(),
                OptionKind::Seconds => number().map(|number| {
                    let mut table = Table::default();
                    table.put("value", span, node(number));
                    table.put("unit", span, node(Value::Text("s".to_owned())));
                    Value::Table(table)
                }),
            };
            match value {
                Some(value) => put(walk, root, &[("engine".to_owned(), span), ((*key).to_owned(), span)], node(value)),
                None => walk.fault(span, format!("expected a number, found `{text}`"), None),
            }
        }
    }
}

fn set(walk: &mut Walk, root: &mut Table, argument: &str, base: usize) {
    let whole = Span { start: base, end: base + argument.len() };
    let Some((path, text)) = argument.split_once('=') else {
        walk.fault(whole, "expected PATH=VALUE", Some("as in --set engine.step=1e-3".to_owned()));
        return;
    };
    let text_base = base + path.len() + 1;
    let Some(new) = read_value(walk, text, text_base) else { return };
    let mut steps = Vec::new();
    let mut start = base;
    for part in path.split('.') {
        let name = part.trim();
        let lead = part.len() - part.trim_start().len();
        let span = Span { start: start + lead, end: start + lead + name.len() };
        if name.is_empty() {
            walk.fault(span, "a name is missing in the path", None);
            return;
        }
        steps.push((name.to_owned(), span));
        start += part.len() + 1;
    }
    put(walk, root, &steps, new);
}

/// Puts `new` where the path of `steps` leads.
fn put(walk: &mut Walk, root: &mut Table, steps: &[(String, Span)], new: Node) {
    let (section, section_span) = &steps[0];
    let Some((_, open)) = SECTIONS.iter().find(|(name, _)| name == section) else {
        let help = help_for(section, SECTIONS.iter().map(|(name, _)| *name));
        walk.fault(*section_span, format!("no section is named `{section}`"), help);
        return;
    };
    if root.get(section).is_none() {
        if !open {
            walk.fault(*section_span, format!("the scene has no section `{section}`"), None);
            return;
        }
        if steps.len() > 1 {
            root.put(section, *section_span, Node { value: Value::Table(Table::default()), span: *section_span });
        }
    }
    if let [_] = steps {
        if section == "title" {
            root.put(section, *section_span, new);
        } else {
            walk.fault(*section_span, format!("`{section}` is a section: name what to set in it"), None);
        }
        return;
    }
    if let Some(node) = root.get_mut(section) {
        graft(walk, node, section, &steps[1..], new, *open);
    }
}

/// Whether a text may stand for itself, without quotes.
pub(crate) fn is_word(text: &str) -> bool {
    text.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || "_-./^".contains(c))
        && !["true", "false", "inf", "nan"].contains(&text)
}

/// The value of an argument: TOML, or a bare word.
fn read_value(walk: &mut Walk, text: &str, base: usize) -> Option<Node> {
    let word = text.trim();
    let lead = text.len() - text.trim_start().len();
    let span = Span { start: base + lead, end: base + lead + word.len() };
    if is_word(word) {
        return Some(Node { value: Value::Text(word.to_owned()), span });
    }
    if word.is_empty() {
        walk.fault(Span { start: base, end: base }, "a value is missing after `=`", None);
        return None;
    }
    match value(word, base + lead) {
        Ok(node) => Some(node),
        Err(faults) => {
            for (span, text) in faults.into_iter().take(1) {
                walk.fault(span, text, None);
            }
            None
        }
    }
}

/// Walks down `steps` from `node`, which is called `place`, and puts `new` there.
fn graft(walk: &mut Walk, node: &mut Node, place: &str, steps: &[(String, Span)], new: Node, open: bool) {
    let Some(((name, span), rest)) = steps.split_first() else {
        replace(node, new);
        return;
    };
    // `integrator = "x"` is short for `{ name = "x" }`; an option asks for the long form.
    if place == "integrator" && matches!(node.value, Value::Text(_)) {
        let mut table = Table::default();
        let short = std::mem::replace(&mut node.value, Value::Date);
        table.put("name", node.span, Node { value: short, span: node.span });
        node.value = Value::Table(table);
    }
    let described = node.value.described();
    match &mut node.value {
        Value::Table(table) => {
            if table.get(name).is_none() {
                if let (Some(inner), true) = (table.get_mut("value"), name.parse::<usize>().is_ok()) {
                    graft(walk, inner, place, steps, new, open);
                    return;
                }
                if !open || !rest.is_empty() {
                    let keys: Vec<String> = table.keys().map(str::to_owned).collect();
                    let help = help_for(name, keys.iter().map(String::as_str));
                    walk.fault(*span, format!("the scene has no `{name}` in `{place}`"), help);
                    return;
                }
                table.put(name, *span, new);
                return;
            }
            // The names of domains, columns and constants are the file's; what stands below a generator, a field or an
            // integrator is checked when it is read.
            let open = open || matches!(place, "generate" | "fields" | "integrator");
            let entry = table.entries.iter_mut().find(|entry| &entry.key == name);
            if let Some(entry) = entry {
                graft(walk, &mut entry.node, name, rest, new, open);
            }
        }
        Value::List(items) if place == "laws" => {
            if let Some(index) = find_law(walk, items, name, *span) {
                graft(walk, &mut items[index], name, rest, new, true);
            }
        }
        Value::List(items) => {
            let count = items.len();
            match name.parse::<usize>().ok().and_then(|index| items.get_mut(index)) {
                Some(item) => graft(walk, item, name, rest, new, open),
                None => walk.fault(*span, format!("`{place}` has {count} items, none is number `{name}`"), None),
            }
        }
        _ => walk.fault(*span, format!("`{place}` is {described}: it has no `{name}`"), None),
    }
}

/// Puts `new` in the place of `node`; of `{ value, unit }` only the value, where `new` is no table.
fn replace(node: &mut Node, new: Node) {
    if let (Value::Table(table), false) = (&mut node.value, matches!(new.value, Value::Table(_)))
        && let Some(value) = table.get_mut("value")
    {
        *value = new;
        return;
    }
    *node = new;
}

/// The law with the label `name`, or the only one with that name.
fn find_law(walk: &mut Walk, items: &[Node], name: &str, span: Span) -> Option<usize> {
    let entry = |item: &Node, key: &str| match &item.value {
        Value::Table(table) => match table.get(key).map(|node| &node.value) {
            Some(Value::Text(text)) => Some(text.clone()),
            _ => None,
        },
        _ => None,
    };
    let with = |key: &str| -> Vec<usize> {
        (0..items.len()).filter(|&index| entry(&items[index], key).as_deref() == Some(name)).collect()
    };
    let labelled = with("label");
    let found = if labelled.is_empty() { with("name") } else { labelled };
    match found[..] {
        [index] => Some(index),
        [] => {
            let known: Vec<String> =
                items.iter().filter_map(|item| entry(item, "label").or_else(|| entry(item, "name"))).collect();
            let help = help_for(name, known.iter().map(String::as_str));
            walk.fault(span, format!("the scene has no law `{name}`"), help);
            None
        }
        _ => {
            let help = Some("give each a `label`, and set by that".to_owned());
            walk.fault(span, format!("the scene has {} laws `{name}`", found.len()), help);
            None
        }
    }
}
