//! USD as text: the surface as one Mesh, with colours, attributes and velocities of each vertex; of several frames as time
//! samples of one file.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use glam::DVec3;
use rayon::prelude::*;

use super::polygons::Polygons;
use super::{Encoded, Format, Frame, Join, Joining, polygons};
use crate::bake::usd_layer::{identifier, identifiers};
use crate::bake::{Error, Output};
use crate::disk;
use crate::node::Model;
use crate::node::keys::metres;

/// The format of `.usda` files.
#[derive(Debug)]
pub struct Usda;

/// What a file ends in.
const END: &str = "    }\n}\n";
/// What the line that begins an attribute's samples ends in.
const SAMPLES: &str = ".timeSamples = {";
/// The name of the colours.
const COLOUR: &str = "displayColor";
/// Values that are written by one thread at a time.
const CHUNK: usize = 1 << 14;

impl Format for Usda {
    fn extension(&self) -> &'static str {
        "usda"
    }

    fn check(&self, model: &Model, output: &Output) -> Result<(), String> {
        polygons::check(model, output)
    }

    /// Where each frame has a file of its own the values are samples of its time, so that the files are value clips.
    fn encode(&self, frame: &Frame<'_>) -> Result<Encoded, Error> {
        let surface = polygons::of_frame(frame)?;
        let pattern = &frame.output.sequence.pattern;
        let time = pattern.has_token().then_some(frame.number);
        let model = frame.prepared.model();
        let mut text = head(model, frame.output, &pattern.file(frame.number), time.map(|time| (time, time)));
        for Property { kind, name, value } in properties(&surface) {
            let declared = declared(kind, &name);
            // Writing to a string cannot fail.
            let _ = match time {
                Some(time) => write!(text, "{declared}{SAMPLES}\n            {time}: {value},\n        }}\n"),
                None => writeln!(text, "{declared} = {value}"),
            };
        }
        text.push_str(END);
        Ok(Encoded { pieces: vec![text.into_bytes()], polygons: surface.merged })
    }

    fn read_back(&self, pieces: &[Vec<u8>], path: &Path) -> Result<(), Error> {
        match pieces.last() {
            Some(piece) if piece.ends_with(END.as_bytes()) => Ok(()),
            _ => Err(Error::Encode(format!("{}: its last lines are missing", path.display()))),
        }
    }

    fn join(&self) -> Option<Join> {
        Some(join)
    }
}

/// An attribute of the mesh, as USD calls it.
struct Property {
    kind: &'static str,
    name: String,
    value: String,
}

fn properties(surface: &Polygons) -> Vec<Property> {
    let plain = |kind, name: &str, value| Property { kind, name: name.into(), value };
    let places: Vec<[f32; 3]> = surface.positions.iter().map(|position| position.as_vec3().to_array()).collect();
    let bounds = surface.positions.iter().fold(None, |bounds: Option<[DVec3; 2]>, position| {
        Some(bounds.map_or([*position; 2], |[low, high]| [low.min(*position), high.max(*position)]))
    });
    let bounds: Vec<[f32; 3]> = bounds.iter().flatten().map(|corner| corner.as_vec3().to_array()).collect();
    let mut all = vec![
        plain("float3[]", "extent", threes(&bounds)),
        plain("int[]", "faceVertexCounts", list(&surface.triangles, |_, out| out.push('3'))),
        plain("int[]", "faceVertexIndices", list(&surface.triangles, |[a, b, c], out| _ = write!(out, "{a},{b},{c}"))),
        plain("point3f[]", "points", threes(&places)),
    ];
    all.extend(surface.velocities.as_ref().map(|velocities| plain("vector3f[]", "velocities", threes(velocities))));
    all.extend(
        surface.colours.as_ref().map(|colours| plain("color3f[]", &format!("primvars:{COLOUR}"), threes(colours))),
    );
    let names = [COLOUR].into_iter().chain(surface.scalars.iter().map(|(name, _)| name.as_str()));
    let names = identifiers(names).into_iter().skip(1);
    all.extend(surface.scalars.iter().zip(names).map(|((_, values), name)| {
        plain("float[]", &format!("primvars:{name}"), list(values, |value, out| _ = write!(out, "{value}")))
    }));
    all
}

fn threes(values: &[[f32; 3]]) -> String {
    list(values, |[x, y, z], out| _ = write!(out, "({x},{y},{z})"))
}

/// Values in brackets, without blanks: they would be a tenth of the file.
fn list<T: Sync>(values: &[T], one: impl Fn(&T, &mut String) + Sync) -> String {
    let chunk = |values: &[T]| {
        let mut out = String::new();
        for value in values {
            one(value, &mut out);
            out.push(',');
        }
        out
    };
    let chunks: Vec<String> = values.par_chunks(CHUNK).map(chunk).collect();
    let all = chunks.concat();
    format!("[{}]", all.strip_suffix(',').unwrap_or(&all))
}

