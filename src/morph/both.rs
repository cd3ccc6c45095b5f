//! The distances of both objects of a morph, on one thread, and bounds of what is blended of them.

use glam::Vec3;

use crate::field::{Aabb, BATCH, Evaluator, Interval, Points};

/// How often parts of a region are halved to bound what they hold. More costs more than blocks opened in vain.
const HALVINGS: usize = 5;

/// Two evaluators that enter regions together.
pub(super) struct Both<'a> {
    pub first: Box<dyn Evaluator + 'a>,
    pub second: Box<dyn Evaluator + 'a>,
    /// D, world units.
    unit: f64,
    regions: Vec<Aabb>,
    values: Box<[[f32; BATCH]; 2]>,
}

impl<'a> Both<'a> {
    pub(super) fn new(first: Box<dyn Evaluator + 'a>, second: Box<dyn Evaluator + 'a>, unit: f64) -> Self {
        Self { first, second, unit, regions: Vec::new(), values: Box::new([[0.0; BATCH]; 2]) }
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

    /// Bounds over the region entered of a blend that has bounds over a box where both distances have, in units of D.
    /// Where those of the whole region leave its sign open, those of its parts are asked for.
    pub(super) fn bounds_of(&mut self, blend: impl Fn(&Aabb, [Interval; 2]) -> Interval) -> Interval {
        let Some(region) = self.region() else { return Interval::ALL };
        let bounds = blend(&region, self.bounds());
        match bounds.contains(0.0).then(|| self.bounds_by_parts(&region, blend)).flatten() {
            Some(other) => Interval::new(bounds.lo.max(other.lo), bounds.hi.min(other.hi)),
            None => bounds,
        }
    }

    /// Bounds from the distances in the middles of a region's parts: over a part neither changes by more than its slope
    /// allows on the way to a corner. Narrower than those of the ends of both distances over the region, which are met in
    /// different places of it. Parts that may hold a zero are halved; `None` where some still may.
    fn bounds_by_parts(&mut self, region: &Aabb, blend: impl Fn(&Aabb, [Interval; 2]) -> Interval) -> Option<Interval> {
        let steepest = [self.first.steepest()?, self.second.steepest()?];
        let mut bounds = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
        let mut part = region.size();
        let mut parts = Points::new(region.centre());
        parts.push(Vec3::ZERO);
        for _ in 0..HALVINGS {
            // The rounding of an f32 value is far below a thousandth of a part.
            let reach = 0.5005 * part.length() / self.unit;
            let [first, second] = &mut *self.values;
            self.first.values(&parts, first);
            self.second.values(&parts, second);
            let middle = Aabb::new(-part * 0.5, part * 0.5);
            part *= 0.5;
            let corners = Aabb::new(-part * 0.5, part * 0.5).corners();
            let mut halves = Points::new(parts.origin);
            for i in 0..parts.len {
                let around = |object: usize| {
                    let (value, most) = (f64::from(self.values[object][i]) / self.unit, steepest[object] * reach);
                    Interval::new(value - most, value + most)
                };
                let place = parts.position(i);
                let whole = Aabb::new(middle.min + place, middle.max + place);
                let found = blend(&whole, [around(0), around(1)]);
                if !found.contains(0.0) {
                    bounds = bounds.union(found);
                } else if halves.len + 8 <= BATCH {
                    corners.iter().for_each(|step| halves.push(parts.offset(i) + step.as_vec3()));
                } else {
                    return None;
                }
            }
            if bounds.contains(0.0) {
                return None;
            }
            if halves.len == 0 {
                return Some(bounds);
            }
            parts = halves;
        }
        None
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
