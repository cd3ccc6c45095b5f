//! A model made ready for frames: meshes read, the box of the whole shot and the voxel size known.

use std::collections::HashSet;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use crate::distance::band::Feet;
use crate::distance::extent;
use crate::field::Aabb;
use crate::grid::{Lattice, VoxelSize};

use crate::node::argument::Arguments;
use crate::node::assets::Assets;
use crate::node::attributes::{TheColour, TheScalar};
use crate::node::cache::Cache;
use crate::node::extent::{FindBox, box_about, box_of, no_box};
use crate::node::id::Stage;
use crate::node::measured::MOST_CELLS;
use crate::node::model::{Content, Model, Morph, ShapeId};
use crate::node::paint::surely_has;
use crate::node::solid::Solids;
use crate::node::variation::Variation;
use crate::shot::carry::untold;
use crate::shot::error::Error;
use crate::shot::far::far_out;
use crate::shot::level_sets::LevelSets;
use crate::shot::morphing::{Measuring, Pair, alike, empty_frames, extent_over_shot, found_pairs, pair, plan};
use crate::shot::plane::height;
use crate::shot::prepared::{Prepared, Ready};
use crate::shot::scenery::scenery;
use crate::shot::stop::{Stop, stop_if, unless_cancelled};
use crate::text::diagnostic::{Diagnostic, Diagnostics};
use crate::text::frames::sampled_frames;
use crate::text::number::plain_number;
use crate::text::problem::Problem;
use crate::text::sequence::FileSequence;

/// The finest voxels that OpenVDB takes, in world units.
const LEAST_VOXEL: f64 = 1.45e-5;
/// How many voxels away from the origin an object may reach: as far as bands go, see [`crate::distance::band`].
const MOST_VOXELS: f64 = (1 << 30) as f64;
/// What is measured to build a shape is measured no finer than this, voxels along the longest side, for an estimate.
const ROUGH_RESOLUTION: f64 = 64.0;
/// The least share of a morph that a cut is taken to leave, before it is known.
const LEAST_LEFT: f64 = 1.0 / 16.0;

/// What the command line says about a model's frames. `None` leaves the scene's own.
#[derive(Clone)]
pub struct PrepareOptions<'a> {
    /// A voxel's edge, world units. Comes before `resolution`.
    pub voxel_size: Option<f64>,
    /// Voxels along the longest side of the box of F ≥ 0 over the whole shot.
    pub resolution: Option<u32>,
    /// Half the band's width in voxels.
    pub half_width: Option<f64>,
    /// The most memory that a morph's frames, measuring one of its objects, and a volume of voxels, may take, in bytes;
    /// `None` for no limit of frames, and 4 GiB for an object or a volume.
    pub memory_limit: Option<usize>,
    /// Where measured objects are kept, to be used again.
    pub cache: Option<Arc<Cache>>,
    /// Set it to stop, now or while a frame is made: the result is [`Error::Cancelled`].
    pub cancel: Arc<AtomicBool>,
    /// Told the share done, 0 to 1, and what is being done, from any thread; only morphs take long.
    pub progress: &'a (dyn Fn(f64, &str) + Sync),
}

impl Default for PrepareOptions<'_> {
    fn default() -> Self {
        Self {
            voxel_size: None,
            resolution: None,
            half_width: None,
            memory_limit: None,
            cache: None,
            cancel: Arc::default(),
            progress: &|_, _| {},
        }
    }
}

impl Model {
    /// Makes ready for frames.
    pub fn prepare(self: &Arc<Self>, options: &PrepareOptions<'_>) -> Result<Prepared, Error> {
        let prepared = prepare(self, options, Precision::Full);
        unless_cancelled(&options.cancel, prepared.map_err(|stop| self.stopped(stop)))
    }

    /// Makes ready for estimates, in a fraction of the time: the objects of a morph are measured roughly, so that its box,
    /// the voxel size that follows from it, and its frames are about what they will be.
    pub fn outlook(self: &Arc<Self>, options: &PrepareOptions<'_>) -> Result<Prepared, Error> {
        let prepared = prepare(self, options, Precision::Rough);
        unless_cancelled(&options.cancel, prepared.map_err(|stop| self.stopped(stop)))
    }

