//! Turns: as rotation vectors, along directions, between axes, and the one that fits places best.
//!
//! A rotation vector points along the axis, counterclockwise seen from its tip, and is as long as the angle in radians;
//! angles past half a turn are kept, so that what turns on and on has one that goes on and on.

use std::f64::consts::TAU;

use glam::{DMat3, DQuat, DVec3};

use super::inertia::Axes;
use crate::field::{eigen_descending, rotation_about};

/// Directions that differ by less than this are the same, in radians: far more than rounding, far less than is seen.
const SAME: f64 = 1e-6;
/// How far places must reach beside the line that fits them best, against along it. Less: the turn about the line hangs
/// on rounding.
const IN_LINE: f64 = 1e-4;

/// The turn of a rotation vector.
pub(super) fn turn(vector: DVec3) -> DMat3 {
    let angle = vector.length();
    if angle == 0.0 {
        return DMat3::IDENTITY;
    }
    rotation_about(vector / angle, angle)
}

/// The rotation vector of a turn; of those that differ by whole turns, the nearest to another.
pub(super) fn vector_near(turn: &DMat3, near: DVec3) -> DVec3 {
    let quaternion = DQuat::from_mat3(turn).normalize();
    let (axis, sin) = (quaternion.xyz(), quaternion.xyz().length());
    let axis = if sin > 1e-12 { axis / sin } else { near.normalize_or_zero() };
    let angle = 2.0 * libm::atan2(sin, quaternion.w);
    axis * (angle + TAU * ((near.dot(axis) - angle) / TAU).round())
}

/// The least turn that takes one direction, of any length, to another; of opposite ones, about an axis as near to z as
/// may be.
pub(super) fn between(from: DVec3, to: DVec3) -> DMat3 {
    let (from, to) = (from.normalize_or(DVec3::Z), to.normalize_or(DVec3::Z));
    let (cos, axis) = (from.dot(to), from.cross(to));
    if is_half_turn(from, to) {
        let upright = if from.z.abs() < 0.9 { DVec3::Z } else { DVec3::X };
        let axis = (upright - from * from.dot(upright)).normalize();
        return half_turn(axis);
    }
    let cross = DMat3::from_cols(
        DVec3::new(0.0, axis.z, -axis.y),
        DVec3::new(-axis.z, 0.0, axis.x),
        DVec3::new(axis.y, -axis.x, 0.0),
    );
    DMat3::IDENTITY + cross + cross * cross * (1.0 / (1.0 + cos))
}

/// Whether two directions are opposite, so that no least turn between them is told apart from others.
pub(super) fn is_half_turn(from: DVec3, to: DVec3) -> bool {
    let (from, to) = (from.normalize_or(DVec3::Z), to.normalize_or(DVec3::Z));
    from.dot(to) < 0.0 && from.cross(to).length() < SAME
}

fn half_turn(axis: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(axis * axis.x, axis * axis.y, axis * axis.z);
    outer * 2.0 - DMat3::IDENTITY
}

