//! How the surface of a frame moves: that of shapes by their own `scale`, `rotate` and `move`, that of parts with them.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::attribute::{AffineVector, Attribute, Constant, Part, Parts, Rule, Sampler, SpaceMap};
use crate::field::{Aabb, BATCH, Points};
use crate::morph::{Around, Instant, Movement};

use crate::node::bend::Bend;
use crate::node::id::Stage;
use crate::node::model::{Content, ShapeId};
use crate::node::paint::last_of_each;
use crate::node::placed::Way;
use crate::node::solid::Solids;
use crate::node::source::TOLERANCE_VOXELS;
use crate::node::spec::Carries;
use crate::shot::prepared::{Prepared, Ready};
use crate::shot::stop::Stop;
use crate::text::problem::Problem;

/// How far the instants are from a frame that its velocity is taken from, in frames. Nearer: rounding of positions shows;
/// farther: what turns or speeds up within a frame is cut short.
const STEP: f64 = 0.125;

/// The greatest speed of a change of shape where the scene says none, against that of a motion: a surface that crosses
/// the whole shot in fewer than eight frames is one that meets, parts or vanishes.
const CHANGE: f64 = 0.125;

/// A vector attribute; `None` is 0 everywhere.
type Vectors = Option<Arc<dyn Attribute<3>>>;

impl Prepared {
    /// How the surface of a frame moves, in world units a second. Outside the shot its ends stand still.
    pub(crate) fn movement(&self, frame: i64) -> Result<Movement, Stop> {
        let shot = self.model.shot;
        let (first, last) = (shot.range.first, shot.range.last);
        let across = self.extent.size().max_element() * shot.fps;
        let (max_speed, max_change) = match self.model.output.max_speed {
            Some(max_speed) => (max_speed, max_speed),
            None => (across, CHANGE * across),
        };
        let mut movement =
            Movement { around: Vec::new(), given: None, max_speed, max_change, frame_seconds: 1.0 / shot.fps };
        if frame < first || frame > last {
            return Ok(movement);
        }
        if let Content::Shape(id) = self.model.content {
            movement.given = self.given_way(id, frame)?;
        }
        if first == last || matches!(self.content, Ready::Still(_)) {
            return Ok(movement);
        }
        let side = match frame {
            _ if frame == first => Some(Ordering::Greater),
            _ if frame == last => Some(Ordering::Less),
            _ => None,
        };
        let now = frame as f64;
        let solids = |frame: f64| self.base.at(self.model.moment(frame), &self.variation);
        let mut solids_now = solids(now);
        for instant in Instant::around(STEP / shot.fps, side) {
            let then = now + instant.seconds * shot.fps;
            let (field, own) = match &self.content {
                Ready::Still(_) => continue,
                Ready::Changing(id) => {
                    let (then, ways) = (solids(then), BTreeMap::new());
                    let mut both = Both { prepared: self, now: &mut solids_now, then, of: WayOf::Motion, ways };
                    (both.then.field(*id, Stage::Placed)?, both.way(*id)?)
                }
                Ready::Morph(planned) => {
                    let (time, later) = (shot.range.share(now), shot.range.share(then));
                    // Beside an object of a chain the instants lie in two morphs, each with a way of its own.
                    let shown = &planned[self.shown(then)];
                    let field = self.dressed(shown.morph.moving_field(later), shown, then)?;
                    (field, shown.morph.own_way(time, later))
                }
            };
            movement.around.push(Around { instant, field, own });
        }
        Ok(movement)
    }

    /// What the files of a shape say of its velocity, where and as it stands, world units a second.
    fn given_way(&self, id: ShapeId, frame: i64) -> Result<Vectors, Problem> {
        let mut now = self.base.at(self.model.moment(frame as f64), &self.variation);
        let (then, ways) = (now.clone(), BTreeMap::new());
        Both { prepared: self, now: &mut now, then, of: WayOf::Files, ways }.way(id)
    }
}

/// What way is asked for.
#[derive(Clone, Copy, PartialEq)]
enum WayOf {
    /// That of shapes which move.
    Motion,
    /// A second's way by the velocities of files.
    Files,
}

/// Shapes at a frame and at an instant near it; of files the frame twice.
struct Both<'a> {
    prepared: &'a Prepared,
    now: &'a mut Solids,
    then: Solids,
    of: WayOf,
    /// The ways that were found.
    ways: BTreeMap<ShapeId, Vectors>,
}

