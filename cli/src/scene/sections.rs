//! Sections `[engine]`, `[constants]`, `[fields]`, `[[laws]]`.
//!
//! In: nodes of the tree. Out: plain data. Never: checks names of laws or integrators, which are not known here.

use super::data::*;
use super::tree::{Node, Table, Value};
use super::walk::Walk;
use crate::fault::{Span, Spanned, help_for, number};

/// Words for backends.
const BACKENDS: [(&str, BackendChoice); 5] = [
    ("auto", BackendChoice::Auto),
    ("cpu", BackendChoice::Cpu),
    ("parallel", BackendChoice::Parallel),
    ("gpu", BackendChoice::Gpu),
    ("fastest", BackendChoice::Fastest),
];

/// Keys of `[engine]`.
pub(crate) const ENGINE: [&str; 13] = [
    "precision",
    "integrator",
    "step",
    "frame",
    "end",
    "backend",
    "threads",
    "strict",
    "compensated",
    "across_jumps",
    "estimates",
    "moving_origin",
    "observe",
];

/// `[engine]`.
pub(crate) fn engine(walk: &mut Walk, node: &Node) -> EngineSettings {
    let mut settings = EngineSettings::default();
    let Some(table) = walk.table(node, "a table of settings") else { return settings };
    walk.known_keys(table, "[engine]", &ENGINE);
    for entry in &table.entries {
        let node = &entry.node;
        match entry.key.as_str() {
            "precision" => {
                settings.precision = walk.choice(node, &PRECISIONS);
            }
            "integrator" => settings.integrator = integrator(walk, entry.key_span, node),
            "step" => settings.step = time(walk, "step", entry.key_span, node, false),
            "frame" => settings.frame = time(walk, "frame", entry.key_span, node, false),
            "end" => settings.end = time(walk, "end", entry.key_span, node, true),
            "backend" => settings.backend = walk.choice(node, &BACKENDS),
            "threads" => settings.threads = walk.count_from(node, 1),
            "strict" => settings.strict = walk.flag(node),
            "compensated" => settings.compensated = walk.flag(node),
            "across_jumps" => settings.across_jumps = walk.flag(node),
            "estimates" => settings.estimates = walk.flag(node),
            "moving_origin" => settings.moving_origin = walk.flag(node),
            "observe" => settings.observe = observe(walk, node),
            _ => {}
        }
    }
    settings
}

/// A time in seconds, or with a unit.
fn time(walk: &mut Walk, key: &str, key_span: Span, node: &Node, zero: bool) -> Option<Spanned<f64>> {
    let time = walk.quantity(key, key_span, node, "s")?;
    if time.value > 0.0 || (zero && time.value == 0.0) {
        return Some(time);
    }
    let least = if zero { "not below 0" } else { "above 0" };
    walk.fault(time.span, format!("expected a time {least}, found {}", number(time.value)), None);
    None
}

fn integrator(walk: &mut Walk, key_span: Span, node: &Node) -> Option<IntegratorChoice> {
    let Value::Table(table) = &node.value else {
        return Some(IntegratorChoice { name: walk.text(node)?, options: Vec::new() });
    };
    let options: Vec<Option<Parameter>> = table
        .entries
        .iter()
        .filter(|entry| entry.key != "name")
        .map(|entry| walk.parameter(&entry.key, entry.key_span, &entry.node))
        .collect();
    let name = walk.required(table, "name", key_span, "`integrator`").and_then(|name| walk.text(name))?;
    Some(IntegratorChoice { name, options: options.into_iter().collect::<Option<_>>()? })
}

fn observe(walk: &mut Walk, node: &Node) -> Option<Vec<Spanned<String>>> {
    let columns = walk.texts(node)?;
    for column in &columns {
        let parts: Vec<&str> = column.value.split('.').collect();
        if parts.len() != 2 || parts.contains(&"") {
            let text = format!("expected \"domain.property\", found \"{}\"", column.value);
            walk.fault(column.span, text, None);
        }
    }
    Some(columns)
}

/// `[constants]`.
pub(crate) fn constants(walk: &mut Walk, node: &Node) -> Vec<Parameter> {
    let Some(table) = walk.table(node, "a table of constants") else { return Vec::new() };
    table.entries.iter().filter_map(|entry| walk.parameter(&entry.key, entry.key_span, &entry.node)).collect()
}

