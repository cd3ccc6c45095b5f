//! Interior distances by the eikonal equation |∇d| = 1/f inside of the body, f a speed or 1: by the solver of
//! [`fim`](crate::distance::method::fim), on the nodes of the body that are middles of cells.
//!
//! **Guaranteed:** nothing passes between two nodes that do not see each other, so that arms nearer than a cell do not leak;
//! the same bits for any number of threads. **Not guaranteed:** more than first order, as all solvers on a lattice: about a
//! cell too long, a little more with each halving of the cell. What is thinner than a cell has no middles inside: there
//! the wavefront of [`spread`](super::spread) goes on, from node to node where there is a speed.

use std::sync::atomic::AtomicBool;

use glam::{IVec3, Vec3};

use super::Error;
use super::nodes::{Body, NONE};
use super::sight::Sight;
use super::spread::{Spread, State};
use crate::distance::method::blocks::Blocks;
use crate::distance::method::fim;
use crate::distance::nearest::Watch;
use crate::grid::{BLOCK_VOXELS, block_order};

/// Nodes that lie together at least so deep, in cells, see each other when they are a cell apart.
const IN_SIGHT: f32 = 1.0;

/// What the solution is besides its values.
pub(super) struct Solved {
    /// What a cell takes at each node; empty where that is 1.
    pub slowness: Vec<f32>,
    /// How the value grows at each node, by cell; no use where the solution stands for no value.
    pub slopes: Vec<Vec3>,
}

impl Solved {
    #[inline(always)]
    pub fn slowness(&self, node: u32) -> f32 {
        self.slowness.get(node as usize).copied().unwrap_or(1.0)
    }

    #[inline(always)]
    pub fn slope(&self, node: u32) -> Vec3 {
        self.slopes[node as usize]
    }

    /// The most that a cell takes.
    pub fn greatest(&self) -> f32 {
        self.slowness.iter().copied().reduce(f32::max).unwrap_or(1.0)
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.slowness[..]) + size_of_val(&self.slopes[..])
    }
}

/// The middles of cells inside of a body as the solver takes them.
pub(super) struct Middles {
    blocks: Blocks,
    /// The body's node of each of the solver's, or [`NONE`].
    nodes: Vec<u32>,
    /// The faces of each that are walled up, a bit each.
    walled: Vec<u8>,
}

impl Middles {
    pub fn new(body: &Body) -> Self {
        let mut origins: Vec<IVec3> = body.block_origins().collect();
        origins.sort_by_cached_key(|origin| block_order(*origin));
        let blocks = Blocks::new(origins);
        let of = |number: usize| {
            let node = body.node(blocks.voxel(number));
            if node != NONE && body.is_middle(node) { node } else { NONE }
        };
        let nodes: Vec<u32> = (0..blocks.nodes()).map(of).collect();
        // On one thread: whoever waits for this may be a task of the same pool.
        let mut sight = Sight::new(body);
        let mut is_walled = |number: usize, face: usize| {
            let Some(other) = blocks.beside(number, face).map(|other| nodes[other]) else { return false };
            let node = nodes[number];
            if other == NONE || body.depth(node) + body.depth(other) >= IN_SIGHT {
                return false;
            }
            // Looked along one way only, so that both sides agree.
            !sight.is_clear(body.place(node.min(other)), body.place(node.max(other)))
        };
        let mut walled = vec![0; nodes.len()];
        for number in (0..nodes.len()).filter(|number| nodes[*number] != NONE) {
            walled[number] = (0..6).filter(|face| is_walled(number, *face)).fold(0, |walled, face| walled | 1 << face);
        }
        Self { blocks, nodes, walled }
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.walled[..]) + self.blocks.origins.len() * 36
    }
}

/// Solves from the nodes where a wavefront begins, and gives it the middles as settled; how the value grows at each node.
pub(super) fn march(spread: &mut Spread<'_>, cancel: &AtomicBool) -> Result<Vec<Vec3>, Error> {
    let body = spread.body;
    let middles = body.middles();
    let Middles { blocks, nodes, walled } = middles;
    let all = || (0..BLOCK_VOXELS * blocks.origins.len()).filter(|number| nodes[*number] != NONE);
    let begins = |number: &usize| spread.nodes[nodes[*number] as usize].state == State::Seen;
    let seeds: Vec<(usize, f64)> =
        all().filter(begins).map(|number| (number, f64::from(spread.nodes[nodes[number] as usize].value))).collect();
    let of_cell = spread.slowness;
    let slowness = |number: usize| match nodes[number] {
        NONE => f64::INFINITY,
        node => of_cell.get(node as usize).copied().map_or(1.0, f64::from),
    };
    let is_open = |number: usize, face: usize| walled[number] >> face & 1 == 0;
    let watch = Watch { cancel, progress: &|_| {} };
    // Nothing but a stop makes it fail.
    let times = fim::arrivals(blocks, 1.0, &seeds, slowness, is_open, &watch).map_err(|_| Error::Cancelled)?;
    let mut slopes = vec![Vec3::ZERO; body.len()];
    for number in all().filter(|number| times[*number].is_finite()) {
        let time = |face: usize| {
            let beside = blocks.beside(number, face).filter(|_| is_open(number, face));
            beside.map_or(f64::INFINITY, |other| times[other])
        };
        // Upwind, as the solver has it.
        let along = |axis: usize| {
            let (before, after) = (time(2 * axis), time(2 * axis + 1));
            let growth = (times[number] - before.min(after)).max(0.0);
            (if before <= after { growth } else { -growth }) as f32
        };
        let node = nodes[number];
        let way = Vec3::new(along(0), along(1), along(2)).normalize_or_zero();
        slopes[node as usize] = way * spread.of_cell(node);
        spread.settle(node, times[number] as f32);
    }
    Ok(slopes)
}
