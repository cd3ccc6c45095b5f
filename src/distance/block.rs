//! One leaf block: values, feet and distances of its 512 voxels.

use glam::{DVec3, IVec3, Vec3};

use crate::{
    field::{Aabb, BATCH, Evaluator, Field, Gradients, Points, Slope},
    grid::{BLOCK_EDGE, BLOCK_VOXELS, BlockMask, Lattice},
};

use super::{
    band::Error,
    descent::Scope,
    exchange,
    polish::{Polisher, Request},
};

/// Room around a block, in voxels beyond the half width, in which its feet are sought.
const ROOM: f64 = 1.0;

/// A finished block, as visitors see it. Offsets of all points are from the same origin.
pub struct MeasuredBlock<'a> {
    /// The block's least corner.
    pub origin: IVec3,
    /// Where the voxels stand.
    pub lattice: Lattice,
    /// A box that holds all voxel centres and feet.
    pub region: Aabb,
    /// The voxel centres.
    pub points: &'a Points,
    /// Signed distances, world units, positive inside, clamped to ± the background.
    pub distances: &'a [f32; BLOCK_VOXELS],
    /// Voxels nearer to the surface than the background.
    pub active: &'a BlockMask,
    /// The closest surface point of each active voxel; an inactive voxel's own centre.
    pub feet: &'a Points,
    /// Gradients of the distance: unit vectors pointing inward, x, y and z; zero at inactive voxels.
    pub normals: &'a [[f32; BLOCK_VOXELS]; 3],
}

/// What a block turned out to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It holds active voxels.
    Band,
    /// No active voxel, all outside.
    Outside,
    /// No active voxel, all inside.
    Inside,
}

/// Measures blocks on one thread.
pub struct Meter<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    slope: Slope,
    scope: Scope,
    background: f32,
    entered: Option<IVec3>,
    polisher: Polisher,
    at_voxels: Box<Gradients>,
    points: Points,
    feet: Points,
    /// Unsigned while measuring, then signed.
    distances: Box<[f32; BLOCK_VOXELS]>,
    changed: Box<[bool; BLOCK_VOXELS]>,
    some_queries: Points,
    some_feet: Points,
    some_distances: Box<[f32; BATCH]>,
    normals: Box<[[f32; BLOCK_VOXELS]; 3]>,
    active: BlockMask,
    /// Voxels nearer than half a voxel to a surface that has the same sign all around them.
    pub thin: u32,
    /// One of them.
    pub thin_at: Option<DVec3>,
    origin: IVec3,
    region: Aabb,
}

impl<'a> Meter<'a> {
    pub fn new(field: &'a dyn Field, scope: &Scope) -> Self {
        let empty = || Points::new(DVec3::ZERO);
        Self {
            evaluator: field.evaluator(),
            slope: field.slope(),
            scope: *scope,
            background: (f64::from(scope.half_width) * scope.lattice.voxel_size.get()) as f32,
            entered: None,
            polisher: Polisher::new(),
            at_voxels: Box::default(),
            points: empty(),
            feet: empty(),
            distances: Box::new([0.0; BLOCK_VOXELS]),
            changed: Box::new([false; BLOCK_VOXELS]),
            some_queries: empty(),
            some_feet: empty(),
            some_distances: Box::new([0.0; BATCH]),
            normals: Box::new([[0.0; BLOCK_VOXELS]; 3]),
            active: [0; 8],
            thin: 0,
            thin_at: None,
            origin: IVec3::ZERO,
            region: Aabb::new(DVec3::ZERO, DVec3::ZERO),
        }
    }

    /// Enters a node that holds the blocks measured next, so that their tapes are cut from its shorter one.
    pub fn enter_node(&mut self, node: IVec3, edge: i32) {
        if self.entered == Some(node) {
            return;
        }
        self.leave_node();
        self.evaluator.enter(&self.scope.centres(node, edge, f64::from(self.scope.half_width) + ROOM));
        self.entered = Some(node);
    }

