//! Engines: steps, columns in place and copied, rows, words.
//!
//! In: handles, names, arrays. Out: status codes, numbers, pointers to columns. Never: an array that is copied where its length is
//! not that of the column.

use super::arguments::{argument, array, numbers, place, room, text};
use super::columns::{ColumnView, Type, VESPER_READ, VESPER_WRITE, Values};
use super::declare::{constants, functions, records};
use super::failure::{Failure, Status, guarded, in_c, told};
use super::handles::ENGINES;
use crate::session::{Session, Trouble, Words};
use core::ffi::{c_char, c_void};
use core::ptr;
use std::ffi::CString;

records! {
    /// The structures of engines.
    ENGINE_RECORDS;

    /// The handle of an engine.
    struct EngineId = vesper_engine {
        /// Not to be looked at; 0 for none.
        id: u64,
    }
}

constants! {
    /// What an engine can say.
    TEXTS: u32;
    /// Which laws run, which do not, and why.
    VESPER_REPORT = 0;
    /// The order of the laws.
    VESPER_EXPLAIN = 1;
    /// The graph for Graphviz.
    VESPER_DOT = 2;
    /// The whole state.
    VESPER_CHECKPOINT = 3;
}

/// An engine, and the text that it said last.
#[derive(Debug)]
pub(super) struct Held {
    session: Session,
    text: CString,
}

impl Held {
    pub(super) fn new(session: Session) -> Self {
        Held { session, text: CString::default() }
    }
}

/// A call on an engine.
#[inline]
fn on(engine: EngineId, call: impl FnOnce(&mut Session) -> Result<(), Failure>) -> Status {
    told(ENGINES.with(engine.id, |held| call(&mut held.session)))
}

