//! The closed pieces of a mesh, and which way round they are wound.

use glam::DVec3;

use super::winding::Winding;
use super::{Topology, TriangleMesh};
use crate::field::Aabb;

/// Faces at which it is asked whether a piece lies in another. Fewer misjudge pieces that stick out, more cost time.
const ASKED: usize = 64;
/// A position counts as within a piece from this winding number on: less than the ½ of faces that touch its wall.
const WITHIN: f64 = 0.45;

/// A part of the surface that is closed by itself.
#[derive(Debug)]
pub(super) struct Piece {
    pub bounds: Aabb,
    /// Negative where it is wound inward.
    pub volume: f64,
    pub triangles: Vec<u32>,
}

/// The pieces of a closed mesh, in order of their first triangles. Triangles that share a side are in one piece,
/// except where more than two meet: there only those are joined that would not be closed otherwise.
pub(super) fn pieces(mesh: &TriangleMesh, topology: &Topology) -> Vec<Piece> {
    let count = mesh.triangles().len();
    let mut groups = Groups::new(count);
    let triangles = |edge: &super::topology::Edge| edge.uses.iter().map(|&(t, _)| t).collect::<Vec<_>>();
    for edge in topology.edges.iter().filter(|edge| edge.is_regular()) {
        groups.join(edge.uses[0].0, edge.uses[1].0);
    }
    for edge in topology.edges.iter().filter(|edge| !edge.is_regular()) {
        let mut nets: Vec<(u32, i32)> = Vec::new();
        for &(t, side) in &edge.uses {
            let group = groups.of(t);
            let from = topology.welded[mesh.triangles()[t as usize][side as usize] as usize];
            let way = if from == edge.ends[0] { 1 } else { -1 };
            match nets.iter_mut().find(|(other, _)| *other == group) {
                Some((_, net)) => *net += way,
                None => nets.push((group, way)),
            }
        }
        let open: Vec<u32> = nets.into_iter().filter(|(_, net)| *net != 0).map(|(group, _)| group).collect();
        for pair in open.windows(2) {
            groups.join(pair[0], pair[1]);
        }
    }
    // A triangle without three different corners bounds nothing, and belongs to its neighbour.
    for edge in topology.edges.iter().filter(|edge| edge.uses.len() > 2) {
        let flat = |t: u32| mesh.area_normal(t as usize) == DVec3::ZERO;
        for pair in triangles(edge).windows(2).filter(|pair| flat(pair[0]) || flat(pair[1])) {
            groups.join(pair[0], pair[1]);
        }
    }
    let mut number = vec![u32::MAX; count];
    let mut members: Vec<Vec<u32>> = Vec::new();
    for t in 0..count as u32 {
        let group = groups.of(t) as usize;
        if number[group] == u32::MAX {
            number[group] = members.len() as u32;
            members.push(Vec::new());
        }
        members[number[group] as usize].push(t);
    }
    members.into_iter().map(|triangles| piece(mesh, triangles)).collect()
}

fn piece(mesh: &TriangleMesh, triangles: Vec<u32>) -> Piece {
    let empty = Aabb::new(DVec3::INFINITY, DVec3::NEG_INFINITY);
    let corners = triangles.iter().flat_map(|&t| mesh.corners(t as usize));
    let bounds = corners.fold(empty, |all, p| Aabb::new(all.min.min(p), all.max.max(p)));
    let middle = bounds.centre();
    let six_times = |&t: &u32| {
        let [a, b, c] = mesh.corners(t as usize).map(|p| p - middle);
        a.dot(b.cross(c))
    };
    let volume = triangles.iter().map(six_times).sum::<f64>() / 6.0;
    Piece { bounds, volume, triangles }
}

/// Whether the boxes of any two pieces overlap: sweeps along x, quadratic only where many share a stretch of x.
pub(super) fn any_overlap(pieces: &[Piece]) -> bool {
    let mut boxes: Vec<Aabb> = pieces.iter().map(|piece| piece.bounds).collect();
    boxes.sort_by(|a, b| a.min.x.total_cmp(&b.min.x));
    boxes.iter().enumerate().any(|(i, first)| {
        let reached = boxes[i + 1..].iter().take_while(|second| second.min.x <= first.max.x);
        reached.into_iter().any(|second| first.intersection(*second).is_some())
    })
}

/// The pieces that are to be turned over: those wound inward that lie in no other (one that lies mostly in another is a
/// hollow in it), and with them what lies in them, so that their own hollows stay hollows.
pub(super) fn inside_out(mesh: &TriangleMesh, pieces: &[Piece]) -> Vec<usize> {
    let is_inward = |piece: &Piece| {
        let size = piece.bounds.size().max_element();
        piece.volume < -1e-12 * size * size * size
    };
    if !pieces.iter().any(is_inward) {
        return Vec::new();
    }
    // Largest first, so that what holds a piece comes before it.
    let mut order: Vec<usize> = (0..pieces.len()).collect();
    order.sort_by(|&a, &b| pieces[b].volume.abs().total_cmp(&pieces[a].volume.abs()).then(a.cmp(&b)));
    let mut windings: Vec<Option<Winding>> = pieces.iter().map(|_| None).collect();
    let mut turned = vec![false; pieces.len()];
    for (place, &inner) in order.iter().enumerate() {
        let holder = order[..place].iter().rev().copied().find(|&outer| {
            let overlap = pieces[outer].bounds.intersection(pieces[inner].bounds).is_some();
            overlap && {
                let of = |t: &u32| (*t, mesh.corners(*t as usize));
                let winding = windings[outer]
                    .get_or_insert_with(|| Winding::of(pieces[outer].triangles.iter().map(of).collect()));
                lies_in(mesh, &pieces[inner], winding)
            }
        });
        turned[inner] = holder.map_or_else(|| is_inward(&pieces[inner]), |holder| turned[holder]);
    }
    (0..pieces.len()).filter(|&piece| turned[piece]).collect()
}

/// Whether most of a piece lies in what a winding number goes round.
fn lies_in(mesh: &TriangleMesh, piece: &Piece, winding: &Winding) -> bool {
    let step = piece.triangles.len().div_ceil(ASKED);
    let asked: Vec<u32> = piece.triangles.iter().copied().step_by(step).collect();
    let within = |&&t: &&u32| {
        let [a, b, c] = mesh.corners(t as usize);
        winding.number((a + b + c) / 3.0).abs() > WITHIN
    };
    asked.iter().filter(within).count() * 2 > asked.len()
}

/// Numbers joined into groups.
pub(crate) struct Groups(Vec<u32>);

impl Groups {
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The least number of the group that a number is in.
    pub fn of(&mut self, mut v: u32) -> u32 {
        while self.0[v as usize] != v {
            self.0[v as usize] = self.0[self.0[v as usize] as usize];
            v = self.0[v as usize];
        }
        v
    }

    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}
