//! Points on F = 0 for the nodes beside it: Newton's step from a node, and where an edge of the lattice crosses the surface,
//! both pulled onto it. Voxel centres in their place would cost half a voxel of error.

use glam::{DVec3, IVec3};
use rayon::prelude::*;

use crate::distance::method::lattice::Nodes;
use crate::distance::nearest::Watch;
use crate::distance::octree::BuildError;
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Points};
use crate::grid::{BLOCK_EDGE, BLOCK_VOXELS, Lattice, voxel_offset};

/// A node starts Newton's steps by itself where they are no longer than half a cell's diagonal, in voxels.
const BESIDE: f64 = 0.867;

/// Halvings and secants by which a root on an edge is found. The secant's error falls below that of an `f32` in half of
/// them where F is smooth; where it is not, halvings leave 2⁻⁸ of an edge.
const ROOT_STEPS: usize = 16;

/// Newton's steps onto the surface.
const NEWTON_STEPS: usize = 3;

/// How near to F = 0 a point must be to count as on it, in voxels, to first order.
const ON_SURFACE: f64 = 1e-3;

/// How much nearer than the band's own distance a point may be, in voxels. A point of a piece that the band has left out is
/// far nearer; rounding is far less.
const NEARER_THAN_BAND: f64 = 0.05;

/// A node with a point on the surface, or one that is to be pulled onto it.
#[derive(Clone, Copy)]
struct Seed {
    voxel: IVec3,
    point: DVec3,
}

/// Nodes with points on F = 0, some of them several times, in the order of blocks.
pub fn points(field: &dyn Field, nodes: &Nodes<'_>, watch: &Watch<'_>) -> Result<Vec<(usize, DVec3)>, BuildError> {
    let of_block = |block: usize| {
        if watch.cancelled() {
            return Err(BuildError::Cancelled);
        }
        let band = nodes.band;
        // An edge may cross the surface where no node of the block is nearer than that.
        let within = 2.0 * nodes.step();
        if band.distances[block].iter().all(|distance| f64::from(distance.abs()) > within) {
            return Ok(Vec::new());
        }
        let mut work = Work::new(field, nodes.lattice, band.origins[block]);
        let seeds = work.seeds();
        work.evaluator.leave();
        let found = seeds.into_iter().filter_map(|Seed { voxel, point }| {
            let node = nodes.blocks.node(voxel)?;
            let away = nodes.lattice.centre(voxel).distance(point);
            Some((node, point, away))
        });
        Ok(found.collect::<Vec<_>>())
    };
    let all: Result<Vec<_>, BuildError> = (0..nodes.band.origins.len()).into_par_iter().map(of_block).collect();
    let mut known = vec![f64::INFINITY; nodes.blocks.nodes()];
    for (node, distance) in nodes.active() {
        known[node] = distance.abs();
    }
    let slack = NEARER_THAN_BAND * nodes.step();
    let is_of_band = |&(node, _, away): &(usize, DVec3, f64)| known[node].is_finite() && away > known[node] - slack;
    Ok(all?.into_iter().flatten().filter(is_of_band).map(|(node, point, _)| (node, point)).collect())
}

/// One block.
struct Work<'a> {
    evaluator: Box<dyn Evaluator + 'a>,
    lattice: Lattice,
    origin: IVec3,
    middle: DVec3,
    at: Box<Gradients>,
}

/// An edge whose ends are on different sides: `low` and `high` are places on it, in edges from `voxel`, with their F.
#[derive(Clone, Copy)]
struct Edge {
    voxel: IVec3,
    axis: usize,
    low: (f64, f64),
    high: (f64, f64),
}

impl<'a> Work<'a> {
    fn new(field: &'a dyn Field, lattice: Lattice, origin: IVec3) -> Self {
        let mut evaluator = field.evaluator();
        let corner = |voxel: IVec3| lattice.centre(voxel);
        evaluator.enter(&Aabb::new(corner(origin - 2), corner(origin + BLOCK_EDGE + 2)));
        Self { evaluator, lattice, origin, middle: Points::middle_of_block(origin, &lattice), at: Box::default() }
    }

    fn step(&self) -> f64 {
        self.lattice.voxel_size.get()
    }

    /// Calls `take` with each of some positions, in their order, and F and ∇F there.
    fn each(&mut self, positions: &[DVec3], mut take: impl FnMut(usize, f64, DVec3)) {
        let mut points = Points::new(self.middle);
        for (run, positions) in positions.chunks(BATCH).enumerate() {
            points.len = 0;
            positions.iter().for_each(|&position| points.push((position - self.middle).as_vec3()));
            self.evaluator.gradients(&points, &mut self.at);
            for i in 0..positions.len() {
                take(run * BATCH + i, f64::from(self.at.value[i]), self.at.gradient(i).as_dvec3());
            }
        }
    }

