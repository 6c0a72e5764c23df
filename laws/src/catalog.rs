//! The stock laws as a list, for whoever chooses laws by name at run time: the command line, scene files.
//!
//! In: the laws of this crate. Out: [`stock_laws`], each with its declaration and a way to make it runnable from the
//! numbers of its parameters, in any precision. Never: a state, a scene.

use crate::*;
use vesper::backend::{Compile, Compiled};
use vesper::law::{Law, Signature};
use vesper::real::DoubleDouble;

/// A law of this crate.
#[derive(Clone, Copy)]
pub struct StockLaw {
    /// What it touches, its parameters, and its documentation.
    pub signature: Signature,
    single: fn(&[f64]) -> Compiled<f32>,
    double: fn(&[f64]) -> Compiled<f64>,
    twice: fn(&[f64]) -> Compiled<DoubleDouble>,
}

impl core::fmt::Debug for StockLaw {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("StockLaw").field("name", &self.signature.name).finish_non_exhaustive()
    }
}

/// The precisions of a stock law are those of an engine.
pub use vesper::real::Scalar as CatalogPrecision;

/// A stock law with the components of its parameters.
struct Given<'a>(&'a StockLaw, &'a [f64]);

impl Compile for Given<'_> {
    fn compile_f32(&self) -> Compiled<f32> {
        (self.0.single)(self.1)
    }

    fn compile_f64(&self) -> Compiled<f64> {
        (self.0.double)(self.1)
    }

    fn compile_double_double(&self) -> Compiled<DoubleDouble> {
        (self.0.twice)(self.1)
    }
}

impl StockLaw {
    const fn of<L: Law + Compile>() -> Self {
        StockLaw {
            signature: L::SIGNATURE,
            single: |parameters| L::from_parameters(parameters).compile_f32(),
            double: |parameters| L::from_parameters(parameters).compile_f64(),
            twice: |parameters| L::from_parameters(parameters).compile_double_double(),
        }
    }

    /// The law made runnable, with the components of its parameters in declared order (a vector is three). Those left
    /// out at the end have their defaults.
    pub fn compile<P: CatalogPrecision>(&self, parameters: &[f64]) -> Compiled<P> {
        Given(self, parameters).compile()
    }

    /// The components of all parameters in declared order, as they are where none is given; 0 where there is no default.
    pub fn default_parameters(&self) -> Vec<f64> {
        let parameters = self.signature.parameters.iter();
        parameters
            .flat_map(|parameter| parameter.default.unwrap_or_default().into_iter().take(parameter.width))
            .collect()
    }

    /// The first line of its documentation: what it is.
    pub fn summary(&self) -> &'static str {
        self.signature.doc.lines().next().unwrap_or_default()
    }
}

/// All stock laws, by name.
pub fn stock_laws() -> &'static [StockLaw] {
    const LAWS: &[StockLaw] = &[
        StockLaw::of::<ContactPlane>(),
        StockLaw::of::<Coulomb>(),
        StockLaw::of::<Damper>(),
        StockLaw::of::<Drag>(),
        StockLaw::of::<DrivenForce>(),
        StockLaw::of::<EinsteinInfeldHoffmann>(),
        StockLaw::of::<ElectricForce>(),
        StockLaw::of::<FieldGravity>(),
        StockLaw::of::<Gravity>(),
        StockLaw::of::<GravityByParameter>(),
        StockLaw::of::<HenonHeiles>(),
        StockLaw::of::<HierarchicalGravity>(),
        StockLaw::of::<Kinematics>(),
        StockLaw::of::<MagneticForce>(),
        StockLaw::of::<Motion>(),
        StockLaw::of::<NewtonianField>(),
        StockLaw::of::<PostNewtonian>(),
        StockLaw::of::<QuadraticDrag>(),
        StockLaw::of::<QuarticSpring>(),
        StockLaw::of::<RelativisticMass>(),
        StockLaw::of::<RelativisticMotion>(),
        StockLaw::of::<RelativisticVelocity>(),
        StockLaw::of::<RotatingFrame>(),
        StockLaw::of::<Spring>(),
        StockLaw::of::<UniformGravity>(),
    ];
    LAWS
}

/// The stock law of this name.
pub fn stock_law(name: &str) -> Option<&'static StockLaw> {
    stock_laws().iter().find(|law| law.signature.name == name)
}
