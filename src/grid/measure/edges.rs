//! Voxels inside that touch along an edge only.

use glam::IVec3;

use super::lookup::{Place, Surroundings};
use crate::grid::{BLOCK_EDGE, BlockMask};

/// The two steps of each diagonal of a voxel pair that shares an edge, each such pair once.
pub(super) const DIAGONALS: [(IVec3, IVec3); 6] = [
    (IVec3::X, IVec3::Y),
    (IVec3::X, IVec3::NEG_Y),
    (IVec3::X, IVec3::Z),
    (IVec3::X, IVec3::NEG_Z),
    (IVec3::Y, IVec3::Z),
    (IVec3::Y, IVec3::NEG_Z),
];

const EDGE: usize = BLOCK_EDGE as usize;

/// Which voxels are inside, of a block and of the layers around it that its [`DIAGONALS`] reach: by x from 0 and by y from −1
/// a row of bits, by z from −1.
pub(super) struct InsideRows([[u16; EDGE + 2]; EDGE + 1]);

impl InsideRows {
    /// Those of a block; `inside` tells them of each block of the band.
    pub(super) fn of(around: &Surroundings<'_>, inside: &[BlockMask]) -> Self {
        let voxels = |step: IVec3| match around.neighbour(step) {
            Place::Outside => BlockMask::default(),
            Place::Tile(_) => [u64::MAX; 8],
            Place::Voxel { block, .. } => inside[block],
        };
        let mut rows = [[0; EDGE + 2]; EDGE + 1];
        for (block_x, xs) in [(0, 0..EDGE), (1, 0..1)] {
            for (block_y, ys) in [(0, EDGE - 1..EDGE), (1, 0..EDGE), (2, 0..1)] {
                let blocks = [-1, 0, 1].map(|z| voxels(IVec3::new(block_x, block_y - 1, z)));
                for x in xs.clone() {
                    for y in ys.clone() {
                        let [before, here, behind] = blocks.map(|block| u16::from((block[x] >> (EDGE * y)) as u8));
                        let row = &mut rows[EDGE * block_x as usize + x][EDGE * block_y as usize + y + 1 - EDGE];
                        *row = before >> (EDGE - 1) | here << 1 | (behind & 1) << (EDGE + 1);
                    }
                }
            }
        }
        Self(rows)
    }

    /// The block's inside voxels that touch another one across a diagonal, the two others around the edge outside.
    pub(super) fn touching(&self, (first, second): (IVec3, IVec3)) -> BlockMask {
        let Self(rows) = self;
        std::array::from_fn(|x| {
            (0..EDGE).fold(0, |word, y| {
                let row = |step: IVec3| {
                    let [ahead, aside] = [x as i32 + step.x, y as i32 + step.y + 1].map(|place| place as usize);
                    rows[ahead][aside] >> (step.z + 1)
                };
                let touching = row(IVec3::ZERO) & !row(first) & !row(second) & row(first + second);
                word | u64::from(touching as u8) << (EDGE * y)
            })
        })
    }
}
