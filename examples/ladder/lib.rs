//! A ladder of programs, from a first law to an own integrator. Start with
//! `cargo run --release --example first_law`, and read the files beside this one in the order of their numbers.

pub mod lennard_jones;
