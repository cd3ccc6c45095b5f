//! Closest points on the spline's own zero set.

use glam::DVec3;

use super::patch::AXIS_BIT;
use super::{DistanceObject, LEAF};
use crate::distance::Foot;
use crate::field::Field;

/// A point this near to the zero set, in smallest cells, is on it.
const ON_SURFACE: f64 = 1e-6;

/// The closest point of the zero set, sought from the feet of the corners of the cell around the position, and from
/// where its own gradient leads: a corner's value and gradient hold where the patch between them is rounded by the
/// medial axis.
pub(super) fn foot(object: &DistanceObject, position: DVec3) -> Foot {
    let (value, gradient) = object.value_and_gradient(position);
    let root = object.root_box();
    let (place, _) = object.find(position.clamp(root.min, root.max));
    let patch = object.patch(place);
    let mut best: Option<(f64, DVec3)> = None;
    let mut consider = |start: DVec3| {
        let Some(point) = onto_surface(object, start) else { return };
        let distance = point.distance(position);
        if best.is_none_or(|(least, _)| distance < least) {
            best = Some((distance, point));
        }
    };
    consider(position - gradient * value);
    // Of the corners' feet, the nearest two: on both sides of a medial axis, most often.
    let mut corners: [(f64, DVec3); 8] = std::array::from_fn(|i| {
        let step = std::array::from_fn(|axis| f64::from(place.origin[axis]) + side(i, axis) * f64::from(place.size));
        let corner = object.origin + DVec3::from(step) * object.step;
        let jet = patch.corners[i];
        let foot = corner - DVec3::new(jet[4], jet[2], jet[1]) * jet[0];
        (foot.distance(position), foot)
    });
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    consider(corners[0].1);
    consider(corners[1].1);
    let Some((mut distance, mut point)) = best else {
        // No surface was met: as far as the field knows, there.
        let normal = gradient.normalize_or(DVec3::X);
        return finish(object, position, position - normal * value, value);
    };
    // Along the surface towards the position, as far as it comes nearer: a whole step is right where the surface is
    // flat, shorter ones where it bends away.
    let mut part = 1.0;
    for _ in 0..12 {
        let normal = object.value_and_gradient(point).1.normalize_or(DVec3::X);
        let away = position - point;
        let along = away - normal * away.dot(normal);
        if along.length() <= 1e-4 * distance.max(object.step) || part < 0.05 {
            break;
        }
        match onto_surface(object, point + along * part) {
            Some(next) if next.distance(position) < distance => (distance, point) = (next.distance(position), next),
            _ => part *= 0.4,
        }
    }
    finish(object, position, point, value)
}

fn side(corner: usize, axis: usize) -> f64 {
    if corner & AXIS_BIT[axis] != 0 { 1.0 } else { 0.0 }
}

/// Newton's steps along the gradient onto the zero set.
fn onto_surface(object: &DistanceObject, start: DVec3) -> Option<DVec3> {
    let mut point = start;
    for _ in 0..8 {
        let (rest, normal) = object.value_and_gradient(point);
        if rest.abs() <= ON_SURFACE * object.step {
            return Some(point);
        }
        // A rounded slope is short: no step is longer than twice the distance left.
        point -= normal * (rest / normal.length_squared().max(0.25));
    }
    (object.reference(point).abs() <= 1e-3 * object.step).then_some(point)
}

fn finish(object: &DistanceObject, position: DVec3, point: DVec3, value: f64) -> Foot {
    let away = position - point;
    let length = away.length();
    let sign = if value < 0.0 { -1.0 } else { 1.0 };
    let gradient = if length > ON_SURFACE * object.step {
        away * (sign / length)
    } else {
        object.value_and_gradient(point).1.normalize_or(DVec3::X)
    };
    // The part is that of the corner nearest to the foot.
    let root = object.root_box();
    let (place, t) = object.find(point.clamp(root.min, root.max));
    let corner: usize = (0..3).map(|axis| if t[axis] > 0.5 { AXIS_BIT[axis] } else { 0 }).sum();
    let leaf = &object.leaves[(object.nodes[place.node as usize] & !LEAF) as usize];
    Foot { point, distance: sign * length, gradient, part: object.parts[leaf[corner] as usize] }
}
