//! What a method of integration is to the engine, and what it learns about the laws before it is taken.

use super::{StableLimits, System};
use crate::error::Fault;

const SEPARABLE: &str = "rates of momenta without momenta, and of coordinates without coordinates or the time";
const SECOND_ORDER: &str = "the rate of every coordinate to be its momentum";
const MEND: &str = "take leapfrog or gauss_radau_15";

/// What the builder tells an integrator about the laws, so that it can refuse them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Structure {
    /// States that are drifted: "bodies.position".
    pub coordinates: Vec<String>,
    /// How many rows each of them has.
    pub rows: Vec<usize>,
    /// States that are kicked, each moving a coordinate.
    pub momenta: Vec<String>,
    /// States that are neither.
    pub others: Vec<String>,
    /// A momentum that a rate of a momentum depends on, through the laws between: a force that depends on a velocity.
    pub momenta_depend_on_momenta: Option<String>,
    /// Momenta that forces turn without changing their magnitude, as magnetic ones do: laws add to a turn.
    pub turned: Vec<String>,
    /// A momentum that a rate of a momentum depends on by more than being turned.
    pub depends_beyond_turning: Option<String>,
    /// A coordinate, or the time, that a rate of a coordinate depends on, where there is one.
    pub coordinates_depend_on: Option<String>,
    /// Whether the laws say that the rate of every coordinate is its momentum.
    pub second_order: bool,
    /// Switches of laws, and fields with regions: where one turns, or a row leaves its region, rates jump.
    pub jumps: Vec<String>,
    /// A law that is not evaluated on every step, where there is one.
    pub every: Option<String>,
    /// The parameters of the laws that run, each with its value: "henon_heiles.lambda". Those that are vectors are not among
    /// them.
    pub parameters: Vec<(String, f64)>,
    /// A law that corrects the state after each step, where there is one.
    pub amends: Option<String>,
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
        let mend = "leave out its `every`, or take respa";
        Err(Structure::refused(integrator, "every law to be evaluated whenever it asks", found, mend))
    }

    /// Refuses switches of laws and fields with regions, at which a step would have to end.
    ///
    /// # Errors
    /// There is one.
    pub fn without_jumps(&self, integrator: &str) -> Result<(), Fault> {
        let Some(jump) = self.jumps.first() else { return Ok(()) };
        let mend = "take leapfrog, or an adaptive integrator";
        Err(Structure::refused(integrator, "rates that do not jump", format!("they jump with {jump}"), mend))
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
        self.drifts(integrator)?;
        let Some(momentum) = &self.momenta_depend_on_momenta else { return Ok(()) };
        let found = format!("a rate of a momentum depends on {momentum}");
        let mend = if self.depends_beyond_turning.is_none() { "take boris or gauss_radau_15" } else { MEND };
        Err(Structure::refused(integrator, SEPARABLE, found, mend))
    }

    /// Refuses forces that depend on velocities otherwise than by turning them, and velocities that depend on places.
    ///
    /// # Errors
    /// There is one.
    pub fn separable_but_for_turning(&self, integrator: &str) -> Result<(), Fault> {
        self.drifts(integrator)?;
        let Some(momentum) = &self.depends_beyond_turning else { return Ok(()) };
        let found = format!("a rate of a momentum depends on {momentum}, and not by a law's turn alone");
        let need = "rates of momenta without momenta, but for what turns them";
        Err(Structure::refused(integrator, need, found, MEND))
    }

    /// Refuses coordinates whose rates may be others than their momenta.
    ///
    /// # Errors
    /// There may be some.
    pub fn of_second_order(&self, integrator: &str) -> Result<(), Fault> {
        if self.second_order {
            return Ok(());
        }
        let found = "no law says so".to_owned();
        Err(Structure::refused(integrator, SECOND_ORDER, found, "take gauss_radau_15, or laws of `second_order`"))
    }

    /// The fault of a row whose coordinate does not move by its momentum, though the laws say that it does.
    pub(super) fn rows_do_not_follow(integrator: &str) -> Fault {
        let found = "some rows have momenta that do not move them".to_owned();
        Structure::refused(integrator, SECOND_ORDER, found, "set these to zero, or take gauss_radau_15")
    }

    /// Refuses states that are neither coordinates nor momenta, and velocities that depend on places.
    fn drifts(&self, integrator: &str) -> Result<(), Fault> {
        self.without_others(integrator)?;
        let Some(other) = &self.coordinates_depend_on else { return Ok(()) };
        let found = format!("a rate of a coordinate depends on {other}");
        Err(Structure::refused(integrator, SEPARABLE, found, MEND))
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
    /// Whether the rounding errors of the state are to be kept and added back, whatever the builder says. `epsilon`: the distance
    /// from 1 to the next number of the state's precision.
    fn compensates(&self, _epsilon: f64) -> bool {
        false
    }
    /// Whether its tables have more digits than f64, so that a state in double-double numbers gains by it.
    fn is_beyond_f64(&self) -> bool {
        false
    }
    /// Whether every step makes the same calls on the system in the same order, whatever the values. Then `explain` can foretell what a step moves
    /// to and from a device, by steps on a system whose values are all 0. `false` costs that forecast, and nothing else.
    fn steps_alike(&self) -> bool {
        false
    }
    /// Whether it asks for what turns momenta apart from their other rates.
    fn rotates(&self) -> bool {
        false
    }
    /// Makes itself fit for the laws, when an engine is built. Whether it is another one now.
    fn suit(&mut self, _structure: &Structure) -> bool {
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
    /// Brings the state to the end of the last step, where steps leave it behind: asked before anybody looks at it. The time
    /// is that of the end already, and stays.
    ///
    /// # Errors
    /// As [`Integrator::step`].
    fn finish(&mut self, _system: &mut dyn System) -> Result<(), Fault> {
        Ok(())
    }
    /// The state has changed from outside: nothing remembered of it holds any longer.
    fn restart(&mut self) {}
    /// What it remembers from step to step besides its vectors, for a checkpoint; nothing after a restart.
    fn memory(&self) -> Vec<f64> {
        Vec::new()
    }
    /// Goes on from a checkpoint.
    fn set_memory(&mut self, _memory: &[f64]) {}
}
