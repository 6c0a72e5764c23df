//! The files beside a scene, for whoever reads one scene many times and must find the same.
//!
//! In: a folder, names of files in it. Out: their texts; of those that were read on account, a hash of each. Never: on
//! account, other bytes under a name than it had the first time.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use crate::hash::fnv1a;

/// Stands for the hash of a file that could not be read.
const NONE: &str = "-";

/// Where a scene's files are read from.
#[derive(Clone, Debug, Default)]
pub struct Files {
    folder: PathBuf,
    /// The hash of each file that was read, by its name; none where nobody asks. All clones have one account.
    account: Option<Arc<Mutex<BTreeMap<String, String>>>>,
}

impl Files {
    /// Those in a folder, each as it is when it is read.
    pub fn of(folder: &Path) -> Self {
        Self { folder: folder.to_owned(), account: None }
    }

    /// Those in a folder, on account. Contents are not kept, for there may be one for each of many runs: what is read is
    /// compared by its hash, so there is no moment in which a change goes unseen.
    pub fn on_account(folder: &Path) -> Self {
        Self { account: Some(Arc::default()), ..Self::of(folder) }
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The text of a file.
    ///
    /// # Errors
    /// It cannot be read, is no UTF-8, or is not what it was the first time.
    pub fn read(&self, name: &str) -> io::Result<String> {
        let bytes = std::fs::read(self.folder.join(name));
        if let Some(account) = &self.account {
            let hash = bytes.as_ref().map_or_else(|_| NONE.to_owned(), |bytes| fnv1a(bytes));
            let mut account = account.lock().unwrap_or_else(PoisonError::into_inner);
            let known = account.entry(name.to_owned()).or_insert_with(|| hash.clone());
            if bytes.is_ok() && *known != hash {
                return Err(io::Error::other("it has changed since it was read first; put it back, or begin again"));
            }
        }
        String::from_utf8(bytes?).map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))
    }

    /// The names of all files that were read on account, each with the hash of its bytes; `-` where it could not be read.
    pub fn account(&self) -> Vec<(String, String)> {
        let Some(account) = &self.account else { return Vec::new() };
        account.lock().unwrap_or_else(PoisonError::into_inner).clone().into_iter().collect()
    }
}
