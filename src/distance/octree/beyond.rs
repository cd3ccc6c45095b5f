//! The field outside the root cell.
//!
//! At p outside, with q the nearest point of the root, n the outward directions in which p left it and s the
//! lengths along them, the field goes on as F's multilinear Taylor polynomial at q in the lengths A(s) instead of
//! s, less |s − A(s)|. A(s) = s/(1 + s/S) starts like s and never passes S. So near the root F is linear along the
//! outward normal, C¹ across it, and far away it falls with slope 1, as the distance to a bounded solid does; its
//! slope stays bounded, which that of the plain linear continuation does not (its tangential part grows with s).
//! What is solid is thereby taken to end at the root or a little beyond.

use glam::DVec3;

use super::DistanceObject;
use super::bounds::Bounded;
use super::evaluate::Place;
use super::patch::{self, Patch, PatchBounds};
use crate::field::{Aabb, Interval};

/// S above, as a share of the root's edge. Greater makes slopes steeper, smaller turns earlier to slope 1.
pub(in crate::distance) const SATURATION: f64 = 1.0 / 32.0;

/// What bounds need to know about the root's faces.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Border {
    /// S above, world units.
    saturation: f64,
    /// The greatest |∇F| on the faces.
    slope: f64,
    /// The greatest F on the faces.
    greatest: f64,
    /// The greatest derivative outward.
    outward: f64,
    /// The greatest mixed second derivative, and the third.
    second: f64,
    third: f64,
}

impl Border {
    /// By how much mixed terms may change F, lengths up to `a` along the axes that were left.
    fn mixed(&self, a: [f64; 3]) -> f64 {
        self.second * (a[0] * a[1] + a[0] * a[2] + a[1] * a[2]) + self.third * a[0] * a[1] * a[2]
    }

    /// By how much mixed terms may change a component of the gradient.
    fn mixed_slope(&self, a: [f64; 3]) -> f64 {
        // The other two axes' lengths count.
        let [x, y, z] = a;
        let (sum, product) = ((x + y).max(x + z).max(y + z), (x * y).max(x * z).max(y * z));
        self.second * sum + self.third * product
    }

    /// The greatest slope outside. A component is a mean of the spline's and one of slope 1, and the mixed terms.
    pub(super) fn slope(&self) -> f64 {
        let all = [self.saturation; 3];
        (self.slope * self.slope + 1.0).sqrt() + 3.0_f64.sqrt() * self.mixed_slope(all)
    }

    /// The greatest F outside.
    pub(super) fn greatest(&self) -> f64 {
        let all = [self.saturation; 3];
        self.greatest + 3.0 * self.saturation * self.outward.max(0.0) + self.mixed(all)
    }

    /// A(s) and A'(s).
    fn damped(&self, s: f64) -> (f64, f64) {
        let r = self.saturation / (self.saturation + s);
        (s * r, r * r)
    }
}

impl DistanceObject {
    /// F, ∂x, ∂y, ∂z at a position outside the root; `last` keeps the patch of the position before.
    pub(super) fn beyond(&self, position: DVec3, last: &mut Option<(Place, Patch)>) -> [f64; 4] {
        let root = self.root_box();
        let q = position.clamp(root.min, root.max);
        let jet = self.jet_beside(q, last);
        let gone = (position - q).to_array();
        let (mut a, mut rate, mut excess) = ([0.0; 3], [1.0; 3], [0.0; 3]);
        for axis in 0..3 {
            let s = gone[axis].abs();
            let (length, slope) = self.border.damped(s);
            a[axis] = length.copysign(gone[axis]);
            rate[axis] = slope;
            excess[axis] = s - length;
        }
        // The polynomial and its derivatives along the lengths.
        let [f, fz, fy, fyz, fx, fxz, fxy, fxyz] = jet;
        let [x, y, z] = a;
        let (by_x, by_y) = ((fx + z * fxz) + y * (fxy + z * fxyz), (fy + z * fyz) + x * (fxy + z * fxyz));
        let by_z = (fz + y * fyz) + x * (fxz + y * fxyz);
        let value = (f + z * fz) + y * (fy + z * fyz) + x * by_x;
        let length = DVec3::from(excess).length();
        let mut out = [value - length, by_x, by_y, by_z];
        for axis in 0..3 {
            out[axis + 1] *= rate[axis];
            if length > 0.0 {
                out[axis + 1] -= (excess[axis] / length * (1.0 - rate[axis])).copysign(gone[axis]);
            }
        }
        out
    }

    fn root_holds(&self, region: &Aabb) -> bool {
        let root = self.root_box();
        region.min.cmpge(root.min).all() && region.max.cmple(root.max).all()
    }

