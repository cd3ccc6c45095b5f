//! One leaf block: values, feet and distances of its 512 voxels.

mod feet;
mod lanes;

use glam::{DVec3, IVec3, Vec3};

use crate::{
    field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Points, Slope},
    grid::{BLOCK_EDGE, BLOCK_VOXELS, BlockMask, mask, node_origin},
};

use super::{
    band::{Error, Feet},
    descent::{NODE_EDGE, Scope},
    exchange,
    facing::{Offer, Seed, Side},
    polish::{
        Polisher, Request, Resolution, Sides,
        around::{Approach, Around},
    },
    staged::{ROOM, Staged},
};

/// Edges in voxels of the nodes whose tapes are shortened on the way to a block's, each from the one before. The
/// last are those whose blocks are measured one after the other; others are left out where that saves nothing.
const NODE_EDGES: [i32; 2] = [NODE_EDGE, TASK_EDGE];
/// See [`NODE_EDGES`].
pub const TASK_EDGE: i32 = 32;

/// Whether a voxel's distance follows from F there alone.
pub fn by_itself(slope: Slope, sought: Feet) -> bool {
    sought == Feet::FirstOrder || matches!(slope, Slope::Exact { inside: true, outside: true })
}

/// Measures blocks on one thread.
pub struct Meter<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    slope: Slope,
    sought: Feet,
    scope: Scope,
    background: f32,
    region: Aabb,
    /// The nodes around the block measured next: as many of [`NODE_EDGES`] as are entered.
    entered: Vec<IVec3>,
    resolution: Resolution,
    polisher: Polisher,
    around: Around,
    sides: Sides,
    open: Vec<Approach>,
    at_voxels: Box<Gradients>,
    at_feet: Box<Gradients>,
    points: Points,
    feet: Box<Points>,
    /// Unsigned.
    distances: Box<[f32; BLOCK_VOXELS]>,
    changed: Box<[bool; BLOCK_VOXELS]>,
    some_queries: Points,
    some_feet: Points,
    some_distances: Box<[f32; BATCH]>,
    some_inside: Box<[bool; BATCH]>,
}

impl<'a> Meter<'a> {
    pub fn new(field: &'a dyn Field, scope: &Scope, sought: Feet) -> Self {
        let empty = || Points::new(DVec3::ZERO);
        Self {
            evaluator: field.evaluator(),
            slope: field.slope(),
            sought,
            scope: *scope,
            background: scope.background(),
            region: Aabb::new(DVec3::ZERO, DVec3::ZERO),
            entered: Vec::with_capacity(NODE_EDGES.len()),
            resolution: scope.resolution(),
            polisher: Polisher::new(),
            around: Around::new(),
            sides: Sides::new(),
            open: Vec::new(),
            at_voxels: Box::default(),
            at_feet: Box::default(),
            points: Points::of_block(IVec3::ZERO, &scope.lattice),
            feet: Box::new(empty()),
            distances: Box::new([0.0; BLOCK_VOXELS]),
            changed: Box::new([false; BLOCK_VOXELS]),
            some_queries: empty(),
            some_feet: empty(),
            some_distances: Box::new([0.0; BATCH]),
            some_inside: Box::new([false; BATCH]),
        }
    }

    /// Enters the nodes that hold a block, so that its tape is cut from their shorter ones. Those that held the block
    /// before stay.
    pub fn enter_nodes(&mut self, block: IVec3) {
        let nodes = NODE_EDGES.map(|edge| (edge, node_origin(block, edge)));
        let nodes = &nodes[usize::from(!self.evaluator.hints(Hint::HasManyParts).has_many_parts)..];
        let same = self.entered.iter().zip(nodes).take_while(|(entered, (_, node))| *entered == node).count();
        for _ in self.entered.drain(same..) {
            self.evaluator.leave();
        }
        for &(edge, node) in &nodes[same..] {
            self.evaluator.enter(&self.scope.centres(node, edge, f64::from(self.scope.half_width) + ROOM));
            self.entered.push(node);
        }
    }

    /// Measures a block into `out`, by itself.
    pub fn measure(&mut self, origin: IVec3, out: &mut Staged) -> Result<(), Error> {
        self.enter_block(origin);
        let result = self.check_values().map(|()| {
            self.find_feet();
            self.settle(out);
            self.finish(origin, out);
        });
        self.evaluator.leave();
        result
    }

    /// Improves a measured block by what its neighbours offer: no voxel's foot gets farther.
    pub fn improve(&mut self, seeds: &[Seed], block: &mut Staged) {
        self.enter_block(block.origin);
        (*self.feet).clone_from(&self.points);
        for i in 0..BLOCK_VOXELS {
            self.distances[i] = block.distances[i].abs();
            if let Some(to_foot) = block.to_foot(i) {
                self.set_foot(i, self.points.offset(i) + to_foot);
            }
        }
        self.take_seeds(seeds);
        self.settle(block);
        self.finish(block.origin, block);
        self.evaluator.leave();
    }

