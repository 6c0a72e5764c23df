//! Speed against error: integrators, steps, tolerances and precisions, held against answers.
//!
//! In: cases with known answers, or anybody's scene. Out: how long each way takes, and how far it ends from the answer.
//! Never: a choice that knows a case, or a claim without a run behind it.
//!
//! The way of the data: [`case`](Case) reads cases, `setup` makes laws and rows of one; a [`Problem`] is such a case or a
//! scene; [`measure()`] runs it by a [`Method`]; a [`Grid`] says which methods, and where to stop; [`Findings`] holds what
//! came of it; `table` and `diagram` show it; a [`Budget`] chooses from it, by the times of a [`race()`], and [`written()`]
//! puts the choice into its scene. An [`Attribution`] switches off one law after the other.

mod attribution;
mod budget;
mod case;
mod diagram;
mod findings;
mod grid;
mod measure;
mod problem;
mod race;
mod setup;
mod shares;
mod table;
mod write;

pub use attribution::{Attribution, Finding, Share, Verdict};
pub use budget::Budget;
pub use case::{Body, Case, CaseLaw, Region, Sample, Spring, read};
pub use diagram::diagram;
pub use findings::{Findings, LEVELS};
pub use grid::{Grid, Keeper, Refusal, makers};
pub use measure::{Method, Patience, Run, Setting, answer, measure};
pub use problem::{Answer, Moment, Problem};
pub use race::race;
pub use setup::builder;
pub use shares::shares;
pub use table::{choice, table};
pub use write::written;
