//! One run of a problem by one method: how long it takes, how far it ends from the answer, what it should have kept.
//!
//! In: a problem, a method. Out: a [`Run`], or why the method refuses the laws. Never: a time in which anything but the
//! integration happens.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use vesper::prelude::*;
use vesper_laws::catalog::CatalogPrecision;

use super::problem::{Answer, Moment, Problem};
use crate::assemble::integrators::NamedIntegrator;
use crate::run::drift::Drift;
pub use crate::run::patience::Patience;
use crate::run::patience::watched;
use crate::run::stable;
use crate::scene::Precision as Numbers;

/// What an integrator is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setting {
    /// The length of a step, in s; a little less where a whole number of steps ends at each comparison.
    Step(f64),
    /// The first option of an adaptive one: "rtol", "precision".
    Tolerance(f64),
}

/// A way to run a problem.
#[derive(Clone, Copy, Debug)]
pub struct Method {
    /// The integrator.
    pub integrator: &'static NamedIntegrator,
    /// Its step or tolerance.
    pub setting: Setting,
    /// Number type of the state.
    pub numbers: Numbers,
    /// Whether the rounding errors of the state are kept and added back.
    pub compensated: bool,
    /// Where the laws run.
    pub backend: Backend,
}

/// What came of a run.
#[derive(Clone, Debug)]
pub struct Run {
    /// The name of the problem.
    pub case: String,
    /// How it was run.
    pub method: Method,
    /// Time of the integration, in s: the median of some runs, the shortest, the longest.
    pub wall: [f64; 3],
    /// Evaluations of the laws.
    pub evaluations: u64,
    /// Steps taken.
    pub steps: u64,
    /// Steps that an adaptive integrator gave up.
    pub rejected: u64,
    /// The largest distance from the answer, over all comparisons, quantities and rows, each quantity by its scale. `None`
    /// where there is no answer, infinite where the run broke.
    pub error: Option<f64>,
    /// What the error is at most: the distance from the answer, and what the answer may itself be wrong by.
    pub bound: Option<f64>,
    /// The largest ratio of an error to what the rounding of the input alone may make of it, where that is known.
    pub by_floor: Option<f64>,
    /// The largest relative changes of what should not change.
    pub drift: Vec<(String, f64)>,
    /// Whether it came to its end with numbers of the answer's magnitude: none more than ten times as large.
    pub stable: bool,
    /// Why it did not come to its end.
    pub broke: Option<String>,
}

/// What one go through a problem leaves.
pub(super) struct Went {
    pub(super) wall: f64,
    moments: Vec<Moment>,
    drift: Drift,
    evaluations: u64,
    steps: u64,
    rejected: u64,
    pub(super) broke: Option<String>,
}

/// The part of a problem's least scale that counts as nothing: what is at rest shall not be held to a relative error.
pub const AT_REST: f64 = 1e-6;

/// Runs that took less than this, in s, are repeated, the first so often, the second so often.
const SHORT: [(f64, usize); 2] = [(0.02, 5), (0.2, 3)];

impl Method {
    /// The words of its setting: "step 0.1", "rtol 1e-9".
    pub fn setting_words(&self) -> String {
        match self.setting {
            Setting::Step(step) => format!("step {}", crate::output::rounded(step, 4)),
            Setting::Tolerance(tolerance) => {
                format!("{} {}", self.integrator.options[0], crate::output::rounded(tolerance, 3))
            }
        }
    }

    /// The options that the integrator is given; `least_scale`: of what is compared.
    pub(super) fn options(&self, least_scale: f64) -> Vec<(&'static str, f64)> {
        let Setting::Tolerance(tolerance) = self.setting else { return Vec::new() };
        let given = self.integrator.options.iter().enumerate().filter_map(|(number, option)| match *option {
            option if number == 0 => Some((option, tolerance)),
            "atol" => Some(("atol", tolerance * AT_REST * least_scale)),
            _ => None,
        });
        given.collect()
    }

    fn configure<P: CatalogPrecision>(&self, builder: Builder<P>, least_scale: f64) -> Builder<P> {
        let options = self.options(least_scale);
        let option = |name: &str, usual: f64| {
            options.iter().find(|(option, _)| *option == name).map_or(usual, |(_, value)| *value)
        };
        let builder = builder.boxed_integrator((self.integrator.make)(&option)).backend(self.backend);
        if self.compensated { builder.compensated() } else { builder }
    }

    /// Where a problem ends, and the time of one evaluation of its laws, in s.
    pub(super) fn end(&self, problem: &Problem, patience: &Patience) -> Result<(Moment, f64), String> {
        // Nobody looks at it on the way.
        let mut problem = problem.clone();
        problem.frame = None;
        let went = self.go(&problem, patience, false)?;
        let mut each = went.wall / went.evaluations.max(1) as f64;
        if went.wall < SHORT[0].0 {
            for _ in 1..SHORT[0].1 {
                each = each.min(self.go(&problem, patience, false)?.wall / went.evaluations.max(1) as f64);
            }
        }
        match (went.broke, went.moments.into_iter().next_back()) {
            (None, Some(end)) => Ok((end, each)),
            (broke, _) => Err(broke.unwrap_or_else(|| "it does not come to the end".to_owned())),
        }
    }

