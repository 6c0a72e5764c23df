//! Laws that were compiled apart: the same bits as laws that were not, and clear words for everything that can be wrong with them.

#![allow(clippy::unwrap_used, reason = "tests")]

mod alike;
mod compiler;
mod failures;
mod header;
mod memory;
mod refused;
