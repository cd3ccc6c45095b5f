//! `hfvdb preview`: pictures of a scene, a `.vdb` file or a sequence, without any DCC.

mod picture;
mod source;
mod table;
mod target;
mod terminal;
mod turntable;
mod vary;
mod watch;

use std::path::PathBuf;

use std::str::FromStr;

use clap::{Args, ValueEnum};
use serde_json::json;

use super::failure::Failure;
use super::options::{Global, Sampling, SceneChanges};
use super::progress::Progress;
use super::{files, job, paths, signals};
use crate::bake::{Frames, Interrupt};
use crate::grid::{Band, measure};
use crate::render::{self, ContactSheet, Plane, SheetFrame, View};
use picture::Painter;
use source::Source;
use table::Table;
use target::{Kind, Target, Writer};

/// Arguments of `hfvdb preview`.
#[derive(Args)]
#[command(after_help = "\
The name of the output says what is made of the frames:
  heart.png       a picture of one frame; of several a contact sheet, with the curves of volume,
                  change and pieces
  heart.apng      all frames, moving, at the scene's frames a second; browsers play it
  heart.####.png  a picture of each frame
  heart.exr       one frame in layers for compositing: beauty (R G B A), depth.Z, normal.XYZ,
                  colour.RGB, mask.A; heart.####.exr for each frame
The camera is the same over all frames.

Examples:
  hfvdb preview cubism -o cubism.png --pictures 12   a contact sheet; curves of all 48 frames
  hfvdb preview cubism -o cubism.apng                the morph, moving
  hfvdb preview my.toml -o my.png --watch --open     follow what is saved, in a browser
  hfvdb preview my.toml --terminal --frames 12       without any file
  hfvdb preview covid -o turn.apng --turntable 48    once around one frame
  hfvdb preview cubism -o inside.png --slice z=0     colours inside, lines of equal distance
  hfvdb preview bat -o bat.exr --slice y=0           numbers: distance, F, R G B A, and attributes by name
  hfvdb preview cubism -o f.png --slice z=0 --slice-of f --frames 24    F far from the surface
  hfvdb preview bat -o d.png --slice y=0 --slice-of distance            distances, there too
  hfvdb preview 'out/cubism.####.vdb' -o cubism.apng files that are there, of any maker
  hfvdb preview my.toml -o grid.png --vary size=0.5,1,2 --vary seed=1,2   a grid of parameters
  hfvdb preview a.vdb b.vdb -o both.png              files of several names, side by side")]
pub struct Arguments {
    /// A scene file, the name of a built-in scene, or .vdb files, by name or frame pattern (several are a sequence)
    #[arg(value_name = "SCENE or FILE.vdb", required = true, value_parser = paths::text())]
    inputs: Vec<String>,

    /// The .png, .apng or .exr to write; it is replaced if it exists
    #[arg(short, long, value_name = "FILE", value_parser = paths::path(), required_unless_present = "terminal")]
    output: Option<PathBuf>,

    /// Show the picture in the terminal: in its pixels where it can (kitty, iTerm, sixel), else in half blocks
    #[arg(long, conflicts_with = "json")]
    terminal: bool,

    /// Make the picture again whenever the scene, or a file that it names, is saved; until Ctrl-C
    #[arg(long)]
    watch: bool,

    /// Write a page beside the picture that shows each new one, and open it in the browser
    #[arg(long, requires = "watch", requires = "output")]
    open: bool,

    /// Frames of a scene or a frame pattern [default: the whole shot, or all that are there]
    #[arg(long, value_name = "FRAMES", allow_hyphen_values = true)]
    frames: Option<Frames>,

    /// Where to look from: front, back, left, right, top, bottom or three-quarter
    #[arg(long, value_name = "VIEW", default_value = "three-quarter")]
    view: View,

