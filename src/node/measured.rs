//! Distances of what has none by itself: those of set operations from their operands', all others measured on an octree
//! that is fine where they are asked for.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;

use crate::distance::Distance;
use crate::distance::extent;
use crate::distance::method::{Choice, MeasuredInPlane, Request};
use crate::distance::nearest::Watch;
use crate::distance::octree::{self, BuildError};
use crate::distance::outlined::Outlined;
use crate::field::{Aabb, Expression, Field, Graph, Interval, Node, Side};

use crate::node::cache::Claim;
use crate::node::extent::box_of;
use crate::node::keeping::{Keeping, Solid};
use crate::node::model::Shape;
use crate::node::profile::lift_it;
use crate::text::problem::Problem;
use crate::text::source::Span;

/// Measured distances are short of the distance by less than this share of it: how much further than a level the
/// surface there is sought.
pub(crate) const SLACK: f64 = 1.1;

/// The least number of seeds along a solid's longest side. Fewer miss its details where its levels are far from it.
const LEAST_SEEDS: f64 = 64.0;

/// How far a distance at the levels may be wrong, in voxels.
const TOLERANCE: f64 = 0.02;

/// The smallest cells, in voxels. They stand at creases of the levels only, which they round by about as much.
const AT_CREASES: f64 = 0.25;

/// Parts of a solid are measured one by one where they are no more than these: their edges stay sharp. More take longer
/// than the whole.
const MOST_PARTS: usize = 4;

/// Smallest cells of a distance object along its longest side, at most: more take memory without end, and a morph's
/// in-betweens are smooth.
pub(crate) const MOST_CELLS: f64 = 512.0;

/// Levels on both sides of the surface, as near to it as can be.
pub(crate) const BESIDE_SURFACE: Interval = Interval::new(-f64::MIN_POSITIVE, f64::MIN_POSITIVE);

/// The smallest cells that an object's distances need, from a voxel's edge in its space.
pub(crate) fn smallest_cell(voxel: f64, solid: &Aabb) -> f64 {
    voxel.max(solid.size().max_element() / MOST_CELLS)
}

/// The distance of a solid in a box by what was chosen, as good as its band wherever it is one of `levels`, positive inside.
/// `voxel` is a voxel's edge. It is kept by `key` where there is a cache.
pub(crate) fn measured(
    choice: Choice,
    field: &Arc<dyn Field>,
    solid: Aabb,
    levels: Interval,
    voxel: f64,
    kept: Option<Kept<'_>>,
    cancel: &AtomicBool,
) -> Result<Arc<dyn Distance>, BuildError> {
    let watch = Watch { cancel, progress: &|_| {} };
    let request = request(choice, field, solid, levels, voxel);
    measured_or_kept(choice, &request, kept, &[levels.lo, levels.hi, voxel], &watch)
}

/// What is to be measured for that.
fn request(choice: Choice, field: &Arc<dyn Field>, solid: Aabb, levels: Interval, voxel: f64) -> Request<'_> {
    let detail = smallest_cell(voxel.min(solid.size().max_element() / LEAST_SEEDS), &solid);
    let reach = reach(solid, levels);
    let mut settings = octree::Settings::new(reach, smallest_cell(AT_CREASES * voxel, &reach));
    settings.levels = levels;
    settings.tolerance = TOLERANCE * voxel;
    Request { field, solid, detail, settings: choice.settings(settings) }
}

/// What is measured, or what was kept of it by these numbers and the solid's box.
pub(crate) fn measured_or_kept(
    choice: Choice,
    request: &Request<'_>,
    kept: Option<Kept<'_>>,
    numbers: &[f64],
    watch: &Watch<'_>,
) -> Result<Arc<dyn Distance>, BuildError> {
    let method = choice.method();
    let key = kept.and_then(|(keeping, solid, part)| {
        let Aabb { min, max } = request.solid;
        let numbers = [numbers, &min.to_array(), &max.to_array()].concat();
        Some((keeping.cache(), keeping.key(solid, part, &choice.key(), &numbers)?))
    });
    let Some((cache, key)) = key else { return Ok(method.measure(request, watch)?.distance) };
    match cache.claim(key, watch.cancel, &|| {})? {
        Claim::Known(known) => Ok(method.restored(known, request.field).distance),
        Claim::Open(task) => {
            let measured = method.measure(request, watch)?;
            task.done(&measured);
            Ok(measured.distance)
        }
    }
}

