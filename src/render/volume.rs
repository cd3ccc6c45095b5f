//! Finding and sampling the blocks of a band by position: a table of tables as in OpenVDB's tree (4096³, 128³ and
//! 8³ voxels), so that any place is found in three steps and empty space is left in strides of its own size.
//!
//! Positions here are voxel (index) positions; distances stay in world units.

use std::collections::HashMap;

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, Band, Channel, block_origin, is_active, node_origin, voxel_offset};

/// A root table spans this many voxels each way.
pub(super) const ROOT_EDGE: i32 = 4096;
/// A middle table spans this many voxels each way.
const NODE_EDGE: i32 = 128;
/// The code of a cell outside the solid, without blocks.
const OUTSIDE: u32 = u32::MAX;
/// The code of a cell inside the solid, without blocks. Codes below are indices.
const INSIDE: u32 = u32::MAX - 1;

/// What stands in a cell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Content {
    /// Nothing, up to the cell's border.
    Outside,
    /// Solid, up to the cell's border.
    Inside,
    /// The block of this index.
    Block(usize),
}

/// The largest cell around a voxel that holds one kind of content.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Cell {
    /// What stands in it.
    pub content: Content,
    /// Its least corner.
    pub origin: IVec3,
    /// Its edge in voxels.
    pub edge: i32,
}

/// What stands in two by two by two blocks (bit 2: +x, bit 1: +y, bit 0: +z).
struct Around {
    /// The origin of the last of them.
    border: IVec3,
    contents: [Content; 8],
}

impl Around {
    /// What stands at a voxel in one of them.
    fn content(&self, voxel: IVec3) -> Content {
        let bits = voxel.cmpge(self.border).bitmask() as usize;
        // A mask has x in its lowest bit.
        self.contents[(bits & 1) << 2 | bits & 2 | bits >> 2]
    }
}

/// A band with the tables to find its blocks by position.
pub(super) struct Volume<'a> {
    band: &'a Band,
    background: f32,
    /// The least corners of the 4096³ nodes that hold anything, sorted by their components.
    roots: Vec<IVec3>,
    /// For each root a code, or the index of its table in `middles`.
    root_codes: Vec<u32>,
    middles: Vec<Vec<u32>>,
    lowers: Vec<Vec<u32>>,
    /// For each block, the codes at its origin plus 0 or 8 voxels on each axis (bit 2: x, bit 1: y, bit 0: z): the
    /// blocks that interpolation in it reads.
    corners: Vec<[u32; 8]>,
    /// For each block, which of its 4³ parts of 2³ cells may hold solid: part (x, y, z) is bit 16x + 4y + z.
    solid: Vec<u64>,
    /// The index box of everything: least corner, and one past the greatest.
    extent: (IVec3, IVec3),
}

impl<'a> Volume<'a> {
    /// Builds the tables; a few per cent of the memory of the band itself.
    pub(super) fn new(band: &'a Band) -> Self {
        let mut volume = Self {
            band,
            background: band.background(),
            roots: Vec::new(),
            root_codes: Vec::new(),
            middles: Vec::new(),
            lowers: Vec::new(),
            corners: Vec::new(),
            solid: Vec::new(),
            extent: (IVec3::MAX, IVec3::MIN),
        };
        volume.insert_all();
        volume.corners = band.origins.par_iter().map(|&origin| volume.corner_codes(origin)).collect();
        volume.solid = (0..band.origins.len()).into_par_iter().map(|block| volume.solid_parts(block)).collect();
        volume
    }

