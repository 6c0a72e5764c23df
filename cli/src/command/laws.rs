//! `vesper laws`.

use std::fmt::{self, Write};

use vesper::law::{Mode, Parameter, Place, Port, Signature};
use vesper::module::Module;
use vesper_laws::catalog::{StockLaw, stock_law, stock_laws};

use super::{Exit, say};
use crate::fault::{SceneFault, help_for, number};
use crate::modules::Modules;

/// Lists all laws, stock ones and those of modules, or prints those of this name.
pub(super) fn laws(name: Option<&str>, modules: &Modules) -> Result<Exit, Vec<SceneFault>> {
    let modules = modules.all();
    let Some(name) = name else {
        return Ok(say(&(list() + &in_modules(&modules))));
    };
    let stock = stock_law(name).map(|law| (None, &law.signature));
    let opened = modules.iter().filter_map(|(_, module)| module.as_ref().ok());
    let of_modules = opened.flat_map(|module| module.signatures().map(|law| (Some(*module), law)));
    let found: Vec<_> = stock.into_iter().chain(of_modules.filter(|(_, law)| law.name == name)).collect();
    if found.is_empty() {
        let all = modules.iter().filter_map(|(_, module)| module.as_ref().ok()).flat_map(|module| module.signatures());
        let help = help_for(name, stock_laws().iter().map(|law| law.signature.name).chain(all.map(|law| law.name)));
        let fault = SceneFault { help, ..SceneFault::of_file("vesper laws", format!("no law is named `{name}`")) };
        return Err(vec![fault]);
    }
    let mut text = String::new();
    for (module, law) in found {
        // Writing to a string cannot fail.
        _ = describe(&mut text, law);
        if let Some(module) = module {
            _ = writeln!(text, "\nin module {} ({}), {}", module.name(), module.build(), module.path().display());
            _ = writeln!(text, "fingerprint = \"{:016x}\"", law.fingerprint());
        }
    }
    Ok(say(&text))
}

/// What modules have, and why some of it cannot be used.
fn in_modules(modules: &[(String, Result<&'static Module, String>)]) -> String {
    let mut text = String::new();
    for (name, module) in modules {
        // Writing to a string cannot fail.
        _ = match module {
            Ok(module) => writeln!(text, "\nmodule {name} ({}), {}", module.build(), module.path().display()),
            Err(reason) => writeln!(text, "\nno module {name}: {reason}"),
        };
        let Ok(module) = module else { continue };
        let width = module.signatures().map(|law| law.name.len()).max().unwrap_or(0);
        for law in module.signatures() {
            let summary = law.doc.lines().find(|line| !line.trim().is_empty()).unwrap_or_default();
            _ = writeln!(text, "  {:width$}  {}", law.name, summary.trim());
        }
        for refused in module.refused() {
            _ = writeln!(text, "  refused: {refused}");
        }
    }
    text
}

fn list() -> String {
    let width = stock_laws().iter().map(|law| law.signature.name.len()).max().unwrap_or(0);
    let mut names: Vec<&StockLaw> = stock_laws().iter().collect();
    names.sort_by_key(|law| law.signature.name);
    names.iter().map(|law| format!("{:width$}  {}\n", law.signature.name, law.summary())).collect()
}

fn describe(text: &mut String, law: &Signature) -> fmt::Result {
    writeln!(text, "{}", law.name)?;
    if !law.doc.is_empty() {
        writeln!(text)?;
    }
    for line in law.doc.lines() {
        writeln!(text, "{}", if line.is_empty() { String::new() } else { format!("  {line}") })?;
    }
    writeln!(text, "\ntouches")?;
    if let Some(domain) = law.domain {
        writeln!(text, "  stands on domain {domain}, unless the scene says another")?;
    }
    if let Some(link) = law.link {
        writeln!(text, "  follows {}: {}", link.name, link.kind)?;
    }
    for port in law.ports {
        writeln!(text, "  {}", touched(port))?;
    }
    if law.parameters.is_empty() {
        return writeln!(text, "\nno parameters");
    }
    writeln!(text, "\nparameters")?;
    for parameter in law.parameters {
        let unit = if parameter.unit.is_empty() { String::new() } else { format!(" [{}]", parameter.unit) };
        let doc = parameter.doc.trim();
        let doc = if doc.is_empty() { String::new() } else { format!(": {doc}") };
        writeln!(text, "  {}{unit}, {}{doc}", parameter.name, default(parameter))?;
    }
    Ok(())
}

/// "reads mass \[kg\]", and from where.
fn touched(port: &Port) -> String {
    let place = match port.place {
        Place::Own => "",
        Place::Scene => " of the scene",
        Place::Field => " as a field",
        Place::End => " of the rows linked to",
    };
    let rest = match (port.optional, port.default) {
        (true, _) => ", optional".to_owned(),
        (false, Some(value)) if port.mode == Mode::Reads => {
            format!(", default {}", components(&value[..port.property.kind.width().min(3)]))
        }
        _ => String::new(),
    };
    format!("{:5} {}{place}{rest}", port.mode.word(), port.property.described())
}

fn default(parameter: &Parameter) -> String {
    match parameter.default {
        Some(value) => format!("default {}", components(&value[..parameter.width.min(3)])),
        None => "to be given".to_owned(),
    }
}

fn components(values: &[f64]) -> String {
    match values {
        [one] => number(*one),
        _ => format!("[{}]", values.iter().map(|value| number(*value)).collect::<Vec<_>>().join(", ")),
    }
}
