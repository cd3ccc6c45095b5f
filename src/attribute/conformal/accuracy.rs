//! How right interior distances and weights are: bodies whose shortest ways are known, judged at several resolutions. What
//! `hfvdb accuracy` prints second, and `docs/accuracy.md` holds.
//!
//! Exact ways: in polygons by Dijkstra's search among the corners that see each other, around a hole and a hollow by tangents
//! and arcs.

use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use glam::{DVec2, DVec3};
use serde::Serialize;

use super::{Body, Conformal, Ease, Error, Feature, Goal, Interior, Method, Zones};
use crate::attribute::{Attribute, Constant, Straight};
use crate::distance::accuracy::table::{listed, shown};
use crate::field::{Aabb, BATCH, Field, Joined, Points, Procedure, Slope};

/// The features' radius.
const RADIUS: f64 = 0.02;
/// Half the height of the bodies that stand on an outline.
pub(super) const HALF: f64 = 0.12;
/// Positions that are judged.
const POSITIONS: usize = 300;

/// The length of the shortest way from one position to another.
type Way = Box<dyn Fn(DVec3, DVec3) -> f64>;

/// A body whose shortest ways are known.
pub(super) struct Case {
    pub name: &'static str,
    field: Arc<dyn Field>,
    /// Where the two features are, far from each other.
    ends: [DVec3; 2],
    way: Way,
}

/// The distance of a solid that is as tall as twice `half` on an outline, by the outline's.
pub(super) fn extruded(flat: f64, z: f64, half: f64) -> f64 {
    let above = half - z.abs();
    if flat < 0.0 && above < 0.0 { -flat.hypot(above) } else { flat.min(above) }
}

/// A polygon's distance, positive inside.
pub(super) fn polygon(corners: &[DVec2], p: DVec2) -> f64 {
    let (mut nearest, mut inside) = (f64::INFINITY, false);
    for (i, a) in corners.iter().enumerate() {
        let b = corners[(i + 1) % corners.len()];
        let way = b - a;
        let share = ((p - a).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        nearest = nearest.min(p.distance(a + way * share));
        let crosses = (a.y > p.y) != (b.y > p.y) && p.x < (b.x - a.x) * (p.y - a.y) / (b.y - a.y) + a.x;
        inside ^= crosses;
    }
    if inside { nearest } else { -nearest }
}

/// The shortest way outside of a circle between two points: straight, or by tangents and an arc.
pub(super) fn way_around(radius: f64, from: DVec2, to: DVec2) -> f64 {
    let (a, b) = (from.length(), to.length());
    let angle = (from.dot(to) / (a * b)).clamp(-1.0, 1.0).acos();
    let arc = angle - (radius / a).acos() - (radius / b).acos();
    if arc <= 0.0 {
        return from.distance(to);
    }
    (a * a - radius * radius).sqrt() + (b * b - radius * radius).sqrt() + radius * arc
}

pub(super) fn corners(list: &[[f64; 2]]) -> Vec<DVec2> {
    list.iter().copied().map(DVec2::from).collect()
}

pub(super) fn ell() -> Vec<DVec2> {
    corners(&[[0.0, 0.0], [2.0, 0.0], [2.0, 0.6], [0.6, 0.6], [0.6, 2.0], [0.0, 2.0]])
}

/// Two arms, so far apart.
pub(super) fn you(gap: f64) -> Vec<DVec2> {
    let right = 0.4 + gap;
    corners(&[
        [0.0, 0.0],
        [right + 0.4, 0.0],
        [right + 0.4, 1.6],
        [right, 1.6],
        [right, 0.4],
        [0.4, 0.4],
        [0.4, 1.6],
        [0.0, 1.6],
    ])
}

/// A field by its exact distance.
pub(super) fn exact(aabb: Aabb, distance: impl Fn(DVec3) -> f64 + Send + Sync + 'static) -> Arc<dyn Field> {
    const STEP: f64 = 1e-6;
    let at = move |p: DVec3| {
        let along = |way: DVec3| (distance(p + way * STEP) - distance(p - way * STEP)) / (2.0 * STEP);
        (distance(p), DVec3::from(DVec3::AXES.map(along)))
    };
    let slope = Slope::Exact { outside: true, inside: true };
    Joined::shared(Procedure { at, bounds: Some(aabb), slope, is_flat: false })
}

pub(super) fn ball(centre: DVec3, radius: f64) -> Arc<dyn Field> {
    exact(Aabb::new(centre - radius, centre + radius), move |p| radius - p.distance(centre))
}

pub(super) fn prism(corners: Vec<DVec2>) -> Arc<dyn Field> {
    let (min, max) = corners.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), c| (a.min(*c), b.max(*c)));
    exact(Aabb::new(min.extend(-HALF), max.extend(HALF)), move |p| extruded(polygon(&corners, p.truncate()), p.z, HALF))
}