    /// How long a step of its integrator may be at the start of a problem, where that is known.
    pub(super) fn longest(&self, problem: &Problem) -> Option<StableStep> {
        let mut engine = problem.engine::<f64>(|builder| self.configure(builder, 0.0)).ok()?;
        stable::longest(&mut engine)
    }

    /// Whether an integrator that goes by the laws chooses its own steps for those of a problem; if not, which one it chose.
    pub(super) fn suggests_an_adaptive_one(&self, problem: &Problem) -> Result<(), String> {
        let engine = problem.engine::<f64>(|builder| self.configure(builder, 0.0))?;
        let chosen = engine.integrator();
        if chosen.is_adaptive() {
            return Ok(());
        }
        let (name, chosen) = (self.integrator.name, chosen.name());
        Err(format!("for these laws {name} is {chosen}, which takes fixed steps: study that"))
    }

    /// Goes through a problem once; `looks`: whether at what should be kept.
    pub(super) fn go(&self, problem: &Problem, patience: &Patience, looks: bool) -> Result<Went, String> {
        match self.numbers {
            Numbers::F32 => self.go_as::<f32>(problem, patience, looks),
            Numbers::F64 => self.go_as::<f64>(problem, patience, looks),
            Numbers::DoubleDouble => self.go_as::<DoubleDouble>(problem, patience, looks),
        }
    }

    fn go_as<P: CatalogPrecision>(&self, problem: &Problem, patience: &Patience, looks: bool) -> Result<Went, String> {
        let mut engine = problem.engine::<P>(|builder| self.configure(builder, problem.least_scale()))?;
        let stop = Arc::new(AtomicBool::new(false));
        engine.stop_on(Some(stop.clone()));
        let mut went = Went {
            wall: 0.0,
            moments: Vec::new(),
            drift: Drift::default(),
            evaluations: 0,
            steps: 0,
            rejected: 0,
            broke: None,
        };
        let result = watched(patience, &stop, || self.take(problem, &mut engine, &mut went, looks, &stop));
        if let Err(fault) = result {
            went.broke = Some(if stop.load(Ordering::Relaxed) {
                format!("given up after {} s", crate::output::rounded(went.wall, 2))
            } else {
                fault
            });
        }
        let [rejected, accepted] = engine.tried_steps();
        went.steps = if accepted > 0 { accepted } else { engine.steps() };
        (went.rejected, went.evaluations) = (rejected, engine.evaluations());
        Ok(went)
    }

    /// From one comparison to the next.
    fn take<P: CatalogPrecision>(
        &self,
        problem: &Problem,
        engine: &mut Engine<P>,
        went: &mut Went,
        looks: bool,
        stop: &AtomicBool,
    ) -> Result<(), String> {
        let words = |faults: Faults| faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        if looks {
            went.drift.look(engine).map_err(words)?;
        }
        for time in &problem.times {
            let way = time - engine.time();
            let from = Instant::now();
            let result = match self.setting {
                Setting::Step(step) if way > 0.0 => fixed(engine, way, step, stop),
                Setting::Tolerance(_) if way > 0.0 => fixed(engine, way, problem.frame.unwrap_or(way), stop),
                _ => engine.advance(way),
            };
            went.wall += from.elapsed().as_secs_f64();
            result.map_err(words)?;
            if stop.load(Ordering::Relaxed) {
                return Err("stopped".to_owned());
            }
            let moment = problem.moment(engine).ok_or("the state lacks what is compared")?;
            went.moments.push(moment);
            if looks {
                went.drift.look(engine).map_err(words)?;
            }
        }
        Ok(())
    }
}

/// How many steps of at most this length there are in a way.
pub(super) fn whole(way: f64, step: f64) -> f64 {
    (way / step - 1e-9).ceil().max(1.0)
}

/// Steps of one length, a whole number of them to the end of the way; in pieces, so that somebody can stop it.
fn fixed<P: CatalogPrecision>(engine: &mut Engine<P>, way: f64, step: f64, stop: &AtomicBool) -> Result<(), Faults> {
    let count = whole(way, step);
    let (mut left, length) = (count as u64, way / count);
    let mut piece = 16;
    while left > 0 && !stop.load(Ordering::Relaxed) {
        let take = left.min(piece);
        let from = Instant::now();
        engine.steps_of(take, length)?;
        left -= take;
        if from.elapsed() < Duration::from_millis(10) {
            piece = piece.saturating_mul(2);
        }
    }
    Ok(())
}

