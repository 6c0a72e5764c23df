//! What `vesper study --error` chooses, beside the best that there is.
//!
//! In: cases of `examples/references.json`, whose answers are hidden from the choice. Out: `benches/results/budget/README.md`:
//! for each case and error, the true error of the choice, and its cost beside the cheapest way of an exhaustive search through
//! all integrators, finely spaced steps and tolerances, both number types, with and without rounding errors kept. Never: a
//! search that is told what was chosen. Takes some five minutes; `-- --test` goes through one small pair, `-- kepler` through
//! those whose names hold the word, and leaves the page as it is.

use std::fmt::Write;
use std::path::Path;
use std::time::Instant;

use vesper::prelude::Backend;
use vesper_benches::Run as Mode;
use vesper_cli::assemble::integrators::{NamedIntegrator, methods};
use vesper_cli::scene::Precision;
use vesper_cli::study::{Answer, Budget, Findings, Grid, Method, Patience, Problem, Run, Setting, measure, race, read};

/// Cases, and the errors that are allowed.
const PAIRS: [(&str, f64); 12] = [
    ("pleiades", 1e-3),
    ("kepler_e0.9", 1e-6),
    ("figure_eight", 1e-9),
    ("arenstorf", 1e-5),
    ("projectile_quadratic_drag", 1e-12),
    ("exb_drift", 1e-4),
    ("magnetic_bottle", 1e-8),
    ("rel_exb_from_rest", 1e-10),
    ("rutherford_alpha_gold", 1e-7),
    ("double_pendulum_stiff", 1e-5),
    ("henon_heiles_regular", 1e-9),
    ("bounce_damped", 1e-6),
];

/// What runs where nothing is measured.
const SMALL: (&str, f64) = ("projectile_linear_drag", 1e-6);

/// Time that a run of the study may take, in s.
const LIMIT: f64 = 0.2;
/// Steps of the exhaustive search for each halving; tolerances for each tenth.
const FINE: f64 = 4.0;
/// The search goes on to finer steps up to so many times the time of the best way that is known.
const FARTHER: f64 = 2.0;
/// Runs of the search, those with the shortest times, that are raced at the end with the choice, and for how long, in s.
const FINALISTS: usize = 8;
const RACE: f64 = 3.0;
/// What a choice may cost, by the cheapest way.
const ALLOWED: f64 = 1.3;

/// A pair, and what came of it.
struct Verdict {
    case: String,
    allowed: f64,
    /// What was claimed of the choice's error, and what it is.
    bound: f64,
    error: f64,
    choice: Way,
    best: Way,
    /// Runs of the study, and of the exhaustive search.
    runs: [usize; 2],
}

/// A way to an error, as the race has it.
#[derive(Clone)]
struct Way {
    method: Method,
    wall: f64,
    evaluations: u64,
}

fn main() {
    let mode = Mode::from_arguments();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("../examples/references.json")).expect("the cases can be read");
    let cases = read(&text).expect("they are cases");
    let pairs = if mode == Mode::Measure { &PAIRS[..] } else { &[SMALL] };
    let begin = Instant::now();
    let mut verdicts = Vec::new();
    let wanted = pairs.iter().filter(|(id, _)| mode.wants(&format!("budget {id}")));
    for &(id, error) in wanted {
        let case = cases.iter().find(|case| case.id == id).expect("there is a case of this name");
        let verdict = judge(&Problem::of_case(case.clone()), error);
        println!("{}", line(&verdict));
        assert!(verdict.error <= error, "{id}: the error {:e} is above {error:e}", verdict.error);
        verdicts.push(verdict);
    }
    if mode == Mode::Measure && verdicts.len() == PAIRS.len() {
        let folder = root.join("results/budget");
        std::fs::create_dir_all(&folder).expect("a folder for results");
        let page = page(&verdicts, begin.elapsed().as_secs_f64() / 60.0);
        std::fs::write(folder.join("README.md"), page).expect("the page");
        println!("the report is in {}", folder.display());
    }
}

