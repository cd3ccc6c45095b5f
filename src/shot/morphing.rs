//! The morph of a scene: two objects with their motion, measured once, planned once.

use std::collections::BTreeSet;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use rayon::prelude::*;

use crate::attribute::Scalar;
use crate::distance::Distance;
use crate::distance::descent::Scope;
use crate::distance::extent::{Effort, Estimate, estimate};
use crate::distance::method::{Measured, Method, Request, Rough};
use crate::distance::nearest::Watch;
use crate::distance::octree;
use crate::field::{Aabb, Field};
use crate::grid::{Lattice, VoxelSize};
use crate::morph::{self, MorphObject, Motion, Side};

use crate::node::argument::Arguments;
use crate::node::attributes::{Asked, TheColour, TheScalar};
use crate::node::cache::{Cache, Claim};
use crate::node::extent::{FindBox, box_of, no_box, solid_box};
use crate::node::id::Stage;
use crate::node::measured::smallest_cell;
use crate::node::model::{Model, Morph, Pairs, ShapeId};
use crate::node::morphed::planned_or_kept;
use crate::node::painted::Paint;
use crate::node::solid::Solids;
use crate::node::variation::Variation;
use crate::shot::carry::{anchors_problem, carry};
use crate::shot::delay::delay;
use crate::shot::matching::matched;
use crate::shot::morph_settings::settings;
use crate::shot::placed::{motion, scale_is_uniform, stands, whole};
use crate::shot::plane::{extruded, plane, profile, thick};
use crate::shot::stop::Stop;
use crate::text::diagnostic::{Diagnostic, Severity, clip};
use crate::text::frames::sampled_frames;
use crate::text::frames::{in_ranges, plain};
use crate::text::problem::Problem;

/// One of the two objects before it is measured.
#[derive(Clone)]
pub(crate) struct Object {
    id: ShapeId,
    stage: Stage,
    field: Arc<dyn Field>,
    solid: Aabb,
    motion: Motion,
    /// Whether it is a shape of the plane, with the field of one; the box is that of what is extruded.
    is_flat: bool,
}

impl Object {
    /// The shape that it is, and how far it is made.
    fn what(&self) -> (ShapeId, Stage) {
        (self.id, self.stage)
    }

    /// About what a level set of it takes, of voxels with this edge in its own space.
    fn band(&self, edge: f64, half_width: f32) -> Estimate {
        let Some(voxel_size) = VoxelSize::new(edge) else { return Estimate::default() };
        let region = self.solid.grown((f64::from(half_width) + 2.0) * edge);
        let scope = Scope { lattice: Lattice { voxel_size }, half_width, region };
        let extruded = self.is_flat.then(|| extruded(&self.field, self.solid));
        estimate(extruded.as_ref().unwrap_or(&self.field).as_ref(), &scope, Effort::Careful)
    }

    /// A voxel's edge in the object's own space: it may be made larger where it stands.
    fn voxel(&self, voxel: f64) -> f64 {
        voxel / self.motion.at(0.0).scale()
    }

    /// The edge of the smallest cells that its distances need there.
    fn cell(&self, voxel: f64) -> f64 {
        smallest_cell(self.voxel(voxel), &self.solid)
    }
}

/// What both objects of a morph are, before anything depends on the voxel size.
pub(crate) struct Pair {
    from: Object,
    to: Object,
    /// Their corresponding parts, each in its object's space.
    parts: Vec<[Object; 2]>,
    /// The box around both over the whole shot.
    pub both: Aabb,
    /// How far the morph of shapes of the plane is extruded, in its own units.
    height: Option<f64>,
}

impl Pair {
    /// The shapes to measure.
    pub fn shapes(&self) -> impl Iterator<Item = (ShapeId, Stage)> {
        let all = [&self.from, &self.to].into_iter().chain(self.parts.iter().flatten());
        all.map(Object::what)
    }

    /// About what a level set of either object takes, each where the shot begins. `voxel` is a voxel's edge.
    pub fn bands(&self, voxel: f64, half_width: f32) -> [Estimate; 2] {
        [&self.from, &self.to].map(|side| side.band(side.voxel(voxel), half_width))
    }
}

