//! `vesper study`.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use indicatif::ProgressBar;
use vesper::prelude::*;

use super::arguments::Study;
use super::{Exit, bar, complain, say, stop_on_interrupt};
use crate::assemble::integrators::{self, NamedIntegrator};
use crate::fault::SceneFault;
use crate::modules::Modules;
use crate::output::json;
use crate::scene::{PRECISIONS, Precision as Numbers};
use crate::study::{
    Attribution, Budget, Findings, Grid, Keeper, Method, Patience, Problem, Refusal, Run, choice, diagram, makers,
    read, shares, table, written,
};

/// The files of a study in its folder.
const JSON: &str = "study.json";
const CSV: &str = "study.csv";
const LAWS: &str = "laws.json";
/// How much longer a run may take that tells what a law does.
const LAWS_PATIENCE: f64 = 30.0;

pub(super) fn study(arguments: &Study) -> Result<Exit, Vec<SceneFault>> {
    if arguments.laws {
        return laws(arguments);
    }
    let mut faults = Vec::new();
    let problems = problems(arguments).map_err(|more| faults.extend(more)).ok();
    let grid = grid(arguments).map_err(|more| faults.extend(more)).ok();
    let made = arguments.resume.as_deref().map_or(Ok(Vec::new()), resumed).map_err(|fault| faults.push(fault)).ok();
    let budget = budget(arguments).map_err(|more| faults.extend(more)).ok().flatten();
    let folder = arguments.out.as_deref().map_or(Ok(()), std::fs::create_dir_all);
    if let (Err(error), Some(out)) = (&folder, &arguments.out) {
        faults.push(SceneFault::of_file(out.display().to_string(), format!("the folder cannot be made: {error}")));
    }
    let (Some(mut problems), Some(grid), Some(made), true) = (problems, grid, made, faults.is_empty()) else {
        return Err(faults);
    };
    let grid = Grid { enough: budget.map(|budget| budget.error), ..grid };
    let variants = grid.numbers.len() * grid.backends.len();
    let steps = (problems.len() * grid.integrators.len() * variants) as u64;
    let mut log = Log {
        findings: Findings::default(),
        made,
        out: arguments.out.clone(),
        saved: Instant::now(),
        bar: bar(arguments.quiet, steps),
        trouble: None,
    };
    for problem in &mut problems {
        if problem.answer.is_some() {
            log.answered(problem, Ok(()));
        }
        grid.study(problem, &mut log);
        if let Some(budget) = &budget {
            let runs: Vec<Run> = log.findings.of(&problem.id).cloned().collect();
            budget.refine(&grid, problem, runs, &mut log);
        }
        log.draw(&problem.id);
    }
    log.save();
    log.bar.finish_and_clear();
    let changed = match (&budget, &problems[..]) {
        (Some(budget), [problem]) if arguments.write => write(&arguments.file, problem, budget, &log.findings)?,
        _ => String::new(),
    };
    let text = match &budget {
        _ if arguments.json => json::text(&log.findings.to_json_and(budget.as_ref(), &problems)),
        None => table(&log.findings),
        Some(budget) => {
            let choices: Vec<String> = problems.iter().map(|problem| choice(&log.findings, problem, budget)).collect();
            format!("{}\n{}{changed}", table(&log.findings), choices.concat())
        }
    };
    let said = if arguments.quiet && !arguments.json { Exit::Done } else { say(&text) };
    if let Some(trouble) = log.trouble {
        complain(&format!("{trouble}\n"));
        return Ok(Exit::Failed);
    }
    if grid.patience.stop.load(Ordering::Relaxed) {
        let on = match &arguments.out {
            Some(out) => format!("go on with --resume {}", out.join(JSON).display()),
            None => "with --out DIR there would be a file to go on from".to_owned(),
        };
        complain(&format!("interrupted; {on}\n"));
        return Ok(Exit::Interrupted);
    }
    Ok(said)
}

