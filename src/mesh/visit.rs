//! Triangles near a region, by a tree of their boxes.

use parry3d_f64::partitioning::{Bvh, TraversalAction};

use crate::field::Aabb;

/// Calls with every triangle of a tree whose box, grown by `margin`, meets the region, until told to stop.
pub(super) fn visit(tree: &Bvh, region: &Aabb, margin: f64, mut stop: impl FnMut(u32) -> bool) {
    let region = region.grown(margin);
    tree.traverse(|node| {
        let (low, high) = (node.mins().to_array(), node.maxs().to_array());
        let apart = (0..3).any(|i| low[i] > region.max[i] || high[i] < region.min[i]);
        match node.leaf_data() {
            _ if apart => TraversalAction::Prune,
            Some(triangle) if stop(triangle) => TraversalAction::EarlyExit,
            _ => TraversalAction::Continue,
        }
    });
}