/// Positions inside of a body, spread evenly.
fn inside(field: &dyn Field, aabb: &Aabb) -> Vec<DVec3> {
    // Martin Roberts' sequence of low discrepancy (2018).
    const STEPS: DVec3 = DVec3::new(0.819_172_513_396_164_5, 0.671_043_606_703_789_2, 0.549_700_477_901_970_4);
    let all = (1u32..).map(|i| aabb.min + (STEPS * f64::from(i)).fract() * aabb.size());
    all.filter(|p| field.reference(*p) > 0.0).take(POSITIONS).collect()
}

/// Twice the area of the triangle of three points, positive anticlockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Whether the straight way between two places of a polygon stays in it.
fn is_clear(corners: &[DVec2], a: DVec2, b: DVec2) -> bool {
    const ROUNDING: f64 = 1e-12;
    // Between all places where its line meets edges it must be inside.
    let mut shares = vec![0.0, 1.0];
    for (i, &c) in corners.iter().enumerate() {
        let d = corners[(i + 1) % corners.len()];
        let across = (b - a).perp_dot(d - c);
        if across.abs() > ROUNDING {
            let share = (c - a).perp_dot(d - c) / across;
            let along = (c - a).perp_dot(b - a) / across;
            if (-ROUNDING..=1.0 + ROUNDING).contains(&along) && (0.0..=1.0).contains(&share) {
                shares.push(share);
            }
        } else if turn(a, b, c).abs() < ROUNDING {
            let length = (b - a).length_squared();
            shares.extend([c, d].map(|end| ((end - a).dot(b - a) / length).clamp(0.0, 1.0)));
        }
    }
    shares.sort_by(f64::total_cmp);
    shares
        .array_windows()
        .all(|[from, to]| to - from < 1e-9 || polygon(corners, a + (b - a) * (0.5 * (from + to))) > -1e-9)
}

/// The shortest way in a polygon, by Dijkstra's search among its corners.
pub(super) fn way_in(corners: &[DVec2], from: DVec2, to: DVec2) -> f64 {
    let mut stops = vec![from, to];
    stops.extend(corners);
    let mut lengths = vec![f64::INFINITY; stops.len()];
    let mut open: Vec<usize> = (0..stops.len()).collect();
    lengths[0] = 0.0;
    while let Some(place) = (0..open.len()).min_by(|a, b| lengths[open[*a]].total_cmp(&lengths[open[*b]])) {
        let next = open.swap_remove(place);
        if next == 1 {
            break;
        }
        for &other in &open {
            let over = lengths[next] + stops[next].distance(stops[other]);
            if over < lengths[other] && is_clear(corners, stops[next], stops[other]) {
                lengths[other] = over;
            }
        }
    }
    lengths[1]
}

/// A square spiral with ten bends, as wide as what is between its arms.
pub(super) fn spiral() -> Vec<DVec2> {
    const WIDTH: f64 = 0.1;
    // The middle of the stroke: each side two widths shorter than the last but one.
    let mut middle = vec![DVec2::ZERO];
    let mut way = DVec2::X;
    let sides = [20.0, 20.0, 20.0, 16.0, 16.0, 12.0, 12.0, 8.0, 8.0, 4.0, 4.0];
    for side in sides {
        middle.push(middle[middle.len() - 1] + way * (side * WIDTH));
        way = way.perp();
    }
    let last = middle.len() - 1;
    let along = |i: usize| (middle[i + 1] - middle[i]).normalize();
    let beside = |i: usize, side: f64| {
        let (before, after) = (along(i.max(1) - 1), along(i.min(last - 1)));
        let normal = if i == 0 || i == last { after.perp() } else { before.perp() + after.perp() };
        middle[i] + normal * (side * WIDTH / 2.0)
    };
    let right = (0..=last).map(|i| beside(i, -1.0));
    right.chain((0..=last).rev().map(|i| beside(i, 1.0))).collect()
}

