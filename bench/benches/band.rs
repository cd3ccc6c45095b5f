//! The band against its own goals (rows 1, 7, 8 and 18 of the performance table): blocks opened, growth with the
//! resolution, peak memory, two threads against one. Ratios are taken pair by pair in one run.
//!
//! `cargo bench -p hfvdb-bench --bench band [-- SCENE... RESOLUTION...]`; without arguments ball, three and two_hundred at 512.

use std::{cell::RefCell, hint::black_box, process::Command};

use hfvdb::distance::band::Measured;
use hfvdb::shot::{FrameContent, Prepared};
use hfvdb_bench::clock::{Seconds, pairs, time_of_many, timed};
use hfvdb_bench::memory::resident;
use hfvdb_bench::report::{Goal, Row};
use hfvdb_bench::scenes::{self, Sampling};
use rayon::{ThreadPool, prelude::*};

const PAIRS: usize = 5;
/// Pairs of the machine's own measures run between those of a job, so that both meet the same machine: rounds, and pairs
/// of either in one.
const TURNS: [usize; 2] = [5, 2];
const LEAF_BYTES: usize = 512 * 4 + 64 + 12;

/// A scene made ready at a resolution.
struct Job(Prepared, FrameContent);

impl Job {
    fn new(scene: &str, resolution: u32) -> Self {
        let prepared = scenes::prepare(scene, Sampling::OfBox(resolution));
        let content = prepared.frame(1).expect("a frame");
        Self(prepared, content)
    }

    fn run(&self) -> Measured<()> {
        scenes::band(&self.0, &self.1)
    }

    fn time(&self) -> Seconds {
        timed(|| self.run()).0
    }
}

/// Arithmetic in registers, in pieces that any thread takes: two threads are to one what the machine gives at that
/// moment. Two processors of a virtual machine may share a core, or one be lent out.
fn arithmetic() -> Seconds {
    let piece = |seed: u32| {
        let mut lanes: [f32; 64] = std::array::from_fn(|lane| (seed + lane as u32) as f32 * 1e-4);
        for _ in 0..1 << 12 {
            lanes = lanes.map(|value| value * 0.999 + 1e-3);
        }
        lanes.iter().sum::<f32>()
    };
    timed(|| black_box((0..1024_u32).into_par_iter().with_max_len(1).map(piece).sum::<f32>())).0
}

/// The bytes that a thread goes over again and again: more than a core's own cache holds.
const STREAM: usize = 8 << 20;

/// Reading and writing memory beyond a core's own cache, which cores share, also with other machines on the same host.
fn streaming() -> Seconds {
    thread_local!(static BUFFER: RefCell<Vec<f32>> = RefCell::new(vec![1.0; STREAM / 4]));
    let piece = |_| {
        BUFFER.with_borrow_mut(|buffer| {
            buffer.iter_mut().for_each(|value| *value = *value * 0.999 + 1e-3);
            buffer[0]
        })
    };
    timed(|| black_box((0..64_u32).into_par_iter().with_max_len(1).map(piece).sum::<f32>())).0
}

/// Leaves opened ÷ leaves that hold a piece of the band.
fn opened(measured: &Measured<()>) -> f64 {
    measured.report.opened_blocks as f64 / measured.report.band_blocks as f64
}

fn bench(scene: &str, resolution: u32) {
    let (single, double) = (hfvdb_bench::threads(1), hfvdb_bench::threads(2));
    let (once, twice) = (Job::new(scene, resolution), Job::new(scene, 2 * resolution));
    let (before, _) = resident();
    let (time, measured) = double.install(|| timed(|| once.run()));
    let (_, peak) = resident();
    let blocks = measured.band.origins.len();
    let leaves = blocks * LEAF_BYTES;
    println!("{scene} at {resolution}: {time:.3?} s, {blocks} leaves, {} voxels", measured.band.active_voxels());
    println!("{:.1} MB at most for {:.1} MB of leaves", (peak - before) as f64 / 1e6, leaves as f64 / 1e6);
    Row("1", scene, resolution).value("leaves", opened(&measured), Goal::AtMost(1.25));
    let share = ((peak - before) as f64 - 30e6).max(0.0) / leaves as f64;
    Row("8", scene, resolution).value("memory", share, Goal::AtMost(1.6));
    drop(measured);

    let (mut threads, mut registers, mut memory) = (Vec::new(), Vec::new(), Vec::new());
    let sample = |pool: &ThreadPool, work: &(dyn Fn() -> Seconds + Sync)| pool.install(|| time_of_many(work));
    for _ in 0..TURNS[0] {
        let job = || once.time();
        threads.extend(pairs(TURNS[1], || sample(&double, &job), || sample(&single, &job)));
        registers.extend(pairs(TURNS[1], || sample(&double, &arithmetic), || sample(&single, &arithmetic)));
        memory.extend(pairs(TURNS[1], || sample(&double, &streaming), || sample(&single, &streaming)));
    }
    Row("18", scene, resolution).compare("two threads against one", Goal::AtLeast(1.85), &threads);
    Row("18-machine", scene, resolution).compare("arithmetic in registers", Goal::None, &registers);
    Row("18-memory", scene, resolution).compare("reading and writing memory", Goal::None, &memory);
    let finer = pairs(PAIRS, || double.install(|| twice.time()), || double.install(|| once.time()));
    Row("7", scene, resolution).compare("twice the resolution", Goal::AtMost(4.3), &finer);

    let finer = double.install(|| twice.run());
    println!("{scene} at {}: {:.2} times the leaves", 2 * resolution, finer.band.origins.len() as f64 / blocks as f64);
    Row("1", scene, 2 * resolution).value("leaves", opened(&finer), Goal::AtMost(1.25));
}

fn main() {
    let resolutions = hfvdb_bench::resolutions(&[512]);
    let named: Vec<String> = hfvdb_bench::arguments().into_iter().filter(|word| word.parse::<u32>().is_err()).collect();
    if let [scene] = named.as_slice() {
        return resolutions.into_iter().for_each(|resolution| bench(scene, resolution));
    }
    let scenes = if named.is_empty() { ["ball", "three", "two_hundred"].map(String::from).to_vec() } else { named };
    // A process each: memory that one job leaves behind would hide what the next one takes.
    for (scene, resolution) in scenes.iter().flat_map(|scene| resolutions.iter().map(move |at| (scene, at))) {
        let program = std::env::current_exe().expect("this program");
        let status = Command::new(program).arg(scene).arg(resolution.to_string()).status().expect("it starts");
        assert!(status.success(), "{scene} at {resolution} failed");
    }
}
