//! The stock laws of physics, one file each: what a law touches, its equation, its source, where it is wrong, its
//! kernel, its test. They use only `vesper::prelude`, so that anyone's law crate has the same power.
//!
//! ```
//! use vesper::prelude::*;
//! use vesper_laws::{Gravity, Motion};
//!
//! let bodies = Domain::new("bodies")
//!     .with(Position, [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])
//!     .with(Velocity, [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
//!     .with(Mass, [1.0, 1e-9]);
//! let gravity = Gravity { g: 1.0, softening: 0.0 };
//! let mut engine = Engine::<f64>::builder().domain(bodies).law(gravity).law(Motion).step(1e-3).build()?;
//! engine.advance(core::f64::consts::TAU)?;
//! assert!((engine.state().get("bodies", Position, 1)? - DVec3::X).length() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! [`catalog`] lists the laws for whoever chooses by name; [`invariants`] sums what an undisturbed system keeps;
//! [`mod@reference`] holds problems with known answers. [`WisdomHolman`] is an integrator that knows one of the laws.

/// The code of the repository's front page, run as a test.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct FrontPage;

/// The examples of `derive(Law)`, whose own crate cannot run them.
#[cfg(doctest)]
#[doc = include_str!("../../vesper-macros/src/law.md")]
struct Declarations;

pub mod catalog;
pub mod invariants;
pub mod reference;
mod spheres;
mod wisdom_holman;

pub use wisdom_holman::{KeplerStep, WisdomHolman, kepler_step};

/// Declares the files of the laws, and brings what they make to the front.
macro_rules! laws {
    ($($file:ident),* $(,)?) => {$(
        mod $file;
        pub use $file::*;
    )*};
}
laws! {
    contact_plane,
    coulomb,
    damper,
    drag,
    driven_force,
    einstein_infeld_hoffmann,
    electric_force,
    field_gravity,
    gravity,
    gravity_by_parameter,
    henon_heiles,
    hierarchical_gravity,
    kinematics,
    magnetic_force,
    motion,
    newtonian_field,
    post_newtonian,
    quadratic_drag,
    quartic_spring,
    relativistic_mass,
    relativistic_motion,
    relativistic_velocity,
    rotating_frame,
    spring,
    uniform_gravity,
}
