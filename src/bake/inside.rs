//! Attributes and a density through all of the inside, where the band alone is not enough: to be cut open, and for fog.

use std::borrow::Cow;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use super::asked::{Attributes, ComputeError};
use super::survey::survey;
use crate::attribute::{Attribute, LinearRgb, Sampler};
use crate::distance::band;
use crate::field::{Aabb, BATCH, Field, Points};
use crate::grid::{
    BLOCK_EDGE, BLOCK_VOXELS, Band, BlockMask, Channel, InsideTile, Lattice, block_order, mask, node_origin, place_of,
};

/// The grid that programs show as fog.
pub const DENSITY: &str = "density";
/// The edges of OpenVDB's tiles, in voxels, which hold so many of the next along theirs.
const EDGES: [i32; 3] = [4096, 128, 8];
/// Blocks that one task samples at most, all in one node of 128 voxels.
const BLOCKS_A_TASK: usize = 64;
/// What a block takes beside its numbers: its place, its mask, and lists.
const BYTES_A_BLOCK: u64 = 160;

/// What of the inside a frame has.
#[derive(Clone, Debug)]
pub struct Insides {
    /// Colours on the band's active voxels and through the inside.
    pub colour: Option<Inside<LinearRgb>>,
    /// The scalars there, but for one that is the density.
    pub scalars: Vec<Inside<f32>>,
    /// 1 inside, and from 0 at the surface up to that as deep as the band; times the scalar of this name.
    pub density: Option<Inside<f32>>,
}

impl Insides {
    /// Voxels with a value of their own behind those of a band, in the grid that has most of them.
    pub fn behind(&self, band: &Band) -> u64 {
        let colour = self.colour.iter().map(|inside| in_blocks(&inside.active));
        let most = colour.chain(self.scalars.iter().map(|inside| in_blocks(&inside.active))).max();
        most.unwrap_or(0).saturating_sub(band.active_voxels())
    }
}

fn in_blocks(active: &[BlockMask]) -> u64 {
    active.iter().map(|mask| mask::count(mask) as u64).sum()
}

/// Bytes that the inside of a field may take: of the attributes that are not the same all over it, by samples of F at the
/// middles of so many cells along each side of its box.
pub(super) fn estimate(field: &dyn Field, region: Aabb, attributes: &Attributes<'_>, lattice: &Lattice) -> f64 {
    const CELLS: usize = 24;
    let colour = attributes.colour.map_or(0, |(_, colour)| numbers(colour, &region));
    let numbers =
        colour + attributes.scalars.iter().map(|(_, scalar)| numbers(scalar.as_ref(), &region)).sum::<usize>();
    if numbers == 0 {
        return 0.0;
    }
    let place = |i: usize| (i as f64 + 0.5) / CELLS as f64;
    let plane = |x: usize| {
        let mut evaluator = field.evaluator();
        evaluator.enter(&region);
        let mut out = [0.0; BATCH];
        let mut inside = 0;
        for y in 0..CELLS {
            let mut points = Points::new(region.min);
            for z in 0..CELLS {
                points.push((DVec3::new(place(x), place(y), place(z)) * region.size()).as_vec3());
            }
            evaluator.values(&points, &mut out);
            inside += out[..points.len].iter().filter(|value| **value >= 0.0).count();
        }
        evaluator.leave();
        inside
    };
    let inside: usize = (0..CELLS).into_par_iter().map(plane).sum();
    let volume = region.size().element_product() * inside as f64 / CELLS.pow(3) as f64;
    volume / lattice.voxel_size.get().powi(3) * (4 * numbers) as f64
}

/// How many numbers an attribute has that are not the same all over a region.
fn numbers<const N: usize>(attribute: &dyn Attribute<N>, region: &Aabb) -> usize {
    if constant(attribute.sampler().as_mut(), region).is_some() { 0 } else { N }
}

/// One grid through the inside: blocks, and tiles where it is constant.
#[derive(Clone, Debug)]
pub struct Inside<T> {
    /// The blocks' least corners, sorted as a band's.
    pub origins: Vec<IVec3>,
    /// Voxels that have a value.
    pub active: Vec<BlockMask>,
    /// The values.
    pub channel: Channel<T>,
    /// Cubes of one value each.
    pub tiles: Vec<InsideTile>,
    /// Theirs.
    pub tile_values: Vec<T>,
}

