//! The cheapest way to an error.
//!
//! In: the runs of a study, the error that is allowed. Out: more runs, between those that nearly meet it and those that
//! do, and the cheapest of all that do. Never: a choice that was not run.

use super::findings::Findings;
use super::grid::{Grid, Keeper};
use super::measure::{Method, Run, Setting, measure};
use super::problem::Problem;

/// What a user allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// The largest error, what the answer may be wrong by counted in.
    pub error: f64,
    /// Frames in a second of the scene, each of which must not take longer than it lasts.
    pub fps: Option<f64>,
}

/// Integrators that may still win: those whose cheapest run takes at most so many times the cheapest one's time.
const NEAR: f64 = 3.0;
/// Steps or tolerances that are tried between a run that meets the budget and one that does not.
const TRIES: usize = 4;

impl Budget {
    /// Whether a run meets it.
    pub fn is_met_by(&self, run: &Run, problem: &Problem) -> bool {
        let frames = |fps: f64| problem.length() * fps;
        let in_time = self.fps.is_none_or(|fps| run.wall[0] / frames(fps) <= 1.0 / fps);
        run.broke.is_none() && run.stable && in_time && run.bound.is_some_and(|bound| bound <= self.error)
    }

    /// The cheapest run that meets it.
    pub fn choice<'f>(&self, problem: &Problem, findings: &'f Findings) -> Option<&'f Run> {
        let meets = findings.of(&problem.id).filter(|run| self.is_met_by(run, problem));
        meets.min_by(|one, other| one.wall[0].total_cmp(&other.wall[0]))
    }

    /// Tries what is between a run that meets the budget and the next coarser one, for all that may be the cheapest.
    pub fn refine(&self, grid: &Grid, problem: &Problem, runs: &[Run], keeper: &mut dyn Keeper) {
        let alike = |one: &Method, other: &Method| {
            one.integrator.name == other.integrator.name
                && (one.numbers, one.compensated, one.backend) == (other.numbers, other.compensated, other.backend)
        };
        let mut cheapest: Vec<&Run> = Vec::new();
        for run in runs.iter().filter(|run| self.is_met_by(run, problem)) {
            match cheapest.iter_mut().find(|known| alike(&known.method, &run.method)) {
                Some(known) if known.wall[0] > run.wall[0] => *known = run,
                Some(_) => {}
                None => cheapest.push(run),
            }
        }
        let best = cheapest.iter().map(|run| run.wall[0]).fold(f64::INFINITY, f64::min);
        for start in cheapest.into_iter().filter(|run| run.wall[0] <= NEAR * best) {
            let coarser = runs.iter().filter(|run| alike(&run.method, &start.method));
            let coarser = coarser.map(|run| value(&run.method)).filter(|other| *other > value(&start.method));
            let mut coarse = coarser.reduce(f64::min);
            let mut fine = value(&start.method);
            // No step is longer than the way from one comparison to the next.
            let (most, factor) = match start.method.setting {
                Setting::Step(_) => (problem.length() / problem.times.len().max(1) as f64, 2.0),
                Setting::Tolerance(_) => (1.0, 10.0),
            };
            for _ in 0..TRIES {
                if grid.is_stopped() || coarse.is_none() && fine >= most {
                    break;
                }
                let between = coarse.map_or(most.min(factor * fine), |coarse| (fine * coarse).sqrt());
                let setting = match start.method.setting {
                    Setting::Step(_) => Setting::Step(between),
                    Setting::Tolerance(_) => Setting::Tolerance(between),
                };
                let method = Method { setting, ..start.method };
                let made = keeper.made(&problem.id, &method);
                let Ok(run) = made.map_or_else(|| measure(problem, &method, &grid.patience), Ok) else { break };
                if self.is_met_by(&run, problem) {
                    fine = between;
                } else {
                    coarse = Some(between);
                }
                keeper.ran(run);
            }
        }
    }
}

fn value(method: &Method) -> f64 {
    match method.setting {
        Setting::Step(value) | Setting::Tolerance(value) => value,
    }
}
