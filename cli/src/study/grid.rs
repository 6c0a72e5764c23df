//! Which runs a study makes: each integrator by coarser to finer steps or tolerances, until it gains no more.
//!
//! In: problems, and what of integrators, precisions and backends is asked for. Out: runs, one by one, to whoever keeps
//! them. Never: a run that an earlier study has already made, where its runs are given.
//!
//! Integrators of high order go first: one of low order is followed as long as it may still win, and not through minutes of
//! steps in which another one is ten times as fast. Steps at which an explicit integrator is not stable at the start are
//! refused.

use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use vesper::prelude::*;

use super::measure::{Method, Patience, Run, Setting, answer, measure};
use super::problem::Problem;
use crate::assemble::integrators::{AUTO, NamedIntegrator, integrator, methods};
use crate::run::stable;
use crate::scene::Precision as Numbers;

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Grid {
    /// The integrators.
    pub integrators: Vec<&'static NamedIntegrator>,
    /// Steps of those that take fixed ones, in s; without, halves of one that suits the problem.
    pub steps: Option<Vec<f64>>,
    /// Tolerances of adaptive ones; without, tenths.
    pub tolerances: Option<Vec<f64>>,
    /// Number types.
    pub numbers: Vec<Numbers>,
    /// Whether integrators that gain by it go on in double-double numbers, where rounding limits them in f64.
    pub widens: bool,
    /// Whether all runs are also made with rounding errors kept and added back; if not, those that rounding limits are.
    pub compensated: bool,
    /// Where laws run.
    pub backends: Vec<Backend>,
    /// An error that is small enough: an integrator that comes to it is done, and so is one that has taken longer than another
    /// one that came to it. Without, each goes on to its best.
    pub enough: Option<f64>,
    /// When to give up a run.
    pub patience: Patience,
}

impl Grid {
    /// All integrators, in f64, where the laws run by themselves; no run of more than `limit` s.
    pub fn of_all(patience: Patience) -> Self {
        Grid {
            integrators: methods().collect(),
            steps: None,
            tolerances: None,
            numbers: vec![Numbers::F64],
            widens: true,
            compensated: false,
            backends: vec![Backend::Auto],
            enough: None,
            patience,
        }
    }
}

/// An integrator that refuses a problem's laws.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// The name of the problem.
    pub case: String,
    /// The integrator's name.
    pub integrator: String,
    /// Whether it is only the longer steps that it cannot take.
    pub longer_steps: bool,
    /// Why.
    pub reason: String,
}

/// What a study tells on its way, and what it asks.
pub trait Keeper {
    /// A run that has been made before, by the same method.
    fn made(&self, _case: &str, _method: &Method) -> Option<Run> {
        None
    }
    /// An integrator begins with a problem.
    fn begins(&mut self, _problem: &Problem, _integrator: &str) {}
    /// It is done with it.
    fn ended(&mut self) {}
    /// A run is done.
    fn ran(&mut self, run: Run);
    /// A run that is known has other times now, which were taken with more care.
    fn timed(&mut self, again: Run);
    /// A problem has an answer now that had none, or has none, for this reason.
    fn answered(&mut self, _problem: &Problem, _answer: Result<(), String>) {}
    /// An integrator cannot.
    fn refused(&mut self, refusal: Refusal);
}

/// How much longer a run may take that makes an answer.
const ANSWER_PATIENCE: f64 = 30.0;
/// How much longer than a run all runs of a problem may take; the second where the pilot says how long a run may take.
const WHOLE: f64 = 25.0;
const WHOLE_LONG: f64 = 2.5;
/// How much longer than the pilot a run may take, where that is more than asked for.
const LONGER: f64 = 4.0;
/// Runs that come no nearer to the answer, after which an integrator is at its best.
const STALLED: usize = 2;
/// Errors, in f64 and f32, above which a run that came no nearer says nothing: its steps do not yet resolve the motion.
const RESOLVED: [f64; 2] = [1e-5, 1e-2];
/// What rounding may leave of an answer before more digits than f64 are tried.
const LEFT: f64 = 1e-12;
/// A run that is so many times as fast as another one, and as near to the answer, ends that one's integrator.
const BEATEN: f64 = 10.0;
/// Times of what comes to an error that is enough, after which one that has not come to it is given up: more than 1, as clocks
/// are unsure.
const LATE: f64 = 2.0;
/// The steps in one that the pilot takes: the first one that is tried is so much longer.
const COARSER: f64 = 8.0;

