//! The cheapest way to an error.
//!
//! In: the runs of a study, the error that is allowed. Out: more runs, between those that nearly meet it and those that
//! do, and the cheapest of all that do. Never: a choice that was not run.
//!
//! Ways differ in what cannot be compared but by a clock: the integrator, the number type, whether rounding errors are kept.
//! Runs of one way differ in their steps alone, and evaluations tell which is cheaper: no clock is as sure.

use super::findings::Findings;
use super::grid::{Grid, Keeper};
use super::measure::{Method, Patience, Run, Setting, measure};
use super::problem::Problem;
use super::race::race;

/// What a user allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// The largest error, what the answer may be wrong by counted in.
    pub error: f64,
    /// Frames in a second of the scene, each of which must not take longer than it lasts.
    pub fps: Option<f64>,
}

/// Ways that may still win, before and after steps between their own are tried: those whose cheapest run takes at most so
/// many times the cheapest one's time.
const NEAR: [f64; 2] = [3.0, 1.6];
/// Steps or tolerances that are tried between a run that meets the budget and one that does not.
const TRIES: usize = 4;
/// Coarser ones that are tried beyond, since errors do not grow evenly; each is this part of a half or a tenth.
const BEYOND: [usize; 2] = [4, 4];
/// Times of the usual that a run may take which is between two that have been made.
const LONGER: f64 = 4.0;
/// No round of runs of those that are left, by turns, begins after this time, in s.
const RACE: f64 = 1.0;

impl Budget {
    /// Whether a run meets it.
    pub fn is_met_by(&self, run: &Run, problem: &Problem) -> bool {
        let frames = |fps: f64| problem.length() * fps;
        let in_time = self.fps.is_none_or(|fps| run.wall[0] / frames(fps) <= 1.0 / fps);
        run.broke.is_none() && run.stable && in_time && run.bound.is_some_and(|bound| bound <= self.error)
    }

    /// The cheapest run that meets it: of each way the one with the fewest evaluations, of these the one with the shortest
    /// time. Other work on the machine makes times longer, never shorter; and those that were timed by turns may have been
    /// so in a worse minute than the others.
    pub fn choice<'f>(&self, problem: &Problem, findings: &'f Findings) -> Option<&'f Run> {
        let cheapest = self.cheapest(problem, findings.of(&problem.id));
        cheapest.into_iter().min_by(|one, other| one.wall[1].total_cmp(&other.wall[1]))
    }

    /// Of each way the run with the fewest evaluations that meets it; of several, the nearest.
    fn cheapest<'r>(&self, problem: &Problem, runs: impl Iterator<Item = &'r Run>) -> Vec<&'r Run> {
        let key = |run: &Run| (run.evaluations, run.error.unwrap_or(f64::INFINITY));
        let mut cheapest: Vec<&Run> = Vec::new();
        for run in runs.filter(|run| self.is_met_by(run, problem)) {
            match cheapest.iter_mut().find(|known| alike(&known.method, &run.method)) {
                Some(known) if key(run) < key(known) => *known = run,
                Some(_) => {}
                None => cheapest.push(run),
            }
        }
        cheapest
    }

    /// Those of them that take at most so many times the time of the fastest.
    fn near(&self, problem: &Problem, runs: &[Run], times: f64) -> Vec<Run> {
        let cheapest = self.cheapest(problem, runs.iter());
        let best = cheapest.iter().map(|run| run.wall[1]).fold(f64::INFINITY, f64::min);
        cheapest.into_iter().filter(|run| run.wall[1] <= times * best).cloned().collect()
    }

    /// Tries what is between a run that meets the budget and the next coarser one, and a little beyond, for all that may be
    /// the cheapest; those that are left are timed by turns.
    pub fn refine(&self, grid: &Grid, problem: &Problem, mut runs: Vec<Run>, keeper: &mut dyn Keeper) {
        for start in self.near(problem, &runs, NEAR[0]) {
            self.between(&start, grid, problem, &mut runs, keeper);
        }
        for start in self.near(problem, &runs, NEAR[1]) {
            self.beyond(&start, grid, problem, &mut runs, keeper);
        }
        let last = self.near(problem, &runs, NEAR[1]);
        if last.iter().any(|run| keeper.made(&problem.id, &run.method).is_none()) {
            again(last, grid, problem, keeper);
        }
    }

    /// Halves what is between the coarsest run of a way that meets the budget and the next one, which does not.
    fn between(&self, start: &Run, grid: &Grid, problem: &Problem, runs: &mut Vec<Run>, keeper: &mut dyn Keeper) {
        let coarser = runs.iter().filter(|run| alike(&run.method, &start.method)).map(|run| value(&run.method));
        let mut fine = value(&start.method);
        let mut coarse = coarser.filter(|other| *other > fine).reduce(f64::min);
        let [most, factor] = range(start, problem);
        for _ in 0..TRIES {
            if coarse.is_none() && fine >= most {
                break;
            }
            let between = coarse.map_or(most.min(factor * fine), |coarse| (fine * coarse).sqrt());
            match self.attempt(start, between, grid, problem, runs, keeper) {
                Some(true) => fine = between,
                Some(false) => coarse = Some(between),
                None => break,
            }
        }
    }

    /// Goes on where errors should be too large: some are not.
    fn beyond(&self, start: &Run, grid: &Grid, problem: &Problem, runs: &mut Vec<Run>, keeper: &mut dyn Keeper) {
        let [most, factor] = range(start, problem);
        let [count, parts] = BEYOND;
        for number in 1..=count {
            let next = value(&start.method) * factor.powf(number as f64 / parts as f64);
            if next > most || self.attempt(start, next, grid, problem, runs, keeper).is_none() {
                break;
            }
        }
    }

    /// Runs a way with another step or tolerance; whether that meets the budget. `None` where it cannot be told.
    fn attempt(
        &self,
        start: &Run,
        value: f64,
        grid: &Grid,
        problem: &Problem,
        runs: &mut Vec<Run>,
        keeper: &mut dyn Keeper,
    ) -> Option<bool> {
        let setting = match start.method.setting {
            Setting::Step(_) => Setting::Step(value),
            Setting::Tolerance(_) => Setting::Tolerance(value),
        };
        let method = Method { setting, ..start.method };
        if let Some(known) = runs.iter().find(|run| run.method.is(&method)) {
            return Some(self.is_met_by(known, problem));
        }
        let made = keeper.made(&problem.id, &method);
        let run = match made {
            Some(run) => run,
            None if grid.is_stopped() => return None,
            None => measure(problem, &method, &patience(grid, start.wall[2])).ok()?,
        };
        let met = self.is_met_by(&run, problem);
        runs.push(run.clone());
        keeper.ran(run);
        Some(met)
    }
}

