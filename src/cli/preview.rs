//! `hfvdb preview`: a picture of a scene, a `.vdb` file or a sequence, without any DCC.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::failure::Failure;
use super::job;
use super::options::{Global, Sampling, SceneArguments, SceneChanges};
use super::progress::Progress;
use crate::attribute::LinearRgb;
use crate::bake::{self, Frames, Interrupt};
use crate::field::Aabb;
use crate::grid::{Band, Channel, measure};
use crate::render::{Camera, ContactSheet, Image, Look, Scene, SheetFrame, View, render};
use crate::vdb::{self, Voxels};

/// Voxels along the longest side where nobody says otherwise: enough for a picture, in a fraction of a bake's time.
const RESOLUTION: u32 = 128;

/// Arguments of `hfvdb preview`.
#[derive(Args)]
pub struct Arguments {
    /// A scene file, the name of a built-in scene, or .vdb files (several make a contact sheet)
    #[arg(value_name = "SCENE or FILE.vdb", required = true)]
    inputs: Vec<String>,

    /// The PNG to write; it is replaced if it exists
    #[arg(short, long, value_name = "FILE.png")]
    output: PathBuf,

    /// Frames of a scene; more than one make a contact sheet [default: the whole shot]
    #[arg(long, value_name = "FRAMES", allow_hyphen_values = true)]
    frames: Option<Frames>,

    /// Where to look from: front, three-quarter or top
    #[arg(long, value_name = "VIEW", default_value = "three-quarter")]
    view: View,

    /// Degrees to turn the camera around the object
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true)]
    turn: f64,

    /// Edge of a picture in pixels [default: 800 for one, 220 for each of a contact sheet]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(16..=8192))]
    size: Option<u32>,

    /// Pictures in a row of a contact sheet
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    columns: Option<u32>,

    /// Show at most so many pictures, evenly chosen; the curves are of all frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pictures: Option<u32>,

    #[command(flatten)]
    changes: SceneChanges,
    #[command(flatten)]
    sampling: Sampling,
}

/// One frame of whatever is shown.
struct Shown {
    number: i64,
    band: Band,
    colour: Option<Channel<LinearRgb>>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    if arguments.output.extension().is_none_or(|end| !end.eq_ignore_ascii_case("png")) {
        return Err(Failure::usage(format!("{}: a preview is a .png", arguments.output.display())));
    }
    let files = arguments.inputs.iter().filter(|input| is_vdb(input)).count();
    let interrupt = job::interrupt()?;
    if files == arguments.inputs.len() {
        return of_files(arguments, &interrupt, global);
    }
    if files > 0 || arguments.inputs.len() > 1 {
        return Err(Failure::usage("preview takes one scene, or any number of .vdb files, not both"));
    }
    of_scene(arguments, &interrupt, global)
}

fn is_vdb(input: &str) -> bool {
    Path::new(input).extension().is_some_and(|end| end.eq_ignore_ascii_case("vdb"))
}

/// Frames of a scene, computed in memory.
fn of_scene(arguments: &Arguments, interrupt: &Interrupt, global: &Global) -> Result<(), Failure> {
    let scene = SceneArguments { scene: arguments.inputs[0].clone(), changes: arguments.changes.clone() };
    let model = job::load(&scene, global)?;
    let frames = job::frames(arguments.frames.as_ref(), &model, global)?;
    let progress = Progress::new(frames.numbers().len(), global);
    let default = arguments.sampling.voxel_size.is_none().then_some(RESOLUTION);
    let prepared = job::prepare(&model, &arguments.sampling, default, interrupt, &progress, global)?;
    let limit = job::limit(&arguments.sampling);
    let numbers = frames.numbers();
    let compute = |place: usize| {
        let number = numbers[place];
        let computed = bake::compute_frame(&prepared, number, limit, interrupt, &|share| progress.at(place, share))
            .map_err(|error| job::failure_of(error, interrupt))?;
        Ok(Shown { number, band: computed.band, colour: computed.colour })
    };
    show(arguments, numbers.len(), prepared.extent, &compute, interrupt, &progress, global)
}

/// Files of any maker, read one after the other.
fn of_files(arguments: &Arguments, interrupt: &Interrupt, global: &Global) -> Result<(), Failure> {
    let progress = Progress::new(arguments.inputs.len(), global);
    let mut bounds: Option<Aabb> = None;
    if arguments.inputs.len() > 1 {
        for path in &arguments.inputs {
            if let Some([least, greatest]) = vdb::active_box(path)? {
                let world = Aabb::new(least.into(), greatest.into());
                bounds = Some(bounds.map_or(world, |bounds| bounds.union(world)));
            }
        }
    }
    let bounds = match bounds {
        Some(bounds) => bounds,
        None => {
            let first = read(&arguments.inputs[0], 0)?;
            let own = measure::solid_extent(&first.band).map(|(least, greatest)| Aabb::new(least, greatest));
            own.unwrap_or(Aabb::new(glam::DVec3::NEG_ONE, glam::DVec3::ONE))
        }
    };
    let compute = |place: usize| read(&arguments.inputs[place], place);
    show(arguments, arguments.inputs.len(), bounds, &compute, interrupt, &progress, global)
}