    fn insert_all(&mut self) {
        let band = self.band;
        let cells = || {
            let tiles = band.inside_tiles.iter().map(|tile| (tile.origin, tile.edge, INSIDE));
            tiles.chain(band.origins.iter().enumerate().map(|(index, &origin)| (origin, BLOCK_EDGE, index as u32)))
        };
        let mut roots: Vec<IVec3> = cells().map(|(origin, ..)| node_origin(origin, ROOT_EDGE)).collect();
        roots.sort_unstable_by_key(|root| root.to_array());
        roots.dedup();
        let places: HashMap<IVec3, usize> = roots.iter().enumerate().map(|(place, &root)| (root, place)).collect();
        self.root_codes = vec![OUTSIDE; roots.len()];
        self.roots = roots;
        for (origin, edge, code) in cells() {
            self.extent.0 = self.extent.0.min(origin);
            self.extent.1 = self.extent.1.max(origin.saturating_add(IVec3::splat(edge)));
            let root = &mut self.root_codes[places[&node_origin(origin, ROOT_EDGE)]];
            if edge >= ROOT_EDGE {
                *root = code;
                continue;
            }
            let middle = &mut open(&mut self.middles, root, 32)[place(origin, ROOT_EDGE, NODE_EDGE)];
            if edge >= NODE_EDGE {
                *middle = code;
                continue;
            }
            open(&mut self.lowers, middle, 16)[place(origin, NODE_EDGE, BLOCK_EDGE)] = code;
        }
    }

    fn corner_codes(&self, origin: IVec3) -> [u32; 8] {
        std::array::from_fn(|corner| {
            let bit = |axis: usize| (corner >> axis & 1) as i32 * BLOCK_EDGE;
            match self.cell(origin.saturating_add(IVec3::new(bit(2), bit(1), bit(0)))).content {
                Content::Outside => OUTSIDE,
                Content::Inside => INSIDE,
                Content::Block(index) => index as u32,
            }
        })
    }

    /// The index box of everything: least corner, and one past the greatest. Empty where the band is.
    pub(super) fn extent(&self) -> (DVec3, DVec3) {
        (self.extent.0.as_dvec3(), self.extent.1.as_dvec3())
    }

    /// The least corners of the 4096³ nodes that hold anything.
    pub(super) fn roots(&self) -> &[IVec3] {
        &self.roots
    }

    /// A voxel's edge in world units.
    pub(super) fn voxel_size(&self) -> f64 {
        self.band.lattice.voxel_size.get()
    }

    /// What stands around a voxel.
    pub(super) fn cell(&self, voxel: IVec3) -> Cell {
        let filled = |code: u32, edge: i32| {
            let content = if code == INSIDE { Content::Inside } else { Content::Outside };
            Cell { content, origin: node_origin(voxel, edge), edge }
        };
        let root = node_origin(voxel, ROOT_EDGE);
        let Ok(place_of_root) = self.roots.binary_search_by_key(&root.to_array(), |root| root.to_array()) else {
            return filled(OUTSIDE, ROOT_EDGE);
        };
        let code = self.root_codes[place_of_root];
        if code >= INSIDE {
            return filled(code, ROOT_EDGE);
        }
        let code = self.middles[code as usize][place(voxel, ROOT_EDGE, NODE_EDGE)];
        if code >= INSIDE {
            return filled(code, NODE_EDGE);
        }
        let code = self.lowers[code as usize][place(voxel, NODE_EDGE, BLOCK_EDGE)];
        if code >= INSIDE {
            return filled(code, BLOCK_EDGE);
        }
        Cell { content: Content::Block(code as usize), origin: block_origin(voxel), edge: BLOCK_EDGE }
    }

    /// The distance at a voxel, world units, positive inside; ± the background away from all blocks.
    pub(super) fn value(&self, voxel: IVec3) -> f32 {
        self.value_of(self.cell(voxel).content, voxel)
    }

    fn value_of(&self, content: Content, voxel: IVec3) -> f32 {
        match content {
            Content::Outside => -self.background,
            Content::Inside => self.background,
            Content::Block(index) => self.band.distances[index][voxel_offset(voxel)],
        }
    }

