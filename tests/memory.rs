//! The memory limit of the program, set by the shell.

mod support;

use std::process::Command;

use support::{Run, Workplace, json, workplace};

/// Runs the program under a limit of the shell, in KiB.
fn limited(place: &Workplace, limit: &str, arguments: &str) -> Run {
    let script = format!("{limit}; exec \"$0\" {arguments}");
    place.run(Command::new("bash").args(["-c", &script, env!("CARGO_BIN_EXE_hfvdb")]))
}

/// What a limit of 3,000,000 KiB leaves, and 80 % of it. The program itself takes some of it before it looks.
#[test]
fn the_shells_limits_are_heeded() {
    let place = workplace();
    for limit in ["ulimit -v 3000000", "ulimit -d 3000000"] {
        let run = limited(&place, limit, "check ball.toml --threads 2 --json").ok();
        let told = json(&run.stdout)["memory_limit_bytes"].as_u64().expect("a number");
        let whole = 3_000_000 * 1024 / 5 * 4;
        assert!(told < whole && told > whole / 2, "{limit}: {told} of {whole}");
        // About 6 GB of voxels: refused before anything is allocated, with the exit code that says why.
        let run = limited(&place, limit, "bake ball.toml --threads 2 --frames 24 --resolution 3000 -o m.vdb");
        run.fails(3, &["limit is", "--max-memory"]);
        assert!(!place.path("m.vdb").exists());
        // The user's word is the last one.
        let run = limited(&place, limit, "check ball.toml --threads 2 --json --max-memory 9G").ok();
        assert_eq!(json(&run.stdout)["memory_limit_bytes"], 9_u64 << 30);
    }
}