functions! {
    /// The functions of engines.
    ENGINE_FUNCTIONS;

    /// Takes steps.
    fn vesper_engine_step(engine: EngineId, count: u64, step: f64) -> Status {
        on(engine, |session| Ok(session.step(count, step)?))
    }

    /// Goes on by a frame.
    fn vesper_engine_advance(engine: EngineId, frame: f64) -> Status {
        on(engine, |session| Ok(session.advance(frame)?))
    }

    /// The time, in s, and the steps taken.
    fn vesper_engine_time(engine: EngineId, time: *mut f64, steps: *mut u64) -> Status {
        // SAFETY: as the header says.
        let time = (!time.is_null()).then(|| unsafe { place(time, 0.0, "the place for the time") });
        // SAFETY: as the header says.
        let steps = (!steps.is_null()).then(|| unsafe { place(steps, 0, "the place for the steps") });
        on(engine, |session| {
            let (time, steps) = (time.transpose()?, steps.transpose()?);
            time.into_iter().for_each(|time| *time = session.time());
            steps.into_iter().for_each(|steps| *steps = session.steps());
            Ok(())
        })
    }

    /// Where a column is.
    fn vesper_engine_column(
        engine: EngineId,
        domain: *const c_char,
        property: *const c_char,
        access: u32,
        column: *mut ColumnView,
    ) -> Status {
        // SAFETY: as the header says.
        let column = unsafe { place(column, ColumnView::EMPTY, "the place for the column") };
        on(engine, |session| {
            let column = column?;
            // SAFETY: as the header says.
            let (domain, property) = unsafe { (text(domain, "the domain")?, text(property, "the property")?) };
            // What changed since the last step may move columns: before, not after, somebody knows where they are.
            session.refresh()?;
            *column = match access {
                VESPER_READ => session.column(domain, property)?,
                VESPER_WRITE => session.column_to_change(domain, property)?,
                other => argument(format!("the access is {other}: give VESPER_READ or VESPER_WRITE"))?,
            }
            .into();
            Ok(())
        })
    }

    /// Copies the numbers of a column.
    fn vesper_engine_get(
        engine: EngineId,
        domain: *const c_char,
        property: *const c_char,
        type_: Type,
        values: *mut c_void,
        count: usize,
    ) -> Status {
        on(engine, |session| {
            // SAFETY: as the header says.
            let (domain, property, values) = unsafe {
                let property = text(property, "the property")?;
                (text(domain, "the domain")?, property, room(type_, values, count, property)?)
            };
            Ok(session.get(domain, property, values)?)
        })
    }

    /// Changes the numbers of a column.
    fn vesper_engine_set(
        engine: EngineId,
        domain: *const c_char,
        property: *const c_char,
        type_: Type,
        values: *const c_void,
        count: usize,
    ) -> Status {
        on(engine, |session| {
            // SAFETY: as the header says.
            let (domain, property, values) = unsafe {
                let property = text(property, "the property")?;
                (text(domain, "the domain")?, property, numbers(type_, values, count, property)?)
            };
            Ok(session.set(domain, property, values)?)
        })
    }

    /// Adds rows.
    fn vesper_engine_add_rows(
        engine: EngineId,
        domain: *const c_char,
        rows: usize,
        columns: *const Values,
        count: usize,
    ) -> Status {
        on(engine, |session| {
            // SAFETY: as the header says.
            unsafe {
                let domain = text(domain, "the domain")?;
                let columns = array::<Values>(columns.cast(), count, "the columns")?.iter().map(|column| {
                    let name = text(column.property, "the property of a column")?;
                    Ok::<_, Failure>((name, numbers(column.type_, column.numbers, column.count, name)?))
                });
                let columns = columns.collect::<Result<Vec<_>, _>>()?;
                Ok(session.add_rows(domain, rows, &columns)?)
            }
        })
    }

    /// Removes rows.
    fn vesper_engine_remove_rows(engine: EngineId, domain: *const c_char, rows: *const u32, count: usize) -> Status {
        on(engine, |session| {
            // SAFETY: as the header says.
            let domain = unsafe { text(domain, "the domain")? };
            let there = session.rows(domain)?;
            if count > there {
                let text = format!("{count} rows of {domain} cannot be removed: there are {there}");
                return Err(Trouble::Fault(text).into());
            }
            // SAFETY: as the header says.
            let rows = unsafe { array::<u32>(rows.cast(), count, "the rows")? };
            Ok(session.remove_rows(domain, rows)?)
        })
    }

    /// Switches a law on or off.
    fn vesper_engine_enable(engine: EngineId, law: *const c_char, enabled: i32) -> Status {
        // SAFETY: as the header says.
        on(engine, |session| Ok(session.enable(unsafe { text(law, "the law")? }, enabled != 0)?))
    }

    /// Looks at one more property.
    fn vesper_engine_observe(engine: EngineId, domain: *const c_char, property: *const c_char) -> Status {
        on(engine, |session| {
            // SAFETY: as the header says.
            let (domain, property) = unsafe { (text(domain, "the domain")?, text(property, "the property")?) };
            Ok(session.observe(domain, property)?)
        })
    }

    /// What the engine has to say.
    fn vesper_engine_text(engine: EngineId, which: u32, text_: *mut *const c_char) -> Status {
        // SAFETY: as the header says.
        let said = unsafe { place(text_, ptr::null(), "the place for the text") };
        told(ENGINES.with(engine.id, |held| {
            let said = said?;
            let words = match which {
                VESPER_REPORT => Words::Report,
                VESPER_EXPLAIN => Words::Explain,
                VESPER_DOT => Words::Dot,
                VESPER_CHECKPOINT => Words::Checkpoint,
                other => argument(format!("text {other} is none: give one of VESPER_REPORT to VESPER_CHECKPOINT"))?,
            };
            held.text = in_c(&held.session.words(words)?);
            *said = held.text.as_ptr();
            Ok(())
        }))
    }

    /// Goes on from a checkpoint.
    fn vesper_engine_restore(engine: EngineId, checkpoint: *const c_char) -> Status {
        // SAFETY: as the header says.
        on(engine, |session| Ok(session.restore(unsafe { text(checkpoint, "the checkpoint")? })?))
    }

    /// Lets the next thread that calls have the engine.
    fn vesper_engine_let_go(engine: EngineId) -> Status {
        told(ENGINES.let_go(engine.id))
    }

    /// Frees an engine.
    fn vesper_engine_free(engine: EngineId) -> Status {
        guarded(|| ENGINES.remove(engine.id).map(drop))
    }
}
