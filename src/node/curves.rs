//! Curves by control points. Of tubes each is a place and a radius: the radius is a fourth coordinate of the curve.
//!
//! A curve is cut into straight pieces, [`PIECES`] between two control points; against their length they are off by about
//! a thirty-thousandth of it at a quarter turn.

use glam::{DVec3, DVec4};

use super::spec::Build;
use crate::field::{CopyPlace, Graph, Joined, Node, Strut, Struts};
use crate::text::problem::Problem;
use crate::text::source::Span;

/// Straight pieces of a curve between two control points.
const PIECES: usize = 64;

/// The most control points of one Bézier curve.
const MOST_OF_BEZIER: usize = 32;

/// The most points of a curve that solids lie along, each with [`PIECES`] that a place is compared with.
const MOST_POINTS: usize = 1000;

/// The points that a key lists, or the file that it names, and where.
pub fn curve_points(build: &dyn Build, key: &str) -> Result<(Vec<DVec3>, Span), Problem> {
    let given = build.arguments().places(key).expect("it must be there");
    let is_plain = |place: &CopyPlace| *place == CopyPlace::moved(place.at);
    if let Some(at) = given.rows.iter().position(|place| !is_plain(place)) {
        let problem = format!("point {} of `{key}` has more than x, y and z", at + 1);
        return Err(
            Problem::new(given.span, problem).help("a curve goes through places, which have neither size nor turn")
        );
    }
    Ok((given.rows.iter().map(|place| place.at).collect(), given.span))
}

/// The line that solids lie along, by the points of a key, the choice of its curve, and whether it closes: then without its
/// beginning once more at the end.
pub fn line_along(build: &dyn Build, key: &str, curve: &str, closed: bool) -> Result<Vec<DVec3>, Problem> {
    let (mut points, span) = curve_points(build, key)?;
    let kind = match curve {
        "bezier" => "Bézier curve",
        "b_spline" => "B-spline",
        _ => "smooth curve",
    };
    let broken = |rule: String, help: &str| Err(Problem::new(span, format!("`{key}`: {rule}")).help(help));
    if points.len() > MOST_POINTS {
        let rule = format!("a curve takes at most {MOST_POINTS} points, and has {}", points.len());
        return broken(rule, "every second or tenth point: the curve is smooth between them");
    }
    let size = points.iter().fold(0.0_f64, |size, point| size.max(point.distance(points[0])));
    let is_same = |a: &DVec3, b: &DVec3| a.distance(*b) <= 1e-9 * size;
    if points.len() > 1 && size == 0.0 {
        return broken("all points of the curve are the same".into(), "give it points that differ");
    }
    if curve == "smooth" {
        // It would go out and back between two that stand on one another.
        points.dedup_by(|a, b| is_same(a, b));
        if closed && points.len() > 1 && is_same(&points[0], &points[points.len() - 1]) {
            points.pop();
        }
    }
    let (least, in_words) = match (curve, closed) {
        (_, true) => (3, "three"),
        ("b_spline", _) => (4, "four"),
        _ => (2, "two"),
    };
    if points.len() < least {
        let closed = if closed { "closed " } else { "" };
        let rule = format!("a {closed}{kind} needs at least {in_words} points, and has {}", points.len());
        return broken(
            rule,
            if closed.is_empty() { "more points; a smooth curve goes through two" } else { "more points" },
        );
    }
    if curve == "bezier" && points.len() > MOST_OF_BEZIER {
        let rule = format!("a Bézier curve takes at most {MOST_OF_BEZIER} control points, and has {}", points.len());
        return broken(rule, "a B-spline (`b_spline`) takes more");
    }
    let control: Vec<DVec4> = points.iter().map(|point| point.extend(1.0)).collect();
    let line = match curve {
        "bezier" => bezier(&control),
        "b_spline" => b_spline(&control, closed),
        _ => catmull_rom(&control, closed),
    };
    let mut line: Vec<DVec3> = line.into_iter().map(DVec4::truncate).collect();
    line.dedup_by(|a, b| is_same(a, b));
    if closed {
        line.pop();
    }
    if line.len() < 3 {
        return broken("the curve has no length".into(), "give it points that differ");
    }
    Ok(line)
}

