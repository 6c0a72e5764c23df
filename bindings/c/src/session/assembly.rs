//! The two precisions behind one type: an engine that is being put together, and one that runs.

use super::draft::{Draft, in_precision};
use super::run::{Run, Words};
use super::{Memory, NumberType, Numbers, NumbersMut, Trouble, View};
use std::path::Path;
use vesper::prelude::{DynLaw, PropertyInfo};
use vesper::registry::Options;

/// Does the same in either precision.
macro_rules! either {
    ($of:expr, $each:ident => $done:expr) => {
        match $of {
            Self::F32($each) => $done,
            Self::F64($each) => $done,
        }
    };
}

/// An engine that is being put together by names, in f32 or f64.
///
/// What is wrong with a call is told at once, and again, with all others, when the engine is built.
#[derive(Debug)]
pub struct Assembly(Either);

#[derive(Debug)]
enum Either {
    F32(Draft<f32>),
    F64(Draft<f64>),
}

impl Either {
    fn noted(
        &mut self,
        single: impl FnOnce(&mut Draft<f32>) -> Result<(), Trouble>,
        double: impl FnOnce(&mut Draft<f64>) -> Result<(), Trouble>,
    ) -> Result<(), Trouble> {
        match self {
            Either::F32(draft) => draft.noted(single),
            Either::F64(draft) => draft.noted(double),
        }
    }
}

/// A call on the draft, in either precision.
macro_rules! noted {
    ($of:expr, $draft:ident => $done:expr) => {
        $of.0.noted(|$draft| $done, |$draft| $done)
    };
}

impl Assembly {
    /// Begins an engine that computes with numbers of this type.
    ///
    /// # Errors
    /// They are rows.
    pub fn new(precision: NumberType) -> Result<Self, Trouble> {
        match precision {
            NumberType::F32 => Ok(Assembly(Either::F32(Draft::new()))),
            NumberType::F64 => Ok(Assembly(Either::F64(Draft::new()))),
            NumberType::Rows => {
                Err(Trouble::Argument("an engine computes in f32 or f64, and not with rows".to_owned()))
            }
        }
    }

    /// A domain of this name with so many rows. "scene", of one row, is there: it holds the constants.
    ///
    /// # Errors
    /// There is one already, or too many rows.
    pub fn domain(&mut self, name: &str, rows: usize) -> Result<(), Trouble> {
        noted!(self, draft => draft.domain(name, rows))
    }

    /// A column, copied: the numbers of the first row, then those of the second. `property` may have a unit behind it,
    /// `velocity [km/s]`; a name that no law knows is a property of its own, as wide as its rows.
    ///
    /// # Errors
    /// The domain is not there, or the numbers do not fit it or the property.
    pub fn column(&mut self, domain: &str, property: &str, numbers: Numbers<'_>) -> Result<(), Trouble> {
        noted!(self, draft => draft.column(domain, property, numbers))
    }

    /// A column in memory of the client, used in place.
    ///
    /// # Errors
    /// As [`Assembly::column`]; it is of the other precision, in another unit, at an odd address, or lent already.
    ///
    /// # Safety
    /// All numbers of the memory are there, and stay there until assembly and session are gone; nobody touches them while
    /// the session is called, and nobody else writes them meanwhile.
    pub unsafe fn lend(&mut self, domain: &str, property: &str, memory: Memory) -> Result<(), Trouble> {
        let what = format!("{domain}.{property}");
        self.0.noted(
            // SAFETY: promised by the caller.
            |draft| unsafe { draft.lend(domain, property, in_precision(memory, &what)?) },
            // SAFETY: promised by the caller.
            |draft| unsafe { draft.lend(domain, property, in_precision(memory, &what)?) },
        )
    }

    /// A link: for every row, rows of the domain `target`.
    ///
    /// # Errors
    /// As [`Assembly::column`].
    pub fn link(&mut self, domain: &str, property: &str, target: &str, rows: &[u32]) -> Result<(), Trouble> {
        noted!(self, draft => draft.link(domain, property, target, rows))
    }

    /// A folder in which modules of laws are looked for, before those of `VESPER_LAW_PATH`; it comes before laws that need it. Code of a
    /// module runs in this process: whoever put it there is trusted.
    ///
    /// # Errors
    /// There is no such folder.
    pub fn laws_from(&mut self, folder: &Path) -> Result<(), Trouble> {
        noted!(self, draft => draft.laws_from(folder))
    }

