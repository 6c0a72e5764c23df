//! An engine that runs.
//!
//! In: names, steps, arrays. Out: steps taken, without Python's lock; arrays that look at columns in place. Never: a call into an
//! engine that is at work; memory that moves under an array.

use crate::arrays::{self, Given};
use crate::assembly::Lender;
use crate::callback::Callback;
use crate::failure::{fault, raised};
use crate::hold::Hold;
use numpy::{PyArrayDyn, PyArrayMethods, PyUntypedArray};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pyo3::{PyTraverseError, PyVisit};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError};
use vesper_c::session::{NumberType, Numbers, NumbersMut, Session, View, Words};

/// How many arrays look into an engine, and which columns may be written through them.
#[derive(Debug, Default)]
pub(crate) struct Looks {
    count: AtomicUsize,
    writing: AtomicUsize,
    written: Mutex<Vec<(String, String)>>,
    /// Rows, laws or observers changed: columns move when the engine follows, which it has to before somebody looks.
    stale: AtomicBool,
}

impl Looks {
    fn written(&self) -> MutexGuard<'_, Vec<(String, String)>> {
        self.written.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn begin(&self, written: Option<&(String, String)>) {
        self.count.fetch_add(1, Ordering::Relaxed);
        if let Some(column) = written {
            self.writing.fetch_add(1, Ordering::Relaxed);
            self.written().push(column.clone());
        }
    }

    pub(crate) fn end(&self, written: Option<&(String, String)>) {
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

/// An engine that runs. The package's class `Engine` puts it together.
#[pyclass(frozen, subclass, module = "vesper._vesper")]
pub(crate) struct Engine {
    session: Mutex<Session>,
    pub(crate) looks: Looks,
    /// Arrays that are lent.
    lenders: Vec<Lender>,
    callbacks: Vec<Arc<Callback>>,
}

impl Engine {
    pub(crate) fn new(session: Session, lenders: Vec<Lender>, callbacks: Vec<Arc<Callback>>) -> Self {
        let looks = Looks { stale: AtomicBool::new(true), ..Looks::default() };
        Engine { session: Mutex::new(session), looks, lenders, callbacks }
    }

    /// The session, unless somebody uses it.
    #[inline]
    fn session(&self) -> PyResult<MutexGuard<'_, Session>> {
        match self.session.try_lock() {
            Ok(session) => Ok(session),
            Err(TryLockError::WouldBlock) => {
                Err(fault("the engine is at work, for another thread or for this law: wait until its call is done"))
            }
            Err(TryLockError::Poisoned(_)) => Err(fault(
                "the engine came to harm by a mistake inside the library: make another one, and tell its authors",
            )),
        }
    }

    /// The session, to change where columns are.
    fn session_to_move(&self, what: &str) -> PyResult<MutexGuard<'_, Session>> {
        let looking = self.looks.count.load(Ordering::Relaxed);
        if looking > 0 {
            let arrays = if looking == 1 { "1 array looks" } else { &format!("{looking} arrays look") };
            let text =
                format!("{what} would move columns that {arrays} at in place: delete them (del), or work with copies");
            return Err(fault(text));
        }
        let session = self.session()?;
        self.looks.stale.store(true, Ordering::Relaxed);
        Ok(session)
    }