    /// What stands in the blocks that the 4³ voxels from `least − 1` on lie in.
    fn around(&self, least: IVec3) -> Around {
        let (low, high) = (least.saturating_sub(IVec3::ONE), least.saturating_add(IVec3::splat(2)));
        let border = block_origin(high);
        // An axis along which all lie in one block needs no second look.
        let over = border.cmpgt(block_origin(low));
        let mut contents = [Content::Outside; 8];
        for corner in 0..8 {
            let step = corner_step(corner);
            let repeated = step.cmpgt(IVec3::ZERO) & !over;
            contents[corner] = if repeated.any() {
                let other = IVec3::select(repeated, IVec3::ZERO, step);
                contents[(other.x * 4 + other.y * 2 + other.z) as usize]
            } else {
                self.cell(IVec3::select(step.cmpgt(IVec3::ZERO), high, low)).content
            };
        }
        Around { border, contents }
    }
    /// The interpolated distance at an index position, world units, positive inside.
    pub(super) fn distance(&self, position: DVec3) -> f64 {
        let least = voxel_below(position);
        let corners = std::array::from_fn(|corner| self.value(least.saturating_add(corner_step(corner))));
        interpolate(&corners, position - least.as_dvec3())
    }

    /// The cells that may hold solid: least corner and edge.
    pub(super) fn solid_cells(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let blocks = self.band.origins.iter().zip(&self.solid).filter(|(_, parts)| **parts != 0);
        let blocks = blocks.map(|(origin, _)| (origin.as_dvec3(), f64::from(BLOCK_EDGE)));
        blocks.chain(self.band.inside_tiles.iter().map(|tile| (tile.origin.as_dvec3(), f64::from(tile.edge))))
    }

    /// Whether interpolation in a part of a block, 2³ cells around this one, may give solid.
    pub(super) fn may_be_solid(&self, block: usize, cell: IVec3) -> bool {
        let part = cell / 2;
        self.solid[block] >> (part.x * 16 + part.y * 4 + part.z) & 1 == 1
    }

    /// Whether a block holds no solid at all.
    pub(super) fn is_hollow(&self, block: usize) -> bool {
        self.solid[block] == 0
    }

    /// The parts of a block that may hold solid: those with a voxel of it at one of their 3³ corners.
    fn solid_parts(&self, block: usize) -> u64 {
        let mut parts = 0;
        for x in 0..=BLOCK_EDGE {
            for y in 0..=BLOCK_EDGE {
                let inside = |z: i32| u64::from(self.near_value(block, IVec3::new(x, y, z)) >= 0.0) << z;
                let row = (0..=BLOCK_EDGE).fold(0, |row, z| row | inside(z));
                let of_row = (0..4).fold(0, |of_row, z| of_row | u64::from(row >> (2 * z) & 7 != 0) << z);
                // A plane of corners between two parts is of both.
                let parts_at = |place: i32| (place - 1).max(0) / 2..=(place / 2).min(3);
                for part_x in parts_at(x) {
                    for part_y in parts_at(y) {
                        parts |= of_row << (part_x * 16 + part_y * 4);
                    }
                }
            }
        }
        parts
    }

    /// The value at a voxel of a block or next to it; `local` is its place in the block, 0 to 8 on each axis.
    fn near_value(&self, block: usize, local: IVec3) -> f32 {
        if local.max_element() < BLOCK_EDGE {
            return self.band.distances[block][voxel_offset(local)];
        }
        let over = local / BLOCK_EDGE;
        match self.corners[block][(over.x * 4 + over.y * 2 + over.z) as usize] {
            OUTSIDE => -self.background,
            INSIDE => self.background,
            index => self.band.distances[index as usize][voxel_offset(local)],
        }
    }

    /// The distances at the eight corners of a cell of a block (bit 2: +x, bit 1: +y, bit 0: +z); `local` is the
    /// cell's least corner in the block, 0 to 7 on each axis.
    pub(super) fn corner_values(&self, block: usize, local: IVec3) -> [f32; 8] {
        let offset = voxel_offset(local);
        if local.max_element() < BLOCK_EDGE - 1 {
            let values: &[f32; BLOCK_VOXELS] = &self.band.distances[block];
            return std::array::from_fn(|corner| values[offset + CORNER_OFFSETS[corner]]);
        }
        std::array::from_fn(|corner| self.near_value(block, local + corner_step(corner)))
    }

