//! The folder of a sweep: a file for each run, so that any number of machines can fill it at once.
//!
//! In: a manifest, records. Out: `manifest.json`, `runs/NUMBER.json`, `table.csv`, `sweep.svg`; records that are there.
//! Never: a file that is half written, also where the machine goes off: each is written beside its place, down to the disk, and
//! then moved there; a lock; a record of another sweep.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

use serde_json::Value;

use super::ensemble::Ensemble;
use super::manifest::Manifest;
use super::record::Record;
use crate::fault::SceneFault;
use crate::hash::fnv1a;
use crate::output::json;

/// What the folder is of.
const MANIFEST: &str = "manifest.json";
/// The records.
const RUNS: &str = "runs";
/// The table.
pub const TABLE: &str = "table.csv";
/// The picture.
pub const PICTURE: &str = "sweep.svg";
/// Under this name a record has the hash of its sweep's manifest.
const SWEEP: &str = "sweep";
/// So often, with so much time between, a manifest is read that ends in the middle: somebody may be writing it.
const LOOKS: u32 = 20;
const BETWEEN: Duration = Duration::from_millis(50);

/// A folder that is of a sweep.
#[derive(Clone, Debug)]
pub struct SweepFolder {
    path: PathBuf,
    /// The hash of the manifest that is there.
    sweep: String,
}

impl SweepFolder {
    /// The folder at `path` for the sweep of `manifest`: made where it is not there.
    ///
    /// # Errors
    /// It cannot be made, or it is of another sweep, which is told in what.
    pub fn new(path: &Path, manifest: &Manifest) -> Result<Self, Vec<SceneFault>> {
        let cannot = |error: io::Error| {
            let text = format!("the folder cannot be made: {error}");
            vec![SceneFault::of_file(path.display().to_string(), text)]
        };
        if !path.join(MANIFEST).exists() {
            let text = json::text(&manifest.to_json());
            let link = |from: &Path, to: &Path| fs::hard_link(from, to);
            fs::create_dir_all(path).and_then(|()| claim(path, &text, link)).map_err(cannot)?;
        }
        // Also where it was just written: another shard, or another sweep, may have been first.
        let (folder, there) = Self::open(path)?;
        let help = "take another --out, or the same words as before; a folder holds one sweep";
        let fault = |text: String| SceneFault {
            help: Some(help.to_owned()),
            ..SceneFault::of_file(path.display().to_string(), format!("the folder is of another sweep; {text}"))
        };
        let faults: Vec<SceneFault> = there.differences(manifest).into_iter().map(fault).collect();
        if !faults.is_empty() {
            return Err(faults);
        }
        // Whoever wrote the manifest may have gone off before this.
        fs::create_dir_all(path.join(RUNS)).and_then(|()| synced(path)).map_err(cannot)?;
        Ok(folder)
    }

    /// A folder that is there, and the sweep that it is of.
    ///
    /// # Errors
    /// It is not the folder of a sweep.
    pub fn open(path: &Path) -> Result<(Self, Manifest), Vec<SceneFault>> {
        let file = path.join(MANIFEST);
        let wrong = |text: String| vec![SceneFault::of_file(file.display().to_string(), text)];
        let mut looks = 1;
        loop {
            let text = fs::read_to_string(&file).map_err(|error| wrong(format!("cannot be read: {error}")))?;
            match Manifest::read(&text) {
                // Not the line's end, which may be yet to come.
                Ok(manifest) => {
                    let sweep = fnv1a(text.trim_end().as_bytes());
                    return Ok((Self { path: path.to_owned(), sweep }, manifest));
                }
                Err(_) if looks < LOOKS && serde_json::from_str::<Value>(&text).is_err() => {
                    looks += 1;
                    std::thread::sleep(BETWEEN);
                }
                Err(why) => return Err(wrong(format!("is not the manifest of a sweep: {why}"))),
            }
        }
    }

    /// Writes a file, the whole of it or nothing.
    ///
    /// # Errors
    /// In words, that it cannot be written.
    pub fn write(&self, name: &str, text: &str) -> Result<(), String> {
        let (place, begun) = (self.path.join(name), begun(&self.path, name));
        let written = written(&begun, text).and_then(|()| fs::rename(&begun, &place)).and_then(|()| {
            let folder = place.parent().unwrap_or(&self.path);
            synced(folder)
        });
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
        let mut value = record.to_json(ensemble);
        value[SWEEP] = Value::from(self.sweep.as_str());
        self.write(&name(record.run), &json::text(&value))
    }

