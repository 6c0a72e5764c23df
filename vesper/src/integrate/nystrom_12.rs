//! The Runge-Kutta-Nystroem method of Dormand, El-Mikkawy and Prince of order 12, with an error of order 10.
//!
//! Order 12, seventeen evaluations per step; the step follows the tolerance, and the higher order is kept. It integrates places
//! twice: for forces that depend on places and the time alone, and coordinates whose rates are their momenta; others are
//! refused. The state is compensated where the tolerance comes near its rounding errors. The fastest adaptive method for smooth problems of this kind at errors from 1e-4 down to
//! rounding. Frames end with a step. Not symplectic: for millions of orbits `gauss_radau_15` loses less energy; not for stiff
//! laws.
//!
//! The next step goes on from the last two errors and lengths: on the way into a close encounter each step has to be shorter
//! than the one before, by a factor that the step before foretells (Gustafsson, ACM TOMS 20 (1994) 496; Hairer, Wanner,
//! Solving Ordinary Differential Equations II, 2nd ed. (1996), eq. IV.8.25).
//!
//! Source: Dormand, El-Mikkawy, Prince, High-order embedded Runge-Kutta-Nystrom formulae, IMA J. Numer. Anal. 7 (1987) 423,
//! RKN12(10)17M.

use super::adaptive::Control;
use super::embedded::{Progress, START, Scheme, slope, slopes};
use super::nystrom_12_table::{MOMENTA, MOMENTUM_ERRORS, PLACE_ERRORS, PLACES, STAGES};
use super::{Combination, Integrator, Register, Structure, System, Terms, Tolerance};
use crate::error::Fault;
use crate::law::Part;

/// Runge-Kutta-Nystroem of order 12: adaptive, for forces that do not depend on velocities.
#[derive(Clone, Copy, Debug)]
pub struct Nystrom12 {
    /// What error a step may have.
    pub tolerance: Tolerance,
    progress: Progress,
    /// Whether the rate of every coordinate is its momentum, where that is known.
    follows: Option<bool>,
}

impl Nystrom12 {
    /// With this tolerance.
    pub fn new(tolerance: Tolerance) -> Self {
        Nystrom12 { tolerance, progress: Progress::default(), follows: None }
    }
}

impl Default for Nystrom12 {
    fn default() -> Self {
        Nystrom12::new(Tolerance::relative(1e-12))
    }
}

const NAME: &str = "nystrom_12";
/// The error of the step.
const ERROR: Register = slope(STAGES.len() + 1);

impl Integrator for Nystrom12 {
    fn name(&self) -> &'static str {
        NAME
    }

    fn order(&self) -> u32 {
        12
    }

    fn work_vectors(&self) -> usize {
        STAGES.len() + 3
    }

    fn is_adaptive(&self) -> bool {
        true
    }

    fn set_first_step(&mut self, step: f64) {
        self.progress.steps.first = Some(step);
    }

    fn compensates(&self, epsilon: f64) -> bool {
        self.tolerance.comes_near(epsilon)
    }

    fn accept(&self, structure: &Structure) -> Result<(), Fault> {
        structure.without_every(NAME)?;
        structure.separable(NAME)?;
        structure.of_second_order(NAME)
    }

    fn step(&mut self, system: &mut dyn System, step: f64) -> Result<(), Fault> {
        if !*self.follows.get_or_insert_with(|| system.coordinates_follow_momenta()) {
            return Err(Structure::rows_do_not_follow(NAME));
        }
        self.progress.cover((&Pair, &self.tolerance), system, step)
    }

    fn restart(&mut self) {
        self.follows = None;
        self.progress.restart();
    }

    fn memory(&self) -> Vec<f64> {
        self.progress.memory()
    }

    fn set_memory(&mut self, memory: &[f64]) {
        self.progress.set_memory(memory);
    }
}

/// Both orders.
struct Pair;

impl Pair {
    /// Leaves a sum over the rates of momenta in a vector: of coordinates, which the momenta at the start move by `time`, too, and
    /// of momenta.
    fn coordinates(system: &mut dyn System, to: Register, weights: &[f64], (time, step): (f64, f64), adds: bool) {
        let start = [(time, START)];
        let momenta = slopes(weights, step * step).and(if time == 0.0 { &[] } else { &start });
        let terms = if to == Register::State && !adds { const { &[(1.0, START)] } } else { &[][..] };
        system.linear(Combination { to, adds, part: Part::Coordinates, terms: Terms::of(terms), momenta });
    }

    /// Leaves a sum over the rates of momenta, and some others, in a vector.
    fn momenta(system: &mut dyn System, to: Register, terms: Terms<'_>, adds: bool) {
        system.linear(Combination { to, adds, part: Part::Momenta, terms, momenta: Terms::NONE });
    }
}

impl Scheme for Pair {
    fn name(&self) -> &'static str {
        NAME
    }

    fn control(&self) -> &Control {
        &Control { order: 11, beta: 0.0, limits: [0.2, 4.0], foresees: true }
    }

    fn last_slope(&self) -> Option<Register> {
        None
    }

    fn end(&self) -> Option<Register> {
        None
    }

    fn try_step(&self, system: &mut dyn System, time: f64, step: f64) {
        for (number, (when, far)) in STAGES.iter().enumerate() {
            Pair::coordinates(system, Register::State, far, (when * step, step), false);
            system.set_time(time + when * step);
            system.evaluate_to(slope(number + 1), Part::Momenta);
        }
        Pair::coordinates(system, Register::State, PLACES, (step, step), false);
        Pair::momenta(system, Register::State, slopes(MOMENTA, step).and(&[(1.0, START)]), false);
    }

    fn excess(&self, system: &mut dyn System, tolerance: &Tolerance, step: f64) -> f64 {
        Pair::coordinates(system, ERROR, PLACE_ERRORS, (0.0, step), false);
        Pair::momenta(system, ERROR, slopes(MOMENTUM_ERRORS, step), false);
        tolerance.excess(system, [ERROR], |[error]| error, (START, slope(0), step))
    }

    fn take(&self, system: &mut dyn System, step: f64) {
        Pair::coordinates(system, Register::State, PLACES, (step, step), true);
        Pair::momenta(system, Register::State, slopes(MOMENTA, step), true);
    }
}
