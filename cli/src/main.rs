//! The `vesper` command.

use std::process::ExitCode;

use clap::Parser;
use vesper_cli::command::{Arguments, execute};

fn main() -> ExitCode {
    execute(&Arguments::parse()).into()
}
