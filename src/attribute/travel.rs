//! Arrival times inside a solid: |∇u| = 1/f with u = 0 on the sources and f the speed, by
//! [`fim`](crate::distance::method::fim) on the nodes inside.
//!
//! **Guaranteed:** the same bits for any number of threads; ways stay inside, as far as nodes tell it. **Not guaranteed:**
//! more than first order in the voxel: a time is too late by about what a voxel takes. Outside, the time is that of the
//! nearest node inside.

use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::DVec3;
use rayon::prelude::*;

use super::positional::{Positional, PositionalSampler};
use super::{Attribute, Sampler, around};
use crate::distance::band;
use crate::distance::method::blocks::Blocks;
use crate::distance::method::fim;
use crate::distance::method::lattice::{Nodes, seed_band};
use crate::distance::method::rounds::settle;
use crate::distance::nearest::Watch;
use crate::distance::octree::BuildError;
use crate::field::{Aabb, BATCH, Field, Interval, Points};
use crate::grid::{BLOCK_VOXELS, Lattice, VoxelSize};

/// Nodes along the solid's longest side at most. More take memory and time to the third power for detail that a solution
/// of first order has little of.
const MOST_NODES: f64 = 256.0;

/// Nodes around the solid, in voxels: the times of points on its surface are mixed from them.
const MARGIN: f64 = 2.0;

/// Where arrival begins.
pub enum Sources {
    /// On the solid's own surface.
    Surface,
    /// Wherever one of these solids is.
    Solids(Vec<Arc<dyn Field>>),
}

/// What arrival times are found for.
pub struct Journey<'a> {
    /// The solid that ways stay in.
    pub solid: &'a dyn Field,
    /// Its box.
    pub aabb: Aabb,
    /// Where they begin.
    pub sources: Sources,
    /// How fast, units a second.
    pub speed: &'a dyn Field,
    /// A voxel's edge, units.
    pub voxel: f64,
    /// Set to stop.
    pub cancel: &'a AtomicBool,
}

/// Why there are no arrival times.
#[derive(Clone, Debug, PartialEq)]
pub enum TravelError {
    /// The speed there is no positive number.
    Speed {
        /// World units.
        position: DVec3,
        /// What it is.
        speed: f32,
    },
    /// No source meets the solid.
    NoSource,
    /// No way inside leads there from any source.
    Unreached {
        /// World units.
        position: DVec3,
        /// How many nodes none leads to.
        nodes: usize,
        /// How far apart nodes are, world units.
        step: f64,
    },
    /// The surface of the solid or of a source.
    Surface(BuildError),
}

