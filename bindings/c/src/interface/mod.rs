//! What `include/vesper.h` declares: handles, pointers and codes around a [`session`](crate::session).
//!
//! In: calls from C. Out: status codes; what they mean in words, by thread. Never: a panic that leaves a function; a handle
//! that is followed before it is looked up; an array that is read before its length is known to be right.
//!
//! Every function, structure and constant is declared once, by the macros of [`declare`], which also list it: a test reads the
//! header and compares. The header documents them; here stands only what Rust adds.

mod arguments;
mod builder;
mod columns;
pub mod declare;
mod engine;
mod failure;
mod general;
mod handles;
mod log;

pub use builder::*;
pub use columns::*;
pub use engine::*;
pub use failure::*;
pub use general::*;
pub use log::*;
