//! `vesper run`.

use std::path::Path;

use vesper::prelude::{Checkpoint, DoubleDouble};
use vesper_laws::catalog::CatalogPrecision;

use super::arguments::Run;
use super::{Exit, complain, precision, read, say, stop_on_interrupt};
use crate::fault::{SceneFault, number};
use crate::output::folder::{CHECKPOINT, Folder};
use crate::output::picture::worth_adding;
use crate::output::{checkpoint, json, summary};
use crate::run::{Outcome, Ready, Request};
use crate::scene::{Precision, Scene};

/// Where `--every` does not say, at most so many frames are written, and at most so many lines of tables.
const FRAMES: u64 = 1000;
const LINES: u64 = 200_000;

pub(super) fn run(arguments: &Run) -> Result<Exit, Vec<SceneFault>> {
    let scene = read(&arguments.scene, &arguments.overrides());
    // A checkpoint that cannot be read is told together with the mistakes of the scene.
    let resume = arguments.resume.as_deref().map(read_checkpoint).transpose();
    let every = arguments.every.as_deref().map(every).transpose();
    let (scene, resume, every) = match (scene, resume, every) {
        (Ok(scene), Ok(resume), Ok(every)) => (scene, resume, every),
        (scene, resume, every) => {
            let more = resume.err().into_iter().chain(every.err());
            return Err(scene.err().unwrap_or_default().into_iter().chain(more).collect());
        }
    };
    match precision(&scene) {
        Precision::F32 => go::<f32>(arguments, &scene, resume.as_ref(), every),
        Precision::F64 => go::<f64>(arguments, &scene, resume.as_ref(), every),
        Precision::DoubleDouble => go::<DoubleDouble>(arguments, &scene, resume.as_ref(), every),
    }
}

fn every(text: &str) -> Result<u64, SceneFault> {
    let fault =
        || SceneFault::of_file(format!("--every {text}"), format!("expected a whole number, 1 or more, found {text}"));
    text.trim().parse().ok().filter(|every| *every > 0).ok_or_else(fault)
}

fn read_checkpoint(path: &Path) -> Result<Checkpoint, SceneFault> {
    let file = path.display().to_string();
    let text = std::fs::read_to_string(path)
        .map_err(|error| SceneFault::of_file(&file, format!("the checkpoint cannot be read: {error}")))?;
    checkpoint::from_text(&text)
        .map_err(|why| SceneFault::of_file(&file, format!("the checkpoint cannot be read: {why}")))
}

fn go<P: CatalogPrecision>(
    arguments: &Run,
    scene: &Scene,
    resume: Option<&Checkpoint>,
    every: Option<u64>,
) -> Result<Exit, Vec<SceneFault>> {
    let mut ready = Ready::<P>::new(scene, resume)?;
    if let Some(text) = ready.too_long().filter(|_| !arguments.quiet) {
        complain(&format!("warning: {text}\n"));
    }
    let mut folder = arguments.out.as_deref().map(Folder::new).transpose();
    let folder = folder.as_mut().map_err(|text| vec![scene.fault_of_file(text.as_str())])?;
    let rows: usize = ready.engine.state().domains().iter().map(|domain| domain.rows()).sum();
    let frames = (LINES / rows.max(1) as u64).clamp(8, FRAMES);
    let every = every.unwrap_or(ready.course.frames().div_ceil(frames).max(1));
    let request = Request {
        progress: !arguments.quiet,
        record_every: if folder.is_some() { every } else { 0 },
        draw_every: if folder.is_some() { worth_adding(ready.engine.state(), ready.course.frames()) } else { 0 },
        stop: stop_on_interrupt(),
    };
    let mut outcome = ready.run(request, &mut |engine, shown| match folder.as_mut() {
        Some(folder) => folder.add(scene, engine, shown),
        None => Ok(()),
    });
    let mut files = Vec::new();
    if let Some(folder) = folder.take() {
        let written = folder.finish(scene, &outcome);
        files = written.files;
        outcome.faults.extend(written.faults.into_iter().map(|text| scene.fault_of_file(text)));
    }
    let said = tell(arguments, scene, &outcome, every, &files);
    Ok(match said {
        _ if !outcome.faults.is_empty() => Exit::Failed,
        Exit::Done if outcome.interrupted => Exit::Interrupted,
        said => said,
    })
}

fn tell(arguments: &Run, scene: &Scene, outcome: &Outcome, every: u64, files: &[String]) -> Exit {
    let mut text = String::new();
    if arguments.json {
        text = json::text(&json::outcome(outcome));
    } else if !arguments.quiet {
        text = summary::summary(scene, outcome);
        if let (Some(out), true) = (&arguments.out, outcome.faults.is_empty()) {
            let frames = if every == 1 { "every frame".to_owned() } else { format!("one frame in {every}") };
            text += &format!("\n{frames} written to {}: {}\n", out.display(), files.join(", "));
        }
    }
    let said = say(&text);
    for law in outcome.laws.iter().filter(|law| law.status == "failed") {
        let why = law.reason.as_deref().unwrap_or_default();
        complain(&format!("warning: law {} failed, and the run went on without it: {why}\n", law.name));
    }
    for fault in &outcome.faults {
        complain(&format!("{fault}\n"));
    }
    if outcome.interrupted && outcome.faults.is_empty() {
        let on = match &arguments.out {
            Some(out) => format!("go on with --resume {}", out.join(CHECKPOINT).display()),
            None => "with --out DIR there would be a checkpoint to go on from".to_owned(),
        };
        complain(&format!("interrupted at {} s, step {}; {on}\n", number(outcome.time), outcome.steps));
    }
    if !outcome.faults.is_empty() {
        complain(&format!("the run failed at {} s, step {}\n", number(outcome.time), outcome.steps));
        if let (Some(out), false) = (&arguments.out, files.is_empty()) {
            complain(&format!("written to {}: {}\n", out.display(), files.join(", ")));
            let checkpoint = outcome.checkpoint.as_ref().filter(|_| files.iter().any(|file| file == CHECKPOINT));
            if let Some(checkpoint) = checkpoint {
                let (time, steps, path) = (number(checkpoint.time), checkpoint.steps, out.join(CHECKPOINT));
                complain(&format!("go on from {time} s, step {steps}, with --resume {}\n", path.display()));
            }
        }
    }
    said
}
