//! The distances of both objects of a morph, on one thread, and bounds of what is blended of them.

use glam::{DVec3, Vec3};

use crate::field::{Aabb, BATCH, Evaluator, Hint, Interval, Points};

/// How often parts of a region are halved to bound what they hold. More costs more than blocks opened in vain.
const HALVINGS: usize = 5;

/// Two evaluators that enter regions together.
pub(super) struct Both<'a> {
    pub first: Box<dyn Evaluator + 'a>,
    pub second: Box<dyn Evaluator + 'a>,
    /// D, world units.
    unit: f64,
    regions: Vec<Aabb>,
    scratch: Box<Scratch>,
}

/// What bounds by parts are worked out in.
struct Scratch {
    middles: Points,
    halves: Points,
    values: [[f32; BATCH]; 2],
    found: [Interval; BATCH],
}

impl<'a> Both<'a> {
    pub(super) fn new(first: Box<dyn Evaluator + 'a>, second: Box<dyn Evaluator + 'a>, unit: f64) -> Self {
        let empty = || Points::new(DVec3::ZERO);
        let scratch =
            Scratch { middles: empty(), halves: empty(), values: [[0.0; BATCH]; 2], found: [Interval::ALL; BATCH] };
        Self { first, second, unit, regions: Vec::new(), scratch: Box::new(scratch) }
    }

    pub(super) fn enter(&mut self, region: &Aabb) {
        self.regions.push(*region);
        self.first.enter(region);
        self.second.enter(region);
    }

    pub(super) fn leave(&mut self) {
        self.regions.pop();
        self.first.leave();
        self.second.leave();
    }

    /// The region entered last.
    pub(super) fn region(&self) -> Option<Aabb> {
        self.regions.last().copied()
    }

    /// Bounds of both distances over the region entered, in units of D.
    pub(super) fn bounds(&mut self) -> [Interval; 2] {
        [&mut self.first, &mut self.second].map(|object| scaled(object.bounds(), 1.0 / self.unit))
    }

    /// Bounds over the region entered of a blend, in units of D: where the distances tell how steep they are by
    /// [`Self::bounds_by_parts`], else from the bounds of both.
    pub(super) fn bounds_of(
        &mut self,
        of_region: impl Fn([Interval; 2]) -> Interval,
        of_parts: impl FnMut(&Parts, &mut [Interval; BATCH]),
    ) -> Interval {
        let Some(region) = self.region() else { return Interval::ALL };
        let [first, second] = [&mut self.first, &mut self.second].map(|object| object.hints(Hint::Steepest).steepest);
        match (first, second) {
            (Some(first), Some(second)) => self.bounds_by_parts(&region, [first, second], of_parts),
            _ => of_region(self.bounds()),
        }
    }

    /// Bounds from the distances in the middles of a region's parts: over a part neither changes by more than its slope
    /// allows on the way to a corner. Narrower than those of the ends of both distances over the region, which are met in
    /// different places of it. Parts that may hold a zero are halved; where some still may, nothing is known.
    fn bounds_by_parts(
        &mut self,
        region: &Aabb,
        steepest: [f64; 2],
        mut blend: impl FnMut(&Parts, &mut [Interval; BATCH]),
    ) -> Interval {
        let mut bounds = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        let mut size = region.size();
        let Scratch { middles, halves, values: [first, second], found } = &mut *self.scratch;
        middles.origin = region.centre();
        halves.origin = middles.origin;
        middles.len = 0;
        middles.push(Vec3::ZERO);
        for _ in 0..HALVINGS {
            self.first.values(middles, first);
            self.second.values(middles, second);
            // The rounding of an f32 value is far below a thousandth of a part.
            let spread = steepest.map(|steepest| steepest * 0.5005 * size.length() / self.unit);
            blend(&Parts { middles, size, distances: [first, second], unit: self.unit, spread }, found);
            size *= 0.5;
            let corners = Aabb::new(-size * 0.5, size * 0.5).corners();
            halves.len = 0;
            for (i, found) in found[..middles.len].iter().enumerate() {
                if !found.contains(0.0) {
                    bounds = bounds.union(*found);
                } else if halves.len + 8 <= BATCH {
                    corners.iter().for_each(|step| halves.push(middles.offset(i) + step.as_vec3()));
                } else {
                    return Interval::ALL;
                }
            }
            if bounds.contains(0.0) {
                return Interval::ALL;
            }
            if halves.len == 0 {
                return bounds;
            }
            std::mem::swap(middles, halves);
        }
        Interval::ALL
    }
}

/// Parts of a region, of one size.
pub(super) struct Parts<'a> {
    pub middles: &'a Points,
    pub size: DVec3,
    /// Both distances in the middles, world units.
    pub distances: [&'a [f32; BATCH]; 2],
    /// D, world units.
    pub unit: f64,
    /// The most that each distance changes on the way from a middle, in units of D.
    pub spread: [f64; 2],
}

impl Parts<'_> {
    /// Bounds of a blend over each part, one after the other.
    pub(super) fn each(&self, out: &mut [Interval; BATCH], blend: impl Fn([Interval; 2]) -> Interval) {
        for (i, out) in out.iter_mut().enumerate().take(self.middles.len) {
            *out = blend(self.bounds(i));
        }
    }

    /// Bounds of both distances over a part, in units of D.
    fn bounds(&self, i: usize) -> [Interval; 2] {
        std::array::from_fn(|object| {
            let (value, most) = (f64::from(self.distances[object][i]) / self.unit, self.spread[object]);
            Interval::new(value - most, value + most)
        })
    }
}

/// Bounds from their ends; all where one is no number.
#[inline(always)]
pub(super) fn told(lo: f64, hi: f64) -> Interval {
    if lo.is_nan() || hi.is_nan() { Interval::ALL } else { Interval::new(lo, hi) }
}

/// The same of each part, by the least and the most of all.
#[inline(always)]
pub(super) fn told_each([least, most]: &[[f32; BATCH]; 2], parts: &Parts, out: &mut [Interval; BATCH]) {
    for (i, out) in out.iter_mut().enumerate().take(parts.middles.len) {
        *out = told(f64::from(least[i]), f64::from(most[i]));
    }
}

/// Bounds of values times a length.
pub(super) fn scaled(bounds: Interval, by: f64) -> Interval {
    Interval::new(bounds.lo * by, bounds.hi * by)
}

/// Whether a field has both signs at some points of a region: then it has a zero between them, if it is continuous. A few
/// values cost less than bounds of two objects' cells.
pub(super) fn has_both_signs(evaluator: &mut impl Evaluator, region: &Aabb) -> bool {
    let centre = region.centre();
    let mut points = Points::new(centre);
    let half = (region.size() * 0.5).as_vec3();
    points.push(Vec3::ZERO);
    for corner in region.corners() {
        points.push((corner - centre).as_vec3());
    }
    for axis in Vec3::AXES {
        points.push(half * axis);
        points.push(half * -axis);
    }
    let mut values = [0.0; BATCH];
    evaluator.values(&points, &mut values);
    let values = &values[..points.len];
    values.iter().any(|value| *value >= 0.0) && values.iter().any(|value| *value < 0.0)
}