/// The methods that make an answer where there is none.
pub fn makers() -> Vec<Method> {
    let maker = |(name, tolerance): (&str, f64)| {
        let setting = Setting::Tolerance(tolerance);
        let known = integrator(name)?;
        Some(Method { integrator: known, setting, numbers: Numbers::F64, compensated: true, backend: Backend::Auto })
    };
    let makers = [("gauss_radau_15", 1e-7), ("dormand_prince_8", 1e-13), ("dormand_prince_5", 1e-12)];
    makers.into_iter().filter_map(maker).collect()
}

impl Grid {
    pub(super) fn is_stopped(&self) -> bool {
        self.patience.stop.load(Ordering::Relaxed)
    }

    /// Studies a problem.
    pub fn study(&self, problem: &mut Problem, keeper: &mut dyn Keeper) {
        if problem.answer.is_none() {
            keeper.begins(problem, "an answer");
            let patience = Patience { limit: self.patience.limit * ANSWER_PATIENCE, ..self.patience.clone() };
            let made = answer(problem, &makers(), &patience);
            let told = made.map(|answer| problem.answer = Some(answer));
            keeper.answered(problem, told);
        }
        let (first, patience) = self.first_step(problem);
        let whole = (WHOLE * self.patience.limit).max(WHOLE_LONG * patience.limit).min(1e9);
        let end = Instant::now() + Duration::from_secs_f64(whole);
        let mut integrators = self.integrators.clone();
        integrators.sort_by_key(|known| core::cmp::Reverse((known.make)(&|_, usual| usual).order()));
        let mut enough = f64::INFINITY;
        for &numbers in &self.numbers {
            for &backend in &self.backends {
                let known = Vec::new();
                let mut climb =
                    Climb { grid: self, problem, patience: &patience, end, known, enough: &mut enough, keeper };
                for &integrator in &integrators {
                    if self.is_stopped() {
                        return;
                    }
                    climb.keeper.begins(problem, integrator.name);
                    let setting = Setting::Step(first);
                    let plain = Method { integrator, setting, numbers, compensated: false, backend };
                    let kept = Method { compensated: true, ..plain };
                    let wide = Method { numbers: Numbers::DoubleDouble, ..plain };
                    let made = (integrator.make)(&|_, usual| usual);
                    let widens = self.widens && numbers == Numbers::F64 && made.is_beyond_f64();
                    // Double-double numbers have no rounding errors to keep.
                    let keeps = numbers != Numbers::DoubleDouble && !made.compensates(f64::EPSILON);
                    let mut climbs = || {
                        let floor = climb.up(plain, 0)?;
                        match &floor {
                            _ if self.compensated && numbers != Numbers::DoubleDouble => _ = climb.up(kept, 0)?,
                            Some(floor) if keeps => _ = climb.up(kept, floor.rung)?,
                            _ => {}
                        }
                        if let Some(floor) = floor.filter(|floor| widens && floor.error > LEFT) {
                            climb.up(wide, floor.rung)?;
                        }
                        Ok::<(), String>(())
                    };
                    let done = climbs();
                    if let Err(reason) = done {
                        let (case, integrator) = (problem.id.clone(), integrator.name.to_owned());
                        climb.keeper.refused(Refusal { case, integrator, longer_steps: false, reason });
                    }
                    climb.keeper.ended();
                }
            }
        }
    }

