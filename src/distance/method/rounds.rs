//! States of nodes that follow from those of their neighbours, worked out in rounds over a list of the nodes that may
//! change (Jeong and Whitaker, *A Fast Iterative Method for Eikonal Equations*, 2008).
//!
//! A round reads what the round before left (Jacobi), so that the result has the same bits for any number of threads.

use rayon::prelude::*;

use super::blocks::Blocks;
use crate::distance::nearest::Watch;
use crate::distance::octree::BuildError;

/// Nodes that one task works out at least.
const A_TASK: usize = 512;

/// Works out the states of all nodes that can be reached from `sources`, whose states are known. `relax` gives a node's new
/// state, or `None` where the old one is as good; what it gives must come to an end.
///
/// # Errors
/// [`BuildError::Cancelled`].
pub fn settle<T: Copy + Send + Sync>(
    blocks: &Blocks,
    states: &mut [T],
    sources: &[usize],
    relax: impl Fn(&[T], usize) -> Option<T> + Sync,
    watch: &Watch<'_>,
) -> Result<(), BuildError> {
    let mut listed = vec![false; blocks.nodes()];
    let mut active = Vec::new();
    let list_around = |node: usize, active: &mut Vec<usize>, listed: &mut [bool]| {
        for face in 0..6 {
            if let Some(other) = blocks.beside(node, face)
                && !std::mem::replace(&mut listed[other], true)
            {
                active.push(other);
            }
        }
    };
    sources.iter().for_each(|&node| list_around(node, &mut active, &mut listed));
    let mut found = Vec::new();
    while !active.is_empty() {
        if watch.cancelled() {
            return Err(BuildError::Cancelled);
        }
        active.par_iter().with_min_len(A_TASK).map(|&node| relax(states, node)).collect_into_vec(&mut found);
        let changed = |(&node, state): (&usize, &Option<T>)| Some((node, (*state)?));
        active.iter().for_each(|&node| listed[node] = false);
        let mut next = Vec::with_capacity(active.len());
        for (node, state) in active.iter().zip(&found).filter_map(changed) {
            states[node] = state;
            list_around(node, &mut next, &mut listed);
        }
        active = next;
    }
    Ok(())
}
