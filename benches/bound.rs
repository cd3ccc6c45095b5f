//! What bounds the distances of a frame: they are worked out from F and ∇F at so many points, and the work cannot take less
//! than those take by themselves, in whole blocks and whole batches. Processor time, two threads.
//!
//! `cargo bench --bench bound [-- SCENE... RESOLUTION...]`
//!
//! `BOUND scene resolution points distances gradients cached ratio`: millions of points at which gradients are asked for, of F
//! or of one of its branches; milliseconds that the distances take, blocks found already; what so many gradients take, block
//! after block; the same where the block is in the caches from the time before: the rest is memory; the first over the
//! second. Of branches, which are cheaper than F, no time is known: scenes of several smooth parts have no bound here.

mod common;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use common::clock::{quartiles, timed};
use common::scenes::{self, Sampling};
use common::{
    fill::{in_blocks, node},
    threads,
};
use glam::{DVec3, IVec3};
use hfvdb::distance::descent::{Scope, descend};
use hfvdb::field::{Aabb, BATCH, Evaluator, Field, Gradients, Interval, Points, Slope};
use rayon::prelude::*;

const ROUNDS: usize = 9;
/// How often more each block is filled once it is in the caches.
const AGAIN: u64 = 4;

/// A field that counts the points at which its gradients are asked for.
struct Counted {
    field: Arc<dyn Field>,
    points: AtomicU64,
}

struct CountedEvaluator<'a> {
    inner: Box<dyn Evaluator + 'a>,
    points: &'a AtomicU64,
}

impl Field for Counted {
    fn bounding_box(&self) -> Option<Aabb> {
        self.field.bounding_box()
    }

    fn slope(&self) -> Slope {
        self.field.slope()
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.field.reference(position)
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(CountedEvaluator { inner: self.field.evaluator(), points: &self.points })
    }
}

impl Evaluator for CountedEvaluator<'_> {
    fn enter(&mut self, region: &Aabb) {
        self.inner.enter(region);
    }

    fn bounds(&mut self) -> Interval {
        self.inner.bounds()
    }

    fn vanishes(&mut self) -> bool {
        self.inner.vanishes()
    }

    fn has_many_parts(&self) -> bool {
        self.inner.has_many_parts()
    }

    fn leave(&mut self) {
        self.inner.leave();
    }

    fn values(&mut self, points: &Points, out: &mut [f32; BATCH]) {
        self.inner.values(points, out);
    }

    fn gradients(&mut self, points: &Points, out: &mut Gradients) {
        self.points.fetch_add(points.len as u64, Ordering::Relaxed);
        self.inner.gradients(points, out);
    }

    fn steepest(&mut self) -> Option<f64> {
        self.inner.steepest()
    }

    fn branches(&self) -> usize {
        self.inner.branches()
    }

    fn branch(&mut self, branch: usize, points: &Points, out: &mut Gradients) {
        self.points.fetch_add(points.len as u64, Ordering::Relaxed);
        self.inner.branch(branch, points, out);
    }
}

/// Gradients at all voxels of blocks that were found, so many times one after the other.
fn gradients(field: &dyn Field, scope: &Scope, blocks: &[IVec3], times: u64) {
    let of_node = |(evaluator, out): &mut (Box<dyn Evaluator + '_>, Gradients), blocks: &[IVec3]| {
        in_blocks(&mut **evaluator, scope, blocks, |evaluator, _, points| {
            (0..times).for_each(|_| evaluator.gradients(points, std::hint::black_box(out)));
        });
    };
    let evaluator = || (field.evaluator(), Gradients::new());
    blocks.par_chunk_by(|a, b| node(*a) == node(*b)).for_each_init(evaluator, of_node);
}

fn bench(scene: &str, resolution: u32) {
    let frame = if scene == "cubism" { 24 } else { 1 };
    let prepared = scenes::prepare(scene, Sampling::OfSolid(resolution));
    let mut content = prepared.frame(frame).expect("a frame");
    let field = Arc::clone(&content.field);
    let counted = Arc::new(Counted { field: Arc::clone(&field), points: AtomicU64::new(0) });
    content.field = counted.clone();
    scenes::band(&prepared, &content);
    let points = counted.points.load(Ordering::Relaxed);
    content.field = field;

    let field = &*content.field;
    let scope = Scope { lattice: prepared.lattice, half_width: prepared.half_width, region: content.region };
    let find = || descend(field, &scope, &AtomicBool::new(false)).expect("not cancelled").blocks;
    let blocks = find();
    let mut milliseconds = [const { Vec::new() }; 3];
    for _ in 0..ROUNDS {
        let [found, band, once, often] = [
            timed(find).0,
            timed(|| scenes::band(&prepared, &content)).0,
            timed(|| gradients(field, &scope, &blocks, 1)).0,
            timed(|| gradients(field, &scope, &blocks, 1 + AGAIN)).0,
        ]
        .map(|seconds| 1e3 * seconds[1]);
        let share = points as f64 / (blocks.len() * BATCH) as f64;
        let times = [band - found, once * share, (often - once) / AGAIN as f64 * share];
        milliseconds.iter_mut().zip(times).for_each(|(all, time)| all.push(time));
    }
    let [distances, gradients, cached] = milliseconds.map(|all| quartiles(all)[0]);
    println!(
        "BOUND {scene} {resolution} {:.2} {distances:.1} {gradients:.1} {cached:.1} {:.2}",
        points as f64 / 1e6,
        distances / gradients
    );
}

fn main() {
    let named: Vec<String> = common::arguments().into_iter().filter(|word| word.parse::<u32>().is_err()).collect();
    let scenes = if named.is_empty() { ["sphere-to-cube", "cubism"].map(String::from).to_vec() } else { named };
    for resolution in common::resolutions(&[512]) {
        for scene in &scenes {
            threads(2).install(|| bench(scene, resolution));
        }
    }
}
