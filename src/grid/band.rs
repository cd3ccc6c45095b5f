//! The band: all leaf blocks around F = 0 with their distances, and what is solid behind them.

use glam::IVec3;

use super::{BLOCK_EDGE, BLOCK_VOXELS, BlockMask, Lattice, is_active, mask};

/// A cube of voxels that lies wholly inside the solid and holds no leaf blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InsideTile {
    /// Its least corner, a multiple of `edge`.
    pub origin: IVec3,
    /// Its edge in voxels: 8, 128 or 4096, the sizes of a tile in OpenVDB's tree.
    pub edge: i32,
}

impl InsideTile {
    /// The least corners of the blocks that fit in it.
    pub fn blocks(&self) -> impl Iterator<Item = IVec3> + use<> {
        let (origin, blocks) = (self.origin, self.edge / BLOCK_EDGE);
        (0..blocks.pow(3)).map(move |number| {
            origin + IVec3::new(number / blocks / blocks, number / blocks % blocks, number % blocks) * BLOCK_EDGE
        })
    }
}

/// A narrow-band distance field in leaf blocks, positive inside.
#[derive(Clone, Debug)]
pub struct Band {
    /// Where the voxels stand.
    pub lattice: Lattice,
    /// Half the band's width in voxels; the background is this times the voxel size.
    pub half_width: f32,
    /// The blocks' least corners, sorted by [`super::block_order`].
    pub origins: Vec<IVec3>,
    /// Signed distances in world units, one array a block, **positive inside**, clamped to ± the background.
    pub distances: Vec<[f32; BLOCK_VOXELS]>,
    /// Voxels nearer to the surface than the background.
    pub active: Vec<BlockMask>,
    /// Solid beyond the blocks, sorted by [`super::block_order`] of the origins.
    pub inside_tiles: Vec<InsideTile>,
}

impl Band {
    /// The distance at which the band ends, in world units.
    pub fn background(&self) -> f32 {
        (f64::from(self.half_width) * self.lattice.voxel_size.get()) as f32
    }

    /// The number of active voxels.
    pub fn active_voxels(&self) -> u64 {
        self.active.iter().map(|mask| mask::count(mask) as u64).sum()
    }
}

/// A named attribute on the active voxels of blocks: those of a [`Band`], or others.
#[derive(Clone, Debug)]
pub struct Channel<T> {
    /// The grid's name in the file, such as `Cd`.
    pub name: String,
    /// One list a block, in their order: the values of its active voxels, in the order of their places.
    pub values: Vec<Box<[T]>>,
    /// The value everywhere else.
    pub background: T,
}

impl From<Channel<[f32; 1]>> for Channel<f32> {
    fn from(Channel { name, values, background: [background] }: Channel<[f32; 1]>) -> Self {
        let values = values.into_iter().map(|block| block.into_vec().into_flattened().into()).collect();
        Self { name, values, background }
    }
}

impl<T: Copy> Channel<T> {
    /// A channel from whole blocks, of which the active voxels are taken.
    pub fn of_blocks(
        name: impl Into<String>,
        active: &[BlockMask],
        blocks: impl IntoIterator<Item = [T; BLOCK_VOXELS]>,
        background: T,
    ) -> Self {
        let of_block =
            |(mask, block): (&BlockMask, [T; BLOCK_VOXELS])| mask::places(mask).map(|at| block[at]).collect();
        Self { name: name.into(), values: active.iter().zip(blocks).map(of_block).collect(), background }
    }

    /// The value at a place of a block with these active voxels.
    pub fn at(&self, block: usize, active: &BlockMask, place: usize) -> T {
        let known = || self.values.get(block)?.get(mask::rank(active, place)).copied();
        if is_active(active, place) { known().unwrap_or(self.background) } else { self.background }
    }
}