/// Finds the two objects, their motion and their boxes. Those of the plane are extruded by `height`, in the morph's own units.
pub(crate) fn pair(
    model: &Arc<Model>,
    solids: &mut Solids,
    variation: &Variation,
    morph: &Morph,
    height: Option<f64>,
    find: FindBox,
) -> Result<Pair, Stop> {
    let from = side(model, solids, variation, morph, morph.from, height, find)?;
    let to = side(model, solids, variation, morph, morph.to, height, find)?;
    let scale = &morph.placement.scale[0];
    if model.varies(scale) {
        let problem = "`morph.scale` changes over time, and a morph is moved and turned only";
        return Err(Problem::new(scale.span, problem).help("let both shapes grow, by a `scale` of their own").into());
    }
    if morph.mode.spec.by_level_sets {
        stand_still(model, morph, [&from, &to])?;
    }
    let over_shot = |side: &Object| {
        let frames = if side.motion.is_still() { vec![0.0] } else { sampled_frames(model.shot.range) };
        let boxes = frames.iter().map(|frame| side.motion.at(model.shot.range.share(*frame)).box_to_world(side.solid));
        boxes.reduce(Aabb::union).unwrap_or(side.solid)
    };
    let both = over_shot(&from).union(over_shot(&to));
    let mut parts = Vec::new();
    match morph.correspondence.as_ref().map(|correspondence| &correspondence.pairs) {
        None => {}
        Some(Pairs::Named(pairs)) => {
            for [one, two] in pairs {
                parts.push([part(model, solids, &from, *one)?, part(model, solids, &to, *two)?]);
            }
        }
        Some(Pairs::Nearest([first, second])) => {
            let mut of = |whole: &Object, ids: &[ShapeId]| -> Result<Vec<Object>, Problem> {
                ids.iter().map(|id| part(model, solids, whole, *id)).collect()
            };
            let (first, second) = (of(&from, first)?, of(&to, second)?);
            let boxes = [&first, &second].map(|all| all.iter().map(|part| part.solid).collect::<Vec<_>>());
            let pairs = matched([from.solid, to.solid], [&boxes[0], &boxes[1]]);
            parts.extend(pairs.into_iter().map(|[one, two]| [first[one].clone(), second[two].clone()]));
        }
    }
    Ok(Pair { from, to, parts, both, height })
}

/// OpenVDB's morph knows one target, and one place to start from.
fn stand_still(model: &Model, morph: &Morph, objects: [&Object; 2]) -> Result<(), Problem> {
    if model.placement_varies(&morph.placement) {
        let problem = "the morph is moved over time, which `mode = \"openvdb\"` does not do";
        return Err(Problem::new(morph.span, problem).help("leave its motion out, or use another `mode`"));
    }
    let Some(moving) = objects.into_iter().find(|object| !object.motion.is_still()) else { return Ok(()) };
    let shape = model.shape(moving.id);
    let problem = format!("`{}` moves, and in `mode = \"openvdb\"` both objects stand still", shape.name);
    Err(Problem::new(shape.span, problem).help("leave out its motion, or use another `mode`"))
}

/// A part of an object, which it stands still in.
fn part(model: &Model, solids: &mut Solids, whole: &Object, id: ShapeId) -> Result<Object, Problem> {
    if whole.stage != Stage::Own {
        let shape = model.shape(whole.id);
        let problem = format!("`{}` is stretched, and so its parts cannot be told apart for `pairs`", shape.name);
        return Err(Problem::new(shape.span, problem).help("stretch its parts"));
    }
    // Between parts values are compared: they hold everywhere.
    let (field, solid): (Arc<dyn Field>, _) = if whole.is_flat {
        let (field, Aabb { min, max }) = profile(model, solids, id, Stage::Placed)?;
        (field, Aabb::new(min.with_z(whole.solid.min.z), max.with_z(whole.solid.max.z)))
    } else {
        let field = Arc::new(solids.values(id)?);
        let solid = solid_box(model, id, field.as_ref())?;
        (field, solid)
    };
    Ok(Object { id, stage: Stage::Placed, field, solid, motion: whole.motion.clone(), is_flat: whole.is_flat })
}

