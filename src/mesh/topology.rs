//! How triangles hang together: which edges are shared, where holes are.
//!
//! Vertices at one position count as one, so a file that splits vertices at seams of colour or texture is closed
//! when its surface is.

use glam::DVec3;

use super::TriangleMesh;

/// An undirected edge between welded vertices, with the triangles around it.
#[derive(Clone, Debug)]
pub(super) struct Edge {
    /// The welded vertices, the lesser first.
    pub ends: [u32; 2],
    /// Triangle and side (0: first to second corner) of each use, in order of triangles.
    pub uses: Vec<(u32, u8)>,
    /// Uses from the lesser to the greater end minus uses the other way: 0 where orientations cancel.
    pub net: i32,
}

impl Edge {
    /// Two triangles that agree about which side is out.
    pub fn is_regular(&self) -> bool {
        self.uses.len() == 2 && self.net == 0
    }
}

/// A report of how a mesh hangs together, and the tables it was made from.
#[derive(Clone, Debug)]
pub struct Topology {
    /// Edges used by an odd number of triangles: the rims of holes.
    pub boundary_edges: usize,
    /// Edges used by an even number of triangles that do not pair up: neighbours that face opposite ways.
    pub inconsistent_edges: usize,
    /// Edges shared by more than two triangles.
    pub non_manifold_edges: usize,
    /// The welded vertex of each vertex.
    pub(super) welded: Vec<u32>,
    /// How many welded vertices there are.
    pub(super) welded_count: usize,
    /// All edges, by their ends.
    pub(super) edges: Vec<Edge>,
}

impl Topology {
    /// Every edge is used as often one way as the other.
    pub fn is_closed(&self) -> bool {
        self.boundary_edges == 0 && self.inconsistent_edges == 0
    }

    pub(super) fn of(mesh: &TriangleMesh) -> Self {
        let (welded, welded_count) = weld(mesh.positions());
        let edges = edges(mesh, &welded);
        let odd = |edge: &&Edge| edge.uses.len() % 2 == 1;
        Self {
            boundary_edges: edges.iter().filter(odd).count(),
            inconsistent_edges: edges.iter().filter(|edge| edge.uses.len() % 2 == 0 && edge.net != 0).count(),
            non_manifold_edges: edges.iter().filter(|edge| edge.uses.len() > 2).count(),
            welded,
            welded_count,
            edges,
        }
    }
}

/// Numbers positions so that equal ones (−0 and 0 too) have one number.
fn weld(positions: &[DVec3]) -> (Vec<u32>, usize) {
    let key = |&v: &u32| (positions[v as usize] + 0.0).to_array().map(f64::to_bits);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|v| (key(v), *v));
    let mut welded = vec![0; positions.len()];
    let mut count = 0;
    for pair in 0..order.len() {
        if pair > 0 && key(&order[pair]) != key(&order[pair - 1]) {
            count += 1;
        }
        welded[order[pair] as usize] = count;
    }
    (welded, count as usize + 1)
}

fn edges(mesh: &TriangleMesh, welded: &[u32]) -> Vec<Edge> {
    let mut uses: Vec<([u32; 2], u32, u8, i32)> = Vec::with_capacity(mesh.triangles().len() * 3);
    for (t, triangle) in mesh.triangles().iter().enumerate() {
        for side in 0..3 {
            let (a, b) = (welded[triangle[side] as usize], welded[triangle[(side + 1) % 3] as usize]);
            uses.push(([a.min(b), a.max(b)], t as u32, side as u8, (a < b) as i32 - (a > b) as i32));
        }
    }
    uses.sort_unstable();
    let same = |a: &([u32; 2], u32, u8, i32), b: &([u32; 2], u32, u8, i32)| a.0 == b.0;
    uses.chunk_by(same)
        .filter(|group| group[0].0[0] != group[0].0[1])
        .map(|group| Edge {
            ends: group[0].0,
            uses: group.iter().map(|&(_, triangle, side, _)| (triangle, side)).collect(),
            net: group.iter().map(|use_| use_.3).sum(),
        })
        .collect()
}
