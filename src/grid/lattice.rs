//! Where voxels stand in the world. The world's origin is a voxel centre.

use glam::{DVec3, IVec3};

use super::BLOCK_EDGE;

/// A voxel's edge, in world units: finite and positive.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct VoxelSize(f64);

impl VoxelSize {
    /// The edge, or `None` where it is not a finite positive number.
    pub fn new(edge: f64) -> Option<Self> {
        (edge.is_finite() && edge > 0.0).then_some(Self(edge))
    }

    /// The edge in world units.
    pub fn get(self) -> f64 {
        self.0
    }
}

/// Uniform cubic voxels whose centres are at integer multiples of the voxel size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice {
    /// A voxel's edge.
    pub voxel_size: VoxelSize,
}

impl Lattice {
    /// The world position of a voxel's centre.
    pub fn centre(&self, voxel: IVec3) -> DVec3 {
        voxel.as_dvec3() * self.voxel_size.get()
    }

    /// The voxel whose centre is nearest to a world position.
    pub fn nearest(&self, position: DVec3) -> IVec3 {
        (position / self.voxel_size.get()).round().as_ivec3()
    }
}

/// The least corner of the leaf block that holds a voxel.
pub fn block_origin(voxel: IVec3) -> IVec3 {
    node_origin(voxel, BLOCK_EDGE)
}

/// The least corner of the node of that edge, a power of two, that holds a voxel.
pub fn node_origin(voxel: IVec3, edge: i32) -> IVec3 {
    voxel & IVec3::splat(!(edge - 1))
}

/// A voxel's place in its block's arrays: `x·64 + y·8 + z` of its offsets, as OpenVDB orders a leaf.
pub fn voxel_offset(voxel: IVec3) -> usize {
    let local = voxel & IVec3::splat(BLOCK_EDGE - 1);
    (local.x * 64 + local.y * 8 + local.z) as usize
}

/// The sort key of a block: blocks of one 4096³ node stand together, in it those of one 128³ node, as OpenVDB's
/// tree holds them. One number, which compares faster than the corners of the nodes.
pub fn block_order(origin: IVec3) -> u128 {
    // Less stays less where the sign's bit is turned.
    let place = origin.to_array().map(|along| (along as u32) ^ (1 << 31));
    [(12, 20), (7, 5), (0, 7)].into_iter().fold(0, |key, (start, width)| {
        place.iter().fold(key, |key, along| key << width | u128::from(along >> start & ((1 << width) - 1)))
    })
}

/// Where a block is in a list in the order of blocks, or would be.
pub fn place_of(blocks: &[IVec3], origin: IVec3) -> Result<usize, usize> {
    blocks.binary_search_by_key(&block_order(origin), |&other| block_order(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_and_offsets_of_negative_voxels() {
        assert_eq!(block_origin(IVec3::new(-1, 0, 8)), IVec3::new(-8, 0, 8));
        assert_eq!(voxel_offset(IVec3::new(-1, 0, 9)), 7 * 64 + 1);
    }

    #[test]
    fn blocks_are_in_the_order_of_their_nodes() {
        let corners = [-(1 << 30), -4104, -4096, -136, -128, -8, 0, 8, 120, 128, 4088, 4096, (1 << 30) - 8];
        let mut all = Vec::new();
        for x in corners {
            for y in corners {
                all.extend(corners.map(|z| IVec3::new(x, y, z)));
            }
        }
        let nodes = |origin: IVec3| [4096, 128, 1].map(|edge| (origin & IVec3::splat(!(edge - 1))).to_array());
        for pair in all.windows(2).map(|pair| [pair[0], pair[1]]).chain(all.iter().map(|&one| [one, all[77]])) {
            let [before, after] = pair.map(block_order);
            assert_eq!(before.cmp(&after), nodes(pair[0]).cmp(&nodes(pair[1])), "{pair:?}");
        }
    }

    #[test]
    fn voxel_size_is_finite_and_positive() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert_eq!(VoxelSize::new(bad), None);
        }
    }
}
