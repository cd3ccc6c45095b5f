//! Frames with colour, computed and on the disk, against OpenVDB alone writing the same ready grids with `io::File`
//! and syncing the file as we do (rows 12 and 13 of the performance table): one frame, and a sequence with a frame
//! written while the next is computed. Making scenes ready is not timed. On two threads, under `target/tmp`.
//!
//! `cargo bench -p hfvdb-bench --bench frames [-- SCENE... RESOLUTION...]`

use hfvdb::vdb::{self, WriteOptions};
use hfvdb_bench::clock::{Seconds, pairs, timed};
use hfvdb_bench::report::{Goal, Row};
use hfvdb_bench::rivals;
use hfvdb_bench::scenes::{self, Sampling};
use hfvdb_bench::{bake, threads};

const PAIRS: usize = 5;
/// Frames of a sequence.
const FRAMES: i64 = 6;

/// What the scenes are called, how their resolution is meant, and where a sequence begins: for cubism in its middle,
/// where its frames are hardest.
fn scene(name: &str, resolution: u32) -> (Sampling, i64) {
    match name {
        "cubism" => (Sampling::OfSolid(resolution), 20),
        _ => (Sampling::OfBox(resolution), 1),
    }
}

fn bench(name: &str, resolution: u32) {
    let (sampling, first) = scene(name, resolution);
    let (making_ready, prepared) = timed(|| scenes::prepare(name, sampling));
    println!("{name} at {resolution}: made ready in {making_ready:.2?} s");
    let numbers: Vec<i64> = (first..first + FRAMES).collect();
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a folder");
    let ready = |frame: &i64| {
        let path = folder.path().join("ready.vdb");
        let computed = bake::compute(&prepared, *frame);
        let options = WriteOptions { overwrite: true, ..Default::default() };
        vdb::write(&path, &bake::grids(&computed), &options).expect("it is written");
        rivals::read_with_library(path.to_str().expect("UTF-8")).expect("the rival reads it")
    };
    let ready: Vec<_> = numbers.iter().map(ready).collect();
    let theirs = |frames: usize| -> Seconds {
        let write = |(place, grids): (usize, &cxx::UniquePtr<rivals::LibraryFrame>)| {
            let path = folder.path().join(format!("theirs.{place}.vdb"));
            grids.write(path.to_str().expect("UTF-8")).expect("the rival runs");
        };
        timed(|| ready[..frames].iter().enumerate().for_each(write)).0
    };
    let ours = |frames: usize| timed(|| bake::write(&prepared, &numbers[..frames], folder.path())).0;
    let one = pairs(PAIRS, || ours(1), || theirs(1));
    Row("12", name, resolution).compare("a frame, against io::File alone", Goal::AtMost(1.0), &one);
    let each = |seconds: Seconds| seconds.map(|seconds| seconds / FRAMES as f64);
    let all = pairs(PAIRS, || each(ours(numbers.len())), || each(theirs(numbers.len())));
    Row("13", name, resolution).compare("a frame of a sequence, against io::File alone", Goal::AtMost(0.75), &all);
}

fn main() {
    let named: Vec<String> = hfvdb_bench::arguments().into_iter().filter(|word| word.parse::<u32>().is_err()).collect();
    let scenes = if named.is_empty() { ["two_hundred", "three", "cubism"].map(String::from).to_vec() } else { named };
    for resolution in hfvdb_bench::resolutions(&[512]) {
        for scene in &scenes {
            threads(2).install(|| bench(scene, resolution));
        }
    }
}
