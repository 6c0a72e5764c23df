//! Where in a scene the library's faults stand.
//!
//! In: a fault that names domains, properties, laws. Out: the place of the nearest of these that the scene wrote, and
//! words that a scene's author can follow. Never: hides a fault; one without a place is printed as it is.

use vesper::prelude::Fault;

use crate::fault::Span;
use crate::scene::{DomainData, LawRequest, Scene};

/// A library's fault in a scene's words, with its place where there is one.
pub(super) fn placed(scene: &Scene, fault: &Fault) -> (Option<Span>, String, Option<String>) {
    let text = fault.to_string();
    let law = |name: &str| law(scene, name).map(|law| law.name.span);
    let (span, text, help) = match fault {
        Fault::Dimension { domain, property, given, expected, .. } => (
            unit(scene, domain, property),
            format!("`{property}` is measured in {expected}, and {given} is no unit of that dimension"),
            None,
        ),
        Fault::Unit { place, .. } => {
            let (domain, property) = place.split_once('.').unwrap_or((place, ""));
            (unit(scene, domain, property), text, None)
        }
        Fault::Kind { domain, property, .. }
        | Fault::Length { domain, property, .. }
        | Fault::SubsetLength { domain, property, .. }
        | Fault::LinkToNone { domain, property, .. }
        | Fault::NotFinite { domain, property, .. }
        | Fault::OutOfPrecision { domain, property, .. }
        | Fault::NoValue { domain, property, .. }
        | Fault::ColumnTwice { domain, property, .. }
        | Fault::SubsetTwice { domain, property, .. }
        | Fault::SubsetRange { domain, property, .. }
        | Fault::LinkRange { domain, property, .. }
        | Fault::LinkTarget { domain, property, .. } => (column(scene, domain, property), text, None),
        Fault::Declared { property, one_by, other_by, .. } => {
            let columns = [one_by, other_by].map(|by| by.strip_prefix("domain ").unwrap_or_default());
            let span = columns.iter().find_map(|domain| column(scene, domain, property));
            let field = scene.fields.iter().find(|field| field.name.value == *property).map(|field| field.name.span);
            (span.or(field), text, None)
        }
        Fault::FieldTwice { field, .. } => (
            scene.fields.iter().rev().find(|known| known.name.value == *field).map(|field| field.name.span),
            text,
            None,
        ),
        // The only columns that the library looks for and does not find are observed ones.
        Fault::NoDomain { domain, .. } => (observed(scene, domain, None), text, None),
        Fault::NoProperty { domain, property, nearest, .. } => (
            observed(scene, domain, Some(property)),
            format!("`{domain}` has no property `{property}`, and no running law makes one"),
            nearest.as_ref().map(|near| format!("did you mean `{near}`?")),
        ),
        Fault::WhichDomain { law: name, domains, .. } => (
            law(name),
            format!("law `{name}` can stand on {}", domains.join(" or ")),
            domains.first().map(|domain| format!("say on which: domain = \"{domain}\"")),
        ),
        // What a program can do about it, a scene cannot.
        Fault::BlowUp { .. } => (None, text.split("; trace_blow_ups").next().unwrap_or(&text).to_owned(), None),
        Fault::LawTwice { law: name, domain, .. } => (
            scene.laws.iter().rev().find(|law| law.called() == name).map(|law| law.name.span),
            format!("law `{name}` is listed twice on domain {domain}"),
            Some("keep one, or give one of them a `label` of its own".to_owned()),
        ),
        Fault::SetGiven { law: name, property, .. } => {
            let (domain, property) = property.split_once('.').unwrap_or(("", property));
            (column(scene, domain, property).or(law(name)), text, None)
        }
        Fault::EveryOutput { law: name, .. } | Fault::Every { law: name, .. } => {
            let every = self::law(scene, name).and_then(|law| law.every.as_ref()).map(|every| every.span);
            (every.or(law(name)), text, None)
        }
        Fault::LawDomain { law: name, .. } => {
            let domain = self::law(scene, name).and_then(|law| law.domain.as_ref()).map(|domain| domain.span);
            (domain.or(law(name)), text, None)
        }
        Fault::TwoSet { other: name, .. }
        | Fault::TwoRates { other: name, .. }
        | Fault::RateOfComputed { law: name, .. }
        | Fault::AddToPlain { law: name, .. }
        | Fault::SetOnSubset { law: name, .. }
        | Fault::Shape { law: name, .. }
        | Fault::TooWide { law: name, .. }
        | Fault::Dormant { law: name, .. }
        | Fault::EmptyDomain { law: name, .. }
        | Fault::Subset { law: name, .. }
        | Fault::ParameterNotFinite { law: name, .. } => (law(name), text, None),
        Fault::TooManyRows { domain, .. } => (column(scene, domain, ""), text, None),
        Fault::SceneRow { .. } => (column(scene, vesper::domain::SCENE, ""), text, None),
        Fault::SubsetStart { start, .. } => {
            let (domain, property) = start.split_once('.').unwrap_or(("", start));
            (column(scene, domain, property), text, None)
        }
        Fault::Integrator { .. } => (integrator(scene), text, None),
        Fault::Step { .. } | Fault::TooManySteps { .. } => {
            (scene.engine.step.as_ref().map(|step| step.span), text, None)
        }
        Fault::Threads { .. } | Fault::ThreadPool { .. } => {
            (scene.engine.threads.as_ref().map(|threads| threads.span), text, None)
        }
        Fault::NoParallel => (scene.engine.backend.as_ref().map(|backend| backend.span), text, None),
        Fault::Cycle { path, .. } => {
            let in_path = |law: &&LawRequest| path.iter().any(|step| step.split(' ').any(|word| word == law.called()));
            (scene.laws.iter().find(in_path).map(|law| law.name.span), text, None)
        }
        _ => (None, text, None),
    };
    (span, text, help)
}