    fn enter_block(&mut self, origin: IVec3) {
        let margin = f64::from(self.scope.half_width) + ROOM;
        self.region = self.scope.centres(origin, BLOCK_EDGE, margin);
        self.points.origin = Points::middle_of_block(origin, &self.scope.lattice);
        self.evaluator.enter(&self.region);
        self.evaluator.gradients(&self.points, &mut self.at_voxels);
        if !by_itself(self.slope, Feet::Nearest) {
            self.sides.settle(&mut *self.evaluator, self.resolution, &self.points, &mut self.at_voxels);
        }
    }

    /// Whether its neighbours have nothing to offer to a block.
    fn is_by_itself(&self) -> bool {
        by_itself(self.slope, self.sought)
    }

    /// Lets the voxels take each other's feet, and signs the distances.
    fn settle(&mut self, out: &mut Staged) {
        self.exchange();
        lanes::signed(&self.at_voxels.value, &self.distances, &mut out.distances);
        if self.find_crossings(&out.distances) {
            lanes::signed(&self.at_voxels.value, &self.distances, &mut out.distances);
        }
    }

    fn voxel(&self) -> f32 {
        self.scope.lattice.voxel_size.get() as f32
    }

    fn request(&self) -> Request {
        Request { unit: self.voxel(), least: self.resolution.least, reach: self.background, region: self.region }
    }

    fn check_values(&self) -> Result<(), Error> {
        let values = &self.at_voxels.value;
        // The usual answer is no, and a loop without a way out finds that out fast.
        let any = values.iter().fold(false, |any, value| any | value.is_nan());
        if any && let Some(first) = values.iter().position(|value| value.is_nan()) {
            return Err(Error::NotANumber { position: self.points.position(first) });
        }
        Ok(())
    }

    /// Takes the seeds that are nearer than what was found, and polishes them.
    fn take_seeds(&mut self, seeds: &[Seed]) {
        self.changed.fill(false);
        for seed in seeds {
            let i = usize::from(seed.voxel);
            let foot = match seed.offer {
                Offer::Foot(foot) => foot,
                Offer::Crossing(step) => self.bisect(self.points.offset(i), step, self.at_voxels.value[i] >= 0.0),
            };
            let distance = (self.points.offset(i) - foot).length();
            if distance < self.distances[i] {
                self.distances[i] = distance;
                (self.feet.x[i], self.feet.y[i], self.feet.z[i]) = foot.into();
                self.changed[i] = true;
            }
        }
        self.polish_changed();
    }

    /// Where the sign changes between two neighbours their distances add up to a voxel at most; where they do not (F
    /// has no gradient to follow, or jumps, or another sheet is nearly as near) bisection finds the surface. `signed` are
    /// the distances as they are; whether they have changed.
    fn find_crossings(&mut self, signed: &[f32; BLOCK_VOXELS]) -> bool {
        let voxel = self.voxel();
        if !exchange::any_crossing_missed(voxel, signed) {
            return false;
        }
        let mut found = false;
        for (stride, axis) in [(64, 0), (8, 1), (1, 2)] {
            for i in (0..BLOCK_VOXELS - stride).filter(|&i| (i / stride) % 8 < 7) {
                let signed =
                    |i: usize| if self.at_voxels.value[i] >= 0.0 { self.distances[i] } else { -self.distances[i] };
                let inside = self.at_voxels.value[i] >= 0.0;
                if !exchange::miss_a_crossing(voxel, signed(i), signed(i + stride)) {
                    continue;
                }
                if !found {
                    found = true;
                    self.changed.fill(false);
                }
                let mut step = Vec3::ZERO;
                step[axis] = voxel;
                let crossing = self.bisect(self.points.offset(i), step, inside);
                for i in [i, i + stride] {
                    let distance = (self.points.offset(i) - crossing).length();
                    if distance < self.distances[i] {
                        self.distances[i] = distance;
                        (self.feet.x[i], self.feet.y[i], self.feet.z[i]) = crossing.into();
                        self.changed[i] = true;
                    }
                }
            }
        }
        if found {
            self.polish_changed();
            self.exchange();
        }
        found
    }

    /// The point between `from` and `from + step` where the sign is no longer that of `from`.
    fn bisect(&mut self, from: Vec3, step: Vec3, inside: bool) -> Vec3 {
        let (mut same, mut other) = (0.0, 1.0);
        self.some_queries.origin = self.points.origin;
        // 2⁻¹² of a voxel is far below the error allowed.
        for _ in 0..12 {
            let middle = 0.5 * (same + other);
            self.some_queries.len = 0;
            self.some_queries.push(from + step * middle);
            self.evaluator.values(&self.some_queries, &mut self.some_distances);
            if (self.some_distances[0] >= 0.0) == inside { same = middle } else { other = middle }
        }
        from + step * other
    }

