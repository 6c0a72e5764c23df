//! Looks at a whole sweep before anything of it runs.
//!
//! In: a plan. Out: the plan with what only an engine knows (units, the title) and with hashes of all that its scenes read, or
//! every mistake: of paths, of values, of the scene, of what is measured. Never: a step.
//!
//! Values are looked at one by one, beside the first ones of whatever else varies: so all words are seen, and thousands of
//! combinations need not be; of long ranges of numbers the first ones and the last, for what a number may be has a limit, or
//! is whole. A combination that does not go together is a run that fails, as one that breaks on
//! its way does; only where no run could begin is that a mistake of the scene.

use std::path::Path;

use vesper::prelude::DoubleDouble;
use vesper_laws::catalog::CatalogPrecision;

use super::ensemble::{Ensemble, MOST_RUNS};
use super::measure::Measure;
use super::plan::Plan;
use super::vary::Spacing;
use crate::fault::SceneFault;
use crate::run::Ready;
use crate::scene::{Override, Precision, Scene};

/// So many values of a range are looked at, and its last.
const MOST_OF_A_RANGE: usize = 50;

/// Checks `plan`, and completes it. `faults` are those known so far: where there are any, no engine is asked, which might
/// miss what a wrong argument was to give.
///
/// # Errors
/// Everything that is wrong, and `faults`.
pub fn check(plan: &mut Plan, mut faults: Vec<SceneFault>) -> Result<(), Vec<SceneFault>> {
    faults.extend(of_the_arguments(plan));
    let few = plan.ensemble.checked_runs().is_some_and(|runs| runs <= MOST_RUNS);
    if !few {
        faults.push(too_many(&plan.ensemble));
    }
    // Measures are looked at by an engine; until then they are not to be observed.
    let measures = std::mem::take(&mut plan.ensemble.measures);
    // Runs beyond all numbers have none to be looked at by.
    let runs = if few { one_by_one(&plan.ensemble) } else { vec![1] };
    let mut wrong = Vec::new();
    for run in &runs {
        // A file or a module that some run reads is the value of one path, or of none: so here all are read.
        match plan.scene(*run) {
            Ok(scene) => wrong.extend(plan.note(&scene).err()),
            Err(more) => wrong.extend(more),
        }
    }
    faults.extend(told_once(wrong.into_iter()));
    if !faults.is_empty() {
        return Err(faults);
    }
    let (title, units) = first_that_begins(plan, &runs, &measures)?;
    // Not the path of the file, which is another one on another machine.
    let name = || Path::new(&plan.file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    plan.ensemble.title = title.unwrap_or_else(name);
    for (mut measure, unit) in measures.into_iter().zip(units) {
        match unit {
            Ok(unit) => {
                measure.unit = unit;
                plan.ensemble.measures.push(measure);
            }
            Err(fault) => faults.push(fault),
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(faults) }
}

/// Of each measure, its unit, or what is wrong with it.
type Units = Vec<Result<String, SceneFault>>;

/// What an engine knows of the first of `runs` that can begin; else what is wrong with the first of all.
fn first_that_begins(
    plan: &Plan,
    runs: &[usize],
    measures: &[Measure],
) -> Result<(Option<String>, Units), Vec<SceneFault>> {
    let mut first = None;
    for run in runs {
        let scene = plan.scene(*run);
        let units = scene.as_ref().map_err(Clone::clone).and_then(|scene| look(scene, measures));
        match (scene, units) {
            (Ok(scene), Ok(units)) => return Ok((scene.title.map(|title| title.value), units)),
            (_, Err(faults)) | (Err(faults), _) => first = first.or(Some(faults)),
        }
    }
    Err(first.unwrap_or_default())
}

/// The first run, and those in which one path takes another value than there.
fn one_by_one(ensemble: &Ensemble) -> Vec<usize> {
    let mut runs = vec![1];
    for (place, vary) in ensemble.varies.iter().enumerate() {
        let last = vary.values.len().saturating_sub(1);
        let looked_at = |index: &usize| vary.spacing == Spacing::List || *index < MOST_OF_A_RANGE || *index == last;
        for index in (1..=last).filter(looked_at) {
            let mut indices = vec![0; ensemble.varies.len()];
            indices[place] = index;
            runs.push(ensemble.run(&indices));
        }
    }
    runs
}

/// Paths that are varied twice, or set beside.
fn of_the_arguments(plan: &Plan) -> Vec<SceneFault> {
    let mut faults = Vec::new();
    let varies = &plan.ensemble.varies;
    for (place, vary) in varies.iter().enumerate() {
        let path = vary.path.as_str();
        if varies[..place].iter().any(|before| before.path == vary.path) {
            faults.push(SceneFault::of_file(format!("--vary {path}"), "the path is varied twice"));
        }
        for change in &plan.changes {
            let (name, other) = match change {
                Override::Set(argument) => {
                    (format!("--set {argument}"), argument.split('=').next().unwrap_or("").trim().to_owned())
                }
                Override::Engine { option, key, .. } => ((*option).to_owned(), format!("engine.{key}")),
                Override::Vary { .. } => continue,
            };
            if other == path {
                faults.push(SceneFault::of_file(name, format!("`{path}` is varied: it cannot also be set")));
            }
        }
    }
    let measures = &plan.ensemble.measures;
    for (place, measure) in measures.iter().enumerate() {
        if measures[..place].iter().any(|before| before.text == measure.text) {
            faults.push(SceneFault::of_file(format!("--measure {}", measure.text), "it is measured twice"));
        }
    }
    faults
}

fn too_many(ensemble: &Ensemble) -> SceneFault {
    let counts: Vec<String> = ensemble.varies.iter().map(|vary| vary.values.len().to_string()).collect();
    let text = format!("{} runs are too many: at most {MOST_RUNS} share a folder", counts.join(" x "));
    let help = "take fewer values, or make several sweeps, each with a folder of its own".to_owned();
    SceneFault { help: Some(help), ..SceneFault::of_file("--vary", text) }
}

/// A mistake of a path is found with each of its values, and one of the file with each run: each is told once.
fn told_once(found: impl Iterator<Item = SceneFault>) -> Vec<SceneFault> {
    let mut told: Vec<SceneFault> = Vec::new();
    for fault in found {
        // Of an argument, what stands before the place counts, so that wrong values are told one by one.
        let upto = |fault: &SceneFault| -> String {
            fault.source_line.chars().take(fault.column + fault.span_len - 1).collect()
        };
        let same = |known: &SceneFault| {
            let place = (&known.file, known.line, known.column, &known.text);
            place == (&fault.file, fault.line, fault.column, &fault.text) && upto(known) == upto(&fault)
        };
        if !told.iter().any(same) {
            told.push(fault);
        }
    }
    told.sort_by_key(|fault| fault.line == 0);
    told
}

fn look(scene: &Scene, measures: &[Measure]) -> Result<Units, Vec<SceneFault>> {
    match scene.engine.precision.as_ref().map_or(Precision::default(), |precision| precision.value) {
        Precision::F32 => looked::<f32>(scene, measures),
        Precision::F64 => looked::<f64>(scene, measures),
        Precision::DoubleDouble => looked::<DoubleDouble>(scene, measures),
    }
}

fn looked<P: CatalogPrecision>(scene: &Scene, measures: &[Measure]) -> Result<Units, Vec<SceneFault>> {
    let ready = Ready::<P>::new(scene, None)?;
    Ok(measures.iter().map(|measure| measure.look(scene, &ready.engine)).collect())
}
