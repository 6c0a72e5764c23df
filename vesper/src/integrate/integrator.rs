//! What a method of integration is to the engine, and what it learns about the laws before it is taken.

use super::{StableLimits, System};
use crate::error::Fault;

/// What the builder tells an integrator about the laws, so that it can refuse them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Structure {
    /// States that are drifted: "bodies.position".
    pub coordinates: Vec<String>,
    /// States that are kicked, each moving a coordinate.
    pub momenta: Vec<String>,
    /// States that are neither.
    pub others: Vec<String>,
    /// A momentum that a rate of a momentum depends on, through the laws between: a force that depends on a velocity.
    pub momenta_depend_on_momenta: Option<String>,
    /// A coordinate, or the time, that a rate of a coordinate depends on, where there is one.
    pub coordinates_depend_on: Option<String>,
    /// Whether the laws say that the rate of every coordinate is its momentum.
    pub second_order: bool,
    /// Switches of laws, and fields with regions: where one turns, or a row leaves its region, rates jump.
    pub jumps: Vec<String>,
    /// A law that is not evaluated on every step, where there is one.
    pub every: Option<String>,
}

impl Structure {
    fn refused(integrator: &str, need: &str, found: String, mend: &str) -> Fault {
        Fault::Integrator { integrator: integrator.to_owned(), need: need.to_owned(), found, mend: mend.to_owned() }
    }

    /// Refuses laws that are not evaluated on every step: for integrators that choose their steps.
    ///
    /// # Errors
    /// There is one.
    pub fn without_every(&self, integrator: &str) -> Result<(), Fault> {
        let Some(law) = &self.every else { return Ok(()) };
        let found = format!("{law} is evaluated on some steps only");
        let mend = "leave out its `every`, or take an explicit integrator of fixed steps";
        Err(Structure::refused(integrator, "every law to be evaluated whenever it asks", found, mend))
    }

    /// Refuses states that are neither coordinates nor momenta.
    ///
    /// # Errors
    /// There is one.
    pub fn without_others(&self, integrator: &str) -> Result<(), Fault> {
        let Some(state) = self.others.first() else { return Ok(()) };
        let found = format!("{state} is neither");
        Err(Structure::refused(integrator, "every state to be a coordinate or a momentum", found, "take runge_kutta_4"))
    }

    /// Refuses forces that depend on velocities, and velocities that depend on places: a kick and a drift are then no
    /// exact solutions of their parts.
    ///
    /// # Errors
    /// There is one.
    pub fn separable(&self, integrator: &str) -> Result<(), Fault> {
        self.without_others(integrator)?;
        let need = "rates of momenta without momenta, and of coordinates without coordinates or the time";
        let mend = "take leapfrog or gauss_radau_15";
        if let Some(momentum) = &self.momenta_depend_on_momenta {
            let found = format!("a rate of a momentum depends on {momentum}");
            return Err(Structure::refused(integrator, need, found, mend));
        }
        if let Some(other) = &self.coordinates_depend_on {
            let found = format!("a rate of a coordinate depends on {other}");
            return Err(Structure::refused(integrator, need, found, mend));
        }
        Ok(())
    }
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
    /// Whether it chooses its own steps within the one it is asked for: then a frame is asked for as a whole, and the
    /// engine's step is only the first that it tries.
    fn is_adaptive(&self) -> bool {
        false
    }
    /// The first step to try, in s, where it is adaptive and has no better one.
    fn set_first_step(&mut self, _step: f64) {}
    /// Whether the rounding errors of the state are to be kept and added back, whatever the builder says.
    fn compensates(&self) -> bool {
        false
    }
    /// Whether it asks how the rates change ([`super::Linearised::derivative`]): only then is a program made for that.
    fn needs_derivatives(&self) -> bool {
        false
    }
    /// The longest step times the rate of an oscillation, and of a decay, at which neither grows; `None` where steps of any length
    /// are stable, or where it chooses its own. `second_order`: the laws say that the rate of every coordinate is its momentum.
    fn stable_limits(&self, _second_order: bool) -> Option<StableLimits> {
        None
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
    ///
    /// # Errors
    /// No step that it may take is short enough for its tolerance. The state is then the last one that it accepted.
    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault>;
    /// The state has changed from outside: nothing remembered of it holds any longer.
    fn restart(&mut self) {}
    /// What it remembers from step to step besides its vectors, for a checkpoint; nothing after a restart.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Goes on from a checkpoint.
    fn set_memory(&mut self, _memory: &[f64]) {}
}