impl Both<'_> {
    /// The way of each point of a placed shape from the frame to the instant.
    fn way(&mut self, id: ShapeId) -> Result<Vectors, Problem> {
        if let Some(known) = self.ways.get(&id) {
            return Ok(known.clone());
        }
        let way = self.new_way(id)?;
        self.ways.insert(id, way.clone());
        Ok(way)
    }

    fn new_way(&mut self, id: ShapeId) -> Result<Vectors, Problem> {
        if self.of == WayOf::Motion && !self.prepared.variation.placed(id) {
            return Ok(None);
        }
        let placement = &self.prepared.model.shape(id).placement;
        let now = self.now.placement(placement, Stage::Placed)?;
        let then = self.then.placement(placement, Stage::Placed)?;
        let whole = (now != then).then(|| AffineVector::of_move(now, then));
        let inner = self.inner_way(id)?;
        if whole.is_none() && inner.is_none() {
            return Ok(None);
        }
        Ok(Some(Arc::new(Carried { whole, inner, turn: then.matrix3, back: Way::Back(now.inverse()) })))
    }

    /// The way of a shape's parts in its own space, as its colour comes from them.
    fn inner_way(&mut self, id: ShapeId) -> Result<Vectors, Problem> {
        let model = Arc::clone(&self.prepared.model);
        let shape = model.shape(id);
        // Copies take no motion of what is copied: each stands in a cell of its own.
        if shape.is_copied() {
            return Ok(None);
        }
        let parts = shape.painters();
        let inner = match shape.spec.carries {
            Carries::Union => self.way_of_parts(parts, Rule::Union { seam: shape.seam() })?,
            Carries::Blend => self.way_of_parts(parts, Rule::Blend)?,
            Carries::First | Carries::Any => self.way(parts[0])?,
            Carries::Morph => self.way_of_morph(id)?,
            Carries::Import if self.of == WayOf::Files => self.now.imported(id)?.velocity.clone(),
            Carries::Nothing | Carries::Import => None,
        };
        let mut way = inner;
        for step in 1..=shape.modifiers.len() {
            let Some(bend) = self.now.bend(id, step)? else { continue };
            let varies = bend.goes_by_box() || self.prepared.variation.modifier(id, step);
            let changes = self.of == WayOf::Motion && varies;
            let then = if changes { self.then.bend(id, step)? } else { None };
            way = match (way, then) {
                (None, None) => None,
                (inner, Some(then)) => Some(Arc::new(Moved { inner, now: bend, then })),
                (Some(inner), None) => Some(Arc::new(Bent { inner, bend })),
            };
        }
        Ok(way)
    }

    /// The way of a morph as a shape, while its operands stand still: along with what carries them.
    fn way_of_morph(&mut self, id: ShapeId) -> Result<Vectors, Problem> {
        let model = Arc::clone(&self.prepared.model);
        if self.prepared.variation.parts(&model, id) {
            return Ok(None);
        }
        let mix = model.shape(id).arguments.number("mix").expect("it has a default");
        let (now, then) = (self.now.number(mix)?, self.then.number(mix)?);
        Ok(self.now.morphed(id)?.own_way(now, then))
    }

    fn way_of_parts(&mut self, operands: &[ShapeId], rule: Rule) -> Result<Vectors, Problem> {
        let operands = last_of_each(operands);
        let mut ways = Vec::with_capacity(operands.len());
        for id in &operands {
            ways.push(self.way(*id)?);
        }
        if ways.iter().all(Option::is_none) {
            return Ok(None);
        }
        let same = |[a, b]: &[Vectors; 2]| matches!((a, b), (Some(a), Some(b)) if Arc::ptr_eq(a, b));
        if ways.array_windows().all(same) {
            return Ok(ways.swap_remove(0));
        }
        let mut parts: Vec<Part<3>> = Vec::with_capacity(operands.len());
        for (id, way) in operands.iter().zip(ways) {
            let rest = || Arc::new(Constant::new([0.0; 3])) as Arc<dyn Attribute<3>>;
            parts.push((self.now.decider(*id, rule)?, way.unwrap_or_else(rest)));
        }
        let tolerance = TOLERANCE_VOXELS * self.prepared.lattice.voxel_size.get();
        Ok(Parts::new(parts, rule, tolerance).map(|parts| Arc::new(parts) as Arc<dyn Attribute<3>>))
    }
}

/// The way of a whole, and with it that of its parts.
struct Carried {
    whole: Option<AffineVector>,
    inner: Vectors,
    /// How the whole turns and stretches its own space at the instant.
    turn: DMat3,
    back: Way,
}

