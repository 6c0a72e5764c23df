//! Faults as exceptions.
//!
//! In: what a session has to complain about. Out: an exception with the same text. Never: a text that is cut short.

use pyo3::PyErr;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use vesper_c::session::Trouble;

create_exception!(
    vesper,
    Fault,
    PyException,
    "What was described or asked for does not fit. The text says who, what, where, and what to do, for every fault."
);
create_exception!(
    vesper,
    StepFault,
    Fault,
    "A step could not be taken, or numbers became infinite or NaN; or a law of a module failed in a step, which was taken without it. \
     `engine.steps` says how far it came."
);

/// The exception for a trouble.
pub(crate) fn raised(trouble: Trouble) -> PyErr {
    match trouble {
        Trouble::Run(text) => StepFault::new_err(text),
        Trouble::Argument(text) | Trouble::Fault(text) => Fault::new_err(text),
    }
}

/// An exception with this text.
pub(crate) fn fault(text: impl Into<String>) -> PyErr {
    Fault::new_err(text.into())
}
