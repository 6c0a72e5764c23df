//! A law that a module made: its own memory behind a pointer, what it said, and whether it failed.
//!
//! In: a declaration and parameters. Out: an [`Instance`], which calls the law as long as it does what it should. A law that fails is
//! not called again: its shares are nothing from then on, and the engine is told. Never: which rows a call is of.

use super::abi;
use super::declared::Declared;
use super::trial;
use crate::backend::{Entries, Foreign, RowCall, RowFunction};
use crate::law::{Place, Port};
use crate::real::Isa;
use core::cell::RefCell;
use core::ffi::{CStr, c_char, c_void};
use core::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

/// A component of a port.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slot {
    pub(super) port: &'static Port,
    /// Whether it has one number for all rows.
    pub(super) one: bool,
}

/// What computes.
type Apply = unsafe extern "C" fn(*mut c_void, *const abi::Call) -> i32;

/// A table without one is refused.
unsafe extern "C" fn no_apply(_this: *mut c_void, _call: *const abi::Call) -> i32 {
    0
}

/// A law that was made.
#[derive(Debug)]
pub(super) struct Instance {
    pub(super) declared: &'static Declared,
    this: *mut c_void,
    apply: Apply,
    has_memory: bool,
    pub(super) slots: Vec<Slot>,
    /// By slot, numbers from one row to the next.
    pub(super) strides: Vec<usize>,
    failed: AtomicBool,
    reason: Mutex<String>,
    /// Held during calls of a law that has a memory: it need not know of threads.
    turn: Mutex<()>,
}

// SAFETY: a module promises that its laws may be called by any thread, and those without a memory by several at once, for different rows.
unsafe impl Send for Instance {}
// SAFETY: as above; those with a memory are called by one thread at a time.
unsafe impl Sync for Instance {}

thread_local! {
    /// What a law of this thread last said was an error, and who said it.
    static ERROR: RefCell<(usize, String)> = const { RefCell::new((0, String::new())) };
}

