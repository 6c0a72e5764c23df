//! Who looks into an engine: the base of arrays of numpy that look at its columns.
//!
//! In: an engine and a column of it. Out: an object that keeps the engine alive, and counts, while an array has it as its base.
//! Never: memory of its own.

use crate::engine::Engine;
use pyo3::prelude::*;

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