/// The level set of a file, and a colour over the same blocks if there is one.
fn read(path: &str, place: usize) -> Result<Shown, Failure> {
    let contents = vdb::read(path)?;
    let level_set = contents.grids.iter().find(|grid| grid.class == vdb::StoredClass::LevelSet);
    let level_set = level_set.ok_or_else(|| {
        let names: Vec<_> = contents.grids.iter().map(|grid| grid.name.as_str()).collect();
        Failure::work(format!(
            "{path}: no level set to show; it holds {}",
            if names.is_empty() { "no grid that can be read".into() } else { names.join(", ") }
        ))
    })?;
    let band = level_set.to_band().map_err(|problem| Failure::work(format!("{path}: {problem}")))?;
    let colour = contents.grids.iter().find_map(|grid| match &grid.voxels {
        Voxels::Vectors(blocks) if grid.transform == level_set.transform && grid.name != "vel" => {
            let place: HashMap<_, _> = blocks.origins.iter().enumerate().map(|(at, origin)| (*origin, at)).collect();
            let none = [blocks.background; crate::grid::BLOCK_VOXELS];
            let values = band.origins.iter().map(|origin| place.get(origin).map_or(none, |&at| blocks.values[at]));
            Some(Channel { name: grid.name.clone(), values: values.collect(), background: blocks.background })
        }
        _ => None,
    });
    // The number in the name, as programs read it; else the place among the files.
    let stem = Path::new(path).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let digits = stem.len() - stem.trim_end_matches(|c: char| c.is_ascii_digit()).len();
    let number = stem[stem.len() - digits..].parse().unwrap_or(place as i64 + 1);
    Ok(Shown { number, band, colour })
}

/// Renders the frames into one picture or a contact sheet.
fn show(
    arguments: &Arguments,
    count: usize,
    bounds: Aabb,
    compute: &dyn Fn(usize) -> Result<Shown, Failure>,
    interrupt: &Interrupt,
    progress: &Progress,
    global: &Global,
) -> Result<(), Failure> {
    let size = arguments.size.unwrap_or(if count == 1 { 800 } else { 220 }) as usize;
    let camera = Camera::framing(&bounds, arguments.view, arguments.turn, 1.0);
    let look = Look { ground: Some(bounds.min.z), ..Look::default() };
    let picture =
        |shown: &Shown| render(&Scene { band: &shown.band, colour: shown.colour.as_ref(), camera, look }, size, size);
    let mut sheet = ContactSheet {
        title: arguments.inputs[0].clone(),
        frames: Vec::with_capacity(count),
        columns: arguments.columns.map(|columns| columns as usize),
    };
    let mut last: Option<Band> = None;
    let mut only: Option<Image> = None;
    for place in 0..count {
        progress.stage(&format!("frame {} of {count}", place + 1));
        progress.at(place, 0.0);
        let shown = compute(place)?;
        if interrupt.is_raised() {
            return Err(Failure::interrupted(interrupt.exit_code()));
        }
        let image = is_pictured(place, count, arguments.pictures).then(|| picture(&shown));
        if count == 1 {
            only = image;
            break;
        }
        sheet.frames.push(SheetFrame {
            frame: shown.number,
            image,
            volume: measure::volume(&shown.band),
            change: last.as_ref().and_then(|last| measure::change(last, &shown.band)),
            pieces: measure::pieces(&shown.band).len(),
        });
        last = Some(shown.band);
    }
    let image = only.unwrap_or_else(|| sheet.compose());
    image.save_png(&arguments.output).map_err(|error| Failure::work(error.to_string()))?;
    report(arguments, &sheet, global)
}

/// Whether a frame is among the pictures, when at most `most` are evenly chosen, the first and the last always.
fn is_pictured(place: usize, count: usize, most: Option<u32>) -> bool {
    match most.map(|most| most as usize) {
        None => true,
        Some(most) if most >= count => true,
        Some(1) => place == 0,
        Some(most) => (0..most).any(|picture| picture * (count - 1) / (most - 1) == place),
    }
}

fn report(arguments: &Arguments, sheet: &ContactSheet, global: &Global) -> Result<(), Failure> {
    if !global.json {
        return super::print(&format!("{}\n", arguments.output.display()));
    }
    let frames: Vec<_> = sheet
        .frames
        .iter()
        .map(|frame| json!({ "frame": frame.frame, "volume": frame.volume, "change": frame.change, "pieces": frame.pieces }))
        .collect();
    super::print_json(&json!({ "path": arguments.output, "frames": frames }))
}