/// Takes the times of runs again, by turns.
fn again(last: Vec<Run>, grid: &Grid, problem: &Problem, keeper: &mut dyn Keeper) {
    if grid.is_stopped() || last.len() < 2 {
        return;
    }
    let methods: Vec<Method> = last.iter().map(|run| run.method).collect();
    let longest = last.iter().map(|run| run.wall[2]).fold(0.0, f64::max);
    // Without times of one race, those of the runs are as good as there are.
    let Ok(walls) = race(problem, &methods, &patience(grid, longest), RACE) else { return };
    for (run, wall) in last.into_iter().zip(walls) {
        keeper.timed(Run { wall, ..run });
    }
}

/// Whether two methods differ in their steps or tolerances alone.
fn alike(one: &Method, other: &Method) -> bool {
    one.integrator.name == other.integrator.name
        && (one.numbers, one.compensated, one.backend) == (other.numbers, other.compensated, other.backend)
}

/// The coarsest step or tolerance; what one is multiplied by for a coarser one.
fn range(run: &Run, problem: &Problem) -> [f64; 2] {
    match run.method.setting {
        // No step is longer than the way from one comparison to the next.
        Setting::Step(_) => {
            let starts = [problem.start].into_iter().chain(problem.times.iter().copied());
            [starts.zip(&problem.times).map(|(start, end)| end - start).fold(0.0, f64::max), 2.0]
        }
        Setting::Tolerance(_) => [1.0, 10.0],
    }
}

/// Enough for a run that is alike to one that took `wall` s.
fn patience(grid: &Grid, wall: f64) -> Patience {
    Patience { limit: grid.patience.limit.max(LONGER * wall), ..grid.patience.clone() }
}

