//! A choice, written into its scene.
//!
//! In: the text of a scene, the run that was chosen. Out: the text with the keys of `[engine]` changed that make it run so;
//! every other key, comment and line as it was. Never: a file.

use toml_edit::{DocumentMut, InlineTable, Item, Value, value};

use super::measure::{Method, Run, Setting};
use super::problem::Problem;
use crate::scene::Precision as Numbers;

/// The text of a scene that runs as `run` did, and the lines that say so.
///
/// # Errors
/// In words: the text cannot be changed.
pub fn written(text: &str, problem: &Problem, run: &Run) -> Result<(String, Vec<String>), String> {
    let mut document: DocumentMut = text.parse().map_err(|error| format!("cannot be changed: {error}"))?;
    let engine = document.entry("engine").or_insert_with(toml_edit::table);
    let Some(engine) = engine.as_table_like_mut() else { return Err("`engine` is no table".to_owned()) };
    let Method { integrator, setting, numbers, compensated, .. } = run.method;
    let mut changes: Vec<(&str, Value)> = Vec::new();
    match setting {
        Setting::Step(step) => {
            changes.push(("integrator", integrator.name.into()));
            // Frames were steps: what the scene shows stays what it was.
            if let (None, Some(old)) = (engine.get("frame"), problem.step) {
                changes.push(("frame", old.into()));
            }
            changes.push(("step", problem.whole_step(step).into()));
        }
        Setting::Tolerance(_) => {
            let mut choice = InlineTable::new();
            choice.insert("name", integrator.name.into());
            for (option, number) in run.method.options(problem.least_scale()) {
                choice.insert(option, number.into());
            }
            changes.push(("integrator", Value::InlineTable(choice)));
        }
    }
    if numbers != Numbers::F64 || engine.contains_key("precision") {
        changes.push(("precision", super::findings::number_type(numbers).into()));
    }
    if compensated || engine.contains_key("compensated") {
        changes.push(("compensated", compensated.into()));
    }
    let mut lines = Vec::new();
    for (key, new) in changes {
        lines.push(format!("{key} = {}", new.to_string().trim()));
        match engine.get_mut(key) {
            Some(Item::Value(old)) => {
                // The spaces before it, and the comment behind it.
                let decor = old.decor().clone();
                *old = new;
                *old.decor_mut() = decor;
            }
            _ => {
                engine.insert(key, value(new));
            }
        }
    }
    Ok((document.to_string(), lines))
}
