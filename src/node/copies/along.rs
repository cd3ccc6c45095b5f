//! Copies along a curve.

use glam::DVec3;

use crate::field::CopyPlace;
use crate::node::copied::{MOST_COPIES, cells_of, copies_of, facing};
use crate::node::curves::curve_points;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number, Text};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// Pieces that each span of a smooth curve is measured in. Fewer: copies are spaced unevenly where it turns.
const PIECES: usize = 64;

/// Copies along a curve.
pub const NODE: Spec = Spec {
    key: Key::new(
        "along",
        Kind::Places,
        Nothing,
        "Copies along the curve through these points, evenly by its length: `[[x, y, z], …]`, or a file of them.",
    ),
    parameters: &[
        Key::new("count", Kind::Whole, Number(10.0), "How many; the first and the last are at its ends.")
            .limit(Limit::Within(1.0, MOST_COPIES as f64)),
        Key::new(
            "curve",
            Kind::Choice(&["smooth", "straight"]),
            Text("smooth"),
            "Smooth through the points (Catmull and Rom), or straight from each to the next.",
        ),
        Key::new("closed", Kind::Choice(&["no", "yes"]), Text("no"), "Whether it ends where it begins."),
        Key::new(
            "aligned",
            Kind::Choice(&["yes", "no"]),
            Text("yes"),
            "Whether a copy's z axis points along the curve.",
        ),
    ],
    source: "Catmull and Rom, A class of local interpolating splines, 1974",
    example: "box = [0.3, 0.25, 0.12]\nalong = [[-1, -0.6, 0], [-0.4, 0.6, 0.2], [0.4, -0.6, 0.4], [1, 0.6, 0.6]]\ncount = 24",
    cells: Some(cells_of),
    bend: Some(|build| {
        let (points, span) = curve_points(build, "along")?;
        if points.len() < 2 {
            return Err(Problem::new(span, "a curve needs at least two points"));
        }
        let closed = build.arguments().choice("closed") == Some(&"yes");
        let smooth = build.arguments().choice("curve") != Some(&"straight");
        let aligned = build.arguments().choice("aligned") != Some(&"no");
        let count = build.arguments().whole("count").map_or(1, |count| (*count).max(1) as usize);
        let line = line(&points, closed, smooth);
        let mut lengths = vec![0.0];
        for pair in line.array_windows::<2>() {
            lengths.push(lengths[lengths.len() - 1] + pair[0].distance(pair[1]));
        }
        let whole = lengths[lengths.len() - 1];
        if whole <= 0.0 {
            return Err(Problem::new(span, "all points of the curve are the same").help("give it points that differ"));
        }
        let steps = if closed { count } else { (count - 1).max(1) };
        let place = |i: usize| {
            let at = whole * i as f64 / steps as f64;
            let piece = lengths.partition_point(|length| *length <= at).clamp(1, line.len() - 1);
            let (from, to) = (lengths[piece - 1], lengths[piece]);
            let share = if to > from { (at - from) / (to - from) } else { 0.0 };
            let turn = if aligned { facing(line[piece] - line[piece - 1], DVec3::Z) } else { glam::DMat3::IDENTITY };
            CopyPlace { turn, ..CopyPlace::moved(line[piece - 1].lerp(line[piece], share)) }
        };
        let places = (0..count).map(place).collect();
        copies_of(build, places)
    }),
    ..Spec::PLAIN
};

/// The curve as a line of short pieces.
fn line(points: &[DVec3], closed: bool, smooth: bool) -> Vec<DVec3> {
    let count = points.len();
    let spans = if closed { count } else { count - 1 };
    // Beyond the ends the curve goes straight on.
    let point = |i: i64| match (closed, i) {
        (true, _) => points[i.rem_euclid(count as i64) as usize],
        (false, -1) => 2.0 * points[0] - points[1],
        (false, i) if i as usize >= count => 2.0 * points[count - 1] - points[count - 2],
        (false, i) => points[i as usize],
    };
    let mut line = vec![points[0]];
    for span in 0..spans as i64 {
        let [a, b, c, d] = [span - 1, span, span + 1, span + 2].map(point);
        if !smooth {
            line.push(c);
            continue;
        }
        line.extend((1..=PIECES).map(|piece| {
            let t = piece as f64 / PIECES as f64;
            let (along, bend, turn) = (c - a, 2.0 * a - 5.0 * b + 4.0 * c - d, 3.0 * (b - c) + d - a);
            0.5 * (2.0 * b + t * (along + t * (bend + t * turn)))
        }));
    }
    line
}
