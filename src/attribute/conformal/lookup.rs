//! Interior distances anywhere: by the roots of the nodes around.
//!
//! Each of the eight nodes around a place tells the way over its own root; their mean, weighted as in trilinear
//! interpolation, is continuous, and exact where they share a root. Beside walls the nodes that are there tell. A place
//! outside of the body has what the nearest place of its surface has (CONFORMAL, section 4.2: there the ways to all
//! features grow alike).

use glam::{IVec3, Vec3};

use super::feature::Feature;
use super::nodes::{Body, NONE};
use super::sight::Sight;
use crate::field::{BATCH, Evaluator, Gradients, Points};

/// Deeper than this, in cells, all around a node is inside.
const DEEP: f32 = 2.0;
/// What two nodes around a place may tell apart, in cells, before one is suspected of standing behind a wall. Less: sight is
/// looked up where only roots differ; more: as much leaks through walls that are thinner than a cell.
const SUSPECT: f32 = 0.5;
/// No lattice reaches so far, in cells.
const FAR: f32 = 1e6;
/// How often a place outside is moved to the surface: the distance far away may be measured coarsely.
const STEPS_TO_SURFACE: usize = 3;

/// The nodes around a place, with their shares.
#[derive(Clone, Copy)]
struct Corners {
    nodes: [u32; 8],
    shares: [f32; 8],
    count: usize,
}

impl Corners {
    const NONE: Self = Self { nodes: [NONE; 8], shares: [0.0; 8], count: 0 };

    fn push(&mut self, node: u32, share: f32) {
        (self.nodes[self.count], self.shares[self.count]) = (node, share);
        self.count += 1;
    }

    fn iter(&self) -> impl Iterator<Item = (u32, f32)> {
        self.nodes.into_iter().zip(self.shares).take(self.count)
    }
}

/// Reads interior distances of one body, on one thread, batch by batch.
pub(super) struct Lookup<'b> {
    body: &'b Body,
    sight: Sight<'b>,
    distance: Box<dyn Evaluator + 'b>,
    /// The points of the batch: as they were asked for, those outside moved to the surface.
    points: Points,
    /// The same on the lattice.
    places: [Vec3; BATCH],
    corners: [Corners; BATCH],
    /// Whether a wall is near, and the sight of the corners was not looked up yet.
    is_open: [bool; BATCH],
    /// How far outside the points were, units.
    away: [f32; BATCH],
    /// Points near a wall, and where they are in the batch.
    near: Points,
    at: Vec<usize>,
    gradients: Box<Gradients>,
    /// The distances to the feature that is read, straight.
    reaches: [f32; BATCH],
}

impl<'b> Lookup<'b> {
    pub fn new(body: &'b Body) -> Self {
        Self {
            body,
            sight: Sight::new(body),
            distance: body.distance().evaluator(),
            points: Points::new(body.origin()),
            places: [Vec3::ZERO; BATCH],
            corners: [Corners::NONE; BATCH],
            is_open: [false; BATCH],
            away: [0.0; BATCH],
            near: Points::new(body.origin()),
            at: Vec::with_capacity(BATCH),
            gradients: Box::default(),
            reaches: [0.0; BATCH],
        }
    }

    /// The points of the batch, those outside moved to the surface.
    pub fn points(&self) -> &Points {
        &self.points
    }

    /// How far outside a point of the batch was, units; 0 inside.
    pub fn away(&self, i: usize) -> f32 {
        self.away[i]
    }

    /// Takes a batch of points: all that is the same for every feature.
    pub fn begin(&mut self, points: &Points) {
        self.points.clone_from(points);
        self.away[..points.len].fill(0.0);
        self.at.clear();
        for i in 0..points.len {
            self.places[i] = self.body.on_lattice(points.position(i));
            self.corners[i] = self.around(self.places[i]);
            let corners = &self.corners[i];
            self.is_open[i] = corners.count < 8 || self.body.depth(corners.nodes[0]) < DEEP;
            if self.is_open[i] {
                self.at.push(i);
            }
        }
        for _ in 0..STEPS_TO_SURFACE {
            self.move_to_surface();
        }
    }

    /// The nodes of the eight cells whose middles are around a place.
    fn around(&self, place: Vec3) -> Corners {
        // Far away nothing is around; whole numbers do not reach there.
        let place = place.clamp(Vec3::splat(-FAR), Vec3::splat(FAR));
        let cell = place.floor();
        let (share, cell) = (place - cell, cell.as_ivec3());
        let mut corners = Corners::NONE;
        for (i, node) in self.body.corners(cell).into_iter().enumerate() {
            if node != NONE {
                let along = |axis: usize| if i >> (2 - axis) & 1 == 1 { share[axis] } else { 1.0 - share[axis] };
                corners.push(node, along(0) * along(1) * along(2));
            }
        }
        // On the middles themselves only nodes without a share may be there.
        if corners.shares.iter().sum::<f32>() > 0.0 { corners } else { self.nearest(place) }
    }

