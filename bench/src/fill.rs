//! Blocks that were found, filled with F.

use glam::IVec3;
use hfvdb::distance::descent::{NODE_EDGE, Scope};
use hfvdb::field::{BATCH, Evaluator, Points};
use hfvdb::grid::BLOCK_EDGE;

/// The node that a block is in.
pub fn node(block: IVec3) -> IVec3 {
    block & !(NODE_EDGE - 1)
}

/// Goes through the blocks of one node, as the program does: the node is entered once, then each block. `visit` is told
/// which block it is, and its voxels.
pub fn in_blocks<'a>(
    evaluator: &mut (dyn Evaluator + 'a),
    scope: &Scope,
    blocks: &[IVec3],
    mut visit: impl FnMut(&mut (dyn Evaluator + 'a), usize, &Points),
) {
    let half_width = f64::from(scope.half_width);
    evaluator.enter(&scope.centres(node(blocks[0]), NODE_EDGE, half_width));
    for (i, block) in blocks.iter().enumerate() {
        evaluator.enter(&scope.centres(*block, BLOCK_EDGE, half_width));
        visit(evaluator, i, &Points::of_block(*block, &scope.lattice));
        evaluator.leave();
    }
    evaluator.leave();
}

/// Fills the blocks of one node.
pub fn fill_node(evaluator: &mut dyn Evaluator, scope: &Scope, blocks: &[IVec3], values: &mut [[f32; BATCH]]) {
    in_blocks(evaluator, scope, blocks, |evaluator, i, points| evaluator.values(points, &mut values[i]));
}
