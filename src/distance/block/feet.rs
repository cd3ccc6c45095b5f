//! The feet of a block's voxels: their own, and those that neighbours have.
//!
//! Where the block holds few branches all its voxels are polished in one batch. Where there are many, a voxel's foot is
//! sought in a small cube grown by the band's width: nearly all branches of the block have no part in it.

use glam::Vec3;

use super::{Meter, lanes};
use crate::{
    distance::{
        band::Feet,
        exchange,
        polish::{COMBINED, FEW, Request, around::Approach},
    },
    field::{Aabb, Slope},
    grid::{BLOCK_EDGE, BLOCK_VOXELS},
};

/// How near to the surface a voxel is, in voxels, whose foot is sought by itself where there are many branches; others
/// get theirs from neighbours, which is not always the nearest. Larger holds more branches.
const NEAR: f64 = 3.0;

/// The same where regions around voxels hold more branches than can be combined. Every piece of surface is nearer than
/// this to some voxel.
const LEAST_NEAR: f64 = 1.0;

/// The thickness in voxels of the shells in which feet are carried outward. Thicker carries feet that are not settled.
const SHELL: f32 = 0.5;

/// How near to the surface, in voxels, first order takes more than one step: as far as a voxel's neighbours on its other side.
const BESIDE: f32 = 1.75;
/// The most of them.
const STEPS: usize = 4;
/// The step, in voxels, after which there is none.
const SETTLED: f32 = 0.05;
/// How far, in voxels, a foot may lie aside of the normal through its voxel, before it is sought as that of a frame is: it does
/// so at edges.
const ASIDE: f32 = 0.2;

/// The edge in voxels of the least cube whose near feet are sought together.
const LEAST_CUBE: usize = 2;

