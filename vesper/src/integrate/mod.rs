//! How a state goes on by one step.
//!
//! In: a [`System`] that can be asked for rates. Out: integrators, one file each, written only in sums of vectors and
//! magnitudes of rows, so that each works with any laws. Never: a law, a column, a property's name. One that uses the
//! structure of its problem stands in the crate that knows it, and reads and writes rows ([`System::find`]).
//!
//! | integrator | order | evaluations per step | for |
//! |---|---|---|---|
//! | [`ExplicitEuler`] | 1 | 1 | a yardstick |
//! | [`SemiImplicitEuler`] | 1 | 1 | games |
//! | [`Midpoint`] | 2 | 2 | any laws, short runs |
//! | [`Leapfrog`], [`DriftKickDrift`] | 2 | 1 | long runs, moderate accuracy |
//! | [`Respa`] | 2 | 1 | laws of different pace |
//! | [`RungeKutta4`] | 4 | 4 | any laws |
//! | [`Symplectic4`], [`Symplectic6`], [`Symplectic8`] | 4, 6, 8 | 6, 10 or 11, 17 | long runs, high accuracy |
//! | [`Boris`], [`HigueraCary`] | 2 | 1 | charges in magnetic fields, long runs |
//! | [`Boris8`] | 8 | 17 | the same, high accuracy |
//! | [`DormandPrince5`], [`DormandPrince8`] | 5, 8, adaptive | 6, 12 | a tolerance, any laws |
//! | [`Nystrom12`] | 12, adaptive | 17 | forces that do not depend on velocities |
//! | [`Auto`] | | | what the structure of the laws suggests |
//! | [`GaussRadau15`] | 15, adaptive | 7 a round | all digits |
//! | [`ImplicitEuler`], [`ImplicitMidpoint`] | 1, 2 | 2 to 5, and derivatives | stiff laws |
//!
//! Explicit methods of fixed steps say where they are stable ([`Integrator::stable_limits`]); the laws' own derivatives say how
//! long a step that allows ([`crate::engine::Engine::stable_step`]).
//!
//! A step ends where a law's switch turns or a row leaves a region of a field: adaptive integrators ask for it
//! ([`System::turned`]), and the engine cuts the steps of all others, so that each keeps its order.

mod adaptive;
mod auto;
mod boris;
mod boris_8;
mod dense;
mod dormand_prince_5;
mod dormand_prince_8;
mod drift_kick_drift;
mod embedded;
mod explicit_euler;
mod gauss_radau_15;
mod gauss_radau_table;
mod hessenberg;
mod higuera_cary;
mod implicit;
mod implicit_euler;
mod implicit_midpoint;
mod integrator;
mod jump;
mod krylov;
mod leapfrog;
mod linearised;
mod midpoint;
mod nystrom_12;
mod nystrom_12_table;
mod quantity;
mod respa;
mod runge_kutta;
mod runge_kutta_4;
mod semi_implicit_euler;
mod splitting;
mod stability;
mod symplectic_4;
mod symplectic_6;
mod symplectic_8;
mod system;

pub use crate::law::Part;
pub use adaptive::Tolerance;
pub use auto::Auto;
pub use boris::Boris;
pub use boris_8::Boris8;
pub use dormand_prince_5::DormandPrince5;
pub use dormand_prince_8::DormandPrince8;
pub use drift_kick_drift::DriftKickDrift;
pub use explicit_euler::ExplicitEuler;
pub use gauss_radau_15::GaussRadau15;
pub use higuera_cary::HigueraCary;
pub use implicit_euler::ImplicitEuler;
pub use implicit_midpoint::ImplicitMidpoint;
pub use integrator::{Integrator, Structure};
pub(crate) use jump::{Again, split};
pub use leapfrog::Leapfrog;
pub use linearised::Linearised;
pub use midpoint::Midpoint;
pub use nystrom_12::Nystrom12;
pub(crate) use quantity::At;
pub use quantity::Quantity;
pub use respa::Respa;
pub use runge_kutta_4::RungeKutta4;
pub use semi_implicit_euler::SemiImplicitEuler;
pub use stability::{StableLimits, StableStep};
pub(crate) use stability::{stable_step, vectors as stable_vectors};
pub use symplectic_4::Symplectic4;
pub use symplectic_6::Symplectic6;
pub use symplectic_8::Symplectic8;
pub use system::{Combination, Pace, Register, Rotation, System, Term, Terms};
