//! The distances of a ball and a ring whose F is no distance, against OpenVDB's `levelSetRebuild` and `sdfToSdf` on a
//! dense grid of the same F, whose making is not timed (rows 9 and 10 of the performance table). The rivals take
//! seconds, so they run once; the errors of all three are printed. On two threads.
//!
//! `cargo bench -p hfvdb-bench --bench redistance [-- RESOLUTION...]`

use glam::{DVec3, IVec3};
use hfvdb::distance::accuracy::{compare, exact};
use hfvdb::field::{BATCH, Field, Points};
use hfvdb::grid::{Band, Lattice};
use hfvdb_bench::clock::timed;
use hfvdb_bench::report::{Goal, Row};
use hfvdb_bench::rivals::{self, RivalGrid};
use hfvdb_bench::scenes::{self, Sampling};
use hfvdb_bench::threads;
use rayon::prelude::*;

const ROUNDS: usize = 5;

/// A scene, its exact distance, and a rival's grid made from its dense one.
type Exact = fn(DVec3) -> f64;
type Rival = fn(&RivalGrid) -> Result<cxx::UniquePtr<RivalGrid>, cxx::Exception>;

/// −F at all voxels of the box [-1, 1]³.
fn dense(field: &dyn Field, lattice: Lattice, resolution: u32) -> cxx::UniquePtr<RivalGrid> {
    let half = resolution as i32 / 2;
    let corners = (-half..half).step_by(8);
    let origins: Vec<IVec3> = corners
        .clone()
        .flat_map(|x| corners.clone().map(move |y| (x, y)))
        .flat_map(|(x, y)| corners.clone().map(move |z| IVec3::new(x, y, z)))
        .collect();
    let mut values = vec![[0.0; BATCH]; origins.len()];
    origins.par_iter().zip(&mut values).for_each_init(
        || field.evaluator(),
        |evaluator, (origin, values)| {
            evaluator.values(&Points::of_block(*origin, &lattice), values);
            values.iter_mut().for_each(|value| *value = -*value);
        },
    );
    let origins: Vec<i32> = origins.iter().flat_map(IVec3::to_array).collect();
    rivals::dense_grid(&origins, values.as_flattened(), lattice.voxel_size.get()).expect("a grid")
}

/// Prints how far a band is from the truth.
fn errors(row: Row, who: &str, band: &Band, exact: Exact, goals: bool) {
    let found = compare(band, exact);
    println!("{who}: {} active voxels", found.voxels);
    let goal = |most| if goals { Goal::AtMost(most) } else { Goal::None };
    row.value(&format!("{who}:_mean"), found.mean, goal(0.005));
    row.value(&format!("{who}:_greatest"), found.max, goal(0.05));
    row.value(&format!("{who}:_wrong_signs"), found.wrong_signs as f64, goal(0.0));
}

fn bench(scene: &str, exact: Exact, resolution: u32) {
    let prepared = scenes::prepare(scene, Sampling::OfBox(resolution));
    let content = prepared.frame(1).expect("a frame");
    let ours = || timed(|| scenes::band(&prepared, &content));
    let (_, measured) = ours();
    errors(Row("9", scene, resolution), "hfvdb", &measured.band, exact, true);
    drop(measured);
    let dense = dense(&*content.field, prepared.lattice, resolution);
    let (rebuilding, sweeping) = if resolution < 512 { (40.0, 150.0) } else { (100.0, 700.0) };
    let rivals: [(&str, &str, Rival, f64); 2] =
        [("9", "levelSetRebuild", rivals::rebuild, rebuilding), ("10", "sdfToSdf", rivals::sweep, sweeping)];
    for (number, name, rival, goal) in rivals {
        let row = Row(number, scene, resolution);
        let (theirs, grid) = timed(|| rival(&dense).expect("the rival runs"));
        let pairs: Vec<_> = (0..ROUNDS).map(|_| [ours().0, theirs]).collect();
        row.compare(name, Goal::AtLeast(goal), &pairs);
        errors(row, name, &rivals::band_of(&grid, prepared.lattice, prepared.half_width), exact, false);
    }
}

fn main() {
    let scenes: [(&str, Exact); 2] =
        [("ball", |p| exact::sphere(p, DVec3::ZERO, 0.9)), ("ring", |p| exact::torus(p, 0.65, 0.25))];
    for resolution in hfvdb_bench::resolutions(&[256, 512]) {
        for (scene, exact) in scenes {
            threads(2).install(|| bench(scene, exact, resolution));
        }
    }
}