impl<T> Inside<T> {
    /// Voxels that have a value.
    pub fn active_voxels(&self) -> u64 {
        in_blocks(&self.active) + self.tiles.iter().map(voxels_of).sum::<u64>()
    }
}

impl From<Inside<[f32; 1]>> for Inside<f32> {
    fn from(one: Inside<[f32; 1]>) -> Self {
        let Inside { origins, active, channel, tiles, tile_values } = one;
        Self { origins, active, channel: channel.into(), tiles, tile_values: tile_values.into_flattened() }
    }
}

/// Why an inside is not filled.
pub(super) enum Trouble<const N: usize> {
    Cancelled,
    /// It would take so many bytes, of so many voxels.
    Memory(u64, u64),
    /// The value there is out of range.
    Wrong([f64; 3], [f32; N]),
}

impl<const N: usize> Trouble<N> {
    /// As a frame's error.
    pub fn told(self, wrong: impl FnOnce([f64; 3], [f32; N]) -> ComputeError) -> ComputeError {
        match self {
            Self::Cancelled => ComputeError::Distance(band::Error::Cancelled),
            Self::Memory(needed, voxels) => ComputeError::Memory { needed, voxels },
            Self::Wrong(position, value) => wrong(position, value),
        }
    }
}

/// What bounds the work.
#[derive(Clone, Copy)]
pub(super) struct Bounds<'a> {
    /// The most memory that one grid may take, in bytes.
    pub bytes: u64,
    /// Set to stop.
    pub cancel: &'a AtomicBool,
}

/// A block of which some voxels are to be sampled.
type Cell = (IVec3, BlockMask);

/// An attribute through the inside, with its values on the band's active voxels, which `channel` has.
pub(super) fn through<const N: usize>(
    band: &Band,
    channel: &Channel<[f32; N]>,
    attribute: &dyn Attribute<N>,
    least: f32,
    bounds: Bounds<'_>,
) -> Result<Inside<[f32; N]>, Trouble<N>> {
    let (mut tiles, mut tile_values) = (Vec::new(), Vec::new());
    let mut cells = cells_of_band(band);
    let enough = bounds.bytes / (BYTES_A_BLOCK + (BLOCK_VOXELS * N * 4) as u64);
    let mut sampler = attribute.sampler();
    let mut open: Vec<InsideTile> = band.inside_tiles.iter().rev().copied().collect();
    while let Some(tile) = open.pop() {
        if let Some(value) = constant(sampler.as_mut(), &region(tile.origin, tile.edge, &band.lattice)) {
            tiles.push(tile);
            tile_values.push(value);
        } else if tile.edge == BLOCK_EDGE {
            cells.push((tile.origin, [u64::MAX; 8]));
        } else {
            let blocks = (tile.edge / BLOCK_EDGE).pow(3) as u64;
            if cells.len() as u64 + blocks > enough {
                let voxels = band.inside_tiles.iter().map(voxels_of).sum::<u64>();
                let blocks = voxels / BLOCK_VOXELS as u64 + cells.len() as u64;
                return Err(Trouble::Memory(blocks * (BYTES_A_BLOCK + (BLOCK_VOXELS * N * 4) as u64), voxels));
            }
            open.extend(parts(tile).rev());
        }
    }
    cells.sort_unstable_by_key(|(origin, _)| block_order(*origin));
    let tasks: Vec<&[Cell]> = cells
        .chunk_by(|(one, _), (other, _)| node_origin(*one, EDGES[1]) == node_origin(*other, EDGES[1]))
        .flat_map(|node| node.chunks(BLOCKS_A_TASK))
        .collect();
    let sampled: Result<Vec<_>, Trouble<N>> = tasks
        .into_par_iter()
        .map_init(|| attribute.sampler(), |sampler, cells| sample(sampler.as_mut(), cells, band, least, bounds.cancel))
        .collect();

    let mut filled = cells.iter().zip(sampled?.into_iter().flatten()).peekable();
    let mut inside = Inside {
        origins: Vec::with_capacity(band.origins.len()),
        active: Vec::new(),
        channel: Channel { name: channel.name.clone(), values: Vec::new(), background: channel.background },
        tiles,
        tile_values,
    };
    let mut add = |origin: IVec3, mask: BlockMask, values: Box<[[f32; N]]>| {
        if values.len() == BLOCK_VOXELS && values.iter().all(|value| *value == values[0]) {
            inside.tiles.push(InsideTile { origin, edge: BLOCK_EDGE });
            inside.tile_values.push(values[0]);
            return;
        }
        inside.origins.push(origin);
        inside.active.push(mask);
        inside.channel.values.push(values);
    };
    for (block, origin) in band.origins.iter().enumerate() {
        let here = block_order(*origin);
        while let Some(((origin, mask), values)) = filled.next_if(|((cell, _), _)| block_order(*cell) < here) {
            add(*origin, *mask, values);
        }
        let (active, own) = (band.active[block], &channel.values[block]);
        match filled.next_if(|((cell, _), _)| cell == origin) {
            Some(((_, more), values)) => {
                let (mask, values) = merged((&active, own), (more, &values));
                add(*origin, mask, values);
            }
            None => add(*origin, active, own.clone()),
        }
    }
    filled.for_each(|((origin, mask), values)| add(*origin, *mask, values));
    Ok(inside)
}