pub(super) fn cases() -> Vec<Case> {
    let of_polygon = |name, outline: Vec<DVec2>, ends: [[f64; 3]; 2]| {
        let field = prism(outline.clone());
        let way: Way = Box::new(move |a, b| way_in(&outline, a.truncate(), b.truncate()).hypot(a.z - b.z));
        Case { name, field, ends: ends.map(DVec3::from), way }
    };
    let flat = Aabb::new(DVec3::new(-1.0, -1.0, -HALF), DVec3::new(1.0, 1.0, HALF));
    let ring = exact(flat, |p| {
        let far = p.truncate().length();
        extruded((1.0 - far).min(far - 0.5), p.z, HALF)
    });
    let hollow = |p: DVec3| (1.0 - p.length()).min(p.length() - 0.6);
    let shell = exact(Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)), hollow);
    vec![
        of_polygon("L", ell(), [[1.8, 0.4, 0.03], [0.3, 1.8, -0.02]]),
        of_polygon("U", you(0.5), [[0.2, 1.4, -0.05], [1.1, 1.4, 0.0]]),
        Case {
            name: "ring",
            field: ring,
            ends: [DVec3::new(-0.75, 0.1, 0.0), DVec3::new(0.7, 0.2, 0.03)],
            way: Box::new(|a, b| way_around(0.5, a.truncate(), b.truncate()).hypot(a.z - b.z)),
        },
        of_polygon("spiral", spiral(), [[0.1, 0.01, 0.0], [0.82, 0.8, 0.02]]),
        Case {
            name: "shell",
            field: shell,
            ends: [DVec3::new(-0.5, 0.3, 0.5), DVec3::new(0.6, -0.2, -0.45)],
            way: Box::new(|a, b| {
                // In the plane of both and the middle.
                let angle = (a.dot(b) / (a.length() * b.length())).clamp(-1.0, 1.0).acos();
                way_around(0.6, DVec2::X * a.length(), DVec2::from_angle(angle) * b.length())
            }),
        },
    ]
}

pub(super) fn sampled<const N: usize>(attribute: &dyn Attribute<N>, positions: &[DVec3]) -> Vec<[f32; N]> {
    let mut sampler = attribute.sampler();
    let mut all = Vec::new();
    for batch in positions.chunks(BATCH) {
        let (mut points, mut out) = (Points::new(batch[0]), [[f32::NAN; N]; BATCH]);
        batch.iter().for_each(|position| points.push((*position - batch[0]).as_vec3()));
        sampler.sample(&points, &mut out);
        all.extend_from_slice(&out[..points.len]);
    }
    all
}

/// Errors at so many cells.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Level {
    /// Cells along the body's longest side.
    pub cells: u32,
    /// Mean error of the distance, in cells.
    pub mean: f64,
    /// Greatest error, in cells.
    pub max: f64,
    /// The greatest error of a weight.
    pub weight: f64,
    /// What it took to spread from two features and to look both up.
    pub seconds: f64,
}

/// A method in a body.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// The body.
    pub body: &'static str,
    /// The method.
    pub method: &'static str,
    /// By cells.
    pub levels: Vec<Level>,
    /// The order of convergence of the mean error in units, by the two finest. `None` of a single one.
    pub order: Option<f64>,
}

