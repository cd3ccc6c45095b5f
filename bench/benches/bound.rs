//! What bounds the distances and the colours of a frame. Distances are worked out from F and ∇F at so many points, and
//! cannot take less than those take by themselves, in whole blocks and whole batches; colours cannot take less than sampling
//! them does where all that it needs is at hand. Processor time, two threads.
//!
//! `cargo bench -p hfvdb-bench --bench bound [-- SCENE... RESOLUTION...]`
//!
//! `BOUND scene resolution points distances gradients cached ratio`: millions of points at which gradients are asked for, of F
//! or of one of its branches; milliseconds that the distances take, blocks found already; what so many gradients take, block
//! after block; the same where the block is in the caches from the time before: the rest is memory; the first over the
//! second. Of branches, which are cheaper than F, no time is known: scenes of several smooth parts have no bound here.
//!
//! `BOUND-COLOUR scene resolution voxels colours sampling ratio`: millions of active voxels; milliseconds that their colours
//! take, the distances known already; what sampling takes at the same closest points, in blocks that were sampled just
//! before; the first over the second. A scene whose parts have one colour each has no such line: memory is what bounds it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::{DVec3, IVec3};
use hfvdb::attribute::Colour;
use hfvdb::distance::band::{Feet, MeasuredBlock, Settings, measure};
use hfvdb::distance::descent::{Scope, descend};
use hfvdb::field::{Aabb, BATCH, Evaluator, Field, Gradients, Hint, Hints, Interval, Points, Slope};
use hfvdb::shot::{FrameContent, Prepared};
use hfvdb_bench::clock::{quartiles, timed};
use hfvdb_bench::scenes::{self, Sampling};
use hfvdb_bench::{
    bake,
    fill::{in_blocks, node},
    threads,
};
use rayon::prelude::*;

const ROUNDS: usize = 9;
/// How often more each block is filled, or its colours are sampled, once it is in the caches.
const AGAIN: u64 = 4;
/// Where sampling takes less of the time of colours, it is lost in the noise.
const LEAST_SHARE: f64 = 0.2;

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

    fn hints(&mut self, asked: Hint) -> Hints {
        self.inner.hints(asked)
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

fn distances(scene: &str, resolution: u32) {
    let prepared = scenes::prepare(scene, Sampling::OfSolid(resolution));
    let mut content = prepared.frame(frame_of(scene)).expect("a frame");
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

/// The band with its colours sampled in each block, so many times one after the other.
fn samples(prepared: &Prepared, content: &FrameContent, colour: &Colour, times: u64) -> u64 {
    let new_visitor = || {
        let mut sampler = colour.sampler();
        let (mut feet, mut sampled) = (Points::new(DVec3::ZERO), Box::new([[0.0; 3]; BATCH]));
        move |block: &MeasuredBlock| {
            block.feet_into(&mut feet);
            sampler.enter(&feet.bounding_box().unwrap_or(block.region));
            (0..times).for_each(|_| sampler.sample(&feet, std::hint::black_box(&mut sampled)));
            sampler.leave();
            feet.len as u64
        }
    };
    let settings = Settings {
        lattice: prepared.lattice,
        half_width: prepared.half_width,
        region: content.region,
        feet: Feet::Nearest,
        cancel: &AtomicBool::new(false),
        progress: &|_| {},
    };
    let measured = measure(&*content.field, &settings, new_visitor).expect("the scenes have surfaces");
    measured.visits.iter().sum()
}

fn colours(scene: &str, resolution: u32) {
    let frame = frame_of(scene);
    let prepared = scenes::prepare(scene, Sampling::OfSolid(resolution));
    let content = prepared.frame(frame).expect("a frame");
    let colour = content.colour.as_deref().expect("the scenes have a colour");
    let mut voxels = 0;
    let mut milliseconds = [const { Vec::new() }; 2];
    for _ in 0..ROUNDS {
        let [band, computed, once, often] = [
            timed(|| scenes::band(&prepared, &content)).0,
            timed(|| bake::compute(&prepared, frame)).0,
            timed(|| samples(&prepared, &content, colour, 1)).0,
            timed(|| voxels = samples(&prepared, &content, colour, 1 + AGAIN)).0,
        ]
        .map(|seconds| 1e3 * seconds[1]);
        let times = [computed - band, (often - once) / AGAIN as f64];
        milliseconds.iter_mut().zip(times).for_each(|(all, time)| all.push(time));
    }
    let [colours, sampling] = milliseconds.map(|all| quartiles(all)[0]);
    if sampling > LEAST_SHARE * colours {
        let ratio = colours / sampling;
        println!("BOUND-COLOUR {scene} {resolution} {:.2} {colours:.1} {sampling:.1} {ratio:.2}", voxels as f64 / 1e6);
    }
}

/// The frame of a scene that is looked at.
fn frame_of(scene: &str) -> i64 {
    if scene == "cubism" { 24 } else { 1 }
}

fn main() {
    let named: Vec<String> = hfvdb_bench::arguments().into_iter().filter(|word| word.parse::<u32>().is_err()).collect();
    let scenes = if named.is_empty() { ["sphere-to-cube", "cubism"].map(String::from).to_vec() } else { named };
    for resolution in hfvdb_bench::resolutions(&[512]) {
        for scene in &scenes {
            threads(2).install(|| distances(scene, resolution));
            threads(2).install(|| colours(scene, resolution));
        }
    }
}
