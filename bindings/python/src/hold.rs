//! Who looks into an engine: the base of arrays of numpy that look at its columns, and how many there are.
//!
//! In: an engine and a column of it. Out: an object that keeps the engine alive, and counts, while an array has it as its base.
//! Never: memory of its own.

use crate::engine::Engine;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// How many arrays look into an engine, and which columns may be written through them.
#[derive(Debug, Default)]
pub(crate) struct Looks {
    count: AtomicUsize,
    writing: AtomicUsize,
    written: Mutex<Vec<(String, String)>>,
}

impl Looks {
    /// How many arrays there are.
    #[inline]
    pub(crate) fn count(&self) -> usize {
        self.count.load(Ordering::Relaxed)
    }

    /// Whether a column may be written through one of them.
    #[inline]
    pub(crate) fn writes(&self) -> bool {
        self.writing.load(Ordering::Relaxed) > 0
    }

    /// The columns that may be written.
    pub(crate) fn written(&self) -> MutexGuard<'_, Vec<(String, String)>> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn begin(&self, written: Option<&(String, String)>) {
        self.count.fetch_add(1, Ordering::Relaxed);
        if let Some(column) = written {
            self.writing.fetch_add(1, Ordering::Relaxed);
            self.written().push(column.clone());
        }
    }

    fn end(&self, written: Option<&(String, String)>) {
        self.count.fetch_sub(1, Ordering::Relaxed);
        if let Some(column) = written {
            self.writing.fetch_sub(1, Ordering::Relaxed);
            let mut all = self.written();
            if let Some(place) = all.iter().position(|other| other == column) {
                all.swap_remove(place);
            }
        }
    }
}

/// What an array that looks into an engine has as its base.
#[pyclass(frozen, module = "vesper._vesper")]
pub(crate) struct Hold {
    /// The engine, which lives as long as the array.
    #[pyo3(get)]
    engine: Py<Engine>,
    /// The column that is written through the array; none where it is only looked at.
    written: Option<(String, String)>,
}

impl Hold {
    /// Counts one more array.
    pub(crate) fn begin<'py>(
        engine: &Bound<'py, Engine>,
        written: Option<(String, String)>,
    ) -> PyResult<Bound<'py, PyAny>> {
        engine.get().looks.begin(written.as_ref());
        Ok(Bound::new(engine.py(), Hold { engine: engine.clone().unbind(), written })?.into_any())
    }
}

impl Drop for Hold {
    fn drop(&mut self) {
        self.engine.get().looks.end(self.written.as_ref());
    }
}
