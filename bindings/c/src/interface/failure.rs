//! Status codes, and the words behind the last one.
//!
//! In: what a call came to. Out: its code; the text of a failure, kept for its thread until the next one. Never: a panic that
//! goes on into C.

use super::declare::constants;
use crate::session::{Trouble, panicked};
use core::ffi::c_char;
use std::any::Any;
use std::cell::RefCell;
use std::ffi::CString;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What a call came to: `vesper_status`.
pub type Status = i32;

constants! {
    /// The status codes.
    STATUSES: Status;
    /// Done.
    VESPER_OK = 0;
    /// An argument makes no sense by itself.
    VESPER_ERROR_ARGUMENT = 1;
    /// The handle is null, was freed, or never was one.
    VESPER_ERROR_HANDLE = 2;
    /// Another thread has the handle, or a call on it is under way.
    VESPER_ERROR_THREAD = 3;
    /// What was described or asked for does not fit.
    VESPER_ERROR_FAULT = 4;
    /// A step could not be taken, or its numbers are none.
    VESPER_ERROR_RUN = 5;
    /// A mistake inside the library.
    VESPER_ERROR_PANIC = 6;
    /// No more handles.
    VESPER_ERROR_LIMIT = 7;
}

/// Why a call failed.
#[derive(Debug)]
pub(super) struct Failure {
    pub(super) status: Status,
    pub(super) text: String,
}

impl Failure {
    pub(super) fn new(status: Status, text: impl Into<String>) -> Self {
        Failure { status, text: text.into() }
    }

    /// A panic, in the words of whoever panicked.
    #[cold]
    pub(super) fn panic(payload: &(dyn Any + Send)) -> Self {
        Failure::new(VESPER_ERROR_PANIC, panicked(payload))
    }
}

impl From<Trouble> for Failure {
    #[cold]
    fn from(trouble: Trouble) -> Self {
        let status = match trouble {
            Trouble::Argument(_) => VESPER_ERROR_ARGUMENT,
            Trouble::Fault(_) => VESPER_ERROR_FAULT,
            Trouble::Run(_) => VESPER_ERROR_RUN,
        };
        Failure::new(status, trouble.text())
    }
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::new(CString::default());
}

/// Text as C has it; a NUL in it becomes a blank.
pub(super) fn in_c(text: &str) -> CString {
    CString::new(text.replace('\0', " ")).unwrap_or_default()
}

/// Keeps the text of a failure for this thread.
#[cold]
fn keep(failure: &Failure) -> Status {
    // A thread that ends keeps no words.
    _ = LAST.try_with(|last| *last.borrow_mut() = in_c(&failure.text));
    failure.status
}

/// The text of this thread's last failure.
pub(super) fn last_text() -> *const c_char {
    LAST.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// The code of a call that cannot panic, or has caught what did.
#[inline]
pub(super) fn told(done: Result<(), Failure>) -> Status {
    match done {
        Ok(()) => VESPER_OK,
        Err(failure) => keep(&failure),
    }
}

/// Runs a call, and tells what came of it.
#[inline]
pub(super) fn guarded(call: impl FnOnce() -> Result<(), Failure>) -> Status {
    told(caught(call).unwrap_or_else(Err))
}

/// Runs something that may panic.
#[inline]
pub(super) fn caught<T>(call: impl FnOnce() -> T) -> Result<T, Failure> {
    // What a panic may leave half done is not used again: handles in use then stay locked, but for being freed.
    catch_unwind(AssertUnwindSafe(call)).map_err(|payload| Failure::panic(&*payload))
}