fn side(
    model: &Arc<Model>,
    solids: &mut Solids,
    variation: &Variation,
    morph: &Morph,
    id: ShapeId,
    height: Option<f64>,
    find: FindBox,
) -> Result<Object, Problem> {
    let shape = model.shape(id);
    if variation.own(id) {
        if let Some(files) = shape.all_arguments().find_map(Arguments::sequence) {
            let problem = format!("`{}` is a file by frame, and so cannot enter a morph", shape.name);
            return Err(Problem::new(files.span, problem).help("name one of the files"));
        }
        let problem = format!("`{}` changes its shape over time, and so cannot enter a morph", shape.name);
        return Err(Problem::new(shape.span, problem)
            .help("only its own `scale`, `rotate` and `move` may change; parts and sizes stand still"));
    }
    let uniform = scale_is_uniform(model, shape)?;
    let stage = if uniform { Stage::Own } else { Stage::Scaled };
    let motion = motion(model, id, uniform, morph, variation.placed(id))?;
    if let Some(height) = height {
        let (field, aabb) = profile(model, solids, id, stage)?;
        // The whole's scale stands still.
        let whole = stands(&whole(morph), true, &model.moment(model.shot.range.first as f64))?;
        let solid = thick(aabb, height * whole.scale(), &motion, model);
        return Ok(Object { id, stage, field, solid, motion, is_flat: true });
    }
    let field = solids.field(id, stage)?;
    let solid = find(field.as_ref()).map_err(|error| no_box(model, id, error))?;
    Ok(Object { id, stage, field, solid, motion, is_flat: false })
}

/// How one of the two objects is painted.
pub(crate) struct Brush {
    /// The shape.
    pub id: ShapeId,
    /// Its stage.
    pub stage: Stage,
    /// A voxel's edge in its space.
    pub voxel: f64,
}

/// A morph made ready.
pub(crate) struct Planned {
    /// The morph.
    pub morph: morph::Morph,
    /// Whether anything in it has a colour.
    pub has_colour: bool,
    /// The scalars that either object has, by the names of their grids, sorted: the first object's and the second's.
    pub scalars: Vec<(String, [Arc<Scalar>; 2])>,
    /// How the first object is painted.
    pub from: Brush,
    /// How the second object is painted.
    pub to: Brush,
    /// The morphs of corresponding parts, by whose places the attributes go; none where they go by the objects.
    pub parts: Vec<Planned>,
    /// Memory that the distances take, in bytes.
    pub bytes: u64,
}

/// How objects are measured.
pub(crate) struct Measuring<'w> {
    /// Only as well as an estimate needs.
    pub roughly: bool,
    /// Where what is measured is kept.
    pub cache: Option<&'w Cache>,
    /// About how many voxels go along the longest side, which decides how finely shapes are built.
    pub resolution: f64,
    /// About a voxel's edge.
    pub voxel: f64,
    /// The most memory that one may take, in bytes.
    pub memory_limit: Option<usize>,
    /// Set it to stop.
    pub cancel: &'w AtomicBool,
    /// Told how far it is, and what is being done.
    pub progress: &'w (dyn Fn(f64, &str) + Sync),
    /// How many objects there are to measure.
    pub count: usize,
    /// Those measured so far: a chain shows all but its first and last twice.
    pub done: Vec<(ShapeId, Stage, MeasuredSide)>,
}

impl Measuring<'_> {
    /// An object that was measured.
    fn known(&self, side: &Object) -> Option<&MeasuredSide> {
        self.done.iter().find(|(id, stage, _)| (*id, *stage) == side.what()).map(|(_, _, known)| known)
    }
}

/// Measures both objects and plans the morph.
pub(crate) fn plan(
    model: &Arc<Model>,
    solids: &mut Solids,
    morph: &Morph,
    pair: Pair,
    measuring: &mut Measuring<'_>,
) -> Result<Planned, Stop> {
    let before = measuring.done.len();
    let mut settings = settings(model, morph, delay(model, solids, morph, measuring.voxel)?)?;
    settings.plane = pair.height.map(|height| plane(model, morph, height)).transpose()?;
    settings.carry = carry(morph, [&pair.from, &pair.to].map(|side| (side.solid, &side.motion)), settings.over);
    let kept = plan_key(model, morph, &pair, measuring);
    let mut planned = ready(model, solids, [&pair.from, &pair.to], measuring, |from, to| {
        planned_or_kept(from, to, settings, kept).map_err(|error| no_plan(model, morph, &error))
    })?;
    for [from, to] in &pair.parts {
        let whole = &planned.morph;
        let part = ready(model, solids, [from, to], measuring, |from, to| Ok(whole.of_parts(from, to)))?;
        planned.parts.push(part);
    }
    planned.bytes = measuring.done[before..].iter().map(|(_, _, side)| side.bytes).sum();
    Ok(planned)
}

