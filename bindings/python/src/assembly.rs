//! An engine that is being put together.
//!
//! In: domains, arrays, laws by name, functions as laws, settings, scenes. Out: an engine. Never: a half-built one: what is
//! wrong with a call is an exception at once.

use crate::arrays::{self, Given};
use crate::callback::{Callback, Raised};
use crate::engine::Engine;
use crate::failure::{fault, raised};
use crate::lender::Lender;
use numpy::PyUntypedArray;
use pyo3::prelude::*;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};
use vesper::prelude::DynLaw;
use vesper::registry::Options;
use vesper_c::session::{Assembly as Parts, NumberType};

/// What was given so far.
struct Draft {
    parts: Parts,
    lenders: Vec<Lender>,
    callbacks: Vec<Arc<Callback>>,
    /// Where all of them put their exceptions.
    raised: Arc<Raised>,
}

/// An engine that is being put together.
#[pyclass(frozen, module = "vesper._vesper")]
pub(crate) struct Assembly {
    draft: Mutex<Option<Draft>>,
    precision: NumberType,
}

impl Assembly {
    fn draft(&self) -> PyResult<MutexGuard<'_, Option<Draft>>> {
        match self.draft.try_lock() {
            Ok(draft) if draft.is_some() => Ok(draft),
            Ok(_) => Err(fault("the engine is built already: begin another one")),
            Err(TryLockError::WouldBlock) => Err(fault("another thread puts the engine together")),
            Err(TryLockError::Poisoned(_)) => Err(fault("a mistake inside the library: begin another engine")),
        }
    }

    fn with<T>(&self, then: impl FnOnce(&mut Draft) -> PyResult<T>) -> PyResult<T> {
        self.draft()?.as_mut().map_or_else(|| Err(fault("the engine is built already")), then)
    }

    /// The engine.
    pub(crate) fn build(&self, py: Python<'_>) -> PyResult<Engine> {
        let Some(Draft { parts, lenders, callbacks, raised: laws }) = self.draft()?.take() else {
            return Err(fault("the engine is built already"));
        };
        lenders.iter().try_for_each(|lender| lender.check(py))?;
        // Memory that was lent outlives what uses it: the session goes first where this fails. Laws may be run, by other threads.
        let session = py.detach(|| parts.build());
        if let Some(error) = laws.take() {
            return Err(error);
        }
        let mut session = session.map_err(raised)?;
        if !callbacks.is_empty() {
            session.trace_blow_ups(true);
        }
        Ok(Engine::new(py, session, lenders, callbacks, laws))
    }
}

/// A property's name without the unit that may stand behind it.
pub(crate) fn bare(property: &str) -> &str {
    property.split('[').next().unwrap_or_default().trim()
}

/// A name, and how many numbers a row has where nobody knows.
type Sized = (String, usize);

#[pymethods]
impl Assembly {
    #[new]
    fn new(precision: &str) -> PyResult<Self> {
        let precision = match precision {
            "f32" | "float32" => NumberType::F32,
            "f64" | "float64" => NumberType::F64,
            other => return Err(fault(format!("no precision is named `{other}`: take \"f32\" or \"f64\""))),
        };
        let parts = Parts::new(precision).map_err(raised)?;
        let draft = Draft { parts, lenders: Vec::new(), callbacks: Vec::new(), raised: Arc::default() };
        Ok(Assembly { draft: Mutex::new(Some(draft)), precision })
    }

    fn domain(&self, name: &str, rows: usize) -> PyResult<()> {
        self.with(|draft| draft.parts.domain(name, rows).map_err(raised))
    }

    /// Numbers in a value of a property; 0 where nobody knows the name.
    fn width(&self, property: &str) -> PyResult<usize> {
        let unknown = 4;
        self.with(|draft| {
            let info = draft.parts.property(property, unknown).map_err(raised)?;
            let again = draft.parts.property(property, 1).map_err(raised)?;
            Ok(if info.kind == again.kind { info.kind.width() } else { 0 })
        })
    }

    fn column(&self, domain: &str, property: &str, array: &Bound<'_, PyUntypedArray>) -> PyResult<()> {
        let given = Given::new(&format!("{domain}.{property}"), array)?;
        self.with(|draft| draft.parts.column(domain, property, given.numbers()?).map_err(raised))
    }

    fn lend(&self, domain: &str, property: &str, array: &Bound<'_, PyUntypedArray>) -> PyResult<()> {
        let memory = arrays::memory(&format!("{domain}.{property}"), self.precision, array)?;
        self.with(|draft| {
            let lender = Lender::new(domain, bare(property).to_owned(), array)?;
            // SAFETY: the array is kept with the assembly, and then with the engine, so that its numbers stay; Python's lock, or
            // the care of whoever releases it, keeps others from writing them meanwhile, as for all arrays of numpy.
            unsafe { draft.parts.lend(domain, property, memory) }.map_err(raised)?;
            draft.lenders.push(lender);
            Ok(())
        })
    }

    fn link(&self, domain: &str, property: &str, target: &str, rows: Vec<u32>) -> PyResult<()> {
        self.with(|draft| draft.parts.link(domain, property, target, &rows).map_err(raised))
    }

    /// A folder with modules of laws; it comes before laws that need it.
    fn laws_from(&self, folder: PathBuf) -> PyResult<()> {
        self.with(|draft| draft.parts.laws_from(&folder).map_err(raised))
    }

    #[pyo3(signature = (name, text = ""))]
    fn law(&self, name: &str, text: &str) -> PyResult<()> {
        self.with(|draft| draft.parts.law(name, text).map_err(raised))
    }

    fn settings(&self, text: &str) -> PyResult<()> {
        self.with(|draft| draft.parts.settings(text).map_err(raised))
    }

    fn scene(&self, text: &str, folder: PathBuf) -> PyResult<()> {
        self.with(|draft| draft.parts.scene(text, &folder).map_err(raised))
    }

    /// A function as a law. `inputs`: a name, a width for what nobody knows, and whether it is a constant; `outputs`: "adds",
    /// "sets", "rates" or "amends", a name, a width.
    #[pyo3(signature = (name, function, inputs, outputs, domain = None, label = None, every = 1))]
    #[allow(clippy::too_many_arguments, reason = "the package gives them")]
    fn made_law(
        &self,
        name: &str,
        function: Py<PyAny>,
        inputs: Vec<(String, usize, bool)>,
        outputs: Vec<(String, String, usize)>,
        domain: Option<String>,
        label: Option<String>,
        every: u32,
    ) -> PyResult<()> {
        self.with(|draft| {
            let property = |(name, width): Sized| draft.parts.property(&name, width).map_err(raised);
            let (mut law, mut given, mut widths) = (DynLaw::new(name), Vec::new(), Vec::new());
            for (name, width, constant) in inputs {
                let info = property((name, width))?;
                given.push((info.kind.width(), constant));
                law = if constant { law.scene(info) } else { law.reads(info) };
            }
            for (mode, name, width) in outputs {
                let info = property((name, width))?;
                widths.push(info.kind.width());
                law = match mode.as_str() {
                    "adds" => law.adds(info),
                    "sets" => law.sets(info),
                    "rates" => law.rates(info),
                    "amends" => law.amends(info),
                    other => return Err(fault(format!("a law does not {other}: it adds, sets, rates or amends"))),
                };
            }
            let callback = Arc::new(Callback::new(function, given, widths, draft.raised.clone()));
            draft.callbacks.push(callback.clone());
            let law = law.whole(move |given, results| callback.call(given, results));
            draft.parts.made_law(law, Options { domain, label, every, required: true, ..Options::default() });
            Ok(())
        })
    }
}
