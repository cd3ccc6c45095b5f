//! Where a triangle meets another one that is not its neighbour there: the segments that the other cuts it along.
//!
//! Everything is measured against one tolerance, in world units: surfaces nearer than that count as touching, and
//! triangles nearly in one plane as lying in one. An answer may be wrong by as much and no more.

use glam::DVec3;

/// A triangle, ready to be compared with others.
pub(super) struct Face {
    pub corners: [DVec3; 3],
    /// The welded vertices.
    pub welded: [u32; 3],
    /// Unit normal; zero where there is no area.
    pub normal: DVec3,
}

/// Normals whose cosine is beyond this count as parallel where the triangles touch.
pub(super) const PARALLEL: f64 = 0.9;

impl Face {
    /// How far a position is within each side, in the triangle's plane; negative beyond the side.
    fn within_sides(&self, position: DVec3) -> [f64; 3] {
        std::array::from_fn(|i| {
            let (from, to) = (self.corners[i], self.corners[(i + 1) % 3]);
            self.normal.cross(to - from).normalize_or_zero().dot(position - from)
        })
    }

    /// The piece of a segment in the triangle's plane that lies in the triangle or within the tolerance of it.
    fn clip(&self, [from, to]: [DVec3; 2], tolerance: f64) -> Option<[DVec3; 2]> {
        let (at_from, at_to) = (self.within_sides(from), self.within_sides(to));
        let (mut start, mut end) = (0.0_f64, 1.0_f64);
        for i in 0..3 {
            let (a, b) = (at_from[i] + tolerance, at_to[i] + tolerance);
            if a < 0.0 && b < 0.0 {
                return None;
            }
            if a < 0.0 {
                start = start.max(a / (a - b));
            } else if b < 0.0 {
                end = end.min(a / (a - b));
            }
        }
        (start <= end).then(|| [from.lerp(to, start), from.lerp(to, end)])
    }

    /// Whether a segment runs along one of the sides.
    fn has_along_side(&self, [from, to]: [DVec3; 2], tolerance: f64) -> bool {
        let (at_from, at_to) = (self.within_sides(from), self.within_sides(to));
        (0..3).any(|i| at_from[i].abs() <= 2.0 * tolerance && at_to[i].abs() <= 2.0 * tolerance)
    }

    /// Whether the triangle meets another one beyond the corners and sides that they share. Appends to `cuts` the
    /// segments through the triangle's inside.
    pub fn meets(&self, other: &Self, tolerance: f64, cuts: &mut Vec<[DVec3; 2]>) -> bool {
        let shared = other.welded.map(|v| self.welded.contains(&v));
        let height = |i: usize| {
            let height = self.normal.dot(other.corners[i] - self.corners[0]);
            if shared[i] || height.abs() <= tolerance { 0.0 } else { height }
        };
        let heights: [f64; 3] = std::array::from_fn(height);
        if heights.iter().all(|&h| h > 0.0) || heights.iter().all(|&h| h < 0.0) {
            return false;
        }
        let flat = heights == [0.0; 3];
        if flat && shared == [true; 3] {
            return true;
        }
        let mut met = false;
        let mut consider = |segment: [DVec3; 2], shares: [bool; 2]| {
            if shares == [true; 2] {
                return;
            }
            let Some([from, to]) = self.clip(segment, tolerance) else { return };
            // Triangles that share a corner meet there without touching otherwise.
            let reached = |shares: bool, corner: DVec3| {
                shares && from.distance(corner).max(to.distance(corner)) <= 8.0 * tolerance
            };
            if reached(shares[0], segment[0]) || reached(shares[1], segment[1]) {
                return;
            }
            met = true;
            if from.distance(to) > 4.0 * tolerance && !self.has_along_side([from, to], tolerance) {
                cuts.push([from, to]);
            }
        };
        if flat {
            for i in 0..3 {
                let j = (i + 1) % 3;
                consider([other.corners[i], other.corners[j]], [shared[i], shared[j]]);
            }
            // One that covers all of this has no side within it.
            return met || self.is_covered_by(other);
        }
        let mut ends = [(DVec3::ZERO, false); 2];
        let mut count = 0;
        for i in 0..3 {
            let j = (i + 1) % 3;
            if heights[i] == 0.0 {
                ends[count] = (other.corners[i], shared[i]);
                count += 1;
            } else if heights[i] * heights[j] < 0.0 {
                let along = heights[i] / (heights[i] - heights[j]);
                ends[count] = (other.corners[i].lerp(other.corners[j], along), false);
                count += 1;
            }
        }
        match count {
            1 => consider([ends[0].0; 2], [ends[0].1, false]),
            2 => consider([ends[0].0, ends[1].0], [ends[0].1, ends[1].1]),
            _ => {}
        }
        met
    }

    /// Whether another triangle in this one's plane holds the middle of this one.
    fn is_covered_by(&self, other: &Self) -> bool {
        let middle = (self.corners[0] + self.corners[1] + self.corners[2]) / 3.0;
        other.within_sides(middle).iter().all(|&within| within > 0.0)
    }
}