/// Where a plan is kept, and its key.
fn plan_key<'c>(model: &Model, morph: &Morph, pair: &Pair, measuring: &Measuring<'c>) -> Option<(&'c Cache, [u8; 32])> {
    let cache = measuring.cache.filter(|_| !measuring.roughly)?;
    let cells = [&pair.from, &pair.to].map(|side| side.cell(measuring.voxel));
    let numbers = [measuring.voxel, measuring.resolution, cells[0], cells[1]];
    // A file that cannot be read by now is told of when its frame is made.
    Some((cache, cache.key(&model.plan_hash(morph).ok()?, &numbers)))
}

/// What is wrong with a morph that cannot be planned.
fn no_plan(model: &Model, morph: &Morph, error: &morph::Error) -> Problem {
    if let Some(problem) = anchors_problem(model, morph, error) {
        return problem;
    }
    let span = match error {
        morph::Error::Unbounded(Side::From) => model.shape(morph.from).span,
        morph::Error::Unbounded(Side::To) => model.shape(morph.to).span,
        morph::Error::Setting { name: "delay", .. } => morph.mode.delay().map_or(morph.span, |delay| delay.span),
        _ => morph.span,
    };
    let frame = match error {
        morph::Error::Spreads { time, .. } => format!(" (frame {})", plain(model.shot.frame_at(*time).round())),
        _ => String::new(),
    };
    Problem::new(span, format!("{error}{frame}"))
}

/// Measures two objects, or two parts of them, and finds their attributes; `make` plans their morph.
fn ready(
    model: &Model,
    solids: &mut Solids,
    [from, to]: [&Object; 2],
    measuring: &mut Measuring<'_>,
    make: impl FnOnce(MorphObject, MorphObject) -> Result<morph::Morph, Problem>,
) -> Result<Planned, Stop> {
    let [one, two] = measured(model, solids, [from, to], measuring)?;
    let voxel = measuring.voxel;
    let has_colour = one.paint.is_some() || two.paint.is_some();
    let mut scalars = Vec::new();
    for name in model.scalar_names() {
        let what = TheScalar(name);
        let mut paint = |side: &Object| solids.paint(what, side.id, side.stage, side.voxel(voxel));
        let [one, two] = [paint(from)?, paint(to)?];
        if one.is_some() || two.is_some() {
            let both = [one, two].map(|paint| paint.unwrap_or_else(|| Paint::solid(what.absent())).attribute);
            scalars.push((name.to_owned(), both));
        }
    }
    let brush = |side: &Object| Brush { id: side.id, stage: side.stage, voxel: side.voxel(voxel) };
    let morph = make(one.object(from), two.object(to))?;
    let (from, to) = (brush(from), brush(to));
    Ok(Planned { morph, has_colour, scalars, from, to, parts: Vec::new(), bytes: 0 })
}

/// Gives all morphs of a chain the same grids, and so all of corresponding parts: where none of a morph's objects has an
/// attribute, it is what shapes without it count as.
pub(crate) fn alike(chain: &mut [Planned]) {
    make_alike(chain.iter_mut().flat_map(|planned| &mut planned.parts).collect());
    make_alike(chain.iter_mut().collect());
}

fn make_alike(morphs: Vec<&mut Planned>) {
    let has_colour = morphs.iter().any(|planned| planned.has_colour);
    let names: BTreeSet<String> =
        morphs.iter().flat_map(|planned| planned.scalars.iter().map(|(name, _)| name.clone())).collect();
    for planned in morphs {
        planned.has_colour = has_colour;
        for (place, name) in names.iter().enumerate() {
            if planned.scalars.get(place).is_none_or(|(there, _)| there != name) {
                let absent = || Paint::solid(TheScalar(name).absent()).attribute;
                planned.scalars.insert(place, (name.clone(), [absent(), absent()]));
            }
        }
    }
}

