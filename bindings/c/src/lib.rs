//! The C interface of vesper.
//!
//! In: names, texts, arrays and handles from C, or from whatever speaks C. Out: engines behind handles, status codes, texts
//! that say what is wrong. Never: physics; a panic that leaves this crate; memory that was not lent or given.
//!
//! Two layers. [`session`] is safe Rust without handles: an engine of either precision, put together and asked by names,
//! which bindings to other languages use as a crate. [`interface`] is what `include/vesper.h` declares: handles, pointers
//! and codes around the session. `README.md` beside the header begins with ten lines of C.

pub mod interface;
pub mod session;
