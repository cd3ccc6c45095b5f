//! Angle-weighted normals of faces, sides and corners: the side of the closest surface a point is on
//! (J. A. Bærentzen, H. Aanæs, Signed distance computation using the angle weighted pseudonormal, 2005).

use glam::DVec3;

use super::closest::Part;
use super::{Topology, TriangleMesh};

/// Outward pseudonormals. A zero vector stands where none can be trusted: parts without an area, and sides and
/// corners where the surface is no manifold.
#[derive(Debug)]
pub(super) struct Pseudonormals {
    /// Unit normals.
    faces: Vec<DVec3>,
    /// Of each edge of the topology.
    edges: Vec<DVec3>,
    /// The edge of each side of each triangle.
    sides: Vec<[u32; 3]>,
    /// Of each welded vertex.
    vertices: Vec<DVec3>,
    /// The welded vertices of each triangle.
    corners: Vec<[u32; 3]>,
}

impl Pseudonormals {
    /// `touched` says of each triangle, unless it is empty, whether it touches others than its neighbours: no edge between
    /// two such is trusted.
    pub fn new(mesh: &TriangleMesh, topology: &Topology, touched: &[bool]) -> Self {
        let count = mesh.triangles().len();
        let faces: Vec<DVec3> = (0..count).map(|t| mesh.area_normal(t).normalize_or_zero()).collect();
        let corners: Vec<[u32; 3]> =
            mesh.triangles().iter().map(|triangle| triangle.map(|v| topology.welded[v as usize])).collect();
        let mut trusted = vec![true; topology.welded_count];
        let mut edges = Vec::with_capacity(topology.edges.len());
        let mut sides = vec![[u32::MAX; 3]; count];
        for (number, edge) in topology.edges.iter().enumerate() {
            let around: Vec<DVec3> = edge.uses.iter().map(|&(t, _)| faces[t as usize]).collect();
            let is_free = |&(t, _): &(u32, u8)| !touched.get(t as usize).is_some_and(|&touched| touched);
            let sound = edge.is_regular()
                && edge.uses.iter().any(is_free)
                && around.iter().all(|&normal| normal != DVec3::ZERO);
            edges.push(if sound { around[0] + around[1] } else { DVec3::ZERO });
            for end in edge.ends {
                trusted[end as usize] &= sound;
            }
            for &(t, side) in &edge.uses {
                sides[t as usize][side as usize] = number as u32;
            }
        }
        let vertices = vertex_normals(mesh, &faces, &corners, &trusted);
        Self { faces, edges, sides, vertices, corners }
    }

    /// The pseudonormal of a part of a triangle; zero where there is none to be trusted.
    pub fn of(&self, triangle: u32, part: Part) -> DVec3 {
        let triangle = triangle as usize;
        match part {
            Part::Face => self.faces[triangle],
            // A side of no length belongs to no edge.
            Part::Side(i) => self.edges.get(self.sides[triangle][i as usize] as usize).copied().unwrap_or(DVec3::ZERO),
            Part::Corner(i) => self.vertices[self.corners[triangle][i as usize] as usize],
        }
    }

    /// Whether every part has a pseudonormal.
    pub fn all_trusted(&self) -> bool {
        let all = [&self.faces, &self.edges, &self.vertices];
        all.into_iter().flatten().all(|&normal| normal != DVec3::ZERO)
    }

    /// The unit normal of a triangle; zero where it has no area.
    pub fn face(&self, triangle: u32) -> DVec3 {
        self.faces[triangle as usize]
    }
}

fn vertex_normals(mesh: &TriangleMesh, faces: &[DVec3], corners: &[[u32; 3]], trusted: &[bool]) -> Vec<DVec3> {
    let mut normals = vec![DVec3::ZERO; trusted.len()];
    for (t, face) in faces.iter().enumerate() {
        let positions = mesh.corners(t);
        for i in 0..3 {
            let (to, from) = (positions[(i + 1) % 3] - positions[i], positions[(i + 2) % 3] - positions[i]);
            normals[corners[t][i] as usize] += *face * angle(to, from);
        }
    }
    for (normal, trusted) in normals.iter_mut().zip(trusted) {
        if !trusted {
            *normal = DVec3::ZERO;
        }
    }
    normals
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}