    /// The session, after it has followed what changed: columns stay where they are until rows, laws or observers change again.
    fn settled(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Session>> {
        let stale = &self.looks.stale;
        loop {
            let session = self.session()?;
            if !stale.load(Ordering::Relaxed) {
                return Ok(session);
            }
            drop(session);
            self.run(py, |session| session.refresh().inspect(|()| stale.store(false, Ordering::Relaxed)))?;
        }
    }

    /// Runs a call that takes steps, while other threads of Python run, too.
    #[inline]
    fn run(
        &self,
        py: Python<'_>,
        call: impl FnOnce(&mut Session) -> Result<(), vesper_c::session::Trouble> + Send,
    ) -> PyResult<()> {
        let mut session = self.session()?;
        if self.looks.writing.load(Ordering::Relaxed) > 0 {
            for (domain, property) in self.looks.written().iter() {
                session.column_to_change(domain, property).map_err(raised)?;
            }
        }
        let session = &mut *session;
        let done = py.detach(|| call(session));
        match self.callbacks.iter().find_map(|callback| callback.raised()) {
            Some(error) => Err(error),
            None => done.map_err(raised),
        }
    }

    /// The array that is lent as this column.
    fn lender(&self, domain: &str, property: &str) -> Option<&Lender> {
        self.lenders.iter().find(|lender| lender.domain == domain && lender.property == property)
    }

    fn view<'py>(
        this: &Bound<'py, Self>,
        (domain, property): (&str, &str),
        writeable: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = this.py();
        let mut session = this.get().settled(py)?;
        let view =
            if writeable { session.column_to_change(domain, property) } else { session.column(domain, property) };
        let view = view.map_err(raised)?;
        if let Some(lender) = this.get().lender(domain, property) {
            return Ok(lender.array.bind(py).clone().into_any());
        }
        let components = if view.numbers == NumberType::Rows { 1 } else { view.width };
        let mut arrays = Vec::with_capacity(components);
        for component in 0..components {
            let written = writeable.then(|| (domain.to_owned(), property.to_owned()));
            let owner = Hold::begin(this, written)?;
            // SAFETY: nothing moves columns while holds are counted, and a hold keeps the engine.
            arrays.push(unsafe { arrays::looking(&view, component, writeable, owner)? });
        }
        match arrays.pop() {
            Some(only) if arrays.is_empty() => Ok(only),
            last => {
                arrays.extend(last);
                py.import("vesper")?.getattr("Vector")?.call1(PyTuple::new(py, arrays)?)
            }
        }
    }

    fn look(&self, domain: &str, property: &str) -> PyResult<View> {
        self.session()?.column(domain, property).map_err(raised)
    }
}

#[pymethods]
impl Engine {
    /// The engine that was put together.
    #[new]
    fn made(assembly: &crate::assembly::Assembly) -> PyResult<Self> {
        assembly.build()
    }

    /// Takes `count` steps of `step` s.
    #[pyo3(signature = (count, step, /))]
    fn step(&self, py: Python<'_>, count: u64, step: f64) -> PyResult<()> {
        self.run(py, |session| session.step(count, step))
    }

    /// Goes on by `frame` s: by as many steps of the set length as fit, the rest is carried to the next frame; without a set
    /// step by one step.
    #[pyo3(signature = (frame, /))]
    fn advance(&self, py: Python<'_>, frame: f64) -> PyResult<()> {
        self.run(py, |session| session.advance(frame))
    }

