//! The command line: one file for each subcommand. Parses, dispatches, and turns errors into exit codes;
//! no geometry lives here.
//!
//! stdout carries only results (paths, text asked for, or one JSON document with `--json`); messages and progress
//! go to stderr.

mod accuracy;
mod bake;
mod caching;
mod check;
mod check_mesh;
mod convert;
mod dry_run;
mod events;
mod failure;
mod files;
mod fmt;
mod info;
mod job;
mod mesh;
mod morph;
mod new;
mod nodes;
mod options;
mod paths;
mod preview;
mod probe;
mod progress;
mod report;
mod scenes;
mod schema;
mod signals;
mod usd;
mod verify;
mod writing;

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use clap::{Parser, Subcommand};

use failure::Failure;
use options::Global;

use crate::terminal;

/// Coloured volumetric objects, modelled by functions, morphed through space and time, written as OpenVDB.
#[derive(Parser)]
#[command(name = "hfvdb", version, propagate_version = true, arg_required_else_help = true)]
#[command(after_help = "\
First steps:
  hfvdb scenes                                   what is built in
  hfvdb bake heart -o heart.vdb                  one coloured object, one file
  hfvdb bake cubism -o out/cubism.####.vdb       48 frames of a coloured morph
  hfvdb morph a.obj b.ply -o out/m.####.vdb      a morph of two meshes, no scene file
  hfvdb convert fox.glb -o fox.vdb               a mesh with its colours, no scene file
  hfvdb mesh out/cubism.0048.vdb -o frame.glb    polygons with colours of any .vdb
  hfvdb usd 'out/cubism.####.vdb' -o cubism.usda  one Volume that plays, for Solaris
  hfvdb new mine.toml                            a first scene, with remarks
  hfvdb fmt mine.toml                            the same scene, neatly spaced
  hfvdb nodes lattice                            what scenes are made of, searched
  hfvdb verify out                               whether all frames are there and whole

Exit codes: 0 done; 1 the input or the work failed; 2 the command line is wrong; 3 more memory is needed than
allowed; 128 and a signal's number, such as 130 and 143, interrupted.")]
struct Program {
    #[command(flatten)]
    global: Global,
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Bake frames of a scene into .vdb files, or polygons (.glb, .usda, .ply, .obj)
    Bake(bake::Arguments),
    /// Morph one mesh into another, without a scene file
    Morph(morph::Arguments),
    /// Turn a mesh or a .vdb file into another: distance, colours, attributes, without a scene file
    Convert(convert::Arguments),
    /// Turn .vdb files of any maker into polygons with colours and attributes: .glb, .usda, .ply, .obj
    Mesh(mesh::Arguments),
    /// Write a USD layer of .vdb files: one Volume that plays, for Solaris, usdview and Blender
    Usd(usd::Arguments),
    /// Check a scene and estimate its voxels, memory and file size, a .vdb file for programs, or a mesh
    Check(check::Arguments),
    /// Show what a .vdb file holds
    Info(info::Arguments),
    /// List the built-in scenes, or print one to start from
    Scenes(scenes::Arguments),
    /// Search the nodes that scenes are made of, or show one with its keys, formula and example
    Nodes(nodes::Arguments),
    /// Read F at one place, node by node: value, slope, distance, colour, attributes
    Probe(probe::Arguments),
    /// Write a first scene to change: one shape, a morph, or two meshes
    New(new::Arguments),
    /// Format scene files: spaces, line breaks and commas; order, comments and values stay
    Fmt(fmt::Arguments),
    /// Print the JSON Schema of the scene format, from which editors complete and check scenes
    Schema,
    /// Hold frames against their manifest: missing, foreign, or a single bit flipped
    Verify(verify::Arguments),
    /// Measure how right every way to measure distances is, on shapes whose distance is known exactly
    Accuracy(accuracy::Arguments),
    /// Take pictures of a scene, a .vdb file or a sequence: PNG, animated PNG, EXR
    Preview(preview::Arguments),
}

/// Runs the program on the process's arguments and returns its exit code.
pub fn run() -> ExitCode {
    signals::survive_file_size_limit();
    let program = match Program::try_parse() {
        Ok(program) => program,
        Err(error) => {
            // Help and version go to stdout with exit code 0, wrong command lines to stderr with 2.
            let code = if error.use_stderr() { 2 } else { 0 };
            report_usage(&error);
            return ExitCode::from(code);
        }
    };
    let global = program.global;
    if global.progress == options::ProgressKind::Json {
        events::start();
    }
    let result = set_threads(&global).and_then(|()| match program.command {
        Command::Bake(arguments) => bake::run(&arguments, &global),
        Command::Morph(arguments) => morph::run(&arguments, &global),
        Command::Convert(arguments) => convert::run(&arguments, &global),
        Command::Mesh(arguments) => mesh::run(&arguments, &global),
        Command::Usd(arguments) => usd::run(&arguments, &global),
        Command::Check(arguments) => check::run(&arguments, &global),
        Command::Info(arguments) => info::run(&arguments, &global),
        Command::Scenes(arguments) => scenes::run(&arguments, &global),
        Command::Nodes(arguments) => nodes::run(&arguments, &global),
        Command::Probe(arguments) => probe::run(&arguments, &global),
        Command::New(arguments) => new::run(&arguments, &global),
        Command::Fmt(arguments) => fmt::run(&arguments, &global),
        Command::Schema => schema::run(),
        Command::Verify(arguments) => verify::run(&arguments, &global),
        Command::Accuracy(arguments) => accuracy::run(&arguments, &global),
        Command::Preview(arguments) => preview::run(&arguments, &global),
    });
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.report(global.json);
            ExitCode::from(failure.exit_code())
        }
    }
}

/// Says what is wrong with a command line, as clap puts it, or prints its help.
fn report_usage(error: &clap::Error) {
    let arguments: Vec<_> = std::env::args_os().collect();
    let not_text = arguments.iter().find(|argument| argument.to_str().is_none());
    match not_text.filter(|_| error.kind() == clap::error::ErrorKind::InvalidUtf8) {
        Some(argument) => say(&format!(
            "error: {}: this is not UTF-8, as names in scenes and manifests are: rename the file",
            terminal::path(Path::new(argument))
        )),
        None if arguments.iter().filter_map(|argument| argument.to_str()).any(terminal::is_obeyed_in) => {
            say(error.render().to_string().trim_end());
        }
        // A closed pipe is no error worth another message.
        None => _ = error.print(),
    }
}

/// Limits Rust's and OpenVDB's threads to the same number.
fn set_threads(global: &Global) -> Result<(), Failure> {
    let threads = global.threads.map_or_else(available_threads, usize::from);
    rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build_global()
        .map_err(|error| Failure::work(format!("cannot start {threads} threads: {error}; try fewer with --threads")))?;
    crate::vdb::set_threads(threads)?;
    Ok(())
}

fn available_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Writes a result to stdout. A reader that went away (`hfvdb … | head`) is no failure.
fn print(text: &str) -> Result<(), Failure> {
    write_out(&terminal::message(text))
}

fn write_out(text: &str) -> Result<(), Failure> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::work(format!("cannot write to standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Says something on stderr. Where its reader went away there is nobody to tell, and the work goes on.
fn say(text: &str) {
    say_as_is(&terminal::message(text));
}

/// Says what has been made ready for a terminal.
fn say_as_is(text: &str) {
    let _ = std::io::stderr().lock().write_all(format!("{text}\n").as_bytes());
}

/// Prints one JSON document on stdout.
fn print_json(document: &serde_json::Value) -> Result<(), Failure> {
    write_out(&terminal::json(&format!("{document:#}\n")))
}
