//! Finding the leaves that may hold a piece of the band and filling F in them, no distances: against fidget's JIT in
//! its best case, min and max in place of R₀, its interval evaluation down the same tree and its simplified tapes
//! (row 4 of the performance table). Both on one thread.
//!
//! `cargo bench -p hfvdb-bench --bench leaves [-- RESOLUTION...]`

use std::sync::atomic::AtomicBool;

use fidget::eval::Function;
use fidget::jit::{JitFunction, JitShape};
use fidget::types::Interval;
use glam::IVec3;
use hfvdb::distance::descent::{Scope, descend};
use hfvdb::field::{BATCH, Evaluator, Field, Points};
use hfvdb::grid::{BLOCK_EDGE, BLOCK_VOXELS};
use hfvdb_bench::clock::{pairs, timed};
use hfvdb_bench::fill::{fill_node, node};
use hfvdb_bench::report::{Goal, Row};
use hfvdb_bench::scenes::{self, Balls, HALF_WIDTH, Sampling};
use hfvdb_bench::{jit, threads};

const PAIRS: usize = 5;

/// Leaves and their values of F, the latter one after another.
#[derive(Default)]
struct Leaves {
    origins: Vec<IVec3>,
    values: Vec<[f32; BLOCK_VOXELS]>,
}

impl Leaves {
    fn clear(&mut self) {
        self.origins.clear();
        self.values.clear();
    }
}

/// As the program does it: all leaves are found, and entered again to be filled.
fn apart(field: &dyn Field, scope: &Scope) -> Leaves {
    let origins = descend(field, scope, &AtomicBool::new(false)).expect("not cancelled").blocks;
    let mut values = vec![[0.0; BLOCK_VOXELS]; origins.len()];
    let mut evaluator = field.evaluator();
    let mut from = 0;
    for blocks in origins.chunk_by(|a, b| node(*a) == node(*b)) {
        fill_node(&mut *evaluator, scope, blocks, &mut values[from..]);
        from += blocks.len();
    }
    Leaves { origins, values }
}

/// The least corners of the eight nodes around the origin that hold the scope, and their edge.
fn octants(scope: &Scope) -> ([IVec3; 8], i32) {
    let [least, end] = scope.block_range();
    let edge = (least.abs().max(end).max_element() as u32).next_power_of_two() as i32;
    (CORNERS.map(|corner| (corner - 1) * edge), edge)
}

const CORNERS: [IVec3; 8] = {
    let mut corners = [IVec3::ZERO; 8];
    let mut child = 0;
    while child < 8 {
        corners[child] = IVec3::new(child as i32 >> 2, child as i32 >> 1 & 1, child as i32 & 1);
        child += 1;
    }
    corners
};

/// One walk that fills a leaf when it finds it, as the rival's. Into memory that is there already, as the rival: new
/// memory takes as long as the work.
fn ours(field: &dyn Field, scope: &Scope, mut found: Leaves) -> Leaves {
    found.clear();
    let mut evaluator = field.evaluator();
    let (octants, edge) = octants(scope);
    octants.into_iter().for_each(|origin| walk(&mut *evaluator, scope, origin, edge, &mut found));
    found
}

fn walk(evaluator: &mut dyn Evaluator, scope: &Scope, origin: IVec3, edge: i32, found: &mut Leaves) {
    evaluator.enter(&scope.centres(origin, edge, HALF_WIDTH));
    let bounds = evaluator.bounds();
    if bounds.lo <= 0.0 && bounds.hi >= 0.0 {
        if edge == BLOCK_EDGE {
            found.origins.push(origin);
            found.values.push([0.0; BLOCK_VOXELS]);
            let values = found.values.last_mut().expect("pushed");
            evaluator.values(&Points::of_block(origin, &scope.lattice), values);
        } else {
            CORNERS
                .into_iter()
                .for_each(|corner| walk(evaluator, scope, origin + corner * (edge / 2), edge / 2, found));
        }
    }
    evaluator.leave();
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
        for corner in CORNERS {
            self.descend(shape, origin + corner * (edge / 2), edge / 2);
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

fn theirs(shape: &JitShape, scope: &Scope, mut found: Leaves) -> Leaves {
    found.clear();
    let mut rival = Rival {
        scope,
        intervals: JitShape::new_interval_eval(),
        floats: JitShape::new_float_slice_eval(),
        storage: Vec::new(),
        tapes: Vec::new(),
        workspace: Default::default(),
        found,
    };
    let (octants, edge) = octants(scope);
    octants.into_iter().for_each(|origin| rival.descend(shape, origin, edge));
    rival.found
}

fn bench(balls: &Balls, resolution: u32) {
    let prepared = scenes::prepare("two_hundred", Sampling::OfBox(resolution));
    let content = prepared.frame(1).expect("a frame");
    let scope = Scope { lattice: prepared.lattice, half_width: prepared.half_width, region: content.region };
    let shape = jit::shape(balls, jit::greater);
    let count =
        |leaves: &Leaves| (leaves.origins.len(), leaves.values.as_flattened().iter().filter(|f| **f >= 0.0).count());
    let field = &*content.field;
    let (mut our_leaves, mut their_leaves) = Default::default();
    let mut one_walk = || timed(|| our_leaves = ours(field, &scope, std::mem::take(&mut our_leaves))).0;
    let mut rival = || timed(|| their_leaves = theirs(&shape, &scope, std::mem::take(&mut their_leaves))).0;
    threads(1).install(|| {
        let one_walk = pairs(PAIRS, &mut one_walk, &mut rival);
        let row = |number| Row(number, "two_hundred", resolution);
        row("4").compare("finding and filling leaves, against fidget's JIT", Goal::AtLeast(10.0), &one_walk);
        let apart = pairs(PAIRS, || timed(|| apart(field, &scope)).0, &mut rival);
        row("4-apart").compare("finding leaves, then filling them, against the same", Goal::None, &apart);
    });
    println!("ours: {:?} leaves and voxels inside", count(&our_leaves));
    println!("theirs: {:?}", count(&their_leaves));
}

fn main() {
    let balls = scenes::two_hundred();
    hfvdb_bench::resolutions(&[512]).into_iter().for_each(|resolution| bench(&balls, resolution));
}
