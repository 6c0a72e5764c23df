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
//! # Laws that jump
//!
//! A law whose body has cases with a jump between them sets a switch, and decides by the value that it had when the step
//! began. Integrators end a step where its sign turns, so that no step goes across the jump, whatever their order:
//!
//! ```
//! use vesper::prelude::*;
//!
//! property! {
//!     /// Height above the table; below 0 on it.
//!     pub Gap: Scalar, "m", switch;
//! }
//!
//! /// A table that pushes what has sunk in.
//! #[derive(Law, Clone, Copy, Debug)]
//! #[law(reads(position: Position, previous held: Gap), sets(gap: Gap), adds(force: Force))]
//! pub struct Table<R = f64> {
//!     /// Force per depth.
//!     #[law(unit = "N/m", default = 1e5)]
//!     pub stiffness: R,
//! }
//!
//! #[kernel]
//! impl<R: Real> RowLaw<R> for Table<R> {
//!     fn row(&self, body: TableRow<R>) -> TableOutput<R> {
//!         let gap = body.position.z();
//!         let push = R::Vec3::new(R::lit(0.0), R::lit(0.0), -self.stiffness * gap);
//!         TableOutput { gap, force: R::select_vector(body.held.less(R::lit(0.0)), push, R::Vec3::zero()) }
//!     }
//! }
//! ```
//!
//! # The way of the data
//!
//! Lowest layer first; a module imports only from those before it, which a test holds:
//! [`dimension`], [`error`], [`real`], [`mod@property`], [`mod@column`], [`domain`], [`field`], [`state`], [`law`],
//! [`mod@registry`], `graph`, [`backend`], `module`, [`integrate`], [`mod@pipeline`], [`engine`], [`prelude`].
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
#[cfg(feature = "modules")]
pub mod module;
pub mod pipeline;
pub mod prelude;
pub mod property;
pub mod real;
pub mod registry;
pub mod state;
