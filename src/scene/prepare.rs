//! A model made ready for frames: meshes read, the box of the whole shot and the voxel size known.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::attribute::{Colour, Scalar, Straight};
use crate::distance::extent::{self, extent};
use crate::distance::nearest::Watch;
use crate::distance::without::Keep;
use crate::field::{Aabb, Field};
use crate::grid::{Lattice, VoxelSize};
use crate::morph::{FrameReport, Movement};

use super::assets::Assets;
use super::diagnostic::{Diagnostic, Diagnostics, listed};
use super::error::{Error, Problem};
use super::frames::{FrameRange, Shot};
use super::model::{AttributeSource, Content, Model, Morph, ShapeId};
use super::morphing::{Brush, Measuring, Pair, Planned, empty_frames, extent_over_shot, pair, plan, shown_at};
use super::paint::{Asked, Paint, Scenery, TheColour, TheScalar};
use super::solid::{Solids, Stage};
use super::source::Span;
use super::variation::Variation;

/// The finest voxels that OpenVDB takes, in world units.
const LEAST_VOXEL: f64 = 1.45e-5;
/// The least share of a morph that a cut is taken to leave, before it is known.
const LEAST_LEFT: f64 = 1.0 / 16.0;
/// The most frames at which the box of a shape that changes is taken; more frames are sampled evenly.
const MOST_BOXES: usize = 200;

/// What the command line says about a model's frames. `None` leaves the scene's own.
#[derive(Clone, Copy)]
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
    /// Set it to stop: the result is [`Error::Cancelled`].
    pub cancel: &'a AtomicBool,
    /// Told the share done, 0 to 1, from any thread.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

/// A model made ready: any frame can be had from it, in any order, from any thread.
pub struct Prepared {
    /// Where the voxels stand.
    pub lattice: Lattice,
    /// Half the band's width in voxels.
    pub half_width: f32,
    /// The box of F ≥ 0 over the whole shot, band not counted.
    pub extent: Aabb,
    /// What was noticed, with places in the scene.
    pub warnings: Diagnostics,
    pub(super) model: Arc<Model>,
    /// All shapes that it is made from or painted by.
    parts: Vec<ShapeId>,
    assets: Arc<Assets>,
    pub(super) variation: Variation,
    pub(super) content: Ready,
    /// All that does not change, built.
    pub(super) base: Solids,
}

/// What frames are made from.
pub(super) enum Ready {
    /// A shape that never changes.
    Still(Scenery),
    /// A shape that is built for each frame.
    Changing(ShapeId),
    /// A chain of morphs.
    Morph(Vec<Planned>),
}

/// All that a frame's grids are computed from.
#[derive(Clone)]
pub struct FrameContent {
    /// F, world units.
    pub field: Arc<dyn Field>,
    /// The colour; `None` where nothing in the scene has one, or its grid is not to be written.
    pub colour: Option<Arc<Colour>>,
    /// The scalars of the grids that are to be written, by their names, sorted.
    pub scalars: Vec<(String, Arc<Scalar>)>,
    /// How the surface moves; `None` where `vel` is not to be written.
    pub movement: Option<Movement>,
    /// Where to look for the band: the solid's box grown by the band.
    pub region: Aabb,
    /// Which pieces of the solid stay.
    pub keep: Keep,
    /// The frame's place in time.
    pub info: FrameInfo,
}

/// Numbers on a frame of a morph.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MorphReport {
    /// Its volume and what changed since the frame before.
    #[serde(flatten)]
    pub numbers: FrameReport,
    /// The farthest that the surface went since the frame before, world units, to a part of a cell of the morph's coarse
    /// grid; 0 in the shot's first.
    pub displacement: f64,
}

/// A frame's place in time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInfo {
    /// The frame that was asked for.
    pub frame: i64,
    /// Scene time: 0 at the shot's first frame, 1 at its last.
    pub t: f64,
    /// Whether the frame lies outside of the shot, where the ends hold.
    pub outside_shot: bool,
}

impl Model {
    /// Makes ready for frames.
    pub fn prepare(self: &Arc<Self>, options: &PrepareOptions<'_>) -> Result<Prepared, Error> {
        prepare(self, options).map_err(|stop| match stop {
            Stop::Cancelled => Error::Cancelled,
            Stop::Memory { needed, limit, voxels } => Error::Memory { needed, limit, voxels },
            Stop::Problem(problem) => self.error(problem),
        })
    }
}

