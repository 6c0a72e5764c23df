//! Arrays of numpy as numbers of a session, and back.
//!
//! In: arrays of any kind; views of columns. Out: slices, memory to lend, arrays that look into columns. Never: a conversion:
//! what does not fit is refused, with the call of numpy that mends it; numbers that change while they are read.

use crate::failure::fault;
use crate::lender;
use numpy::ndarray::{ArrayView, IntoDimension, ShapeBuilder};
use numpy::{
    BorrowError, Element, PyArray, PyArrayDescrMethods, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArray,
    PyUntypedArrayMethods,
};
use pyo3::prelude::*;
use std::ptr::NonNull;
use vesper_c::session::{Memory, NumberType, Numbers, View, is_lent};

/// An array whose numbers stand one behind the other, borrowed to be read.
pub(crate) enum Given<'py> {
    F32(PyReadonlyArrayDyn<'py, f32>),
    F64(PyReadonlyArrayDyn<'py, f64>),
    Rows(PyReadonlyArrayDyn<'py, u32>),
}

impl<'py> Given<'py> {
    /// The numbers of an array, which `what` is given by.
    pub(crate) fn new(what: &str, array: &Bound<'py, PyUntypedArray>) -> PyResult<Self> {
        contiguous(what, array)?;
        // Of memory that an engine has, some may be the column that is written: numpy, too, copies what overlaps.
        let array = &if shares(array) { array.call_method0("copy")?.cast_into()? } else { array.clone() };
        if let Ok(array) = array.cast::<PyArrayDyn<f64>>() {
            return Ok(Given::F64(read(what, array)?));
        }
        if let Ok(array) = array.cast::<PyArrayDyn<f32>>() {
            return Ok(Given::F32(read(what, array)?));
        }
        if let Ok(array) = array.cast::<PyArrayDyn<u32>>() {
            return Ok(Given::Rows(read(what, array)?));
        }
        let text =
            format!("{what} is an array of {}: give numbers of float64 or float32, or rows of uint32", array.dtype());
        Err(fault(text))
    }

    /// The numbers.
    pub(crate) fn numbers(&self) -> PyResult<Numbers<'_>> {
        Ok(match self {
            Given::F32(array) => Numbers::F32(array.as_slice()?),
            Given::F64(array) => Numbers::F64(array.as_slice()?),
            Given::Rows(array) => Numbers::Rows(array.as_slice()?),
        })
    }
}

/// Whether an engine has some of an array's memory.
fn shares(array: &Bound<'_, PyUntypedArray>) -> bool {
    let start = lender::start(array);
    is_lent(&(start..start + array.len() * array.dtype().itemsize()))
}

/// Fills an array by `get`.
pub(crate) fn fill<T: Element + Copy>(
    what: &str,
    array: &Bound<'_, PyArrayDyn<T>>,
    get: impl FnOnce(&mut [T]) -> PyResult<()>,
) -> PyResult<()> {
    contiguous(what, array.as_untyped())?;
    let shares = shares(array.as_untyped());
    let mut array = array.try_readwrite().map_err(|why| match why {
        BorrowError::NotWriteable => fault(format!("{what}: the array is read-only: give another one")),
        _ => fault(format!("{what}: somebody else uses the array: give another one")),
    })?;
    let numbers = array.as_slice_mut()?;
    if !shares {
        return get(numbers);
    }
    let mut copy = numbers.to_vec();
    get(&mut copy)?;
    numbers.copy_from_slice(&copy);
    Ok(())
}

fn read<'py, T: Element>(what: &str, array: &Bound<'py, PyArrayDyn<T>>) -> PyResult<PyReadonlyArrayDyn<'py, T>> {
    array.try_readonly().map_err(|_| fault(format!("{what}: the array is being written by somebody else: give a copy")))
}

