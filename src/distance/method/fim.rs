//! `fim`: the eikonal equation |∇u| = 1/f from exact distances at the corners of the cells that the surface crosses, by the
//! fast iterative method with Godunov's first-order update.
//!
//! **Guaranteed:** at its seeds the distance to the closest point; the same bits for any number of threads. **Not
//! guaranteed:** elsewhere it is of first order: too far by up to a few hundredths of a voxel in a narrow band, by more
//! where the surface is curved within few voxels, and far away.

use std::sync::Arc;

use super::blocks::Blocks;
use super::godunov::arrival;
use super::lattice::{self, Nodes};
use super::rounds::settle;
use super::{AsChosen, Measured, Method, Request};
use crate::distance::nearest::Watch;
use crate::distance::octree::{BuildError, DistanceObject};
use crate::field::Field;
use crate::grid::Band;

/// A change that counts, in the time that the way from node to node takes. Less costs rounds that change no digit of a
/// level set's, more stops short of the solution.
const CHANGE: f64 = 1e-6;

/// A surface nearer to a node than half a cell's diagonal may pass through the cell and leave its corners on one side.
const BESIDE: f64 = 0.867;

/// Its time, whether it is known, its side, whether it is at a crossing and whether it is listed; lists of nodes take a
/// part of that.
const BYTES_A_NODE: usize = 16;

/// The method.
pub struct Fim;

impl Method for Fim {
    fn name(&self) -> &'static str {
        "fim"
    }

    fn measure(&self, request: &Request<'_>, watch: &Watch<'_>) -> Result<Measured, BuildError> {
        lattice::measure(request, BYTES_A_NODE, &distances, watch)
    }

    fn bytes_a_node(&self) -> usize {
        BYTES_A_NODE
    }

    fn restored(&self, object: Arc<DistanceObject>, field: &Arc<dyn Field>) -> Measured {
        Measured::signed(object, field)
    }

    fn measure_band(
        &self,
        _field: &dyn Field,
        band: &mut Band,
        _as_chosen: AsChosen,
        watch: &Watch<'_>,
    ) -> Result<(), BuildError> {
        lattice::measure_band(band, &distances, watch)
    }
}

/// Distances from the corners of crossed cells.
fn distances(nodes: &Nodes<'_>, watch: &Watch<'_>) -> Result<Vec<f64>, BuildError> {
    arrivals(nodes.blocks, nodes.step(), &seeds(nodes), |_| 1.0, |_, _| true, watch)
}

/// The nodes beside the surface with their distances, not signed.
pub fn seeds(nodes: &Nodes<'_>) -> Vec<(usize, f64)> {
    let crossed = nodes.at_crossings();
    let is_seed = |(node, distance): &(usize, f64)| crossed[*node] || distance.abs() < BESIDE * nodes.step();
    nodes.active().filter(is_seed).map(|(node, distance)| (node, distance.abs())).collect()
}

/// Arrival times at nodes `step` apart from some whose times are known and stay; ∞ where nothing arrives. `slowness` is 1/f
/// at a node, ∞ where nothing passes; `is_open` says whether anything passes through a face of a node, seen from either side.
pub fn arrivals(
    blocks: &Blocks,
    step: f64,
    seeds: &[(usize, f64)],
    slowness: impl Fn(usize) -> f64 + Sync,
    is_open: impl Fn(usize, usize) -> bool + Sync,
    watch: &Watch<'_>,
) -> Result<Vec<f64>, BuildError> {
    let mut times = vec![f64::INFINITY; blocks.nodes()];
    let mut known = vec![false; blocks.nodes()];
    for &(node, time) in seeds {
        (times[node], known[node]) = (time, true);
    }
    let sources: Vec<usize> = seeds.iter().map(|&(node, _)| node).collect();
    let relax = |times: &[f64], node: usize| {
        let slowness = slowness(node);
        if known[node] || slowness == f64::INFINITY {
            return None;
        }
        let open = |face: usize| blocks.beside(node, face).filter(|_| is_open(node, face));
        let time = |face: usize| open(face).map_or(f64::INFINITY, |other| times[other]);
        let nearest = std::array::from_fn(|axis| time(2 * axis).min(time(2 * axis + 1)));
        let found = arrival(nearest, [step; 3], slowness);
        (found < times[node] - CHANGE * step * slowness).then_some(found)
    };
    settle(blocks, &mut times, &sources, relax, watch)?;
    Ok(times)
}
