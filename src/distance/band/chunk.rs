//! The blocks of a chunk, measured each by itself.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::IVec3;
use rayon::prelude::*;

use super::{
    Error, Feet,
    pool::{Pool, Taken},
};
use crate::{
    distance::{
        block::{Meter, TASK_EDGE, by_itself},
        descent::{NODE_EDGE, Scope},
        staged::Staged,
    },
    field::Field,
    grid::node_origin,
};

/// Blocks of a node that one thread measures before another may take the next. At the end of a chunk threads wait for
/// the last such; tapes are shortened anew by the threads that take them.
const BLOCKS_OF_TASK: usize = 4;

/// Blocks that were measured, not yet improved by their neighbours.
#[derive(Default)]
pub struct Chunk {
    /// Those of one task together.
    pub staged: Vec<Staged>,
    /// The place of each in the order of blocks.
    pub order: Vec<usize>,
}

/// What measures blocks, on any thread.
pub struct Measuring<'a> {
    field: &'a dyn Field,
    scope: &'a Scope,
    feet: Feet,
    cancel: &'a AtomicBool,
    meters: Pool<Meter<'a>>,
}

impl<'a> Measuring<'a> {
    pub fn new(field: &'a dyn Field, scope: &'a Scope, feet: Feet, cancel: &'a AtomicBool) -> Self {
        Self { field, scope, feet, cancel, meters: Pool::new() }
    }

    /// Whether blocks have nothing to offer to their neighbours: each knows its distances by itself.
    pub fn by_itself(&self) -> bool {
        by_itself(self.field.slope(), self.feet)
    }

    pub fn scope(&self) -> &'a Scope {
        self.scope
    }

    pub fn stop_if_cancelled(&self) -> Result<(), Error> {
        if self.cancel.load(Ordering::Relaxed) { Err(Error::Cancelled) } else { Ok(()) }
    }

    pub fn meter(&self) -> Taken<'_, Meter<'a>> {
        self.meters.take(|| Meter::new(self.field, self.scope, self.feet))
    }

    /// Measures blocks, chunk after chunk, into memory that others left.
    pub fn stage(&self, blocks: &[IVec3], chunk: usize, mut left: Vec<Chunk>) -> Result<Vec<Chunk>, Error> {
        left.resize_with(blocks.len().div_ceil(chunk), Chunk::default);
        let measured = blocks.par_chunks(chunk).zip(left).map(|(blocks, left)| self.stage_chunk(blocks, left.staged));
        measured.collect()
    }

    fn stage_chunk(&self, blocks: &[IVec3], mut staged: Vec<Staged>) -> Result<Chunk, Error> {
        let order = by_task(blocks);
        staged.resize_with(blocks.len(), Staged::new);
        let mut tasks = Vec::new();
        let mut rest = &mut staged[..];
        let node = |place: usize| node_origin(blocks[place], TASK_EDGE);
        let nodes = order.chunk_by(|&a, &b| node(a) == node(b));
        for task in nodes.flat_map(|node| node.chunks(BLOCKS_OF_TASK)) {
            let (of_task, after) = std::mem::take(&mut rest).split_at_mut(task.len());
            rest = after;
            tasks.push((task, of_task));
        }
        // Each may go to another thread: the last of a chunk are waited for.
        tasks.into_par_iter().with_max_len(1).try_for_each_init(
            || self.meter(),
            |meter, (task, staged)| {
                meter.enter_nodes(blocks[task[0]]);
                task.iter().zip(staged).try_for_each(|(&place, staged)| {
                    self.stop_if_cancelled()?;
                    meter.measure(blocks[place], staged)
                })
            },
        )?;
        Ok(Chunk { staged, order })
    }
}

/// Places of a chunk's blocks, those of one task together.
fn by_task(chunk: &[IVec3]) -> Vec<usize> {
    // Blocks come node after node, so that their tasks need to be told apart within one only.
    let task = |origin: IVec3| {
        let at = (origin & IVec3::splat(NODE_EDGE - 1)) / TASK_EDGE;
        (at.x << 16 | at.y << 8 | at.z) as u32
    };
    let mut places: Vec<usize> = (0..chunk.len()).collect();
    for of_node in places.chunk_by_mut(|&a, &b| node_origin(chunk[a], NODE_EDGE) == node_origin(chunk[b], NODE_EDGE)) {
        of_node.sort_by_key(|&place| task(chunk[place]));
    }
    places
}