    /// The gradient at an index position, in voxel steps: central differences at the eight voxels around it,
    /// interpolated, so that it turns smoothly from cell to cell. Points inward.
    pub(super) fn gradient(&self, position: DVec3) -> DVec3 {
        let least = voxel_below(position);
        let base = least.as_dvec3();
        let around = self.around(least);
        // The 4³ voxels around the cell; its corners are entries 1 and 2 on each axis.
        let mut values = [[[0.0_f32; 4]; 4]; 4];
        for (x, plane) in values.iter_mut().enumerate() {
            for (y, row) in plane.iter_mut().enumerate() {
                for (z, value) in row.iter_mut().enumerate() {
                    // The stencil's own corners and edges are never read.
                    let rim = [x, y, z].into_iter().filter(|&place| place == 0 || place == 3).count();
                    if rim < 2 {
                        let voxel = least.saturating_add(IVec3::new(x as i32, y as i32, z as i32) - 1);
                        *value = self.value_of(around.content(voxel), voxel);
                    }
                }
            }
        }
        let weights = corner_weights(position - base);
        let mut gradient = DVec3::ZERO;
        for (corner, weight) in weights.into_iter().enumerate() {
            let step = corner_step(corner);
            let (x, y, z) = (1 + step.x as usize, 1 + step.y as usize, 1 + step.z as usize);
            let slope = DVec3::new(
                f64::from(values[x + 1][y][z] - values[x - 1][y][z]),
                f64::from(values[x][y + 1][z] - values[x][y - 1][z]),
                f64::from(values[x][y][z + 1] - values[x][y][z - 1]),
            );
            gradient += slope * (0.5 * weight);
        }
        gradient
    }

    /// A channel's colour at an index position, interpolated over those of the eight voxels around it that have
    /// one; the channel's background where none has.
    pub(super) fn colour(&self, channel: &Channel<[f32; 3]>, position: DVec3) -> [f32; 3] {
        let least = voxel_below(position);
        let base = least.as_dvec3();
        let around = self.around(least);
        let mut sum = [0.0_f64; 3];
        let mut total = 0.0;
        for (corner, weight) in corner_weights(position - base).into_iter().enumerate() {
            let voxel = least.saturating_add(corner_step(corner));
            let Content::Block(index) = around.content(voxel) else { continue };
            let offset = voxel_offset(voxel);
            let active = self.band.active.get(index).filter(|active| is_active(active, offset));
            let Some(active) = active.filter(|_| index < channel.values.len()) else { continue };
            for (sum, value) in sum.iter_mut().zip(channel.at(index, active, offset)) {
                *sum += weight * f64::from(value);
            }
            total += weight;
        }
        // Weights below this are rounding: dividing by them would invent a colour.
        if total > 1e-6 { sum.map(|sum| (sum / total) as f32) } else { channel.background }
    }
}

/// The voxel at or below an index position on each axis; at the ends of the indices where it lies beyond them.
/// (Without the processor's own rounding, which the oldest x86 lacks, `floor` is a call.)
pub(super) fn voxel_below(position: DVec3) -> IVec3 {
    let towards_zero = position.as_ivec3();
    let below = |truncated: i32, exact: f64| truncated.saturating_sub(i32::from(f64::from(truncated) > exact));
    IVec3::new(below(towards_zero.x, position.x), below(towards_zero.y, position.y), below(towards_zero.z, position.z))
}

/// Trilinear interpolation between corner values at a position in the cell, 0 to 1 on each axis.
pub(super) fn interpolate(corners: &[f32; 8], at: DVec3) -> f64 {
    let c = |corner: usize| f64::from(corners[corner]);
    let along_z = |low: usize| c(low) + (c(low + 1) - c(low)) * at.z;
    let along_y = |low: usize| {
        let (near, far) = (along_z(low), along_z(low + 2));
        near + (far - near) * at.y
    };
    let (near, far) = (along_y(0), along_y(4));
    near + (far - near) * at.x
}

/// The interpolation weights of the eight corners at a position in the cell.
fn corner_weights(at: DVec3) -> [f64; 8] {
    std::array::from_fn(|corner| {
        let weight = |axis: usize, along: f64| if corner >> axis & 1 == 1 { along } else { 1.0 - along };
        weight(2, at.x) * weight(1, at.y) * weight(0, at.z)
    })
}

