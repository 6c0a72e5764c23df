//! The `vesper` command.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use vesper_cli::scene::{Scene, print_faults};

/// Reads a scene, and prints every mistake in it.
#[derive(Parser, Debug)]
#[command(name = "vesper", version)]
struct Arguments {
    /// The scene file.
    scene: PathBuf,
    /// Sets one value of the scene, as in `--set engine.step=1e-3`.
    #[arg(long = "set", value_name = "PATH=VALUE", allow_hyphen_values = true)]
    set: Vec<String>,
}

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    match Scene::read(&arguments.scene, &arguments.set) {
        Ok(scene) => {
            let rows = |name: &str| scene.domain(name).and_then(|domain| domain.rows()).unwrap_or(0);
            for domain in &scene.domains {
                println!("{}: {} rows, {} columns", domain.name.value, rows(&domain.name.value), domain.columns.len());
            }
            ExitCode::SUCCESS
        }
        Err(faults) => {
            eprint!("{}", print_faults(&faults));
            ExitCode::from(2)
        }
    }
}