/// `--write`: puts the choice into the scene; what it says of it.
fn write(path: &Path, problem: &Problem, budget: &Budget, findings: &Findings) -> Result<String, Vec<SceneFault>> {
    let file = path.display().to_string();
    let Some(run) = budget.choice(problem, findings) else {
        return Ok(format!("{file} is left as it is\n"));
    };
    let text = std::fs::read_to_string(path).map_err(|error| vec![wrong(&file, format!("cannot be read: {error}"))])?;
    let (text, lines) = written(&text, problem, run).map_err(|why| vec![wrong(&file, why)])?;
    // The whole file or nothing of it.
    let begun = path.with_extension("toml.part");
    let done = std::fs::write(&begun, text).and_then(|()| std::fs::rename(&begun, path));
    done.map_err(|error| vec![wrong(&file, format!("cannot be written: {error}"))])?;
    Ok(format!("  written into {file}:\n    {}\n", lines.join("\n    ")))
}

/// `--laws`: what each law of a scene does.
fn laws(arguments: &Study) -> Result<Exit, Vec<SceneFault>> {
    let mut faults = Vec::new();
    let problems = problems(arguments).map_err(|more| faults.extend(more)).ok();
    let grid = grid(arguments).map_err(|more| faults.extend(more)).ok();
    let budget = budget(arguments).map_err(|more| faults.extend(more)).ok().flatten();
    let (Some(problems), Some(grid), true) = (problems, grid, faults.is_empty()) else { return Err(faults) };
    let scene = match &problems[..] {
        [problem] => problem.scene().map(|scene| (problem, scene)),
        _ => None,
    };
    let Some((problem, scene)) = scene else {
        let file = arguments.file.display().to_string();
        return Err(vec![wrong(&file, "--laws is for scenes: cases have no laws to drop")]);
    };
    let bar = bar(arguments.quiet, scene.laws.len() as u64 + 2);
    // A law may leave a motion that is harder to follow.
    let patience = Patience { limit: LAWS_PATIENCE * grid.patience.limit, ..grid.patience.clone() };
    let found = Attribution::of(problem, &makers(), &patience, |law| {
        bar.inc(1);
        bar.set_message(law.to_owned());
    });
    bar.finish_and_clear();
    let found = match found {
        Ok(found) => found,
        Err(_) if patience.stop.load(Ordering::Relaxed) => return Ok(Exit::Interrupted),
        Err(reason) => return Err(vec![wrong(&problem.id, reason)]),
    };
    let error = budget.map(|budget| budget.error);
    let json = json::text(&found.to_json(error));
    if let Some(out) = &arguments.out {
        let path = out.join(LAWS);
        let written = std::fs::create_dir_all(out).and_then(|()| std::fs::write(&path, &json));
        if let Err(error) = written {
            return Err(vec![wrong(&path.display().to_string(), format!("cannot be written: {error}"))]);
        }
    }
    Ok(match (arguments.json, arguments.quiet) {
        (true, _) => say(&json),
        (false, true) => Exit::Done,
        (false, false) => say(&shares(&found, error)),
    })
}

/// What a study has found so far, in a folder where one is asked for.
struct Log {
    findings: Findings,
    made: Vec<Run>,
    out: Option<PathBuf>,
    saved: Instant,
    bar: ProgressBar,
    trouble: Option<String>,
}

impl Log {
    fn write(&mut self, name: &str, text: &str) {
        let Some(out) = &self.out else { return };
        // Whole files only: a study that is stopped goes on from this one.
        let (path, begun) = (out.join(name), out.join(format!("{name}.part")));
        let written = std::fs::write(&begun, text).and_then(|()| std::fs::rename(&begun, &path));
        if let Err(error) = written {
            self.trouble = Some(format!("{} cannot be written: {error}", path.display()));
        }
    }

