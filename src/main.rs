//! The program: parse, dispatch, exit code.

use std::process::ExitCode;

/// Also OpenVDB's: of the program only, users of the library choose their own. The system's gives a frame's memory back
/// and asks for it again page by page, which took a quarter of a frame's processor time. How it is set up: `.cargo/config.toml`.
#[global_allocator]
static ALLOCATOR: tikv_jemallocator::Jemalloc = tikv_jemallocator::Jemalloc;

fn main() -> ExitCode {
    hfvdb::cli::run()
}