/// The density of a band and what is behind it: a ramp as deep as the band, times the numbers of an attribute.
pub(super) fn density(band: &Band, of: Option<&Inside<f32>>) -> Result<Inside<f32>, ComputeError> {
    let negative =
        |voxel: IVec3, value: f32| ComputeError::Density { position: band.lattice.centre(voxel).to_array(), value };
    let (mut origins, mut active, mut values) = (Vec::new(), Vec::new(), Vec::new());
    let background = band.background();
    let one = Inside::plain(band);
    let of = of.unwrap_or(&one);
    // Where the attribute is constant over a block of the band it is a tile, and the ramp is not.
    let is_of_band = |tile: &InsideTile| tile.edge == BLOCK_EDGE && place_of(&band.origins, tile.origin).is_ok();
    let (of_band, tiles): (Vec<_>, Vec<_>) =
        of.tiles.iter().zip(&of.tile_values).partition(|(tile, _)| is_of_band(tile));
    let in_full = of_band.iter().map(|(tile, value)| (tile.origin, [u64::MAX; 8], vec![**value; BLOCK_VOXELS].into()));
    let mut blocks: Vec<(IVec3, BlockMask, Cow<'_, [f32]>)> = in_full.collect();
    let in_blocks = of.origins.iter().zip(&of.active).zip(&of.channel.values);
    blocks.extend(in_blocks.map(|((origin, active), values)| (*origin, *active, Cow::Borrowed(&values[..]))));
    blocks.sort_by_key(|(origin, ..)| block_order(*origin));
    for (origin, of_block, numbers) in &blocks {
        let distances = place_of(&band.origins, *origin).ok().map(|at| &band.distances[at]);
        let ramp = |at: usize| distances.map_or(1.0, |distances| (distances[at] / background).clamp(0.0, 1.0));
        let (mut mask, mut list) = ([0; 8], Vec::with_capacity(BLOCK_VOXELS));
        for (at, value) in mask::places(of_block).zip(numbers.iter()) {
            let share = ramp(at);
            if share > 0.0 {
                if *value < 0.0 {
                    let place = IVec3::new((at >> 6) as i32, (at >> 3 & 7) as i32, (at & 7) as i32);
                    return Err(negative(*origin + place, *value));
                }
                mask[at >> 6] |= 1 << (at & 63);
                list.push(share * value);
            }
        }
        if !list.is_empty() {
            origins.push(*origin);
            active.push(mask);
            values.push(list.into_boxed_slice());
        }
    }
    if let Some((tile, value)) = tiles.iter().find(|(_, value)| **value < 0.0) {
        return Err(negative(tile.origin, **value));
    }
    let (tiles, tile_values) = tiles.into_iter().map(|(tile, value)| (*tile, *value)).unzip();
    let channel = Channel { name: DENSITY.into(), values, background: 0.0 };
    Ok(Inside { origins, active, channel, tiles, tile_values })
}

impl Inside<f32> {
    /// 1 on the band's voxels and inside.
    fn plain(band: &Band) -> Self {
        let active: Vec<BlockMask> = band.active.iter().zip(cells_by_block(band)).map(|(a, b)| either(a, &b)).collect();
        let values = active.iter().map(|mask| vec![1.0; mask::count(mask)].into()).collect();
        let channel = Channel { name: DENSITY.into(), values, background: 0.0 };
        let (tiles, tile_values) = (band.inside_tiles.clone(), vec![1.0; band.inside_tiles.len()]);
        Self { origins: band.origins.clone(), active, channel, tiles, tile_values }
    }
}

/// The inside voxels of each block of a band that are deeper than it.
fn cells_by_block(band: &Band) -> impl Iterator<Item = BlockMask> + use<'_> {
    band.distances.iter().zip(&band.active).map(|(distances, active)| {
        let mut mask = mask::pack(&distances.map(|distance| u8::from(distance > 0.0)));
        mask.iter_mut().zip(active).for_each(|(word, active)| *word &= !active);
        mask
    })
}