/// Lets the study choose without the answer, and holds the choice against it.
fn judge(given: &Problem, error: f64) -> Verdict {
    let patience = Patience { limit: LIMIT, ..Patience::default() };
    let numbers = vec![Precision::F64, Precision::F32];
    let grid = Grid { numbers, widens: false, enough: Some(error), ..Grid::of_all(patience.clone()) };
    let budget = Budget { error, fps: None };
    let (mut blind, mut log) = (given.clone().without_answer(), Findings::default());
    let begin = Instant::now();
    grid.study(&mut blind, &mut log);
    let runs = log.runs.clone();
    budget.refine(&grid, &blind, runs, &mut log);
    let studied = begin.elapsed().as_secs_f64();
    let choice = budget.choice(&blind, &log).expect("something meets the error").clone();
    // The same scales, or errors could not be compared; nothing else of what the study made.
    let scales = blind.answer.as_ref().map(|answer| answer.scales.clone()).expect("there was an answer to choose by");
    let mut truth = given.clone();
    truth.answer = truth.answer.map(|answer| Answer { scales, ..answer });
    let mut tried = exhaustive(&truth, error, &patience);
    let searched = begin.elapsed().as_secs_f64() - studied;
    let count = tried.len();
    tried.retain(|run| meets(run, error));
    tried.sort_by(|one, other| one.wall[1].total_cmp(&other.wall[1]));
    let mut methods = vec![choice.method];
    methods.extend(tried.iter().map(|run| run.method).filter(|method| !method.is(&choice.method)).take(FINALISTS));
    let found: Vec<Run> =
        methods.iter().map(|method| measure(&truth, method, &patience).expect("it has run")).collect();
    let walls = race(&truth, &methods, &patience, RACE).expect("they come to the end");
    let way = |(run, wall): (&Run, [f64; 3])| Way { method: run.method, wall: wall[0], evaluations: run.evaluations };
    let ways: Vec<Way> = found.iter().zip(walls).map(way).collect();
    println!("  {studied:.1} s for the study, {searched:.1} s for the search");
    for way in &ways {
        println!("  {} {:.3e} s, {} evaluations", words(&way.method), way.wall, way.evaluations);
    }
    let best = ways.iter().min_by(|one, other| one.wall.total_cmp(&other.wall)).expect("the choice is one").clone();
    Verdict {
        case: given.id.clone(),
        allowed: error,
        bound: choice.bound.unwrap_or(f64::NAN),
        error: found[0].error.unwrap_or(f64::INFINITY),
        choice: ways[0].clone(),
        best,
        runs: [log.runs.len(), count],
    }
}

fn meets(run: &Run, error: f64) -> bool {
    run.broke.is_none() && run.stable && run.error.is_some_and(|of_run| of_run <= error)
}

/// All integrators, number types, with rounding errors kept or not, by steps and tolerances from coarse to fine, up to twice
/// the time of the cheapest that meets the error.
fn exhaustive(truth: &Problem, error: f64, patience: &Patience) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    let mut best = f64::INFINITY;
    // Those first which are likely to be fast, so that the others need not go on for long; it decides nothing else.
    let mut integrators: Vec<&'static NamedIntegrator> = methods().collect();
    integrators.sort_by_key(|known| core::cmp::Reverse((known.make)(&|_, usual| usual).order()));
    for integrator in integrators {
        let adaptive = (integrator.make)(&|_, usual| usual).is_adaptive();
        for (numbers, compensated) in
            [(Precision::F64, false), (Precision::F64, true), (Precision::F32, false), (Precision::F32, true)]
        {
            for setting in ladder(truth, adaptive) {
                let method = Method { integrator, setting, numbers, compensated, backend: Backend::Auto };
                let Ok(run) = measure(truth, &method, patience) else { break };
                let wall = run.wall[1];
                if meets(&run, error) {
                    best = best.min(run.wall[0]);
                }
                let gave_up = run.broke.is_some() && run.wall[0] > patience.limit;
                runs.push(run);
                if wall > FARTHER * best || gave_up {
                    break;
                }
            }
        }
    }
    runs
}

