//! How a state goes on by one step.
//!
//! In: a [`System`] that can be asked for rates. Out: integrators, one file each, written only in evaluate, zero, copy,
//! axpy and advance, so that each works with any laws. Never: a law, a column, a property's name.

mod leapfrog;
mod runge_kutta_4;
mod semi_implicit_euler;

pub use crate::law::Part;
pub use leapfrog::Leapfrog;
pub use runge_kutta_4::RungeKutta4;
pub use semi_implicit_euler::SemiImplicitEuler;

use crate::error::Fault;

/// A vector with a number for every number of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Register {
    /// The state itself.
    State,
    /// The time derivatives that the last `evaluate` left.
    Rates,
    /// A vector of the integrator's own, zero at first; it asks for as many as it needs.
    Work(usize),
}

/// What an integrator sees of laws and data.
pub trait System {
    /// The time of the state, in s.
    fn time(&self) -> f64;
    /// Sets the time at which laws are evaluated, in s.
    fn set_time(&mut self, time: f64);
    /// Runs the laws once, so that [`Register::Rates`] holds the rates of this part at the state and time as they are.
    fn evaluate(&mut self, part: Part);
    /// For each stage in turn: evaluates, and adds the step, in s, times the rates to the state. The same as `evaluate`
    /// and `axpy`, but the rates need not be kept, so a stage of row laws is one pass over memory, and so are
    /// neighbouring stages.
    fn advance(&mut self, stages: &[(Part, f64)]);
    /// `to += a * x`, for this part.
    fn axpy(&mut self, to: Register, a: f64, x: Register, part: Part);
    /// `to = from`, for this part.
    fn copy(&mut self, to: Register, from: Register, part: Part);
    /// `to = 0`, for this part.
    fn zero(&mut self, to: Register, part: Part);
    /// Whether the rates of momenta depend on momenta: a force that depends on a velocity.
    fn momenta_depend_on_momenta(&self) -> bool;
    /// Whether the rates of coordinates depend on more than momenta: on coordinates, or on the time.
    fn coordinates_depend_on_others(&self) -> bool;
}

/// What the builder tells an integrator about the laws, so that it can refuse them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Structure {
    /// States that are drifted: "bodies.position".
    pub coordinates: Vec<String>,
    /// States that are kicked, each moving a coordinate.
    pub momenta: Vec<String>,
    /// States that are neither.
    pub others: Vec<String>,
    /// Whether a force depends on a velocity.
    pub momenta_depend_on_momenta: bool,
    /// A coordinate, or the time, that a rate of a coordinate depends on, where there is one.
    pub coordinates_depend_on: Option<String>,
}

/// A method that takes a state on by one step.
pub trait Integrator: Send {
    /// Its name in scenes: "leapfrog".
    fn name(&self) -> &'static str;
    /// Its order: halving the step divides the error of a smooth problem by two to this power.
    fn order(&self) -> u32;
    /// How many vectors of its own it needs.
    fn work_vectors(&self) -> usize {
        0
    }
    /// Refuses laws that it cannot integrate.
    ///
    /// # Errors
    /// Says what it needs, and what to use instead.
    fn accept(&self, _structure: &Structure) -> Result<(), Fault> {
        Ok(())
    }
    /// What it does differently for these laws, for the report.
    fn remark(&self, _structure: &Structure) -> Option<String> {
        None
    }
    /// Takes the state on by `step`, in s, the time too.
    fn step(&mut self, system: &mut dyn System, step: f64);
    /// The state has changed from outside: nothing remembered of it holds any longer.
    fn restart(&mut self) {}
    /// Whether it remembers the last step's rates, for a checkpoint.
    fn memory(&self) -> bool {
        false
    }
    /// Goes on from a checkpoint.
    fn set_memory(&mut self, _remembers: bool) {}
}
