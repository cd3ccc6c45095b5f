//! What grid methods share: nodes around a surface with their sides and nearest distances, and the way from solved nodes
//! to a distance that answers everywhere.
//!
//! HFRep, section 4: the distances at nodes are restored by a C¹ spline, here that of
//! [`octree`](crate::distance::octree) over the same nodes, and the sign is F's own at the point that is asked for.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::Blocks;
use super::{Measured, Request};
use crate::distance::Foot;
use crate::distance::band::{self, MeasuredBlock};
use crate::distance::nearest::{ClosestPoint, Watch};
use crate::distance::octree::{BuildError, DistanceObject, Settings};
use crate::field::{Aabb, Field};
use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, Band, Lattice, VoxelSize, is_active, place_of};

/// Half the width of the band whose distances may be given to nodes, in voxels: the corners of a cell that the surface
/// crosses are nearer than √3.
const SEED_BAND: f32 = 1.8;

/// Nodes around the region, in voxels: for gradients at its border.
const MARGIN: f64 = 2.0;

/// How far a patch of the restored distance may miss the nodes' before its cell is split, in voxels. Less follows the
/// error of the nodes, more adds to it.
const TOLERANCE: f64 = 0.05;

/// The share that finding seeds has in the time that measuring takes.
const SEEDING: f64 = 0.2;
/// The same when the nodes are solved.
const SOLVED: f64 = 0.6;

/// Nodes to be solved.
pub struct Nodes<'a> {
    /// Where they are.
    pub lattice: Lattice,
    /// Their numbers.
    pub blocks: &'a Blocks,
    /// The band that they take their seeds from, all of whose blocks are among theirs.
    pub band: &'a Band,
    /// By node, whether it is inside.
    pub inside: Vec<bool>,
}

/// Solves nodes: the distance to the surface at each, not signed, in world units; ∞ where none was found.
pub type Solve<'s> = &'s dyn Fn(&Nodes<'_>, &Watch<'_>) -> Result<Vec<f64>, BuildError>;

impl<'a> Nodes<'a> {
    /// All nodes of some blocks, and a band whose blocks are among them, or of no matter.
    pub fn new(band: &'a Band, blocks: &'a Blocks) -> Self {
        let mut inside = vec![false; blocks.nodes()];
        for tile in band.inside_tiles.iter().flat_map(|tile| tile.blocks()) {
            if let Ok(block) = place_of(&blocks.origins, tile) {
                inside[block * BLOCK_VOXELS..][..BLOCK_VOXELS].fill(true);
            }
        }
        for (origin, distances) in band.origins.iter().zip(&band.distances) {
            if let Ok(block) = place_of(&blocks.origins, *origin) {
                let of_block = &mut inside[block * BLOCK_VOXELS..][..BLOCK_VOXELS];
                of_block.iter_mut().zip(distances).for_each(|(inside, distance)| *inside = distance.is_sign_positive());
            }
        }
        Self { lattice: band.lattice, blocks, band, inside }
    }

    /// A node's edge, world units.
    pub fn step(&self) -> f64 {
        self.lattice.voxel_size.get()
    }

    /// The nodes of the band's active voxels, with the signed distances to their closest points.
    pub fn active(&self) -> impl Iterator<Item = (usize, f64)> {
        self.band.origins.iter().enumerate().flat_map(move |(block, origin)| {
            let first = place_of(&self.blocks.origins, *origin).ok().map(|place| place * BLOCK_VOXELS);
            let (active, distances) = (&self.band.active[block], &self.band.distances[block]);
            (0..BLOCK_VOXELS)
                .filter(|&place| is_active(active, place))
                .filter_map(move |place| Some((first? + place, f64::from(distances[place]))))
        })
    }

    /// By node, whether it is a corner of a cell whose corners are not all on one side.
    pub fn at_crossings(&self) -> Vec<bool> {
        // Bit 0: one of those around is inside; bit 1: one is outside. Each axis adds the neighbours along it.
        let mut sides: Vec<u8> = self.inside.iter().map(|&inside| if inside { 1 } else { 2 }).collect();
        for axis in 0..3 {
            let side = |node: Option<usize>| node.map_or(0, |node| sides[node]);
            let with_next = |node: usize| {
                sides[node] | side(self.blocks.beside(node, 2 * axis)) | side(self.blocks.beside(node, 2 * axis + 1))
            };
            sides = (0..sides.len()).into_par_iter().map(with_next).collect();
        }
        sides.into_par_iter().map(|sides| sides == 3).collect()
    }
}

/// The band of a field that nodes take their seeds from.
pub fn seed_band(field: &dyn Field, lattice: Lattice, region: Aabb, watch: &Watch<'_>) -> Result<Band, band::Error> {
    let Watch { cancel, progress } = *watch;
    let settings =
        band::Settings { lattice, half_width: SEED_BAND, region, feet: band::Feet::Nearest, cancel, progress };
    Ok(band::measure(field, &settings, || |_: &MeasuredBlock| ())?.band)
}

