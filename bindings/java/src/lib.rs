//! The native half of the Java interface: what `vesper.Engine` and `vesper.Builder` in `../java` call.
//!
//! In: calls from these two classes and from `vesper.Library`, with texts, arrays and direct buffers. Out: numbers, and every fault as a
//! `vesper.VesperException` with its whole text. Never: physics; a panic that goes on into Java; a number of a lent buffer
//! that is copied.
//!
//! The native methods are private, and their handles are addresses: that none is used after it is closed, or by two threads
//! at once, is the duty of the Java half, `vesper/Held.java`, which sees to it before each call. All else is checked here, or in
//! the [`session`](vesper_c::session) that this stands on. `README.md` beside this folder begins with ten lines of Java.

mod arguments;
mod builder;
mod engine;
mod failure;
mod held;
mod library;
