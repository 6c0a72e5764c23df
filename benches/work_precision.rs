//! Work against precision, beside those whom the field uses: REBOUND, and a crate for ordinary differential equations.
//!
//! In: two cases of `examples/references.json`; a Python that has `rebound`, by `VESPER_PYTHON` or else `python3`. Out:
//! `benches/results/work_precision/README.md`: for pairs of comparable methods, the time that each takes to an error. Without
//! REBOUND that part is left out, and said to be. Takes some minutes; `-- --test` runs one coarse setting of each.

mod work_precision {
    pub mod asked;
    pub mod compared;
    pub mod ode;
    pub mod ours;
}

use std::fmt::Write;
use std::path::Path;
use vesper_benches::Run as Mode;
use vesper_cli::study::{Case, CaseLaw, Problem, read};
use work_precision::asked::{self, Peer};
use work_precision::compared::{Curve, Ratio, ratio};
use work_precision::{ode, ours};

/// What the page begins with.
const HEAD: &str = "# Beside others\n\nMade by `VESPER_PYTHON=.. cargo bench -- work_precision`, with a Python that has REBOUND: \
    the time that each takes to an error, between the settings that were run, on one core of a shared machine, by turns. In a turn \
    the shortest of at least three runs counts, more where they are short. Times are medians of five turns; the ratio is that of \
    each turn, its median and, in brackets, its least and largest. Errors are the largest over all times and bodies, positions \
    and velocities each by the case's scale.\n\nWith few \
    bodies the time goes to what an evaluation, or a sum of vectors, costs before anything is computed: laws are composed at run time, \
    pass by pass, where the peers are compiled for this one problem. So with three bodies methods of low order are a loss beside \
    `ode_solvers` and diffsol, and with six they are not; methods that need fewer evaluations are no loss with three.\n\n";
/// Errors at which times are compared.
const LEVELS: [f64; 4] = [1e-6, 1e-9, 1e-11, 1e-12];
/// The error for methods that come to none of these.
const LOW: f64 = 1e-3;
/// Times that everything is run, in turns.
const ROUNDS: usize = 5;
/// Times that a run is made in one turn at least, of which the shortest counts: the first one finds caches full of somebody
/// else's work.
pub const REPEATS: usize = 3;
/// The time that runs of one setting take at least in a turn, in s: shorter ones are made more often, by everybody.
pub const SECONDS: f64 = 0.04;

/// The shortest of runs, each of which gives its time in s, and what one of them comes to.
pub fn shortest<T>(mut once: impl FnMut() -> (f64, T)) -> (f64, T) {
    let (mut shortest, found) = once();
    let (mut spent, mut made) = (shortest, 1);
    while made < REPEATS || spent < SECONDS && made < 1000 {
        let (time, _) = once();
        (shortest, spent, made) = (shortest.min(time), spent + time, made + 1);
    }
    (shortest, found)
}

/// A case, and what is needed of it.
#[derive(Debug)]
pub struct Task {
    case: Case,
    problem: Problem,
    gravity: f64,
}

impl Task {
    /// A case up to a time.
    fn new(mut case: Case, until: f64) -> Self {
        case.samples.retain(|sample| sample.time <= until);
        let gravity = case.laws.iter().find_map(|law| if let CaseLaw::Gravity(g, _) = law { Some(*g) } else { None });
        let gravity = gravity.expect("bodies attract each other");
        Task { problem: Problem::of_case(case.clone()), case, gravity }
    }

    /// What is usual, of positions and of velocities.
    fn scales(&self) -> [f64; 2] {
        self.case.scale
    }

    /// The error of states at all times: positions and velocities of the rows.
    pub fn error(&self, moments: &[[Vec<f64>; 2]]) -> f64 {
        let answer = self.problem.answer.as_ref().expect("it is given");
        let pairs = moments.iter().zip(&answer.moments);
        let errors = pairs.map(|(moment, exact)| self.problem.distance(&moment.to_vec(), exact, &answer.scales));
        if moments.len() == answer.moments.len() { errors.fold(0.0, f64::max) } else { f64::INFINITY }
    }
}

