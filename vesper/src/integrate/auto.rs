//! The integrator that the structure of the laws suggests: the accurate one, not the fastest for any one scene.
//!
//! | the laws | the integrator |
//! |---|---|
//! | are evaluated on every k-th step, and kick without looking at momenta | [`Respa`] |
//! | are evaluated on every k-th step, otherwise | [`Leapfrog`] |
//! | correct the state after each step | [`Leapfrog`] |
//! | anything else | [`GaussRadau15`], to rounding, with steps of its own |
//!
//! The choice is made when an engine is built, and stays when laws are switched on and off.
//!
//! What laws declare says neither how stiff they are nor what error a scene can bear: `vesper study` measures that.

use super::{GaussRadau15, Integrator, Leapfrog, Respa, StableLimits, Structure, System};
use crate::error::Fault;

/// Takes the integrator that the structure of the laws suggests.
pub struct Auto {
    /// That of [`GaussRadau15`], where it is chosen.
    pub precision: f64,
    chosen: Box<dyn Integrator>,
    /// Whether the laws have been seen.
    settled: bool,
}

impl core::fmt::Debug for Auto {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Auto").field("chosen", &self.chosen.name()).finish_non_exhaustive()
    }
}

impl Default for Auto {
    fn default() -> Self {
        Auto::new(GaussRadau15::default().precision)
    }
}

impl Auto {
    /// With this precision of [`GaussRadau15`], where it is chosen.
    pub fn new(precision: f64) -> Self {
        Auto { precision, chosen: Box::new(GaussRadau15::new(precision)), settled: false }
    }
}

impl Integrator for Auto {
    fn name(&self) -> &'static str {
        self.chosen.name()
    }
    fn order(&self) -> u32 {
        self.chosen.order()
    }
    fn work_vectors(&self) -> usize {
        self.chosen.work_vectors()
    }
    fn is_adaptive(&self) -> bool {
        self.chosen.is_adaptive()
    }
    fn set_first_step(&mut self, step: f64) {
        self.chosen.set_first_step(step);
    }
    fn compensates(&self, epsilon: f64) -> bool {
        self.chosen.compensates(epsilon)
    }
    fn is_beyond_f64(&self) -> bool {
        self.chosen.is_beyond_f64()
    }
    fn rotates(&self) -> bool {
        self.chosen.rotates()
    }
    fn needs_derivatives(&self) -> bool {
        self.chosen.needs_derivatives()
    }
    fn stable_limits(&self, second_order: bool) -> Option<StableLimits> {
        self.chosen.stable_limits(second_order)
    }
    fn suit(&mut self, structure: &Structure) -> bool {
        self.settled = true;
        let respa = Respa::default();
        let chosen: Box<dyn Integrator> = if structure.every.is_some() && respa.accept(structure).is_ok() {
            Box::new(respa)
        } else if structure.every.is_some() || structure.amends.is_some() {
            Box::<Leapfrog>::default()
        } else {
            Box::new(GaussRadau15::new(self.precision))
        };
        let changes = chosen.name() != self.chosen.name();
        self.chosen = chosen;
        changes
    }
    fn accept(&self, structure: &Structure) -> Result<(), Fault> {
        if self.settled { self.chosen.accept(structure) } else { Ok(()) }
    }
    fn remark(&self, structure: &Structure) -> Option<String> {
        let own = self.chosen.remark(structure).map_or(String::new(), |own| format!("; {own}"));
        let (name, order) = (self.chosen.name(), self.chosen.order());
        Some(format!("the laws suggest {name}, of order {order}{own}"))
    }
    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        self.chosen.step(system, step)
    }
    fn finish(&mut self, system: &mut dyn System) -> Result<(), Fault> {
        self.chosen.finish(system)
    }
    fn restart(&mut self) {
        self.chosen.restart();
    }
    fn memory(&self) -> Vec<f64> {
        self.chosen.memory()
    }
    fn set_memory(&mut self, memory: &[f64]) {
        self.chosen.set_memory(memory);
    }
}
