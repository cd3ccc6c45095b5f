//! How the cost of a frame with colour grows with the resolution, for a still (the heart) and a frame of a morph (cube
//! to heart, the middle): seconds of the processor, memory, bytes of the file, and the exponents fitted to them.
//!
//! `cargo bench -p hfvdb-bench --bench growth [-- RESOLUTION...]`; 64 to 2048 without arguments, of which the heart takes 6 GB.
//!
//! `GROWTH scene resolution voxels ready compute write memory bytes`: seconds, then bytes; memory is the most that
//! a process takes that makes this one frame.
//! `EXPONENT scene compute write memory bytes`: of the resolution, by least squares of the logarithms from 256 on.

use std::process::{Command, Stdio};

use hfvdb::vdb::{self, WriteOptions};
use hfvdb_bench::clock::timed;
use hfvdb_bench::memory::resident;
use hfvdb_bench::scenes::{self, Sampling};
use hfvdb_bench::{bake, threads};

/// Scenes, and their frame.
const SCENES: [(&str, i64); 2] = [("heart", 1), ("cube-to-heart", 12)];
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

/// Makes one frame.
fn bench(scene: &str, frame: i64, resolution: u32) {
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a folder");
    let (ready, prepared) = timed(|| scenes::prepare(scene, Sampling::OfSolid(resolution)));
    let (compute, computed) = timed(|| bake::compute(&prepared, frame));
    let voxels = computed.band.active_voxels();
    let options = WriteOptions { overwrite: true, ..Default::default() };
    let (write, written) = timed(|| {
        vdb::write(folder.path().join("frame.vdb"), &bake::grids(&computed), &options).expect("it is written")
    });
    let ([_, ready], [_, compute], [_, write]) = (ready, compute, write);
    let (memory, bytes) = (resident().1, written.bytes);
    println!("GROWTH {scene} {resolution} {voxels} {ready:.3} {compute:.3} {write:.3} {memory} {bytes}");
}

/// Makes one frame in a process of its own: what it costs, as printed last.
fn in_a_process(scene: &str, resolution: u32) -> [f64; 4] {
    let program = std::env::current_exe().expect("this program");
    let mut command = Command::new(program);
    let output = command.arg(scene).arg(resolution.to_string()).stderr(Stdio::inherit()).output().expect("it starts");
    assert!(output.status.success(), "{scene} at {resolution} failed");
    let line = String::from_utf8(output.stdout).expect("a line");
    print!("{line}");
    let cost: Vec<f64> = line.split_whitespace().skip(5).map(|number| number.parse().expect("a number")).collect();
    cost.try_into().expect("four numbers")
}

fn main() {
    let resolutions = hfvdb_bench::resolutions(&[64, 128, 256, 512, 1024, 2048]);
    if let Some((scene, frame)) =
        SCENES.into_iter().find(|(scene, _)| hfvdb_bench::arguments().iter().any(|word| word == scene))
    {
        return threads(2).install(|| resolutions.iter().for_each(|resolution| bench(scene, frame, *resolution)));
    }
    for (scene, _) in SCENES {
        let costs: Vec<_> = resolutions.iter().map(|at| (*at, in_a_process(scene, *at))).collect();
        let fitted = costs.iter().filter(|(resolution, _)| *resolution >= LEAST_FITTED);
        let points =
            |cost: usize| -> Vec<_> { fitted.clone().map(|(at, costs)| (f64::from(*at), costs[cost])).collect() };
        let [compute, write, memory, bytes] = [0, 1, 2, 3].map(|cost| exponent(&points(cost)));
        println!("EXPONENT {scene} {compute:.2} {write:.2} {memory:.2} {bytes:.2}");
    }
}
