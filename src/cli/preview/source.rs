//! Where the frames that are shown come from: a scene, computed in memory, or files of any maker.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, IVec3};

use super::target::{Kind, Target};
use super::{Arguments, Quality, SliceOf};
use crate::attribute::{Colour, LinearRgb, Scalar};
use crate::bake::{self, Bytes, Interrupt};
use crate::cli::failure::Failure;
use crate::cli::files;
use crate::cli::job;
use crate::cli::options::{Global, Sampling, SceneArguments};
use crate::cli::progress::Progress;
use crate::distance::band::Feet;
use crate::field::{Aabb, Field};
use crate::grid::{Band, Channel, block_origin, is_active, measure, node_origin, voxel_offset};
use crate::render::{Fill, Up};
use crate::shot::Prepared;
use crate::terminal;
use crate::vdb::{self, MetadataValue, SparseBlocks, Voxels};

/// Voxels along the longest side where nobody says otherwise: enough for a picture, in a fraction of a bake's time.
const RESOLUTION: u32 = 128;
/// The fewest voxels of a small draft.
const LEAST_RESOLUTION: u32 = 48;
/// Half the width, in voxels, of the band of a draft where nobody says otherwise: all that interpolation on the surface takes.
const DRAFT_HALF_WIDTH: f64 = 2.0;
/// Half the width, in voxels, of the band of a slice where nobody says otherwise: wide enough for lines of equal
/// distance over most of an inside at [`RESOLUTION`].
const SLICE_HALF_WIDTH: f64 = 16.0;
/// Frames a second of files that do not say.
const FPS: f64 = 24.0;

/// Frames to show.
pub struct Source<'a> {
    /// What they are of.
    pub name: String,
    /// Their numbers.
    pub numbers: Vec<i64>,
    /// Their names, where they are no frames of one sequence.
    pub labels: Option<Vec<String>>,
    /// Pictures in a row, where that is given by what they are of.
    pub columns: Option<usize>,
    /// The box that holds the object in all of them.
    pub bounds: Aabb,
    /// Gives the frame at a place in the list.
    pub compute: &'a dyn Fn(usize) -> Result<Shown, Failure>,
    /// What a frame changed since the one before, seen from a frame that moves with it; `None` of what does not move.
    pub change_of_shape: &'a dyn Fn(usize) -> Option<f64>,
}

impl Source<'_> {
    /// What the frame at a place in the list is called.
    pub fn named(&self, place: usize) -> String {
        self.labels.as_ref().map_or_else(|| format!("frame {}", self.numbers[place]), |labels| labels[place].clone())
    }
}

/// One frame of whatever is shown.
pub struct Shown {
    pub band: Band,
    /// On the surface.
    pub colour: Option<Channel<LinearRgb>>,
    /// Known only where a slice was asked for.
    pub inside: Inside,
    /// F itself, of a scene of which a slice was asked for. Of a shape of the plane that of the plane.
    pub field: Option<Arc<dyn Field>>,
    /// Its distance everywhere, where that was asked for.
    pub distance: Option<Arc<dyn Field>>,
    /// Its scalars, there too.
    pub scalars: Vec<(String, Arc<Scalar>)>,
    /// Of a file the numbers of its other grids, of vectors each part by itself.
    pub grids: Vec<(String, Box<NumbersAt>)>,
    pub fps: f64,
    /// The axis that points up.
    pub up: Up,
}

/// A grid's numbers at world positions.
pub type NumbersAt = dyn Fn(DVec3) -> f32 + Send + Sync;

/// The colour of the inside.
pub enum Inside {
    None,
    Everywhere(Arc<Colour>),
    Voxels(Box<VoxelValues<LinearRgb>>),
}

