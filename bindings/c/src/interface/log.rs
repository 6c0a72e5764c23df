//! What the library logs, handed to a function of the client.
//!
//! In: records of `log`. Out: calls of the client's function, on the thread that has something to say. Never: a record kept, or a
//! lock held while the client's function runs.

use super::declare::{constants, functions};
use super::failure::{Failure, Status, VESPER_ERROR_ARGUMENT, VESPER_ERROR_FAULT, guarded, in_c};
use core::ffi::{c_char, c_void};
use log::{LevelFilter, Log, Metadata, Record};
use std::sync::{OnceLock, PoisonError, RwLock};

constants! {
    /// The levels of the log.
    LOG_LEVELS: u32;
    /// Nothing.
    VESPER_LOG_OFF = 0;
    /// What is wrong.
    VESPER_LOG_ERROR = 1;
    /// What probably is not meant: a law that sleeps.
    VESPER_LOG_WARN = 2;
    /// What is good to know: a law that woke, a column that nobody uses.
    VESPER_LOG_INFO = 3;
    /// What helps to find mistakes.
    VESPER_LOG_DEBUG = 4;
    /// Everything.
    VESPER_LOG_TRACE = 5;
}

/// A function of the client: `vesper_log_callback`.
pub type LogCallback = Option<unsafe extern "C" fn(level: u32, text: *const c_char, user: *mut c_void)>;

/// The client's function, and the address that it is given back.
#[derive(Clone, Copy)]
struct Listener {
    callback: unsafe extern "C" fn(u32, *const c_char, *mut c_void),
    user: *mut c_void,
}

// SAFETY: the client promised that its function may be called on any thread, with this address, which is never followed here.
unsafe impl Send for Listener {}
// SAFETY: as above.
unsafe impl Sync for Listener {}

static LISTENER: RwLock<Option<Listener>> = RwLock::new(None);

struct Forward;

impl Log for Forward {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn log(&self, record: &Record<'_>) {
        let listener = *LISTENER.read().unwrap_or_else(PoisonError::into_inner);
        if let Some(Listener { callback, user }) = listener {
            let text = in_c(&record.args().to_string());
            // SAFETY: the client gave the function for this; the text lives until it comes back.
            unsafe { callback(record.level() as u32, text.as_ptr(), user) };
        }
    }

    fn flush(&self) {}
}

/// Whether this library could become the program's logger; asked once.
fn is_logger() -> bool {
    static IS: OnceLock<bool> = OnceLock::new();
    *IS.get_or_init(|| log::set_logger(&Forward).is_ok())
}

functions! {
    /// The functions for the log.
    LOG_FUNCTIONS;

    /// Hands what is logged to a function of the client; null for nobody.
    fn vesper_set_log(callback: LogCallback, user: *mut c_void, level: u32) -> Status {
        guarded(|| {
            let level = match level {
                VESPER_LOG_OFF => LevelFilter::Off,
                VESPER_LOG_ERROR => LevelFilter::Error,
                VESPER_LOG_WARN => LevelFilter::Warn,
                VESPER_LOG_INFO => LevelFilter::Info,
                VESPER_LOG_DEBUG => LevelFilter::Debug,
                VESPER_LOG_TRACE => LevelFilter::Trace,
                other => {
                    let text = format!("the level is {other}: give one of VESPER_LOG_OFF to VESPER_LOG_TRACE");
                    return Err(Failure::new(VESPER_ERROR_ARGUMENT, text));
                }
            };
            if !is_logger() {
                let text = "the program has a logger of its own in Rust already: it gets what vesper logs";
                return Err(Failure::new(VESPER_ERROR_FAULT, text));
            }
            let listener = callback.map(|callback| Listener { callback, user });
            *LISTENER.write().unwrap_or_else(PoisonError::into_inner) = listener;
            log::set_max_level(if callback.is_some() { level } else { LevelFilter::Off });
            Ok(())
        })
    }
}
