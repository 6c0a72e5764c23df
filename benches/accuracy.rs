//! Speed against error: all cases by all integrators, and what is claimed of errors where no answer is known.
//!
//! In: `examples/references.json`. Out: `benches/results/accuracy/README.md`, with a diagram for each case; what changed in it
//! since the last time shows in the history of the repository. Takes some ten minutes; `-- --test` runs three small cases.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;
use vesper::prelude::{Auto, Backend};
use vesper_benches::Run as Mode;
use vesper_cli::assemble::integrators::{AUTO, integrator};
use vesper_cli::scene::Precision;
use vesper_cli::study::{
    Answer, Findings, Grid, LEVELS, Method, Patience, Problem, Run, Setting, answer, diagram, makers, measure, read,
};

/// What runs where nothing is measured.
const SMALL: [&str; 3] = ["projectile_vacuum", "rel_force_free", "terminal_velocity"];

/// Why nothing comes nearer, for cases that are known to be hard.
const WHY: [(&str, &str); 3] = [
    (
        "pythagorean",
        "three bodies in repeated close passages: the roundings of one are multiplied by the next, and the error of a velocity is \
         30 times that of a place in the case's scales",
    ),
    ("kepler_e0.9999", "at the pericentre energies are 2e4 times their sum, and so are their roundings"),
    (
        "oscillator_1e6_periods",
        "a million periods take longer than one run of a study may; `auto`, given the time, comes to half a rounding of 6e6 radians",
    ),
];

/// Time that the integrator of the laws' own structure may take for one case, in s: the one of a million periods takes it.
const LONG: f64 = 900.0;
/// The same in double-double numbers, where f64 is not enough.
const WIDE: f64 = 30.0;

fn main() {
    let mode = Mode::from_arguments();
    if !mode.wants("accuracy") {
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("../examples/references.json")).expect("the cases can be read");
    let cases = read(&text).expect("they are cases");
    let chosen = |id: &str| mode == Mode::Measure || SMALL.contains(&id);
    let problems: Vec<Problem> = cases.into_iter().filter(|case| chosen(&case.id)).map(Problem::of_case).collect();
    // What f64 comes to; where that is not all, more digits are told of apart.
    let grid = Grid { widens: false, ..Grid::of_all(Patience { limit: 1.0, ..Patience::default() }) };
    let mut log = Findings::default();
    let begin = Instant::now();
    for problem in &problems {
        log.answers.push((problem.id.clone(), Ok(("given".to_owned(), 0.0))));
        grid.study(&mut problem.clone(), &mut log);
        let nearest = log.best(&problem.id).and_then(|run| run.error);
        println!("accuracy {}: {:.0e} at best", problem.id, nearest.unwrap_or(f64::NAN));
    }
    let defaults: Vec<ByDefault> = problems.iter().map(|problem| by_default(problem, &log)).collect();
    let claims = claims(&problems);
    let minutes = begin.elapsed().as_secs_f64() / 60.0;
    let page = page(&log, (&problems, &defaults), &claims, minutes);
    if mode == Mode::Measure {
        write(&root.join("results/accuracy"), &page, &log);
    }
}

fn write(folder: &PathBuf, page: &str, findings: &Findings) {
    std::fs::create_dir_all(folder).expect("a folder for results");
    std::fs::write(folder.join("README.md"), page).expect("the page");
    for (case, _) in &findings.answers {
        if let Some(text) = diagram(findings, case) {
            std::fs::write(folder.join(format!("{case}.svg")), text).expect("a diagram");
        }
    }
    println!("the report is in {}", folder.display());
}

/// The error that the default integrator is to come to.
const GOOD: f64 = 1e-6;

/// Errors of the default integrator: in f64, and where that is not enough, in double-double numbers.
struct ByDefault {
    double: f64,
    twice: Option<f64>,
}

fn by_default(problem: &Problem, findings: &Findings) -> ByDefault {
    let double = suggested(problem, Precision::F64, LONG);
    let limited = double > GOOD || floors(findings, &problem.id) > 1.0;
    let twice = limited.then(|| suggested(problem, Precision::DoubleDouble, WIDE)).filter(|error| error.is_finite());
    ByDefault { double, twice }
}

/// The error of the nearest run, by the floor of a case.
fn floors(findings: &Findings, case: &str) -> f64 {
    let known = findings.of(case).filter_map(|run| run.by_floor).fold(f64::INFINITY, f64::min);
    let error = findings.best(case).and_then(|run| run.error).unwrap_or(f64::INFINITY);
    // A case that does not say how errors grow is held to the least floor.
    if known.is_finite() { known } else { error / 1e-12 }
}

/// The error with the integrator that the declared structure of the laws suggests, as it is.
fn suggested(problem: &Problem, numbers: Precision, limit: f64) -> f64 {
    let integrator = integrator(AUTO).expect("there is one for scenes that name none");
    let setting = Setting::Tolerance(Auto::default().precision);
    let method = Method { integrator, setting, numbers, compensated: false, backend: Backend::Auto };
    let run = measure(problem, &method, &Patience { limit, ..Patience::default() });
    let error = run.ok().filter(|run| run.broke.is_none()).and_then(|run| run.error).unwrap_or(f64::INFINITY);
    println!("accuracy {}: {error:.0e} by default in {numbers:?}", problem.id);
    error
}