/// Steps from the whole way between two comparisons on, or tolerances from 1 on.
fn ladder(truth: &Problem, adaptive: bool) -> impl Iterator<Item = Setting> {
    let starts = [truth.start].into_iter().chain(truth.times.iter().copied());
    let longest = starts.zip(&truth.times).map(|(start, end)| end - start).fold(0.0, f64::max);
    let rungs = FINE as i32 * if adaptive { 15 } else { 40 };
    (0..rungs).map(move |rung| {
        let rung = f64::from(rung) / FINE;
        if adaptive { Setting::Tolerance(10f64.powf(-rung)) } else { Setting::Step(longest / 2f64.powf(rung)) }
    })
}

/// "dormand_prince_8, rtol 1e-9, f32, compensated".
fn words(method: &Method) -> String {
    let mut words = format!("{}, {}", method.integrator.name, method.setting_words());
    if method.numbers == Precision::F32 {
        words += ", f32";
    }
    if method.compensated {
        words += ", compensated";
    }
    words
}

/// "2.5 ms"
fn time(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s >= 1.0 => (s, "s"),
        s if s >= 1e-3 => (s * 1e3, "ms"),
        s => (s * 1e6, "µs"),
    };
    format!("{value:.3} {unit}")
}

impl Verdict {
    fn ratio(&self) -> f64 {
        self.choice.wall / self.best.wall
    }
}

/// A choice, or the best, as cells of the table.
fn cells(way: &Way) -> String {
    format!("{} | {} | {}", words(&way.method), time(way.wall), way.evaluations)
}

fn line(verdict: &Verdict) -> String {
    let Verdict { case, allowed, bound, error, choice, best, .. } = verdict;
    let (ratio, choice, best) = (verdict.ratio(), cells(choice), cells(best));
    format!("| `{case}` | {allowed:.0e} | {error:.1e} | {bound:.1e} | {choice} | {best} | {ratio:.2} |")
}

fn page(verdicts: &[Verdict], minutes: f64) -> String {
    let mut page = String::new();
    // Writing to a string cannot fail.
    let mut line_of = |words: &str| _ = writeln!(page, "{words}");
    let count = |which: fn(&Verdict) -> bool| verdicts.iter().filter(|verdict| which(verdict)).count();
    let [studied, searched] = [0, 1].map(|of| verdicts.iter().map(|verdict| verdict.runs[of]).sum::<usize>());
    line_of("# The cheapest way to an error\n");
    line_of(&format!(
        "Made by `cargo bench -- budget` in {minutes:.0} minutes. `vesper study --error`, as with `--precisions f64,f32 --limit \
         {LIMIT}`, chooses a way for each case without its answer, in {studied} runs for all; an exhaustive search that has the \
         answer makes {searched}: all integrators, steps by fourths of a halving, tolerances by fourths of a tenth, f64 and f32, \
         with and without rounding errors kept.\n"
    ));
    line_of(&format!(
        "**{} of {} choices meet the error, and {} cost at most {ALLOWED} times the best.**\n",
        count(|verdict| verdict.error <= verdict.allowed),
        verdicts.len(),
        count(|verdict| verdict.ratio() <= ALLOWED),
    ));
    line_of(&format!(
        "Errors are the largest over all times and bodies, positions and velocities each by its largest magnitude: the true one \
         of the choice, and what was claimed of it without the answer. Times are medians of a race by turns between the choice \
         and the {FINALISTS} fastest runs of the search, on a shared machine; evaluations are exact. The best is the fastest in \
         that race: the choice itself where the ratio is 1, for the study looks closer than fourths where it ends. No run of \
         the search takes more than {LIMIT} s.\n",
    ));
    line_of(
        "| case | allowed | error | claimed | choice | time | evaluations | best of all | time | evaluations | ratio |",
    );
    line_of("|---|---|---|---|---|---|---|---|---|---|---|");
    for verdict in verdicts {
        line_of(&line(verdict));
    }
    let dear: Vec<&Verdict> = verdicts.iter().filter(|verdict| verdict.ratio() > ALLOWED).collect();
    if !dear.is_empty() {
        line_of(&format!("\nAbove {ALLOWED}:\n"));
    }
    for verdict in dear {
        let evaluations = verdict.choice.evaluations as f64 / verdict.best.evaluations.max(1) as f64;
        line_of(&format!(
            "- `{}`, {:.0e}: {:.2} times the time, {evaluations:.2} times the evaluations",
            verdict.case,
            verdict.allowed,
            verdict.ratio()
        ));
    }
    page
}