    /// Degrees to turn the camera around the object
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true)]
    turn: f64,

    /// Frame each picture on its own object, so that it fills the picture; sizes and places then do not compare
    #[arg(long, conflicts_with = "slice")]
    follow: bool,

    /// Turn the camera once around one frame in this many pictures: a turning .apng, ####.png, or a contact sheet
    #[arg(long, value_name = "PICTURES", value_parser = clap::value_parser!(u32).range(2..=720),
          conflicts_with_all = ["slice", "pictures", "vary", "csv"])]
    turntable: Option<u32>,

    /// Show the inside in a plane across an axis, such as z=0 or x=-0.5 (world units), with lines of equal distance as
    /// far as the band reaches (see --half-width; 16 voxels here)
    #[arg(long, value_name = "AXIS=PLACE", conflicts_with_all = ["view", "turn"])]
    slice: Option<Plane>,

    /// What a slice shows by its lines: band (distances as they are written, over the colours inside), distance (as far as
    /// the picture goes, measured for it), f (F itself, as far), gradient (how steep F is: white 1, red more, blue less), or an
    /// attribute by its name, inside. Places where F is no number or steeper than declared are magenta
    #[arg(long, value_name = "WHAT", default_value = "band", requires = "slice")]
    slice_of: SliceOf,

    /// Edge of a picture in pixels [default: 800; 480 of an .apng, 220 each of a contact sheet]
    #[arg(long, value_name = "PIXELS", value_parser = clap::value_parser!(u32).range(16..=8192))]
    size: Option<u32>,

    /// How much work goes into a picture [default: draft; final of an .exr]
    #[arg(long, value_enum, value_name = "QUALITY")]
    quality: Option<Quality>,

    /// Pictures in a row of a contact sheet
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=100))]
    columns: Option<u32>,

    /// Show at most so many pictures, evenly chosen; the curves are of all frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pictures: Option<u32>,

    /// Show one frame with each of these values of a [param] name or any key, as `--set` takes them; of several, each
    /// combination, the last in rows; may be repeated
    #[arg(long, value_name = "NAME=VALUE,…", conflicts_with = "watch")]
    vary: Vec<String>,

    /// Write what is counted beside the pictures as a table: volume, area of the surface, pieces, and the change since
    /// the frame before, of shape alone too where a morph moves
    #[arg(long, value_name = "FILE.csv", value_parser = paths::path())]
    csv: Option<PathBuf>,

    /// Show nothing where a frame of the scene has no surface, or all files have no inside, instead of failing
    #[arg(long)]
    allow_empty: bool,

    #[command(flatten)]
    changes: SceneChanges,
    #[command(flatten)]
    sampling: Sampling,
}

/// What a slice shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SliceOf {
    /// Distances as they are written, and the colours inside.
    Band,
    /// Distances as far as the picture goes.
    Distance,
    /// F.
    F,
    /// The length of the gradient of F.
    Gradient,
    /// The attribute of this name.
    Attribute(String),
}

impl FromStr for SliceOf {
    type Err = std::convert::Infallible;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        Ok(match text {
            "band" => Self::Band,
            "distance" => Self::Distance,
            "f" => Self::F,
            "gradient" => Self::Gradient,
            name => Self::Attribute(name.into()),
        })
    }
}

/// How much work goes into a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Quality {
    /// In a fraction of a second: soft shadows at every other pixel, edges smoothed where pixels differ, voxels no finer
    /// than a picture of its size shows, distances to first order
    Draft,
    /// All of it at every pixel
    Final,
}