/// What laws call to say something. The context is the law's name.
pub(super) unsafe extern "C" fn log(context: *mut c_void, level: u32, text: *const c_char) {
    if context.is_null() || text.is_null() {
        return;
    }
    // SAFETY: hosts are made with the name of a law as their context, which stays; the law gives a text that ends with a zero.
    let (law, text) = unsafe { (*context.cast::<&'static str>().cast_const(), CStr::from_ptr(text)) };
    let text = text.to_string_lossy();
    let level = match level {
        abi::LOG_ERROR => log::Level::Error,
        2 => log::Level::Warn,
        3 => log::Level::Info,
        4 => log::Level::Debug,
        _ => log::Level::Trace,
    };
    log::log!(level, "{law}: {text}");
    if level == log::Level::Error {
        // A thread that ends may have no place for it any more.
        _ = ERROR.try_with(|error| *error.borrow_mut() = (context.addr(), text.into_owned()));
    }
}

impl Instance {
    /// Makes the law; one that cannot be made has failed from the beginning.
    ///
    /// # Safety
    /// The module's functions do what `vesper_law.h` says.
    pub(super) unsafe fn new(declared: &'static Declared, parameters: &[f64]) -> Self {
        let components = |port: &'static Port| {
            let one = port.place == Place::Scene;
            core::iter::repeat_n(Slot { port, one }, port.property.kind.width())
        };
        let slots: Vec<Slot> = declared.signature.ports.iter().flat_map(components).collect();
        let strides = slots.iter().map(|slot| usize::from(!slot.one)).collect();
        let mut instance = Instance {
            declared,
            this: core::ptr::null_mut(),
            apply: declared.table.apply.unwrap_or(no_apply),
            has_memory: declared.table.state_size > 0,
            slots,
            strides,
            failed: AtomicBool::new(false),
            reason: Mutex::default(),
            turn: Mutex::default(),
        };
        // Parameters that are no numbers are a fault of their own.
        if !parameters.iter().all(|number| number.is_finite()) {
            return instance;
        }
        // SAFETY: passed on to the caller.
        unsafe { instance.make(parameters) };
        // What the framework's own loops run is checked where it was compiled.
        if declared.table.native != abi::NATIVE && !instance.has_failed() {
            // SAFETY: passed on to the caller.
            if let Err(wrong) = unsafe { trial::trial(&instance) } {
                instance.fail_for(wrong);
            } else if instance.has_memory {
                // It shall not remember rows of nobody's.
                instance.unmake();
                // SAFETY: passed on to the caller.
                unsafe { instance.make(parameters) };
            }
        }
        instance
    }

    /// # Safety
    /// As for `new`.
    unsafe fn make(&mut self, parameters: &[f64]) {
        let Some(create) = self.declared.table.create else { return };
        forget_errors();
        // SAFETY: passed on to the caller; the host and the declaration stay.
        let status =
            unsafe { create(&raw const self.declared.host, parameters.as_ptr(), parameters.len(), &raw mut self.this) };
        if status != 0 {
            self.this = core::ptr::null_mut();
            self.fail("create", status);
        }
    }

    fn unmake(&mut self) {
        if let Some(destroy) = self.declared.table.destroy.filter(|_| !self.this.is_null()) {
            // SAFETY: `create` made it, and nobody else has it.
            unsafe { destroy(self.this) };
        }
        self.this = core::ptr::null_mut();
    }

    /// Whether the law is called no more.
    #[inline(always)]
    pub(super) fn has_failed(&self) -> bool {
        self.failed.load(Ordering::Relaxed)
    }

    /// Calls the law; whether it did what it should.
    ///
    /// # Safety
    /// The call is of this law's slots, and nobody else touches the rows that it writes.
    #[inline]
    pub(super) unsafe fn call(&self, call: &abi::Call) -> bool {
        if self.has_failed() {
            return false;
        }
        // SAFETY: passed on to the caller.
        let status = unsafe { self.apply(call) };
        if status != 0 {
            self.fail("apply", status);
        }
        status == 0
    }

    /// What computes rows as the framework's own loops do, of a law that was made by [`export_laws!`](crate::export_laws).
    pub(super) fn native_rows<P>(&self) -> Option<RowFunction> {
        if self.declared.table.native != abi::NATIVE || self.this.is_null() {
            return None;
        }
        // SAFETY: what such a law's `create` makes begins so.
        unsafe { Entries::rows_of::<P>(self.this) }
    }

    /// Calls the law with rows as the framework's own loops have them; whether it did what it should.
    ///
    /// # Safety
    /// As for `call`; `rows` is the law's in the precision of `call`.
    #[inline(always)]
    pub(super) unsafe fn call_rows<P>(&self, rows: RowFunction, call: &RowCall<'_, P>, isa: Isa) -> bool {
        if self.has_failed() {
            return false;
        }
        // SAFETY: passed on to the caller; such laws have no memory, so that they need no turns.
        let status = unsafe { rows(self.this, (&raw const *call).cast(), isa.number()) };
        if status != 0 {
            self.fail("apply", status);
        }
        status == 0
    }

    /// Calls the law, whatever it answers.
    ///
    /// # Safety
    /// As for `call`.
    #[inline]
    pub(super) unsafe fn apply(&self, call: &abi::Call) -> i32 {
        let _turn = self.turn();
        // SAFETY: passed on to the caller.
        unsafe { (self.apply)(self.this, call) }
    }

    /// The energy, where the law knows it.
    ///
    /// # Safety
    /// As for `call`.
    pub(super) unsafe fn energy(&self, call: &abi::Call) -> f64 {
        let Some(energy) = self.declared.table.energy.filter(|_| !self.has_failed()) else { return 0.0 };
        let _turn = self.turn();
        let mut found = 0.0;
        // SAFETY: passed on to the caller.
        let status = unsafe { energy(self.this, call, &raw mut found) };
        if status != 0 {
            self.fail("energy", status);
            return 0.0;
        }
        found
    }

    #[inline(always)]
    fn turn(&self) -> Option<std::sync::MutexGuard<'_, ()>> {
        self.has_memory.then(|| self.turn.lock().unwrap_or_else(PoisonError::into_inner))
    }

    #[cold]
    fn fail(&self, function: &str, status: i32) {
        let said = self.said();
        self.fail_for(format!("`{function}` returned {status}{said}"));
    }

    /// What the law itself last said was an error, behind a colon.
    fn said(&self) -> String {
        let (who, text) = ERROR.try_with(RefCell::take).unwrap_or_default();
        if who == self.declared.host.context.addr() && !text.is_empty() { format!(": {text}") } else { String::new() }
    }

    fn fail_for(&self, reason: String) {
        let mut first = self.reason.lock().unwrap_or_else(PoisonError::into_inner);
        if !self.failed.swap(true, Ordering::Relaxed) {
            *first = reason;
        }
    }
}

/// What was said before does not belong to what comes.
fn forget_errors() {
    _ = ERROR.try_with(RefCell::take);
}

impl Drop for Instance {
    fn drop(&mut self) {
        self.unmake();
    }
}

impl Foreign for Instance {
    fn give_up(&self, reason: &str) {
        self.fail_for(reason.to_owned());
    }

    fn fits(&self, memory: &[u8]) -> Result<(), String> {
        let size = if self.has_failed() { memory.len() } else { self.declared.table.state_size };
        if memory.len() == size {
            return Ok(());
        }
        Err(format!("its memory has {} bytes, and the law's {size}", memory.len()))
    }

    fn failure(&self) -> Option<String> {
        self.has_failed().then(|| self.reason.lock().unwrap_or_else(PoisonError::into_inner).clone())
    }

    fn save(&self) -> Result<Vec<u8>, String> {
        let (Some(save), size) = (self.declared.table.save, self.declared.table.state_size) else {
            return Ok(Vec::new());
        };
        if size == 0 || self.has_failed() {
            return Ok(Vec::new());
        }
        let mut memory = vec![0_u8; size];
        let _turn = self.turn();
        // SAFETY: there is room for as many bytes as the law says.
        match unsafe { save(self.this, memory.as_mut_ptr().cast()) } {
            0 => Ok(memory),
            status => Err(format!("`save` returned {status}{}", self.said())),
        }
    }

    fn load(&self, memory: &[u8]) -> Result<(), String> {
        let size = self.declared.table.state_size;
        self.fits(memory)?;
        let Some(load) = self.declared.table.load.filter(|_| size > 0 && !self.has_failed()) else { return Ok(()) };
        let _turn = self.turn();
        // SAFETY: there are as many bytes as the law says.
        match unsafe { load(self.this, memory.as_ptr().cast()) } {
            0 => Ok(()),
            status => Err(format!("`load` returned {status}{}", self.said())),
        }
    }
}
