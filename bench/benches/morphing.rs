//! A morph of 24 frames, sphere to cube, against OpenVDB's `LevelSetMorphing` with its defaults (row 14 of the
//! performance table): a frame in memory; a frame of the sequence with colour on the disk; and the errors of the ends.
//! The rival's target is a band, so its surface moves by at most 3 voxels a unit of time and comes to rest there: it
//! gets as much time as a surface at that speed needs for the longest way, and for the last 3 voxels down to a
//! twentieth. It runs once, a step between two of our frames. On two threads, under `target/tmp`.
//!
//! `cargo bench -p hfvdb-bench --bench morphing [-- RESOLUTION...]`

use glam::{DMat3, DVec3};
use hfvdb::distance::accuracy::{compare, exact};
use hfvdb::grid::Band;
use hfvdb_bench::clock::{Seconds, timed};
use hfvdb_bench::report::{Goal, Row};
use hfvdb_bench::rivals;
use hfvdb_bench::scenes::{self, HALF_WIDTH, Sampling};
use hfvdb_bench::{bake, threads};

const SCENE: &str = "sphere-to-cube";
const FRAMES: i64 = 24;
/// As the scene has them.
const RADIUS: f64 = 0.9;
const EDGE: f64 = 1.6;

fn sphere(p: DVec3) -> f64 {
    exact::sphere(p, DVec3::ZERO, RADIUS)
}

fn cube(p: DVec3) -> f64 {
    exact::oriented_box(p, DMat3::IDENTITY, DVec3::splat(0.5 * EDGE))
}

/// The time that the rival's whole morph gets.
fn time_to_morph(voxel_size: f64) -> f64 {
    let longest_way = 0.5 * EDGE * 3f64.sqrt() - RADIUS;
    longest_way / (HALF_WIDTH * voxel_size) + (HALF_WIDTH / 0.05).ln()
}

fn end(row: Row, what: &str, band: &Band, exact: fn(DVec3) -> f64) {
    let found = compare(band, exact);
    row.value(&format!("{what}_mean"), found.mean, Goal::None);
    row.value(&format!("{what}_greatest"), found.max, Goal::None);
}

fn bench(resolution: u32) {
    let row = Row("14", SCENE, resolution);
    let (making_ready, prepared) = timed(|| scenes::prepare(SCENE, Sampling::OfBox(resolution)));
    println!("{SCENE} at {resolution}: made ready in {making_ready:.2?} s");
    let voxel_size = prepared.lattice.voxel_size.get();
    let ours = |frame| {
        let content = prepared.frame(frame).expect("a frame");
        timed(|| scenes::band(&prepared, &content))
    };
    ours(1);

    let mut grid = rivals::sphere_level_set(RADIUS, voxel_size).expect("a sphere");
    let target = rivals::cube_level_set(EDGE, voxel_size).expect("a cube");
    let band_of = |grid: &rivals::RivalGrid| rivals::band_of(grid, prepared.lattice, prepared.half_width);
    end(row, "OpenVDB's_first_frame:", &band_of(&grid), sphere);
    let each = time_to_morph(voxel_size) / (FRAMES - 1) as f64;
    let mut pairs: Vec<[Seconds; 2]> = Vec::new();
    let mut steps = 0;
    for frame in 2..=FRAMES {
        let to = (frame - 1) as f64 * each;
        let (theirs, substeps) =
            timed(|| rivals::morph(grid.pin_mut(), &target, to - each, to).expect("the rival runs"));
        steps += substeps;
        pairs.push([ours(frame).0, theirs]);
    }
    println!("LevelSetMorphing took {steps} steps");
    end(row, "OpenVDB's_last_frame:", &band_of(&grid), cube);
    end(row, "first_frame:", &ours(1).1.band, sphere);
    end(row, "last_frame:", &ours(FRAMES).1.band, cube);
    row.compare("a frame in memory, against LevelSetMorphing", Goal::AtLeast(20.0), &pairs);

    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a folder");
    let numbers: Vec<i64> = (1..=FRAMES).collect();
    let written = timed(|| bake::write(&prepared, &numbers, folder.path())).0.map(|time| time / FRAMES as f64);
    let against = |ours: Seconds| -> Vec<[Seconds; 2]> { pairs.iter().map(|[_, theirs]| [ours, *theirs]).collect() };
    let row = |number| Row(number, SCENE, resolution);
    row("14-written").compare("a frame with colour on the disk", Goal::AtLeast(10.0), &against(written));
    let whole = [0, 1].map(|clock| written[clock] + making_ready[clock] / FRAMES as f64);
    row("14-whole").compare("the same and its share of making ready", Goal::None, &against(whole));
}

fn main() {
    for resolution in hfvdb_bench::resolutions(&[256]) {
        threads(2).install(|| bench(resolution));
    }
}
