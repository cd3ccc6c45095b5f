//! Where the time of one frame with colour goes, on two threads: finding blocks, filling them with F, distances, colour,
//! encoding, writing into memory with the check that reads the file back, and the disk. Each stage is what a longer piece of
//! the work takes more than a shorter one, so that nothing in the program has a clock in it.
//!
//! `cargo bench -p hfvdb-bench --bench stages [-- SCENE... RESOLUTION...]`
//!
//! `STAGE scene resolution name clock processor`: medians in milliseconds, by the clock and of the processor.

use std::path::Path;
use std::sync::atomic::AtomicBool;

use glam::IVec3;
use hfvdb::disk;
use hfvdb::distance::descent::{Scope, descend};
use hfvdb::field::{BATCH, Evaluator, Field};
use hfvdb::vdb::{self, Compression};
use hfvdb_bench::clock::{Seconds, quartiles, timed};
use hfvdb_bench::fill::{fill_node, node};
use hfvdb_bench::scenes::{self, Sampling};
use hfvdb_bench::{bake, threads};
use rayon::prelude::*;

const ROUNDS: usize = 9;

/// Finds the blocks, and fills them with F, node by node.
fn fill(field: &dyn Field, scope: &Scope) -> Vec<Vec<[f32; BATCH]>> {
    let blocks = descend(field, scope, &AtomicBool::new(false)).expect("not cancelled").blocks;
    let of_node = |evaluator: &mut Box<dyn Evaluator + '_>, blocks: &[IVec3]| {
        let mut values = vec![[0.0; BATCH]; blocks.len()];
        fill_node(&mut **evaluator, scope, blocks, &mut values);
        values
    };
    blocks.par_chunk_by(|a, b| node(*a) == node(*b)).map_init(|| field.evaluator(), of_node).collect()
}

fn write(pieces: &[Vec<u8>], folder: &Path) {
    let path = folder.join("frame.vdb");
    let (staged, sound) = rayon::join(|| disk::stage(&path, pieces, true), || vdb::read_back(pieces, &path));
    sound.expect("it is sound");
    staged.and_then(disk::Staged::commit).expect("it is written");
}

fn bench(scene: &str, resolution: u32) {
    let frame = if scene == "cubism" { 24 } else { 1 };
    let prepared = scenes::prepare(scene, Sampling::OfSolid(resolution));
    let content = prepared.frame(frame).expect("a frame");
    let scope = Scope { lattice: prepared.lattice, half_width: prepared.half_width, region: content.region };
    let disk = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a folder");
    // A folder in memory, where syncing is nothing.
    let memory = tempfile::tempdir_in("/dev/shm").expect("a folder in memory");
    let mut stages = [const { Vec::new() }; 7];
    for _ in 0..ROUNDS {
        let (find, _) = timed(|| descend(&*content.field, &scope, &AtomicBool::new(false)));
        let (filled, _) = timed(|| fill(&*content.field, &scope));
        let (measured, _) = timed(|| scenes::band(&prepared, &content));
        let (computed, grids) = timed(|| bake::compute(&prepared, frame));
        let frame = bake::grids(&grids);
        let encode = || vdb::encode(&frame, Compression::Blosc).expect("a sound frame");
        let (encoded, bytes) = timed(encode);
        let (checked, ()) = timed(|| write(&bytes, memory.path()));
        let (written, ()) = timed(|| write(&bytes, disk.path()));
        let more = |long: Seconds, short: Seconds| [long[0] - short[0], long[1] - short[1]];
        let stage = [
            find,
            more(filled, find),
            more(measured, filled),
            more(computed, measured),
            encoded,
            checked,
            more(written, checked),
        ];
        stages.iter_mut().zip(stage).for_each(|(list, seconds)| list.push(seconds));
    }
    let names = ["find", "fill", "distances", "colour", "encode", "check", "disk"];
    for (name, list) in names.into_iter().zip(stages) {
        let [clock, processor] = [0, 1].map(|clock| 1e3 * quartiles(list.iter().map(|seconds| seconds[clock]))[0]);
        println!("STAGE {scene} {resolution} {name} {clock:.1} {processor:.1}");
    }
}

fn main() {
    let named: Vec<String> = hfvdb_bench::arguments().into_iter().filter(|word| word.parse::<u32>().is_err()).collect();
    let default = ["ball", "three", "two_hundred", "heart", "sphere-to-cube", "cubism"];
    let scenes = if named.is_empty() { default.map(String::from).to_vec() } else { named };
    for resolution in hfvdb_bench::resolutions(&[512]) {
        for scene in &scenes {
            threads(2).install(|| bench(scene, resolution));
        }
    }
}