/// Where a distance is kept, the solid that it is of, and which of its parts where it is measured by these.
pub(crate) type Kept<'a> = (&'a Keeping, Solid, Option<usize>);

/// The box of a solid grown to the outermost of some levels.
fn reach(solid: Aabb, levels: Interval) -> Aabb {
    solid.grown(SLACK * (-levels.lo).max(0.0))
}

/// The sides of the surface that some levels are on.
fn sides(levels: Interval) -> (Option<Side>, Option<Side>) {
    ((levels.lo < 0.0).then_some(Side::Outside), (levels.hi > 0.0).then_some(Side::Inside))
}

/// A node with a solid's zero set that is the distance to it wherever that is one of `levels`, as far as it takes no
/// measuring. Who makes another `choice` than the usual wants its distances.
pub(crate) fn told(graph: &mut Graph, solid: Node, levels: Interval, choice: Choice) -> Option<Node> {
    if choice != Choice::USUAL {
        return None;
    }
    let slope = graph.slope(solid);
    let exact = |side: Option<Side>| side.is_none_or(|side| slope.is_exact(side));
    match sides(levels) {
        (outside, inside) if exact(outside) && exact(inside) => Some(solid),
        (Some(side), None) | (None, Some(side)) => graph.distance(solid, side, &BTreeMap::new()),
        _ => None,
    }
}

/// What a distance is for.
#[derive(Clone, Copy)]
pub(crate) struct Purpose<'a> {
    /// Of what it is.
    pub solid: Solid,
    /// The shape that needs it.
    pub shape: &'a Shape,
    /// The key that needs it.
    pub key: &'a str,
    /// Where the scene has that.
    pub span: Span,
    /// A voxel's edge, where it is not to hang on the voxels of the whole.
    pub voxel: Option<f64>,
    /// How far from the box of the solid it is asked for; `None`: as far as its levels are.
    pub around: Option<f64>,
    /// What the distance is measured by.
    pub choice: Choice,
}

impl Purpose<'_> {
    fn failed(&self, error: &BuildError) -> Problem {
        // What the chosen method cannot do is told where it is chosen.
        let is_of_choice = self.choice.depth.is_some() || matches!(error, BuildError::SolidsOnly { .. });
        let span = if is_of_choice { self.shape.distance_span } else { self.span };
        Problem::new(span, format!("`{}`: {error}", self.shape.name))
    }

    /// A shape of the plane is measured there, and one that leaves it has no end.
    fn leaves_the_plane(&self) -> Problem {
        let (Shape { name, .. }, key) = (self.shape, self.key);
        let problem = format!("`{key}` needs the distance to `{name}`, a shape of the plane that leaves it");
        Problem::new(self.span, problem).help(format!("turn it about z alone, or {} first", lift_it()))
    }

    fn without_box(&self, error: extent::Error) -> Problem {
        let (Shape { name, .. }, key) = (self.shape, self.key);
        match error {
            extent::Error::Unbounded => Problem::new(
                self.span,
                format!(
                    "`{key}` needs the distance to `{name}`, which may reach to infinity and whose F is not a distance"
                ),
            )
            .help("give it `bounds` that reach a little beyond all of it that is used"),
            extent::Error::TooFar => Problem::new(self.span, format!("`{name}`: {error}")),
            extent::Error::Empty => {
                Problem::new(self.span, format!("nothing is inside `{name}`, whose distance `{key}` needs"))
                    .help("F is negative everywhere: check the signs (positive is inside), the sizes and the bounds")
            }
        }
    }
}

