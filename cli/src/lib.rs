//! The `vesper` command, as a library: tests and benches read and run scenes as the command does.
//!
//! In: files that people write. Out: engines, runs, files, or every mistake with its place. Never: physics; that is the
//! library's and the laws'.
//!
//! The way of the data: [`scene`] (with [`csv`], [`generate`], [`fault`]) reads a file -> [`assemble`] makes an engine of
//! it -> [`run`] takes it to its end -> [`output`] says, saves and draws what came of it; [`study`] holds integrators
//! against known answers (with [`reader`]); [`sweep`] runs a scene with many values; [`command`] is the words of the command
//! line for all this.

pub mod assemble;
pub mod command;
pub mod csv;
pub mod fault;
pub mod generate;
pub mod hash;
pub mod modules;
pub mod output;
pub mod reader;
pub mod run;
pub mod scene;
pub mod study;
pub mod sweep;