    /// The block's points.
    fn seeds(&mut self) -> Vec<Seed> {
        let (lattice, origin, step) = (self.lattice, self.origin, self.step());
        // The block's own nodes, then the next ones beyond its far faces.
        let own = (0..BLOCK_VOXELS as i32).map(|place| origin + IVec3::new(place >> 6, place >> 3 & 7, place & 7));
        let across = |axis: usize, side: i32| {
            let mut step = IVec3::ZERO;
            step[axis] = BLOCK_EDGE;
            step[(axis + 1) % 3] = side >> 3;
            step[(axis + 2) % 3] = side & 7;
            origin + step
        };
        let beyond = (0..3).flat_map(|axis| (0..64).map(move |side| across(axis, side)));
        let voxels: Vec<IVec3> = own.chain(beyond).collect();
        let positions: Vec<DVec3> = voxels.iter().map(|&voxel| lattice.centre(voxel)).collect();
        let mut values = vec![0.0; voxels.len()];
        let mut seeds = Vec::new();
        self.each(&positions, |i, value, gradient| {
            values[i] = value;
            let way = -value * gradient / gradient.length_squared();
            if i < BLOCK_VOXELS && way.length() < BESIDE * step {
                seeds.push(Seed { voxel: voxels[i], point: positions[i] + way });
            }
        });
        let value = |voxel: IVec3| {
            let local = voxel - origin;
            let axis = (0..3).find(|&axis| local[axis] == BLOCK_EDGE);
            let beyond =
                |axis: usize| (BLOCK_VOXELS + 64 * axis) as i32 + 8 * local[(axis + 1) % 3] + local[(axis + 2) % 3];
            values[axis.map_or_else(|| voxel_offset(voxel), |axis| beyond(axis) as usize)]
        };
        let mut edges = Vec::new();
        for &voxel in &voxels[..BLOCK_VOXELS] {
            for axis in 0..3 {
                let [low, high] = [value(voxel), value(voxel + IVec3::AXES[axis])];
                if (low < 0.0) != (high < 0.0) {
                    edges.push(Edge { voxel, axis, low: (0.0, low), high: (1.0, high) });
                }
            }
        }
        self.roots(&mut edges, &mut seeds);
        self.pulled(&seeds)
    }

    /// Finds where edges cross the surface; adds that point, and from there the nearest of the tangent plane, to both ends.
    fn roots(&mut self, edges: &mut [Edge], seeds: &mut Vec<Seed>) {
        let (lattice, step) = (self.lattice, self.step());
        let place = |edge: &Edge, share: f64| lattice.centre(edge.voxel) + DVec3::AXES[edge.axis] * (share * step);
        let middle = |edge: &Edge, round: usize| {
            let ((low, at_low), (high, at_high)) = (edge.low, edge.high);
            // Halvings in turns, so that a bend of F holds none up.
            let share = if round.is_multiple_of(2) { at_low / (at_low - at_high) } else { 0.5 };
            if share > 0.0 && share < 1.0 { low + share * (high - low) } else { 0.5 * (low + high) }
        };
        for round in 0..ROOT_STEPS {
            let shares: Vec<f64> = edges.iter().map(|edge| middle(edge, round)).collect();
            let positions: Vec<DVec3> = edges.iter().zip(&shares).map(|(edge, &share)| place(edge, share)).collect();
            self.each(&positions, |i, value, _| {
                let edge = &mut edges[i];
                let end = if (value < 0.0) == (edge.low.1 < 0.0) { &mut edge.low } else { &mut edge.high };
                *end = (shares[i], value);
            });
        }
        let nearer = |edge: &Edge| if edge.low.1.abs() < edge.high.1.abs() { edge.low.0 } else { edge.high.0 };
        let positions: Vec<DVec3> = edges.iter().map(|edge| place(edge, nearer(edge))).collect();
        self.each(&positions, |i, _, gradient| {
            let (edge, root) = (&edges[i], positions[i]);
            let normal = gradient.normalize_or_zero();
            for voxel in [edge.voxel, edge.voxel + IVec3::AXES[edge.axis]] {
                seeds.push(Seed { voxel, point: root });
                let at = lattice.centre(voxel);
                seeds.push(Seed { voxel, point: at - normal * normal.dot(at - root) });
            }
        });
    }

    /// Points pulled onto the surface by Newton's steps; those that do not come there are left out.
    fn pulled(&mut self, seeds: &[Seed]) -> Vec<Seed> {
        let step = self.step();
        let mut positions: Vec<DVec3> = seeds.iter().map(|seed| seed.point).collect();
        for _ in 0..NEWTON_STEPS {
            let mut ways = vec![DVec3::ZERO; positions.len()];
            self.each(&positions, |i, value, gradient| {
                let way = -value * gradient / gradient.length_squared();
                if way.length() < step {
                    ways[i] = way;
                }
            });
            positions.iter_mut().zip(ways).for_each(|(position, way)| *position += way);
        }
        let mut found = Vec::with_capacity(seeds.len());
        self.each(&positions.clone(), |i, value, gradient| {
            let Seed { voxel, .. } = seeds[i];
            // Also left out where F has no gradient.
            if value.abs() <= ON_SURFACE * step * gradient.length() && value.is_finite() {
                found.push(Seed { voxel, point: positions[i] });
            }
        });
        found
    }
}
