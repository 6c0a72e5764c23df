//! Scene files: text in, a plain [`Scene`] out, or every mistake of the file at once.
//!
//! In: TOML, `--set` arguments, the CSV files that the scene names. Out: a [`Scene`], or [`SceneFault`]s in the order of
//! their places. Never: knows a law, a property, or the library; names of those are checked by who knows them, with
//! [`Scene::fault`] for the place.
//!
//! The way of the data: `tree` (what TOML says) -> `overrides` (`--set`) -> `walk` with `sections`, `domains`, `compare`
//! (what it means) -> `fill` (files, generators) -> `check` (what one part says about another).

mod brackets;
mod check;
mod compare;
mod data;
mod domains;
mod files;
mod fill;
mod overrides;
mod sections;
mod tree;
mod unit_names;
mod walk;

use crate::modules::Modules;
use std::path::{Path, PathBuf};

pub use data::*;
pub(crate) use domains::plural;
pub use files::Files;
pub(crate) use overrides::is_word;
pub use overrides::{OptionKind, Override};

pub use crate::fault::{SceneFault, Sources, Span, Spanned, help_for, nearest, print_faults};
use crate::generate;
use walk::Walk;

/// Everything that a scene file says.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The texts that spans point into.
    pub sources: Sources,
    /// The folder of the scene: files that it names lie beside it.
    pub folder: PathBuf,
    /// These files.
    pub files: Files,
    /// What it is.
    pub title: Option<Spanned<String>>,
    /// Section `[engine]`.
    pub engine: EngineSettings,
    /// The end that the file says, in s, whatever a change of it says.
    pub own_end: Option<f64>,
    /// Section `[constants]`: the one row of domain "scene".
    pub constants: Vec<Parameter>,
    /// Section `[fields]`.
    pub fields: Vec<FieldData>,
    /// Section `[domains]`, with what files and generators filled.
    pub domains: Vec<DomainData>,
    /// Section `[generate]`; its columns are already in `domains`.
    pub generate: Vec<GenerateRequest>,
    /// Section `[[laws]]`, in the order of the file.
    pub laws: Vec<LawRequest>,
    /// Section `[compare]`.
    pub compare: Option<Compare>,
    /// Where modules of laws may come from; not the scene's to say.
    pub modules: Modules,
}

/// The sections of a scene.
const SECTIONS: [&str; 8] = ["title", "engine", "constants", "fields", "domains", "generate", "laws", "compare"];

impl Scene {
    /// Whether every law has to run.
    pub fn is_strict(&self) -> bool {
        self.engine.strict.as_ref().is_some_and(|strict| strict.value)
    }

    /// Reads the scene file at `path`, applies the `--set` arguments, and fills its domains.
    pub fn read(path: &Path, overrides: &[Override]) -> Result<Self, Vec<SceneFault>> {
        Self::read_and(path, overrides, |_| Vec::new())
    }