/// Why preparing stopped.
pub(super) enum Stop {
    Cancelled,
    Memory { needed: u64, limit: u64, voxels: f64 },
    Problem(Problem),
}

impl From<Problem> for Stop {
    fn from(problem: Problem) -> Self {
        Self::Problem(problem)
    }
}

fn prepare(model: &Arc<Model>, options: &PrepareOptions<'_>) -> Result<Prepared, Stop> {
    let roots = match &model.content {
        Content::Shape(id) => vec![*id],
        Content::Morph(morphs) => {
            morphs.iter().flat_map(|morph| [morph.from, morph.to].into_iter().chain(morph.cut)).collect()
        }
    };
    let parts = model.with_parts(&roots);
    let assets = Arc::new(Assets::load(model, &parts, options.memory_limit)?);
    let variation = Variation::of(model);
    stop_if(options.cancel)?;
    let mut solids = Solids::new(model, &assets, model.moment(model.shot.range.first as f64));
    let mut warnings = solids.cut_by_bounds(&parts)?;
    let (content, extent, lattice) = match &model.content {
        Content::Shape(id) => ready_shape(model, &mut solids, &variation, *id, options)?,
        Content::Morph(morphs) => ready_morphs(model, &mut solids, &variation, morphs, options)?,
    };
    if let (Content::Morph(morphs), Ready::Morph(planned)) = (&model.content, &content) {
        warnings.extend(empty_frames(model, morphs, planned));
    }
    Ok(Prepared {
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
    })
}

fn ready_shape(
    model: &Model,
    solids: &mut Solids,
    variation: &Variation,
    id: ShapeId,
    options: &PrepareOptions<'_>,
) -> Result<(Ready, Aabb, Lattice), Stop> {
    if variation.placed(id) || variation.painted(id) {
        solids.build_still(&model.with_parts(&[id]), variation);
        let extent = box_over_shot(model, solids, variation, id, options)?;
        return Ok((Ready::Changing(id), extent, lattice(model, options, extent)?));
    }
    let extent = solid_box(model, id, solids.field(id, Stage::Placed)?.as_ref())?;
    let lattice = lattice(model, options, extent)?;
    Ok((Ready::Still(scenery(solids, id, &lattice)?), extent, lattice))
}

fn ready_morphs(
    model: &Arc<Model>,
    solids: &mut Solids,
    variation: &Variation,
    morphs: &[Morph],
    options: &PrepareOptions<'_>,
) -> Result<(Ready, Aabb, Lattice), Stop> {
    let pairs = morphs.iter().map(|morph| pair(model, solids, variation, morph)).collect::<Result<Vec<_>, _>>()?;
    let both = pairs.iter().map(|pair| pair.both).reduce(Aabb::union).expect("a chain has a morph");
    // The in-betweens' box is known only once the objects are measured; about a voxel is enough for that.
    let about = lattice(model, options, both)?;
    for (morph, pair) in morphs.iter().zip(&pairs) {
        admit(model, morph, pair, &about, options)?;
    }
    let mut measuring = Measuring {
        voxel: about.voxel_size.get(),
        memory_limit: options.memory_limit,
        watch: Watch { cancel: options.cancel, progress: options.progress },
        done: Vec::new(),
    };
    let mut planned = Vec::new();
    for (morph, pair) in morphs.iter().zip(pairs) {
        planned.push(plan(model, solids, morph, pair, &mut measuring)?);
    }
    alike(&mut planned);
    let extent = extent_over_shot(model, morphs, &planned)?;
    Ok((Ready::Morph(planned), extent, lattice(model, options, extent)?))
}

/// Gives all morphs of a chain the same grids: where none of a morph's objects has an attribute, it is what shapes
/// without it count as.
fn alike(chain: &mut [Planned]) {
    let has_colour = chain.iter().any(|planned| planned.has_colour);
    let names: BTreeSet<String> =
        chain.iter().flat_map(|planned| planned.scalars.iter().map(|(name, _)| name.clone())).collect();
    for planned in chain {
        planned.has_colour = has_colour;
        for (place, name) in names.iter().enumerate() {
            if planned.scalars.get(place).is_none_or(|(there, _)| there != name) {
                let absent = || Paint::solid(TheScalar(name).absent()).attribute;
                planned.scalars.insert(place, (name.clone(), [absent(), absent()]));
            }
        }
    }
}

