//! The folder of a sweep: a file for each run, so that any number of machines can fill it at once.
//!
//! In: a manifest, records. Out: `manifest.json`, `runs/NUMBER.json`, `table.csv`, `sweep.svg`; records that are there.
//! Never: a file that is half written: each is written beside its place, and then moved there; a lock.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use super::ensemble::Ensemble;
use super::manifest::Manifest;
use super::record::Record;
use crate::fault::SceneFault;
use crate::output::json;

/// What the folder is of.
const MANIFEST: &str = "manifest.json";
/// The records.
const RUNS: &str = "runs";
/// The table.
pub const TABLE: &str = "table.csv";
/// The picture.
pub const PICTURE: &str = "sweep.svg";

/// A folder that is of a sweep.
#[derive(Clone, Debug)]
pub struct SweepFolder {
    path: PathBuf,
}

impl SweepFolder {
    /// The folder at `path` for the sweep of `manifest`: made where it is not there.
    ///
    /// # Errors
    /// It cannot be made, or it is of another sweep, which is told in what.
    pub fn new(path: &Path, manifest: &Manifest) -> Result<Self, Vec<SceneFault>> {
        let wrong = |text: String| vec![SceneFault::of_file(path.display().to_string(), text)];
        let folder = Self { path: path.to_owned() };
        if !path.join(MANIFEST).exists() {
            let made = fs::create_dir_all(path.join(RUNS)).and_then(|()| folder.claim(manifest));
            made.map_err(|error| wrong(format!("the folder cannot be made: {error}")))?;
        }
        // Also where it was just written: another shard, or another sweep, may have been first.
        let there = Self::manifest(path)?;
        let help = "take another --out, or the same words as before; a folder holds one sweep";
        let fault = |text: String| SceneFault {
            help: Some(help.to_owned()),
            ..SceneFault::of_file(path.display().to_string(), format!("the folder is of another sweep; {text}"))
        };
        let faults: Vec<SceneFault> = there.differences(manifest).into_iter().map(fault).collect();
        if faults.is_empty() { Ok(folder) } else { Err(faults) }
    }

    /// A folder that is there, and the sweep that it is of.
    ///
    /// # Errors
    /// It is not the folder of a sweep.
    pub fn open(path: &Path) -> Result<(Self, Manifest), Vec<SceneFault>> {
        Ok((Self { path: path.to_owned() }, Self::manifest(path)?))
    }

    fn manifest(path: &Path) -> Result<Manifest, Vec<SceneFault>> {
        let file = path.join(MANIFEST);
        let wrong = |text: String| vec![SceneFault::of_file(file.display().to_string(), text)];
        let text = fs::read_to_string(&file).map_err(|error| wrong(format!("cannot be read: {error}")))?;
        Manifest::read(&text).map_err(|why| wrong(format!("is not the manifest of a sweep: {why}")))
    }

    /// Writes the manifest, unless there is one by now.
    fn claim(&self, manifest: &Manifest) -> io::Result<()> {
        let place = self.path.join(MANIFEST);
        let begun = self.begun(MANIFEST);
        fs::write(&begun, json::text(&manifest.to_json()))?;
        // A link fails where its name is taken, a move does not: of two sweeps that begin at once, one has the folder.
        let linked = fs::hard_link(&begun, &place);
        match linked {
            Ok(()) => fs::remove_file(&begun),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => fs::remove_file(&begun),
            // File systems without links.
            Err(_) => fs::rename(&begun, &place),
        }
    }

    /// A name beside a place that no other process takes.
    fn begun(&self, name: &str) -> PathBuf {
        let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_nanos());
        let name = name.replace(['/', '\\'], "-");
        self.path.join(format!(".{name}.{}.{now}.part", std::process::id()))
    }

    /// Writes a file, the whole of it or nothing.
    ///
    /// # Errors
    /// In words, that it cannot be written.
    pub fn write(&self, name: &str, text: &str) -> Result<(), String> {
        let (place, begun) = (self.path.join(name), self.begun(name));
        let written = fs::write(&begun, text).and_then(|()| fs::rename(&begun, &place));
        written.map_err(|error| {
            _ = fs::remove_file(&begun);
            format!("cannot write `{}`: {error}", place.display())
        })
    }

    /// Keeps a record.
    ///
    /// # Errors
    /// In words, that it cannot be written.
    pub fn keep(&self, ensemble: &Ensemble, record: &Record) -> Result<(), String> {
        self.write(&name(record.run), &json::text(&record.to_json(ensemble)))
    }

    /// The record of a run, where there is one. One that cannot be read is none: its run is made again.
    pub fn record(&self, ensemble: &Ensemble, run: usize) -> Option<Record> {
        let text = fs::read_to_string(self.path.join(name(run))).ok()?;
        Record::read(&text, ensemble, run).ok()
    }
}

/// The file of a run: numbers of one length, so that lists of files are in order.
fn name(run: usize) -> String {
    format!("{RUNS}/{run:06}.json")
}
