//! What the command does, word by word.
//!
//! In: arguments. Out: text on standard output and standard error, files where `--out` says, an [`Exit`]. Never: a file
//! or a step before the scene is known to be right.

mod arguments;
mod laws;
mod run;
mod study;
mod sweep;

pub use arguments::{Arguments, Command};

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use signal_hook::consts::SIGINT;
use signal_hook::flag;
use vesper::prelude::DoubleDouble;

use crate::assemble;
use crate::fault::{SceneFault, print_faults};
use crate::modules::Modules;
use crate::scene::{Override, Precision, Scene};
use arguments::{Explain, SceneArguments};

/// How the command ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Done.
    Done,
    /// The scene or the arguments are wrong; nothing was run or written.
    Wrong,
    /// The run failed, or something could not be written.
    Failed,
    /// Somebody stopped the run, whose state up to then is told and written as at its end.
    Interrupted,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        ExitCode::from(match exit {
            Exit::Done => 0,
            Exit::Wrong => 2,
            Exit::Failed => 3,
            // What shells say of a program that SIGINT ended: 128 and the signal's number.
            Exit::Interrupted => 130,
        })
    }
}

/// Does what the arguments say.
pub fn execute(arguments: &Arguments) -> Exit {
    let result = match &arguments.command {
        Command::Run(run) => run::run(run),
        Command::Study(study) => study::study(study),
        Command::Sweep(sweep) => sweep::sweep(sweep),
        Command::Explain(explain) => self::explain(explain),
        Command::Laws { name, folders } => laws::laws(name.as_deref(), &Modules::new(folders, false)),
    };
    result.unwrap_or_else(|faults| {
        complain(&print_faults(&faults));
        Exit::Wrong
    })
}

fn explain(arguments: &Explain) -> Result<Exit, Vec<SceneFault>> {
    let scene = read(&arguments.scene, &arguments.scene.settings.overrides())?;
    let text = match precision(&scene) {
        Precision::F32 => explained::<f32>(&scene, arguments.dot),
        Precision::F64 => explained::<f64>(&scene, arguments.dot),
        Precision::DoubleDouble => explained::<DoubleDouble>(&scene, arguments.dot),
    };
    Ok(say(&text?))
}

fn explained<P: vesper::prelude::Precision>(scene: &Scene, dot: bool) -> Result<String, Vec<SceneFault>> {
    let engine = assemble::engine::<P>(scene)?;
    Ok(if dot { engine.to_dot() } else { engine.explain() })
}

fn read(arguments: &SceneArguments, overrides: &[Override]) -> Result<Scene, Vec<SceneFault>> {
    scene(&arguments.scene, overrides, arguments.settings.modules.modules())
}

/// Reads a scene whose laws may be in modules.
fn scene(path: &Path, overrides: &[Override], modules: Modules) -> Result<Scene, Vec<SceneFault>> {
    let mut scene = Scene::read_and(path, overrides, |scene| assemble::names(scene, &modules))?;
    scene.modules = modules;
    Ok(scene)
}

fn precision(scene: &Scene) -> Precision {
    scene.engine.precision.as_ref().map_or(Precision::default(), |precision| precision.value)
}

/// Writes to standard output, up to the last byte. A reader that has gone away, as `head` does, is no fault; a full disk
/// is one, for whoever redirected the text would take a part of it for all.
fn say(text: &str) -> Exit {
    let mut output = std::io::stdout().lock();
    written(output.write_all(text.as_bytes()).and_then(|()| output.flush()))
}

fn written(result: std::io::Result<()>) -> Exit {
    match result {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            complain(&format!("error: cannot write to standard output: {error}\n"));
            Exit::Failed
        }
        _ => Exit::Done,
    }
}

/// Says what is wrong with the words of a command, or the help that they ask for.
pub fn refuse(error: &clap::Error) -> Exit {
    let printed = error.print().and_then(|()| std::io::stdout().flush());
    if error.use_stderr() { Exit::Wrong } else { written(printed) }
}

/// A flag that the first Ctrl-C sets; the second one ends the command at once.
fn stop_on_interrupt() -> Arc<AtomicBool> {
    let stop = Arc::new(AtomicBool::new(false));
    // In this order: the first time the flag is not yet set when it is asked for. Where no handler can be had, the first
    // Ctrl-C ends the command, as it would without.
    _ = flag::register_conditional_shutdown(SIGINT, 130, stop.clone())
        .and_then(|_| flag::register(SIGINT, stop.clone()));
    stop
}

/// Writes to standard error.
fn complain(text: &str) {
    _ = std::io::stderr().write_all(text.as_bytes());
}

/// A progress bar over so many pieces, where standard error is a terminal.
fn bar(quiet: bool, steps: u64) -> ProgressBar {
    let bar = if quiet { ProgressBar::hidden() } else { ProgressBar::new(steps) };
    if let Ok(style) = ProgressStyle::with_template("[{bar:40}] {percent:>3} %, {eta} left, {msg}") {
        bar.set_style(style.progress_chars("=> "));
    }
    bar.enable_steady_tick(Duration::from_millis(200));
    bar
}