    /// A stock law by its name, or one of a module, with what stands behind it in a scene, `softening = 1e3, domain = 'stars'`. Domains come first.
    ///
    /// # Errors
    /// No law has this name, or no parameter has one of these.
    pub fn law(&mut self, name: &str, text: &str) -> Result<(), Trouble> {
        noted!(self, draft => draft.law(name, text))
    }

    /// A law of the client, made at run time. What is wrong with it is told when the engine is built.
    pub fn made_law(&mut self, law: DynLaw, options: Options) {
        match &mut self.0 {
            Either::F32(draft) => draft.made_law(law, options),
            Either::F64(draft) => draft.made_law(law, options),
        }
    }

    /// What is meant by a name with a unit behind it or without, for a law of the client: a property that laws know, one that a
    /// column was given of, or a new one of so many numbers.
    ///
    /// # Errors
    /// No property is this wide; the unit is none.
    pub fn property(&self, text: &str, width: usize) -> Result<PropertyInfo, Trouble> {
        match &self.0 {
            Either::F32(draft) => draft.property(text, width),
            Either::F64(draft) => draft.property(text, width),
        }
    }

    /// What section `[engine]` of a scene says: `integrator = 'leapfrog', step = 1e-3, observe = ['bodies.force']`.
    ///
    /// # Errors
    /// A word or a value is none of those of `[engine]`.
    pub fn settings(&mut self, text: &str) -> Result<(), Trouble> {
        noted!(self, draft => draft.settings(text))
    }

    /// A whole scene; files that it names lie in `folder`.
    ///
    /// # Errors
    /// All that is wrong with it, each with its place and a caret.
    pub fn scene(&mut self, text: &str, folder: &Path) -> Result<(), Trouble> {
        noted!(self, draft => draft.scene(text, folder))
    }

    /// Keeps a fault that somebody else found, for [`Assembly::build`] to tell.
    pub fn note(&mut self, trouble: &Trouble) {
        let refused = || Err::<(), Trouble>(trouble.clone());
        _ = self.0.noted(|_| refused(), |_| refused());
    }

    /// Checks everything and makes the engine.
    ///
    /// # Errors
    /// Everything that was refused before; if that is nothing, all that does not fit together, and laws that sleep by a slip of
    /// the pen.
    pub fn build(self) -> Result<Session, Trouble> {
        match self.0 {
            Either::F32(draft) => draft.build().map(Session::F32),
            Either::F64(draft) => draft.build().map(Session::F64),
        }
    }
}

/// An engine that runs, in f32 or f64.
#[derive(Debug)]
#[non_exhaustive]
pub enum Session {
    /// In f32.
    F32(Run<f32>),
    /// In f64.
    F64(Run<f64>),
}

impl Session {
    /// The type of its numbers.
    pub const fn precision(&self) -> NumberType {
        match self {
            Session::F32(_) => NumberType::F32,
            Session::F64(_) => NumberType::F64,
        }
    }

    /// Takes `count` steps of `step` s.
    ///
    /// # Errors
    /// The step is no time, what changed does not fit, or numbers became infinite or NaN.
    #[inline]
    pub fn step(&mut self, count: u64, step: f64) -> Result<(), Trouble> {
        either!(self, run => run.step(count, step))
    }

    /// Goes on by a frame of `frame` s, in fixed steps where a step is set; what is left of a step is carried on.
    ///
    /// # Errors
    /// As [`Session::step`].
    #[inline]
    pub fn advance(&mut self, frame: f64) -> Result<(), Trouble> {
        either!(self, run => run.advance(frame))
    }

    /// Follows what changed, so that columns stay where they are until rows, laws or observers change again.
    ///
    /// # Errors
    /// What changed does not fit.
    pub fn refresh(&mut self) -> Result<(), Trouble> {
        either!(self, run => run.refresh())
    }

    /// Lets the integrator begin anew with the next step, as after a change of the state: what it remembers of a call that broke may
    /// be of no use, a step of no length that it tried last.
    pub fn begin_anew(&mut self) {
        either!(self, run => run.begin_anew());
    }

    /// Whether columns are where the next step finds them: [`Session::refresh`] says when they move, a law that failed moves them, too.
    pub fn is_settled(&self) -> bool {
        either!(self, run => run.is_settled())
    }

