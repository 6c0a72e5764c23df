//! The laws of a scene, against the stock laws, and those of modules.
//!
//! In: a law's entry. Out: its kernels and options, or faults at the place of the mistake. Never: whether its properties
//! exist; the library's registry tells.

use vesper::backend::{Compile, Compiled};
use vesper::law::{Parameter, Signature};
use vesper::module::ModuleLaw;
use vesper::registry::Options;
use vesper_dimension::Unit;
use vesper_laws::catalog::{CatalogPrecision, StockLaw, stock_law, stock_laws};

use super::Notes;
use crate::fault::{Span, Spanned, help_for, nearest};
use crate::scene::{BackendChoice, LawRequest, Parameter as Given};

/// A law by its name.
#[derive(Clone, Debug)]
pub(super) enum Found {
    Stock(&'static StockLaw),
    Module(ModuleLaw),
}

impl Found {
    pub(super) fn signature(&self) -> &'static Signature {
        match self {
            Found::Stock(law) => &law.signature,
            Found::Module(law) => law.signature(),
        }
    }

    fn compile<P: CatalogPrecision>(&self, values: &[f64]) -> Compiled<P> {
        match self {
            Found::Stock(law) => law.compile(values),
            // As many as its signature has.
            Found::Module(law) => law.clone().with_all(values).as_ref().unwrap_or(law).compile(),
        }
    }
}

/// Why there is no law that an entry names: where, a text, and what to do.
type NotFound = (Span, String, Option<String>);

/// The law that an entry names.
pub(super) fn find(notes: &Notes<'_>, request: &LawRequest) -> Result<Found, NotFound> {
    let name = &request.name.value;
    let Some(module) = &request.module else {
        return stock_law(name).map(Found::Stock).ok_or_else(|| {
            let known = stock_laws().iter().map(|law| law.signature.name);
            let has = |module: &vesper::module::Module| module.signatures().any(|law| law.name == name);
            let modules = notes.modules.all();
            let elsewhere = modules.iter().find(|(_, module)| module.as_ref().is_ok_and(|module| has(module)));
            let help = match (elsewhere, nearest(name, known)) {
                (Some((module, _)), _) => format!("module {module} has it: write `module = \"{module}\"` too"),
                (None, Some(near)) => format!("did you mean `{near}`?"),
                (None, None) => "`vesper laws` lists them".to_owned(),
            };
            (request.name.span, format!("no law is named `{name}`"), Some(help))
        });
    };
    let found = notes.modules.module(&module.value, &notes.scene.folder);
    let opened = found.map_err(|reason| (module.span, format!("module `{}`: {reason}", module.value), None))?;
    opened.law(name).map(Found::Module).map_err(|fault| (request.name.span, fault.to_string(), None))
}

/// A law and how it is used.
pub(super) fn law<P: CatalogPrecision>(notes: &mut Notes<'_>, request: &LawRequest) -> Option<(Compiled<P>, Options)> {
    let found = find(notes, request);
    if let Err((span, text, help)) = &found {
        notes.fault(*span, text.clone(), help.clone());
    }
    let backend = notes.backend(request.backend.as_ref());
    let every = request.every.as_ref().map_or(Some(1), |every| match u32::try_from(every.value) {
        Ok(steps) => Some(steps),
        Err(_) => notes.wrong(every.span, format!("expected at most {} steps, found {}", u32::MAX, every.value)),
    });
    let law = found.ok()?;
    let values = parameters(notes, request, law.signature());
    same_as_then(notes, request, law.signature());
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

/// A law that was another one when the scene was written is refused.
fn same_as_then(notes: &mut Notes<'_>, request: &LawRequest, law: &Signature) {
    let Some(then) = &request.fingerprint else { return };
    let now = format!("{:016x}", law.fingerprint());
    if then.value != now {
        let help =
            format!("if that is right, write {now}; it says now: {}", law.declaration().trim_end().replace('\n', "; "));
        notes.fault(
            then.span,
            format!("law `{}` is not the one that had the fingerprint {}", law.name, then.value),
            Some(help),
        );
    }
}

/// The components of all parameters in declared order.
fn parameters(notes: &mut Notes<'_>, request: &LawRequest, law: &Signature) -> Option<Vec<f64>> {
    let name = law.name;
    let before = notes.count();
    for (index, given) in request.parameters.iter().enumerate() {
        let known = || law.parameters.iter().map(|parameter| parameter.name);
        if !known().any(|known| known == given.name.value) {
            let own = ["module", "fingerprint", "domain", "label", "backend", "every", "enabled", "far_field"];
            let help = match law.parameters.len() {
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
    for parameter in law.parameters {
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