    /// Whether it can be made ready, as far as that is known before anything is measured: files are read, shapes built and
    /// their boxes found.
    pub fn examine(self: &Arc<Self>, options: &PrepareOptions<'_>) -> Result<Diagnostics, Error> {
        let found = examine(self, options).map_err(|stop| self.stopped(stop));
        unless_cancelled(&options.cancel, found)
    }

    /// Why it stopped, with this scene's text.
    pub(crate) fn stopped(&self, stop: Stop) -> Error {
        match stop {
            Stop::Cancelled => Error::Cancelled,
            Stop::Memory { needed, limit, voxels } => Error::Memory { needed, limit, voxels },
            Stop::Problem(problem) => self.error(problem),
        }
    }
}

/// How well objects are measured.
#[derive(Clone, Copy, PartialEq)]
enum Precision {
    /// As frames need it.
    Full,
    /// As an estimate needs it.
    Rough,
}

/// A model with its files read and its shapes built as they are at the shot's beginning.
struct Built {
    parts: Vec<ShapeId>,
    assets: Arc<Assets>,
    variation: Variation,
    solids: Solids,
    warnings: Vec<Diagnostic>,
}

fn build(model: &Arc<Model>, options: &PrepareOptions<'_>, precision: Precision) -> Result<Built, Stop> {
    let roots = match &model.content {
        Content::Shape(id) => vec![*id],
        Content::Morph(morphs) => {
            let fill = morphs[0].fill.iter().flat_map(|fill| fill.structures);
            let objects = morphs.iter().flat_map(|morph| [morph.from, morph.to]);
            objects.chain(morphs[0].cut).chain(fill).collect()
        }
    };
    let parts = model.with_parts(&roots);
    let assets = Arc::new(Assets::load(model, &parts, options.memory_limit)?);
    let variation = Variation::of(model);
    stop_if(&options.cancel)?;
    let mut solids = Solids::new(
        model,
        &assets,
        model.moment(model.shot.range.first as f64),
        match precision {
            Precision::Full => resolution(model, options),
            Precision::Rough => resolution(model, options).min(ROUGH_RESOLUTION),
        },
        &options.cancel,
    );
    if let Some(cache) = &options.cache {
        solids.keep(cache);
    }
    let mut cut = solids.cut_by_bounds(&parts)?;
    // What changes is looked at in the middle and at the end too, the ends of most changes.
    let range = model.shot.range;
    for frame in [(range.first + range.last) as f64 / 2.0, range.last as f64].map(f64::round) {
        let told = |id: &ShapeId| cut.iter().any(|(other, _)| other == id);
        let changing: Vec<ShapeId> = parts.iter().copied().filter(|id| variation.own(*id) && !told(id)).collect();
        // What is wrong in a later frame is told when that is made.
        let found = solids.at(model.moment(frame), &variation).cut_by_bounds(&changing);
        cut.extend(found.unwrap_or_default());
    }
    let warnings = cut.into_iter().map(|(_, warning)| warning).collect();
    Ok(Built { parts, assets, variation, solids, warnings })
}

fn examine(model: &Arc<Model>, options: &PrepareOptions<'_>) -> Result<Diagnostics, Stop> {
    let Built { mut solids, variation, mut warnings, assets, .. } = build(model, options, Precision::Rough)?;
    match &model.content {
        Content::Shape(id) => {
            let extent = shape_box(model, &mut solids, &variation, *id, options, box_about)?;
            let about = lattice(model, options, extent)?;
            warnings.extend(coarse(model, extent, about.voxel_size.get()));
        }
        Content::Morph(morphs) => {
            let height = height(model, &mut solids, morphs)?;
            for morph in morphs {
                let pair = pair(model, &mut solids, &variation, morph, height, box_about)?;
                let about = lattice(model, options, pair.both)?;
                admit(model, morph, &pair, numbers_of(model, morphs), &about, options)?;
            }
        }
    }
    warnings.extend(assets.warnings());
    Ok(Diagnostics::new(warnings, model.sources.clone()))
}