impl fmt::Display for TravelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Speed { position: p, speed } => write!(
                f,
                "the speed at ({:.4}, {:.4}, {:.4}) is {speed}: it must be a finite number greater than 0 everywhere inside",
                p.x, p.y, p.z
            ),
            Self::NoSource => f.write_str("nothing that it starts from meets the inside"),
            Self::Unreached { position: p, nodes, step } => write!(
                f,
                "no way inside leads to ({:.4}, {:.4}, {:.4}), nor to {} other nodes {step:.3e} units apart",
                p.x,
                p.y,
                p.z,
                nodes - 1
            ),
            Self::Surface(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for TravelError {}

impl From<band::Error> for TravelError {
    fn from(error: band::Error) -> Self {
        Self::Surface(error.into())
    }
}

/// Arrival times at nodes that fill a box, and trilinear between them; beyond it those of the nearest place in it.
pub struct Travel {
    lattice: Lattice,
    blocks: Blocks,
    /// By node, seconds.
    times: Vec<f32>,
    range: Interval,
}

impl Travel {
    /// Finds the arrival times.
    ///
    /// # Errors
    /// Where the speed is none, no source meets the solid, or a part of it cannot be reached.
    pub fn new(journey: &Journey<'_>) -> Result<Self, TravelError> {
        let Journey { solid, aabb, sources, speed, voxel, cancel } = journey;
        let watch = Watch { cancel, progress: &|_| {} };
        let step = voxel.max(aabb.size().max_element() / MOST_NODES);
        let lattice = Lattice { voxel_size: VoxelSize::new(step).ok_or(TravelError::Surface(BuildError::Settings))? };
        let region = aabb.grown(MARGIN * step);
        let band = seed_band(*solid, lattice, region, &watch)?;
        let blocks = Blocks::filling(lattice.nearest(region.min), lattice.nearest(region.max));
        let nodes = Nodes::new(&band, &blocks);
        let slowness = slowness(*speed, &nodes)?;
        let starts: Vec<(usize, f64)> = match sources {
            Sources::Surface => fim::seeds(&nodes),
            Sources::Solids(solids) => {
                let starts = solids.iter().map(|solid| starts(solid.as_ref(), &nodes, region, &watch));
                starts.collect::<Result<Vec<_>, TravelError>>()?.concat()
            }
        };
        let mut seeds: Vec<(usize, f64)> = starts
            .into_iter()
            .filter(|&(node, _)| nodes.inside[node])
            .map(|(node, distance)| (node, distance * f64::from(slowness[node])))
            .collect();
        if seeds.is_empty() {
            return Err(TravelError::NoSource);
        }
        // Of several sources the first to arrive.
        seeds.sort_by(|(a, at_a), (b, at_b)| a.cmp(b).then(at_a.total_cmp(at_b)));
        seeds.dedup_by_key(|(node, _)| *node);
        let times = fim::arrivals(&blocks, step, &seeds, |node| f64::from(slowness[node]), |_, _| true, &watch)
            .map_err(TravelError::Surface)?;
        let mut unreached = (0..times.len()).filter(|&node| nodes.inside[node] && times[node] == f64::INFINITY);
        if let Some(first) = unreached.next() {
            let position = lattice.centre(blocks.voxel(first));
            return Err(TravelError::Unreached { position, nodes: 1 + unreached.count(), step });
        }
        let times = beyond(&nodes, &times, &watch).map_err(TravelError::Surface)?;
        let [range] = around(times.iter().map(|time| [*time]));
        Ok(Self { lattice, blocks, times, range })
    }
}

impl Positional for Travel {
    /// The time at a position.
    fn at(&self, position: DVec3) -> f32 {
        let (first, last) = self.blocks.ends();
        let place = position / self.lattice.voxel_size.get();
        let place = place.clamp(first.as_dvec3(), (last - 1).as_dvec3());
        let least = place.floor().as_ivec3().clamp(first, last - 1);
        let share = (place - least.as_dvec3()).as_vec3();
        let Some(node) = self.blocks.node(least) else { return f32::NAN };
        let next = |node: usize, axis: usize| self.blocks.beside(node, 2 * axis + 1).unwrap_or(node);
        let mix = |share: f32, low: f32, high: f32| low + share * (high - low);
        let along_z = |node: usize| mix(share.z, self.times[node], self.times[next(node, 2)]);
        let along_y = |node: usize| mix(share.y, along_z(node), along_z(next(node, 1)));
        mix(share.x, along_y(node), along_y(next(node, 0)))
    }

    fn range(&self) -> Interval {
        self.range
    }
}

/// 1/f at each node inside, ∞ at the others.
fn slowness(speed: &dyn Field, nodes: &Nodes<'_>) -> Result<Vec<f32>, TravelError> {
    let mut slowness = vec![f32::INFINITY; nodes.blocks.nodes()];
    let of_block = |block: usize, slowness: &mut [f32]| {
        let inside = &nodes.inside[block * BLOCK_VOXELS..][..BLOCK_VOXELS];
        if !inside.contains(&true) {
            return Ok(());
        }
        let points = Points::of_block(nodes.blocks.origins[block], &nodes.lattice);
        let mut values = [0.0; BATCH];
        speed.evaluator().values(&points, &mut values);
        for place in (0..BLOCK_VOXELS).filter(|&place| inside[place]) {
            let speed = values[place];
            slowness[place] = 1.0 / speed;
            // The greatest speeds have no slowness but 0, at which everything arrives at once.
            if !(speed > 0.0 && speed.is_finite() && slowness[place].is_finite()) {
                return Err(TravelError::Speed { position: points.position(place), speed });
            }
        }
        Ok(())
    };
    // The first block that is wrong is told, whichever is found first.
    let found: Vec<Result<(), TravelError>> =
        slowness.par_chunks_mut(BLOCK_VOXELS).enumerate().map(|(block, slowness)| of_block(block, slowness)).collect();
    found.into_iter().collect::<Result<(), _>>()?;
    Ok(slowness)
}

/// The nodes of a region in and beside a source, with their distances to it.
fn starts(
    source: &dyn Field,
    nodes: &Nodes<'_>,
    region: Aabb,
    watch: &Watch<'_>,
) -> Result<Vec<(usize, f64)>, TravelError> {
    let band = match seed_band(source, nodes.lattice, region, watch) {
        Err(band::Error::Empty { solid: false }) => return Ok(Vec::new()),
        Err(band::Error::Empty { solid: true }) => {
            return Ok((0..nodes.blocks.nodes()).map(|node| (node, 0.0)).collect());
        }
        other => other?,
    };
    let own = Nodes::new(&band, nodes.blocks);
    let beside = fim::seeds(&own).into_iter().filter(|&(node, _)| !own.inside[node]);
    let within = (0..own.inside.len()).filter(|&node| own.inside[node]).map(|node| (node, 0.0));
    Ok(beside.chain(within).collect())
}

/// The times with those of the nearest nodes inside at all others.
fn beyond(nodes: &Nodes<'_>, times: &[f64], watch: &Watch<'_>) -> Result<Vec<f32>, BuildError> {
    let (blocks, inside) = (nodes.blocks, &nodes.inside);
    let all = 0..blocks.nodes();
    let mut nearest: Vec<u32> = all.clone().map(|node| if inside[node] { node as u32 } else { u32::MAX }).collect();
    let faces_outside = |node: usize| (0..6).any(|face| blocks.beside(node, face).is_some_and(|other| !inside[other]));
    let sources: Vec<usize> = all.filter(|&node| inside[node] && faces_outside(node)).collect();
    let square = |node: usize, to: u32| {
        if to == u32::MAX {
            return i64::MAX;
        }
        (blocks.voxel(node) - blocks.voxel(to as usize)).as_i64vec3().length_squared()
    };
    let relax = |nearest: &[u32], node: usize| {
        if inside[node] {
            return None;
        }
        let offers = (0..6).filter_map(|face| blocks.beside(node, face)).map(|other| nearest[other]);
        let best = offers.min_by_key(|&offer| square(node, offer))?;
        (square(node, best) < square(node, nearest[node])).then_some(best)
    };
    settle(blocks, &mut nearest, &sources, relax, watch)?;
    Ok(nearest.into_iter().map(|node| times[node as usize] as f32).collect())
}

impl Attribute<1> for Travel {
    fn sampler(&self) -> Box<dyn Sampler<1> + '_> {
        Box::new(PositionalSampler(self))
    }
}

#[cfg(test)]
mod tests;
