//! What is needed to make the runs of a sweep: the scene's text, its changes, the ensemble.
//!
//! In: a scene file, changes of it, what varies and what is measured. Out: the scene of each run; hashes of the files and modules
//! that it reads. Never: reads the scene file a second time, or another file with other bytes than the first time, so that
//! nothing that is edited meanwhile changes a run.

use std::collections::BTreeMap;
use std::path::Path;

use super::ensemble::Ensemble;
use crate::assemble;
use crate::fault::{SceneFault, Span, Spanned};
use crate::hash::fnv1a;
use crate::modules::Modules;
use crate::scene::{Files, Override, Scene};

/// A sweep that can be run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scene file, as it was named.
    pub file: String,
    /// Its text.
    pub text: String,
    /// Files that it names, which lie beside it.
    pub files: Files,
    /// Changes of the scene that all runs have.
    pub changes: Vec<Override>,
    /// Where modules of laws may come from.
    pub modules: Modules,
    /// Modules of laws that the scene names, each with a hash of its library, once a [check](super::check()) has looked at them.
    pub libraries: BTreeMap<String, String>,
    /// The runs.
    pub ensemble: Ensemble,
}

impl Plan {
    /// A sweep of the scene at `path`.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn new(path: &Path, changes: Vec<Override>, modules: Modules, ensemble: Ensemble) -> Result<Self, SceneFault> {
        let file = path.display().to_string();
        let text = std::fs::read_to_string(path)
            .map_err(|error| SceneFault::of_file(&file, format!("cannot be read: {error}")))?;
        let files = Files::on_account(path.parent().unwrap_or(Path::new("")));
        Ok(Self { file, text, files, changes, modules, libraries: BTreeMap::new(), ensemble })
    }

    /// All changes of the scene for a run. Short paths first, so that `engine.integrator` does not wipe out what
    /// `engine.integrator.rtol` has set, in whichever order they were given.
    pub fn overrides(&self, run: usize) -> Vec<Override> {
        let mut parameters = self.ensemble.parameters(run);
        parameters.sort_by_key(|(path, _)| path.matches('.').count());
        let varied = parameters
            .into_iter()
            .map(|(path, value)| Override::Vary { path: path.to_owned(), set: format!("{path}={value}") });
        self.changes.iter().cloned().chain(varied).collect()
    }

    /// The scene of a run: its columns that are measured are observed, and it takes one thread unless it says otherwise,
    /// for runs are what is made at the same time. (On how many threads a run is made changes no bit of it.)
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn scene(&self, run: usize) -> Result<Scene, Vec<SceneFault>> {
        let names = |scene: &Scene| assemble::names(scene, &self.modules);
        let mut scene = Scene::from_text_of(&self.file, &self.text, &self.files, &self.overrides(run), names)?;
        scene.modules = self.modules.clone();
        let engine = &mut scene.engine;
        engine.threads.get_or_insert(Spanned::new(1, Span::default()));
        for measure in &self.ensemble.measures {
            let column = format!("{}.{}", measure.domain, measure.property);
            engine.observe.get_or_insert_default().push(Spanned::new(column, Span::default()));
        }
        Ok(scene)
    }

    /// Takes note of what a scene reads beyond its text when it is run: modules, the table that it is compared with.
    ///
    /// # Errors
    /// The library of a module cannot be read.
    pub fn note(&mut self, scene: &Scene) -> Result<(), SceneFault> {
        if let Some(compare) = &scene.compare {
            // What is wrong with it is a fault of the run.
            _ = self.files.read(&compare.csv.value);
        }
        for name in scene.laws.iter().filter_map(|law| law.module.as_ref()) {
            if !self.libraries.contains_key(&name.value) {
                let module = self.modules.module(&name.value, self.files.folder());
                let bytes = module.and_then(|module| std::fs::read(module.path()).map_err(|error| error.to_string()));
                let wrong = |why| scene.fault(name.span, format!("module `{}`: {why}", name.value), None);
                self.libraries.insert(name.value.clone(), fnv1a(&bytes.map_err(wrong)?));
            }
        }
        Ok(())
    }
}
