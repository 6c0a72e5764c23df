//! Vesper: a compile-time law-graph framework for physics.
//!
//! A law of physics is an annotated struct with one function. It says which properties it reads, adds to, sets or gives
//! the rates of; from that the framework checks names, kinds and units, orders the laws, merges their loops, and runs
//! them under any integrator.
//!
//! ```
//! use vesper::prelude::*;
//!
//! /// Weight in a uniform field.
//! #[derive(Law, Clone, Copy, Debug)]
//! #[law(reads(mass: Mass), adds(force: Force))]
//! pub struct Weight<R = f64> {
//!     /// Acceleration of free fall.
//!     #[law(unit = "m/s^2", default = 9.81)]
//!     pub g: R,
//! }
//!
//! #[kernel]
//! impl<R: Real> RowLaw<R> for Weight<R> {
//!     fn row(&self, body: WeightRow<R>) -> R::Vec3 {
//!         R::Vec3::new(R::lit(0.0), R::lit(0.0), -self.g * body.mass)
//!     }
//! }
//!
//! /// Newton's second law.
//! #[derive(Law, Clone, Copy, Debug)]
//! #[law(reads(velocity: Velocity, force: Force, mass: Mass),
//!       rates(position: Position from (velocity), velocity: Velocity from (force, mass)))]
//! pub struct Newton;
//!
//! #[kernel]
//! impl<R: Real> RowLaw<R> for Newton {
//!     fn row(&self, body: NewtonRow<R>) -> NewtonOutput<R> {
//!         NewtonOutput { position: body.velocity, velocity: body.force / body.mass }
//!     }
//! }
//!
//! let ball = Domain::new("bodies").with(Position, [[0.0; 3]]).with(Velocity, [[0.0, 0.0, 10.0]]).with(Mass, [1.0]);
//! let mut engine = Engine::<f64>::builder().domain(ball).law(Weight::default()).law(Newton).step(1e-3).build()?;
//! engine.advance(1.0)?;
//! let height = engine.state().get("bodies", Position, 0)?.z;
//! assert!((height - (10.0 - 0.5 * 9.81)).abs() < 1e-9);
//! # Ok::<(), Faults>(())
//! ```
//!
//! # The way of the data
//!
//! Lowest layer first; a module imports only from those before it, which a test holds:
//! [`dimension`], [`error`], [`real`], [`mod@property`], [`mod@column`], [`domain`], [`field`], [`state`], [`law`],
//! [`mod@registry`], `graph`, [`backend`], [`integrate`], [`mod@pipeline`], [`engine`], [`prelude`].
//!
//! [`domain::Domain`]s become a [`state::State`]; the [`mod@registry`] ties every law's [`law::Signature`] to it; the graph
//! orders them; a [`mod@pipeline`] evaluates them, as often as an [`integrate::Integrator`] asks; an [`engine::Engine`] cuts
//! client time into steps.

extern crate self as vesper;

pub use vesper_dimension as dimension;
pub use vesper_macros::{Law, kernel, property};

pub mod backend;
pub mod column;
pub mod domain;
pub mod engine;
pub mod error;
pub mod field;
mod graph;
pub mod integrate;
pub mod law;
pub mod pipeline;
pub mod prelude;
pub mod property;
pub mod real;
pub mod registry;
pub mod state;
