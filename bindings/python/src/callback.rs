//! A function of Python as a law.
//!
//! In: a function that takes arrays and gives arrays. Out: a law over whole columns, which takes Python's lock, hands copies of
//! its columns to the function, and copies what it returns. Never: a column that Python keeps; an exception that is lost.

use numpy::{IntoPyArray, PyArray1, PyArrayDyn, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyList, PyTuple};
use pyo3::{PyTraverseError, PyVisit};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The first exception that laws of an engine raised since somebody asked: no law is called until then.
#[derive(Debug, Default)]
pub(crate) struct Raised(Mutex<Option<PyErr>>);

impl Raised {
    /// The exception, which is over then.
    pub(crate) fn take(&self) -> Option<PyErr> {
        locked(&self.0).take()
    }
}

/// The function, and where its exceptions go.
pub(crate) struct Callback {
    function: Mutex<Option<Py<PyAny>>>,
    /// For each array that it takes, the numbers in a row; and whether it is a constant of the scene, of one row.
    inputs: Vec<(usize, bool)>,
    /// For each array that it gives, the numbers in a row.
    outputs: Vec<usize>,
    raised: Arc<Raised>,
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Callback {
    pub(crate) fn new(
        function: Py<PyAny>,
        inputs: Vec<(usize, bool)>,
        outputs: Vec<usize>,
        raised: Arc<Raised>,
    ) -> Self {
        Callback { function: Mutex::new(Some(function)), inputs, outputs, raised }
    }

    /// What the function gives. After an exception of any law none is called until somebody asks for the exception, and results are
    /// NaN: they end the call where they move something.
    pub(crate) fn call(&self, given: &[Vec<f64>], results: &mut [Vec<f64>]) {
        let failed = locked(&self.raised.0).is_some();
        let done = if failed { None } else { Python::try_attach(|py| self.called(py, given, results)) };
        if let Some(Ok(())) = done {
            return;
        }
        if let Some(Err(error)) = done {
            // Of laws that ran at once, on several threads, the first one is told.
            locked(&self.raised.0).get_or_insert(error);
        }
        results.iter_mut().for_each(|numbers| numbers.fill(f64::NAN));
    }

    fn called(&self, py: Python<'_>, given: &[Vec<f64>], results: &mut [Vec<f64>]) -> PyResult<()> {
        let function = locked(&self.function).as_ref().map(|function| function.clone_ref(py));
        let Some(function) = function else { return Ok(()) };
        let mut arrays = Vec::with_capacity(given.len());
        for (numbers, &(width, constant)) in given.iter().zip(&self.inputs) {
            arrays.push(match (&numbers[..], width, constant) {
                (&[number], 1, true) => number.into_pyobject(py)?.into_any(),
                (numbers, 1, _) | (numbers, _, true) => PyArray1::from_slice(py, numbers).into_any(),
                (numbers, ..) => numbers.to_vec().into_pyarray(py).reshape([numbers.len() / width, width])?.into_any(),
            });
        }
        let shapes = results.iter().zip(&self.outputs).map(|(numbers, &width)| (numbers.len() / width, width));
        let shapes = PyList::new(py, shapes)?;
        let returned = function.bind(py).call1((PyTuple::new(py, arrays)?, shapes))?;
        for (numbers, array) in results.iter_mut().zip(returned.try_iter()?) {
            let array = array?;
            let array = array.cast::<PyArrayDyn<f64>>()?.try_readonly()?;
            numbers.copy_from_slice(array.as_slice()?);
        }
        Ok(())
    }

    pub(crate) fn traverse(&self, visit: &PyVisit<'_>) -> Result<(), PyTraverseError> {
        match self.function.try_lock() {
            Ok(function) => visit.call(&*function),
            Err(_) => Ok(()),
        }
    }

    /// Lets go of the function.
    pub(crate) fn clear(&self) {
        locked(&self.function).take();
    }
}