/// The points of a key, with their radii.
pub fn tube_points(build: &mut dyn Build, key: &str) -> Result<Vec<DVec4>, Problem> {
    let radius = build.number("radius")?;
    let rows = &build.arguments().rows(key).expect("it must be there").all;
    let points: Vec<DVec4> =
        rows.iter().map(|row| DVec4::new(row[0], row[1], row[2], row.get(3).copied().unwrap_or(radius))).collect();
    if points.iter().any(|point| point.w <= 0.0) {
        return Err(build
            .wrong(key, "a radius must be greater than 0")
            .help("the fourth number of a point is its radius"));
    }
    Ok(points)
}

/// The tube along straight lines.
pub fn tube(graph: &mut Graph, points: &[DVec4]) -> Node {
    let place = |point: &DVec4| DVec3::new(point.x, point.y, point.z);
    let piece = |[a, b]: &[DVec4; 2]| Strut::new(place(a), place(b), [a.w, b.w]);
    graph.field(Joined::shared(Struts::new(points.array_windows().map(piece).collect())))
}

/// A curve at even steps from 0 to 1.
fn sampled(steps: usize, at: impl Fn(f64) -> DVec4) -> Vec<DVec4> {
    (0..=steps).map(|i| at(i as f64 / steps as f64)).collect()
}

/// By de Casteljau's construction.
pub fn bezier(control: &[DVec4]) -> Vec<DVec4> {
    sampled(PIECES * (control.len() - 1), |share| {
        let mut points = control.to_vec();
        while points.len() > 1 {
            points = points.array_windows().map(|[a, b]| a.lerp(*b, share)).collect();
        }
        points[0]
    })
}

/// The uniform cubic B-spline, which begins at its first control point and ends at its last, or closes.
pub fn b_spline(control: &[DVec4], closed: bool) -> Vec<DVec4> {
    let count = control.len();
    let spans = if closed { count } else { count - 3 };
    // Knots stand evenly; of an open curve the first four are one, and the last four.
    let knot = |i: usize| if closed { i as f64 } else { i.clamp(3, count) as f64 };
    let point = |i: usize| control[i % count];
    sampled(PIECES * spans, |share| {
        let at = (share * spans as f64).min(spans as f64);
        let span = (at.floor() as usize).min(spans - 1);
        let at = at + 3.0;
        // De Boor's construction.
        let mut points: [DVec4; 4] = std::array::from_fn(|i| point(span + i));
        for level in 1..=3 {
            for i in (level..=3).rev() {
                let (from, to) = (knot(span + i), knot(span + i + 4 - level));
                points[i] = points[i - 1].lerp(points[i], (at - from) / (to - from));
            }
        }
        points[3]
    })
}

/// Through all points: between two of them the cubic whose slopes at both are half of the way from one neighbour to the
/// other.
pub fn catmull_rom(points: &[DVec4], closed: bool) -> Vec<DVec4> {
    let count = points.len();
    let spans = if closed { count } else { count - 1 };
    let point = |i: isize| {
        if closed {
            return points[i.rem_euclid(count as isize) as usize];
        }
        // An end goes on as it came.
        match usize::try_from(i) {
            Err(_) => points[0] * 2.0 - points[1],
            Ok(i) if i >= count => points[count - 1] * 2.0 - points[count - 2],
            Ok(i) => points[i],
        }
    };
    sampled(PIECES * spans, |share| {
        let at = share * spans as f64;
        let span = (at.floor() as usize).min(spans - 1);
        let t = at - span as f64;
        let [a, b, c, d] = [-1, 0, 1, 2].map(|offset| point(span as isize + offset));
        let (square, cube) = (t * t, t * t * t);
        let sum = a * (2.0 * square - t - cube)
            + b * (3.0 * cube - 5.0 * square + 2.0)
            + c * (4.0 * square + t - 3.0 * cube)
            + d * (cube - square);
        let curve = sum / 2.0;
        // Radii stay between those of the two points.
        curve.with_w(curve.w.clamp(b.w.min(c.w), b.w.max(c.w)))
    })
}