fn prepare(model: &Arc<Model>, options: &PrepareOptions<'_>, precision: Precision) -> Result<Prepared, Stop> {
    let Built { parts, assets, variation, mut solids, mut warnings } = build(model, options, precision)?;
    let (content, extent, lattice) = match &model.content {
        Content::Shape(id) => ready_shape(model, &mut solids, &variation, *id, options)?,
        Content::Morph(morphs) => ready_morphs(model, &mut solids, &variation, morphs, options, precision)?,
    };
    warnings.extend(assets.warnings());
    warnings.extend(coarse(model, extent, lattice.voxel_size.get()));
    warnings.extend(far_out(model, &mut solids, &parts, lattice.voxel_size.get()));
    warnings.extend(solids.insides.take_warnings());
    if let (Content::Morph(morphs), Ready::Morph(planned)) = (&model.content, &content) {
        warnings.extend(empty_frames(model, morphs, planned));
        warnings.extend(morphs.iter().zip(planned).flat_map(|(morph, planned)| untold(model, morph, &planned.morph)));
        warnings.extend(morphs.iter().zip(planned).filter_map(|(morph, planned)| found_pairs(model, morph, planned)));
    }
    let mut prepared = Prepared {
        lattice,
        half_width: options.half_width.unwrap_or(model.output.half_width) as f32,
        extent,
        warnings: Diagnostics::new(warnings, model.sources.clone()),
        model: Arc::clone(model),
        parts,
        assets,
        variation,
        content,
        base: solids,
        level_sets: None,
        feet: Feet::Nearest,
        roughly: precision == Precision::Rough && matches!(model.content, Content::Morph(_)),
        cancel: Arc::clone(&options.cancel),
    };
    let way = prepared.greatest_displacement()?;
    if way > 0.0 {
        prepared.extent = prepared.extent.grown(way);
        prepared.lattice = self::lattice(model, options, prepared.extent)?;
    }
    if let (Content::Morph(morphs), Ready::Morph(planned)) = (&model.content, &prepared.content)
        && morphs[0].mode.spec.by_level_sets
        && precision == Precision::Full
    {
        let Prepared { lattice, half_width, .. } = prepared;
        let cancel = Arc::clone(&options.cancel);
        let sets = LevelSets::new(model, &morphs[0], &planned[0], lattice, half_width, cancel)?;
        prepared.level_sets = Some(sets);
    }
    Ok(prepared)
}

/// A tree of distances to be written whose least cells, by the depth that the scene asks for, are larger than voxels.
fn coarse(model: &Model, extent: Aabb, voxel: f64) -> Option<Diagnostic> {
    let choice = model.written_distance();
    let (depth, span) = (choice.depth?, model.written_distance_span()?);
    let (cell, fine) = (choice.smallest_cell(extent)?, choice.depth_for(extent, voxel));
    // Boxes found for a check are a little larger.
    (cell > 1.1 * voxel).then(|| {
        let problem = format!(
            "`{} = {depth}` has cells as large as {:.1} voxels: what is thinner is lost, and distances beside the surface may be \
             those of another place",
            choice.method,
            cell / voxel
        );
        let help = format!("`{} = {fine}` has cells as small as voxels, and so has it without a number", choice.method);
        Diagnostic::warning(span, problem).help(help)
    })
}

/// Whether a shape is built for each frame.
fn changes(variation: &Variation, id: ShapeId) -> bool {
    variation.placed(id) || variation.painted(id)
}

/// The box of a shape over the whole shot.
fn shape_box(
    model: &Model,
    solids: &mut Solids,
    variation: &Variation,
    id: ShapeId,
    options: &PrepareOptions<'_>,
    find: FindBox,
) -> Result<Aabb, Stop> {
    if changes(variation, id) {
        solids.build_still(&model.with_parts(&[id]), variation);
        return box_over_shot(model, solids, variation, id, options, find);
    }
    let field = solids.field(id, Stage::Placed)?;
    Ok(find(field.as_ref()).map_err(|error| no_box(model, id, error))?)
}

