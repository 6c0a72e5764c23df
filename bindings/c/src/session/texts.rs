//! Pieces of the language of scenes: a whole scene, one law, the settings of the engine.
//!
//! In: text of the client, the domains that it may name. Out: a [`Scene`] that holds just that piece, its names looked up.
//! Never: a second language: what the command reads in a file is read here, with the same faults.

use super::Trouble;
use std::path::Path;
use vesper_cli::assemble;
use vesper_cli::scene::{EngineSettings, Precision as Spoken, Scene, SceneFault, Span};

/// A whole scene, for an engine of this precision.
pub(super) fn scene<P: vesper::prelude::Precision>(text: &str, folder: &Path) -> Result<Scene, Trouble> {
    let scene = Scene::from_text_and("scene", text, folder, &[], names)?;
    same_precision::<P>(&scene)?;
    Ok(scene)
}

/// One law: its name, and what stands behind it in a scene, `softening = 1e3, domain = 'stars'`.
pub(super) fn law<P: vesper::prelude::Precision>(name: &str, text: &str, domains: &[&str]) -> Result<Scene, Trouble> {
    let behind = if text.trim().is_empty() { String::new() } else { format!(", {text}") };
    let line = format!("laws = [{{ name = {}{behind} }}]", quoted(name));
    let alone = |scene: &Scene| scene.laws.len() == 1 && scene.engine == EngineSettings::default();
    piece::<P>(&format!("law {name}"), &line, domains, alone)
}

/// What section `[engine]` of a scene says, `integrator = 'leapfrog', step = 1e-3`.
pub(super) fn settings<P: vesper::prelude::Precision>(text: &str, domains: &[&str]) -> Result<Scene, Trouble> {
    let line = format!("engine = {{ {text} }}");
    piece::<P>("settings", &line, domains, |scene| scene.laws.is_empty())
}

/// Reads a piece, beside domains that are known elsewhere.
fn piece<P: vesper::prelude::Precision>(
    file: &str,
    line: &str,
    domains: &[&str],
    alone: impl Fn(&Scene) -> bool,
) -> Result<Scene, Trouble> {
    let named: String = domains.iter().map(|name| format!("\n[domains.{}]", quoted(name))).collect();
    let mut scene = Scene::from_text_and(file, &format!("{line}{named}\n"), Path::new(""), &[], names)?;
    let rest = scene.constants.len() + scene.fields.len() + scene.generate.len();
    let columns = scene.domains.iter().any(|domain| !domain.columns.is_empty() || domain.labels.is_some());
    let other = rest > 0 || columns || scene.domains.len() != domains.len();
    if other || scene.title.is_some() || scene.compare.is_some() || !alone(&scene) {
        let text = format!("{file}: the text goes on behind its end, in `{line}`: keep to what belongs there");
        return Err(Trouble::fault(text));
    }
    scene.domains.clear();
    same_precision::<P>(&scene)?;
    Ok(scene)
}

/// What the names of a piece do not mean.
fn names(scene: &Scene) -> Vec<(Span, SceneFault)> {
    assemble::names(scene, &scene.modules)
}

fn same_precision<P: vesper::prelude::Precision>(scene: &Scene) -> Result<(), Trouble> {
    let Some(said) = &scene.engine.precision else { return Ok(()) };
    let name = match said.value {
        Spoken::F32 => "f32",
        Spoken::F64 => "f64",
        Spoken::DoubleDouble => "double-double",
    };
    if name == P::NAME {
        return Ok(());
    }
    let text = format!("the precision here is {name}, but {} was asked for", P::NAME);
    Err(vec![scene.fault(said.span, text, Some("ask for the same, or leave it out here".to_owned()))].into())
}

/// A text in the quotes of TOML.
fn quoted(text: &str) -> String {
    let mut quoted = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => quoted.extend(['\\', letter]),
            letter if letter.is_control() => quoted += &format!("\\u{:04X}", u32::from(letter)),
            letter => quoted.push(letter),
        }
    }
    quoted + "\""
}
