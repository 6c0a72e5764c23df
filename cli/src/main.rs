//! The `vesper` command.

use std::process::ExitCode;

use clap::Parser;
use vesper_cli::command::{Arguments, execute, refuse};

fn main() -> ExitCode {
    Arguments::try_parse().map_or_else(|error| refuse(&error), |arguments| execute(&arguments)).into()
}
