//! The active voxel whose cube is nearest to a point.
//!
//! Points that stand together share a list of cubes of 4³ in which the nearest voxels of all of them are: where a is at
//! most ρ from a middle A, and the nearest voxel of A at the distance D, that of a is at most D + ρ from a, so at most
//! D + 2ρ from A.

use glam::{DVec3, IVec3, UVec3};

use super::Volume;
use super::group::{Group, ball, halves};
use super::tree::{Below, EDGE, Tree, bits, centre, cube, is_full};

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
    /// Cubes of 4³ that may hold the nearest voxel of one of a group, the nearest to its middle first.
    cubes: Vec<Cube>,
}

/// A cube of 4³ voxels, as all points of a group look at it.
struct Cube {
    /// The distance of its active voxels' box from the group's middle.
    distance: f64,
    /// The least and the greatest centre of its active voxels.
    low: IVec3,
    high: IVec3,
    /// The centre of its first voxel.
    corner: IVec3,
    /// Which are active: a bit each, by x, then y, then z, from the lowest.
    bits: u64,
}

/// How far away the nearest voxel known is, squared, and which it is: of several, the least.
type Best = (f64, [i32; 3]);

impl Cube {
    /// Puts the voxel that is nearest to a point in the place of one that is farther; whether it did.
    fn improve(&self, at: DVec3, best: &mut Best) -> bool {
        let foot = foot(at, self.low, self.high);
        if at.distance_squared(foot) > best.0 {
            return false;
        }
        let mut improved = false;
        let mut tell = |square: f64, voxel: [i32; 3]| {
            if square < best.0 || square == best.0 && voxel < best.1 {
                *best = (square, voxel);
                improved = true;
            }
        };
        if self.bits == u64::MAX {
            // The one that the point's nearest neighbour in the box is in; of several, the least.
            let voxel = (foot - 0.5).ceil().as_ivec3().clamp(self.low, self.high);
            tell(distance_squared(at, voxel, voxel), voxel.to_array());
            return improved;
        }
        // The square of a voxel's distance is the sum of one of each axis.
        let along = |axis: usize| -> [f64; EDGE as usize] {
            std::array::from_fn(|step| {
                let centre = f64::from(self.corner[axis] + step as i32);
                let away = at[axis] - at[axis].clamp(centre - 0.5, centre + 0.5);
                away * away
            })
        };
        let (x, y, z) = (along(0), along(1), along(2));
        let mut left = self.bits;
        while left != 0 {
            let bit = left.trailing_zeros();
            left &= left - 1;
            let [i, j, k] = [bit >> 4, bit >> 2 & 3, bit & 3];
            let square = x[i as usize] + y[j as usize] + z[k as usize];
            tell(square, (self.corner + UVec3::new(i, j, k).as_ivec3()).to_array());
        }
        improved
    }
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
            let node = &self.tree.nodes[waiting[len] as usize];
            let distance = distance_squared(at, node.low, node.high).sqrt();
            if distance > reach {
                continue;
            }
            match node.below {
                Below::Voxels { block, place } => {
                    let corner = centre(self.volume, block, place);
                    let bits = bits(self.volume, block, place);
                    self.cubes.push(Cube { distance, low: node.low, high: node.high, corner, bits });
                }
                Below::Nodes(first, count) => {
                    for child in first..first + u32::from(count) {
                        waiting[len] = child;
                        len += 1;
                    }
                }
            }
        }
        self.cubes.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance));
    }

    /// The nearest of the cubes collected, for a point so far from their group's middle. `near`, any active voxel, only
    /// makes it faster.
    fn of_point(&self, at: DVec3, away: f64, near: Option<IVec3>) -> IVec3 {
        let known = |voxel: IVec3| (distance_squared(at, voxel, voxel), voxel.to_array());
        let mut best = near.map_or((f64::INFINITY, [i32::MAX; 3]), known);
        let reach = |best: &Best| (best.0.sqrt() + away) * ROUNDING;
        let mut farthest = reach(&best);
        for cube in &self.cubes {
            if cube.distance > farthest {
                break;
            }
            if cube.improve(at, &mut best) {
                farthest = reach(&best);
            }
        }
        IVec3::from_array(best.1)
    }
}