/// The distances of nodes of one graph.
#[derive(Clone)]
pub(crate) struct Distances {
    /// About how many voxels go along the longest side of a solid.
    resolution: f64,
    /// Set to stop measuring.
    cancel: Arc<AtomicBool>,
    /// Where they are kept for other runs.
    keeping: Option<Keeping>,
    /// Those found so far, by their solids, levels, voxels, how far around, and methods.
    known: HashMap<(Node, [u64; 4], Choice), Node>,
}

impl Distances {
    /// Keeps them for other runs, and uses what others kept.
    pub fn keep(&mut self, keeping: Keeping) {
        self.keeping = Some(keeping);
    }

    /// Where they are kept.
    pub fn keeping(&self) -> Option<&Keeping> {
        self.keeping.as_ref()
    }

    /// From now on at another frame.
    pub fn go_to(&mut self, frame: f64) {
        self.keeping = self.keeping.take().map(|keeping| keeping.at(frame));
    }

    /// None found yet.
    pub fn new(resolution: f64, cancel: &Arc<AtomicBool>) -> Self {
        Self { resolution, cancel: Arc::clone(cancel), keeping: None, known: HashMap::new() }
    }

    /// A node with a solid's zero set that is the distance to it wherever that is one of `levels`, positive inside: the
    /// solid's own where that is one.
    pub fn of(
        &mut self,
        graph: &mut Graph,
        solid: Node,
        levels: Interval,
        purpose: &Purpose<'_>,
    ) -> Result<Node, Problem> {
        if let Some(distance) = told(graph, solid, levels, purpose.choice) {
            return Ok(distance);
        }
        let (voxel, around) = (purpose.voxel.unwrap_or(0.0), purpose.around.unwrap_or(f64::INFINITY));
        let key = (solid, [levels.lo, levels.hi, voxel, around].map(f64::to_bits), purpose.choice);
        if let Some(known) = self.known.get(&key) {
            return Ok(*known);
        }
        let found = match sides(levels) {
            (None, Some(side)) | (Some(side), None) if purpose.choice == Choice::USUAL && !purpose.shape.is_flat => {
                self.by_parts(graph, (solid, side), levels, purpose)?
            }
            _ => None,
        };
        let distance = match found {
            Some(distance) => distance,
            None => self.measured(graph, (solid, None), levels, purpose)?,
        };
        self.known.insert(key, distance);
        Ok(distance)
    }

    /// The distance on one side from those of a few parts; `None` where it is the whole that has to be measured.
    fn by_parts(
        &mut self,
        graph: &mut Graph,
        (solid, side): (Node, Side),
        levels: Interval,
        purpose: &Purpose<'_>,
    ) -> Result<Option<Node>, Problem> {
        let parts = graph.to_measure(solid, side);
        if parts.len() > MOST_PARTS {
            return Ok(None);
        }
        // What is extruded, say, is of the plane, and its box has no end along z.
        let box_of_solid = |part: Node| {
            let aabb = box_of(&Expression::new(graph, part))?;
            Ok::<_, extent::Error>((!(graph.is_flat(part) && aabb.is_of_plane())).then_some(aabb))
        };
        let boxes = parts.iter().map(|(part, _)| box_of_solid(*part));
        let Ok(boxes) = boxes.collect::<Result<Vec<Option<Aabb>>, _>>() else { return Ok(None) };
        let mut found = BTreeMap::new();
        for (place, (part, aabb)) in parts.into_iter().zip(boxes).enumerate() {
            // Of what is taken away the other side counts.
            let levels = if part.1 == side { levels } else { Interval::new(-levels.hi, -levels.lo) };
            let distance = match aabb {
                Some(aabb) => self.measured(graph, (part.0, Some((place, aabb))), levels, purpose)?,
                None => self.measured_in_plane(graph, part.0, levels, purpose)?,
            };
            found.insert(part, distance);
        }
        Ok(graph.distance(solid, side, &found))
    }