    /// The most that |∇F| may be in a box, as its [`Bounded`] tell, for less. `from` is a node that holds the part of the
    /// root nearest to it.
    pub(super) fn steepest_from(&self, region: &Aabb, from: Place) -> f64 {
        let inside = self.steepest_in_root(region, from);
        if self.root_holds(region) { inside } else { inside.max(self.border.slope()) }
    }

    /// Bounds over a box that may reach beyond the root; `from` is a node that holds the part of the root nearest to it.
    pub(super) fn bounds_from(&self, region: &Aabb, from: Place) -> Bounded {
        let mut bounded = self.bounds_in_root(region, from);
        if self.root_holds(region) {
            return bounded;
        }
        let root = self.root_box();
        let (mut a, mut excess) = ([0.0_f64; 3], [(0.0, 0.0); 3]);
        let mut rate = [(1.0, 1.0); 3];
        let mut sides = [[false; 2]; 3];
        for axis in 0..3 {
            // How far out along the axis the box reaches, and from where.
            let below = ((root.min - region.max)[axis].max(0.0), (root.min - region.min)[axis].max(0.0));
            let above = ((region.min - root.max)[axis].max(0.0), (region.max - root.max)[axis].max(0.0));
            sides[axis] = [below.1 > 0.0, above.1 > 0.0];
            let near = below.0.max(above.0);
            let far = below.1.max(above.1);
            a[axis] = self.border.damped(far).0;
            excess[axis] = (near - self.border.damped(near).0, far - a[axis]);
            rate[axis] = (self.border.damped(far).1, self.border.damped(near).1);
        }
        let mixed = self.border.mixed(a);
        let (mut lo, mut hi) = (bounded.value.lo - mixed, bounded.value.hi + mixed);
        for axis in 0..3 {
            let slope = bounded.gradient[axis];
            let [below, above] = sides[axis];
            let (mut least, mut most) = (0.0_f64, 0.0_f64);
            if below {
                (least, most) = (least.min(-slope.hi * a[axis]), most.max(-slope.lo * a[axis]));
            }
            if above {
                (least, most) = (least.min(slope.lo * a[axis]), most.max(slope.hi * a[axis]));
            }
            (lo, hi) = (lo + least, hi + most);
        }
        let length = |pick: fn((f64, f64)) -> f64| DVec3::from(excess.map(pick)).length();
        (lo, hi) = (lo - length(|e| e.1), hi - length(|e| e.0));
        let spread = self.border.mixed_slope(a);
        for (axis, [below, above]) in sides.into_iter().enumerate() {
            let slope = bounded.gradient[axis];
            let (least_rate, most_rate) = rate[axis];
            let times = |x: f64| [x * least_rate, x * most_rate];
            let ([a0, a1], [b0, b1]) = (times(slope.lo - spread), times(slope.hi + spread));
            let fall = 1.0 - least_rate;
            bounded.gradient[axis] = patch::padded(
                Interval::new(a0.min(a1) - if above { fall } else { 0.0 }, b0.max(b1) + if below { fall } else { 0.0 }),
                1.0,
            );
        }
        bounded.value = patch::padded(Interval::new(lo, hi), lo.abs().max(hi.abs()));
        bounded.steepest = bounded.steepest.max(self.border.slope());
        bounded
    }

    pub(super) fn measure_border(&self, places: &[Place], bounds: &[PatchBounds], slopes: &[f64]) -> Border {
        let mut border = Border {
            saturation: f64::from(self.root_size()) * self.step * SATURATION,
            greatest: f64::NEG_INFINITY,
            outward: f64::NEG_INFINITY,
            ..Border::default()
        };
        for ((place, bounds), slope) in places.iter().zip(bounds).zip(slopes) {
            let top = self.root_size() as i32;
            let sides = place.origin.map(|origin| (origin == 0, origin + place.size == top));
            if !sides.iter().any(|(low, high)| *low || *high) {
                continue;
            }
            for axis in 0..3 {
                if sides[axis].0 {
                    border.outward = border.outward.max(-bounds.gradient[axis].lo);
                }
                if sides[axis].1 {
                    border.outward = border.outward.max(bounds.gradient[axis].hi);
                }
            }
            border.greatest = border.greatest.max(bounds.value.hi);
            border.slope = border.slope.max(*slope);
            let patch = self.patch(*place);
            let (second, third) = patch::mixed(&patch.bernstein(), patch.edge);
            border.second = border.second.max(second);
            border.third = border.third.max(third);
        }
        border
    }
}