/// Refuses a morph whose frames cannot but take too much memory, before its objects are measured.
///
/// Judged by the lesser of the two objects as they are: no in-between is much smaller than both.
fn admit(model: &Model, morph: &Morph, pair: &Pair, about: &Lattice, options: &PrepareOptions<'_>) -> Result<(), Stop> {
    let Some(limit) = options.memory_limit else { return Ok(()) };
    let half_width = options.half_width.unwrap_or(model.output.half_width) as f32;
    let [from, to] = pair.bands(about.voxel_size.get(), half_width);
    let least = if from.voxels < to.voxels { from } else { to };
    let mut needed = least.memory(0);
    if morph.cut.is_some() {
        needed *= LEAST_LEFT;
    }
    if needed <= limit as f64 {
        return Ok(());
    }
    Err(Stop::Memory { needed: needed as u64, limit: limit as u64, voxels: least.voxels })
}

fn stop_if(cancel: &AtomicBool) -> Result<(), Stop> {
    if cancel.load(Ordering::Relaxed) { Err(Stop::Cancelled) } else { Ok(()) }
}

/// A shape's field and attributes, as far as they are to be written.
fn scenery(solids: &mut Solids, id: ShapeId, lattice: &Lattice) -> Result<Scenery, Problem> {
    let field = solids.field(id, Stage::Placed)?;
    let (model, voxel) = (solids.model(), lattice.voxel_size.get());
    let mut colour = None;
    if model.output.writes(&model.output.colour_name) {
        colour = solids.paint(TheColour, id, Stage::Placed, voxel)?;
    }
    let mut scalars = Vec::new();
    for name in model.scalar_names().into_iter().filter(|name| model.output.writes(name)) {
        if let Some(paint) = solids.paint(TheScalar(name), id, Stage::Placed, voxel)? {
            scalars.push((name.to_owned(), paint.attribute));
        }
    }
    Ok(Scenery { field, colour: colour.map(|paint| paint.attribute), scalars })
}

/// The box of F ≥ 0.
pub(super) fn box_of(field: &dyn Field) -> Result<Aabb, extent::Error> {
    let solid = extent(field, None)?.solid;
    if solid.size().max_element() > 0.0 { Ok(solid) } else { Err(extent::Error::Empty) }
}

/// The box of F ≥ 0, or what is wrong with the shape.
pub(super) fn solid_box(model: &Model, id: ShapeId, field: &dyn Field) -> Result<Aabb, Problem> {
    box_of(field).map_err(|error| no_box(model, id, error))
}

/// What is wrong with a shape that has no box.
fn no_box(model: &Model, id: ShapeId, error: extent::Error) -> Problem {
    let shape = model.shape(id);
    match error {
        extent::Error::Unbounded => {
            let culprit = model.unbounded_part(id);
            let problem = format!("`{}` may reach to infinity", model.shape(culprit).name);
            Problem::new(model.shape(culprit).span, problem)
                .help("give it `bounds`, or intersect it with a shape that ends")
        }
        extent::Error::Empty => Problem::new(shape.span, format!("nothing is inside `{}`", shape.name))
            .help("F is negative everywhere: check the signs (positive is inside), the sizes and the bounds"),
    }
}

/// The box over all frames of the shot. Some may be empty, which is for whoever asks for them to judge; not all.
fn box_over_shot(
    model: &Model,
    solids: &Solids,
    variation: &Variation,
    id: ShapeId,
    options: &PrepareOptions<'_>,
) -> Result<Aabb, Stop> {
    let frames =
        if variation.placed(id) { sampled_frames(model.shot.range) } else { vec![model.shot.range.first as f64] };
    let one = |frame: &f64| -> Result<Result<Aabb, extent::Error>, Stop> {
        stop_if(options.cancel)?;
        let mut solids = solids.at(model.moment(*frame), variation);
        Ok(box_of(solids.field(id, Stage::Placed)?.as_ref()))
    };
    let boxes: Result<Vec<_>, Stop> = frames.par_iter().map(one).collect();
    let union = |a, b| match (a, b) {
        (Ok(a), Ok(b)) => Ok(Aabb::union(a, b)),
        (Err(extent::Error::Empty), other) | (other, Err(extent::Error::Empty)) => other,
        (wrong, _) => wrong,
    };
    let all = boxes?.into_iter().reduce(union).expect("a shot has a frame");
    Ok(all.map_err(|error| no_box(model, id, error))?)
}