impl From<Quality> for render::Quality {
    fn from(quality: Quality) -> Self {
        match quality {
            Quality::Draft => Self::Draft,
            Quality::Final => Self::Final,
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let target = Target::new(arguments.output.as_deref(), arguments.terminal)?;
    if target.kind == Kind::Exr && !matches!(arguments.slice_of, SliceOf::Band | SliceOf::Distance) {
        let problem = "an .exr of a slice has distances, F and attributes: leave --slice-of out, or say `distance` for distances \
                       beyond the band";
        return Err(Failure::usage(problem));
    }
    files::none_is_nanovdb(&arguments.inputs)?;
    let files = arguments.inputs.iter().filter(|input| files::is_vdb(input)).count();
    let interrupt = job::interrupt()?;
    if files == arguments.inputs.len() {
        if arguments.watch {
            return Err(Failure::usage("--watch follows a scene, not .vdb files"));
        }
        if !arguments.vary.is_empty() {
            return Err(Failure::usage("--vary changes a scene, not .vdb files"));
        }
        if arguments.slice_of != SliceOf::Band {
            return Err(Failure::usage(
                "--slice-of shows what a scene knows; a .vdb file has its band alone: leave it out, or write --slice-of band",
            ));
        }
        return source::of_files(arguments, &target, global, |source, progress| {
            show(arguments, &target, source, &interrupt, progress, global)
        });
    }
    if files > 0 || arguments.inputs.len() > 1 {
        return Err(Failure::usage("preview takes one scene, or any number of .vdb files, not both"));
    }
    if !arguments.vary.is_empty() {
        return vary::run(arguments, &target, &interrupt, global);
    }
    let once = || {
        source::of_scene(arguments, &target, &interrupt, global, |source, progress| {
            show(arguments, &target, source, &interrupt, progress, global)
        })
    };
    if !arguments.watch {
        return once();
    }
    if arguments.open {
        let file = target.file().ok_or_else(|| Failure::usage("--open shows one file: leave the frame token out"))?;
        watch::open(&file)?;
    }
    watch::follow(arguments, &interrupt, global, once)
}

impl Arguments {
    /// How much work goes into a picture.
    fn quality(&self, target: &Target) -> Quality {
        let usual = if target.kind == Kind::Exr { Quality::Final } else { Quality::Draft };
        self.quality.unwrap_or(usual)
    }

    /// The edge of a picture, of so many frames, in pixels.
    fn size(&self, target: &Target, count: usize) -> usize {
        self.size.unwrap_or_else(|| target.size(count)) as usize
    }
}

/// Makes pictures of the frames, and writes what is made of them.
fn show(
    arguments: &Arguments,
    target: &Target,
    source: &Source<'_>,
    interrupt: &Interrupt,
    progress: &Progress,
    global: &Global,
) -> Result<(), Failure> {
    if let Some(pictures) = arguments.turntable {
        return turntable::show(arguments, target, source, pictures, interrupt, global);
    }
    let count = source.numbers.len();
    let pictured: Vec<usize> = (0..count).filter(|&place| is_pictured(place, count, arguments.pictures)).collect();
    let numbers: Vec<i64> = pictured.iter().map(|&place| source.numbers[place]).collect();
    let size = arguments.size(target, count);
    let mut writer = Writer::new(target, &numbers, count, size)?;
    let mut painter = Painter::new(arguments, source, size, arguments.quality(target))?;
    let mut sheet = ContactSheet {
        title: source.name.clone(),
        frames: Vec::with_capacity(count),
        columns: arguments.columns.map(|columns| columns as usize).or(source.columns),
    };
    let mut table = Table::new();
    let mut last: Option<Band> = None;
    let mut hollow = Vec::new();
    for place in 0..count {
        progress.stage(&format!("frame {} of {count}", place + 1));
        progress.at(place, 0.0);
        let with_picture = pictured.contains(&place);
        if !with_picture && !writer.wants_sheet() && arguments.csv.is_none() {
            continue;
        }
        let shown = (source.compute)(place)?;
        if interrupt.is_raised() {
            return Err(signals::interrupted());
        }
        if shown.band.origins.is_empty() && shown.band.inside_tiles.is_empty() {
            global.warn(&format!("{} is empty", source.named(place)));
            hollow.push(place);
        } else if !measure::has_inside(&shown.band) {
            global.warn(&format!("{} has nothing inside: a picture shows nothing", source.named(place)));
            hollow.push(place);
        }
        // A picture of nothing is no answer; a slice shows the distances all the same.
        if hollow.len() == count && arguments.slice.is_none() && !arguments.allow_empty {
            let problem = "nothing is inside in any frame, so there is nothing to show; `hfvdb check` says more, and \
                           --allow-empty makes the picture all the same";
            return Err(Failure::work(format!("{}: {problem}", source.name)));
        }
        let mut image = None;
        if with_picture {
            image = writer.take(&mut painter, &shown, source.numbers[place])?;
        }
        if writer.wants_sheet() || arguments.csv.is_some() {
            let label = source.labels.as_ref().map(|labels| labels[place].clone());
            let frame = SheetFrame {
                frame: source.numbers[place],
                label,
                image,
                volume: measure::volume(&shown.band),
                // What differs in more than time has no change from one to the next.
                change: last.as_ref().and_then(|last| measure::change(last, &shown.band)),
                change_of_shape: (source.change_of_shape)(place),
                pieces: measure::pieces(&shown.band).len(),
            };
            if arguments.csv.is_some() {
                table.add(&frame, measure::area(&shown.band));
            }
            sheet.frames.push(frame);
            last = source.labels.is_none().then_some(shown.band);
        }
    }
    if let Some(caption) = painter.caption() {
        sheet.title = format!("{}: {caption}", sheet.title);
    }
    let mut paths = writer.finish(&sheet)?;
    if let Some(file) = &arguments.csv {
        table.write(file)?;
        paths.push(file.clone());
    }
    report(&paths, &sheet, global)
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

fn report(paths: &[PathBuf], sheet: &ContactSheet, global: &Global) -> Result<(), Failure> {
    if !global.json {
        return super::print(&paths.iter().map(|path| format!("{}\n", path.display())).collect::<String>());
    }
    let frames: Vec<_> = sheet
        .frames
        .iter()
        .map(|frame| {
            json!({
                "frame": frame.frame,
                "volume": frame.volume,
                "change": frame.change,
                "change_of_shape": frame.change_of_shape,
                "pieces": frame.pieces,
            })
        })
        .collect();
    super::print_json(&json!({ "path": paths.first(), "paths": paths, "frames": frames }))
}
