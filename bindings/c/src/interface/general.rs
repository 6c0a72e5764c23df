//! What needs no handle: the version of the interface, codes in words, the last failure.

use super::declare::{Constant, functions};
use super::failure::{self, Status, last_text};
use core::ffi::{CStr, c_char};

/// The version of everything that the header declares. It changes where a program that was built with an older header would go
/// wrong; a function more does not change it.
pub const VESPER_ABI_VERSION: u32 = 1;

/// The version, for the test that compares the header with the code.
pub const VERSION: &[Constant] = &[Constant { name: "VESPER_ABI_VERSION", value: VESPER_ABI_VERSION as i64 }];

/// A code in words.
const fn words(status: Status) -> &'static CStr {
    match status {
        failure::VESPER_OK => c"done",
        failure::VESPER_ERROR_ARGUMENT => c"an argument makes no sense",
        failure::VESPER_ERROR_HANDLE => c"the handle is null or was freed",
        failure::VESPER_ERROR_THREAD => c"another thread has the handle, or a call on it is under way",
        failure::VESPER_ERROR_FAULT => c"what was described or asked for does not fit",
        failure::VESPER_ERROR_RUN => c"a step could not be taken",
        failure::VESPER_ERROR_PANIC => c"a mistake inside the library",
        failure::VESPER_ERROR_LIMIT => c"there are no more handles",
        _ => c"no status of this library",
    }
}

functions! {
    /// The functions that need no handle.
    GENERAL_FUNCTIONS;

    /// The version of the interface that this library has.
    fn vesper_abi_version() -> u32 {
        VESPER_ABI_VERSION
    }

    /// A status in words.
    fn vesper_status_text(status: Status) -> *const c_char {
        words(status).as_ptr()
    }

    /// The whole text of this thread's last failure.
    fn vesper_last_error() -> *const c_char {
        last_text()
    }
}