const SHAPES: [&str; 4] = ["boxes", "uniform", "point", "dipole"];

/// `[fields]`.
pub(crate) fn fields(walk: &mut Walk, node: &Node) -> Vec<FieldData> {
    let Some(table) = walk.table(node, "a table of fields") else { return Vec::new() };
    table
        .entries
        .iter()
        .filter_map(|entry| {
            let place = format!("[fields.{}]", entry.key);
            let field = walk.table(&entry.node, "a table with the shape of the field")?;
            walk.known_keys(field, &place, &["boxes", "uniform", "point", "dipole", "unit"]);
            let unit = field.get("unit").and_then(|unit| walk.unit(unit));
            let shapes: Vec<_> = field.entries.iter().filter(|shape| SHAPES.contains(&shape.key.as_str())).collect();
            let [first, rest @ ..] = &shapes[..] else {
                // A misspelt shape is faulted already.
                if field.entries.iter().all(|entry| entry.key == "unit") {
                    let help = Some(format!("one of {}", SHAPES.join(", ")));
                    walk.fault(entry.key_span, format!("{place} has no shape"), help);
                }
                return None;
            };
            for second in rest {
                let text = format!("a field has one shape, and `{}` is one already", first.key);
                walk.fault(second.key_span, text, None);
            }
            let shape = shape(walk, &first.key, first.key_span, &first.node)?;
            let name = Spanned::new(entry.key.clone(), entry.key_span);
            Some(FieldData { name, shape, shape_span: first.node.span, unit })
        })
        .collect()
}

fn shape(walk: &mut Walk, key: &str, key_span: Span, node: &Node) -> Option<FieldShape> {
    match key {
        "uniform" => field_value(walk, node).map(FieldShape::Uniform),
        "boxes" => {
            let items = walk.list(node, "a list of boxes")?;
            let boxes: Vec<Option<FieldBox>> = items.iter().map(|item| field_box(walk, item)).collect();
            let boxes: Vec<FieldBox> = boxes.into_iter().collect::<Option<_>>()?;
            for (one, item) in boxes.iter().zip(items) {
                if one.value.len() != boxes[0].value.len() {
                    let (n, first) = (one.value.len(), boxes[0].value.len());
                    walk.fault(item.span, format!("the value has {n} components here, {first} in the first box"), None);
                }
            }
            Some(FieldShape::Boxes(boxes))
        }
        "point" => {
            let table = parts(walk, node, "`point`", &["at", "strength"])?;
            let at = walk.required(table, "at", key_span, "`point`").and_then(|at| walk.vector(at, false));
            let strength = walk.required(table, "strength", key_span, "`point`").and_then(|s| walk.number(s));
            Some(FieldShape::Point { at: at?, strength: strength? })
        }
        _ => {
            let table = parts(walk, node, "`dipole`", &["at", "moment"])?;
            let at = walk.required(table, "at", key_span, "`dipole`").and_then(|at| walk.vector(at, false));
            let moment = walk.required(table, "moment", key_span, "`dipole`").and_then(|m| walk.vector(m, false));
            Some(FieldShape::Dipole { at: at?, moment: moment? })
        }
    }
}

fn parts<'t>(walk: &mut Walk, node: &'t Node, place: &str, keys: &[&str]) -> Option<&'t Table> {
    let table = walk.table(node, &format!("a table with {}", keys.join(" and ")))?;
    walk.known_keys(table, place, keys);
    Some(table)
}

fn field_value(walk: &mut Walk, node: &Node) -> Option<Vec<f64>> {
    let value = walk.components(node)?;
    if matches!(value.len(), 1 | 3) {
        return Some(value);
    }
    walk.fault(node.span, format!("expected a number or 3 numbers, found {}", value.len()), None);
    None
}

fn field_box(walk: &mut Walk, node: &Node) -> Option<FieldBox> {
    let table = parts(walk, node, "a box", &["min", "max", "value"])?;
    let min = walk.required(table, "min", node.span, "a box").and_then(|min| walk.vector(min, true));
    let max = walk.required(table, "max", node.span, "a box").and_then(|max| walk.vector(max, true));
    let value = walk.required(table, "value", node.span, "a box").and_then(|value| field_value(walk, value));
    let one = FieldBox { min: min?, max: max?, value: value? };
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        if one.min[axis] >= one.max[axis] {
            let text = format!("the box is empty: in {name}, min {} is not below max {}", one.min[axis], one.max[axis]);
            walk.fault(node.span, text, None);
        }
    }
    Some(one)
}