/// An object's distance and colour.
#[derive(Clone)]
pub(crate) struct MeasuredSide {
    distance: Arc<dyn Distance>,
    /// Memory that the distance holds.
    bytes: u64,
    paint: Option<Paint<3>>,
}

impl MeasuredSide {
    fn object(self, side: &Object) -> MorphObject {
        MorphObject {
            surface: Arc::clone(&side.field),
            distance: self.distance,
            colour: self.paint.unwrap_or_else(|| Paint::solid(TheColour.absent())).attribute,
            motion: side.motion.clone(),
        }
    }
}

/// Measures two objects, at the same time where memory allows it: much of what one takes is done by a single thread.
fn measured(
    model: &Model,
    solids: &mut Solids,
    sides: [&Object; 2],
    measuring: &mut Measuring<'_>,
) -> Result<[MeasuredSide; 2], Stop> {
    let mut open: Vec<(&Object, Option<Paint<3>>)> = Vec::new();
    for side in sides {
        if measuring.known(side).is_none() && open.iter().all(|(other, _)| other.what() != side.what()) {
            open.push((side, solids.paint(TheColour, side.id, side.stage, side.voxel(measuring.voxel))?));
        }
    }
    let (before, count) = (measuring.done.len() as f64, measuring.count as f64);
    let mut claims = claims(model, &open, measuring)?;
    let unknown = open.iter().zip(&claims).filter(|(_, claim)| !matches!(claim, Some(Claim::Known(_))));
    let names: Vec<&str> = unknown.map(|((side, _), _)| model.shape(side.id).name.as_str()).collect();
    let doing = format!("measuring {}", names.join(" and "));
    let shares = Mutex::new([0.0; 2]);
    let measure = |(which, side): (usize, &Object)| {
        let told = |share: f64| {
            let mut shares = shares.lock().unwrap_or_else(PoisonError::into_inner);
            shares[which] = share;
            shares[0] + shares[1]
        };
        let progress = |share: f64| (measuring.progress)((before + told(share)) / count, &doing);
        progress(0.0);
        distance(model, side, measuring, &Watch { cancel: measuring.cancel, progress: &progress })
    };
    let measure = |(which, (side, claim)): (usize, (&Object, &mut Option<Claim>))| match claim.take() {
        Some(Claim::Known(known)) => Ok(distance_of(method(model, side, measuring).restored(known, &side.field))),
        Some(Claim::Open(task)) => {
            let measured = measure((which, side))?;
            task.done(&measured);
            Ok(distance_of(measured))
        }
        None if side.is_flat => distance_in_plane(model, side, measuring),
        None => Ok(distance_of(measure((which, side))?)),
    };
    let all = open.iter().map(|(side, _)| *side).zip(&mut claims);
    let distances: Result<Vec<WithBytes>, Stop> = if fit_at_once(&open, measuring) {
        // Of two that go wrong the first is told, whichever ends first.
        let all: Vec<_> = all.enumerate().collect();
        let all: Vec<Result<WithBytes, Stop>> = all.into_par_iter().map(measure).collect();
        all.into_iter().collect()
    } else {
        all.enumerate().map(measure).collect()
    };
    for ((side, paint), (distance, bytes)) in open.into_iter().zip(distances?) {
        let (id, stage) = side.what();
        measuring.done.push((id, stage, MeasuredSide { distance, bytes, paint }));
    }
    Ok(sides.map(|side| measuring.known(side).cloned().unwrap_or_else(|| unreachable!("it was measured"))))
}

/// A distance, and the memory that it holds.
type WithBytes = (Arc<dyn Distance>, u64);

fn distance_of(measured: Measured) -> WithBytes {
    (measured.distance, measured.bytes)
}

