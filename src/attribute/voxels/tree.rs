//! An octree over the active voxels of a volume, down to cubes of 2³.

use std::ops::Range;

use glam::{DVec3, IVec3};

use super::Volume;
use crate::grid::{is_active, voxel_offset};

/// The nodes, the root first, a node's children side by side and behind it.
pub(super) struct Tree<const N: usize> {
    pub nodes: Vec<Node<N>>,
    /// The least and the greatest of each number.
    pub range: [[f32; N]; 2],
}

/// Active voxels that stand together. `h` below is a voxel's centre less their centroid, `c` its value.
pub(super) struct Node<const N: usize> {
    /// The least and the greatest centre of its voxels.
    pub low: IVec3,
    pub high: IVec3,
    /// How many there are.
    pub count: f32,
    /// The mean of their centres.
    pub centroid: DVec3,
    /// Σ c.
    pub value: [f32; N],
    /// Σ h c, by number.
    pub dipole: [[f32; 3]; N],
    /// Σ h².
    pub spread: f32,
    pub below: Below,
}

/// What a node is made of.
#[derive(Clone, Copy)]
pub(super) enum Below {
    /// Nodes, and how many.
    Nodes(u32, u8),
    /// The active voxels of the 2³ at this place of a block.
    Voxels { block: u32, place: u16 },
}

/// A node whose children are still to be made.
enum Pending {
    /// Blocks, as places in the order.
    Blocks(Range<usize>),
    /// A cube of a block: its place and its edge, 8, 4 or 2.
    Cube { block: u32, place: u16, edge: i32 },
}

impl<const N: usize> Tree<N> {
    /// `None` where no voxel is active.
    pub fn new(volume: &Volume<N>) -> Option<Self> {
        let mut order: Vec<u32> =
            (0..volume.origins.len() as u32).filter(|block| volume.active[*block as usize] != [0; 8]).collect();
        if order.is_empty() {
            return None;
        }
        let (mut nodes, mut pending) = (vec![Node::new()], vec![Pending::Blocks(0..order.len())]);
        let mut next = 0;
        while next < pending.len() {
            let first = nodes.len() as u32;
            let here = std::mem::replace(&mut pending[next], Pending::Blocks(0..0));
            let (block, place, edge) = match here {
                Pending::Blocks(range) if range.len() == 1 => (order[range.start], 0, 8),
                Pending::Blocks(range) => {
                    octants(volume, &mut order[range.clone()], |part| {
                        pending.push(Pending::Blocks(range.start + part.start..range.start + part.end));
                    });
                    nodes.resize_with(pending.len(), Node::new);
                    nodes[next].below = Below::Nodes(first, (nodes.len() as u32 - first) as u8);
                    next += 1;
                    continue;
                }
                Pending::Cube { block, place, edge } => (block, place, edge),
            };
            if edge == 2 {
                nodes[next].below = Below::Voxels { block, place };
            } else {
                let half = edge / 2;
                let parts = (0..8).map(|i| place + voxel_offset(IVec3::new(i >> 2, i >> 1 & 1, i & 1) * half) as u16);
                let filled = parts.filter(|part| cube(volume, block, *part, half).next().is_some());
                pending.extend(filled.map(|place| Pending::Cube { block, place, edge: half }));
                nodes.resize_with(pending.len(), Node::new);
                nodes[next].below = Below::Nodes(first, (nodes.len() as u32 - first) as u8);
            }
            next += 1;
        }
        drop(pending);
        for node in (0..nodes.len()).rev() {
            sum_up(volume, &mut nodes, node);
        }
        Some(Self { range: range(volume, &nodes), nodes })
    }
}

/// The active voxels of a cube of a block: centre and value.
pub(super) fn cube<const N: usize>(
    volume: &Volume<N>,
    block: u32,
    place: u16,
    edge: i32,
) -> impl Iterator<Item = (IVec3, [f32; N])> + use<'_, N> {
    let block = block as usize;
    let (origin, mask, values) = (volume.origins[block], &volume.active[block], &volume.values[block]);
    let corner = IVec3::new(i32::from(place >> 6), i32::from(place >> 3 & 7), i32::from(place & 7));
    let steps = (0..edge).flat_map(move |x| (0..edge).flat_map(move |y| (0..edge).map(move |z| IVec3::new(x, y, z))));
    steps.filter_map(move |step| {
        let offset = voxel_offset(corner + step);
        is_active(mask, offset).then(|| (origin + corner + step, values[offset]))
    })
}

