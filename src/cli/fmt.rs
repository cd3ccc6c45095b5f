//! `hfvdb fmt`: formats scene files.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;
use serde_json::json;

use super::failure::Failure;
use super::options::Global;
use super::paths;
use crate::disk;
use crate::node;
use crate::terminal;
use crate::text::source::Sources;
use crate::text::{Diagnostic, Diagnostics, builtin_text, format_toml};

/// Arguments of `hfvdb fmt`.
#[derive(Args)]
#[command(after_help = "\
Examples:
  hfvdb fmt mine.toml              the file, formatted in place; its name is printed where it changed
  hfvdb fmt --check scenes/*.toml  names of files that would change, and exit code 1 if there are any
  hfvdb fmt - < mine.toml          formatted text on stdout, for editors

Order, comments, and the spelling of keys, numbers and formulas stay. A file that is not TOML stays as it is.")]
pub struct Arguments {
    /// Scene files (.toml) to format in place; `-` reads stdin and writes stdout
    #[arg(value_name = "SCENE", required = true, value_parser = paths::path())]
    scenes: Vec<PathBuf>,

    /// Write nothing; name the files that would change, and exit with 1 if there are any
    #[arg(long)]
    check: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let is_stdin = |path: &PathBuf| path.as_os_str() == "-";
    if arguments.scenes.iter().any(is_stdin) {
        return match &arguments.scenes[..] {
            [_] => format_stdin(arguments.check, global),
            _ => Err(Failure::usage("`-` stands alone: its text goes to stdout, and files are formatted in place")),
        };
    }
    let (mut changed, mut failures) = (Vec::new(), Vec::new());
    for path in &arguments.scenes {
        match format_file(path, arguments.check) {
            Ok(true) => changed.push(path),
            Ok(false) => {}
            Err(failure) => failures.push(failure),
        }
    }
    if global.json && failures.is_empty() {
        super::print_json(&json!({ "changed": changed, "check": arguments.check }))?;
    } else if !global.json {
        super::print(&changed.iter().map(|path| format!("{}\n", path.display())).collect::<String>())?;
    }
    match failures.pop() {
        Some(last) => {
            failures.iter().for_each(|failure| failure.report(false));
            Err(last)
        }
        None => verdict(arguments.check, changed.len(), "hfvdb fmt FILE formats it"),
    }
}

/// What `--check` found, as an exit code.
fn verdict(check: bool, count: usize, way_out: &str) -> Result<(), Failure> {
    match count {
        _ if !check || count == 0 => Ok(()),
        1 => Err(Failure::work(format!("1 file is not formatted: {way_out}")).with_results()),
        _ => Err(Failure::work(format!("{count} files are not formatted: {way_out}")).with_results()),
    }
}

fn format_stdin(check: bool, global: &Global) -> Result<(), Failure> {
    let mut text = String::new();
    std::io::stdin()
        .lock()
        .read_to_string(&mut text)
        .map_err(|error| Failure::work(format!("cannot read standard input: {error}")))?;
    let formatted = formatted("standard input", &text)?;
    if check {
        return verdict(true, usize::from(formatted != text), "hfvdb fmt - formats it");
    }
    if global.json {
        return super::print_json(&json!({ "text": formatted }));
    }
    super::write_out(&formatted)
}

/// Formats a file; whether that changes it.
fn format_file(path: &Path, check: bool) -> Result<bool, Failure> {
    let shown = terminal::path(path);
    let work = |problem: String| Failure::work(format!("{shown}: {problem}"));
    let name = path.to_string_lossy();
    if !path.exists() && builtin_text(&name).is_some() {
        let way_out = format!("`hfvdb scenes {name} > {name}.toml` makes a file of it");
        return Err(work(format!("a scene inside the program, not a file: {way_out}")));
    }
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("json")) {
        return Err(work("only TOML scenes are formatted, and this one is JSON".into()));
    }
    let text = node::text_of(path).map_err(|problem| with_sources(&shown, "", problem))?;
    let formatted = formatted(&shown, &text)?;
    if formatted == text {
        return Ok(false);
    }
    if !check {
        // What a link leads to is replaced, not the link.
        let file = std::fs::canonicalize(path).unwrap_or_else(|_| path.into());
        if std::fs::metadata(&file).is_ok_and(|metadata| metadata.permissions().readonly()) {
            return Err(work("it is write-protected, and not formatted: allow to write it".into()));
        }
        disk::write_whole(&file, formatted.as_bytes()).map_err(|error| Failure::work(error.to_string()))?;
    }
    Ok(true)
}

fn formatted(name: &str, text: &str) -> Result<String, Failure> {
    format_toml(text, 0).map_err(|problem| with_sources(name, text, problem))
}

fn with_sources(name: &str, text: &str, problem: Diagnostic) -> Failure {
    let mut sources = Sources::default();
    sources.add(name, text);
    Diagnostics::new(vec![problem], Arc::new(sources)).into()
}