fn cells_of_band(band: &Band) -> Vec<Cell> {
    band.origins.iter().copied().zip(cells_by_block(band)).filter(|(_, mask)| *mask != [0; 8]).collect()
}

fn either(a: &BlockMask, b: &BlockMask) -> BlockMask {
    std::array::from_fn(|word| a[word] | b[word])
}

/// The values of two masks that have no voxel in common.
fn merged<T: Copy>((a, of_a): (&BlockMask, &[T]), (b, of_b): (&BlockMask, &[T])) -> (BlockMask, Box<[T]>) {
    let both = either(a, b);
    let (mut of_a, mut of_b) = (of_a.iter(), of_b.iter());
    let next = |at: usize| if crate::grid::is_active(a, at) { of_a.next() } else { of_b.next() };
    let values = mask::places(&both).map(next).map(|value| *value.expect("each voxel has a value"));
    (both, values.collect())
}

/// The one value over a region, where bounds tell that there is one.
fn constant<const N: usize>(sampler: &mut dyn Sampler<N>, region: &Aabb) -> Option<[f32; N]> {
    let bounds = sampler.bounds(region);
    bounds.iter().all(|bounds| bounds.lo == bounds.hi).then(|| bounds.map(|bounds| bounds.lo as f32))
}

/// The voxel centres of a cube, with a rounding error's room around.
fn region(origin: IVec3, edge: i32, lattice: &Lattice) -> Aabb {
    const MARGIN_VOXELS: f64 = 0.01;
    let (least, greatest) = (lattice.centre(origin), lattice.centre(origin + (edge - 1)));
    Aabb::new(least, greatest).grown(MARGIN_VOXELS * lattice.voxel_size.get())
}

/// The tiles of the next size that make up one.
fn parts(tile: InsideTile) -> impl DoubleEndedIterator<Item = InsideTile> {
    let edge = EDGES[EDGES.iter().position(|edge| *edge == tile.edge).unwrap_or(1) + 1];
    let count = tile.edge / edge;
    (0..count.pow(3)).map(move |number| {
        let place = IVec3::new(number / count / count, number / count % count, number % count);
        InsideTile { origin: tile.origin + place * edge, edge }
    })
}

fn voxels_of(tile: &InsideTile) -> u64 {
    (tile.edge as u64).pow(3)
}

/// The values of the voxels of some blocks of one node.
fn sample<const N: usize>(
    sampler: &mut dyn Sampler<N>,
    cells: &[Cell],
    band: &Band,
    least: f32,
    cancel: &AtomicBool,
) -> Result<Vec<Box<[[f32; N]]>>, Trouble<N>> {
    if cancel.load(Ordering::Relaxed) {
        return Err(Trouble::Cancelled);
    }
    let lattice = &band.lattice;
    sampler.enter(&region(node_origin(cells[0].0, EDGES[1]), EDGES[1], lattice));
    let mut out = Box::new([[0.0; N]; BATCH]);
    let offsets = Points::offsets_in_block(lattice);
    let of_cell = |(origin, mask): &Cell| {
        let mut points = Points::new(Points::middle_of_block(*origin, lattice));
        for at in mask::places(mask) {
            points.push(glam::Vec3::new(offsets[at >> 6], offsets[at >> 3 & 7], offsets[at & 7]));
        }
        sampler.enter(&region(*origin, BLOCK_EDGE, lattice));
        sampler.sample(&points, &mut out);
        sampler.leave();
        let values = &out[..points.len];
        match survey(values).first_wrong(values, least) {
            Some(at) => Err(Trouble::Wrong(points.position(at).to_array(), values[at])),
            None => Ok(values.into()),
        }
    };
    let values = cells.iter().map(of_cell).collect();
    sampler.leave();
    values
}