    /// The time, in s.
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.session()?.time())
    }

    /// Steps taken.
    #[getter]
    fn steps(&self) -> PyResult<u64> {
        Ok(self.session()?.steps())
    }

    /// "f32" or "f64".
    #[getter]
    fn precision(&self) -> PyResult<&'static str> {
        Ok(self.session()?.precision().name())
    }

    /// A column in place, to look at.
    fn __getitem__<'py>(this: &Bound<'py, Self>, key: (String, String)) -> PyResult<Bound<'py, PyAny>> {
        Self::view(this, (&key.0, &key.1), false)
    }

    /// A column in place, to change.
    fn writable<'py>(this: &Bound<'py, Self>, domain: &str, property: &str) -> PyResult<Bound<'py, PyAny>> {
        Self::view(this, (domain, property), true)
    }

    /// The rows of a column that have a value; None where all have one.
    fn rows<'py>(this: &Bound<'py, Self>, domain: &str, property: &str) -> PyResult<Option<Bound<'py, PyAny>>> {
        let session = this.get().settled(this.py())?;
        let view = session.column(domain, property).map_err(raised)?;
        if view.subset.is_null() {
            return Ok(None);
        }
        let owner = Hold::begin(this, None)?;
        // SAFETY: as in `view`.
        unsafe { arrays::subset(&view, owner) }.map(Some)
    }

    /// How many values a column has, and how many numbers each.
    fn shape(&self, domain: &str, property: &str) -> PyResult<(usize, usize)> {
        self.look(domain, property).map(|view| (view.rows, view.width))
    }

    /// The type of the numbers of a column: "f32", "f64", or "u32" for a link.
    fn kind(&self, domain: &str, property: &str) -> PyResult<&'static str> {
        self.look(domain, property).map(|view| view.numbers.name())
    }

    /// Copies all numbers of a column into a new array.
    fn copy_to(&self, domain: &str, property: &str, array: &Bound<'_, PyUntypedArray>) -> PyResult<()> {
        let session = self.session()?;
        let busy = |_| fault(format!("{domain}.{property}: somebody else uses the array: give another one"));
        let get = |numbers: NumbersMut<'_>| session.get(domain, property, numbers).map_err(raised);
        if let Ok(array) = array.cast::<PyArrayDyn<f64>>() {
            return get(NumbersMut::F64(array.try_readwrite().map_err(busy)?.as_slice_mut()?));
        }
        if let Ok(array) = array.cast::<PyArrayDyn<f32>>() {
            return get(NumbersMut::F32(array.try_readwrite().map_err(busy)?.as_slice_mut()?));
        }
        match array.cast::<PyArrayDyn<u32>>() {
            Ok(array) => get(NumbersMut::Rows(array.try_readwrite().map_err(busy)?.as_slice_mut()?)),
            Err(_) => Err(fault(format!("{domain}.{property}: ask for float64, float32, or uint32 for a link"))),
        }
    }

    /// Changes all numbers of a column.
    fn copy_from(&self, domain: &str, property: &str, array: &Bound<'_, PyUntypedArray>) -> PyResult<()> {
        let given = Given::new(&format!("{domain}.{property}"), array)?;
        self.session()?.set(domain, property, given.numbers()?).map_err(raised)
    }

    /// Adds rows behind the last: an array for each property.
    fn append(&self, domain: &str, rows: usize, columns: &Bound<'_, PyDict>) -> PyResult<()> {
        let mut named: Vec<(String, Given<'_>)> = Vec::new();
        for (name, array) in columns {
            let name: String = name.extract()?;
            let given = Given::new(&format!("{domain}.{name}"), array.cast::<PyUntypedArray>()?)?;
            named.push((name, given));
        }
        let columns = named.iter().map(|(name, given)| Ok((name.as_str(), given.numbers()?)));
        let columns: Vec<(&str, Numbers<'_>)> = columns.collect::<PyResult<_>>()?;
        self.session_to_move("adding rows")?.add_rows(domain, rows, &columns).map_err(raised)
    }

    /// Removes rows, and with them rows that link to them; later rows move up.
    fn remove_rows(&self, domain: &str, rows: Vec<u32>) -> PyResult<()> {
        self.session_to_move("removing rows")?.remove_rows(domain, &rows).map_err(raised)
    }

    /// Switches a law on or off, by its label, or else its name.
    #[pyo3(signature = (law, on = true))]
    fn enable(&self, law: &str, on: bool) -> PyResult<()> {
        self.session_to_move("switching a law")?.enable(law, on).map_err(raised)
    }

    /// Looks at a property that laws compute, from now on.
    fn observe(&self, domain: &str, property: &str) -> PyResult<()> {
        self.session_to_move("observing one more column")?.observe(domain, property).map_err(raised)
    }

    /// Which laws run, which do not, and why; what nobody uses.
    fn report(&self) -> PyResult<String> {
        self.session_to_move("a report")?.words(Words::Report).map_err(raised)
    }

    /// The order of the laws, merged passes, and what moves where.
    fn explain(&self) -> PyResult<String> {
        self.session_to_move("an explanation")?.words(Words::Explain).map_err(raised)
    }

    /// The graph of the laws in the language of Graphviz.
    fn dot(&self) -> PyResult<String> {
        self.session_to_move("a graph")?.words(Words::Dot).map_err(raised)
    }

    /// The complete state, as text.
    fn checkpoint(&self) -> PyResult<String> {
        self.session()?.words(Words::Checkpoint).map_err(raised)
    }

    /// Goes on from a checkpoint of an engine that was put together alike.
    fn restore(&self, checkpoint: &str) -> PyResult<()> {
        self.session_to_move("going back to a checkpoint")?.restore(checkpoint).map_err(raised)
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.lenders.iter().try_for_each(|lender| visit.call(&lender.array))?;
        self.callbacks.iter().try_for_each(|callback| callback.traverse(&visit))
    }

    fn __clear__(&self) {
        self.callbacks.iter().for_each(|callback| callback.clear());
    }
}