    fn save(&mut self) {
        self.saved = Instant::now();
        let text = json::text(&self.findings.to_json());
        self.write(JSON, &text);
        let text = self.findings.to_csv();
        self.write(CSV, &text);
    }

    fn draw(&mut self, case: &str) {
        if let (Some(_), Some(text)) = (&self.out, diagram(&self.findings, case)) {
            self.write(&format!("{}.svg", file_name(case)), &text);
        }
    }
}

/// A name that any file system takes.
fn file_name(case: &str) -> String {
    case.chars().map(|c| if c.is_alphanumeric() || ".-_".contains(c) { c } else { '_' }).collect()
}

impl Keeper for Log {
    fn made(&self, case: &str, method: &Method) -> Option<Run> {
        self.made.iter().find(|run| run.case == case && run.method.is(method)).cloned()
    }

    fn begins(&mut self, problem: &Problem, integrator: &str) {
        self.bar.set_message(format!("{}: {integrator}", problem.id));
    }

    fn ended(&mut self) {
        self.bar.inc(1);
    }

    fn ran(&mut self, run: Run) {
        self.findings.runs.push(run);
        if self.saved.elapsed() > Duration::from_secs(5) {
            self.save();
        }
    }

    fn timed(&mut self, again: Run) {
        self.findings.time(again);
    }

    fn answered(&mut self, problem: &Problem, answer: Result<(), String>) {
        let told = answer.map(|()| {
            problem.answer.as_ref().map_or_else(Default::default, |answer| (answer.by.clone(), answer.uncertainty))
        });
        self.findings.answers.push((problem.id.clone(), told));
    }

    fn refused(&mut self, refusal: Refusal) {
        self.findings.refusals.push(refusal);
    }
}

fn wrong(what: &str, text: impl Into<String>) -> SceneFault {
    SceneFault::of_file(what, text)
}

