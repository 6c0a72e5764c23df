//! Laws that were compiled elsewhere: found by name when a program runs, checked, and then like any other law.
//!
//! In: a folder of libraries, each of which exports one symbol, `vesper_module_v1`, a function that returns a table of laws. Out:
//! [`ModuleLaw`]s, which a builder lists as it lists others; or why a module, or one law of it, cannot be used. A law that fails while
//! it runs is switched off and named, and everything else goes on. Never: a module that is unloaded; a path that a scene chose.
//!
//! Modules are made from laws in Rust by [`export_laws!`](crate::export_laws), or written in C against `vesper_law.h`.
//!
//! ```no_run
//! use vesper::module::LawPath;
//! use vesper::prelude::*;
//! # fn main() -> Result<(), Faults> {
//! let path = LawPath::new(["laws"]);
//! // SAFETY: whoever put modules there is trusted: their code runs in this process.
//! let wings = unsafe { path.module("wings")? };
//! let bodies = Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[1.0, 0.0, 0.0]]).with(Mass, [1.0]);
//! let engine = Engine::<f64>::builder().domain(bodies).law(wings.law("lift")?.with("slope", &[0.2])?).build()?;
//! # Ok(())
//! # }
//! ```

pub mod abi;
mod column;
mod declared;
mod export;
mod instance;
mod link;
mod load;
mod native;
mod numbers;
mod pair;
mod row;
mod trial;

pub use export::{Table, exported};
pub use load::{LawPath, Module, ModuleLaw, PATH_VARIABLE};