    /// The record of a run, where there is one. One that breaks off is none, and so is that of another run: its run is made
    /// again.
    ///
    /// # Errors
    /// In words, that there is one which cannot be read, or which is of another sweep: neither may be lost by making its run again.
    pub fn record(&self, ensemble: &Ensemble, run: usize) -> Result<Option<Record>, String> {
        let place = self.path.join(name(run));
        let bytes = match fs::read(&place) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
            read => read.map_err(|error| format!("cannot read `{}`: {error}", place.display()))?,
        };
        let Ok(value) = serde_json::from_slice::<Value>(&bytes) else { return Ok(None) };
        if value.get(SWEEP).and_then(Value::as_str) != Some(&self.sweep) {
            return Err(format!(
                "`{}` is of another sweep than {MANIFEST}: take it away, and its run is made here, or take another --out",
                place.display()
            ));
        }
        Ok(Record::read(&value, ensemble, run).ok())
    }

    /// The runs that have a record, by the names of the files alone.
    ///
    /// # Errors
    /// In words, that there is no looking.
    pub fn listed(&self) -> Result<BTreeSet<usize>, String> {
        let place = self.path.join(RUNS);
        let numbers = |entries: fs::ReadDir| -> io::Result<BTreeSet<usize>> {
            let mut numbers = BTreeSet::new();
            for entry in entries {
                let file = entry?.file_name();
                let number = file.to_str().and_then(|file| file.strip_suffix(".json")?.parse().ok());
                numbers.extend(number.filter(|number| Some(file.as_os_str()) == Path::new(&name(*number)).file_name()));
            }
            Ok(numbers)
        };
        match fs::read_dir(&place).and_then(numbers) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(BTreeSet::new()),
            listed => listed.map_err(|error| format!("cannot read `{}`: {error}", place.display())),
        }
    }
}

/// Writes the manifest of `folder`, unless there is one by now. `link`: gives a file one more name, and fails where that is taken.
fn claim(folder: &Path, text: &str, link: impl Fn(&Path, &Path) -> io::Result<()>) -> io::Result<()> {
    let (begun, place) = (begun(folder, MANIFEST), folder.join(MANIFEST));
    written(&begun, text)?;
    // A link fails where its name is taken, a move does not: of two sweeps that begin at once, one has the folder. On file
    // systems without links there is only one way to a file that was not there before: to write it in its place.
    let claimed = match link(&begun, &place) {
        Err(error) if error.kind() != ErrorKind::AlreadyExists => written(&place, text),
        linked => linked,
    };
    _ = fs::remove_file(&begun);
    match claimed {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => Ok(()),
        claimed => claimed.and_then(|()| synced(folder)),
    }
}

/// A name in `folder` that no other process takes.
fn begun(folder: &Path, name: &str) -> PathBuf {
    let now = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).map_or(0, |since| since.as_nanos());
    let name = name.replace(['/', '\\'], "-");
    folder.join(format!(".{name}.{}.{now}.part", std::process::id()))
}

/// Writes a file that was not there, down to the disk: a name may get there before what it stands for.
fn written(path: &Path, text: &str) -> io::Result<()> {
    let mut file = File::create_new(path)?;
    let written = file.write_all(text.as_bytes()).and_then(|()| file.sync_all());
    if written.is_err() {
        _ = fs::remove_file(path);
    }
    written
}

/// Takes the names in a folder down to the disk, where the system has a way to.
#[cfg(unix)]
fn synced(folder: &Path) -> io::Result<()> {
    match File::open(folder)?.sync_all() {
        // Some file systems have none for folders.
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        synced => synced,
    }
}

#[cfg(not(unix))]
fn synced(_: &Path) -> io::Result<()> {
    Ok(())
}

/// The file of a run: numbers of one length, so that lists of files are in order.
fn name(run: usize) -> String {
    format!("{RUNS}/{run:06}.json")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_two_that_claim_a_folder_the_first_has_it_with_links_or_without() {
        let folder = std::env::temp_dir().join(format!("vesper-claims-{}", std::process::id()));
        let without = |_: &Path, _: &Path| Err(io::Error::from(ErrorKind::Unsupported));
        let with = |from: &Path, to: &Path| fs::hard_link(from, to);
        for links in [true, false] {
            _ = fs::remove_dir_all(&folder);
            fs::create_dir_all(&folder).unwrap();
            for text in ["first", "second"] {
                if links { claim(&folder, text, with) } else { claim(&folder, text, without) }.unwrap();
                assert_eq!(fs::read_to_string(folder.join(MANIFEST)).unwrap(), "first", "{links}");
            }
            assert_eq!(fs::read_dir(&folder).unwrap().count(), 1, "nothing is left beside it");
        }
        fs::remove_dir_all(&folder).unwrap();
    }
}
