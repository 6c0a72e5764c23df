//! An array that is lent as a column.
//!
//! In: the array. Out: the array; a fault where its numbers are no longer where they were when it was lent. Never: a look at a
//! number.

use crate::failure::fault;
use numpy::npyffi::NPY_ARRAY_WRITEABLE;
use numpy::{PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::{PyTraverseError, PyVisit};

/// An array, and where its numbers are.
struct Place {
    array: Py<PyUntypedArray>,
    start: usize,
    count: usize,
}

impl Place {
    fn new(array: &Bound<'_, PyUntypedArray>) -> Self {
        Place { array: array.clone().unbind(), start: start(array), count: array.len() }
    }

    fn holds(&self, py: Python<'_>) -> bool {
        let array = self.array.bind(py);
        self.start == start(array) && self.count == array.len()
    }
}

/// Where the first number of an array is.
pub(crate) fn start(array: &Bound<'_, PyUntypedArray>) -> usize {
    // SAFETY: the array is there, and with Python's lock nobody changes it.
    unsafe { (*array.as_array_ptr()).fields.data.addr() }
}

/// An array that is lent as a column.
pub(crate) struct Lender {
    pub(crate) domain: String,
    pub(crate) property: String,
    /// The array, and behind it those that its memory is a part of: each of them can be resized.
    places: Vec<Place>,
}

impl Lender {
    pub(crate) fn new(domain: &str, property: String, array: &Bound<'_, PyUntypedArray>) -> PyResult<Self> {
        let mut places = vec![Place::new(array)];
        let mut base = array.getattr("base")?;
        while let Ok(array) = base.cast::<PyUntypedArray>() {
            places.push(Place::new(array));
            base = array.getattr("base")?;
        }
        Ok(Lender { domain: domain.to_owned(), property, places })
    }

    pub(crate) fn array<'py>(&self, py: Python<'py>) -> &Bound<'py, PyUntypedArray> {
        self.places[0].array.bind(py)
    }

    /// Looks whether the numbers are where they were: `resize(.., refcheck=False)` frees memory that others use.
    #[inline]
    pub(crate) fn check(&self, py: Python<'_>) -> PyResult<()> {
        // SAFETY: as in `start`.
        let flags = unsafe { (*self.array(py).as_array_ptr()).fields.flags };
        if flags & NPY_ARRAY_WRITEABLE != 0 && self.places.iter().all(|place| place.holds(py)) {
            return Ok(());
        }
        Err(self.changed(py))
    }

    #[cold]
    fn changed(&self, py: Python<'_>) -> PyErr {
        let (domain, property) = (&self.domain, &self.property);
        fault(if self.places.iter().all(|place| place.holds(py)) {
            format!(
                "{domain}.{property} is lent, and the array was made read-only since: set its flags.writeable to True"
            )
        } else {
            format!(
                "{domain}.{property} is lent, and the array was resized since, so that its memory is another: make a new engine, and \
                 do not resize what is lent"
            )
        })
    }

    pub(crate) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.places.iter().try_for_each(|place| visit.call(&place.array))
    }
}