impl Meter<'_> {
    /// Each voxel's own foot.
    pub(super) fn find_feet(&mut self) {
        let (outside, inside) = match self.slope {
            Slope::Exact { outside, inside } => (outside, inside),
            _ => (false, false),
        };
        if self.sought == Feet::FirstOrder {
            self.first_order(outside, inside);
            return;
        }
        let few_branches = self.evaluator.branches() <= FEW;
        if !outside && !inside && few_branches {
            let request = self.request();
            let Self { evaluator, polisher, points, at_voxels, feet, distances, .. } = self;
            polisher.closest_from(&mut **evaluator, &request, points, at_voxels, feet, distances);
            return;
        }
        (*self.feet).clone_from(&self.points);
        self.changed.fill(false);
        let mut any = false;
        for i in 0..BLOCK_VOXELS {
            let value = self.at_voxels.value[i];
            let gradient = self.at_voxels.gradient(i).normalize_or_zero();
            if (if value < 0.0 { outside } else { inside }) && gradient != Vec3::ZERO {
                self.distances[i] = value.abs();
                self.set_foot(i, self.points.offset(i) - gradient * value);
            } else {
                self.distances[i] = f32::INFINITY;
                self.changed[i] = true;
                any = true;
            }
        }
        if any && few_branches {
            self.polish_changed();
        } else if any {
            self.find_near_feet([0; 3], BLOCK_EDGE as usize, NEAR);
            self.spread();
        }
    }

    /// The feet by one step of Newton's method, with distances to them (G. Taubin, Distance approximations for rasterizing
    /// implicit curves, 1994, eq. 5). Beside the surface, where pictures interpolate, more steps settle what F curves within a
    /// voxel, as it does near the ends of a morph: the distance is that to the tangent plane there. At edges feet are polished.
    fn first_order(&mut self, outside: bool, inside: bool) {
        let most = BESIDE * self.voxel();
        let crossed = lanes::beside_other_sign(&self.at_voxels.value);
        self.changed.fill(false);
        for i in 0..BLOCK_VOXELS {
            let (point, value, gradient) = (self.points.offset(i), self.at_voxels.value[i], self.at_voxels.gradient(i));
            if value == 0.0 || if value < 0.0 { outside } else { inside } {
                self.distances[i] = value.abs();
                self.set_foot(i, point - gradient.normalize_or_zero() * value);
                continue;
            }
            let Some((step, distance)) = newton(value, gradient) else {
                // Without a slope nothing is known: as far as the band reaches.
                self.distances[i] = f32::INFINITY;
                self.set_foot(i, point);
                continue;
            };
            self.distances[i] = distance;
            self.set_foot(i, point + step);
            // The surface is a voxel's diagonal away from neighbours of two signs; those of voxels on the border may be in other
            // blocks.
            let is_crossed = crossed[i >> 6] >> (i & 63) & 1 == 1;
            let near = if lanes::is_on_border(i) { 2.0 * most } else { most };
            if is_crossed || distance < near {
                self.changed[i] = true;
                self.set_foot(i, point + if is_crossed { step.clamp_length_max(most) } else { step });
            }
        }
        let mut aside = [false; BLOCK_VOXELS];
        for _ in 0..STEPS {
            if !self.step_on(2.0 * most, &mut aside) {
                break;
            }
        }
        for i in 0..BLOCK_VOXELS {
            self.changed[i] |= aside[i];
            // What is polished may come out farther.
            if self.changed[i] {
                self.distances[i] = 1.05 * (self.points.offset(i) - self.feet.offset(i)).length();
            }
        }
        self.polish_changed();
    }

    /// One more step of those feet that are `changed`; none is farther than `most`. Those left so have not come to the surface,
    /// and those `aside` lie not straight below their voxel. Whether there were any.
    fn step_on(&mut self, most: f32, aside: &mut [bool; BLOCK_VOXELS]) -> bool {
        let (settled, beside) = (SETTLED * self.voxel(), ASIDE * self.voxel());
        (self.some_queries.origin, self.some_queries.len) = (self.points.origin, 0);
        for i in (0..BLOCK_VOXELS).filter(|&i| self.changed[i]) {
            self.some_queries.push(self.feet.offset(i));
        }
        if self.some_queries.len == 0 {
            return false;
        }
        self.evaluator.gradients(&self.some_queries, &mut self.at_feet);
        let mut lane = 0;
        for i in 0..BLOCK_VOXELS {
            if !self.changed[i] {
                continue;
            }
            let gradient = self.at_feet.gradient(lane);
            let at_foot = newton(self.at_feet.value[lane], gradient);
            lane += 1;
            let Some((step, length)) = at_foot else {
                self.changed[i] = false;
                continue;
            };
            let point = self.points.offset(i);
            let foot = point + (self.feet.offset(i) + step - point).clamp_length_max(most);
            let normal = gradient.normalize();
            self.distances[i] = (point - foot).dot(normal).abs();
            aside[i] = (point - foot).cross(normal).length() > beside;
            self.set_foot(i, foot);
            self.changed[i] = length > settled;
        }
        true
    }

    pub(super) fn set_foot(&mut self, i: usize, foot: Vec3) {
        (self.feet.x[i], self.feet.y[i], self.feet.z[i]) = foot.into();
    }

    /// Feet of those of a cube's voxels, marked in `changed`, that are within `near` voxels of the surface, in regions of
    /// few branches. (Farther feet may be found, and are of use where they are.)
    fn find_near_feet(&mut self, corner: [usize; 3], edge: usize, near: f64) {
        let reach = near * self.scope.lattice.voxel_size.get();
        let least = (corner[0] << 6) | (corner[1] << 3) | corner[2];
        let greatest = least + (edge - 1) * 0b1001001;
        let region = Aabb::new(self.points.position(least), self.points.position(greatest)).grown(reach);
        self.evaluator.enter(&region);
        let bounds = self.evaluator.bounds();
        if bounds.lo <= 0.0 && bounds.hi >= 0.0 {
            let branches = self.evaluator.branches();
            if branches <= FEW || edge == LEAST_CUBE {
                self.find_feet_of_cube(corner, edge, &Request { reach: reach as f32, region, ..self.request() });
                if branches > COMBINED && near > LEAST_NEAR {
                    self.find_near_feet(corner, edge, near - 1.0);
                }
            } else {
                let half = edge / 2;
                for octant in 0..8 {
                    let at = |axis: usize| corner[axis] + half * (octant >> (2 - axis) & 1);
                    self.find_near_feet([at(0), at(1), at(2)], half, near);
                }
            }
        }
        self.evaluator.leave();
    }

    fn find_feet_of_cube(&mut self, corner: [usize; 3], edge: usize, request: &Request) {
        let in_cube = |i: usize| {
            let at = [i >> 6, (i >> 3) & 7, i & 7];
            (0..3).all(|axis| (corner[axis]..corner[axis] + edge).contains(&at[axis]))
        };
        self.polish(request, in_cube, false);
    }

    fn take_nearer(&mut self, i: usize, foot: Vec3, distance: f32) {
        if distance < self.distances[i] {
            self.distances[i] = distance;
            self.set_foot(i, foot);
        }
    }

    /// Carries the feet of voxels near the surface to those farther away, shell by shell, so that each goes on from
    /// feet that are right.
    fn spread(&mut self) {
        let voxel = self.voxel();
        let mut reach = LEAST_NEAR as f32 * voxel;
        while reach < self.background {
            reach = (reach + SHELL * voxel).min(self.background);
            self.sweep(reach);
        }
    }

    /// Takes nearer feet of neighbours; false when there are none.
    fn sweep(&mut self, reach: f32) -> bool {
        self.changed.fill(false);
        let voxel = self.voxel();
        let Self { points, feet, distances, changed, .. } = self;
        let any = exchange::sweep(voxel, reach, points, feet, distances, changed);
        if any {
            self.polish_changed();
        }
        any
    }

    /// Nearer feet of neighbours, until there are none.
    pub(super) fn exchange(&mut self) {
        if self.is_by_itself() {
            return;
        }
        // Each round settles what the one before brought in; a foot hardly ever travels on after the second.
        for _ in 0..4 {
            if !self.sweep(self.background) {
                break;
            }
        }
    }

    /// Polishes the feet marked in `changed`, from where they are.
    pub(super) fn polish_changed(&mut self) {
        if self.evaluator.branches() > FEW {
            self.polish_around_feet();
            return;
        }
        self.polish(&self.request(), |_| true, true);
    }

    /// Polishes in one batch those voxels marked in `changed` that `picked` picks: from their feet, or from themselves.
    fn polish(&mut self, request: &Request, picked: impl Fn(usize) -> bool, from_feet: bool) {
        let Self { evaluator, polisher, some_queries, some_inside, some_feet, some_distances, .. } = self;
        (some_queries.origin, some_queries.len) = (self.points.origin, 0);
        (some_feet.origin, some_feet.len) = (self.points.origin, 0);
        for i in (0..BLOCK_VOXELS).filter(|&i| self.changed[i] && picked(i)) {
            some_inside[some_queries.len] = self.at_voxels.value[i] >= 0.0;
            some_queries.push(self.points.offset(i));
            some_feet.push(if from_feet { self.feet.offset(i) } else { self.points.offset(i) });
        }
        if some_queries.len == 0 {
            return;
        }
        polisher.closest(&mut **evaluator, request, some_queries, some_inside, some_feet, some_distances);
        let mut lane = 0;
        for i in 0..BLOCK_VOXELS {
            if self.changed[i] && picked(i) {
                self.take_nearer(i, self.some_feet.offset(lane), self.some_distances[lane]);
                lane += 1;
            }
        }
    }

    /// The same where the block holds more branches than can be combined.
    fn polish_around_feet(&mut self) {
        self.open.clear();
        for i in (0..BLOCK_VOXELS).filter(|&i| self.changed[i]) {
            let inside = self.at_voxels.value[i] >= 0.0;
            self.open.push(Approach::new(i, self.points.position(i), inside, self.feet.position(i)));
        }
        self.around.closest(&mut *self.evaluator, self.resolution, &mut self.open);
        for k in 0..self.open.len() {
            let open = self.open[k];
            let foot = (open.foot - self.points.origin).as_vec3();
            self.take_nearer(open.query, foot, (foot - self.points.offset(open.query)).length());
        }
    }
}

/// The step to where F vanishes to first order, and its length; `None` without a slope.
fn newton(value: f32, gradient: Vec3) -> Option<(Vec3, f32)> {
    let square = gradient.length_squared();
    (square > 0.0).then(|| (-gradient * (value / square), value.abs() / square.sqrt()))
}
