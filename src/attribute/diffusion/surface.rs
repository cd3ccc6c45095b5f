//! The boundary of a solid as triangles of about one size: surface nets on a lattice, a vertex in each cell that the surface
//! crosses.

use glam::{DVec3, IVec3};

use crate::field::{Aabb, BATCH, Field, Gradients, Points};
use crate::mesh::Groups;

/// Vertices aimed at: more cost time, the square of it inside; fewer miss a hundredth of the distances.
const VERTICES: f64 = 2000.0;
/// Cells along the longest side that are tried first, and at least and most.
const FIRST: f64 = 20.0;
const CELLS: [f64; 2] = [10.0, 72.0];
/// Cells around the box, for what is mixed from nodes beside the boundary.
const MARGIN: f64 = 2.5;

/// A lattice over a solid and the values at its nodes; z runs fastest.
pub struct Grid {
    /// The first node.
    pub origin: DVec3,
    /// Between nodes, world units.
    pub step: f64,
    /// Nodes along each axis.
    pub size: IVec3,
    values: Vec<f32>,
}

/// Triangles, counter-clockwise from outside.
pub struct Surface {
    /// Vertices.
    pub positions: Vec<DVec3>,
    /// Their places in `positions`.
    pub triangles: Vec<[u32; 3]>,
}

impl Grid {
    /// With about as many cells that the surface crosses as vertices are wanted.
    pub fn fitting(solid: &dyn Field, aabb: Aabb) -> Self {
        let of = |cells: f64| Self::new(solid, aabb, aabb.size().max_element() / cells, false);
        let crossed = of(FIRST).crossed_cells().count().max(1) as f64;
        of((FIRST * (VERTICES / crossed).sqrt()).clamp(CELLS[0], CELLS[1]))
    }

    /// Around a box, in one layer of the plane or in space.
    pub(super) fn new(solid: &dyn Field, aabb: Aabb, step: f64, is_flat: bool) -> Self {
        let mut size = (aabb.size() / step + 2.0 * MARGIN).ceil().as_ivec3() + 1;
        if is_flat {
            size.z = 1;
        }
        let origin = aabb.centre() - 0.5 * (size - 1).as_dvec3() * step;
        let mut grid = Self { origin, step, size, values: Vec::new() };
        let mut evaluator = solid.evaluator();
        let mut out = [0.0; BATCH];
        let all: Vec<usize> = (0..grid.nodes()).collect();
        for batch in all.chunks(BATCH) {
            let positions: Vec<DVec3> = batch.iter().map(|node| grid.position(*node)).collect();
            evaluator.values(&Points::of_positions(&positions), &mut out);
            grid.values.extend(&out[..batch.len()]);
        }
        grid
    }

    /// How many nodes there are.
    pub fn nodes(&self) -> usize {
        (self.size.x * self.size.y * self.size.z) as usize
    }

    pub(super) fn place(&self, node: usize) -> IVec3 {
        let node = node as i32;
        let across = self.size.y * self.size.z;
        IVec3::new(node / across, node / self.size.z % self.size.y, node % self.size.z)
    }

    pub(super) fn node(&self, place: IVec3) -> usize {
        ((place.x * self.size.y + place.y) * self.size.z + place.z) as usize
    }

    /// Where a node is.
    pub fn position(&self, node: usize) -> DVec3 {
        self.origin + self.place(node).as_dvec3() * self.step
    }

    /// Whether a node is inside of the solid.
    pub fn is_inside(&self, node: usize) -> bool {
        self.values[node] >= 0.0
    }

    /// The least nodes of cells whose corners are not all on one side.
    fn crossed_cells(&self) -> impl Iterator<Item = usize> {
        let is_crossed = |node: &usize| {
            let place = self.place(*node);
            if (place + 1).cmpge(self.size).any() {
                return false;
            }
            let inside = corners().filter(|by| self.is_inside(self.node(place + *by))).count();
            inside != 0 && inside != 8
        };
        (0..self.nodes()).filter(is_crossed)
    }

