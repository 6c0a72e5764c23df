//! Ensembles: one scene run with many values, in shards that share a folder, into one table and one picture.
//!
//! In: a scene, `--vary` and `--measure` arguments, a folder. Out: a record for each run, a table, a picture; or every mistake
//! of the arguments and of the scene before anything runs. Never: a lock, a server, a result that depends on how the runs
//! were shared out.
//!
//! The way of the data: [`vary`] (the values of a path) and [`measure`] (what is told of a run) make an [`ensemble`], which
//! numbers the runs -> [`plan`] (with the scene) makes the scene of each -> [`mod@check`] looks at all before anything runs ->
//! [`work`] runs them, some at a time -> [`record`]s lie in a [`folder`], whose [`manifest`] says whose they are -> [`table`]
//! and [`mod@diagram`] (with `scale`, `panel`) show them.

pub mod check;
pub mod diagram;
pub mod ensemble;
pub mod folder;
pub mod manifest;
pub mod measure;
mod panel;
pub mod plan;
pub mod record;
mod scale;
pub mod table;
pub mod vary;
pub mod work;

pub use check::check;
pub use diagram::diagram;
pub use ensemble::{Ensemble, Shard};
pub use folder::SweepFolder;
pub use manifest::Manifest;
pub use measure::Measure;
pub use plan::Plan;
pub use record::Record;
pub use vary::Vary;
