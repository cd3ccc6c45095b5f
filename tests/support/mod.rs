//! What the tests of the program share: a private folder, and the real program run in it.
#![allow(dead_code, reason = "each test file uses its own part of this")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

/// A private folder in which the program runs.
pub struct Workplace {
    folder: TempDir,
}

/// What one run of the program gave.
pub struct Run {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Workplace {
    pub fn new() -> Self {
        Self { folder: tempfile::tempdir().expect("a temporary folder") }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, content).expect("a file of the test");
        path
    }

    /// Runs `hfvdb` with arguments split at spaces.
    pub fn hfvdb(&self, arguments: &str) -> Run {
        self.run(Command::new(env!("CARGO_BIN_EXE_hfvdb")).args(arguments.split_whitespace()))
    }

    pub fn run(&self, command: &mut Command) -> Run {
        let output = command.current_dir(self.folder.path()).output().expect("the program starts");
        Run::from(output)
    }

    /// The names in a folder of the workplace, hidden ones too, sorted.
    pub fn names(&self, folder: &str) -> Vec<String> {
        let mut names: Vec<String> = fs::read_dir(self.folder.path().join(folder))
            .expect("a folder of the test")
            .map(|entry| entry.expect("an entry").file_name().into_string().expect("UTF-8"))
            .collect();
        names.sort();
        names
    }

    /// The frames in a folder of the workplace, sorted: what a program sees that lists a sequence.
    pub fn frames(&self, folder: &str) -> Vec<String> {
        let mut names = self.names(folder);
        names.retain(|name| name.ends_with(".vdb"));
        names
    }

    /// Fails where a lock or a temporary was left in a folder.
    pub fn nothing_is_left(&self, folder: &str) {
        let names = self.names(folder);
        let left: Vec<_> = names.iter().filter(|name| name.ends_with("lock") || name.ends_with("tmp")).collect();
        assert!(left.is_empty(), "{left:?} were left behind");
    }

    pub fn root(&self) -> &Path {
        self.folder.path()
    }
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8(output.stdout).expect("UTF-8 on stdout"),
            stderr: String::from_utf8(output.stderr).expect("UTF-8 on stderr"),
        }
    }
}

impl Run {
    /// Fails unless the program ended well.
    pub fn ok(self) -> Self {
        assert_eq!(self.code, 0, "stdout: {}\nstderr: {}", self.stdout, self.stderr);
        self
    }

    /// Fails unless the program ended with `code`, without a panic, and its message holds every part.
    pub fn fails(&self, code: i32, parts: &[&str]) {
        assert_eq!(self.code, code, "stdout: {}\nstderr: {}", self.stdout, self.stderr);
        assert!(!self.stderr.contains("panicked"), "{}", self.stderr);
        assert!(self.stderr.len() < 2200, "a message of {} bytes:\n{}", self.stderr.len(), self.stderr);
        for part in parts {
            assert!(self.stderr.contains(part), "no \"{part}\" in:\n{}", self.stderr);
        }
    }
}

/// A ball that grows over 24 frames; a frame takes milliseconds.
pub const BALL: &str =
    "hfvdb = 1\nframes = \"1-24\"\n[shape.ball]\nsphere = { 1 = 0.5, 24 = 1 }\ncolor = [0.5, \"t\", 0]\n";
/// Bakes it.
pub const BAKE: &str = "bake ball.toml --resolution 16 -o out/m.####.vdb";

/// A workplace with the ball, and another scene like it.
pub fn workplace() -> Workplace {
    let place = Workplace::new();
    place.write("ball.toml", BALL);
    place.write("egg.toml", BALL.replace("0.5, 24", "0.6, 24"));
    place
}

/// Reads a document.
pub fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// The manifest of what [`BAKE`] writes.
pub fn manifest(place: &Workplace) -> Value {
    json(&fs::read_to_string(place.path("out/m.manifest.json")).expect("a manifest"))
}