/// What the cache, where there is one, knows of objects. Measuring shapes of the plane takes so little time that they are not
/// kept.
fn claims<'c, P>(
    model: &Model,
    open: &[(&Object, P)],
    measuring: &Measuring<'c>,
) -> Result<Vec<Option<Claim<'c>>>, Stop> {
    let mut claims: Vec<Option<Claim>> = open.iter().map(|_| None).collect();
    let Some(cache) = measuring.cache.filter(|_| !measuring.roughly) else { return Ok(claims) };
    let key = |(place, (side, _)): (usize, &(&Object, P))| {
        // A file that cannot be read by now is told of when its frame is made.
        let part = model.part_hash(side.id, side.stage).ok()?;
        let Aabb { min, max } = side.solid;
        let numbers = [side.cell(measuring.voxel), measuring.resolution, min.x, min.y, min.z, max.x, max.y, max.z];
        let part = [&part[..], model.shape(side.id).distance.key().as_bytes()].concat();
        Some((cache.key(&part, &numbers), place))
    };
    let solids = open.iter().enumerate().filter(|(_, (side, _))| !side.is_flat);
    let mut keys: Vec<([u8; 32], usize)> = solids.filter_map(key).collect();
    keys.sort_unstable();
    for (key, place) in keys {
        let waiting = || {
            let name = &model.shape(open[place].0.id).name;
            let share = measuring.done.len() as f64 / measuring.count as f64;
            (measuring.progress)(share, &format!("{name} is being measured by another process"));
        };
        claims[place] = Some(cache.claim(key, measuring.cancel, &waiting).map_err(|_| Stop::Cancelled)?);
    }
    Ok(claims)
}

/// Memory that measuring an object takes, in bytes by the voxels of a level set of it, three to either side: facets three
/// voxels wide take as many, wider ones half, smooth objects 10 to 30.
const BYTES_A_VOXEL: f64 = 1000.0;

/// What a measured object usually takes, in the same terms: those of the built-in scenes take 35 to 470.
const USUAL_BYTES_A_VOXEL: f64 = 300.0;

/// Whether objects may be measured at the same time: together they must not take more memory than one may.
fn fit_at_once<P>(open: &[(&Object, P)], measuring: &Measuring<'_>) -> bool {
    let Some(limit) = measuring.memory_limit.filter(|_| open.len() > 1) else { return true };
    let solids = open.iter().filter(|(side, _)| !side.is_flat);
    let voxels: f64 = solids.map(|(side, _)| side.band(side.cell(measuring.voxel), 3.0).voxels).sum();
    BYTES_A_VOXEL * voxels <= limit as f64
}