impl Inside {
    /// Calls with it as slices take it.
    pub fn with_fill<T>(&self, call: impl FnOnce(Fill<'_>) -> T) -> T {
        match self {
            Self::None => call(Fill::None),
            Self::Everywhere(colour) => call(Fill::Everywhere(&**colour)),
            Self::Voxels(voxels) => call(Fill::Somewhere(&|position| voxels.at(position))),
        }
    }
}

/// Calls `show` with the frames of a scene.
pub fn of_scene(
    arguments: &Arguments,
    target: &Target,
    interrupt: &Interrupt,
    global: &Global,
    show: impl FnOnce(&Source<'_>, &Progress) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let scene = SceneArguments { scene: arguments.inputs[0].clone(), changes: arguments.changes.clone() };
    let model = job::load(&scene, global)?;
    let frames = job::frames(arguments.frames.as_ref(), &model, global)?;
    let numbers = frames.numbers().to_vec();
    let progress = Progress::new(numbers.len(), global);
    let default = default_resolution(arguments, target, numbers.len());
    let sampling = sampling(arguments, target);
    let mut prepared = job::prepare(&model, &sampling, default, interrupt, &progress, global)?;
    prepared.feet = feet(arguments, target);
    let limit = job::limit(&sampling);
    let compute = |place: usize| {
        frame_of(arguments, target, &prepared, numbers[place], limit, interrupt, &|share| progress.at(place, share))
    };
    let (name, bounds) = (arguments.inputs[0].clone(), prepared.extent);
    let change_of_shape =
        |place: usize| place.checked_sub(1).and_then(|last| prepared.change_of_shape(numbers[last], numbers[place]));
    let source = Source {
        name,
        numbers: numbers.clone(),
        labels: None,
        columns: None,
        bounds,
        compute: &compute,
        change_of_shape: &change_of_shape,
    };
    show(&source, &progress)
}

/// Voxels along the longest side for pictures of so many frames, where nobody says otherwise.
pub fn default_resolution(arguments: &Arguments, target: &Target, count: usize) -> Option<u32> {
    let enough = match arguments.quality(target) {
        // Voxels smaller than two pixels show nothing more, and the object fills some 0.7 of the picture.
        Quality::Draft if arguments.slice.is_none() => {
            let shown = arguments.size(target, count) as u32 * 7 / 20;
            shown.clamp(LEAST_RESOLUTION, RESOLUTION)
        }
        _ => RESOLUTION,
    };
    arguments.sampling.voxel_size.is_none().then_some(enough)
}

/// Whether all that is shown is a draft of the surface.
fn is_draft(arguments: &Arguments, target: &Target) -> bool {
    arguments.quality(target) == Quality::Draft && arguments.slice.is_none()
}

/// What frames are measured to.
pub fn feet(arguments: &Arguments, target: &Target) -> Feet {
    if is_draft(arguments, target) { Feet::FirstOrder } else { Feet::Nearest }
}

/// How finely a scene is sampled for pictures.
pub fn sampling(arguments: &Arguments, target: &Target) -> Sampling {
    let own = match arguments.slice {
        Some(_) => Some(SLICE_HALF_WIDTH),
        None => is_draft(arguments, target).then_some(DRAFT_HALF_WIDTH),
    };
    let half_width = arguments.sampling.half_width.or(own);
    Sampling { half_width, ..arguments.sampling.clone() }
}

/// A frame of a scene, computed in memory.
pub fn frame_of(
    arguments: &Arguments,
    target: &Target,
    prepared: &Prepared,
    frame: i64,
    limit: Bytes,
    interrupt: &Interrupt,
    done: &(dyn Fn(f64) + Sync),
) -> Result<Shown, Failure> {
    let computed = match bake::compute_frame(prepared, frame, 1, limit, interrupt, done) {
        Err(error) if arguments.allow_empty && error.is_empty_frame() => bake::empty(prepared),
        computed => computed.map_err(|error| job::failure_of(error, interrupt))?,
    };
    let (mut field, mut inside, mut scalars, mut distance) = (None, None, Vec::new(), None);
    if let Some(slice) = arguments.slice {
        let told = |error| job::failure_of(error, interrupt);
        let content = prepared.frame(frame).map_err(told)?;
        let in_plane = if slice.axis() == 'z' { prepared.in_plane(frame).map_err(told)? } else { None };
        // Distances of the plane end nowhere, and those of the band at the faces of what the shape was extruded to.
        let is_asked = arguments.slice_of == SliceOf::Distance || (target.kind == Kind::Exr && in_plane.is_some());
        if is_asked {
            let found = match &in_plane {
                Some(shape) => prepared.distance_in_plane(frame, shape),
                None => prepared.distance(frame, &content.field, limit.0),
            };
            distance = Some(found.map_err(told)?.distance);
        }
        field = Some(in_plane.map_or(content.field, |(field, _)| field));
        (inside, scalars) = (content.colour, content.scalars);
        known(&arguments.slice_of, &scalars)?;
    }
    let inside = inside.map_or(Inside::None, Inside::Everywhere);
    let (fps, up) = (prepared.model().shot.fps, Up::named(prepared.model().up).unwrap_or_default());
    let grids = Vec::new();
    Ok(Shown { band: computed.band, colour: computed.colour, inside, field, distance, scalars, grids, fps, up })
}

/// Says where a slice is to show an attribute that is not there.
fn known(what: &SliceOf, scalars: &[(String, Arc<Scalar>)]) -> Result<(), Failure> {
    let SliceOf::Attribute(name) = what else { return Ok(()) };
    if scalars.iter().any(|(own, _)| own == name) {
        return Ok(());
    }
    let names: Vec<&str> = ["band", "distance", "f", "gradient"]
        .into_iter()
        .chain(scalars.iter().map(|(name, _)| name.as_str()))
        .collect();
    let names = names.join(", ");
    let (name, names) = (terminal::one_line(name), terminal::one_line(&names));
    Err(Failure::usage(format!("--slice-of {name}: the frame has no such attribute; there is {names}")))
}

/// Calls `show` with files of any maker, read one after the other.
pub fn of_files(
    arguments: &Arguments,
    target: &Target,
    global: &Global,
    show: impl FnOnce(&Source<'_>, &Progress) -> Result<(), Failure>,
) -> Result<(), Failure> {
    let inputs = &files::named(&arguments.inputs, arguments.frames.as_ref())?;
    let progress = Progress::new(inputs.len(), global);
    let mut bounds: Option<Aabb> = None;
    if inputs.len() > 1 {
        for path in inputs {
            if let Some([least, greatest]) = vdb::level_set_box(path)? {
                let world = Aabb::new(least.into(), greatest.into());
                bounds = Some(bounds.map_or(world, |bounds| bounds.union(world)));
            }
        }
    }
    let bounds = match bounds {
        Some(bounds) => bounds,
        None => {
            let own = measure::solid_extent(&read(&inputs[0])?.0.band);
            own.map_or(Aabb::new(DVec3::NEG_ONE, DVec3::ONE), |(least, greatest)| Aabb::new(least, greatest))
        }
    };
    let (names, frames): (Vec<&str>, Vec<Option<i64>>) = inputs.iter().map(|path| name_and_number(path)).unzip();
    let is_sequence = names.iter().all(|name| *name == names[0]) && frames.iter().all(Option::is_some);
    let (name, numbers, labels) = if is_sequence {
        (inputs[0].clone(), frames.into_iter().flatten().collect(), None)
    } else {
        let labels: Vec<String> = inputs.iter().map(|path| stem(path).to_owned()).collect();
        let title = if inputs.len() == 1 { inputs[0].clone() } else { format!("{} files", inputs.len()) };
        (title, (1..=inputs.len() as i64).collect(), Some(labels))
    };
    let is_numbers = arguments.slice.is_some() && target.kind == Kind::Exr;
    let compute = |place: usize| {
        let (mut shown, others) = read(&inputs[place])?;
        if is_numbers {
            let (grids, left_out) = others.numbers();
            shown.grids = grids;
            if !left_out.is_empty() {
                let names = left_out.join(", ");
                let names = terminal::one_line(&names);
                global.warn(&format!("{names}: left out; their voxels are no numbers, or stand elsewhere"));
            }
        }
        Ok(shown)
    };
    let (compute, change_of_shape) = (&compute, &|_| None);
    show(&Source { name, numbers, labels, columns: None, bounds, compute, change_of_shape }, &progress)
}

/// A file's name without its extension.
fn stem(path: &str) -> &str {
    Path::new(path).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default()
}

/// The name of a file's sequence, and its number as programs read it: the last digits before the extension.
fn name_and_number(path: &str) -> (&str, Option<i64>) {
    let whole = path.rsplit_once('.').map_or(path, |(whole, _)| whole);
    let name = whole.trim_end_matches(|c: char| c.is_ascii_digit());
    (name, whole[name.len()..].parse().ok())
}

/// The level set of a file, a colour over the same blocks if there is one, and what else there is.
fn read(path: &str) -> Result<(Shown, Others), Failure> {
    let mut contents = vdb::read(path)?;
    let fps = match contents.metadata.get("hfvdb_fps") {
        Some(MetadataValue::Double(fps)) if fps.is_finite() && *fps > 0.0 => *fps,
        _ => FPS,
    };
    // A file of another maker does not say; in Blender, where most come from, it is z.
    let up = match contents.metadata.get("hfvdb_up") {
        Some(MetadataValue::Text(up)) => Up::named(up).unwrap_or_default(),
        _ => Up::default(),
    };
    let Some(place) = contents.grids.iter().position(|grid| grid.class == vdb::StoredClass::LevelSet) else {
        let names: Vec<_> = contents.grids.iter().map(|grid| grid.name.as_str()).collect();
        return Err(Failure::work(format!(
            "{path}: no level set to show; it holds {}",
            if names.is_empty() { "no grid that can be read".into() } else { names.join(", ") }
        )));
    };
    let level_set = contents.grids.remove(place);
    let band = level_set.to_band().map_err(|problem| Failure::work(format!("{path}: {problem}")))?;
    let is_colour = |grid: &vdb::StoredGrid| {
        matches!(grid.voxels, Voxels::Vectors(_))
            && grid.transform == level_set.transform
            && !vdb::VELOCITIES.contains(&grid.name.as_str())
    };
    let origin = level_set.transform.world(DVec3::ZERO).unwrap_or_default();
    let voxel_size = band.lattice.voxel_size.get();
    let (mut colour, mut inside) = (None, Inside::None);
    let found = contents.grids.iter().position(is_colour).map(|place| contents.grids.remove(place));
    if let Some(vdb::StoredGrid { name, voxels: Voxels::Vectors(blocks), .. }) = found {
        let colours = VoxelValues::new(blocks, origin, voxel_size);
        // A level set's blocks may be shifted, the colours' are as the file has them.
        let shift = (origin / voxel_size).round().as_ivec3();
        let none = [colours.blocks.background; crate::grid::BLOCK_VOXELS];
        let of_block =
            |place: &IVec3| colours.places.get(&(*place - shift)).map_or(none, |&at| colours.blocks.values[at]);
        let of_blocks = band.origins.iter().map(of_block);
        colour = Some(Channel::of_blocks(name, &band.active, of_blocks, colours.blocks.background));
        inside = Inside::Voxels(Box::new(colours));
    }
    let others = Others {
        grids: contents.grids,
        skipped: contents.skipped.into_iter().map(|(name, _)| name).collect(),
        transform: level_set.transform,
        origin,
        voxel_size,
    };
    let shown =
        Shown { band, colour, inside, field: None, distance: None, scalars: Vec::new(), grids: Vec::new(), fps, up };
    Ok((shown, others))
}

/// What a file has beside its level set and its colour.
struct Others {
    grids: Vec<vdb::StoredGrid>,
    /// The names of those that are not read.
    skipped: Vec<String>,
    transform: vdb::Transform,
    origin: DVec3,
    voxel_size: f64,
}

impl Others {
    /// The numbers of those whose voxels are the level set's, and the names of the others.
    fn numbers(self) -> (Vec<(String, Box<NumbersAt>)>, Vec<String>) {
        let Self { grids, skipped: mut left_out, transform, origin, voxel_size } = self;
        let mut all: Vec<(String, Box<NumbersAt>)> = Vec::new();
        for vdb::StoredGrid { name, transform: own, voxels, metadata, .. } in grids {
            match voxels {
                _ if own != transform => left_out.push(name),
                Voxels::Floats(blocks) => {
                    let values = VoxelValues::new(blocks, origin, voxel_size);
                    all.push((name, Box::new(move |position| values.or_background(position))));
                }
                Voxels::Vectors(blocks) => {
                    let values = Arc::new(VoxelValues::new(blocks, origin, voxel_size));
                    let moves = vdb::VELOCITIES.contains(&name.as_str())
                        || vdb::metadata_text(&metadata, "vector_type").is_some_and(|kind| kind != "invariant");
                    let parts = if moves { ["x", "y", "z"] } else { ["R", "G", "B"] };
                    for (axis, part) in parts.into_iter().enumerate() {
                        let values = Arc::clone(&values);
                        let number = move |position| values.or_background(position)[axis];
                        all.push((format!("{name}.{part}"), Box::new(number)));
                    }
                }
            }
        }
        (all, left_out)
    }
}

/// Values that a file has, wherever it has them.
pub struct VoxelValues<T> {
    blocks: SparseBlocks<T>,
    places: HashMap<IVec3, usize>,
    /// The active tiles, by least corner and edge.
    tiles: HashMap<(IVec3, i32), T>,
    /// The world position of voxel (0, 0, 0).
    origin: DVec3,
    voxel_size: f64,
}

impl<T: Copy> VoxelValues<T> {
    fn new(blocks: SparseBlocks<T>, origin: DVec3, voxel_size: f64) -> Self {
        let places = blocks.origins.iter().enumerate().map(|(at, origin)| (*origin, at)).collect();
        let active = blocks.tiles.iter().filter(|tile| tile.active);
        let tiles = active.map(|tile| ((tile.origin, tile.edge), tile.value)).collect();
        Self { blocks, places, tiles, origin, voxel_size }
    }

    /// The value at a world position: that of the voxel around it, where it is active.
    pub fn at(&self, position: DVec3) -> Option<T> {
        let voxel = ((position - self.origin) / self.voxel_size).round().as_ivec3();
        if let Some(&at) = self.places.get(&block_origin(voxel)) {
            let offset = voxel_offset(voxel);
            return is_active(&self.blocks.active[at], offset).then(|| self.blocks.values[at][offset]);
        }
        let tile = |edge: i32| self.tiles.get(&(node_origin(voxel, edge), edge));
        [8, 128, 4096].into_iter().find_map(tile).copied()
    }

    /// The same, and the background where no voxel is active.
    fn or_background(&self, position: DVec3) -> T {
        self.at(position).unwrap_or(self.blocks.background)
    }
}