/// Keys of `[[laws]]` that are no parameters.
pub(crate) const LAW: [&str; 9] =
    ["name", "module", "fingerprint", "domain", "label", "backend", "every", "enabled", "far_field"];

/// `[[laws]]`.
pub(crate) fn laws(walk: &mut Walk, node: &Node) -> Vec<LawRequest> {
    if let Value::Table(_) = node.value {
        walk.fault(node.span, "expected a list of laws, found a table", Some("write [[laws]]".to_owned()));
        return Vec::new();
    }
    let Some(items) = walk.list(node, "a list of laws: [[laws]]") else { return Vec::new() };
    let laws: Vec<LawRequest> = items.iter().filter_map(|item| law(walk, item)).collect();
    for (index, one) in laws.iter().enumerate() {
        let domain = |law: &LawRequest| law.domain.as_ref().map(|domain| domain.value.clone());
        let same = |other: &&LawRequest| other.called() == one.called() && domain(other) == domain(one);
        if laws[..index].iter().any(|other| same(&other)) {
            let span = one.label.as_ref().map_or(one.name.span, |label| label.span);
            let help = Some("give one of them a `label` of its own".to_owned());
            walk.fault(span, format!("law `{}` is listed twice", one.called()), help);
        }
    }
    laws
}

fn law(walk: &mut Walk, node: &Node) -> Option<LawRequest> {
    let table = match &node.value {
        // A bare name is what one would write first: the fault says how it is spelt.
        Value::Text(name) => {
            let help = Some(format!("write {{ name = \"{name}\" }}"));
            walk.fault(node.span, "expected a table with the name of a law, found text", help);
            return None;
        }
        _ => walk.table(node, "a table with the name of a law")?,
    };
    let mut parameters = Vec::new();
    let mut whole = true;
    for entry in table.entries.iter().filter(|entry| !LAW.contains(&entry.key.as_str())) {
        // A key with a value that no parameter can have is a misspelt key of the entry itself.
        if matches!(entry.node.value, Value::Text(_) | Value::Flag(_) | Value::Date) {
            let text =
                format!("expected a number or a vector for `{}`, found {}", entry.key, entry.node.value.described());
            walk.fault(entry.node.span, text, help_for(&entry.key, LAW));
            whole = false;
            continue;
        }
        match walk.parameter(&entry.key, entry.key_span, &entry.node) {
            Some(parameter) => parameters.push(parameter),
            None => whole = false,
        }
    }
    let module = table.get("module").and_then(|module| walk.text(module));
    let fingerprint = table.get("fingerprint").and_then(|fingerprint| walk.text(fingerprint));
    let domain = table.get("domain").and_then(|domain| walk.text(domain));
    let label = table.get("label").and_then(|label| walk.text(label));
    let backend = table.get("backend").and_then(|backend| walk.choice(backend, &BACKENDS));
    let every = table.get("every").and_then(|every| walk.count_from(every, 1));
    let enabled = table.get("enabled").is_none_or(|enabled| walk.flag(enabled).is_none_or(|flag| flag.value));
    let far_field = table.get("far_field").and_then(|far| far_field(walk, far));
    let name = walk.required(table, "name", node.span, "a law").and_then(|name| walk.text(name))?;
    whole.then_some(LawRequest {
        name,
        module,
        fingerprint,
        domain,
        label,
        parameters,
        backend,
        every,
        far_field,
        enabled,
        span: node.span,
    })
}

/// `{ method = "multipole", error = 1e-4 }`: the error.
fn far_field(walk: &mut Walk, node: &Node) -> Option<f64> {
    let table = walk.table(node, "a table such as `{ method = \"multipole\", error = 1e-4 }`")?;
    walk.known_keys(table, "far_field", &["method", "error"]);
    let method = walk
        .required(table, "method", node.span, "a far field")
        .and_then(|method| walk.choice(method, &[("multipole", ())]));
    let error = walk.required(table, "error", node.span, "a far field").and_then(|error| walk.number(error));
    method.and(error)
}
