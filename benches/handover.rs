//! How fast blocks reach OpenVDB's tree across the bridge, against C++ alone and against a call a voxel.
//!
//!     cargo bench --features rivals --bench handover [-- ROUNDS]
//!
//! Rivals alternate in one process, so that both meet the same machine; what counts is the ratio of a pair, its median
//! and its spread over the rounds.

use std::time::Instant;

use glam::{DVec3, IVec3};
use hfvdb::grid::*;
use hfvdb::vdb::{Frame, Grid, prepare, rivals, set_threads};

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

/// Seconds to bring a band's blocks into a tree across the bridge; the tree's end is not counted.
fn across_the_bridge(band: &Band, threads: usize) -> f64 {
    set_threads(threads).expect("a thread limit");
    let frame = Frame { grids: vec![Grid::level_set("surface", band)], ..Default::default() };
    let start = Instant::now();
    let prepared = prepare(&frame).expect("a sound band");
    let seconds = start.elapsed().as_secs_f64();
    drop(prepared);
    seconds
}

fn in_cpp(band: &Band, threads: usize) -> f64 {
    let origins: Vec<i32> = band.origins.iter().flat_map(IVec3::to_array).collect();
    let (masks, values) = (band.active.as_flattened(), band.distances.as_flattened());
    let mut seconds = 0.0;
    let voxels = rivals::link_in_cpp(&origins, masks, values, band.background(), threads, &mut seconds);
    assert_eq!(voxels.expect("the rival runs"), band.active_voxels());
    seconds
}

fn a_call_a_voxel(band: &Band) -> f64 {
    let start = Instant::now();
    let mut tree = rivals::new_voxel_tree(band.background()).expect("a tree");
    for ((origin, values), mask) in band.origins.iter().zip(&band.distances).zip(&band.active) {
        for (place, value) in (0..).zip(values) {
            if mask[place as usize / 64] >> (place % 64) & 1 == 1 {
                let voxel = *origin + IVec3::new(place >> 6, place >> 3 & 7, place & 7);
                tree.pin_mut().set(voxel.x, voxel.y, voxel.z, -value).expect("a voxel");
            }
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    assert_eq!(tree.active_voxels(), band.active_voxels());
    seconds
}

/// Runs two rivals in turns and prints how many times faster the first is: the median, and the middle half.
fn compare(title: &str, goal: f64, rounds: usize, ours: impl Fn() -> f64, theirs: impl Fn() -> f64) {
    (ours(), theirs()); // warm memory and caches
    let mut ratios = Vec::new();
    let (mut our_seconds, mut their_seconds) = (Vec::new(), Vec::new());
    for round in 0..rounds {
        let (a, b) = if round % 2 == 0 {
            let a = ours();
            (a, theirs())
        } else {
            let b = theirs();
            (ours(), b)
        };
        ratios.push(b / a);
        our_seconds.push(a);
        their_seconds.push(b);
    }
    for list in [&mut ratios, &mut our_seconds, &mut their_seconds] {
        list.sort_by(f64::total_cmp);
    }
    println!(
        "{title}: {:.2} times as fast ({:.2} to {:.2} in the middle half), goal {goal}; {:.1} ms against {:.1} ms",
        ratios[rounds / 2],
        ratios[rounds / 4],
        ratios[rounds * 3 / 4],
        1e3 * our_seconds[rounds / 2],
        1e3 * their_seconds[rounds / 2],
    );
}

fn main() {
    let rounds = std::env::args().filter_map(|argument| argument.parse().ok()).next().unwrap_or(21);
    let threads = std::thread::available_parallelism().map_or(2, usize::from);
    for resolution in [256, 512] {
        let band = sphere(resolution);
        println!("sphere at {resolution}: {} blocks, {} active voxels", band.origins.len(), band.active_voxels());
        for threads in [1, threads] {
            let title = format!("  across the bridge against C++ alone, {threads} threads");
            compare(&title, 0.8, rounds, || across_the_bridge(&band, threads), || in_cpp(&band, threads));
        }
        let title = format!("  {threads} threads against 1");
        compare(&title, 1.6, rounds, || across_the_bridge(&band, threads), || across_the_bridge(&band, 1));
        let title = format!("  blocks against a call a voxel, {threads} threads and 1");
        compare(&title, 3.0, rounds, || across_the_bridge(&band, threads), || a_call_a_voxel(&band));
        compare(
            "  blocks against a call a voxel, 1 thread each",
            3.0,
            rounds,
            || across_the_bridge(&band, 1),
            || a_call_a_voxel(&band),
        );
    }
}