    fn leave_node(&mut self) {
        if self.entered.take().is_some() {
            self.evaluator.leave();
        }
    }

    /// Measures a block; its result is then [`Meter::block`].
    pub fn measure(&mut self, origin: IVec3) -> Result<Kind, Error> {
        let margin = f64::from(self.scope.half_width) + ROOM;
        self.origin = origin;
        self.region = self.scope.centres(origin, BLOCK_EDGE, margin);
        self.points = Points::of_block(origin, &self.scope.lattice);
        self.evaluator.enter(&self.region);
        self.evaluator.gradients(&self.points, &mut self.at_voxels);
        let result = self.check_values().map(|()| {
            self.find_feet();
            self.exchange();
            self.count_thin();
        });
        self.evaluator.leave();
        result.map(|()| self.finish())
    }

    fn voxel(&self) -> f32 {
        self.scope.lattice.voxel_size.get() as f32
    }

    fn request(&self) -> Request {
        Request { unit: self.voxel(), reach: self.background, region: self.region }
    }

    fn check_values(&self) -> Result<(), Error> {
        match self.at_voxels.value.iter().position(|value| value.is_nan()) {
            Some(i) => Err(Error::NotANumber { position: self.points.position(i) }),
            None => Ok(()),
        }
    }

    /// Each voxel's own foot.
    fn find_feet(&mut self) {
        self.feet.clone_from(&self.points);
        let (outside, inside) = match self.slope {
            Slope::Exact { outside, inside } => (outside, inside),
            _ => (false, false),
        };
        if !outside && !inside {
            let request = self.request();
            let Self { evaluator, polisher, points, feet, distances, .. } = self;
            polisher.closest(&mut **evaluator, &request, points, feet, distances);
            return;
        }
        self.changed.fill(false);
        for i in 0..BLOCK_VOXELS {
            let value = self.at_voxels.value[i];
            let gradient = self.at_voxels.gradient(i).normalize_or_zero();
            if (if value < 0.0 { outside } else { inside }) && gradient != Vec3::ZERO {
                self.distances[i] = value.abs();
                let foot = self.points.offset(i) - gradient * value;
                (self.feet.x[i], self.feet.y[i], self.feet.z[i]) = foot.into();
            } else {
                self.distances[i] = f32::INFINITY;
                self.changed[i] = true;
            }
        }
        self.polish_changed();
    }

    /// Nearer feet of neighbours, until there are none.
    fn exchange(&mut self) {
        if matches!(self.slope, Slope::Exact { inside: true, outside: true }) {
            return;
        }
        // Each round settles what the one before brought in; a foot hardly ever travels on after the second.
        for _ in 0..4 {
            self.changed.fill(false);
            let voxel = self.voxel();
            if !exchange::sweep(voxel, &self.points, &mut self.feet, &mut self.distances, &mut self.changed) {
                break;
            }
            self.polish_changed();
        }
    }

    /// Polishes the feet marked in `changed`, from where they are.
    fn polish_changed(&mut self) {
        self.some_queries.origin = self.points.origin;
        self.some_feet.origin = self.points.origin;
        (self.some_queries.len, self.some_feet.len) = (0, 0);
        for i in (0..BLOCK_VOXELS).filter(|&i| self.changed[i]) {
            self.some_queries.push(self.points.offset(i));
            self.some_feet.push(self.feet.offset(i));
        }
        if self.some_queries.len == 0 {
            return;
        }
        let request = self.request();
        let Self { evaluator, polisher, some_queries, some_feet, some_distances, .. } = self;
        polisher.closest(&mut **evaluator, &request, some_queries, some_feet, some_distances);
        for (lane, i) in (0..BLOCK_VOXELS).filter(|&i| self.changed[i]).enumerate() {
            if self.some_distances[lane] < self.distances[i] {
                self.distances[i] = self.some_distances[lane];
                let foot = self.some_feet.offset(lane);
                (self.feet.x[i], self.feet.y[i], self.feet.z[i]) = foot.into();
            }
        }
    }

