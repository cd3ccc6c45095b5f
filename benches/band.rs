//! The band against its own goals (rows 1, 7, 8 and 18 of the performance table): blocks opened, growth with the
//! resolution, peak memory, two threads against one. Ratios are taken pair by pair in one run.
//!
//! `cargo bench --bench band -- [sphere|three|two_hundred] [resolution]`; without arguments all scenes at 512.

use std::{
    sync::atomic::AtomicBool,
    time::{Duration, Instant},
};

use glam::DVec3;
use hfvdb::{
    distance::{
        accuracy::ball,
        band::{Measured, MeasuredBlock, Settings, measure},
    },
    field::{Aabb, Expression, Graph, SetSystem},
    grid::{Lattice, VoxelSize},
};

const PAIRS: usize = 5;
const LEAF_BYTES: usize = 512 * 4 + 64 + 12;

fn scene(name: &str) -> Expression {
    let mut graph = Graph::new();
    let node = match name {
        "sphere" => ball(&mut graph, DVec3::ZERO, 0.9),
        "three" => {
            let balls = [
                ball(&mut graph, DVec3::new(-0.4, 0.0, 0.0), 0.5),
                ball(&mut graph, DVec3::new(0.4, 0.1, 0.0), 0.45),
                ball(&mut graph, DVec3::new(0.0, 0.4, 0.2), 0.4),
            ];
            graph.union(SetSystem::R0, &balls)
        }
        "two_hundred" => {
            let mut random = Random(7);
            let mut balls = |graph: &mut Graph, count: usize| -> Vec<_> {
                (0..count)
                    .map(|_| {
                        let radius = 0.05 + 0.1 * random.next();
                        let centre = DVec3::from_array(std::array::from_fn(|_| (2.0 * random.next() - 1.0) * 0.8));
                        ball(graph, centre, radius)
                    })
                    .collect()
            };
            let (solid, holes) = (balls(&mut graph, 200), balls(&mut graph, 20));
            let solid = graph.union(SetSystem::R0, &solid);
            graph.difference(SetSystem::R0, solid, &holes)
        }
        other => panic!("no scene {other}"),
    };
    Expression::new(&graph, node)
}

/// A linear congruential generator (Knuth's constants): the same scene on every machine.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

fn run(field: &Expression, resolution: f64) -> (Measured<()>, Duration) {
    let cancel = AtomicBool::new(false);
    let settings = Settings {
        lattice: Lattice { voxel_size: VoxelSize::new(2.0 / resolution).unwrap() },
        half_width: 3.0,
        region: Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)),
        cancel: &cancel,
        progress: &|_| {},
    };
    let start = Instant::now();
    let measured = measure(field, &settings, || |_: &MeasuredBlock| ()).expect("the scenes have surfaces");
    (measured, start.elapsed())
}

/// The process's resident bytes now and at most since the last call.
fn resident() -> (usize, usize) {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let bytes = |key: &str| {
        let line = status.lines().find_map(|line| line.strip_prefix(key));
        line.and_then(|line| line.trim().trim_end_matches(" kB").parse::<usize>().ok()).unwrap_or(0) * 1024
    };
    let found = (bytes("VmRSS:"), bytes("VmHWM:"));
    // Resets the high-water mark.
    let _ = std::fs::write("/proc/self/clear_refs", "5");
    found
}

/// Median and range of a ratio over pairs run one after the other.
fn paired(label: &str, goal: &str, mut one: impl FnMut() -> Duration, mut other: impl FnMut() -> Duration) {
    let mut ratios: Vec<f64> = (0..PAIRS).map(|_| one().as_secs_f64() / other().as_secs_f64()).collect();
    ratios.sort_by(f64::total_cmp);
    println!("  {label}: {:.2} (from {:.2} to {:.2}; goal {goal})", ratios[PAIRS / 2], ratios[0], ratios[PAIRS - 1]);
}

fn bench(name: &str, resolution: f64) {
    let field = scene(name);
    println!("{name} at {resolution}");
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of threads");
    let (single, double) = (pool(1), pool(2));
    let (before, _) = resident();
    let (measured, time) = double.install(|| run(&field, resolution));
    let (_, peak) = resident();
    let blocks = measured.band.origins.len();
    let leaves = blocks * LEAF_BYTES;
    println!("  {time:?} on 2 threads, {blocks} leaves, {} voxels", measured.band.active_voxels());
    println!("  leaves opened ÷ needed: {:.3} (goal ≤ 1.25)", measured.report.opened_blocks as f64 / blocks as f64);
    println!(
        "  peak {:.1} MB for {:.1} MB of leaves: {:.2} of it + 30 MB (goal ≤ 1.6)",
        (peak - before) as f64 / 1e6,
        leaves as f64 / 1e6,
        ((peak - before) as f64 - 30e6).max(0.0) / leaves as f64
    );
    drop(measured);
    paired(
        "1 thread ÷ 2 threads",
        "≥ 1.85",
        || single.install(|| run(&field, resolution).1),
        || double.install(|| run(&field, resolution).1),
    );
    paired(
        "time at twice the resolution ÷ time",
        "≤ 4.3",
        || double.install(|| run(&field, 2.0 * resolution).1),
        || double.install(|| run(&field, resolution).1),
    );
    let (twice, _) = double.install(|| run(&field, 2.0 * resolution));
    println!("  leaves at twice the resolution ÷ leaves: {:.2}", twice.band.origins.len() as f64 / blocks as f64);
    println!(
        "  leaves opened ÷ needed there: {:.3} (goal ≤ 1.25)",
        twice.report.opened_blocks as f64 / twice.report.band_blocks as f64
    );
}

fn main() {
    // Cargo passes flags of its own (`--bench`).
    let arguments: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let resolution = arguments.get(1).and_then(|text| text.parse().ok()).unwrap_or(512.0);
    match arguments.first() {
        Some(name) => bench(name, resolution),
        None => ["sphere", "three", "two_hundred"].into_iter().for_each(|name| bench(name, resolution)),
    }
}