    /// Of a solid, or of one of its parts, whose place among them and box are known.
    fn measured(
        &self,
        graph: &mut Graph,
        (solid, part): (Node, Option<(usize, Aabb)>),
        levels: Interval,
        purpose: &Purpose<'_>,
    ) -> Result<Node, Problem> {
        if purpose.shape.is_flat {
            return self.measured_in_plane(graph, solid, levels, purpose);
        }
        let field: Arc<dyn Field> = Arc::new(Expression::new(graph, solid));
        let aabb = match part {
            Some((_, aabb)) => aabb,
            None => box_of(field.as_ref()).map_err(|error| purpose.without_box(error))?,
        };
        // No solid has more voxels than the whole that is baked, but where it is scaled.
        let voxel = purpose.voxel.unwrap_or(reach(aabb, levels).size().max_element() / self.resolution);
        let kept = self.keeping.as_ref().map(|keeping| (keeping, purpose.solid, part.map(|(place, _)| place)));
        let mut request = request(purpose.choice, &field, aabb, levels, voxel);
        let mut numbers = vec![levels.lo, levels.hi, voxel];
        // Other methods measure in all of the region, and a chosen depth is that of a cube around it.
        if let Some(around) = purpose.around.filter(|_| purpose.choice == Choice::USUAL) {
            request.settings.region = aabb.grown(around);
            numbers.push(around);
        }
        let watch = Watch { cancel: &self.cancel, progress: &|_| {} };
        let measured = measured_or_kept(purpose.choice, &request, kept, &numbers, &watch);
        let measured = measured.map_err(|error| purpose.failed(&error))?;
        let node = graph.field(measured);
        let node = graph.bounded(node, aabb);
        Ok(graph.falling(node, 1.0 / SLACK))
    }

    /// Of a shape of the plane. That takes so little time that nothing is kept.
    fn measured_in_plane(
        &self,
        graph: &mut Graph,
        shape: Node,
        levels: Interval,
        purpose: &Purpose<'_>,
    ) -> Result<Node, Problem> {
        if !graph.is_flat(shape) {
            return Err(purpose.leaves_the_plane());
        }
        let aabb = box_in_plane(graph, shape).map_err(|error| purpose.without_box(error))?;
        let field: Arc<dyn Field> = Arc::new(Expression::new(graph, shape));
        let voxel = purpose.voxel.unwrap_or(reach(aabb, levels).size().truncate().max_element() / self.resolution);
        let measured = measured_in_plane(purpose.choice, &field, aabb, levels, voxel, &self.cancel);
        let node = graph.field(measured.map_err(|error| purpose.failed(&error))?.distance);
        let node = graph.bounded(node, aabb.without_z());
        Ok(graph.falling(node, 1.0 / SLACK))
    }
}

/// The box of a shape of the plane, of no height.
pub(crate) fn box_in_plane(graph: &mut Graph, shape: Node) -> Result<Aabb, extent::Error> {
    // A slab of about its size: cells are as fine as the longest side asks for.
    let height = graph.known_box(shape).map_or(1.0, Aabb::longest_side);
    let caps = graph.slab(DVec3::Z, if height > 0.0 { height } else { 1.0 });
    let solid = graph.corner(shape, caps);
    Ok(box_of(&Expression::new(graph, solid))?.at_z(0.0))
}

/// The distance of a shape of the plane in a box of no height by the closest points themselves, for pictures of it.
pub(crate) fn outlined(
    field: &Arc<dyn Field>,
    shape: Aabb,
    voxel: f64,
    cancel: &AtomicBool,
) -> Result<Arc<dyn Field>, BuildError> {
    let outlined = Outlined::new(field, &shape, AT_CREASES * voxel, &Watch { cancel, progress: &|_| {} })?;
    Ok(Arc::new(outlined))
}

/// The distance of a shape of the plane in a box of no height, as [`measured`] has that of a solid.
pub(crate) fn measured_in_plane(
    choice: Choice,
    field: &Arc<dyn Field>,
    shape: Aabb,
    levels: Interval,
    voxel: f64,
    cancel: &AtomicBool,
) -> Result<MeasuredInPlane, BuildError> {
    let request = request(choice, field, shape, levels, voxel);
    choice.method().measure_in_plane(&request, &Watch { cancel, progress: &|_| {} })
}
