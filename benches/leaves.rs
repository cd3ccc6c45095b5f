//! Finding the leaves that may hold a piece of the band and filling F in them, no distances: against fidget's JIT in
//! its best case, min and max in place of R₀, its interval evaluation down the same tree and its simplified tapes
//! (row 4 of the performance table). Both on one thread.
//!
//! `cargo bench --bench leaves [-- RESOLUTION...]`

mod common;

use std::sync::atomic::AtomicBool;

use common::clock::{pairs, timed};
use common::report::{Goal, Row};
use common::scenes::{self, Balls, HALF_WIDTH, Sampling};
use common::{jit, threads};
use fidget::eval::Function;
use fidget::jit::{JitFunction, JitShape};
use fidget::types::Interval;
use glam::IVec3;
use hfvdb::distance::descent::{NODE_EDGE, Scope, descend};
use hfvdb::field::{BATCH, Field, Points};
use hfvdb::grid::{BLOCK_EDGE, BLOCK_VOXELS};

const PAIRS: usize = 5;

/// Leaves and their values of F, the latter one after another.
#[derive(Default)]
struct Leaves {
    origins: Vec<IVec3>,
    values: Vec<[f32; BLOCK_VOXELS]>,
}

/// As the crate does it.
fn ours(field: &dyn Field, scope: &Scope) -> Leaves {
    let origins = descend(field, scope, &AtomicBool::new(false)).expect("not cancelled").blocks;
    let mut values = vec![[0.0; BLOCK_VOXELS]; origins.len()];
    let mut evaluator = field.evaluator();
    let node = |origin: IVec3| origin & IVec3::splat(!(NODE_EDGE - 1));
    let mut from = 0;
    for blocks in origins.chunk_by(|a, b| node(*a) == node(*b)) {
        evaluator.enter(&scope.centres(node(blocks[0]), NODE_EDGE, HALF_WIDTH));
        for (origin, values) in blocks.iter().zip(&mut values[from..]) {
            evaluator.enter(&scope.centres(*origin, BLOCK_EDGE, HALF_WIDTH));
            evaluator.values(&Points::of_block(*origin, &scope.lattice), values);
            evaluator.leave();
        }
        evaluator.leave();
        from += blocks.len();
    }
    Leaves { origins, values }
}

/// As its own renderers and meshers do it: an interval evaluation a node, whose trace simplifies the tape for the
/// node's children, and storage used again.
struct Rival<'a> {
    scope: &'a Scope,
    intervals: fidget::shape::ShapeTracingEval<<JitFunction as Function>::IntervalEval>,
    floats: fidget::shape::ShapeBulkEval<<JitFunction as Function>::FloatSliceEval>,
    storage: Vec<<JitFunction as Function>::Storage>,
    tapes: Vec<<JitFunction as Function>::TapeStorage>,
    workspace: <JitFunction as Function>::Workspace,
    found: Leaves,
}

impl Rival<'_> {
    fn descend(&mut self, shape: &JitShape, origin: IVec3, edge: i32) {
        let around = self.scope.centres(origin, edge, HALF_WIDTH);
        let [x, y, z] = [0, 1, 2].map(|axis| Interval::new(around.min[axis] as f32, around.max[axis] as f32));
        let tape = shape.interval_tape(self.tapes.pop().unwrap_or_default());
        let (bounds, trace) = self.intervals.eval(&tape, x, y, z).expect("a tape");
        if bounds.contains(0.0) {
            let simpler = trace.map(|trace| {
                let storage = self.storage.pop().unwrap_or_default();
                shape.simplify(trace, storage, &mut self.workspace).expect("a trace of this tape")
            });
            let shape = simpler.as_ref().unwrap_or(shape);
            if edge == BLOCK_EDGE {
                self.fill(shape, origin)
            } else {
                self.children(shape, origin, edge)
            }
            self.storage.extend(simpler.and_then(JitShape::recycle));
        }
        self.tapes.extend(tape.recycle());
    }

    fn children(&mut self, shape: &JitShape, origin: IVec3, edge: i32) {
        let half = edge / 2;
        for child in 0..8 {
            self.descend(shape, origin + IVec3::new(child >> 2, child >> 1 & 1, child & 1) * half, half);
        }
    }

    fn fill(&mut self, shape: &JitShape, origin: IVec3) {
        let size = self.scope.lattice.voxel_size.get() as f32;
        let mut at = [[0.0; BATCH]; 3];
        for i in 0..BATCH {
            let voxel = origin + IVec3::new(i as i32 >> 6, i as i32 >> 3 & 7, i as i32 & 7);
            [at[0][i], at[1][i], at[2][i]] = (voxel.as_vec3() * size).to_array();
        }
        let tape = shape.float_slice_tape(self.tapes.pop().unwrap_or_default());
        let values = self.floats.eval(&tape, &at[0], &at[1], &at[2]).expect("a tape");
        self.found.origins.push(origin);
        self.found.values.push(values.try_into().expect("a value a point"));
        self.tapes.extend(tape.recycle());
    }
}

fn theirs(shape: &JitShape, scope: &Scope) -> Leaves {
    let mut rival = Rival {
        scope,
        intervals: JitShape::new_interval_eval(),
        floats: JitShape::new_float_slice_eval(),
        storage: Vec::new(),
        tapes: Vec::new(),
        workspace: Default::default(),
        found: Leaves::default(),
    };
    let [least, end] = scope.block_range();
    let edge = ((end - least).max_element() as u32).next_power_of_two() as i32 / 2;
    for octant in 0..8 {
        let origin = IVec3::new(octant >> 2, octant >> 1 & 1, octant & 1) - 1;
        rival.descend(shape, origin * edge, edge);
    }
    rival.found
}

fn bench(balls: &Balls, resolution: u32) {
    let prepared = scenes::prepare("two_hundred", Sampling::OfBox(resolution));
    let content = prepared.frame(1).expect("a frame");
    let scope = Scope { lattice: prepared.lattice, half_width: prepared.half_width, region: content.region };
    let shape = jit::shape(balls, jit::greater);
    let count =
        |leaves: &Leaves| (leaves.origins.len(), leaves.values.as_flattened().iter().filter(|f| **f >= 0.0).count());
    println!("ours: {:?} leaves and voxels inside", count(&ours(&*content.field, &scope)));
    println!("theirs: {:?}", count(&theirs(&shape, &scope)));
    let pairs = threads(1)
        .install(|| pairs(PAIRS, || timed(|| ours(&*content.field, &scope)).0, || timed(|| theirs(&shape, &scope)).0));
    let row = Row("4", "two_hundred", resolution);
    row.compare("finding leaves and filling F, against fidget's JIT", Goal::AtLeast(10.0), &pairs);
}

fn main() {
    let balls = scenes::two_hundred();
    common::resolutions(&[512]).into_iter().for_each(|resolution| bench(&balls, resolution));
}
