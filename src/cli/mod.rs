//! The command line: one file for each subcommand. Parses, dispatches, and turns errors into exit codes;
//! no geometry lives here.

use std::process::ExitCode;

/// Runs the program on the process's arguments and returns its exit code.
pub fn run() -> ExitCode {
    ExitCode::from(2)
}
