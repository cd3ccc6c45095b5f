//! The bars of interior distances, and the page that tells of all methods' errors.

use std::sync::atomic::AtomicBool;

use glam::DVec2;

use super::accuracy::{self, Case, Level, cases, corners, ell, judge, methods, spiral, way_in};
use crate::distance::accuracy::table::{self, Row, markdown, short};
use crate::distance::accuracy::{all_cases, plane_cases};
use crate::distance::nearest::Watch;

const LEVELS: [u32; 3] = [32, 64, 128];

/// What is promised of a method at 128 cells.
fn hold(case: &Case, method: &str, found: &Level) {
    let what = format!("{} by {method}: {found:?}", case.name);
    eprintln!("{what}");
    // How often a way bends at corners at most.
    let bends = match case.name {
        "L" => 1.0,
        "U" => 2.0,
        "spiral" => 10.0,
        _ => 0.0,
    };
    let (mean, max, weight) = match method {
        "sight" => (0.4, 1.5 + 0.15 * bends, 0.02),
        // It goes around each bend as if from a point.
        _ => (2.0 + 0.3 * bends, 7.5 + 0.75 * bends, 0.03),
    };
    assert!(found.mean <= mean && found.max <= max && found.weight <= weight, "{what}");
}

/// What stands before the numbers of either table.
const HEAD: &str = include_str!("../../../docs/accuracy.in.md");
const MIDDLE: &str = include_str!("../../../docs/accuracy-inside.in.md");

fn level(case: &Case, method: &super::Method, cells: u32) -> Level {
    judge(case, method, cells, &AtomicBool::new(false)).expect("it has an inside")
}

#[test]
fn interior_distances_are_as_right_as_they_are_said_to_be() {
    // The others take longer: they are held to it when the page is written.
    for case in cases().into_iter().take(3) {
        for (name, method) in methods() {
            hold(&case, name, &level(&case, &method, LEVELS[2]));
        }
    }
}

fn rows(resolutions: &[u32]) -> Vec<Row> {
    let cancel = AtomicBool::new(false);
    let watch = Watch { cancel: &cancel, progress: &|_| {} };
    let mut rows = table::table(&all_cases(), resolutions, &watch).expect("all have a surface");
    rows.extend(table::table_in_plane(&plane_cases(), resolutions, &watch).expect("all have an outline"));
    rows
}

/// `UPDATE_DOCS=1 cargo test` writes the page anew, which takes some minutes; else only its coarsest numbers are held
/// against the program's.
#[test]
fn the_page_of_accuracy_is_up_to_date() {
    const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/accuracy.md");
    let is_writing = std::env::var_os("UPDATE_DOCS").is_some();
    if is_writing {
        let mut text = format!("{HEAD}\n{}\n{MIDDLE}\n", markdown(&rows(&LEVELS), false));
        let inside = accuracy::table(&LEVELS, &AtomicBool::new(false)).expect("all have an inside");
        for (i, row) in inside.iter().enumerate() {
            hold(&cases()[i / methods().len()], row.method, &row.levels[2]);
            // What is right within a fifth of a cell has no order left to show.
            let is_fine = row.levels.iter().all(|found| found.mean < 0.2);
            assert!(is_fine || row.order.is_some_and(|order| order > 0.65), "{row:?}");
        }
        text.push_str(&accuracy::markdown(&inside, false));
        std::fs::write(PATH, text).expect("docs can be written");
    }
    let page = std::fs::read_to_string(PATH).expect("the page is there");
    let stale = "docs/accuracy.md is out of date: UPDATE_DOCS=1 cargo test the_page";
    assert!(page.starts_with(HEAD) && page.contains(MIDDLE), "{stale}");
    for row in rows(&LEVELS[..1]) {
        // Between the corners of a quadtree the side is about that of F; `adf` has F's own.
        let is_own = row.method == "adf" || !row.shape.contains("in the plane");
        assert!(!is_own || row.levels[0].wrong_signs == 0, "{} by {}", row.shape, row.method);
        let shape = row.shape.replace('|', "\\|");
        let start = format!("| {shape} | `{}` | {}, ", row.method, short(row.levels[0].mean));
        assert!(page.contains(&start), "{stale}: no `{start}`");
    }
    for case in cases() {
        for (name, method) in methods() {
            let start = format!("| {} | `{name}` | {}, ", case.name, short(level(&case, &method, 32).mean));
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