fn ready_shape(
    model: &Model,
    solids: &mut Solids,
    variation: &Variation,
    id: ShapeId,
    options: &PrepareOptions<'_>,
) -> Result<(Ready, Aabb, Lattice), Stop> {
    let extent = shape_box(model, solids, variation, id, options, box_of)?;
    let lattice = lattice(model, options, extent)?;
    if changes(variation, id) {
        let is_kept = |part: &ShapeId| model.shape(*part).has_seam() || model.shape(*part).is_conformal();
        if model.with_parts(&[id]).iter().any(is_kept) {
            // What parts that stand still are measured for is kept, and insides that are; what cannot be is said when a frame
            // needs it.
            let _ = scenery(solids, id, &lattice);
        }
        return Ok((Ready::Changing(id), extent, lattice));
    }
    Ok((Ready::Still(scenery(solids, id, &lattice)?), extent, lattice))
}

/// The share that measuring its objects has in the time that making a morph ready takes.
const MEASURING: f64 = 0.9;
/// What comes after it.
const PLANNING: &str = "finding the shot's box";

fn ready_morphs(
    model: &Arc<Model>,
    solids: &mut Solids,
    variation: &Variation,
    morphs: &[Morph],
    options: &PrepareOptions<'_>,
    precision: Precision,
) -> Result<(Ready, Aabb, Lattice), Stop> {
    let height = height(model, solids, morphs)?;
    let pairs = morphs.iter().map(|morph| pair(model, solids, variation, morph, height, box_of));
    let pairs = pairs.collect::<Result<Vec<_>, _>>()?;
    let both = pairs.iter().map(|pair| pair.both).reduce(Aabb::union).expect("a chain has a morph");
    // The in-betweens' box is known only once the objects are measured; about a voxel is enough for that.
    let about = lattice(model, options, both)?;
    let numbers = numbers_of(model, morphs);
    for (morph, pair) in morphs.iter().zip(&pairs) {
        admit(model, morph, pair, numbers, &about, options)?;
    }
    let mut measuring = Measuring {
        roughly: precision == Precision::Rough,
        cache: options.cache.as_deref(),
        resolution: resolution(model, options),
        voxel: about.voxel_size.get(),
        memory_limit: options.memory_limit,
        cancel: &options.cancel,
        progress: &|share, what| (options.progress)(MEASURING * share, what),
        count: pairs.iter().flat_map(Pair::shapes).collect::<HashSet<_>>().len(),
        done: Vec::new(),
    };
    let mut planned = Vec::new();
    for (morph, pair) in morphs.iter().zip(pairs) {
        planned.push(plan(model, solids, morph, pair, &mut measuring)?);
    }
    alike(&mut planned);
    (options.progress)(MEASURING, PLANNING);
    let mut extent = extent_over_shot(model, morphs, &planned)?;
    let carried = planned.iter().any(|planned| planned.morph.is_carried());
    if precision == Precision::Rough && !carried {
        // What rough distances bulge by is no object; what is carried may leave the boxes of both.
        extent = extent.intersection(both).unwrap_or(extent);
    }
    (options.progress)(1.0, PLANNING);
    Ok((Ready::Morph(planned), extent, lattice(model, options, extent)?))
}

/// How many numbers a voxel has at least in the grids beside the level set, before anything is built.
fn numbers_of(model: &Model, morphs: &[Morph]) -> usize {
    let output = &model.output;
    let objects = || morphs.iter().flat_map(|morph| [morph.from, morph.to]);
    let colour = output.writes(&output.colour_name) && objects().any(|id| surely_has(model, TheColour, id));
    let has = |name: &&str| output.writes(name) && objects().any(|id| surely_has(model, TheScalar(name), id));
    (if colour { 3 } else { 0 }) + model.scalar_names().into_iter().filter(has).count()
}

/// Refuses a morph whose frames, of so many numbers a voxel beside the distance, cannot but take too much memory, before
/// its objects are measured.
///
/// Judged by the lesser of the two objects as they are: no in-between is much smaller than both.
fn admit(
    model: &Model,
    morph: &Morph,
    pair: &Pair,
    numbers: usize,
    about: &Lattice,
    options: &PrepareOptions<'_>,
) -> Result<(), Stop> {
    let Some(limit) = options.memory_limit else { return Ok(()) };
    let half_width = options.half_width.unwrap_or(model.output.half_width) as f32;
    let [from, to] = pair.bands(about.voxel_size.get(), half_width);
    let least = if from.voxels < to.voxels { from } else { to };
    let mut needed = least.memory(numbers, 1);
    if morph.cut.is_some() {
        needed *= LEAST_LEFT;
    }
    if needed <= limit as f64 {
        return Ok(());
    }
    Err(Stop::Memory { needed: needed as u64, limit: limit as u64, voxels: least.voxels })
}

