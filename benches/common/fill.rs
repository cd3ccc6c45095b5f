//! Blocks that were found, filled with F.

use glam::IVec3;
use hfvdb::distance::descent::{NODE_EDGE, Scope};
use hfvdb::field::{BATCH, Evaluator, Points};
use hfvdb::grid::BLOCK_EDGE;

/// The node that a block is in.
pub fn node(block: IVec3) -> IVec3 {
    block & !(NODE_EDGE - 1)
}

/// Fills the blocks of one node, as the program does: the node is entered once.
pub fn fill_node(evaluator: &mut dyn Evaluator, scope: &Scope, blocks: &[IVec3], values: &mut [[f32; BATCH]]) {
    let half_width = f64::from(scope.half_width);
    evaluator.enter(&scope.centres(node(blocks[0]), NODE_EDGE, half_width));
    for (block, values) in blocks.iter().zip(values) {
        evaluator.enter(&scope.centres(*block, BLOCK_EDGE, half_width));
        evaluator.values(&Points::of_block(*block, &scope.lattice), values);
        evaluator.leave();
    }
    evaluator.leave();
}