/// Where a law is named.
pub(super) fn law_name(scene: &Scene, name: &str) -> Option<Span> {
    law(scene, name).map(|law| law.name.span)
}

/// Where a column, constant or field of this name is written, first of all in `domain`.
pub(super) fn column_of(scene: &Scene, domain: &str, name: &str) -> Option<Span> {
    let column = |domain: &DomainData| domain.column(name).map(|column| column.name.span);
    let here = scene.domain(domain).and_then(column);
    let constants = || scene.constants.iter().map(|constant| &constant.name);
    let fields = || scene.fields.iter().map(|field| &field.name);
    let named = || constants().chain(fields()).find(|known| known.value == name).map(|known| known.span);
    here.or_else(|| scene.domains.iter().find_map(column)).or_else(named)
}

fn law<'s>(scene: &'s Scene, name: &str) -> Option<&'s LawRequest> {
    scene.laws.iter().find(|law| law.called() == name).or_else(|| scene.laws.iter().find(|law| law.name.value == name))
}

fn column(scene: &Scene, domain: &str, property: &str) -> Option<Span> {
    let constant = || scene.constants.iter().find(|constant| constant.name.value == property);
    match scene.domain(domain).and_then(|domain| domain.column(property)) {
        Some(column) => Some(column.name.span),
        None if domain == vesper::domain::SCENE => constant().map(|constant| constant.name.span),
        None => scene.domain(domain).map(|domain| domain.name.span),
    }
}

fn unit(scene: &Scene, domain: &str, property: &str) -> Option<Span> {
    let of_column = scene.domain(domain).and_then(|domain| domain.column(property)?.unit.as_ref());
    let of_constant = scene.constants.iter().find(|constant| constant.name.value == property);
    let of_constant =
        of_constant.filter(|_| domain == vesper::domain::SCENE).and_then(|constant| constant.unit.as_ref());
    of_column.or(of_constant).map(|unit| unit.span).or_else(|| column(scene, domain, property))
}

fn observed(scene: &Scene, domain: &str, property: Option<&str>) -> Option<Span> {
    let named = |entry: &str| match entry.split_once('.') {
        Some((on, what)) => on == domain && property.is_none_or(|property| what == property),
        None => false,
    };
    scene.engine.observe.iter().flatten().find(|entry| named(&entry.value)).map(|entry| entry.span)
}

fn integrator(scene: &Scene) -> Option<Span> {
    scene.engine.integrator.as_ref().map(|integrator| integrator.name.span)
}
