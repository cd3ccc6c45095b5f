//! An octree over the active voxels of a volume, down to cubes of 4³.

use std::ops::Range;

use glam::IVec3;

use super::Volume;
use crate::grid::voxel_offset;

/// The nodes, the root first, a node's children side by side and behind it.
pub(super) struct Tree {
    pub nodes: Vec<Node>,
}

/// Memory of a node.
pub(super) const BYTES_A_NODE: u64 = size_of::<Node>() as u64;

/// The edge of the least cubes.
pub(super) const EDGE: i32 = 4;

/// How many of them are in a block.
pub(super) const CUBES_A_BLOCK: u64 = 8;

/// Active voxels that stand together.
pub(super) struct Node {
    /// The least and the greatest centre of its voxels.
    pub low: IVec3,
    pub high: IVec3,
    pub below: Below,
}

/// What a node is made of.
#[derive(Clone, Copy)]
pub(super) enum Below {
    /// Nodes, and how many.
    Nodes(u32, u8),
    /// The active voxels of the 4³ at this place of a block.
    Voxels { block: u32, place: u16 },
}

impl Tree {
    /// `None` where no voxel is active.
    pub fn new<const N: usize>(volume: &Volume<N>) -> Option<Self> {
        let mut order: Vec<u32> =
            (0..volume.origins.len() as u32).filter(|block| volume.active[*block as usize] != [0; 8]).collect();
        if order.is_empty() {
            return None;
        }
        let mut nodes = vec![Node::new()];
        // Blocks of a node, as places in the order; `None` for cubes, which have none below.
        let mut pending = vec![Some(0..order.len())];
        let mut next = 0;
        while next < pending.len() {
            if let Some(range) = pending[next].take() {
                let first = nodes.len() as u32;
                if range.len() == 1 {
                    let block = order[range.start];
                    let steps = (0..8).map(|i| IVec3::new(i >> 2, i >> 1 & 1, i & 1) * EDGE);
                    let places = steps.map(|step| voxel_offset(step) as u16);
                    nodes.extend(
                        places
                            .filter(|place| bits(volume, block, *place) != 0)
                            .map(|place| Node { below: Below::Voxels { block, place }, ..Node::new() }),
                    );
                    pending.resize(nodes.len(), None);
                } else {
                    octants(volume, &mut order[range.clone()], |part| {
                        pending.push(Some(range.start + part.start..range.start + part.end));
                    });
                    nodes.resize_with(pending.len(), Node::new);
                }
                nodes[next].below = Below::Nodes(first, (nodes.len() as u32 - first) as u8);
            }
            next += 1;
        }
        drop(pending);
        for node in (0..nodes.len()).rev() {
            let (low, high) = match nodes[node].below {
                Below::Voxels { block, place } => around(cube(volume, block, place).map(|(voxel, _)| (voxel, voxel))),
                Below::Nodes(first, count) => {
                    let children = &nodes[first as usize..][..usize::from(count)];
                    around(children.iter().map(|child| (child.low, child.high)))
                }
            };
            (nodes[node].low, nodes[node].high) = (low, high);
        }
        Some(Self { nodes })
    }
}

/// The box around boxes.
fn around(boxes: impl Iterator<Item = (IVec3, IVec3)>) -> (IVec3, IVec3) {
    boxes.fold((IVec3::MAX, IVec3::MIN), |(low, high), next| (low.min(next.0), high.max(next.1)))
}

/// Which voxels of the 4³ at a place of a block are active: a bit each, by x, then y, then z, from the lowest.
pub(super) fn bits<const N: usize>(volume: &Volume<N>, block: u32, place: u16) -> u64 {
    let rows = (0..16).map(|row| {
        let offset = place + (row >> 2 << 6) + ((row & 3) << 3);
        (volume.active[block as usize][usize::from(offset >> 6)] >> (offset & 63) & 15) << (row * 4)
    });
    rows.fold(0, |bits, row| bits | row)
}

/// Whether all voxels of the 4³ at a place of a block are active.
pub(super) fn is_full<const N: usize>(volume: &Volume<N>, block: u32, place: u16) -> bool {
    bits(volume, block, place) == u64::MAX
}

/// The centre of the voxel at a place of a block.
pub(super) fn centre<const N: usize>(volume: &Volume<N>, block: u32, place: u16) -> IVec3 {
    let step = IVec3::new(i32::from(place >> 6), i32::from(place >> 3 & 7), i32::from(place & 7));
    volume.origins[block as usize] + step
}

/// The active voxels of the 4³ at a place of a block: centre and value.
pub(super) fn cube<const N: usize>(
    volume: &Volume<N>,
    block: u32,
    place: u16,
) -> impl Iterator<Item = (IVec3, [f32; N])> + use<'_, N> {
    let mut left = bits(volume, block, place);
    std::iter::from_fn(move || {
        let bit = (left != 0).then(|| left.trailing_zeros() as u16)?;
        left &= left - 1;
        let offset = place + (bit >> 4 << 6) + ((bit >> 2 & 3) << 3) + (bit & 3);
        Some((centre(volume, block, offset), volume.values[block as usize][usize::from(offset)]))
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

impl Node {
    fn new() -> Self {
        Self { low: IVec3::ZERO, high: IVec3::ZERO, below: Below::Nodes(0, 0) }
    }
}
