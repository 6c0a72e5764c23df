//! The C interface, called as C calls it.

mod cases;
mod faults;
mod handles;
mod header;
mod random;
mod rows;
mod support;