    /// The same, with faults that somebody else finds in what could be read, told together with those of the scene.
    pub fn read_and(
        path: &Path,
        overrides: &[Override],
        more: impl FnOnce(&Self) -> Vec<(Span, SceneFault)>,
    ) -> Result<Self, Vec<SceneFault>> {
        let file = path.display().to_string();
        let text = std::fs::read(path)
            .map_err(|error| vec![SceneFault::of_file(&file, format!("cannot be read: {error}"))])?;
        let text = String::from_utf8(text).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            vec![SceneFault::of_file(&file, format!("is not UTF-8 text: see byte {at}"))]
        })?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::from_text_and(&file, &text, folder, overrides, more)
    }

    /// Reads a scene from text; `file` is its name in faults, `folder` is where files that it names lie.
    pub fn from_text(file: &str, text: &str, folder: &Path, overrides: &[Override]) -> Result<Self, Vec<SceneFault>> {
        Self::from_text_and(file, text, folder, overrides, |_| Vec::new())
    }

    /// The same, with faults that somebody else finds, as in [`Scene::read_and`].
    pub fn from_text_and(
        file: &str,
        text: &str,
        folder: &Path,
        overrides: &[Override],
        more: impl FnOnce(&Self) -> Vec<(Span, SceneFault)>,
    ) -> Result<Self, Vec<SceneFault>> {
        Self::from_text_of(file, text, &Files::of(folder), overrides, more)
    }

    /// The same, with the files that it names from wherever `files` has them.
    pub fn from_text_of(
        file: &str,
        text: &str,
        files: &Files,
        overrides: &[Override],
        more: impl FnOnce(&Self) -> Vec<(Span, SceneFault)>,
    ) -> Result<Self, Vec<SceneFault>> {
        let mut walk = Walk::default();
        let base = walk.sources.add(file, text, true);
        let bases: Vec<usize> =
            overrides.iter().map(Override::source).map(|(name, text)| walk.sources.add(name, text, false)).collect();
        let (mut root, faults) = tree::document(text, base);
        for (span, text) in faults {
            walk.syntax_fault(span, text);
        }
        let own = root.get("engine").map(|node| sections::engine(&mut Walk::default(), node));
        for (change, base) in overrides.iter().zip(bases) {
            overrides::apply(&mut walk, &mut root, change, base);
        }
        let own_end = own.and_then(|engine| engine.end).map(|end| end.value);
        let folder = files.folder().to_owned();
        let mut scene = Self { folder, files: files.clone(), own_end, ..Self::default() };
        scene.read_sections(&mut walk, &root);
        // What is lost in a gap of the syntax would be missed here, and faulted for the wrong reason.
        if walk.is_whole() {
            let mut incomplete = Vec::new();
            fill::from_files(&mut walk, &mut scene.domains, files, &mut incomplete);
            fill::from_generators(&mut walk, &mut scene.domains, &scene.generate, &mut incomplete);
            scene.note_lost(&root, &mut incomplete);
            let listed = match root.get("laws").map(|node| &node.value) {
                Some(tree::Value::List(laws)) => laws.len(),
                _ => 0,
            };
            check::check(&mut walk, &scene, &incomplete, listed == scene.laws.len());
        }
        scene.sources = walk.sources.clone();
        for (span, fault) in more(&scene) {
            walk.foreign_fault(span, fault);
        }
        let faults = walk.into_faults();
        if faults.is_empty() { Ok(scene) } else { Err(faults) }
    }

    fn read_sections(&mut self, walk: &mut Walk, root: &tree::Table) {
        if walk.is_whole() {
            walk.known_keys(root, "a scene", &SECTIONS);
        } else {
            // Keys below a broken section head seem to stand outside of all sections; only sections are sure.
            let sections = |entry: &&tree::Entry| {
                matches!(entry.node.value, tree::Value::Table(_)) && !walk.is_broken(entry.node.span)
            };
            let entries = root.entries.iter().filter(sections).cloned().collect();
            walk.known_keys(&tree::Table { entries }, "a scene", &SECTIONS);
        }
        for entry in &root.entries {
            let node = &entry.node;
            match entry.key.as_str() {
                "title" => self.title = walk.text(node),
                "engine" => self.engine = sections::engine(walk, node),
                "constants" => self.constants = sections::constants(walk, node),
                "fields" => self.fields = sections::fields(walk, node),
                "domains" => self.domains = domains::domains(walk, node),
                "generate" => self.generate = domains::generates(walk, node),
                "laws" => self.laws = sections::laws(walk, node),
                "compare" => self.compare = compare::compare(walk, entry.key_span, node),
                _ => {}
            }
        }
    }

    /// Names the domains that something in the file would fill, if it had been right: they are known, their rows are not.
    fn note_lost(&self, root: &tree::Table, incomplete: &mut Vec<String>) {
        let entries = |section: &str| match root.get(section).map(|node| &node.value) {
            Some(tree::Value::Table(table)) => table.entries.as_slice(),
            _ => &[],
        };
        for entry in entries("generate") {
            if !self.generate.iter().any(|request| request.domain.value == entry.key) {
                let also = generate::KINDS.iter().flat_map(|kind| kind.also_fills);
                incomplete.extend(also.map(|name| (*name).to_owned()));
                incomplete.push(entry.key.clone());
            }
        }
        for entry in entries("domains") {
            let asks = matches!(&entry.node.value, tree::Value::Table(table) if table.get("from").is_some());
            if asks && self.domain(&entry.key).is_none_or(|domain| domain.from.is_none()) {
                incomplete.push(entry.key.clone());
            }
        }
    }

    /// The domain `name`.
    pub fn domain(&self, name: &str) -> Option<&DomainData> {
        self.domains.iter().find(|domain| domain.name.value == name)
    }

    /// A fault of this scene at `span`, found by whoever knows more than the scene.
    pub fn fault(&self, span: Span, text: impl Into<String>, help: Option<String>) -> SceneFault {
        self.sources.fault(span, text, help)
    }

    /// A fault of this scene that stands nowhere in it: something that is missing.
    pub fn fault_of_file(&self, text: impl Into<String>) -> SceneFault {
        let SceneFault { file, text, .. } = self.sources.fault(Span::default(), text, None);
        SceneFault::of_file(file, text)
    }
}