/// A corner's place in its cell, 0 or 1 on each axis.
fn corner_step(corner: usize) -> IVec3 {
    IVec3::new((corner >> 2 & 1) as i32, (corner >> 1 & 1) as i32, (corner & 1) as i32)
}

/// What a corner's place adds to a voxel's offset in its block.
const CORNER_OFFSETS: [usize; 8] = [0, 1, 8, 9, 64, 65, 72, 73];

/// The place, in the table of a node of edge `node`, of the child of edge `child` around a voxel.
fn place(voxel: IVec3, node: i32, child: i32) -> usize {
    let local = (voxel & IVec3::splat(node - 1)) / child;
    let across = node / child;
    ((local.x * across + local.y) * across + local.z) as usize
}

/// The table behind a code; a code that is not yet a table becomes one, filled with what it said before.
fn open<'t>(tables: &'t mut Vec<Vec<u32>>, code: &mut u32, across: usize) -> &'t mut Vec<u32> {
    if *code >= INSIDE {
        tables.push(vec![*code; across * across * across]);
        *code = (tables.len() - 1) as u32;
    }
    &mut tables[*code as usize]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::{InsideTile, Lattice, VoxelSize, testing::sphere};

    #[test]
    fn interpolation_gives_back_a_linear_function() {
        let plane = |p: DVec3| 0.25 + 0.5 * p.x - 0.125 * p.y + p.z;
        let corners = std::array::from_fn(|corner| plane(corner_step(corner).as_dvec3()) as f32);
        for at in [DVec3::ZERO, DVec3::ONE, DVec3::new(0.3, 0.9, 0.1)] {
            assert!((interpolate(&corners, at) - plane(at)).abs() < 1e-12);
        }
    }

    #[test]
    fn cells_of_every_size_are_found() {
        let lattice = Lattice { voxel_size: VoxelSize::new(1.0).unwrap() };
        let tile = |origin, edge| InsideTile { origin, edge };
        let band = Band {
            lattice,
            half_width: 3.0,
            origins: vec![IVec3::new(-8, 0, 0)],
            distances: vec![[0.5; BLOCK_VOXELS]],
            active: vec![[u64::MAX; 8]],
            inside_tiles: vec![
                tile(IVec3::new(-4096, -4096, -4096), 4096),
                tile(IVec3::new(-128, 128, 0), 128),
                tile(IVec3::new(8, 16, 24), 8),
            ],
        };
        let volume = Volume::new(&band);
        let found = |x, y, z| volume.cell(IVec3::new(x, y, z));
        let cell = |content, x, y, z, edge| Cell { content, origin: IVec3::new(x, y, z), edge };
        assert_eq!(found(-1, 7, 3), cell(Content::Block(0), -8, 0, 0, 8));
        assert_eq!(found(-9, 7, 3), cell(Content::Outside, -16, 0, 0, 8));
        assert_eq!(found(-1, 255, 127), cell(Content::Inside, -128, 128, 0, 128));
        assert_eq!(found(9, 17, 31), cell(Content::Inside, 8, 16, 24, 8));
        assert_eq!(found(-1, -1, -1), cell(Content::Inside, -4096, -4096, -4096, 4096));
        assert_eq!(found(500, 0, 0), cell(Content::Outside, 384, 0, 0, 128));
        assert_eq!(found(0, 5000, 0), cell(Content::Outside, 0, 4096, 0, 4096));
        assert_eq!(volume.value(IVec3::new(9, 17, 31)), 3.0);
        assert_eq!(volume.value(IVec3::new(-3, 2, 1)), 0.5);
    }

    #[test]
    fn the_gradient_of_a_sphere_points_to_its_centre() {
        let band = sphere(DVec3::new(0.1, -0.2, 0.3), 1.0, 0.05);
        let volume = Volume::new(&band);
        for direction in [DVec3::X, DVec3::new(1.0, -2.0, 0.5).normalize(), DVec3::NEG_ONE.normalize()] {
            let position = (DVec3::new(0.1, -0.2, 0.3) + direction) / 0.05;
            let gradient = volume.gradient(position) / 0.05;
            assert!((gradient + direction).length() < 2e-3, "{gradient} at {direction}");
        }
    }
}