/// Sorts blocks by the octants of the least aligned cube that holds them all, and tells each octant's share.
fn octants<const N: usize>(volume: &Volume<N>, order: &mut [u32], mut tell: impl FnMut(Range<usize>)) {
    let origin = |block: u32| volume.origins[block as usize];
    let first = origin(order[0]);
    // The highest bit in which any two differ; of the sign too, so cubes never straddle 0.
    let differing = order.iter().fold(IVec3::ZERO, |bits, block| bits | (origin(*block) ^ first));
    let level = (differing.x | differing.y | differing.z).leading_zeros();
    let octant = |block: &u32| {
        let bit = |coordinate: i32| (coordinate as u32) << level >> 31;
        let origin = origin(*block);
        bit(origin.x) << 2 | bit(origin.y) << 1 | bit(origin.z)
    };
    order.sort_by_key(octant);
    let mut start = 0;
    for part in order.chunk_by(|a, b| octant(a) == octant(b)) {
        tell(start..start + part.len());
        start += part.len();
    }
}

/// Fills a node from what it is made of.
fn sum_up<const N: usize>(volume: &Volume<N>, nodes: &mut [Node<N>], node: usize) {
    match nodes[node].below {
        Below::Voxels { block, place } => {
            let mut sum = Sum::new();
            cube(volume, block, place, 2)
                .for_each(|(voxel, value)| sum.count(voxel, voxel, 1.0, voxel.as_dvec3(), value));
            let mut whole = sum.node();
            for (voxel, value) in cube(volume, block, place, 2) {
                whole.shift(1.0, voxel.as_dvec3(), value, [[0.0; 3]; N], 0.0);
            }
            nodes[node] = Node { below: nodes[node].below, ..whole };
        }
        Below::Nodes(first, count) => {
            let (above, behind) = nodes.split_at_mut(first as usize);
            let parts = &behind[..usize::from(count)];
            let mut sum = Sum::new();
            parts.iter().for_each(|part| sum.count(part.low, part.high, part.count, part.centroid, part.value));
            let mut whole = sum.node();
            parts.iter().for_each(|part| whole.shift(part.count, part.centroid, part.value, part.dipole, part.spread));
            above[node] = Node { below: above[node].below, ..whole };
        }
    }
}

/// Count, box, centroid and value, before what is around the centroid.
struct Sum<const N: usize> {
    low: IVec3,
    high: IVec3,
    count: f64,
    position: DVec3,
    value: [f64; N],
}

impl<const N: usize> Sum<N> {
    fn new() -> Self {
        Self { low: IVec3::MAX, high: IVec3::MIN, count: 0.0, position: DVec3::ZERO, value: [0.0; N] }
    }

    fn count(&mut self, low: IVec3, high: IVec3, count: f32, centroid: DVec3, value: [f32; N]) {
        (self.low, self.high) = (self.low.min(low), self.high.max(high));
        self.count += f64::from(count);
        self.position += f64::from(count) * centroid;
        self.value.iter_mut().zip(value).for_each(|(sum, value)| *sum += f64::from(value));
    }

    fn node(&self) -> Node<N> {
        Node {
            low: self.low,
            high: self.high,
            count: self.count as f32,
            centroid: self.position / self.count,
            value: self.value.map(|value| value as f32),
            ..Node::new()
        }
    }
}

impl<const N: usize> Node<N> {
    fn new() -> Self {
        Self {
            low: IVec3::ZERO,
            high: IVec3::ZERO,
            count: 0.0,
            centroid: DVec3::ZERO,
            value: [0.0; N],
            dipole: [[0.0; 3]; N],
            spread: 0.0,
            below: Below::Nodes(0, 0),
        }
    }

    /// Adds a part's sums around its own centroid, moved to this one's.
    fn shift(&mut self, count: f32, centroid: DVec3, value: [f32; N], dipole: [[f32; 3]; N], spread: f32) {
        let step = centroid - self.centroid;
        for number in 0..N {
            for axis in 0..3 {
                self.dipole[number][axis] += dipole[number][axis] + value[number] * step[axis] as f32;
            }
        }
        self.spread += spread + count * step.length_squared() as f32;
    }
}

fn range<const N: usize>(volume: &Volume<N>, nodes: &[Node<N>]) -> [[f32; N]; 2] {
    let mut range = [[f32::INFINITY; N], [f32::NEG_INFINITY; N]];
    for node in nodes {
        let Below::Voxels { block, place } = node.below else { continue };
        for (_, value) in cube(volume, block, place, 2) {
            for number in 0..N {
                range[0][number] = range[0][number].min(value[number]);
                range[1][number] = range[1][number].max(value[number]);
            }
        }
    }
    range
}