    /// What follows from the signed distances.
    fn finish(&mut self, origin: IVec3, out: &mut Staged) {
        out.origin = origin;
        lanes::normals(&self.points, &self.feet, &self.at_voxels, &out.distances, self.voxel(), &mut out.normals);
        out.active = lanes::active(&out.distances, self.background);
        Side::fill_all(&out.distances, &out.normals, &mut out.sides);
        self.count_thin(out);
    }

    /// Counts voxels beside a feature thinner than a voxel: those with the same sign again a voxel behind the surface, and
    /// those on it with no inside around them.
    ///
    /// Any piece of surface is within half a voxel's diagonal of a voxel. Most voxels that near have a neighbour of
    /// the other sign, and only the others are probed.
    fn count_thin(&mut self, out: &mut Staged) {
        /// Of so many of a block's voxels the thickness is asked for until one tells it.
        const MEASURED: u32 = 16;
        out.thin = 0;
        out.thin_at = None;
        out.thin_size = 0.0;
        if self.sought == Feet::FirstOrder {
            return;
        }
        let voxel = self.voxel();
        let beside = lanes::beside_surface(&self.at_voxels.value, &self.distances, voxel);
        if beside == [0; 8] {
            return;
        }
        let (ways, is_on) = self.ways_through(&beside);
        self.probe(ways.iter().map(|&(from, way)| from + way * voxel));
        let values = *self.some_distances;
        for (lane, i) in mask::places(&beside).enumerate() {
            let is_thin = if is_on[lane] {
                !self.is_deep(i, values[lane]) && !self.has_inside_around(i)
            } else {
                (values[lane] >= 0.0) == (self.at_voxels.value[i] >= 0.0)
            };
            if is_thin {
                out.thin_at.get_or_insert(self.points.position(i));
                if out.thin_size == 0.0 && out.thin < MEASURED {
                    out.thin_size = self.thickness(ways[lane], is_on[lane] || self.at_voxels.value[i] < 0.0);
                }
                out.thin += 1;
            }
        }
    }

    /// For each voxel beside the surface a point on it and the unit vector on through it; and whether the voxel is on it,
    /// where the way is the inward one.
    fn ways_through(&self, beside: &BlockMask) -> (Vec<(Vec3, Vec3)>, Vec<bool>) {
        let voxel = self.voxel();
        let way = |i: usize| {
            let (point, foot) = (self.points.offset(i), self.feet.offset(i));
            if self.distances[i] < lanes::ON_SURFACE * voxel {
                ((point, self.at_voxels.gradient(i).normalize_or_zero()), true)
            } else {
                ((foot, (foot - point) / self.distances[i]), false)
            }
        };
        mask::places(beside).map(way).unzip()
    }

    /// Puts F at some points, as offsets in the block, into `some_distances`.
    fn probe(&mut self, points: impl Iterator<Item = Vec3>) {
        self.some_queries.origin = self.points.origin;
        self.some_queries.len = 0;
        points.for_each(|point| self.some_queries.push(point));
        self.evaluator.values(&self.some_queries, &mut self.some_distances);
    }

    /// Whether F is that of a point that its voxel holds, near a voxel on the surface.
    fn is_deep(&self, i: usize, value: f32) -> bool {
        value > lanes::ON_SURFACE * self.voxel() * self.at_voxels.gradient(i).length()
    }

    /// Whether one of the 26 places of a voxel's neighbours is inside: some of them are in other blocks.
    fn has_inside_around(&mut self, i: usize) -> bool {
        let (point, voxel) = (self.points.offset(i), self.voxel());
        self.probe((0..27).map(|k| point + neighbour(k) * voxel));
        (0..27).any(|k| k != 13 && self.is_deep(i, self.some_distances[k]))
    }

    /// How far it is through a feature thinner than a voxel, about: of halves of a voxel the longest that is still in it, on
    /// the way or towards a neighbour's place (across a sharp edge the way leads out again at once). 0 where even the shortest is not.
    fn thickness(&mut self, (from, way): (Vec3, Vec3), is_inside: bool) -> f32 {
        const HALVINGS: usize = 16;
        let voxel = self.voxel();
        let along = |k: usize| voxel * 0.5_f32.powi(k as i32 + 1);
        let ways: [Vec3; 27] = std::array::from_fn(|i| if i == 13 { way } else { neighbour(i).normalize() });
        self.probe((0..HALVINGS).flat_map(|k| ways.map(|way| from + way * along(k))));
        let is_in = |probe: &usize| {
            let value = self.some_distances[*probe];
            if is_inside { value > 0.0 } else { value < 0.0 }
        };
        (0..HALVINGS * ways.len()).find(is_in).map_or(0.0, |probe| along(probe / ways.len()))
    }
}

/// The way to one of the 27 places of a voxel and its neighbours, in voxels; 13 is its own.
fn neighbour(k: usize) -> Vec3 {
    Vec3::new((k / 9) as f32, (k / 3 % 3) as f32, (k % 3) as f32) - 1.0
}
