//! Cutting a triangle along segments into convex polygons that none of them crosses.

use glam::DVec3;

/// A corner of a polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Corner {
    pub position: DVec3,
    /// Which corner of the triangle it is, if it is one.
    pub original: Option<u8>,
}

/// With more segments than this in a polygon it is halved first: cutting by one segment after the other takes
/// quadratic time.
const FEW: usize = 8;

/// The parts of a triangle with the unit normal `normal`. Segments are in its plane, or nearly; where they leave less
/// than `tolerance` on one side, nothing is cut.
pub(super) fn parts(corners: [DVec3; 3], normal: DVec3, segments: Vec<[DVec3; 2]>, tolerance: f64) -> Vec<Vec<Corner>> {
    let triangle = (0..3).map(|i| Corner { position: corners[i], original: Some(i as u8) }).collect();
    let mut done = Vec::new();
    let mut open: Vec<(Vec<Corner>, Vec<[DVec3; 2]>, bool)> = vec![(triangle, segments, true)];
    while let Some((polygon, mut segments, may_halve)) = open.pop() {
        segments.retain(|&segment| crosses(&polygon, normal, segment, tolerance));
        if segments.is_empty() {
            done.push(polygon);
            continue;
        }
        let halving = (may_halve && segments.len() > FEW).then(|| halving(&segments));
        let by_halving = halving.and_then(|plane| Some((split(&polygon, plane, tolerance)?, true)));
        let by_segment = || {
            // Any order will do; one in the middle of a row leaves about as many on either side.
            let [from, to] = segments.swap_remove(segments.len() / 2);
            let across = normal.cross(to - from).normalize_or_zero();
            Some((split(&polygon, (across, from), tolerance)?, false))
        };
        match by_halving.or_else(by_segment) {
            Some(([one, other], halved)) => {
                // A halving that leaves all segments on both sides would be done for ever.
                let count = segments.len();
                let mine: Vec<_> = segments.iter().copied().filter(|&s| crosses(&one, normal, s, tolerance)).collect();
                segments.retain(|&segment| crosses(&other, normal, segment, tolerance));
                let fewer = !halved || mine.len().max(segments.len()) * 4 <= count * 3;
                open.push((one, mine, fewer));
                open.push((other, segments, fewer));
            }
            None => open.push((polygon, segments, may_halve)),
        }
    }
    done
}

/// A plane across the longest extent of the segments' middles, at their median.
fn halving(segments: &[[DVec3; 2]]) -> (DVec3, DVec3) {
    let mut middles: Vec<DVec3> = segments.iter().map(|[from, to]| (from + to) * 0.5).collect();
    let low = middles.iter().copied().fold(DVec3::INFINITY, DVec3::min);
    let high = middles.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
    let axis = (high - low).max_position();
    middles.sort_by(|a, b| a[axis].total_cmp(&b[axis]));
    (DVec3::AXES[axis], middles[middles.len() / 2])
}

/// Whether a segment runs through the inside of a convex polygon.
fn crosses(polygon: &[Corner], normal: DVec3, [from, to]: [DVec3; 2], tolerance: f64) -> bool {
    let (mut start, mut end) = (0.0_f64, 1.0_f64);
    for (i, corner) in polygon.iter().enumerate() {
        let next = polygon[(i + 1) % polygon.len()].position;
        let inward = normal.cross(next - corner.position).normalize_or_zero();
        let (a, b) = (inward.dot(from - corner.position) - tolerance, inward.dot(to - corner.position) - tolerance);
        if a <= 0.0 && b <= 0.0 {
            return false;
        }
        if a < 0.0 {
            start = start.max(a / (a - b));
        } else if b < 0.0 {
            end = end.min(a / (a - b));
        }
    }
    (end - start) * from.distance(to) > tolerance
}

/// The two sides of a convex polygon, if the plane leaves both more than the tolerance.
fn split(polygon: &[Corner], (normal, on): (DVec3, DVec3), tolerance: f64) -> Option<[Vec<Corner>; 2]> {
    let heights: Vec<f64> = polygon.iter().map(|corner| normal.dot(corner.position - on)).collect();
    if !heights.iter().any(|&h| h > tolerance) || !heights.iter().any(|&h| h < -tolerance) {
        return None;
    }
    // Nearer than this a corner is on the plane: cutting there would only make a sliver.
    let on_plane = 0.01 * tolerance;
    let mut sides = [Vec::with_capacity(polygon.len() + 1), Vec::with_capacity(polygon.len() + 1)];
    for (i, &corner) in polygon.iter().enumerate() {
        let j = (i + 1) % polygon.len();
        let (a, b) = (heights[i], heights[j]);
        if a >= -on_plane {
            sides[0].push(corner);
        }
        if a <= on_plane {
            sides[1].push(corner);
        }
        if a.abs() > on_plane && b.abs() > on_plane && (a > 0.0) != (b > 0.0) {
            let position = corner.position.lerp(polygon[j].position, a / (a - b));
            sides.iter_mut().for_each(|side| side.push(Corner { position, original: None }));
        }
    }
    Some(sides)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    fn area(polygon: &[Corner]) -> f64 {
        let first = polygon[0].position;
        let doubled = polygon.windows(2).map(|pair| (pair[0].position - first).cross(pair[1].position - first).z);
        doubled.sum::<f64>() * 0.5
    }

    /// A ring of many segments: the parts fill the triangle, and each lies on one side of the ring.
    #[test]
    fn a_ring_parts_inside_from_outside() {
        let corners = [DVec3::ZERO, DVec3::X * 10.0, DVec3::Y * 10.0];
        for count in [3, 40, 1000] {
            let at = |i: u32| {
                let (s, c) = libm::sincos(TAU * f64::from(i) / f64::from(count));
                DVec3::new(3.0 + 2.0 * c, 3.0 + 2.0 * s, 0.0)
            };
            let ring: Vec<_> = (0..count).map(|i| [at(i), at(i + 1)]).collect();
            let parts = parts(corners, DVec3::Z, ring, 1e-9);
            let areas: Vec<f64> = parts.iter().map(|part| area(part)).collect();
            assert!((areas.iter().sum::<f64>() - 50.0).abs() < 1e-6);
            let radians = TAU / f64::from(count);
            let inside = |part: &&Vec<Corner>| {
                let middle = part.iter().map(|corner| corner.position).sum::<DVec3>() / part.len() as f64;
                (0..count).all(|i| (at(i + 1) - at(i)).cross(middle - at(i)).z > 0.0)
            };
            let within: f64 = parts.iter().filter(inside).map(|part| area(part)).sum();
            let ring_area = f64::from(count) * 2.0 * libm::sin(radians);
            assert!((within - ring_area).abs() < 1e-6, "{within} for {ring_area}");
            assert!(parts.len() < 12 * count as usize, "{} parts", parts.len());
        }
    }
}