/// What is claimed of a run's error by somebody who does not know the answer.
struct Claim {
    case: String,
    error: f64,
    bound: f64,
}

/// Runs of every second case, each held against its own answer, and against one that is made as if there were none.
fn claims(problems: &[Problem]) -> Vec<Claim> {
    let patience = Patience { limit: 20.0, ..Patience::default() };
    let mut claims = Vec::new();
    for truth in problems.iter().step_by(2) {
        let (Some(given), Ok(made)) = (&truth.answer, answer(&truth.clone().without_answer(), &makers(), &patience))
        else {
            continue;
        };
        // In the scales of the case, so that errors can be compared.
        let larger = made.scales.iter().zip(&given.scales).map(|(made, given)| made / given).fold(0.0, f64::max);
        let uncertainty = larger * made.uncertainty;
        let mut blind = truth.clone();
        blind.answer = Some(Answer { scales: given.scales.clone(), uncertainty, ..made });
        for (name, tolerance) in [("dormand_prince_5", 1e-4), ("dormand_prince_8", 1e-7), ("dormand_prince_8", 1e-11)] {
            let Some(integrator) = integrator(name) else { continue };
            let setting = Setting::Tolerance(tolerance);
            let method =
                Method { integrator, setting, numbers: Precision::F64, compensated: false, backend: Backend::Auto };
            let errors = [truth, &blind].map(|problem| measure(problem, &method, &patience).ok());
            if let [Some(Run { error: Some(error), .. }), Some(Run { bound: Some(bound), .. })] = errors {
                claims.push(Claim { case: truth.id.clone(), error, bound });
            }
        }
    }
    claims
}

/// "2.5 ms"
fn time(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s >= 1.0 => (s, "s"),
        s if s >= 1e-3 => (s * 1e3, "ms"),
        s => (s * 1e6, "µs"),
    };
    format!("{value:.2} {unit}")
}

fn page(
    findings: &Findings,
    (problems, defaults): (&[Problem], &[ByDefault]),
    claims: &[Claim],
    minutes: f64,
) -> String {
    let mut page = String::new();
    // Writing to a string cannot fail.
    let mut line = |words: &str| _ = writeln!(page, "{words}");
    line("# Speed against error\n");
    line(&format!("Made by `cargo bench -- accuracy` in {minutes:.0} minutes: {} runs.\n", findings.runs.len()));
    line(
        "Errors are the largest over all times and bodies, positions and velocities each by the case's scale. A floor is \
         max(1e-12, ten times what half a rounding of the input becomes): an error of at most one floor is as good as f64 \
         gets without luck. Times are medians on a shared machine: they tell factors, not per cents. Each case's name leads \
         to its diagram.\n",
    );
    let within = problems.iter().filter(|problem| floors(findings, &problem.id) <= 1.0).count();
    line(&format!("**{within} of {} cases come down to their floor in f64.** The others:\n", problems.len()));
    for problem in problems.iter().filter(|problem| floors(findings, &problem.id) > 1.0) {
        let why = WHY.iter().find(|(case, _)| *case == problem.id).map_or("not explained yet", |(_, why)| why);
        line(&format!("- `{}`: {:.1} floors; {why}", problem.id, floors(findings, &problem.id)));
    }
    let good = defaults.iter().filter(|error| error.double <= GOOD).count();
    line(&format!(
        "\n**`auto`, which the declared structure of the laws alone decides, ends within {GOOD:.0e} on {good} of {} in f64.** \
         Where rounding limits f64, its error there and in double-double numbers:\n",
        problems.len()
    ));
    for (problem, ByDefault { double, twice }) in problems.iter().zip(defaults) {
        if let Some(twice) = twice {
            line(&format!("- `{}`: {double:.0e}, {twice:.0e}", problem.id));
        }
    }
    line("");
    line("| case | nearest | floors | by | `auto` | at 1e-6 | at 1e-9 | at 1e-12 |");
    line("|---|---|---|---|---|---|---|---|");
    for (problem, default) in problems.iter().zip(defaults) {
        let case = &problem.id;
        let best = findings.best(case);
        let (error, by) =
            best.map_or((f64::NAN, ""), |run| (run.error.unwrap_or(f64::NAN), run.method.integrator.name));
        let fastest = LEVELS.map(|level| {
            let run = findings.cheapest(case, level);
            run.map_or("-".to_owned(), |run| format!("{} {}", time(run.wall[0]), run.method.integrator.name))
        });
        let floors = floors(findings, case);
        line(&format!(
            "| [`{case}`]({case}.svg) | {error:.0e} | {floors:.2} | {by} | {:.0e} | {} |",
            default.double,
            fastest.join(" | ")
        ));
    }
    line("\n## Without an answer\n");
    let cases: std::collections::BTreeSet<&str> = claims.iter().map(|claim| claim.case.as_str()).collect();
    let broken: Vec<&Claim> = claims.iter().filter(|claim| claim.error > claim.bound).collect();
    line(&format!(
        "`vesper study` makes an answer where there is none, by two unlike integrators, and says of each error what it is at \
         most. Of {} runs of {} cases whose answers were hidden from it, the true error is above that in {}.",
        claims.len(),
        cases.len(),
        broken.len()
    ));
    for Claim { case, error, bound } in broken {
        line(&format!("- `{case}`: {error:.2e}, and not at most {bound:.2e}"));
    }
    page
}
