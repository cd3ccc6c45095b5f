//! The active voxel whose cube is nearest to a point.

use glam::{DVec3, IVec3};

use super::Volume;
use super::tree::{Below, Tree, cube};

/// The most children that wait at one time: seven a level, and cubes of blocks halve a space of 2³² at most 32 times.
const DEPTH: usize = 8 * 34;

/// Square of the distance from a point to the cubes of a box of voxels.
fn distance_squared(at: DVec3, low: IVec3, high: IVec3) -> f64 {
    let half = DVec3::splat(0.5);
    at.distance_squared(at.clamp(low.as_dvec3() - half, high.as_dvec3() + half))
}

impl<const N: usize> Tree<N> {
    /// The active voxel whose cube is nearest; of several, the least by x, then y, then z. `near`, any active voxel,
    /// only makes it faster.
    pub fn nearest(&self, volume: &Volume<N>, at: DVec3, near: Option<IVec3>) -> IVec3 {
        let key = |voxel: IVec3| (distance_squared(at, voxel, voxel), voxel.to_array());
        let mut best = near.map_or((f64::INFINITY, [i32::MAX; 3]), key);
        let mut waiting = [(0.0, 0_u32); DEPTH];
        let mut len = 1;
        while len > 0 {
            len -= 1;
            let (distance, node) = waiting[len];
            if distance > best.0 {
                continue;
            }
            match self.nodes[node as usize].below {
                Below::Voxels { block, place } => {
                    for (voxel, _) in cube(volume, block, place, 2) {
                        let other = key(voxel);
                        if other < best {
                            best = other;
                        }
                    }
                }
                Below::Nodes(first, count) => {
                    let start = len;
                    for child in first..first + u32::from(count) {
                        let node = &self.nodes[child as usize];
                        let distance = distance_squared(at, node.low, node.high);
                        if distance <= best.0 {
                            waiting[len] = (distance, child);
                            len += 1;
                        }
                    }
                    // The nearest is taken first.
                    waiting[start..len].sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
                }
            }
        }
        IVec3::from_array(best.1)
    }
}