/// Two methods that are alike: ours with its settings, theirs with its settings and options.
struct Pair {
    ours: (&'static str, Vec<f64>, &'static [(&'static str, f64)]),
    theirs: (Peer, &'static str, Vec<f64>, &'static [(&'static str, &'static str)]),
}

/// Halves of a step, or tenths of a tolerance.
fn ladder(first: f64, factor: f64, count: i32) -> Vec<f64> {
    (0..count).map(|number| first * factor.powi(number)).collect()
}

fn main() {
    let mode = Mode::from_arguments();
    if !mode.wants("work_precision") {
        return;
    }
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(root.join("../examples/references.json")).expect("the cases can be read");
    let cases = read(&text).expect("they are cases");
    let task = |id: &str, until: f64| {
        let case = cases.iter().find(|case| case.id == id).expect("it is among them");
        Task::new(case.clone(), until)
    };
    // Roundings grow: to 1e-13 in the first 10 of its 70 units of time, to 1e-8 in 40.
    let pythagorean = [task("pythagorean", 10.0), task("pythagorean", 40.0)];
    let planets = task("outer_solar_system", f64::INFINITY);
    let short = mode != Mode::Measure;
    let cut = |mut settings: Vec<f64>| {
        if short {
            settings.truncate(1);
        }
        settings
    };
    let tenths = |coarse: f64| cut(ladder(coarse, 0.1, 10));
    let pairs = |leap: f64| {
        let mut pairs = vec![
            Pair { ours: ("gauss_radau_15", tenths(1e-1), &[]), theirs: (Peer::Rebound, "ias15", tenths(1e-1), &[]) },
            Pair { ours: ("nystrom_12", tenths(1e-5), &[]), theirs: (Peer::Rebound, "ias15", tenths(1e-1), &[]) },
            Pair {
                ours: ("leapfrog", cut(ladder(leap, 0.5, 7)), &[]),
                theirs: (Peer::Rebound, "leapfrog", cut(ladder(leap, 0.5, 7)), &[]),
            },
        ];
        if !short {
            // Building it takes minutes.
            for ours in ["dormand_prince_5", "nystrom_12"] {
                let theirs = (Peer::Diffsol, "tsit45", ladder(1e-5, 0.1, 10), [].as_slice());
                pairs.push(Pair { ours: (ours, ladder(1e-5, 0.1, 10), &[]), theirs });
            }
        }
        pairs
    };
    let mut page = HEAD.to_owned();
    let mut compared = |task: &Task, pairs: Vec<Pair>| {
        table(&mut page, task, &pairs, short);
    };
    for task in &pythagorean {
        compared(task, pairs(2.5e-4));
    }
    let mut with_kepler = pairs(12.5);
    // Steps that are not in whole numbers of one another's: a resonance with a period would decide.
    let kepler = || cut(ladder(410.0, 0.63, 14));
    let splittings: [(&str, &[_], &[_]); 3] = [
        ("wisdom_holman", &[], &[("safe_mode", "0")]),
        ("wisdom_holman", &[("corrector", 17.0)], &[("safe_mode", "0"), ("corrector", "17")]),
        ("wisdom_holman_high", &[], &[("safe_mode", "0"), ("corrector", "17"), ("kernel", "lazy")]),
    ];
    for (name, own, options) in splittings {
        with_kepler.push(Pair { ours: (name, kepler(), own), theirs: (Peer::Rebound, "whfast", kepler(), options) });
    }
    compared(&planets, with_kepler);
    if mode == Mode::Measure {
        let folder = root.join("results/work_precision");
        std::fs::create_dir_all(&folder).expect("a folder for results");
        std::fs::write(folder.join("README.md"), page).expect("the page");
    }
}

/// A table for a task.
fn table(page: &mut String, task: &Task, pairs: &[Pair], short: bool) {
    let mut line = |words: String| {
        println!("{words}");
        // Writing to a string cannot fail.
        _ = writeln!(page, "{words}");
    };
    let rounds = if short { 1 } else { ROUNDS };
    let mut ours: Vec<Curve> = Vec::new();
    let mut theirs: Vec<Result<Curve, String>> = Vec::new();
    let mut crates: Vec<Curve> = Vec::new();
    for round in 0..rounds {
        for (number, pair) in pairs.iter().enumerate() {
            let curve = ours::curve(task, pair.ours.0, &pair.ours.1, pair.ours.2);
            let peer = asked::curve(pair.theirs.0, task, pair.theirs.1, &pair.theirs.2, pair.theirs.3);
            if round == 0 {
                ours.push(curve);
                theirs.push(peer);
            } else {
                ours[number].add(curve);
                if let (Ok(known), Ok(peer)) = (&mut theirs[number], peer) {
                    known.add(peer);
                }
            }
        }
        for (number, method) in ode::METHODS.iter().enumerate() {
            let tolerances = if short { vec![1e-3] } else { ladder(1e-3, 0.1, 12) };
            let own = ours::curve(task, method.ours, &tolerances, &[]);
            let peer = ode::curve(task, method, &tolerances);
            if round == 0 {
                crates.extend([own, peer]);
            } else {
                crates[2 * number].add(own);
                crates[2 * number + 1].add(peer);
            }
        }
    }
    let until = task.case.samples.last().map_or(0.0, |sample| sample.time);
    line(format!("## `{}`, to time {until}\n", task.case.id));
    line("| ours | theirs | error | ours, ms | theirs, ms | ours / theirs |".to_owned());
    line("|---|---|---|---|---|---|".to_owned());
    let mut compare = |ours: &Curve, theirs: &Curve| {
        // Methods of low order are held against each other at what they come to.
        let met: Vec<f64> = LEVELS.into_iter().filter(|level| ratio(ours, theirs, *level).is_some()).collect();
        for level in if met.is_empty() { vec![LOW] } else { met } {
            if let Some(Ratio { ours: own, theirs: peer, by: [least, by, most] }) = ratio(ours, theirs, level) {
                let (own, peer) = (1e3 * own, 1e3 * peer);
                let by = format!("{by:.2} ({least:.2} to {most:.2})");
                line(format!("| {} | {} | {level:.0e} | {own:.2} | {peer:.2} | {by} |", ours.name, theirs.name));
            }
        }
    };
    for (ours, theirs) in ours.iter().zip(&theirs) {
        match theirs {
            Ok(theirs) => compare(ours, theirs),
            Err(reason) => println!("{} is not compared: {reason}", ours.name),
        }
    }
    for both in crates.chunks_exact(2) {
        compare(&both[0], &both[1]);
    }
    line(String::new());
}
