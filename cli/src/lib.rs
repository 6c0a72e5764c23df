//! The parts of the `vesper` command that need no library but units: scene files, tables, generators.
//!
//! In: files that people write. Out: plain data, or faults with places. Never: runs anything. A library beside the
//! command, so that tests and benches read scenes as the command does.

pub mod csv;
pub mod fault;
pub mod generate;
pub mod scene;
