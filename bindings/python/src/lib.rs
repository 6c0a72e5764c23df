//! Vesper from Python: the module `vesper._vesper`, which the package `vesper` dresses.
//!
//! In: names, texts, arrays of numpy, functions of Python. Out: engines, arrays that look into them without a copy, exceptions
//! with the text of every fault. Never: physics; an array that outlives what it looks at; a wait for another thread.

mod arrays;
mod assembly;
mod callback;
mod drive;
mod engine;
mod failure;
mod hold;
mod lender;

use pyo3::prelude::*;

/// Engines, and what they are put together with.
#[pymodule(gil_used = true)]
fn _vesper(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("Fault", module.py().get_type::<failure::Fault>())?;
    module.add("StepFault", module.py().get_type::<failure::StepFault>())?;
    module.add_class::<assembly::Assembly>()?;
    module.add_class::<engine::Engine>()?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))
}