/// The methods, with their names.
pub(super) fn methods() -> [(&'static str, Method); 2] {
    [("sight", Method::Sight), ("eikonal", Method::Eikonal { speed: None })]
}

/// What a method finds in a body of so many cells.
pub(super) fn judge(case: &Case, method: &Method, cells: u32, cancel: &AtomicBool) -> Result<Level, Error> {
    let start = Instant::now();
    let aabb = case.field.bounding_box().expect("it is bounded");
    let body = Arc::new(Body::new(Arc::clone(&case.field), Arc::clone(&case.field), aabb, cells, cancel)?);
    let [near, far] = case.ends;
    let [near, far] = [near, far].map(|at| Feature::new(&body, ball(at, RADIUS), method, cancel).map(Arc::new));
    let features = [near?, far?];
    let positions = inside(case.field.as_ref(), &aabb);
    let ways = case.ends.map(|end| {
        let way = |p: &DVec3| ((case.way)(end, *p) - RADIUS).max(0.0);
        positions.iter().map(way).collect::<Vec<f64>>()
    });
    let interior = Interior::new(Arc::clone(&body), vec![Goal::Feature(Arc::clone(&features[0]))]);
    let found = sampled(&interior, &positions);
    let error = |([found], way): (&[f32; 1], &f64)| (f64::from(*found) - way).abs() / body.edge();
    let off: Vec<f64> = found.iter().zip(&ways[0]).map(error).collect();
    let width = (case.way)(case.ends[0], case.ends[1]) - 2.0 * RADIUS;
    let value = |value: f32| Arc::new(Constant::new([value])) as Arc<dyn Attribute<1>>;
    let zones = Zones::new(&body, &[&features[0], &features[1]], 1.0, Ease::Linear);
    let members = features.into_iter().zip([value(0.0), value(1.0)]).collect();
    let conformal = Conformal::new(Arc::clone(&body), members, zones, vec![Straight]);
    let mut weight = 0.0f64;
    for (i, [found]) in sampled(&conformal, &positions).into_iter().enumerate() {
        let share = (0.5 + (ways[0][i] - ways[1][i]) / (2.0 * width)).clamp(0.0, 1.0);
        weight = weight.max((f64::from(found) - share).abs());
    }
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    let max = off.into_iter().fold(0.0, f64::max);
    Ok(Level { cells, mean, max, weight, seconds: start.elapsed().as_secs_f64() })
}

/// Judges all methods in all bodies.
///
/// # Errors
/// [`Error::Cancelled`]; [`Error::TooMany`] at more cells than a lattice may have, [`Error::Empty`] at hardly any.
pub fn table(cells: &[u32], cancel: &AtomicBool) -> Result<Vec<Row>, Error> {
    let mut rows = Vec::new();
    for case in cases() {
        for (name, method) in methods() {
            let levels: Vec<Level> =
                cells.iter().map(|cells| judge(&case, &method, *cells, cancel)).collect::<Result<_, _>>()?;
            let order = order(&levels);
            rows.push(Row { body: case.name, method: name, levels, order });
        }
    }
    Ok(rows)
}

fn order(levels: &[Level]) -> Option<f64> {
    let [.., coarse, fine] = levels else { return None };
    Some(1.0 + libm::log2(coarse.mean / fine.mean) / libm::log2(f64::from(fine.cells) / f64::from(coarse.cells)))
}

/// Rows as a table in Markdown, an error of each number of cells one after the other. `seconds`: whether times are among
/// them, which no two runs have alike.
pub fn markdown(rows: &[Row], seconds: bool) -> String {
    let cells: Vec<String> =
        rows.first().map_or(&[][..], |row| &row.levels).iter().map(|level| level.cells.to_string()).collect();
    let cells = cells.join(", ");
    let mut out = format!(
        "| body | method | mean error at {cells} | max error | order | max error of a weight |{}\n",
        if seconds { " seconds |" } else { "" }
    );
    out.push_str(if seconds { "|---|---|---|---|---|---|---|\n" } else { "|---|---|---|---|---|---|\n" });
    for row in rows {
        let each = |number: fn(&Level) -> f64| listed(row.levels.iter().map(number));
        let _ = write!(
            out,
            "| {} | `{}` | {} | {} | {} | {} |",
            row.body,
            row.method,
            each(|level| level.mean),
            each(|level| level.max),
            shown(row.order),
            each(|level| level.weight),
        );
        if seconds {
            let _ = write!(out, " {} |", each(|level| level.seconds));
        }
        out.push('\n');
    }
    out
}
