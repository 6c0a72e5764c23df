//! Everything that a law, and a program that runs laws, needs: `use vesper::prelude::*;`.

pub use crate::column::{Column, Lent, Values};
pub use crate::domain::{AsProperty, Domain};
pub use crate::engine::{Builder, Checkpoint, Configure, Engine, Listing};
pub use crate::error::{Fault, Faults};
pub use crate::field::{Bottle, Boxes, Dipole, Field, FieldBox, Point, Points, Uniform};
pub use crate::integrate::{
    Auto, Boris, Boris8, Combination, DormandPrince5, DormandPrince8, DriftKickDrift, ExplicitEuler, GaussRadau15,
    HigueraCary, ImplicitEuler, ImplicitMidpoint, Integrator, Leapfrog, Linearised, Midpoint, Nystrom12, Part,
    Quantity, Register, Respa, RungeKutta4, SemiImplicitEuler, StableLimits, StableStep, Structure, Symplectic4,
    Symplectic6, Symplectic8, System, Terms, Tolerance,
};
pub use crate::law::{ColumnLaw, DynLaw, InverseSquare, Law, LinkLaw, PairLaw, RowLaw, Signature};
pub use crate::pipeline;
pub use crate::property::*;
pub use crate::real::{DoubleDouble, Real, Scalar as Precision, Vector as _};
pub use crate::registry::{Backend, Report, Status};
pub use crate::state::State;
pub use glam::{DVec3, Vec3};
pub use vesper_macros::{Law, kernel, property};