fn value(method: &Method) -> f64 {
    match method.setting {
        Setting::Step(value) | Setting::Tolerance(value) => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assemble::integrators::integrator;
    use crate::scene::Precision as Numbers;
    use crate::study::grid::Refusal;
    use crate::study::problem::tests::a_case;
    use vesper::prelude::Backend;

    fn a_run(name: &str, step: f64, evaluations: u64, wall: f64, error: f64) -> Run {
        let method = Method {
            integrator: integrator(name).unwrap(),
            setting: Setting::Step(step),
            numbers: Numbers::F64,
            compensated: false,
            backend: Backend::Auto,
        };
        Run {
            case: "kepler_e0.9".to_owned(),
            method,
            wall: [wall; 3],
            evaluations,
            steps: evaluations,
            rejected: 0,
            error: Some(error),
            bound: Some(error),
            by_floor: None,
            drift: Vec::new(),
            stable: true,
            broke: None,
        }
    }

    #[test]
    fn evaluations_choose_the_step_and_the_clock_the_integrator() {
        let problem = a_case("kepler_e0.9");
        let runs = vec![
            // Some other work held up the coarser one.
            a_run("leapfrog", 0.1, 10, 5e-3, 1e-4),
            a_run("leapfrog", 0.05, 20, 2e-3, 1e-5),
            a_run("leapfrog", 0.2, 5, 1e-3, 1e-1),
            a_run("midpoint", 0.1, 8, 6e-3, 1e-4),
        ];
        let findings = Findings { runs, ..Findings::default() };
        let choice = |error: f64| {
            let choice = Budget { error, fps: None }.choice(&problem, &findings);
            choice.map(|run| (run.method.integrator.name, run.evaluations))
        };
        assert_eq!(choice(1e-3), Some(("leapfrog", 10)));
        assert_eq!(choice(2e-5), Some(("leapfrog", 20)));
        assert_eq!(choice(1e-6), None);
    }

    #[test]
    fn the_clock_looks_at_the_shortest_time() {
        let problem = a_case("kepler_e0.9");
        let held_up = Run { wall: [4e-3, 1e-3, 9e-3], ..a_run("leapfrog", 0.1, 10, 0.0, 1e-4) };
        let other = a_run("midpoint", 0.1, 10, 2e-3, 1e-4);
        let findings = Findings { runs: vec![other, held_up], ..Findings::default() };
        let choice =
            Budget { error: 1e-3, fps: None }.choice(&problem, &findings).map(|run| run.method.integrator.name);
        assert_eq!(choice, Some("leapfrog"));
    }

    #[derive(Default)]
    struct Log(Findings, usize);

    impl Keeper for Log {
        fn ran(&mut self, run: Run) {
            self.0.runs.push(run);
        }
        fn timed(&mut self, again: Run) {
            self.1 += 1;
            self.0.time(again);
        }
        fn refused(&mut self, refusal: Refusal) {
            panic!("{refusal:?}");
        }
    }

    /// What a study of some integrators finds, and who is left of it.
    fn studied(problem: &mut Problem, budget: &Budget, names: &[&str]) -> (Grid, Log) {
        let integrators = names.iter().map(|name| integrator(name).unwrap()).collect();
        // No clock ends these runs.
        let patience = Patience { limit: 100.0, ..Patience::default() };
        let grid = Grid { integrators, enough: Some(budget.error), ..Grid::of_all(patience) };
        let mut log = Log::default();
        grid.study(problem, &mut log);
        (grid, log)
    }

    #[test]
    fn between_the_runs_of_a_study_is_a_cheaper_one() {
        let budget = Budget { error: 1e-8, fps: None };
        for name in ["dormand_prince_8", "symplectic_6"] {
            let mut problem = a_case("figure_eight");
            let (grid, mut log) = studied(&mut problem, &budget, &[name]);
            // The integrator is done once it meets the error.
            let met: Vec<bool> = log.0.runs.iter().map(|run| budget.is_met_by(run, &problem)).collect();
            assert!(met.len() > 1 && met.iter().position(|met| *met) == Some(met.len() - 1), "{name}: {met:?}");
            let before = budget.choice(&problem, &log.0).unwrap().evaluations;
            budget.refine(&grid, &problem, log.0.runs.clone(), &mut log);
            let choice = budget.choice(&problem, &log.0).unwrap();
            assert!(choice.evaluations < before && choice.error <= Some(1e-8), "{name}: {choice:?}, {before} before");
            // There was nobody to race with.
            assert_eq!(log.1, 0);
        }
    }

    #[test]
    fn those_that_are_left_are_timed_by_turns() {
        let budget = Budget { error: 1e-8, fps: None };
        let mut problem = a_case("figure_eight");
        let (grid, mut log) = studied(&mut problem, &budget, &["dormand_prince_8", "symplectic_6"]);
        // As if the clock had stood still.
        log.0.runs.iter_mut().for_each(|run| run.wall = [0.0; 3]);
        let last = budget.near(&problem, &log.0.runs, NEAR[1]);
        assert_eq!(last.len(), 2);
        again(last, &grid, &problem, &mut log);
        let timed = log.0.runs.iter().filter(|run| run.wall[1] > 0.0).map(|run| run.method.integrator.name);
        assert_eq!((log.1, timed.collect::<Vec<_>>().len()), (2, 2));
    }
}
