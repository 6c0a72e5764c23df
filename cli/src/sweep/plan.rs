//! What is needed to make the runs of a sweep: the scene's text, its changes, the ensemble.
//!
//! In: a scene file, changes of it, what varies and what is measured. Out: the scene of each run. Never: reads the scene file
//! a second time, so that a file that is edited meanwhile changes no run.

use std::path::{Path, PathBuf};

use super::ensemble::Ensemble;
use crate::assemble;
use crate::fault::{SceneFault, Span, Spanned};
use crate::modules::Modules;
use crate::scene::{Override, Scene};

/// A sweep that can be run.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The scene file, as it was named.
    pub file: String,
    /// Its text.
    pub text: String,
    /// Its folder: files that it names lie beside it.
    pub folder: PathBuf,
    /// Changes of the scene that all runs have.
    pub changes: Vec<Override>,
    /// Where modules of laws may come from.
    pub modules: Modules,
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
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        Ok(Self { file, text, folder, changes, modules, ensemble })
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
        let mut scene = Scene::from_text_and(&self.file, &self.text, &self.folder, &self.overrides(run), names)?;
        scene.modules = self.modules.clone();
        let engine = &mut scene.engine;
        engine.threads.get_or_insert(Spanned::new(1, Span::default()));
        for measure in &self.ensemble.measures {
            let column = format!("{}.{}", measure.domain, measure.property);
            engine.observe.get_or_insert_default().push(Spanned::new(column, Span::default()));
        }
        Ok(scene)
    }
}
