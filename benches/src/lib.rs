//! What the benches share: races of several ways to do one piece of work, the summary they write, and the bodies they
//! move.
//!
//! In: closures that do the same work. Out: medians and spreads, as a table for people and as `results/summary.csv`. Never: a
//! claim without the peer it was measured with, in the same run.
//!
//! `cargo bench` runs all; `cargo bench -- --test` runs every piece of work once, to see that it works;
//! `cargo bench --bench rows -- 1000` those whose name holds a word.

mod race;
mod random;
mod summary;

pub mod hand;
pub mod peers;
pub mod scenes;

pub use race::{Contender, Race, Run, Time, criterion};
pub use random::Random;
pub use summary::{Case, Summary};