    /// The longest step to try, in s: some power of two by the scene's own; without one, by the mean step of an adaptive
    /// integrator at a loose tolerance. And how long a run of this problem may take: longer than usual where that integrator
    /// itself does.
    fn first_step(&self, problem: &Problem) -> (f64, Patience) {
        let patience = Patience { limit: self.patience.limit * ANSWER_PATIENCE, ..self.patience.clone() };
        let pilot = integrator("dormand_prince_5").and_then(|known| {
            let (setting, numbers) = (Setting::Tolerance(1e-3), Numbers::F64);
            let method = Method { integrator: known, setting, numbers, compensated: false, backend: Backend::Auto };
            measure(problem, &method, &patience).ok()
        });
        let pilot = pilot.filter(|run| run.broke.is_none());
        let limit = pilot.as_ref().map_or(0.0, |run| LONGER * run.wall[0]).max(self.patience.limit);
        let patience = Patience { limit, ..patience };
        let steps = pilot.map_or(1000, |run| run.steps.max(1));
        let step = problem.step.map_or_else(|| plain(COARSER * problem.length() / steps as f64), |step| COARSER * step);
        (step, patience)
    }

    /// The setting of a rung; `None` where there are no more.
    fn setting(&self, method: &Method, adaptive: bool, first: f64, rung: usize) -> Option<Setting> {
        if adaptive {
            let tenths = match (method.integrator.options[0], method.numbers) {
                ("rtol", Numbers::F64) => 3..=14,
                ("rtol", Numbers::F32) => 2..=7,
                ("rtol", Numbers::DoubleDouble) => 3..=20,
                // The parts of the highest term, which shrinks with the seventh power of the step.
                (_, Numbers::F64) => 0..=8,
                (_, Numbers::F32) => 0..=4,
                (_, Numbers::DoubleDouble) => 0..=12,
            };
            // What is chosen for everybody is not made coarser than it is.
            let coarsest = if method.integrator.name == AUTO { -usual(method).log10().round() as i32 } else { 0 };
            let tenths = *tenths.start().max(&coarsest.min(*tenths.end()))..=*tenths.end();
            let tolerance = match &self.tolerances {
                Some(given) => *given.get(rung)?,
                None => tenths.map(|tenths| 10f64.powi(-tenths)).nth(rung)?,
            };
            return Some(Setting::Tolerance(tolerance));
        }
        let step = match &self.steps {
            Some(given) => *given.get(rung)?,
            // No clock tells shorter ones apart.
            None => Some(first / 2f64.powi(rung as i32)).filter(|_| rung < 40)?,
        };
        Some(Setting::Step(step))
    }
}

/// A problem that integrators are tried on.
struct Climb<'a> {
    grid: &'a Grid,
    problem: &'a Problem,
    patience: &'a Patience,
    /// When there is no more time for this problem.
    end: Instant,
    /// Times and errors of the runs up to now.
    known: Vec<[f64; 2]>,
    /// The shortest time of a run that came to an error that is enough.
    enough: &'a mut f64,
    keeper: &'a mut dyn Keeper,
}

/// Where an integrator is at its best.
struct Floor {
    /// The rung behind which it comes no nearer.
    rung: usize,
    error: f64,
}

