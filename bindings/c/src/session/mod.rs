//! An engine of either precision, put together and asked by names: what bindings to other languages stand on.
//!
//! In: names and texts, slices of numbers, memory that a client lends. Out: an [`Assembly`], which becomes a [`Session`];
//! [`Trouble`] with the text of every fault. Never: a handle; a pointer that it follows, but for lent memory.
//!
//! ```
//! use vesper_c::session::{Assembly, NumberType, Numbers, NumbersMut};
//! let mut assembly = Assembly::new(NumberType::F64)?;
//! assembly.domain("bodies", 1)?;
//! assembly.column("bodies", "position", Numbers::F64(&[0.0, 0.0, 10.0]))?;
//! assembly.column("bodies", "velocity [km/s]", Numbers::F64(&[0.0, 0.0, 0.01]))?;
//! assembly.column("bodies", "mass", Numbers::F64(&[1.0]))?;
//! assembly.column("scene", "gravity", Numbers::F64(&[0.0, 0.0, -9.81]))?;
//! assembly.law("uniform_gravity", "")?;
//! assembly.law("motion", "")?;
//! let mut session = assembly.build()?;
//! session.step(1000, 1e-3)?;
//! let mut position = [0.0; 3];
//! session.get("bodies", "position", NumbersMut::F64(&mut position))?;
//! assert!((position[2] - (20.0 - 0.5 * 9.81)).abs() < 1e-9);
//! # Ok::<(), vesper_c::session::Trouble>(())
//! ```

mod assembly;
mod draft;
mod lending;
mod names;
mod numbers;
mod run;
mod texts;
mod trouble;
mod values;
mod view;

pub use assembly::{Assembly, Session};
pub use lending::is_lent;
pub use numbers::{Memory, NumberType, Numbers, NumbersMut};
pub use run::Words;
pub use trouble::{Trouble, panicked};
pub use view::View;
