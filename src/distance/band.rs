//! The narrow band of a field: exact signed distances, with closest points handed to a visitor on the way.

mod chunk;
mod neighbours;
mod pass;
mod pool;

use std::{fmt, sync::atomic::AtomicBool};

use glam::{DVec3, IVec3};

use crate::{
    field::{Aabb, Field},
    grid::{BLOCK_EDGE, BLOCK_VOXELS, Band, BlockMask, Lattice, block_order, place_of},
};

use super::descent::{self, Scope};
pub use super::staged::MeasuredBlock;
use chunk::Measuring;
use pass::Pass;

/// Blocks that improve each other at once; their feet wait in memory, 11 KiB each, and twice as many: those being
/// finished and those of the next chunk. At the end of each chunk threads wait for the last of it: fewer blocks wait
/// more often, more no longer stay in the caches until they are finished.
pub(super) const CHUNK: usize = 256;

/// What to measure.
#[derive(Clone, Copy)]
pub struct Settings<'a> {
    /// Where the voxels stand.
    pub lattice: Lattice,
    /// Half the band's width, in voxels.
    pub half_width: f32,
    /// Where to look, world units: all blocks with a voxel centre in it. Grow a shape's box by the half width and a
    /// voxel, or the band is cut.
    pub region: Aabb,
    /// What the distances are to.
    pub feet: Feet,
    /// Set it to stop: the result is then [`Error::Cancelled`].
    pub cancel: &'a AtomicBool,
    /// Told the share done, from 0 to 1, now and then.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

/// What a band's distances are to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feet {
    /// To the nearest point of the surface.
    Nearest,
    /// To first order, |F|/|∇F|, in a fraction of the time: for pictures. The sign is right everywhere, and the surface where
    /// it is smooth; at edges it may be off by a part of a voxel. Nothing is told of features thinner than a voxel.
    FirstOrder,
}

/// What to tell the user about a band that was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Blocks evaluated.
    pub opened_blocks: u64,
    /// Blocks that hold a piece of the band.
    pub band_blocks: u64,
    /// Where features are thinner than a voxel, block by block.
    pub thin: Vec<Thin>,
    /// What was left out of the solid by its size.
    pub dropped: Dropped,
    /// Inside voxels on the faces of the region: least x, greatest x, least y, … Not zero: the solid is cut there.
    pub cut_voxels: [u64; 6],
}

/// Pieces that were left out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dropped {
    /// How many.
    pub pieces: u32,
    /// Their share of the volume of all.
    pub share: f64,
}

/// Voxels of a block beside features thinner than a voxel: with the same sign all around them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thin {
    /// The block's least corner.
    pub origin: IVec3,
    /// How many there are.
    pub voxels: u32,
    /// Where one of them is, world units.
    pub at: DVec3,
    /// About how thick the feature is there, world units; 0 where that is not known.
    pub size: f64,
}

/// A measured band, what the visitors made of its blocks (in the band's order), and what to tell about it.
#[derive(Clone, Debug)]
pub struct Measured<T> {
    /// The band.
    pub band: Band,
    /// One visit's result a block.
    pub visits: Vec<T>,
    /// Counts and warnings.
    pub report: Report,
}

impl<T> Measured<T> {
    /// Puts a block of the band in its place, or in that of what was known of it. Whether nothing was.
    pub(super) fn put(&mut self, origin: IVec3, distances: [f32; BLOCK_VOXELS], active: BlockMask, visit: T) -> bool {
        let Self { band, visits, .. } = self;
        let known = place_of(&band.origins, origin);
        match known {
            Ok(place) => (band.distances[place], band.active[place], visits[place]) = (distances, active, visit),
            Err(place) => {
                band.origins.insert(place, origin);
                band.distances.insert(place, distances);
                band.active.insert(place, active);
                visits.insert(place, visit);
            }
        }
        known.is_err()
    }
}

/// Why there is no band.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Error {
    /// F is not a number there.
    NotANumber {
        /// World units.
        position: DVec3,
    },
    /// No surface in the region.
    Empty {
        /// Whether the whole region is inside the solid.
        solid: bool,
    },
    /// The region reaches farther from the origin than voxels can be numbered.
    TooFar {
        /// How far, in voxels.
        voxels: f64,
    },
    /// [`Settings::cancel`] was set.
    Cancelled,
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotANumber { position: p } => write!(
                f,
                "the function is not a number at ({}, {}, {}): look for a division by zero, or a root or logarithm of \
                 a negative number there",
                p.x, p.y, p.z
            ),
            Self::Empty { solid: false } => {
                f.write_str("nothing is inside: the function is negative everywhere in the region; check the signs (positive is inside) and the bounds")
            }
            Self::Empty { solid: true } => {
                f.write_str("there is no surface: the function is positive everywhere in the region; check the signs (positive is inside) and widen the bounds")
            }
            Self::TooFar { voxels } => write!(
                f,
                "the region reaches {voxels:.3e} voxels from the origin, and OpenVDB numbers {} at most: use larger \
                 voxels, or bring the object nearer to the origin",
                1 << 30
            ),
            Self::Cancelled => f.write_str("cancelled"),
        }
    }
}