/// An attribute up to its value; before that, of those that renderers hand to shaders, that each vertex has its own.
fn declared(kind: &str, name: &str) -> String {
    let of_vertices = if name.starts_with("primvars:") {
        format!("        {kind} {name} (\n            interpolation = \"vertex\"\n        )\n")
    } else {
        String::new()
    };
    format!("{of_vertices}        {kind} {name}")
}

/// All before the attributes. `shot`: the first and the last frame, where values are samples.
fn head(model: &Model, output: &Output, path: &Path, shot: Option<(i64, i64)>) -> String {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let root = identifier(&stem);
    let (fps, up) = (model.shot.fps, model.up.to_uppercase());
    let mut text = String::from("#usda 1.0\n(\n    customLayerData = {\n");
    text += &format!("        string creator = \"{}\"\n", output.identity.program);
    text += &format!("        string hfvdb_scene = \"{}\"\n    }}\n", output.identity.scene);
    text +=
        &format!("    defaultPrim = \"{root}\"\n    metersPerUnit = {}\n    upAxis = \"{up}\"\n", metres(model.unit));
    text += &format!("    timeCodesPerSecond = {fps}\n    framesPerSecond = {fps}\n");
    if let Some((first, last)) = shot {
        text += &format!("    startTimeCode = {first}\n    endTimeCode = {last}\n");
    }
    text +=
        &format!(")\n\ndef Xform \"{root}\" (\n    kind = \"component\"\n)\n{{\n    def Mesh \"surface\"\n    {{\n");
    text + "        uniform token subdivisionScheme = \"none\"\n"
}

/// An attribute's sample in a frame's file: where its line begins there, and how long it is.
struct Sample {
    declaration: String,
    start: u64,
    length: u64,
}

/// Joins files of [`Format::encode`].
fn join(joining: &Joining<'_>, out: &mut dyn Write) -> Result<(), Error> {
    let Joining { model, output, path, frames, interrupt } = joining;
    let writing = |error| Error::from(disk::Error::system(path, "write it", error));
    let mut indices = Vec::with_capacity(frames.len());
    for (_, file) in *frames {
        if interrupt.is_raised() {
            return Err(Error::Interrupted);
        }
        indices.push(index(file).map_err(|error| disk::Error::system(file, "read it", error))?);
    }
    let shot = frames.first().zip(frames.last()).map(|((first, _), (last, _))| (*first, *last));
    out.write_all(head(model, output, path, shot).as_bytes()).map_err(writing)?;
    let mut declarations: Vec<&str> = Vec::new();
    for sample in indices.iter().flatten() {
        if !declarations.contains(&sample.declaration.as_str()) {
            declarations.push(&sample.declaration);
        }
    }
    for declaration in declarations {
        let (kind, name) = declaration.split_once(' ').unwrap_or(("token", declaration));
        out.write_all(format!("{}{SAMPLES}\n", declared(kind, name)).as_bytes()).map_err(writing)?;
        for ((frame, file), samples) in frames.iter().zip(&indices) {
            if interrupt.is_raised() {
                return Err(Error::Interrupted);
            }
            match samples.iter().find(|sample| sample.declaration == declaration) {
                Some(sample) => copy(file, sample, out).map_err(|(error, reads)| match reads {
                    true => disk::Error::system(file, "read it", error).into(),
                    false => writing(error),
                })?,
                // Without one of its own a frame would show that of the frame before.
                None => out.write_all(format!("            {frame}: [],\n").as_bytes()).map_err(writing)?,
            }
        }
        out.write_all(b"        }\n").map_err(writing)?;
    }
    out.write_all(END.as_bytes()).map_err(writing)
}

/// Where a frame's file has its samples.
fn index(file: &PathBuf) -> io::Result<Vec<Sample>> {
    let mut reader = BufReader::new(File::open(file)?);
    let (mut samples, mut line, mut start) = (Vec::new(), Vec::new(), 0);
    let mut declaration: Option<String> = None;
    loop {
        line.clear();
        let length = reader.read_until(b'\n', &mut line)? as u64;
        if length == 0 {
            return Ok(samples);
        }
        if let Some(declaration) = declaration.take() {
            samples.push(Sample { declaration, start, length });
        } else {
            let text = std::str::from_utf8(&line).map_err(io::Error::other)?;
            declaration = text.trim().strip_suffix(SAMPLES).map(str::to_owned);
        }
        start += length;
    }
}

/// Copies a sample; an error with whether it was of reading.
fn copy(file: &PathBuf, sample: &Sample, out: &mut dyn Write) -> Result<(), (io::Error, bool)> {
    let reading = |error| (error, true);
    let mut source = File::open(file).map_err(reading)?;
    source.seek(SeekFrom::Start(sample.start)).map_err(reading)?;
    let (mut rest, mut buffer) = (sample.length, vec![0; 1 << 20]);
    while rest > 0 {
        let part = buffer.len().min(rest as usize);
        source.read_exact(&mut buffer[..part]).map_err(reading)?;
        out.write_all(&buffer[..part]).map_err(|error| (error, false))?;
        rest -= part as u64;
    }
    Ok(())
}