    /// The nearest node alone.
    fn nearest(&self, place: Vec3) -> Corners {
        /// The body reaches into the cell of each of its places; rounding may lead to the next.
        const REACH: i32 = 2;
        let (middle, mut best) = ((place + 0.5).floor().as_ivec3(), (f32::INFINITY, NONE));
        for x in -REACH..=REACH {
            for y in -REACH..=REACH {
                for z in -REACH..=REACH {
                    let node = self.body.node(middle + IVec3::new(x, y, z));
                    if node != NONE {
                        let apart = place.distance(self.body.place(node));
                        best = if (apart, node) < best { (apart, node) } else { best };
                    }
                }
            }
        }
        let mut corners = Corners::NONE;
        if best.1 != NONE {
            corners.push(best.1, 1.0);
        }
        corners
    }

    /// Moves the points of `at` that are outside towards the surface, and keeps those in `at`.
    fn move_to_surface(&mut self) {
        if self.at.is_empty() {
            return;
        }
        (self.near.origin, self.near.len) = (self.points.origin, 0);
        self.at.iter().for_each(|&i| self.near.push(self.points.offset(i)));
        self.distance.gradients(&self.near, &mut self.gradients);
        let mut kept = 0;
        for j in 0..self.at.len() {
            let (i, value) = (self.at[j], self.gradients.value[j]);
            // Within a thousandth of a cell it is on the surface.
            if value >= -1e-3 * self.body.edge() as f32 {
                continue;
            }
            self.away[i] -= value;
            let moved = self.points.offset(i) - self.gradients.gradient(j).normalize_or_zero() * value;
            (self.points.x[i], self.points.y[i], self.points.z[i]) = moved.into();
            self.places[i] = self.body.on_lattice(self.points.position(i));
            self.corners[i] = self.around(self.places[i]);
            self.at[kept] = i;
            kept += 1;
        }
        self.at.truncate(kept);
    }

    /// The interior distances of the batch from a feature, whose field an evaluator answers for, in cells. Not a number
    /// where the surface could not be found.
    pub fn distances(&mut self, feature: &Feature, evaluator: &mut dyn Evaluator, out: &mut [f32; BATCH]) {
        evaluator.values(&self.points, &mut self.reaches);
        let scale = self.body.edge().recip() as f32;
        for i in 0..self.points.len {
            let reach = (-self.reaches[i] * scale).max(0.0);
            if reach == 0.0 {
                out[i] = 0.0;
                continue;
            }
            if let Some(bend) = feature.shared(self.corners[i].iter().map(|(node, _)| node)) {
                out[i] = feature.over(bend, self.places[i], reach);
                continue;
            }
            if self.is_open[i] && self.is_suspect(feature, i, reach) {
                self.is_open[i] = false;
                self.keep_seen(i);
            }
            out[i] = self.mean(feature, i, reach);
        }
    }

    fn mean(&self, feature: &Feature, i: usize, reach: f32) -> f32 {
        let (mut sum, mut shares) = (0.0, 0.0);
        for (node, share) in self.corners[i].iter() {
            sum += share * feature.through(self.body, node, self.places[i], reach);
            shares += share;
        }
        sum / shares
    }

    /// Whether a node tells a way that is longer than over another one of them, which then is behind a wall, or that one is.
    fn is_suspect(&self, feature: &Feature, i: usize, reach: f32) -> bool {
        let place = self.places[i];
        let (mut longest, mut over, mut cell) = (0.0f32, f32::INFINITY, 0.0f32);
        for (node, _) in self.corners[i].iter() {
            longest = longest.max(feature.through(self.body, node, place, reach));
            over = over.min(feature.value(node) + place.distance(self.body.place(node)) * feature.of_cell(node));
            cell = cell.max(feature.of_cell(node));
        }
        longest > over + SUSPECT * cell
    }

    /// Keeps the nodes around that a point sees, if it sees one.
    fn keep_seen(&mut self, i: usize) {
        let mut seen = Corners::NONE;
        for (node, share) in self.corners[i].iter() {
            if self.sight.is_clear(self.places[i], self.body.place(node)) {
                seen.push(node, share);
            }
        }
        if seen.shares.iter().sum::<f32>() > 0.0 {
            self.corners[i] = seen;
        }
    }
}