impl Attribute<3> for Carried {
    fn sampler(&self) -> Box<dyn Sampler<3> + '_> {
        let inner = self.inner.as_ref().map(|inner| inner.sampler());
        Box::new(CarriedSampler { carried: self, inner, there: Points::new(DVec3::ZERO) })
    }
}

struct CarriedSampler<'a> {
    carried: &'a Carried,
    inner: Option<Box<dyn Sampler<3> + 'a>>,
    there: Points,
}

impl Sampler<3> for CarriedSampler<'_> {
    fn enter(&mut self, region: &Aabb) {
        if let Some(inner) = &mut self.inner {
            inner.enter(&self.carried.back.region(region));
        }
    }

    fn leave(&mut self) {
        if let Some(inner) = &mut self.inner {
            inner.leave();
        }
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; 3]; BATCH]) {
        out[..points.len].fill([0.0; 3]);
        if let Some(inner) = &mut self.inner {
            self.carried.back.points(points, &mut self.there);
            inner.sample(&self.there, out);
            turn(&self.carried.turn, &mut out[..points.len]);
        }
        if let Some(whole) = &self.carried.whole {
            for (i, out) in out.iter_mut().enumerate().take(points.len) {
                let vector = whole.at(points.position(i)).as_vec3().to_array();
                *out = std::array::from_fn(|axis| out[axis] + vector[axis]);
            }
        }
    }
}

fn turn(matrix: &DMat3, vectors: &mut [[f32; 3]]) {
    for vector in vectors {
        *vector = (*matrix * DVec3::from_array(vector.map(f64::from))).as_vec3().to_array();
    }
}

/// The way of what is bent.
struct Bent {
    inner: Arc<dyn Attribute<3>>,
    bend: Arc<dyn Bend>,
}

impl Attribute<3> for Bent {
    fn sampler(&self) -> Box<dyn Sampler<3> + '_> {
        let way = Way::Bent(Arc::clone(&self.bend));
        Box::new(BentSampler { inner: self.inner.sampler(), way, bend: &*self.bend, there: Points::new(DVec3::ZERO) })
    }
}

struct BentSampler<'a> {
    inner: Box<dyn Sampler<3> + 'a>,
    way: Way,
    bend: &'a dyn Bend,
    there: Points,
}

impl Sampler<3> for BentSampler<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.inner.enter(&self.way.region(region));
    }

    fn leave(&mut self) {
        self.inner.leave();
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; 3]; BATCH]) {
        self.way.points(points, &mut self.there);
        self.inner.sample(&self.there, out);
        self.bend.vectors_carried(points, out);
    }
}

/// The way of what is bent by something that changes itself.
struct Moved {
    inner: Vectors,
    now: Arc<dyn Bend>,
    then: Arc<dyn Bend>,
}

impl Attribute<3> for Moved {
    fn sampler(&self) -> Box<dyn Sampler<3> + '_> {
        let inner = self.inner.as_ref().map(|inner| inner.sampler());
        let way = Way::Bent(Arc::clone(&self.now));
        Box::new(MovedSampler { inner, moved: self, way, there: Points::new(DVec3::ZERO) })
    }
}

struct MovedSampler<'a> {
    inner: Option<Box<dyn Sampler<3> + 'a>>,
    moved: &'a Moved,
    way: Way,
    there: Points,
}

impl Sampler<3> for MovedSampler<'_> {
    fn enter(&mut self, region: &Aabb) {
        if let Some(inner) = &mut self.inner {
            inner.enter(&self.way.region(region));
        }
    }

    fn leave(&mut self) {
        if let Some(inner) = &mut self.inner {
            inner.leave();
        }
    }

    fn sample(&mut self, points: &Points, out: &mut [[f32; 3]; BATCH]) {
        out[..points.len].fill([0.0; 3]);
        if let Some(inner) = &mut self.inner {
            self.way.points(points, &mut self.there);
            inner.sample(&self.there, out);
        }
        let Moved { now, then, .. } = self.moved;
        for (i, out) in out.iter_mut().enumerate().take(points.len) {
            let (position, own) = (points.position(i), DVec3::from_array(out.map(f64::from)));
            // By way of its own space: what a place there does between the two is to be seen from both.
            let way = then.forth(now.back(position) + own, now.branch(position)).map(|then| then - position);
            *out = way.unwrap_or_else(|| now.carried(position, own)).as_vec3().to_array();
        }
    }
}
