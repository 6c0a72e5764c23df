//! The folder of a run: a table for each domain, a picture, the summary, a checkpoint.
//!
//! In: columns at moments, and the outcome. Out: `DOMAIN.csv`, `trajectories.svg`, `summary.json`, `checkpoint.json`.
//! Never: a file outside the folder, whatever a domain is called.

use std::path::{Path, PathBuf};

use vesper::prelude::*;

use super::picture::{Picture, Trails};
use super::table::Table;
use super::{checkpoint, json};
use crate::run::Outcome;
use crate::run::snapshot::ShownDomain;
use crate::scene::Scene;

/// Files that are not tables.
const OWN: [&str; 3] = ["trajectories", "summary", "checkpoint"];

/// The checkpoint in the folder.
pub const CHECKPOINT: &str = "checkpoint.json";

/// A folder that is being filled.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    /// Domain, file name, and the table; none where it could not be written.
    tables: Vec<(String, String, Option<Table>)>,
    trails: Trails,
}

/// What came of writing the files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Written {
    /// Names of the files that are whole.
    pub files: Vec<String>,
    /// What went wrong with others.
    pub faults: Vec<String>,
}

impl Folder {
    /// Makes the folder, where it is not there.
    ///
    /// # Errors
    /// It cannot be made.
    pub fn new(path: &Path) -> Result<Self, String> {
        std::fs::create_dir_all(path)
            .map_err(|error| format!("cannot make the folder `{}`: {error}", path.display()))?;
        Ok(Self { path: path.to_owned(), tables: Vec::new(), trails: Trails::default() })
    }

    /// Adds a moment of the run, to the tables too where there are columns for them.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn add<P: Precision>(
        &mut self,
        scene: &Scene,
        engine: &Engine<P>,
        shown: Option<&[ShownDomain]>,
    ) -> Result<(), String> {
        for domain in shown.unwrap_or_default() {
            if !self.tables.iter().any(|(name, ..)| *name == domain.name) {
                let file = self.file_name(&domain.name);
                let path = self.path.join(&file);
                let labels = scene.domain(&domain.name).and_then(|domain| domain.labels.as_deref()).unwrap_or_default();
                let table = Table::new(&path, domain, labels);
                let (table, failed) = table.map_or_else(|error| (None, Some(error)), |table| (Some(table), None));
                self.tables.push((domain.name.clone(), file, table));
                failed.map_or(Ok(()), |error| Err(cannot_write(&path, &error)))?;
            }
            let known = self.tables.iter_mut().find(|(name, ..)| *name == domain.name);
            let Some((_, file, place @ Some(_))) = known else { continue };
            if let Some(Err(error)) = place.as_mut().map(|table| table.add(engine.time(), domain)) {
                *place = None;
                return Err(cannot_write(&self.path.join(file), &error));
            }
        }
        self.trails.add(engine.state());
        Ok(())
    }

    /// A name for the table of a domain: letters, digits, `-` and `_` only, and no other table's.
    fn file_name(&self, domain: &str) -> String {
        let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' };
        let name: String = domain.chars().map(plain).collect();
        let taken = OWN.contains(&name.as_str())
            || self.tables.iter().any(|(other, ..)| other.chars().map(plain).collect::<String>() == name);
        if taken { format!("{name}_{}.csv", self.tables.len()) } else { format!("{name}.csv") }
    }

    /// Writes what is left: picture, summary, checkpoint. One that cannot be written keeps no other from being tried.
    pub fn finish(self, scene: &Scene, outcome: &Outcome) -> Written {
        let mut written = Written::default();
        let mut note = |file: &str, result: std::io::Result<()>| match result {
            Ok(()) => written.files.push(file.to_owned()),
            Err(error) => written.faults.push(cannot_write(&self.path.join(file), &error)),
        };
        for (_, file, table) in self.tables {
            if let Some(table) = table {
                note(&file, table.finish());
            }
        }
        if let Some(picture) = Picture::new(scene, &self.trails) {
            note("trajectories.svg", std::fs::write(self.path.join("trajectories.svg"), picture.to_string()));
        }
        let summary = json::text(&json::outcome(outcome));
        note("summary.json", std::fs::write(self.path.join("summary.json"), summary));
        if let Some(state) = &outcome.checkpoint {
            let text = format!("{}\n", checkpoint::to_json(state));
            note(CHECKPOINT, std::fs::write(self.path.join(CHECKPOINT), text));
        }
        written
    }
}

fn cannot_write(path: &Path, error: &std::io::Error) -> String {
    format!("cannot write `{}`: {error}", path.display())
}