    /// How many rows a domain has.
    ///
    /// # Errors
    /// There is no such domain.
    pub fn rows(&self, domain: &str) -> Result<usize, Trouble> {
        either!(self, run => run.rows(domain))
    }

    /// Traces numbers that become none to their step and law, and leaves the state as it was before that step. Costs a copy of
    /// the state per call.
    pub fn trace_blow_ups(&mut self, on: bool) {
        either!(self, run => run.trace_blow_ups(on))
    }

    /// The time, in s.
    pub fn time(&self) -> f64 {
        either!(self, run => run.time())
    }

    /// Steps taken.
    pub fn steps(&self) -> u64 {
        either!(self, run => run.steps())
    }

    /// The step that [`Session::advance`] divides a frame into, in s; none where each frame is one step, as with integrators that choose
    /// their own.
    pub fn fixed_step(&self) -> Option<f64> {
        either!(self, run => run.fixed_step())
    }

    /// The property whose columns are measured from an origin that moves with them: what [`Session::get`] and [`Session::set`] put
    /// right, and whoever looks at a column in place does not see.
    pub fn moving_origin(&self) -> Option<&'static str> {
        either!(self, run => run.settings.moving)
    }

    /// Where a column's numbers are, to look at; good until the next call that is not a look.
    ///
    /// # Errors
    /// There is no such domain or property, or nobody observes it.
    pub fn column(&self, domain: &str, property: &str) -> Result<View, Trouble> {
        either!(self, run => run.column(domain, property))
    }

    /// The same, to change before the next call: laws and integrator follow.
    ///
    /// # Errors
    /// As [`Session::column`]; it is a link.
    pub fn column_to_change(&mut self, domain: &str, property: &str) -> Result<View, Trouble> {
        either!(self, run => run.column_to_change(domain, property))
    }

    /// Copies all numbers of a column, row after row, from where coordinates begin, in its own unit or in the one behind its name.
    ///
    /// # Errors
    /// As [`Session::column`]; there is room for another number of them, or of another type, or some of it is the column's own.
    pub fn get(&self, domain: &str, property: &str, numbers: NumbersMut<'_>) -> Result<(), Trouble> {
        either!(self, run => run.get(domain, property, numbers))
    }

    /// Changes all numbers of a column; nothing is changed where one does not fit.
    ///
    /// # Errors
    /// As [`Session::get`]; a number is infinite or NaN. Numbers that are the column itself are looked at, and stay.
    pub fn set(&mut self, domain: &str, property: &str, numbers: Numbers<'_>) -> Result<(), Trouble> {
        either!(self, run => run.set(domain, property, numbers))
    }

    /// Adds so many rows to a domain: every column that has a value for all rows needs values for the new ones.
    ///
    /// # Errors
    /// Something is missing or does not fit, or a column is lent; nothing is changed then.
    pub fn add_rows(&mut self, domain: &str, rows: usize, columns: &[(&str, Numbers<'_>)]) -> Result<(), Trouble> {
        either!(self, run => run.add_rows(domain, rows, columns))
    }

    /// Removes rows, and rows that link to them; later rows move up.
    ///
    /// # Errors
    /// A row does not exist, or a column is lent; nothing is changed then.
    pub fn remove_rows(&mut self, domain: &str, rows: &[u32]) -> Result<(), Trouble> {
        either!(self, run => run.remove_rows(domain, rows))
    }

    /// Switches a law on or off, by its label, or else its name.
    ///
    /// # Errors
    /// No law is called so.
    pub fn enable(&mut self, law: &str, enabled: bool) -> Result<(), Trouble> {
        either!(self, run => run.enable(law, enabled))
    }

    /// Looks at a property that a law computes, from now on.
    ///
    /// # Errors
    /// No law computes it.
    pub fn observe(&mut self, domain: &str, property: &str) -> Result<(), Trouble> {
        either!(self, run => run.observe(domain, property))
    }

    /// What the engine has to say.
    ///
    /// # Errors
    /// What changed does not fit, or the state is not there to be saved.
    pub fn words(&mut self, words: Words) -> Result<String, Trouble> {
        either!(self, run => run.words(words))
    }

    /// Goes on from what [`Words::Checkpoint`] said.
    ///
    /// # Errors
    /// It is no checkpoint, or of another engine; nothing is changed then.
    pub fn restore(&mut self, checkpoint: &str) -> Result<(), Trouble> {
        either!(self, run => run.restore(checkpoint))
    }
}
