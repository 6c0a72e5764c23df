//! An engine that runs.
//!
//! In: names, steps, arrays. Out: steps taken, without Python's lock; arrays that look at columns in place. Never: a call into an
//! engine that is at work; memory that moves under an array.

use crate::arrays::{self, Given};
use crate::assembly::bare;
use crate::callback::{Callback, Raised};
use crate::drive::Pace;
use crate::failure::{fault, raised};
use crate::hold::{Hold, Looks};
use crate::lender::Lender;
use numpy::{PyArrayDyn, PyUntypedArray, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pyo3::{PyTraverseError, PyVisit};
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use vesper_c::session::{NumberType, Numbers, NumbersMut, Session, Trouble, View, Words};

/// An engine that runs. The package's class `Engine` puts it together.
#[pyclass(frozen, subclass, module = "vesper._vesper")]
pub(crate) struct Engine {
    session: Mutex<Session>,
    pub(crate) looks: Looks,
    /// Arrays that are lent.
    lenders: Vec<Lender>,
    callbacks: Vec<Arc<Callback>>,
    /// What laws of Python raised.
    laws: Arc<Raised>,
    pace: Pace,
}

impl Engine {
    pub(crate) fn new(
        py: Python<'_>,
        session: Session,
        lenders: Vec<Lender>,
        callbacks: Vec<Arc<Callback>>,
        laws: Arc<Raised>,
    ) -> Self {
        let lent = lenders.iter().map(|lender| lender.array(py).len()).sum();
        let pace = Pace::new(&session, lent, !callbacks.is_empty());
        Engine { session: Mutex::new(session), looks: Looks::default(), lenders, callbacks, laws, pace }
    }

    /// The session, unless somebody uses it.
    #[inline]
    fn entered(&self) -> PyResult<MutexGuard<'_, Session>> {
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

    /// The session, for a call that may look at lent memory.
    fn session(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Session>> {
        let session = self.entered()?;
        self.check(py)?;
        Ok(session)
    }

    /// Looks whether all lent memory is where it was.
    #[inline]
    fn check(&self, py: Python<'_>) -> PyResult<()> {
        self.lenders.iter().try_for_each(|lender| lender.check(py))
    }

    /// A fault where somebody looks at columns that a call moves.
    fn unless_seen(&self, what: &str, why: &str) -> PyResult<()> {
        let looking = self.looks.count();
        if looking == 0 {
            return Ok(());
        }
        let arrays = if looking == 1 { "1 array looks" } else { &format!("{looking} arrays look") };
        let text =
            format!("{what} would move columns that {arrays} at in place{why}: delete them (del), or work with copies");
        Err(fault(text))
    }

    /// The session, to change where columns are.
    fn session_to_move(&self, py: Python<'_>, what: &str) -> PyResult<MutexGuard<'_, Session>> {
        self.unless_seen(what, "")?;
        self.session(py)
    }

    /// The session, for a call that follows what changed: that moves columns, where a law failed in the last call.
    #[inline]
    fn session_to_follow(&self, what: &str) -> PyResult<MutexGuard<'_, Session>> {
        let session = self.entered()?;
        if self.looks.count() > 0 && !session.is_settled() {
            self.unless_seen(what, ", since laws changed or failed")?;
        }
        Ok(session)
    }

    /// The session, to take steps.
    #[inline]
    fn session_to_step(&self) -> PyResult<MutexGuard<'_, Session>> {
        let mut session = self.session_to_follow("a step")?;
        if self.looks.writes() {
            for (domain, property) in self.looks.written().iter() {
                session.column_to_change(domain, property).map_err(raised)?;
            }
        }
        Ok(session)
    }

    /// The session, after it has followed what changed: columns stay where they are until rows, laws or observers change again.
    fn settled(&self, py: Python<'_>) -> PyResult<MutexGuard<'_, Session>> {
        let mut session = self.session_to_follow("a look at a column")?;
        self.check(py)?;
        if !session.is_settled() {
            self.call(py, &mut session, Session::refresh)?;
        }
        Ok(session)
    }

    /// Runs a call that may evaluate laws. Other threads of Python run meanwhile, among them those of the engine, for laws of Python.
    #[inline]
    fn call<T: Send>(
        &self,
        py: Python<'_>,
        session: &mut Session,
        call: impl FnOnce(&mut Session) -> Result<T, Trouble> + Send,
    ) -> PyResult<T> {
        self.check(py)?;
        let done = py.detach(|| call(session));
        if !self.callbacks.is_empty()
            && let Some(error) = self.laws.take()
        {
            session.begin_anew();
            return Err(error);
        }
        done.map_err(raised)
    }

    /// What the engine has to say.
    fn words(&self, py: Python<'_>, what: &str, words: Words) -> PyResult<String> {
        let mut session = self.session_to_follow(what)?;
        self.call(py, &mut session, |session| session.words(words))
    }

    /// The array that is lent as this column.
    fn lender(&self, domain: &str, property: &str) -> Option<&Lender> {
        self.lenders.iter().find(|lender| lender.domain == domain && lender.property == bare(property))
    }

    fn view<'py>(
        this: &Bound<'py, Self>,
        (domain, property): (&str, &str),
        writeable: bool,
    ) -> PyResult<Bound<'py, PyAny>> {
        let py = this.py();
        let mut session = this.get().settled(py)?;
        if session.moving_origin() == Some(bare(property)) {
            return Err(fault(format!(
                "{domain}.{property} is measured from an origin that moves with it, which is not seen in place: take \
                 engine.get(\"{domain}\", \"{property}\"), and change it by engine[\"{domain}\", \"{property}\"] = .."
            )));
        }
        let view =
            if writeable { session.column_to_change(domain, property) } else { session.column(domain, property) };
        let view = view.map_err(raised)?;
        if let Some(lender) = this.get().lender(domain, property) {
            return Ok(lender.array(py).clone().into_any());
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

    fn look(&self, py: Python<'_>, domain: &str, property: &str) -> PyResult<View> {
        self.session(py)?.column(domain, bare(property)).map_err(raised)
    }
}

#[pymethods]
impl Engine {
    /// The engine that was put together.
    #[new]
    fn made(py: Python<'_>, assembly: &crate::assembly::Assembly) -> PyResult<Self> {
        assembly.build(py)
    }

    /// Takes `count` steps of `step` s.
    #[pyo3(signature = (count, step, /))]
    fn step(&self, py: Python<'_>, count: u64, step: f64) -> PyResult<()> {
        let session = &mut *self.session_to_step()?;
        self.pace.steps(py, count, |_, count| self.call(py, session, |session| session.step(count, step)))
    }

    /// Goes on by `frame` s: by as many steps of the set length as fit, the rest is carried to the next frame; without a set
    /// step by one step.
    #[pyo3(signature = (frame, /))]
    fn advance(&self, py: Python<'_>, frame: f64) -> PyResult<()> {
        let session = &mut *self.session_to_step()?;
        self.pace.frame(py, frame, |frame| self.call(py, session, |session| session.advance(frame)))
    }

    /// The time, in s.
    #[getter]
    fn time(&self) -> PyResult<f64> {
        Ok(self.entered()?.time())
    }

    /// Steps taken.
    #[getter]
    fn steps(&self) -> PyResult<u64> {
        Ok(self.entered()?.steps())
    }

    /// "f32" or "f64".
    #[getter]
    fn precision(&self) -> PyResult<&'static str> {
        Ok(self.entered()?.precision().name())
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
    fn shape(&self, py: Python<'_>, domain: &str, property: &str) -> PyResult<(usize, usize)> {
        self.look(py, domain, property).map(|view| (view.rows, view.width))
    }

    /// The type of the numbers of a column: "f32", "f64", or "u32" for a link.
    fn kind(&self, py: Python<'_>, domain: &str, property: &str) -> PyResult<&'static str> {
        self.look(py, domain, property).map(|view| view.numbers.name())
    }

    /// Copies all numbers of a column into an array of that many, row after row.
    fn copy_to(&self, py: Python<'_>, domain: &str, property: &str, array: &Bound<'_, PyUntypedArray>) -> PyResult<()> {
        let session = self.session(py)?;
        let what = format!("{domain}.{property}");
        let get = |numbers: NumbersMut<'_>| session.get(domain, property, numbers).map_err(raised);
        if let Ok(array) = array.cast::<PyArrayDyn<f64>>() {
            return arrays::fill(&what, array, |numbers| get(NumbersMut::F64(numbers)));
        }
        if let Ok(array) = array.cast::<PyArrayDyn<f32>>() {
            return arrays::fill(&what, array, |numbers| get(NumbersMut::F32(numbers)));
        }
        match array.cast::<PyArrayDyn<u32>>() {
            Ok(array) => arrays::fill(&what, array, |numbers| get(NumbersMut::Rows(numbers))),
            Err(_) => Err(fault(format!("{what}: ask for float64, float32, or uint32 for a link"))),
        }
    }

    /// Changes all numbers of a column.
    fn copy_from(
        &self,
        py: Python<'_>,
        domain: &str,
        property: &str,
        array: &Bound<'_, PyUntypedArray>,
    ) -> PyResult<()> {
        let mut session = self.session(py)?;
        let given = Given::new(&format!("{domain}.{property}"), array)?;
        session.set(domain, property, given.numbers()?).map_err(raised)
    }

    /// Adds rows behind the last: an array for each property.
    fn append(&self, py: Python<'_>, domain: &str, rows: usize, columns: &Bound<'_, PyDict>) -> PyResult<()> {
        let mut named: Vec<(String, Given<'_>)> = Vec::new();
        for (name, array) in columns {
            let name: String = name.extract()?;
            let given = Given::new(&format!("{domain}.{name}"), array.cast::<PyUntypedArray>()?)?;
            named.push((name, given));
        }
        let columns = named.iter().map(|(name, given)| Ok((name.as_str(), given.numbers()?)));
        let columns: Vec<(&str, Numbers<'_>)> = columns.collect::<PyResult<_>>()?;
        self.session_to_move(py, "adding rows")?.add_rows(domain, rows, &columns).map_err(raised)
    }

    /// Removes rows, and with them rows that link to them; later rows move up.
    fn remove_rows(&self, py: Python<'_>, domain: &str, rows: Vec<u32>) -> PyResult<()> {
        self.session_to_move(py, "removing rows")?.remove_rows(domain, &rows).map_err(raised)
    }

    /// Switches a law on or off, by its label, or else its name.
    #[pyo3(signature = (law, on = true))]
    fn enable(&self, py: Python<'_>, law: &str, on: bool) -> PyResult<()> {
        self.session_to_move(py, "switching a law")?.enable(law, on).map_err(raised)
    }

    /// Looks at a property that laws compute, from now on.
    fn observe(&self, py: Python<'_>, domain: &str, property: &str) -> PyResult<()> {
        let mut session = self.session_to_move(py, "observing one more column")?;
        self.call(py, &mut session, |session| session.observe(domain, property))
    }

    /// Which laws run, which do not, and why; what nobody uses.
    fn report(&self, py: Python<'_>) -> PyResult<String> {
        self.words(py, "a report", Words::Report)
    }

    /// The order of the laws, merged passes, and what moves where.
    fn explain(&self, py: Python<'_>) -> PyResult<String> {
        self.words(py, "an explanation", Words::Explain)
    }

    /// The graph of the laws in the language of Graphviz.
    fn dot(&self, py: Python<'_>) -> PyResult<String> {
        self.words(py, "a graph", Words::Dot)
    }

    /// The complete state, as text.
    fn checkpoint(&self, py: Python<'_>) -> PyResult<String> {
        let mut session = self.entered()?;
        self.call(py, &mut session, |session| session.words(Words::Checkpoint))
    }

    /// Goes on from a checkpoint of an engine that was put together alike.
    fn restore(&self, py: Python<'_>, checkpoint: &str) -> PyResult<()> {
        let mut session = self.session_to_move(py, "going back to a checkpoint")?;
        self.call(py, &mut session, |session| session.restore(checkpoint))
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.lenders.iter().try_for_each(|lender| lender.traverse(&visit))?;
        self.callbacks.iter().try_for_each(|callback| callback.traverse(&visit))
    }

    fn __clear__(&self) {
        self.callbacks.iter().for_each(|callback| callback.clear());
    }
}