/// Measures a distance that answers everywhere. `bytes` is what a node takes while it is solved.
pub fn measure(
    request: &Request<'_>,
    bytes: usize,
    solve: Solve<'_>,
    watch: &Watch<'_>,
) -> Result<Measured, BuildError> {
    let Request { field, solid, detail, settings } = request;
    let voxel_size = VoxelSize::new(*detail).ok_or(BuildError::Settings)?;
    let lattice = Lattice { voxel_size };
    let filled = settings.region.union(solid.grown(*detail)).grown(MARGIN * detail);
    let size = filled.size() / *detail + f64::from(BLOCK_EDGE);
    if !size.is_finite() {
        return Err(BuildError::Settings);
    }
    let needed = size.element_product() * bytes as f64;
    if needed > settings.memory_limit as f64 {
        return Err(BuildError::Memory { needed: needed as usize, limit: settings.memory_limit });
    }
    let Watch { cancel, progress } = *watch;
    let seeding = |share: f64| progress(SEEDING * share);
    let band = seed_band(field.as_ref(), lattice, solid.grown(MARGIN * detail), &Watch { cancel, progress: &seeding })?;
    let blocks = Blocks::filling(lattice.nearest(filled.min), lattice.nearest(filled.max));
    let nodes = Nodes::new(&band, &blocks);
    let mut distances = solve(&nodes, watch)?;
    if distances.iter().all(|distance| *distance == f64::INFINITY) {
        return Err(BuildError::NoSurface);
    }
    progress(SOLVED);
    distances.par_iter_mut().zip(&nodes.inside).for_each(|(distance, inside)| {
        if !inside {
            *distance = -*distance;
        }
    });
    drop(nodes);
    let solved = Solved { lattice, blocks, distances };
    let building = |share: f64| progress(SOLVED + (1.0 - SOLVED) * share);
    // Its smallest cells have their corners on the nodes.
    let smallest = Settings::new(settings.region, *detail);
    let settings = Settings {
        levels: settings.levels,
        tolerance: TOLERANCE * detail,
        memory_limit: settings.memory_limit,
        ..smallest
    };
    let object = DistanceObject::build(&solved, &settings, &Watch { cancel, progress: &building })?;
    Ok(Measured::signed(Arc::new(object), field))
}

/// Puts a method's distances in the place of a band's own: those of its active voxels. Their signs, and which voxels are
/// active, stay.
pub fn measure_band(band: &mut Band, solve: Solve<'_>, watch: &Watch<'_>) -> Result<(), BuildError> {
    let blocks = Blocks::new(band.origins.clone());
    let distances = solve(&Nodes::new(band, &blocks), watch)?;
    // An active voxel is nearer than the background, whatever a method takes it to be.
    let most = f64::from(band.background().next_down());
    let of_blocks = distances.par_chunks(BLOCK_VOXELS).zip(&band.active);
    band.distances.par_iter_mut().zip(of_blocks).for_each(|(signed, (distances, active))| {
        for place in (0..BLOCK_VOXELS).filter(|&place| is_active(active, place)) {
            signed[place] = (distances[place].min(most) as f32).copysign(signed[place]);
        }
    });
    Ok(())
}

/// Signed distances at nodes that fill a box.
struct Solved {
    lattice: Lattice,
    blocks: Blocks,
    distances: Vec<f64>,
}

impl Solved {
    /// The distance at a node and its gradient by differences: central ones where there are both neighbours.
    fn at(&self, node: usize) -> (f64, DVec3) {
        let here = self.distances[node];
        let along = |axis: usize| {
            let [low, high] = [0, 1].map(|side| self.blocks.beside(node, 2 * axis + side));
            let value = |node: Option<usize>| node.map_or(here, |node| self.distances[node]);
            let steps = f64::from(u8::from(low.is_some()) + u8::from(high.is_some())).max(1.0);
            (value(high) - value(low)) / (steps * self.lattice.voxel_size.get())
        };
        (here, DVec3::new(along(0), along(1), along(2)))
    }
}

impl ClosestPoint for Solved {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        let (first, last) = self.blocks.ends();
        for (position, foot) in positions.iter().zip(feet) {
            let voxel = self.lattice.nearest(*position).clamp(first, last);
            let node = self.blocks.node(voxel).unwrap_or_default();
            let (distance, gradient) = self.at(node);
            let centre = self.lattice.centre(voxel);
            let point = centre - distance * gradient.normalize_or_zero();
            *foot = Foot { point, distance, gradient, part: 0 };
            let away = *position - centre;
            if away.length_squared() > 0.25 * self.lattice.voxel_size.get().powi(2) {
                // Beyond the nodes the point goes on that is the closest to the nearest of them. Nothing is inside there.
                let length = position.distance(point);
                *foot = Foot { distance: -length, gradient: (point - *position) / length, ..*foot };
            }
        }
    }
}