/// The least turn that takes the first axes onto the second, the longest onto the longest; identity where either has
/// none. An axis has no sense of its own: of turns as long, the one counterclockwise about z, else y, else x.
pub(super) fn onto(from: &Axes, to: &Axes) -> DMat3 {
    let lines = |from: DVec3, to: DVec3| shortest([between(from, to), between(from, -to)]);
    match (from, to) {
        (Axes::None, _) | (_, Axes::None) => DMat3::IDENTITY,
        (Axes::All(from), Axes::All(to)) => {
            let signed = |[x, y]: [f64; 2]| {
                let (x, y) = (to.x_axis * x, to.y_axis * y);
                DMat3::from_cols(x, y, x.cross(y)) * right_handed(from).transpose()
            };
            shortest([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(signed))
        }
        (Axes::All(from), Axes::One { axis, place }) => lines(from.col(*place), *axis),
        (Axes::One { axis, place }, Axes::All(to)) => lines(*axis, to.col(*place)),
        (Axes::One { axis: one, place: first }, Axes::One { axis: two, place: second }) if first == second => {
            lines(*one, *two)
        }
        // A rod and a plate: the rod comes to lie along the plate, or the plate along the rod.
        (Axes::One { axis: one, .. }, Axes::One { axis: two, .. }) => {
            let across = *one - *two * one.dot(*two);
            let along = if across.length() < SAME { two.any_orthonormal_vector() } else { across };
            lines(*one, along)
        }
    }
}

fn right_handed(axes: &DMat3) -> DMat3 {
    DMat3::from_cols(axes.x_axis, axes.y_axis, axes.x_axis.cross(axes.y_axis))
}

/// The one of least angle.
fn shortest<const N: usize>(turns: [DMat3; N]) -> DMat3 {
    let vectors = turns.map(|turn| {
        let vector = vector_near(&turn, DVec3::ZERO);
        // Of both half turns about one axis, that of the axis that points up.
        if std::f64::consts::PI - vector.length() < SAME && rank(vector) < rank(-vector) { -vector } else { vector }
    });
    let better = |best: usize, other: usize| {
        let shorter = vectors[best].length() - vectors[other].length();
        let is_better = shorter > SAME || (shorter > -SAME && rank(vectors[other]) > rank(vectors[best]));
        if is_better { other } else { best }
    };
    turns[(1..N).fold(0, better)]
}

/// By what turns as long are told apart: z, y and x of the rotation vector, without rounding.
fn rank(vector: DVec3) -> [i64; 3] {
    [vector.z, vector.y, vector.x].map(|number| (number / SAME).round() as i64)
}

/// The turn that brings places, each about the middle of its own, nearest to others, by the sum of squares (Kabsch, A
/// solution for the best rotation to relate two sets of vectors, 1976). `None` where they lie on one line, and so any turn
/// about it is as good.
pub(super) fn fit(pairs: &[[DVec3; 2]]) -> Option<DMat3> {
    let mut matrix = DMat3::ZERO;
    for [from, to] in pairs {
        matrix += DMat3::from_cols(*from * to.x, *from * to.y, *from * to.z);
    }
    // The matrix is U·S·Vᵀ: U from its product with its transpose, V from U.
    let [(_, first), (_, second), _] = eigen_descending(matrix * matrix.transpose());
    let (along, beside) = (matrix.transpose() * first, matrix.transpose() * second);
    // Sums of squares of lengths.
    let on_a_line = beside.length() <= IN_LINE * IN_LINE * along.length();
    if on_a_line || along.length() == 0.0 {
        return None;
    }
    let along = along.normalize();
    let beside = (beside - along * along.dot(beside)).normalize();
    // No mirror image: the third axes follow from the others.
    let to = DMat3::from_cols(along, beside, along.cross(beside));
    Some(to * DMat3::from_cols(first, second, first.cross(second)).transpose())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    fn same(a: DMat3, b: DMat3) -> bool {
        a.abs_diff_eq(b, 1e-9)
    }

    #[test]
    fn vectors_and_turns() {
        assert!(same(turn(DVec3::Z * FRAC_PI_2), DMat3::from_cols(DVec3::Y, -DVec3::X, DVec3::Z)));
        for vector in [DVec3::new(0.3, -1.2, 0.7), DVec3::new(0.0, 3.0, 0.0), DVec3::ZERO] {
            assert!(vector_near(&turn(vector), DVec3::ZERO).distance(vector) < 1e-12);
            // What turns on and on keeps its whole turns.
            let on = vector + vector.normalize_or_zero() * (2.0 * TAU);
            assert!(vector_near(&turn(on), on * 0.98).distance(on) < 1e-9);
        }
    }

    #[test]
    fn the_least_turn_between_directions() {
        let (a, b) = (DVec3::new(1.0, 2.0, -0.5), DVec3::new(-0.3, 0.1, 2.0));
        let least = between(a, b);
        assert!((least * a.normalize()).distance(b.normalize()) < 1e-12);
        assert!((vector_near(&least, DVec3::ZERO).length() - a.angle_between(b)).abs() < 1e-9);
        assert!(is_half_turn(a, -a) && (between(a, -a) * a).distance(-a) < 1e-12);
    }

    #[test]
    fn axes_turn_the_shorter_way_and_have_no_sense() {
        let own = turn(DVec3::new(0.4, 0.2, -0.3));
        let flipped = DMat3::from_cols(-own.x_axis, own.y_axis, own.z_axis);
        assert!(same(onto(&Axes::All(DMat3::IDENTITY), &Axes::All(flipped)), own));
        // A quarter turn either way is as long: counterclockwise.
        let across = DMat3::from_cols(-DVec3::Y, DVec3::X, DVec3::Z);
        assert!(same(onto(&Axes::All(DMat3::IDENTITY), &Axes::All(across)), turn(DVec3::Z * FRAC_PI_2)));
        let rod = |axis| Axes::One { axis, place: 0 };
        let plate = |axis| Axes::One { axis, place: 2 };
        assert!(same(onto(&rod(DVec3::X), &rod(-DVec3::Y)), turn(DVec3::Z * FRAC_PI_2)));
        // A rod at 30 degrees to a plate's normal comes to lie in the plate.
        let tilted = turn(DVec3::Y * (PI / 6.0)) * DVec3::Z;
        let laid = onto(&rod(tilted), &plate(DVec3::Z));
        assert!(same(laid, turn(DVec3::Y * (PI / 3.0))));
        assert!(same(onto(&Axes::None, &plate(DVec3::X)), DMat3::IDENTITY));
    }

    #[test]
    fn places_are_fitted_and_lines_refused() {
        let wanted = turn(DVec3::new(1.0, -0.4, 0.8));
        let flat = [DVec3::new(1.0, 0.0, 0.0), DVec3::new(-0.5, 0.8, 0.0), DVec3::new(-0.5, -0.8, 0.0)];
        assert!(same(fit(&flat.map(|place| [place, wanted * place])).expect("a turn"), wanted));
        // Of a mirror image, the best that turns alone.
        let solid = [DVec3::X, -DVec3::X, DVec3::Y * 2.0, DVec3::Y * -2.0, DVec3::Z * 0.1, DVec3::Z * -0.1];
        let found = fit(&solid.map(|place| [place, place * DVec3::new(1.0, 1.0, -1.0)])).expect("a turn");
        assert!(same(found, DMat3::IDENTITY), "{found}");
        assert!(fit(&[-1.0, 0.0, 1.0].map(|along| [DVec3::X * along, DVec3::Y * along])).is_none());
    }
}
