//! The core under test: small laws of every shape, and everything that clients may do with them, rightly or wrongly.

mod common;
mod extremes;
mod faults;
mod graph;
mod lanes;
mod links;
mod oracle;
mod state;