/// All frames of a range, or as many as are looked at, evenly, with both ends.
pub(super) fn sampled_frames(range: FrameRange) -> Vec<f64> {
    let FrameRange { first, last } = range;
    if range.count() <= MOST_BOXES {
        return (first..=last).map(|frame| frame as f64).collect();
    }
    (0..MOST_BOXES).map(|i| first as f64 + (last - first) as f64 * (i as f64 / (MOST_BOXES - 1) as f64)).collect()
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
    let voxel_size = VoxelSize::new(edge).filter(|size| size.get() >= LEAST_VOXEL);
    voxel_size.map(|voxel_size| Lattice { voxel_size }).ok_or_else(|| {
        let problem = format!(
            "voxels of {edge:e} {} are too small for OpenVDB, which takes {LEAST_VOXEL:e} and more",
            model.unit
        );
        Problem(Box::new(
            Diagnostic::without_place(problem)
                .help("build in a smaller `unit`: the same scene in millimetres has numbers 1000 times as large"),
        ))
    })
}

impl Model {
    /// The innermost part that makes a shape endless, as far as the parts tell by themselves.
    fn unbounded_part(&self, id: ShapeId) -> ShapeId {
        use super::model::Maker;
        let endless =
            |maker: &Maker| matches!(maker, Maker::HalfSpace { .. } | Maker::Slab { .. } | Maker::Formula { .. });
        let mut at = id;
        while let Maker::Union { operands, .. } = &self.shape(at).maker {
            let candidates = |test: &dyn Fn(&Maker) -> bool| {
                operands
                    .iter()
                    .copied()
                    .find(|part| self.shape(*part).bounds.is_none() && test(&self.shape(*part).maker))
            };
            let next = candidates(&endless).or_else(|| candidates(&|maker| matches!(maker, Maker::Union { .. })));
            match next {
                Some(part) => at = part,
                None => break,
            }
        }
        at
    }
}

impl Prepared {
    /// The model.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// All that one frame is computed from, whatever other frames are asked for.
    pub fn frame(&self, frame: i64) -> Result<FrameContent, Error> {
        let info = self.info(frame);
        let scenery = match &self.content {
            Ready::Still(scenery) => scenery.clone(),
            Ready::Changing(id) => self.changing(*id, frame).map_err(|problem| self.model.error(problem))?,
            Ready::Morph(planned) => {
                let planned = &planned[self.shown(frame as f64)];
                let whole = planned.morph.field(info.t);
                let field = self.cut(whole, frame as f64).map_err(|problem| self.model.error(problem))?;
                let colour = self.morph_colour(planned, &info).map_err(|problem| self.model.error(problem))?;
                let scalars = self.morph_scalars(planned, &info).map_err(|problem| self.model.error(problem))?;
                Scenery { field, colour, scalars }
            }
        };
        let margin = (f64::from(self.half_width) + 2.0) * self.lattice.voxel_size.get();
        let region = scenery.field.bounding_box().unwrap_or(self.extent).grown(margin);
        let keep = match &self.model.content {
            Content::Morph(morphs) => morphs[0].keep,
            Content::Shape(_) => Keep::ALL,
        };
        let Scenery { field, colour, scalars } = scenery;
        let mut movement = None;
        if self.model.output.writes("vel") {
            movement = Some(self.movement(frame).map_err(|problem| self.model.error(problem))?);
        }
        Ok(FrameContent { field, colour, scalars, movement, region, keep, info })
    }

    /// Numbers on a morph's frame and on the way to it from the one before, measured on the morph's coarse grid; `None`
    /// where the scene is no morph. The same whatever else is asked for.
    pub fn report(&self, frame: i64) -> Option<MorphReport> {
        let Ready::Morph(planned) = &self.content else { return None };
        let range = self.model.shot.range;
        let (frame, before) = (frame.clamp(range.first, range.last), (frame - 1).clamp(range.first, range.last));
        let [from, to] = [before, frame].map(|frame| range.share(frame as f64));
        // A chain's object at its own frame is the end of the morph to it.
        let morph = &planned[self.shown(before as f64)].morph;
        let numbers = morph.report(&[from, to]).frames.pop()?;
        let displacement = if before == frame { 0.0 } else { morph.displacement(from, to) };
        Some(MorphReport { numbers, displacement })
    }

    /// Which morph of a chain a frame shows.
    pub(super) fn shown(&self, frame: f64) -> usize {
        match &self.model.content {
            Content::Morph(morphs) => shown_at(morphs, frame),
            Content::Shape(_) => 0,
        }
    }