/// Runs a problem by a method: once, and again where once is too short for a clock.
///
/// # Errors
/// In words, why the method refuses the laws.
pub fn measure(problem: &Problem, method: &Method, patience: &Patience) -> Result<Run, String> {
    let went = method.go(problem, patience, true)?;
    let mut walls = vec![went.wall];
    if went.broke.is_none() {
        let repeats = SHORT.iter().find(|(limit, _)| went.wall < *limit).map_or(1, |(_, repeats)| *repeats);
        for _ in 1..repeats {
            walls.push(method.go(problem, patience, false)?.wall);
        }
    }
    walls.sort_by(f64::total_cmp);
    let answer = problem.answer.as_ref();
    let whole = went.broke.is_none() && went.moments.len() == problem.times.len();
    let errors: Option<Vec<f64>> = answer.map(|answer| {
        let pairs = went.moments.iter().zip(&answer.moments);
        pairs.map(|(moment, exact)| problem.distance(moment, exact, &answer.scales)).collect()
    });
    let error =
        errors.as_ref().map(|errors| if whole { errors.iter().copied().fold(0.0, f64::max) } else { f64::INFINITY });
    let by_floor = answer.zip(errors.as_ref()).and_then(|(answer, errors)| {
        let ratios: Vec<f64> =
            errors.iter().zip(&answer.floors).filter_map(|(error, floor)| floor.map(|floor| error / floor)).collect();
        (whole && !ratios.is_empty()).then(|| ratios.into_iter().fold(0.0, f64::max))
    });
    Ok(Run {
        case: problem.id.clone(),
        method: *method,
        wall: [walls[walls.len() / 2], walls[0], walls[walls.len() - 1]],
        evaluations: went.evaluations,
        steps: went.steps,
        rejected: went.rejected,
        error,
        bound: error.zip(answer).map(|(error, answer)| error + answer.uncertainty),
        by_floor,
        drift: kept(problem, &went.drift),
        stable: whole && is_stable(problem, answer, &went.moments),
        broke: went.broke,
    })
}

/// Whether nothing has grown to more than ten times what it should be.
fn is_stable(problem: &Problem, answer: Option<&Answer>, moments: &[Moment]) -> bool {
    let largest = problem.largest(moments);
    let Some(answer) = answer else { return largest.iter().all(|largest| largest.is_finite()) };
    let should = problem.largest(&answer.moments);
    let scales = should.iter().zip(&answer.scales).map(|(should, scale)| should.max(*scale));
    largest.iter().zip(scales).all(|(largest, scale)| *largest <= 10.0 * scale)
}

/// The drifts of what a problem says that it keeps, or of all that is known of.
fn kept(problem: &Problem, drift: &Drift) -> Vec<(String, f64)> {
    let mut known = Vec::new();
    if drift.energy.silent.is_empty() {
        // In a rotating frame it is what Jacobi's integral is half of.
        let jacobi = problem.conserved.iter().flatten().any(|name| name == "jacobi");
        known.push((if jacobi { "jacobi" } else { "energy" }, drift.energy.max_relative_drift));
    }
    if let Some((momentum, angular)) = &drift.momenta {
        known.push(("momentum", momentum.max_relative_drift));
        known.push(("angular_momentum", angular.max_relative_drift));
    }
    let wanted = |name: &str| problem.conserved.as_ref().is_none_or(|names| names.iter().any(|known| known == name));
    known.into_iter().filter(|(name, _)| wanted(name)).map(|(name, value)| (name.to_owned(), value)).collect()
}

/// The states of a problem by two unlike integrators at tight tolerances: the first one's, and how far the other's are from
/// them.
///
/// # Errors
/// In words, why there are no two that come to the end.
pub fn answer(problem: &Problem, by: &[Method], patience: &Patience) -> Result<Answer, String> {
    let mut found: Vec<(&Method, Vec<Moment>)> = Vec::new();
    let mut reasons = Vec::new();
    for method in by {
        match method.go(problem, patience, false) {
            Ok(Went { broke: None, moments, .. }) => found.push((method, moments)),
            Ok(Went { broke, .. }) => {
                reasons.push(format!("{}: {}", method.integrator.name, broke.unwrap_or_default()))
            }
            Err(reason) => reasons.push(format!("{}: {reason}", method.integrator.name)),
        }
        if found.len() == 2 {
            break;
        }
    }
    let [(first, moments), (second, others)] = &found[..] else {
        return Err(format!("no two integrators come to the end: {}", reasons.join("; ")));
    };
    let scales = problem.scales(moments);
    let apart =
        moments.iter().zip(others).map(|(one, other)| problem.distance(one, other, &scales)).fold(0.0, f64::max);
    let words = |method: &Method| format!("{} with {}", method.integrator.name, method.setting_words());
    Ok(Answer {
        by: format!("{}; {} ends {apart:.0e} from it", words(first), words(second)),
        floors: vec![None; moments.len()],
        scales,
        // Either may be the one that is wrong, and both by the rounding of their last step.
        uncertainty: 2.0 * apart + 4.0 * f64::EPSILON,
        moments: moments.clone(),
    })
}
