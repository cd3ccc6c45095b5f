//! Points that stand together.

use glam::DVec3;

/// Points in voxels, each with its place in a batch.
pub(super) type Group = [(DVec3, usize)];

/// The middle of the box around points, and how far from it the farthest is.
pub(super) fn ball(points: &Group) -> (DVec3, f64) {
    let start = (points[0].0, points[0].0);
    let (low, high) = points.iter().fold(start, |(low, high), (at, _)| (low.min(*at), high.max(*at)));
    let middle = (low + high) / 2.0;
    let farthest = points.iter().map(|(at, _)| at.distance_squared(middle)).fold(0.0, f64::max);
    (middle, farthest.sqrt())
}

/// Puts at least two points in another order, so that two halves stand apart along the box's longest edge.
pub(super) fn halves(points: &mut Group) -> (&mut Group, &mut Group) {
    let start = (points[0].0, points[0].0);
    let (low, high) = points.iter().fold(start, |(low, high), (at, _)| (low.min(*at), high.max(*at)));
    let axis = (high - low).max_position();
    let middle = points.len() / 2;
    points.select_nth_unstable_by(middle, |a, b| a.0[axis].total_cmp(&b.0[axis]).then(a.1.cmp(&b.1)));
    points.split_at_mut(middle)
}
