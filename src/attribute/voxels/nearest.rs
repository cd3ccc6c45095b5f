//! The active voxel whose cube is nearest to a point.
//!
//! Points that stand together share a list of cubes of 4³ in which the nearest voxels of all of them are: where a is at
//! most ρ from a middle A, and the nearest voxel of A at the distance D, that of a is at most D + ρ from a, so at most
//! D + 2ρ from A.

use glam::{DVec3, IVec3};

use super::Volume;
use super::group::{Group, ball, halves};
use super::tree::{Below, Tree, cube, is_full};

/// The most children that wait at one time: seven a level, and cubes of blocks halve a space of 2³² at most 32 times.
const DEPTH: usize = 8 * 34;

/// Points that share a list. More: each looks through voxels that are near to others only; fewer: more lists.
const GROUP: usize = 32;

/// What distances are multiplied by for the rounding of 64 bits.
const ROUNDING: f64 = 1.0 + 1e-12;

/// Square of the distance from a point to the cubes of a box of voxels.
fn distance_squared(at: DVec3, low: IVec3, high: IVec3) -> f64 {
    at.distance_squared(foot(at, low, high))
}

/// The point of the cubes of a box of voxels that is nearest to a point.
pub(super) fn foot(at: DVec3, low: IVec3, high: IVec3) -> DVec3 {
    let half = DVec3::splat(0.5);
    at.clamp(low.as_dvec3() - half, high.as_dvec3() + half)
}

/// Finds nearest voxels, with its own scratch memory.
pub(super) struct Nearest<'a, const N: usize> {
    volume: &'a Volume<N>,
    tree: &'a Tree,
    /// Cubes of 4³ that may hold the nearest voxel of one of a group, the nearest first: their distance from the
    /// group's middle, and their node.
    cubes: Vec<(f64, u32)>,
}

impl<'a, const N: usize> Nearest<'a, N> {
    pub fn new(volume: &'a Volume<N>, tree: &'a Tree) -> Self {
        Self { volume, tree, cubes: vec![] }
    }

    /// Tells, for each point, its place and the active voxel whose cube is nearest: of several, the least by x, then y,
    /// then z. The points are put in another order.
    pub fn find(&mut self, points: &mut Group, tell: &mut impl FnMut(DVec3, usize, IVec3)) {
        if points.len() > GROUP {
            let (left, right) = halves(points);
            self.find(left, tell);
            self.find(right, tell);
        } else if !points.is_empty() {
            let (middle, radius) = ball(points);
            self.collect(middle, (self.distance(middle) + 2.0 * radius) * ROUNDING);
            let mut near = None;
            for (at, place) in points.iter() {
                let voxel = self.of_point(*at, at.distance(middle), near);
                near = Some(voxel);
                tell(*at, *place, voxel);
            }
        }
    }

    /// The distance from a point to the nearest active voxel's cube.
    fn distance(&self, at: DVec3) -> f64 {
        let mut best = f64::INFINITY;
        let mut waiting = [(0.0, 0_u32); DEPTH];
        let mut len = 1;
        while len > 0 {
            len -= 1;
            let (distance, node) = waiting[len];
            if distance >= best {
                continue;
            }
            match self.tree.nodes[node as usize].below {
                Below::Voxels { block, place } if is_full(self.volume, block, place) => best = distance,
                Below::Voxels { block, place } => {
                    let cubes = cube(self.volume, block, place);
                    best = cubes.map(|(voxel, _)| distance_squared(at, voxel, voxel)).fold(best, f64::min);
                }
                Below::Nodes(first, count) => {
                    let start = len;
                    for child in first..first + u32::from(count) {
                        let node = &self.tree.nodes[child as usize];
                        let distance = distance_squared(at, node.low, node.high);
                        if distance < best {
                            waiting[len] = (distance, child);
                            len += 1;
                        }
                    }
                    // The nearest is taken first.
                    waiting[start..len].sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
                }
            }
        }
        best.sqrt()
    }

    /// Collects the cubes within a distance.
    fn collect(&mut self, at: DVec3, reach: f64) {
        self.cubes.clear();
        let mut waiting = [0_u32; DEPTH];
        let mut len = 1;
        while len > 0 {
            len -= 1;
            let index = waiting[len];
            let node = &self.tree.nodes[index as usize];
            let distance = distance_squared(at, node.low, node.high).sqrt();
            if distance > reach {
                continue;
            }
            match node.below {
                Below::Voxels { .. } => self.cubes.push((distance, index)),
                Below::Nodes(first, count) => {
                    for child in first..first + u32::from(count) {
                        waiting[len] = child;
                        len += 1;
                    }
                }
            }
        }
        self.cubes.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    }

    /// The nearest of the cubes collected, for a point so far from their group's middle. `near`, any active voxel, only
    /// makes it faster.
    fn of_point(&self, at: DVec3, away: f64, near: Option<IVec3>) -> IVec3 {
        let key = |voxel: IVec3| (distance_squared(at, voxel, voxel), voxel.to_array());
        let mut best = near.map_or((f64::INFINITY, [i32::MAX; 3]), key);
        let mut reach = (best.0.sqrt() + away) * ROUNDING;
        for (distance, node) in &self.cubes {
            if *distance > reach {
                break;
            }
            let node = &self.tree.nodes[*node as usize];
            if distance_squared(at, node.low, node.high) > best.0 {
                continue;
            }
            let Below::Voxels { block, place } = node.below else { continue };
            let mut tell = |voxel: IVec3| {
                let key = key(voxel);
                if key < best {
                    best = key;
                }
            };
            if is_full(self.volume, block, place) {
                // The one that the point's nearest neighbour in the box is in; of several, the least.
                tell((foot(at, node.low, node.high) - 0.5).ceil().as_ivec3().clamp(node.low, node.high));
            } else {
                cube(self.volume, block, place).for_each(|(voxel, _)| tell(voxel));
            }
            reach = (best.0.sqrt() + away) * ROUNDING;
        }
        IVec3::from_array(best.1)
    }
}
