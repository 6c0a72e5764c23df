//! Modules of laws, compiled apart, for scenes that name them.
//!
//! In: folders that whoever runs the command named, and those of `VESPER_LAW_PATH`. Out: laws, by module and name. Never: a folder that a
//! scene named, unless whoever runs it said that it may; code out of a scene would be its author's.

use std::path::{Path, PathBuf};

use vesper::module::{LawPath, Module};
use vesper::prelude::Fault;

/// Where modules may come from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Modules {
    path: LawPath,
    /// Whether scenes may name files.
    files: bool,
}

impl Default for Modules {
    fn default() -> Self {
        Modules::new(&[], false)
    }
}

impl Modules {
    /// Modules in these folders, and in those of `VESPER_LAW_PATH`; files that scenes name, where they may.
    pub fn new(folders: &[PathBuf], files: bool) -> Self {
        Modules { path: LawPath::new(folders).and_environment(), files }
    }

    /// The module of a name; or, where scenes may name files, at a path from the scene's folder.
    ///
    /// # Errors
    /// There is none, or it cannot be used, in words.
    pub fn module(&self, name: &str, folder: &Path) -> Result<&'static Module, String> {
        let words = |faults: vesper::prelude::Faults| {
            let reason = |fault: &Fault| match fault {
                Fault::Module { reason, .. } => reason.clone(),
                other => other.to_string(),
            };
            faults.iter().map(reason).collect::<Vec<_>>().join("; ")
        };
        if name.contains(['/', std::path::MAIN_SEPARATOR]) {
            if !self.files {
                return Err("a scene may not name a file of code, only a module: give its folder with `--laws DIR`, or allow it \
                            with `--allow-module-files`"
                    .to_owned());
            }
            // SAFETY: whoever runs the command said that the scene is to be trusted.
            return unsafe { Module::open(&folder.join(name)) }.map_err(words);
        }
        // SAFETY: whoever runs the command named the folders.
        unsafe { self.path.module(name) }.map_err(words)
    }

    /// All modules of the folders that can be opened, and why the others cannot.
    pub fn all(&self) -> Vec<(String, Result<&'static Module, String>)> {
        let opened = |name: String| {
            let module = self.module(&name, Path::new(""));
            (name, module)
        };
        self.path.names().into_iter().map(opened).collect()
    }

    /// Whether there are folders to look in.
    pub fn any(&self) -> bool {
        !self.path.folders().is_empty()
    }
}
