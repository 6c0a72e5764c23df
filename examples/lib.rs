//! A ladder of programs, from a first law to an own integrator. Start with
//! `cargo run --release --example first_law`, and read the files in `ladder/` in the order of their numbers.