/// The problems of a file: cases if it is JSON, else a scene.
fn problems(arguments: &Study) -> Result<Vec<Problem>, Vec<SceneFault>> {
    let path = &arguments.file;
    let file = path.display().to_string();
    if path.extension().is_none_or(|extension| extension != "json") {
        let scene = super::scene(path, &arguments.overrides(), Modules::new(&arguments.laws_from, false))?;
        let id = path.file_stem().map_or_else(|| file.clone(), |stem| stem.to_string_lossy().into_owned());
        return Problem::of_scene(&id, scene, &arguments.of).map(|problem| vec![problem]);
    }
    let scene_options = [
        ("--end", arguments.end.is_some()),
        ("--set", !arguments.changes.set.is_empty()),
        ("--strict", arguments.changes.strict),
        ("--threads", arguments.changes.threads.is_some()),
        ("--of", !arguments.of.is_empty()),
        ("--write", arguments.write),
    ];
    let mut faults: Vec<SceneFault> = scene_options
        .into_iter()
        .filter(|(_, given)| *given)
        .map(|(option, _)| wrong(option, "is for scenes; cases say themselves what they are"))
        .collect();
    let text = std::fs::read_to_string(path).map_err(|error| vec![wrong(&file, format!("cannot be read: {error}"))])?;
    let mut cases = read(&text).map_err(|why| vec![wrong(&file, why)])?;
    for asked in &arguments.cases {
        if !cases.iter().any(|case| case.id == *asked) {
            let help = crate::fault::help_for(asked, cases.iter().map(|case| case.id.as_str()));
            faults.push(SceneFault { help, ..wrong(&format!("--cases {asked}"), "no case has this name") });
        }
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    if !arguments.cases.is_empty() {
        cases.retain(|case| arguments.cases.contains(&case.id));
    }
    Ok(cases.into_iter().map(Problem::of_case).collect())
}

fn grid(arguments: &Study) -> Result<Grid, Vec<SceneFault>> {
    let mut faults = Vec::new();
    let mut number = |option: &str, text: &String| match text.trim().parse::<f64>() {
        Ok(number) if number > 0.0 && number.is_finite() => number,
        _ => {
            faults.push(wrong(&format!("{option} {text}"), "expected a number above 0"));
            1.0
        }
    };
    let mut numbers = |option: &str, list: &[String]| -> Option<Vec<f64>> {
        (!list.is_empty()).then(|| list.iter().map(|text| number(option, text)).collect())
    };
    let (steps, tolerances) = (numbers("--steps", &arguments.steps), numbers("--tolerances", &arguments.tolerances));
    let limit = numbers("--limit", std::slice::from_ref(&arguments.limit)).map_or(1.0, |limit| limit[0]);
    let known = |name: &String| match integrators::integrator(name) {
        Some(known) => Ok(known),
        None => {
            let help = integrators::help(name);
            Err(SceneFault { help, ..wrong(&format!("--integrators {name}"), "no integrator has this name") })
        }
    };
    let mut asked = |list: &[String]| -> Vec<&'static NamedIntegrator> {
        list.iter().filter_map(|name| known(name).map_err(|fault| faults.push(fault)).ok()).collect()
    };
    let integrators = match &arguments.integrators[..] {
        [] => integrators::methods().collect(),
        list => asked(list),
    };
    let widens = arguments.precisions.is_empty();
    let precisions = words("--precisions", &arguments.precisions, &PRECISIONS);
    let backends = [
        ("auto", Backend::Auto),
        ("cpu", Backend::Cpu),
        ("parallel", Backend::Parallel),
        #[cfg(feature = "gpu")]
        ("gpu", Backend::Gpu),
    ];
    let backends = words("--backends", &arguments.backends, &backends);
    let mut precisions = precisions.map_err(|more| faults.extend(more)).unwrap_or_default();
    if widens {
        precisions.push(Numbers::F64);
    }
    let backends = backends.map_err(|more| faults.extend(more)).unwrap_or_default();
    if !faults.is_empty() {
        return Err(faults);
    }
    Ok(Grid {
        integrators,
        steps,
        tolerances,
        numbers: precisions,
        widens,
        compensated: arguments.compensated,
        backends,
        enough: None,
        patience: Patience { limit, stop: stop_on_interrupt() },
    })
}

fn budget(arguments: &Study) -> Result<Option<Budget>, Vec<SceneFault>> {
    let number =
        |option: &str, text: &Option<String>| match text.as_ref().map(|text| (text, text.trim().parse::<f64>())) {
            None => Ok(None),
            Some((_, Ok(number))) if number > 0.0 && number.is_finite() => Ok(Some(number)),
            Some((text, _)) => Err(wrong(&format!("{option} {text}"), "expected a number above 0")),
        };
    match (number("--error", &arguments.error), number("--fps", &arguments.fps)) {
        (Ok(error), Ok(fps)) => Ok(error.map(|error| Budget { error, fps })),
        (error, fps) => Err(error.err().into_iter().chain(fps.err()).collect()),
    }
}

fn words<T: Copy>(option: &str, list: &[String], known: &[(&str, T)]) -> Result<Vec<T>, Vec<SceneFault>> {
    let names = || known.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
    let mut faults = Vec::new();
    let mut found = Vec::new();
    for word in list {
        match known.iter().find(|(name, _)| name == word) {
            Some((_, value)) => found.push(*value),
            None => faults.push(wrong(&format!("{option} {word}"), format!("expected some of {}", names()))),
        }
    }
    if faults.is_empty() { Ok(found) } else { Err(faults) }
}

fn resumed(path: &Path) -> Result<Vec<Run>, SceneFault> {
    let file = path.display().to_string();
    let text =
        std::fs::read_to_string(path).map_err(|error| wrong(&file, format!("the study cannot be read: {error}")))?;
    Findings::runs_from_json(&text).map_err(|why| wrong(&file, format!("the study cannot be read: {why}")))
}
