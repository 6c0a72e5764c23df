//! The laws of a scene, against the stock laws.
//!
//! In: a law's entry. Out: its kernels and options, or faults at the place of the mistake. Never: whether its properties
//! exist; the library's registry tells.

use vesper::backend::Compiled;
use vesper::law::Parameter;
use vesper::registry::Options;
use vesper_dimension::Unit;
use vesper_laws::catalog::{CatalogPrecision, StockLaw, stock_law, stock_laws};

use super::Notes;
use crate::fault::{Spanned, help_for, nearest};
use crate::scene::{BackendChoice, LawRequest, Parameter as Given};

/// A law and how it is used.
pub(super) fn law<P: CatalogPrecision>(notes: &mut Notes<'_>, request: &LawRequest) -> Option<(Compiled<P>, Options)> {
    let found = stock_law(&request.name.value);
    if found.is_none() {
        let known = stock_laws().iter().map(|law| law.signature.name);
        let help = match nearest(&request.name.value, known) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "`vesper laws` lists them".to_owned(),
        };
        notes.fault(request.name.span, format!("no law is named `{}`", request.name.value), Some(help));
    }
    let backend = notes.backend(request.backend.as_ref());
    let every = request.every.as_ref().map_or(Some(1), |every| match u32::try_from(every.value) {
        Ok(steps) => Some(steps),
        Err(_) => notes.wrong(every.span, format!("expected at most {} steps, found {}", u32::MAX, every.value)),
    });
    let law = found?;
    let values = parameters(notes, request, law);
    let options = Options {
        domain: request.domain.as_ref().map(|domain| domain.value.clone()),
        label: request.label.as_ref().map(|label| label.value.clone()),
        every: every?,
        enabled: request.enabled,
        required: false,
        backend: backend?,
        far_field: request.far_field,
    };
    Some((law.compile::<P>(&values?), options))
}

/// The components of all parameters in declared order.
fn parameters(notes: &mut Notes<'_>, request: &LawRequest, law: &StockLaw) -> Option<Vec<f64>> {
    let name = law.signature.name;
    let before = notes.count();
    for (index, given) in request.parameters.iter().enumerate() {
        let known = || law.signature.parameters.iter().map(|parameter| parameter.name);
        if !known().any(|known| known == given.name.value) {
            let own = ["domain", "label", "backend", "every", "enabled", "far_field"];
            let help = match law.signature.parameters.len() {
                0 => Some(format!("`{name}` has no parameters")),
                _ => help_for(&given.name.value, known().chain(own)),
            };
            notes.fault(given.name.span, format!("law `{name}` has no parameter `{}`", given.name.value), help);
        }
        if request.parameters[..index].iter().any(|other| other.name.value == given.name.value) {
            notes.fault(given.name.span, format!("parameter `{}` is given twice", given.name.value), None);
        }
    }
    let mut values = Vec::new();
    for parameter in law.signature.parameters {
        let given = request.parameters.iter().find(|given| given.name.value == parameter.name);
        match (given, parameter.default) {
            (Some(given), _) => values.extend(value(notes, given, parameter)),
            (None, Some(default)) => values.extend(&default[..parameter.width]),
            (None, None) => {
                let help = format!("write `{} = ..`, in {}", parameter.name, said(parameter.unit));
                notes.fault(
                    request.name.span,
                    format!("law `{name}` needs its parameter `{}`", parameter.name),
                    Some(help),
                );
            }
        }
    }
    (notes.count() == before).then_some(values)
}

fn value(notes: &mut Notes<'_>, given: &Given, parameter: &Parameter) -> Vec<f64> {
    if given.value.len() != parameter.width {
        let what = if parameter.width == 1 { "a number".to_owned() } else { format!("{} numbers", parameter.width) };
        let text = format!("expected {what} for `{}`, found {}", parameter.name, given.value.len());
        notes.fault(given.value_span, text, None);
    }
    let factor = given.unit.as_ref().map_or(1.0, |unit| factor(notes, unit, parameter.unit));
    let values: Vec<f64> = given.value.iter().map(|component| component * factor).collect();
    if values.iter().any(|component| !component.is_finite()) {
        notes.fault(given.value_span, format!("`{}` is too large in {}", parameter.name, said(parameter.unit)), None);
    }
    values
}

/// What to multiply numbers in `unit` with to have them in `own`; 1 with a fault where the dimensions differ.
pub(super) fn factor(notes: &mut Notes<'_>, unit: &Spanned<String>, own: &str) -> f64 {
    let parsed = Unit::parse(&unit.value).ok().zip(Unit::parse(own).ok());
    let factor = parsed.and_then(|(from, to)| from.factor_to(to));
    if factor.is_none() {
        let expected = if own.is_empty() { "no unit".to_owned() } else { format!("a unit like {own}") };
        notes.fault(unit.span, format!("expected {expected}, found {}", unit.value), None);
    }
    factor.unwrap_or(1.0)
}

fn said(unit: &str) -> &str {
    if unit.is_empty() { "no unit" } else { unit }
}

/// The library's word for a backend; `None` where this build has none of that kind.
pub(super) fn backend(choice: BackendChoice) -> Option<vesper::registry::Backend> {
    use vesper::registry::Backend;
    match choice {
        BackendChoice::Auto => Some(Backend::Auto),
        BackendChoice::Cpu => Some(Backend::Cpu),
        BackendChoice::Parallel => Some(Backend::Parallel),
        BackendChoice::Fastest => Some(Backend::Fastest),
        BackendChoice::Gpu => cfg!(feature = "gpu").then_some(Backend::Gpu),
    }
}
