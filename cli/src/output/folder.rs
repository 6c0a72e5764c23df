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

/// A folder that is being filled.
#[derive(Debug)]
pub struct Folder {
    path: PathBuf,
    tables: Vec<(String, Table)>,
    trails: Trails,
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

    /// Adds a moment of the run.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn add<P: Precision>(
        &mut self,
        scene: &Scene,
        engine: &Engine<P>,
        shown: &[ShownDomain],
    ) -> Result<(), String> {
        for domain in shown {
            if !self.tables.iter().any(|(name, _)| *name == domain.name) {
                let path = self.path.join(self.file_name(&domain.name));
                let labels = scene.domain(&domain.name).and_then(|domain| domain.labels.as_deref()).unwrap_or_default();
                let table = Table::new(&path, domain, labels).map_err(|error| cannot_write(&path, &error))?;
                self.tables.push((domain.name.clone(), table));
            }
            if let Some((name, table)) = self.tables.iter_mut().find(|(name, _)| *name == domain.name) {
                table
                    .add(engine.time(), domain)
                    .map_err(|error| format!("cannot write the table of `{name}`: {error}"))?;
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
            || self.tables.iter().any(|(other, _)| other.chars().map(plain).collect::<String>() == name);
        if taken { format!("{name}_{}.csv", self.tables.len()) } else { format!("{name}.csv") }
    }

    /// Writes what is left: picture, summary, checkpoint.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(self, scene: &Scene, outcome: &Outcome) -> Result<(), String> {
        for (name, table) in self.tables {
            table.finish().map_err(|error| format!("cannot write the table of `{name}`: {error}"))?;
        }
        let write = |name: &str, text: String| {
            let path = self.path.join(name);
            std::fs::write(&path, text).map_err(|error| cannot_write(&path, &error))
        };
        if let Some(picture) = Picture::new(scene, &self.trails) {
            write("trajectories.svg", picture.to_string())?;
        }
        write("summary.json", json::text(&json::outcome(outcome)))?;
        if let Some(state) = &outcome.checkpoint {
            write("checkpoint.json", format!("{}\n", checkpoint::to_json(state)))?;
        }
        Ok(())
    }
}

fn cannot_write(path: &Path, error: &std::io::Error) -> String {
    format!("cannot write `{}`: {error}", path.display())
}