/// How one is measured.
fn method(model: &Model, side: &Object, measuring: &Measuring<'_>) -> &'static dyn Method {
    if measuring.roughly { &Rough } else { model.shape(side.id).distance.method() }
}

/// The distances of one of the plane, measured there.
fn distance_in_plane(model: &Model, side: &Object, measuring: &Measuring<'_>) -> Result<WithBytes, Stop> {
    let (shape, cell) = (model.shape(side.id), side.cell(measuring.voxel));
    let settings = shape.distance.settings(octree::Settings::new(side.solid, cell));
    let request = Request { field: &side.field, solid: side.solid, detail: cell, settings };
    let watch = Watch { cancel: measuring.cancel, progress: &|_| {} };
    let measured = shape.distance.method().measure_in_plane(&request, &watch).map_err(|error| {
        let is_of_choice = matches!(error, octree::BuildError::SolidsOnly { .. });
        let span = if is_of_choice { shape.distance_span } else { shape.span };
        Stop::of_measuring(&error, |what| Problem::new(span, format!("`{}`: {what}", shape.name)))
    })?;
    Ok((measured.distance, measured.report.bytes as u64))
}

/// The distances of one.
fn distance(model: &Model, side: &Object, measuring: &Measuring<'_>, watch: &Watch) -> Result<Measured, Stop> {
    let shape = model.shape(side.id);
    let cell = side.cell(measuring.voxel);
    let problem = |what: String| Problem::new(shape.span, format!("`{}`: {what}", shape.name));
    let mut settings = octree::Settings::new(side.solid, cell);
    settings.memory_limit = measuring.memory_limit.unwrap_or(settings.memory_limit);
    if !measuring.roughly {
        settings = shape.distance.settings(settings);
    }
    let request = Request { field: &side.field, solid: side.solid, detail: cell, settings };
    let method = method(model, side, measuring);
    let mut measured = method.measure(&request, watch).map_err(|error| Stop::of_measuring(&error, problem))?;
    if measuring.roughly {
        measured.bytes = (USUAL_BYTES_A_VOXEL * side.band(cell, 3.0).voxels) as u64;
    }
    Ok(measured)
}

/// The morph of a chain that a frame shows: where one ends, the next.
pub(crate) fn shown_at(morphs: &[Morph], frame: f64) -> usize {
    morphs.iter().rposition(|morph| morph.over.first as f64 <= frame).unwrap_or(0)
}

/// The box of F ≥ 0 over the whole shot: while a shape changes, as its morph knows it; before and after, of the object
/// that is seen.
pub(crate) fn extent_over_shot(model: &Model, morphs: &[Morph], planned: &[Planned]) -> Result<Aabb, Problem> {
    let range = model.shot.range;
    let (first, last) = (morphs[0].over.first, morphs[morphs.len() - 1].over.last);
    let frames = sampled_frames(range).into_iter().filter(|&frame| {
        let at_an_end = frame == range.first as f64 || frame == range.last as f64;
        at_an_end || frame <= first as f64 || frame >= last as f64
    });
    let seen = morphs.iter().zip(planned).filter(|(morph, _)| {
        let over = morph.over;
        over.last > range.first && over.first < range.last
    });
    let mut all = seen.map(|(_, planned)| planned.morph.extent()).reduce(Aabb::union);
    for frame in frames {
        let field = planned[shown_at(morphs, frame)].morph.field(range.share(frame));
        // A section in the papers' mode may be empty at the ends.
        let seen = box_of(field.as_ref()).ok();
        all = match (all, seen) {
            (Some(one), Some(other)) => Some(one.union(other)),
            (one, other) => one.or(other),
        };
    }
    all.ok_or_else(|| Problem::new(morphs[0].span, "nothing is inside in any frame of the morph"))
}

/// A note of the pairs that were found where the scene leaves them open, as a scene would name them.
pub(crate) fn found_pairs(model: &Model, morph: &Morph, planned: &Planned) -> Option<Diagnostic> {
    let Pairs::Nearest(_) = morph.correspondence.as_ref()?.pairs else { return None };
    let name = |brush: &Brush| format!("\"{}\"", clip(&model.shape(brush.id).name));
    let pairs: Vec<String> =
        planned.parts.iter().map(|part| format!("[{}, {}]", name(&part.from), name(&part.to))).collect();
    let mut note = Diagnostic::warning(morph.span, format!("`pairs = \"auto\"` is [{}]", pairs.join(", ")));
    note.severity = Severity::Note;
    Some(note)
}

/// One warning that names the frames that hold nothing. Where a₀ follows from the volume there are none; those of
/// OpenVDB are not known before.
pub(crate) fn empty_frames(model: &Model, morphs: &[Morph], planned: &[Planned]) -> Option<Diagnostic> {
    let mode = morphs[0].mode.spec;
    if mode.by_level_sets && !planned[0].morph.objects_meet() {
        let problem = "the objects do not overlap, and so OpenVDB's morph ends with nothing";
        let help = "move them together, or use `mode = \"volume\"`";
        return Some(Diagnostic::warning(morphs[0].span, problem).help(help));
    }
    let help = mode.where_empty?;
    let range = model.shot.range;
    let frames: Vec<i64> = sampled_frames(range).into_iter().map(|frame| frame.round() as i64).collect();
    let mut empty: Vec<(i64, f64)> = Vec::new();
    for (place, planned) in planned.iter().enumerate() {
        let own = |frame: &i64| shown_at(morphs, *frame as f64) == place;
        let frames: Vec<i64> = frames.iter().copied().filter(own).collect();
        let times: Vec<f64> = frames.iter().map(|frame| range.share(*frame as f64)).collect();
        let report = planned.morph.report(&times);
        let all = frames.into_iter().zip(&report.frames);
        empty.extend(all.filter(|(_, report)| report.volume == 0.0).map(|(frame, report)| (frame, report.t)));
    }
    let (first, last) = (empty.first()?.1, empty.last()?.1);
    let numbers: Vec<i64> = empty.iter().map(|(frame, _)| *frame).collect();
    let count = if empty.len() == 1 { "frame" } else { "frames" };
    let problem = format!("the morph is empty in {count} {} (t = {first:.3} to {last:.3})", in_ranges(&numbers));
    Some(Diagnostic::warning(morphs[0].span, problem).help(help))
}
