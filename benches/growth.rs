//! How the cost of a frame with colour grows with the resolution, for a still (the heart) and a frame of a morph (cube
//! to heart, the middle): seconds of the processor, memory, bytes of the file, and the exponents fitted to them.
//!
//! `cargo bench --bench growth [-- RESOLUTION...]`; 64 to 2048 without arguments, which takes 8 GB of memory.
//!
//! `GROWTH scene resolution voxels ready compute write memory bytes`: seconds of the processor, then bytes.
//! `EXPONENT scene compute write memory bytes`: of the resolution, by least squares of the logarithms from 256 on.

mod common;

use common::clock::timed;
use common::memory::resident;
use common::scenes::{self, Sampling};
use common::{bake, threads};
use hfvdb::vdb::WriteOptions;

/// From here on fixed costs no longer matter.
const LEAST_FITTED: u32 = 256;

/// The slope of log y over log x.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let logs = points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (x, y) = logs.clone().fold((0.0, 0.0), |sums, (x, y)| (sums.0 + x / count, sums.1 + y / count));
    let (products, squares) =
        logs.fold((0.0, 0.0), |sums, (a, b)| (sums.0 + (a - x) * (b - y), sums.1 + (a - x).powi(2)));
    products / squares
}

fn bench(scene: &str, frame: i64, resolutions: &[u32]) {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a folder");
    let mut fitted = [const { Vec::new() }; 4];
    for resolution in resolutions {
        let (ready, prepared) = timed(|| scenes::prepare(scene, Sampling::OfSolid(*resolution)));
        let (before, _) = resident();
        let (compute, computed) = timed(|| bake::compute(&prepared, frame));
        let voxels = computed.band.active_voxels();
        let options = WriteOptions { overwrite: true, ..Default::default() };
        let (write, written) = timed(|| {
            bake::hand_over(&computed).write(folder.path().join("frame.vdb"), &options).expect("it is written")
        });
        let (_, peak) = resident();
        let cost = [compute[1], write[1], (peak - before) as f64, written.bytes as f64];
        let [compute, write, memory, bytes] = cost;
        println!("GROWTH {scene} {resolution} {voxels} {:.3} {compute:.3} {write:.3} {memory} {bytes}", ready[1]);
        if *resolution >= LEAST_FITTED {
            fitted.iter_mut().zip(cost).for_each(|(list, cost)| list.push((f64::from(*resolution), cost)));
        }
    }
    let [compute, write, memory, bytes] = fitted.map(|list| exponent(&list));
    println!("EXPONENT {scene} {compute:.2} {write:.2} {memory:.2} {bytes:.2}");
}

fn main() {
    let resolutions = common::resolutions(&[64, 128, 256, 512, 1024, 2048]);
    for (scene, frame) in [("heart", 1), ("cube-to-heart", 12)] {
        threads(2).install(|| bench(scene, frame, &resolutions));
    }
}