    /// The surface.
    pub fn surface(&self, solid: &dyn Field) -> Surface {
        let cells: Vec<usize> = self.crossed_cells().collect();
        let mut vertex_of = vec![u32::MAX; self.nodes()];
        let mut positions = Vec::with_capacity(cells.len());
        for (vertex, cell) in (0u32..).zip(&cells) {
            vertex_of[*cell] = vertex;
            positions.push(self.middle_of_crossings(self.place(*cell)));
        }
        self.move_onto(solid, &mut positions);
        let mut triangles = Vec::new();
        for node in 0..self.nodes() {
            let place = self.place(node);
            for axis in 0..3 {
                let (along, [one, two]) =
                    (IVec3::AXES[axis], [IVec3::AXES[(axis + 1) % 3], IVec3::AXES[(axis + 2) % 3]]);
                if (place + along).cmpge(self.size).any() || place[(axis + 1) % 3] < 1 || place[(axis + 2) % 3] < 1 {
                    continue;
                }
                let inside = [place, place + along].map(|place| self.is_inside(self.node(place)));
                if inside[0] == inside[1] {
                    continue;
                }
                let around = [place, place - one, place - one - two, place - two];
                let mut quad = around.map(|place| vertex_of[self.node(place)]);
                if quad.contains(&u32::MAX) {
                    continue;
                }
                // Seen from where the edge leads out.
                if inside[1] {
                    quad.reverse();
                }
                let [a, b, c, d] = quad;
                let length = |a: u32, b: u32| positions[a as usize].distance_squared(positions[b as usize]);
                if length(a, c) <= length(b, d) {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
        Surface { positions, triangles }
    }

    /// The mean of where a cell's edges cross the surface, by values that are linear between.
    fn middle_of_crossings(&self, place: IVec3) -> DVec3 {
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for by in corners() {
            for axis in IVec3::AXES.into_iter().filter(|axis| by.dot(*axis) == 0) {
                let ends = [place + by, place + by + axis];
                let [low, high] = ends.map(|end| f64::from(self.values[self.node(end)]));
                if (low >= 0.0) == (high >= 0.0) {
                    continue;
                }
                let share = low / (low - high);
                let share = if share.is_finite() { share } else { 0.5 };
                sum += ends[0].as_dvec3() + axis.as_dvec3() * share;
                count += 1.0;
            }
        }
        self.origin + sum / count * self.step
    }

    /// Moves vertices onto F = 0 by Newton's steps, each by at most a fraction of a cell.
    fn move_onto(&self, solid: &dyn Field, positions: &mut [DVec3]) {
        const STEPS: usize = 3;
        const MOST: f64 = 0.25;
        let mut evaluator = solid.evaluator();
        let mut out: Box<Gradients> = Box::default();
        for _ in 0..STEPS {
            for batch in positions.chunks_mut(BATCH) {
                evaluator.gradients(&Points::of_positions(batch), &mut out);
                for (i, position) in batch.iter_mut().enumerate() {
                    let slope = out.gradient(i).as_dvec3();
                    let by = -slope * f64::from(out.value[i]) / slope.length_squared();
                    if by.is_finite() {
                        *position += by.clamp_length_max(MOST * self.step);
                    }
                }
            }
        }
    }
}

fn corners() -> impl Iterator<Item = IVec3> {
    (0..8).map(|corner| IVec3::new(corner >> 2, corner >> 1 & 1, corner & 1))
}

impl Surface {
    /// A vertex of one piece and of another, where there is more than one.
    pub fn two_pieces(&self) -> Option<[DVec3; 2]> {
        let mut groups = Groups::new(self.positions.len());
        for [a, b, c] in &self.triangles {
            groups.join(*a, *b);
            groups.join(*b, *c);
        }
        let other = (0..self.positions.len() as u32).find(|vertex| groups.of(*vertex) != 0)?;
        Some([self.positions[0], self.positions[other as usize]])
    }

    /// For each of some positions the vertex that is there; `None` where one has none.
    pub fn order_of(&self, positions: &[DVec3]) -> Option<Vec<u32>> {
        let key = |position: &DVec3| position.to_array().map(f64::to_bits);
        let known: rustc_hash::FxHashMap<[u64; 3], u32> = self.positions.iter().map(key).zip(0..).collect();
        positions.iter().map(|position| known.get(&key(position)).copied()).collect()
    }
}