impl std::error::Error for Error {}

/// Measures the band of a field. `visitor` makes a visitor for each task; a visitor sees finished blocks, and what it
/// returns for each is kept, in the order of the band's blocks. (A block that a later one improves is seen again, and
/// the later visit kept.)
pub fn measure<T, V>(
    field: &dyn Field,
    settings: &Settings,
    visitor: impl Fn() -> V + Sync,
) -> Result<Measured<T>, Error>
where
    T: Send + Sync,
    V: FnMut(&MeasuredBlock) -> T + Send,
{
    Ok(measure_opened(field, settings, &visitor, CHUNK)?.measured)
}

/// A measured band, and the blocks that were looked into: those that may hold a piece of it.
pub(super) struct Opened<T> {
    pub measured: Measured<T>,
    pub blocks: Vec<IVec3>,
}

/// [`measure`], with what was opened.
pub(super) fn measure_opened<T, V>(
    field: &dyn Field,
    settings: &Settings,
    visitor: &(impl Fn() -> V + Sync),
    chunk: usize,
) -> Result<Opened<T>, Error>
where
    T: Send + Sync,
    V: FnMut(&MeasuredBlock) -> T + Send,
{
    let scope = settings.scope();
    check_size(&scope)?;
    let found = descent::descend(field, &scope, settings.cancel).ok_or(Error::Cancelled)?;
    let mut measured = measure_blocks(field, settings, visitor, &found.blocks, chunk)?;
    (settings.progress)(1.0);
    let Measured { band, report, .. } = &mut measured;
    band.inside_tiles.extend(found.inside_tiles);
    if band.origins.is_empty() {
        return Err(Error::Empty { solid: !band.inside_tiles.is_empty() });
    }
    // Two sorted lists in a row: those of blocks, and those of larger nodes.
    band.inside_tiles.sort_by_key(|tile| block_order(tile.origin));
    report.cut_voxels = cut_voxels(band, &scope);
    Ok(Opened { measured, blocks: found.blocks })
}

/// Measures some blocks alone, in [`block_order`]; what is cut off by the region is not counted.
pub(super) fn measure_blocks<T, V>(
    field: &dyn Field,
    settings: &Settings,
    visitor: &(impl Fn() -> V + Sync),
    blocks: &[IVec3],
    chunk: usize,
) -> Result<Measured<T>, Error>
where
    T: Send + Sync,
    V: FnMut(&MeasuredBlock) -> T + Send,
{
    let scope = settings.scope();
    let measuring = Measuring::new(field, &scope, settings.feet, settings.cancel);
    let mut pass = Pass::new(&measuring, visitor, blocks);
    pass.run(chunk, settings.progress)?;
    pass.redo()?;
    Ok(pass.done())
}

impl Settings<'_> {
    pub(super) fn scope(&self) -> Scope {
        Scope { lattice: self.lattice, half_width: self.half_width, region: self.region }
    }
}

/// OpenVDB's voxels are numbered in 32 bits; leave room for neighbours.
fn check_size(scope: &Scope) -> Result<(), Error> {
    let edge = scope.lattice.voxel_size.get();
    let farthest = scope.region.min.abs().max(scope.region.max.abs()).max_element() / edge;
    if farthest < f64::from(1 << 30) { Ok(()) } else { Err(Error::TooFar { voxels: farthest }) }
}

/// Counts inside voxels on the six faces of the range of blocks looked at.
pub(super) fn cut_voxels(band: &Band, scope: &Scope) -> [u64; 6] {
    let [least, end] = scope.block_range();
    let mut cut = [0; 6];
    for (side, count) in cut.iter_mut().enumerate() {
        let axis = side / 2;
        let on_face = |origin: IVec3, edge: i32| {
            if side % 2 == 0 { origin[axis] == least[axis] } else { origin[axis] + edge == end[axis] }
        };
        let layer = if side % 2 == 0 { 0 } else { 7 };
        for (_, distances) in
            band.origins.iter().zip(&band.distances).filter(|(origin, _)| on_face(**origin, BLOCK_EDGE))
        {
            let in_layer = |i: usize| (i >> (6 - 3 * axis)) & 7 == layer;
            *count += (0..BLOCK_VOXELS).filter(|&i| in_layer(i) && distances[i] >= 0.0).count() as u64;
        }
        for tile in band.inside_tiles.iter().filter(|tile| on_face(tile.origin, tile.edge)) {
            *count += (tile.edge as u64).pow(2);
        }
    }
    cut
}

#[cfg(test)]
mod crowd_tests;
#[cfg(test)]
mod tests;
