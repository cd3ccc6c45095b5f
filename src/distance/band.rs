//! The narrow band of a field: exact signed distances, with closest points handed to a visitor on the way.

use std::{
    fmt,
    sync::atomic::{AtomicBool, Ordering},
};

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::{
    field::{Aabb, Field},
    grid::{BLOCK_EDGE, BLOCK_VOXELS, Band, BlockMask, InsideTile, Lattice, block_order},
};

pub use super::block::MeasuredBlock;
use super::{
    block::{Kind, Meter},
    descent::{self, Scope},
};

/// Blocks measured between two reports of progress; their results wait in memory. Smaller starves many threads,
/// larger costs memory beyond the band's own.
const CHUNK: usize = 1024;

/// Edge in voxels of the nodes whose blocks one task measures.
const TASK_EDGE: i32 = 32;

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
    /// Set it to stop: the result is then [`Error::Cancelled`].
    pub cancel: &'a AtomicBool,
    /// Told the share done, from 0 to 1, now and then.
    pub progress: &'a (dyn Fn(f64) + Sync),
}

/// What to tell the user about a band that was measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Blocks evaluated.
    pub opened_blocks: u64,
    /// Blocks that hold a piece of the band.
    pub band_blocks: u64,
    /// Voxels beside a surface with the same sign all around them: features thinner than a voxel.
    pub thin_voxels: u64,
    /// Where one of those is.
    pub thin_at: Option<DVec3>,
    /// Inside voxels on the faces of the region: least x, greatest x, least y, … Not zero: the solid is cut there.
    pub cut_voxels: [u64; 6],
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
            Self::Cancelled => f.write_str("cancelled"),
        }
    }
}

impl std::error::Error for Error {}

/// One measured block on its way into the band.
struct Entry<T> {
    distances: [f32; BLOCK_VOXELS],
    active: BlockMask,
    visit: T,
}

enum Outcome<T> {
    Band(Box<Entry<T>>),
    Outside,
    Inside,
}

/// Measures the band of a field. `visitor` makes a visitor for each task; a visitor sees each finished block once and
/// what it returns is kept, in the order of the band's blocks.
pub fn measure<T, V>(
    field: &dyn Field,
    settings: &Settings,
    visitor: impl Fn() -> V + Sync,
) -> Result<Measured<T>, Error>
where
    T: Send,
    V: FnMut(&MeasuredBlock) -> T,
{
    let Settings { lattice, half_width, region, cancel, progress } = *settings;
    let scope = Scope { lattice, half_width, region };
    let found = descent::descend(field, &scope, cancel).ok_or(Error::Cancelled)?;
    let blocks = found.blocks;
    let mut band = Band {
        lattice,
        half_width,
        origins: Vec::with_capacity(blocks.len()),
        distances: Vec::with_capacity(blocks.len()),
        active: Vec::with_capacity(blocks.len()),
        inside_tiles: found.inside_tiles,
    };
    let mut visits = Vec::with_capacity(blocks.len());
    let mut report = Report { opened_blocks: blocks.len() as u64, ..Report::default() };
    let new_worker = || (Meter::new(field, &scope), visitor());
    for (number, chunk) in blocks.chunks(CHUNK).enumerate() {
        progress((number * CHUNK) as f64 / blocks.len() as f64);
        let outcomes = tasks(chunk)
            .par_iter()
            .map_init(new_worker, |(meter, visitor), task| measure_task(meter, visitor, chunk, task, cancel))
            .collect::<Result<Vec<_>, Error>>()?;
        let mut in_order: Vec<Option<Outcome<T>>> = chunk.iter().map(|_| None).collect();
        for (places, outcomes, thin) in outcomes {
            for (place, outcome) in places.into_iter().zip(outcomes) {
                in_order[place] = Some(outcome);
            }
            report.thin_voxels += thin.0;
            report.thin_at = report.thin_at.or(thin.1);
        }
        for (&origin, outcome) in chunk.iter().zip(in_order) {
            match outcome {
                Some(Outcome::Band(entry)) => {
                    band.origins.push(origin);
                    band.distances.push(entry.distances);
                    band.active.push(entry.active);
                    visits.push(entry.visit);
                }
                Some(Outcome::Inside) => band.inside_tiles.push(InsideTile { origin, edge: BLOCK_EDGE }),
                Some(Outcome::Outside) | None => {}
            }
        }
    }
    progress(1.0);
    if band.origins.is_empty() {
        return Err(Error::Empty { solid: !band.inside_tiles.is_empty() });
    }
    band.inside_tiles.sort_unstable_by_key(|tile| block_order(tile.origin));
    report.band_blocks = band.origins.len() as u64;
    report.cut_voxels = cut_voxels(&band, &scope);
    Ok(Measured { band, visits, report })
}

/// The places in a chunk of the blocks that each task measures: those of one small node.
fn tasks(chunk: &[IVec3]) -> Vec<Vec<usize>> {
    let node = |&place: &usize| (chunk[place] & IVec3::splat(!(TASK_EDGE - 1))).to_array();
    let mut places: Vec<usize> = (0..chunk.len()).collect();
    places.sort_by_key(node);
    places.chunk_by(|a, b| node(a) == node(b)).map(<[usize]>::to_vec).collect()
}

type TaskResult<T> = (Vec<usize>, Vec<Outcome<T>>, (u64, Option<DVec3>));

fn measure_task<T>(
    meter: &mut Meter,
    visitor: &mut impl FnMut(&MeasuredBlock) -> T,
    chunk: &[IVec3],
    task: &[usize],
    cancel: &AtomicBool,
) -> Result<TaskResult<T>, Error> {
    let mut outcomes = Vec::with_capacity(task.len());
    let mut thin = (0, None);
    for &place in task {
        if cancel.load(Ordering::Relaxed) {
            return Err(Error::Cancelled);
        }
        let origin = chunk[place];
        meter.enter_node(origin & IVec3::splat(!(TASK_EDGE - 1)), TASK_EDGE);
        outcomes.push(match meter.measure(origin)? {
            Kind::Outside => Outcome::Outside,
            Kind::Inside => Outcome::Inside,
            Kind::Band => {
                let block = meter.block();
                let visit = visitor(&block);
                Outcome::Band(Box::new(Entry { distances: *block.distances, active: *block.active, visit }))
            }
        });
        thin = (thin.0 + u64::from(meter.thin), thin.1.or(meter.thin_at));
    }
    Ok((task.to_vec(), outcomes, thin))
}

/// Counts inside voxels on the six faces of the range of blocks looked at.
fn cut_voxels(band: &Band, scope: &Scope) -> [u64; 6] {
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
mod tests;
