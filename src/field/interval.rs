//! Intervals of values and boxes of positions.

use glam::DVec3;

/// A closed interval of values, rounded outward where it was computed. NaN never appears: an operation that may
/// be undefined returns [`Interval::ALL`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// The least value.
    pub lo: f64,
    /// The greatest value.
    pub hi: f64,
}

impl Interval {
    /// Every value.
    pub const ALL: Self = Self { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

    /// The interval from `lo` to `hi`.
    pub const fn new(lo: f64, hi: f64) -> Self {
        Self { lo, hi }
    }

    /// The least interval around both.
    pub const fn union(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Whether a value lies in the interval.
    pub fn contains(self, value: f64) -> bool {
        self.lo <= value && value <= self.hi
    }
}

/// Intervals side by side, their lower and their upper ends apart: written end by end and read back at once as a pair, as
/// arithmetic on pairs is compiled, an interval would have to wait until both ends are in memory.
#[derive(Default)]
pub(super) struct Intervals {
    lo: Vec<f64>,
    hi: Vec<f64>,
}

impl Intervals {
    pub fn clear(&mut self) {
        self.lo.clear();
        self.hi.clear();
    }

    pub fn push(&mut self, interval: Interval) {
        self.lo.push(interval.lo);
        self.hi.push(interval.hi);
    }

    pub fn at(&self, index: u32) -> Interval {
        Interval { lo: self.lo[index as usize], hi: self.hi[index as usize] }
    }

    pub fn last(&self) -> Option<Interval> {
        Some(Interval { lo: *self.lo.last()?, hi: *self.hi.last()? })
    }
}

/// An axis-aligned box of world positions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The least corner.
    pub min: DVec3,
    /// The greatest corner.
    pub max: DVec3,
}

/// Where what has no end is taken to: finite, so that turning and moving it makes no infinity times 0.
const FAR: f64 = 1e15;

impl Aabb {
    /// The box between two corners, `min ≤ max` on each axis.
    pub const fn new(min: DVec3, max: DVec3) -> Self {
        Self { min, max }
    }

    /// The box grown by a margin on every side.
    pub fn grown(self, margin: f64) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// The box of a region of the xy plane, whatever z: as far as numbers of a scene reach.
    pub fn without_z(self) -> Self {
        Self { min: self.min.with_z(-FAR), max: self.max.with_z(FAR) }
    }

    /// The box of a region of the xy plane at one z, of no height.
    pub fn at_z(self, z: f64) -> Self {
        Self { min: self.min.with_z(z), max: self.max.with_z(z) }
    }

    /// Whether it is that of a region of the plane, whatever that was scaled by.
    pub fn is_of_plane(self) -> bool {
        /// So many times as high as it is wide, nothing in space is.
        const ENDLESS: f64 = 1e6;
        let size = self.size();
        size.z > ENDLESS * size.truncate().max_element()
    }

    /// The longest side, of those that end.
    pub fn longest_side(self) -> f64 {
        let size = self.size();
        DVec3::select(size.cmplt(DVec3::splat(FAR)), size, DVec3::ZERO).max_element()
    }

    /// The least box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box in both, or `None` where they do not meet.
    pub fn intersection(self, other: Self) -> Option<Self> {
        let both = Self { min: self.min.max(other.min), max: self.max.min(other.max) };
        both.min.cmple(both.max).all().then_some(both)
    }

    /// Whether a position lies in the box, its faces included.
    pub fn contains(self, position: DVec3) -> bool {
        position.cmpge(self.min).all() && position.cmple(self.max).all()
    }

    /// The middle.
    pub fn centre(self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// The lengths of the edges.
    pub fn size(self) -> DVec3 {
        self.max - self.min
    }

    /// The eight corners, x slowest.
    pub fn corners(self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |bit: usize, lo: f64, hi: f64| if i & bit == 0 { lo } else { hi };
            DVec3::new(
                pick(4, self.min.x, self.max.x),
                pick(2, self.min.y, self.max.y),
                pick(1, self.min.z, self.max.z),
            )
        })
    }
}