fn contiguous(what: &str, array: &Bound<'_, PyUntypedArray>) -> PyResult<()> {
    if array.is_c_contiguous() {
        return Ok(());
    }
    let text =
        format!("{what}: the numbers of its rows do not stand one behind the other: give np.ascontiguousarray(..)");
    Err(fault(text))
}

/// The memory of an array, to be used in place.
pub(crate) fn memory(what: &str, precision: NumberType, array: &Bound<'_, PyUntypedArray>) -> PyResult<Memory> {
    contiguous(what, array)?;
    let flag = |name: &str| -> PyResult<bool> { array.getattr("flags")?.getattr(name)?.extract() };
    if !flag("aligned")? {
        return Err(fault(format!("{what}: its numbers are at odd addresses: lend a copy of it, np.array(..)")));
    }
    if !flag("writeable")? {
        return Err(fault(format!("{what} is read-only, and an engine writes what is lent to it: lend a copy of it")));
    }
    let wide = array.cast::<PyArrayDyn<f64>>().map(|array| (array.data(), array.len()));
    let narrow = array.cast::<PyArrayDyn<f32>>().map(|array| (array.data(), array.len()));
    Ok(match (precision, wide, narrow) {
        (NumberType::F64, Ok((start, count)), _) => {
            Memory::F64(NonNull::new(start).unwrap_or(NonNull::dangling()), count)
        }
        (NumberType::F32, _, Ok((start, count))) => {
            Memory::F32(NonNull::new(start).unwrap_or(NonNull::dangling()), count)
        }
        _ => {
            let (name, wanted) = match precision {
                NumberType::F32 => ("f32", "float32"),
                NumberType::F64 | NumberType::Rows => ("f64", "float64"),
            };
            let text = format!(
                "{what} cannot be lent: it is an array of {}, and the engine computes in {name}: give .astype(np.{wanted}), or \
                 have it copied",
                array.dtype()
            );
            return Err(fault(text));
        }
    })
}

/// An array that looks at one component of a column, or at a link.
///
/// # Safety
/// The numbers stay where the view says while `owner` lives.
pub(crate) unsafe fn looking<'py>(
    view: &View,
    component: usize,
    writeable: bool,
    owner: Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>> {
    let start = view.components[component];
    // SAFETY: passed on to the caller.
    unsafe {
        match view.numbers {
            NumberType::F32 => array(start.cast::<f32>(), view.rows, writeable, owner),
            NumberType::F64 => array(start.cast::<f64>(), view.rows, writeable, owner),
            NumberType::Rows => array(start.cast::<u32>(), (view.rows, view.width), writeable, owner),
        }
    }
}

/// An array that looks at the rows of a column which have a value.
///
/// # Safety
/// As for [`looking`].
pub(crate) unsafe fn subset<'py>(view: &View, owner: Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    // SAFETY: passed on to the caller.
    unsafe { array(view.subset.cast_mut(), view.rows, false, owner) }
}

/// # Safety
/// `start` points to as many numbers as the shape has, which stay there while `owner` lives.
unsafe fn array<'py, T: Element, S: IntoDimension>(
    start: *mut T,
    shape: S,
    writeable: bool,
    owner: Bound<'py, PyAny>,
) -> PyResult<Bound<'py, PyAny>>
where
    S::Dim: ShapeBuilder<Dim = S::Dim>,
{
    let start = if start.is_null() { NonNull::dangling().as_ptr() } else { start };
    // SAFETY: passed on to the caller; nobody writes while this view of the numbers is there, which is until it is given to numpy.
    let numbers = unsafe { ArrayView::from_shape_ptr(shape.into_dimension(), start.cast_const()) };
    // SAFETY: the caller promises that the numbers are there while the owner lives.
    let array = unsafe { PyArray::borrow_from_array(&numbers, owner) };
    if !writeable {
        let write = pyo3::types::PyDict::new(array.py());
        write.set_item("write", false)?;
        array.call_method("setflags", (), Some(&write))?;
    }
    Ok(array.into_any())
}