    /// Signs, clamps, masks and normals.
    fn finish(&mut self) -> Kind {
        self.active = [0; 8];
        for i in 0..BLOCK_VOXELS {
            let inside = self.at_voxels.value[i] >= 0.0;
            let distance = self.distances[i];
            let sign = if inside { 1.0 } else { -1.0 };
            let mut normal = Vec3::ZERO;
            if distance < self.background {
                self.active[i >> 6] |= 1 << (i & 63);
                self.distances[i] = sign * distance;
                normal = self.normal(i, sign, distance);
            } else {
                self.distances[i] = sign * self.background;
                (self.feet.x[i], self.feet.y[i], self.feet.z[i]) = self.points.offset(i).into();
            }
            (self.normals[0][i], self.normals[1][i], self.normals[2][i]) = normal.into();
        }
        if self.active != [0; 8] {
            Kind::Band
        } else if self.at_voxels.value[0] >= 0.0 {
            Kind::Inside
        } else {
            Kind::Outside
        }
    }

    /// The gradient of the distance: along the way to the foot, or where that is too short to have a direction, F's.
    fn normal(&self, i: usize, sign: f32, distance: f32) -> Vec3 {
        if distance > 0.05 * self.voxel() {
            ((self.points.offset(i) - self.feet.offset(i)) * sign).normalize_or_zero()
        } else {
            self.at_voxels.gradient(i).normalize_or_zero()
        }
    }

    /// Counts voxels beside a surface with the same sign again a voxel behind it: a feature thinner than a voxel.
    ///
    /// Any piece of surface is within half a voxel's diagonal of a voxel. Most voxels that near have a neighbour of
    /// the other sign, and only the others are probed.
    fn count_thin(&mut self) {
        self.thin = 0;
        self.thin_at = None;
        let voxel = self.voxel();
        let inside = |value: f32| value >= 0.0;
        let probes = &mut self.some_queries;
        probes.origin = self.points.origin;
        probes.len = 0;
        self.changed.fill(false);
        for i in 0..BLOCK_VOXELS {
            let distance = self.distances[i];
            if distance > 0.87 * voxel || distance < 0.05 * voxel || beside_other_sign(&self.at_voxels.value, i) {
                continue;
            }
            let (point, foot) = (self.points.offset(i), self.feet.offset(i));
            probes.push(foot + (foot - point) * (voxel / distance));
            self.changed[i] = true;
        }
        if probes.len == 0 {
            return;
        }
        self.evaluator.values(probes, &mut self.some_distances);
        for (lane, i) in (0..BLOCK_VOXELS).filter(|&i| self.changed[i]).enumerate() {
            if inside(self.some_distances[lane]) == inside(self.at_voxels.value[i]) {
                self.thin += 1;
                self.thin_at.get_or_insert(self.points.position(i));
            }
        }
    }

    /// The block measured last.
    pub fn block(&self) -> MeasuredBlock<'_> {
        MeasuredBlock {
            origin: self.origin,
            lattice: self.scope.lattice,
            region: self.region,
            points: &self.points,
            distances: &self.distances,
            active: &self.active,
            feet: &self.feet,
            normals: &self.normals,
        }
    }
}

/// Whether one of a voxel's neighbours in its block lies on the other side.
fn beside_other_sign(values: &[f32; BLOCK_VOXELS], i: usize) -> bool {
    let at = [i >> 6, (i >> 3) & 7, i & 7];
    let near = |c: usize| c.saturating_sub(1)..=(c + 1).min(7);
    near(at[0])
        .any(|x| near(at[1]).any(|y| near(at[2]).any(|z| (values[x << 6 | y << 3 | z] >= 0.0) != (values[i] >= 0.0))))
}