/// The box over all frames of the shot. Some may be empty, which is for whoever asks for them to judge; not all.
fn box_over_shot(
    model: &Model,
    solids: &Solids,
    variation: &Variation,
    id: ShapeId,
    options: &PrepareOptions<'_>,
    find: FindBox,
) -> Result<Aabb, Stop> {
    let shot = model.shot.range;
    let by_file = model.with_parts(&[id]).into_iter().any(|part| {
        let mut sequences = model.shape(part).all_arguments().filter_map(Arguments::sequence);
        sequences.any(FileSequence::varies)
    });
    let frames = match variation.placed(id) {
        // No file tells of another one's box.
        true if by_file => (shot.first..=shot.last).map(|frame| frame as f64).collect(),
        true => sampled_frames(shot),
        false => vec![shot.first as f64],
    };
    let one = |frame: &f64| -> Result<Result<Aabb, extent::Error>, Stop> {
        stop_if(&options.cancel)?;
        let mut solids = solids.at(model.moment(*frame), variation);
        Ok(find(solids.field(id, Stage::Placed)?.as_ref()))
    };
    // One file after the other: all at a time may not fit into the memory.
    let boxes: Result<Vec<_>, Stop> =
        if by_file { frames.iter().map(one).collect() } else { frames.par_iter().map(one).collect() };
    let union = |a, b| match (a, b) {
        (Ok(a), Ok(b)) => Ok(Aabb::union(a, b)),
        (Err(extent::Error::Empty), other) | (other, Err(extent::Error::Empty)) => other,
        (wrong, _) => wrong,
    };
    let all = boxes?.into_iter().reduce(union).expect("a shot has a frame");
    Ok(all.map_err(|error| no_box(model, id, error))?)
}

/// About how many voxels go along the longest side: no more than distances are measured on where their size is given.
fn resolution(model: &Model, options: &PrepareOptions<'_>) -> f64 {
    match (options.voxel_size, options.resolution, model.output.voxel_size) {
        (None, Some(resolution), _) => f64::from(resolution),
        (None, None, None) => f64::from(model.output.resolution),
        _ => MOST_CELLS,
    }
}

/// Where the voxels stand: by their size, or by how many go along the longest side.
fn lattice(model: &Model, options: &PrepareOptions<'_>, box_of_all: Aabb) -> Result<Lattice, Problem> {
    let by_resolution = |resolution: u32| box_of_all.size().max_element() / f64::from(resolution);
    let edge = match (options.voxel_size, options.resolution, model.output.voxel_size) {
        (Some(edge), _, _) => edge,
        (None, Some(resolution), _) => by_resolution(resolution),
        (None, None, Some(edge)) => edge,
        (None, None, None) => by_resolution(model.output.resolution),
    };
    let Some(voxel_size) = VoxelSize::new(edge).filter(|size| size.get() >= LEAST_VOXEL) else {
        let problem = format!(
            "voxels of {edge:e} {} are too small for OpenVDB, which takes {LEAST_VOXEL:e} and more",
            model.unit
        );
        return Err(Problem(Box::new(
            Diagnostic::without_place(problem)
                .help("build in a smaller `unit`: the same scene in millimetres has numbers 1000 times as large"),
        )));
    };
    let voxels = box_of_all.min.abs().max(box_of_all.max.abs()).max_element() / edge;
    if voxels >= MOST_VOXELS {
        let problem = format!(
            "the object reaches {voxels:.3e} voxels of {} {} from the origin, and OpenVDB numbers {MOST_VOXELS} at most",
            plain_number(edge),
            model.unit
        );
        return Err(Problem(Box::new(
            Diagnostic::without_place(problem).help("use larger voxels, or bring the object nearer to the origin"),
        )));
    }
    Ok(Lattice { voxel_size })
}
