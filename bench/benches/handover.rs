//! How fast blocks become a file's bytes, against C++ alone and, without compression, which goes across the bridge,
//! against a call a voxel (rows 11 and 18 of the performance table); and how fast a ready frame reaches the disk, against
//! OpenVDB's own writer.
//!
//! `cargo bench -p hfvdb-bench --bench handover [-- RESOLUTION...]`

use glam::{DVec3, IVec3};
use hfvdb::grid::*;
use hfvdb::vdb::{Compression, Frame, Grid, WriteOptions, encode, set_threads, write};
use hfvdb_bench::clock::{Seconds, pairs, time_of_many, timed};
use hfvdb_bench::report::{Goal, Row};
use hfvdb_bench::rivals;
use rayon::ThreadPool;

const PAIRS: usize = 21;
/// Pairs of samples of many runs.
const SAMPLES: usize = 9;

/// The band of a sphere of radius 0.9 in the box [-1, 1]³.
fn sphere(resolution: i32) -> Band {
    let lattice = Lattice { voxel_size: VoxelSize::new(2.0 / f64::from(resolution)).expect("positive") };
    let (origins, distances, active, inside_tiles) = Default::default();
    let mut band = Band { lattice, half_width: 3.0, origins, distances, active, inside_tiles };
    let (background, reach) = (band.background(), 8.0 * lattice.voxel_size.get());
    let half = resolution / 2;
    let corners = (-half..half).step_by(8);
    for (x, y, z) in corners.clone().flat_map(|x| corners.clone().map(move |y| (x, y))).flat_map(|(x, y)| {
        let corners = corners.clone();
        corners.map(move |z| (x, y, z))
    }) {
        let origin = IVec3::new(x, y, z);
        let distance = |voxel: IVec3| 0.9 - lattice.centre(voxel).distance(DVec3::ZERO);
        if distance(origin + IVec3::splat(4)).abs() > 1.4 * reach {
            continue;
        }
        let (mut values, mut mask) = ([0.0; BLOCK_VOXELS], [0; 8]);
        for (place, value) in (0..).zip(&mut values) {
            let exact = distance(origin + IVec3::new(place >> 6, place >> 3 & 7, place & 7)) as f32;
            *value = exact.clamp(-background, background);
            mask[place as usize / 64] |= u64::from(exact.abs() < background) << (place % 64);
        }
        if mask != [0; 8] {
            band.origins.push(origin);
            band.distances.push(values);
            band.active.push(mask);
        }
    }
    let mut order: Vec<usize> = (0..band.origins.len()).collect();
    order.sort_by_key(|block| block_order(band.origins[*block]));
    Band {
        origins: order.iter().map(|block| band.origins[*block]).collect(),
        distances: order.iter().map(|block| band.distances[*block]).collect(),
        active: order.iter().map(|block| band.active[*block]).collect(),
        ..band
    }
}

/// Brings a band's blocks across the bridge into a file's bytes; the end of these is not counted.
fn across_the_bridge(band: &Band, threads: &ThreadPool, compression: Compression) -> Seconds {
    let frame = Frame { grids: vec![Grid::level_set("surface", band)], ..Default::default() };
    threads.install(|| timed(|| encode(&frame, compression).expect("a sound band")).0)
}

fn in_cpp(band: &Band, threads: usize) -> Seconds {
    let origins: Vec<i32> = band.origins.iter().flat_map(IVec3::to_array).collect();
    let (masks, values) = (band.active.as_flattened(), band.distances.as_flattened());
    let mut seconds = [0.0; 2];
    rivals::encode_in_cpp(&origins, masks, values, band.background(), threads, &mut seconds).expect("the rival runs");
    seconds
}

fn a_call_a_voxel(band: &Band) -> Seconds {
    let fill = || {
        let mut tree = rivals::new_voxel_tree(band.background()).expect("a tree");
        for ((origin, values), mask) in band.origins.iter().zip(&band.distances).zip(&band.active) {
            for (place, value) in (0..).zip(values) {
                if mask[place as usize / 64] >> (place % 64) & 1 == 1 {
                    let voxel = *origin + IVec3::new(place >> 6, place >> 3 & 7, place & 7);
                    tree.pin_mut().set(voxel.x, voxel.y, voxel.z, -value).expect("a voxel");
                }
            }
        }
        let bytes = tree.encode().expect("the rival runs");
        (tree, bytes)
    };
    timed(fill).0
}

/// Writes a surface with colour here and by OpenVDB's own writer: encoded, on the disk and synced.
fn compare_writing(band: &Band, row: Row) {
    let folder = tempfile::tempdir().expect("a folder");
    let colours = band.distances.iter().map(|values| values.map(|value| [0.5 + value, 0.5 - value, value.abs()]));
    let colour = Channel::of_blocks("Cd", &band.active, colours, [0.5; 3]);
    let frame =
        Frame { grids: vec![Grid::level_set("surface", band), Grid::colour(band, &colour)], ..Default::default() };
    let (ours, theirs) = (folder.path().join("ours.vdb"), folder.path().join("theirs.vdb"));
    let options = WriteOptions { overwrite: true, ..Default::default() };
    let write_ours = || timed(|| write(&ours, &frame, &options).expect("it is written")).0;
    write_ours();
    let ready = rivals::read_with_library(ours.to_str().expect("UTF-8")).expect("the rival reads it");
    let write_theirs = || timed(|| ready.write(theirs.to_str().expect("UTF-8")).expect("the rival runs")).0;
    let pairs = pairs(PAIRS, write_ours, write_theirs);
    row.compare("a ready frame with colour on the disk, against io::File", Goal::None, &pairs);
}

fn bench(resolution: u32) {
    let all = std::thread::available_parallelism().map_or(2, usize::from);
    let band = sphere(resolution as i32);
    println!("sphere at {resolution}: {} blocks, {} active voxels", band.origins.len(), band.active_voxels());
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of threads");
    let pools = [1, all].map(pool);
    let ours = |threads, compression| {
        set_threads(threads).expect("a thread limit");
        across_the_bridge(&band, &pools[usize::from(threads > 1)], compression)
    };
    let compressed = |threads| ours(threads, Compression::Blosc);
    let row = |number| Row(number, "sphere", resolution);
    for threads in [1, all] {
        let scene = format!("sphere,_threads:_{threads}");
        let pairs = pairs(PAIRS, || compressed(threads), || in_cpp(&band, threads));
        Row("11", &scene, resolution).compare(
            "across the bridge and encoded, against C++ alone",
            Goal::AtLeast(0.8),
            &pairs,
        );
    }
    let voxels = pairs(PAIRS, || ours(1, Compression::None), || a_call_a_voxel(&band));
    row("11-voxels").compare(
        "across the bridge and encoded, against a call a voxel, one thread, not compressed",
        Goal::AtLeast(3.0),
        &voxels,
    );
    let sample = |threads| time_of_many(|| compressed(threads));
    let threads = pairs(SAMPLES, || sample(all), || sample(1));
    row("18-handover").compare("all threads against one, handing over and encoding", Goal::AtLeast(1.6), &threads);
    compare_writing(&band, row("written"));
}

fn main() {
    hfvdb_bench::resolutions(&[256, 512]).into_iter().for_each(bench);
}