impl Climb<'_> {
    /// One integrator, from a rung on to finer ones. Where it comes no nearer, if it comes there.
    fn up(&mut self, method: Method, from: usize) -> Result<Option<Floor>, String> {
        let Climb { grid, problem, .. } = *self;
        let limit = self.patience.limit;
        let made = (method.integrator.make)(&|_, usual| usual);
        let adaptive = made.is_adaptive();
        let Setting::Step(first) = method.setting else { return Ok(None) };
        if method.integrator.name == AUTO {
            method.suggests_an_adaptive_one(problem)?;
        }
        let usual = usual(&method);
        let stable = if adaptive { None } else { method.longest(problem) };
        let mut told = method.compensated;
        let given = if adaptive { grid.tolerances.is_some() } else { grid.steps.is_some() };
        let resolved = RESOLVED[usize::from(method.numbers == Numbers::F32)];
        let (mut best, mut nearest, mut stalled, mut before) = (f64::INFINITY, from, 0, 0.0);
        for rung in from.. {
            let Some(setting) = grid.setting(&method, adaptive, first, rung) else {
                // Nothing finer is left in f64.
                let left = made.is_beyond_f64() && best.is_finite() && !given;
                return Ok(left.then_some(Floor { rung: nearest, error: best }));
            };
            let method = Method { setting, ..method };
            if let (Some(stable), Setting::Step(step)) = (&stable, setting)
                && let Some(text) = stable::too_long(method.integrator.name, step, stable)
            {
                // Said once, and not of what comes between: only the state at the start is looked at.
                if !core::mem::replace(&mut told, true) {
                    let (case, integrator) = (problem.id.clone(), method.integrator.name.to_owned());
                    self.keeper.refused(Refusal { case, integrator, longer_steps: true, reason: text });
                }
                continue;
            }
            let run = match self.keeper.made(&problem.id, &method) {
                Some(run) => run,
                None if Instant::now() > self.end => {
                    return Err("not tried: the time for this problem is up".to_owned());
                }
                None => measure(problem, &method, self.patience)?,
            };
            if grid.is_stopped() {
                return Ok(None);
            }
            let (error, wall) = (run.error, run.wall[0]);
            let gave_up = run.broke.is_some() && wall > limit;
            let comes_to = |enough: f64| run.stable && run.bound.is_some_and(|bound| bound <= enough);
            if !given && grid.enough.is_some_and(comes_to) {
                *self.enough = self.enough.min(wall);
                self.keeper.ran(run);
                return Ok(None);
            }
            let late = run.wall[1] > LATE * *self.enough;
            self.keeper.ran(run);
            if let Some(error) = error {
                stalled = if error < 0.7 * best { 0 } else { stalled + 1 };
                if error < best {
                    (best, nearest) = (error, rung);
                }
                self.known.push([wall, error]);
            }
            // At loose tolerances it may be something else that limits a step, and all runs are alike; or bodies meet that
            // would have missed each other, and no step is short enough.
            let usual_yet = !matches!(setting, Setting::Tolerance(tolerance) if tolerance > usual);
            if gave_up && !usual_yet {
                continue;
            }
            // What the next one will take, if it grows as it did.
            let next = wall * if rung == from { 2.0 } else { (wall / f64::max(before, 1e-9)).clamp(1.0, 2.0) };
            before = wall;
            if stalled >= STALLED && best < resolved && usual_yet && !given {
                return Ok(Some(Floor { rung: rung - stalled, error: best }));
            }
            // What it may come to, if its order holds.
            let hoped = best * 0.5f64.powi(made.order().min(50) as i32);
            let beaten = !adaptive && self.known.iter().any(|[wall, error]| wall * BEATEN < next && *error <= hoped);
            if gave_up || !given && (beaten || late || next > limit) {
                return Ok(None);
            }
        }
        Ok(None)
    }
}

/// The tolerance of an adaptive integrator as it is.
fn usual(method: &Method) -> f64 {
    let found = core::cell::Cell::new(f64::INFINITY);
    let first = method.integrator.options.first();
    _ = (method.integrator.make)(&|name, usual| {
        if first == Some(&name) {
            found.set(usual);
        }
        usual
    });
    found.get()
}

/// The next lower of 1, 2, 5 times a power of ten.
fn plain(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    let digit = [5.0, 2.0, 1.0].into_iter().find(|digit| digit * power <= step * (1.0 + 1e-12)).unwrap_or(1.0);
    digit * power
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn plain_steps() {
        assert_eq!([0.37, 1.0, 9.9, 2e-3, 55.0].map(plain), [0.2, 1.0, 5.0, 2e-3, 50.0]);
    }
}
