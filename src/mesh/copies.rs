//! Triangles that are there more than once, on the same three vertices in the same order.

use super::{Topology, TriangleMesh};

/// The first of each set of copies, left out of the mesh; the triangles taken out come second, in rising order.
/// `None` where there are no copies.
pub(super) fn without_copies(mesh: &TriangleMesh, topology: &Topology) -> Option<(TriangleMesh, Vec<u32>)> {
    // All sides of a triangle and its copy are used twice the same way.
    let crowded = topology.edges.iter().filter(|edge| !edge.is_regular());
    let mut suspects: Vec<u32> = crowded.flat_map(|edge| edge.uses.iter().map(|&(t, _)| t)).collect();
    suspects.sort_unstable();
    suspects.dedup();
    let mut keyed: Vec<([u32; 3], u32)> = suspects.into_iter().map(|t| (key(mesh, topology, t), t)).collect();
    keyed.sort_unstable();
    let copies = keyed.chunk_by(|a, b| a.0 == b.0).flat_map(|same| same[1..].iter().map(|&(_, t)| t));
    let mut copies: Vec<u32> = copies.collect();
    copies.sort_unstable();
    if copies.is_empty() {
        return None;
    }
    let stays = |&(t, _): &(usize, &[u32; 3])| copies.binary_search(&(t as u32)).is_err();
    let triangles = mesh.triangles().iter().enumerate().filter(stays).map(|(_, &triangle)| triangle).collect();
    Some((mesh.with_triangles(triangles), copies))
}

/// The welded vertices in their order around the triangle, the least first.
fn key(mesh: &TriangleMesh, topology: &Topology, triangle: u32) -> [u32; 3] {
    let mut corners = mesh.triangles()[triangle as usize].map(|v| topology.welded[v as usize]);
    let least = (0..3).min_by_key(|&i| corners[i]).unwrap_or(0);
    corners.rotate_left(least);
    corners
}