    /// A morph's field without what is to be taken away.
    pub(super) fn cut(&self, whole: Arc<dyn Field>, frame: f64) -> Result<Arc<dyn Field>, Problem> {
        let Content::Morph(morphs) = &self.model.content else { return Ok(whole) };
        let Some(cut) = morphs[0].cut else { return Ok(whole) };
        self.base.at(self.model.moment(frame), &self.variation).without(whole, cut)
    }

    /// A morph's colour; `None` where nothing in it has one. Colours that change over time are made for the frame.
    fn morph_colour(&self, planned: &Planned, info: &FrameInfo) -> Result<Option<Arc<Colour>>, Problem> {
        if !planned.has_colour || !self.model.output.writes(&self.model.output.colour_name) {
            return Ok(None);
        }
        let now =
            |brush: &Brush| self.repainted(TheColour, brush, info).map(|paint| paint.map(|paint| paint.attribute));
        Ok(Some(planned.morph.colour_of(info.t, now(&planned.from)?, now(&planned.to)?)))
    }

    /// A morph's scalars, mixed by the weights of colours.
    fn morph_scalars(&self, planned: &Planned, info: &FrameInfo) -> Result<Vec<(String, Arc<Scalar>)>, Problem> {
        let mut scalars = Vec::new();
        for (name, [from, to]) in planned.scalars.iter().filter(|(name, _)| self.model.output.writes(name)) {
            let now = |brush: &Brush, known: &Arc<Scalar>| -> Result<Arc<Scalar>, Problem> {
                let now = self.repainted(TheScalar(name), brush, info)?;
                Ok(now.map_or_else(|| Arc::clone(known), |paint| paint.attribute))
            };
            let (from, to) = (now(&planned.from, from)?, now(&planned.to, to)?);
            scalars.push((name.clone(), planned.morph.attribute(info.t, from, to, Straight)));
        }
        Ok(scalars)
    }

    /// An attribute of a morph's object as it is in a frame; `None` where it does not change over time.
    fn repainted<const N: usize>(
        &self,
        what: impl Asked<N>,
        brush: &Brush,
        info: &FrameInfo,
    ) -> Result<Option<Paint<N>>, Problem> {
        if !self.variation.painted(brush.id) {
            return Ok(None);
        }
        let mut solids = self.base.at(self.model.moment(info.frame as f64), &self.variation);
        solids.paint(what, brush.id, brush.stage, brush.voxel)
    }

    fn changing(&self, id: ShapeId, frame: i64) -> Result<Scenery, Problem> {
        let mut solids = self.base.at(self.model.moment(frame as f64), &self.variation);
        scenery(&mut solids, id, &self.lattice)
    }

    fn info(&self, frame: i64) -> FrameInfo {
        let Shot { range, .. } = self.model.shot;
        FrameInfo { frame, t: range.share(frame as f64), outside_shot: !(range.first..=range.last).contains(&frame) }
    }

    /// A problem with a value of a grid, the colour's or a scalar's, as an error that points to the formulas it can come
    /// from; `None` where none of them is a formula.
    pub fn attribute_problem(&self, grid: &str, problem: &str) -> Option<Error> {
        let is_colour = grid == self.model.output.colour_name;
        let span = |id: ShapeId| {
            let shape = self.model.shape(id);
            let scalar = shape.scalars.get(grid).and_then(AttributeSource::formula);
            if is_colour { shape.colour.as_ref().and_then(AttributeSource::formula) } else { scalar }
        };
        let named = |id: &ShapeId| Some((self.model.shape(*id).name.clone(), span(*id)?));
        let found: Vec<(String, Span)> = self.parts.iter().filter_map(named).collect();
        let help = "keep its formulas from dividing by 0, and from roots and logarithms of negative numbers";
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        let problem = match found.as_slice() {
            [] => return None,
            [(_, span)] => Diagnostic::error(*span, problem).help(help),
            [(_, span), ..] => {
                Diagnostic::error(*span, problem).help(format!("it is that of one of {}; {help}", listed(&names)))
            }
        };
        Some(self.model.error(Problem(Box::new(problem))))
    }

    /// About how much memory the prepared scene itself holds, in bytes: frames come on top.
    pub fn memory_estimate(&self) -> u64 {
        let distances = match &self.content {
            Ready::Morph(planned) => planned.iter().map(|planned| planned.bytes).sum(),
            _ => 0,
        };
        self.assets.bytes() + distances
    }
}
