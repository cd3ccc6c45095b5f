//! The generalised winding number: how often a surface, closed or not, goes round a point.
//!
//! Solid angles near the point are summed exactly (A. van Oosterom, J. Strackee, 1983), clusters of triangles far
//! from it as dipoles (G. Barill et al., Fast winding numbers for soups and clouds, 2018).

use std::f64::consts::PI;

use glam::DVec3;

use super::TriangleMesh;

/// Clusters farther than this many radii count as one dipole. Smaller is faster; at 2 the error of a smooth surface
/// reaches some hundredths, against a threshold of ½ from either side.
const FAR: f64 = 2.5;
/// Triangles in a leaf. Fewer cost memory, more cost exact solid angles.
const LEAF: usize = 8;

#[derive(Debug)]
struct Node {
    /// Area-weighted centre of the triangles.
    centre: DVec3,
    /// Distance from the centre to the farthest corner.
    radius: f64,
    /// Sum of area × outward normal.
    dipole: DVec3,
    /// Its triangles in the order of the tree.
    range: [u32; 2],
    /// The node after this one's whole subtree.
    next: u32,
}

/// A tree of clusters over a mesh's triangles.
#[derive(Debug)]
pub(super) struct Winding {
    /// In the order of the tree, with their numbers in the mesh.
    triangles: Vec<(u32, [DVec3; 3])>,
    nodes: Vec<Node>,
}

impl Winding {
    pub fn new(mesh: &TriangleMesh) -> Self {
        Self::of((0..mesh.triangles().len()).map(|t| (t as u32, mesh.corners(t))).collect())
    }

    /// The same of some triangles, each with its number.
    pub fn of(mut triangles: Vec<(u32, [DVec3; 3])>) -> Self {
        let mut nodes = Vec::new();
        build(&mut triangles, 0, &mut nodes);
        Self { triangles, nodes }
    }

    /// The winding number of the surface around `p`: 1 inside and 0 outside a closed mesh that faces outward.
    pub fn number(&self, p: DVec3) -> f64 {
        self.number_without(p, FAR, &[])
    }

    /// The same without some triangles, which pass through `p`. Clusters farther than `far` radii count as one dipole.
    pub fn number_without(&self, p: DVec3, far: f64, without: &[u32]) -> f64 {
        let mut solid_angle = 0.0;
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            let to = node.centre - p;
            let distance = to.length();
            let is_leaf = node.next as usize == at + 1;
            if distance > far * node.radius {
                solid_angle += node.dipole.dot(to) / (distance * distance * distance);
                at = node.next as usize;
                continue;
            }
            if is_leaf {
                let [from, to] = node.range.map(|i| i as usize);
                let counts = |(t, _): &&(u32, _)| !without.contains(t);
                let triangles = self.triangles[from..to].iter().filter(counts);
                solid_angle += triangles.map(|(_, corners)| exact(corners, p)).sum::<f64>();
            }
            at += 1;
        }
        solid_angle / (4.0 * PI)
    }
}

/// Appends the subtree over some triangles, halved at the median of the longest axis.
fn build(triangles: &mut [(u32, [DVec3; 3])], first: usize, nodes: &mut Vec<Node>) {
    let at = nodes.len();
    nodes.push(cluster(triangles, first));
    if triangles.len() > LEAF {
        let middle = |(_, c): &(u32, [DVec3; 3])| c[0] + c[1] + c[2];
        let low = triangles.iter().map(middle).fold(DVec3::INFINITY, DVec3::min);
        let high = triangles.iter().map(middle).fold(DVec3::NEG_INFINITY, DVec3::max);
        let axis = (high - low).max_position();
        let half = triangles.len() / 2;
        triangles.select_nth_unstable_by(half, |a, b| middle(a)[axis].total_cmp(&middle(b)[axis]));
        let (left, right) = triangles.split_at_mut(half);
        build(left, first, nodes);
        build(right, first + half, nodes);
    }
    nodes[at].next = nodes.len() as u32;
}

fn cluster(triangles: &[(u32, [DVec3; 3])], first: usize) -> Node {
    let mut dipole = DVec3::ZERO;
    let mut centre = DVec3::ZERO;
    let mut weight = 0.0;
    for (_, [a, b, c]) in triangles {
        let area_normal = (b - a).cross(c - a) * 0.5;
        let area = area_normal.length();
        dipole += area_normal;
        centre += (a + b + c) * (area / 3.0);
        weight += area;
    }
    let centre = if weight > 0.0 { centre / weight } else { triangles[0].1[0] };
    let radius = triangles.iter().flat_map(|(_, corners)| corners).map(|p| p.distance(centre)).fold(0.0, f64::max);
    Node { centre, radius, dipole, range: [first as u32, (first + triangles.len()) as u32], next: 0 }
}

/// The solid angle of one triangle, signed.
fn exact(corners: &[DVec3; 3], p: DVec3) -> f64 {
    let [a, b, c] = corners.map(|corner| corner - p);
    let (la, lb, lc) = (a.length(), b.length(), c.length());
    let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * libm::atan2(a.dot(b.cross(c)), below)
}
