//! A mesh as a distance object: closest triangle anywhere, and the side it is on.

use std::cell::Cell;

use glam::{DVec2, DVec3};
use parry3d_f64::bounding_volume::Aabb as ParryBox;
use parry3d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use rayon::prelude::*;

use super::closest::{Closest, Part, closest, closest_of_sides};
use super::copies::without_copies;
use super::material::PicturePlace;
use super::pseudonormals::Pseudonormals;
use super::solid::boundary;
use super::visit::visit;
use super::winding::Winding;
use super::{MeshEvaluator, Problem, Topology, TriangleMesh};
use crate::distance::{Distance, Foot};
use crate::field::{Aabb, Evaluator, Field, Slope};

/// What to do with a surface that has holes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Holes {
    /// Refuse it, saying how many edges are open.
    Refuse,
    /// Take for inside what the surface goes round by more than half (generalised winding number). F then jumps
    /// from inside to outside across each hole.
    Allow,
    /// Refuse it. Of a closed one that is inside which the surface goes round an odd number of times: what lies in one piece
    /// is a hollow, in two solid again, whichever way they are wound.
    Parity,
}

/// Whether a closed surface with this winding number goes round an odd number of times: it is a whole number, to what
/// clusters are off by.
fn is_odd(number: f64) -> bool {
    number.round() as i64 % 2 != 0
}

/// Which triangles have on their outer side what is inside by parity. One that others cross may have it on a part alone: the
/// sign does not go by its normal.
fn faces_inward(mesh: &TriangleMesh, winding: &Winding) -> Vec<bool> {
    /// How far off the surface it is looked, against the mesh's size: far above rounding, far below features.
    const OFF: f64 = 1e-7;
    let off = OFF * mesh.bounding_box().size().length();
    let inward = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        is_odd(winding.number((a + b + c) / 3.0 + normal * off))
    };
    (0..mesh.triangles().len()).into_par_iter().map(inward).collect()
}

/// The closest point of a mesh.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    /// The point, in world units.
    pub point: DVec3,
    /// Its squared distance.
    pub distance_squared: f64,
    /// The triangle it lies on; of several as close, the first in the mesh.
    pub triangle: u32,
    /// Weights of the triangle's second and third corner; the first has the rest to 1.
    pub weights: [f64; 2],
    /// Which part of the triangle it lies on.
    pub part: Part,
}

impl Nearest {
    /// Of no triangle: any is nearer.
    pub(super) const NONE: Self = Self {
        point: DVec3::ZERO,
        distance_squared: f64::INFINITY,
        triangle: u32::MAX,
        weights: [0.0; 2],
        part: Part::Face,
    };

    /// Whether it is nearer than another, or as near and of an earlier triangle: which of several wins does not depend on the
    /// order they come in.
    pub(super) fn is_before(&self, other: &Self) -> bool {
        let as_near = self.distance_squared == other.distance_squared;
        self.distance_squared < other.distance_squared || as_near && self.triangle < other.triangle
    }
}

/// A triangle mesh as a field: the exact signed distance, positive inside, with its foot.
///
/// A closed mesh is asked for the solid that its winding number gives ([`super::solid`] has the rules), and distances
/// are to that solid's boundary alone. The side is that of the closest part's angle-weighted normal where the surface
/// is one closed manifold there, and that of the winding number elsewhere: at parts without an area, where parts of
/// crossing faces meet, for open meshes.
#[derive(Debug)]
pub struct MeshDistance {
    mesh: TriangleMesh,
    bounds: Aabb,
    normals: Pseudonormals,
    tree: Bvh,
    /// Whether pseudonormals decide where there are any.
    normals_decide: bool,
    by_parity: bool,
    winding: Option<Winding>,
    /// Edges where orientations do not cancel, each with how much is left over. Empty for a closed mesh.
    rim: Vec<([DVec3; 2], f64)>,
    notes: Vec<String>,
}

impl MeshDistance {
    /// The half-spaces n · p ≤ o, as outward unit normals and offsets, whose intersection is the inside of a convex
    /// mesh of few faces; `None` for others.
    pub fn half_spaces(&self) -> Option<Vec<(DVec3, f64)>> {
        super::convex::half_spaces(&self.mesh)
    }

    /// Prepares a mesh for queries. A mesh that faces inward as a whole is turned over; of a closed one what is no
    /// boundary of its solid is left out.
    pub fn new(mut mesh: TriangleMesh, holes: Holes) -> Result<Self, Problem> {
        if mesh.volume() < 0.0 {
            mesh.flip();
        }
        let mut topology = mesh.topology();
        let mut notes = Vec::new();
        if let Some((single, copies)) = without_copies(&mesh, &topology) {
            let of_single = single.topology();
            if of_single.is_closed() {
                notes.push(note_on_copies(&mesh, &copies));
                (mesh, topology) = (single, of_single);
            }
        }
        let closed = topology.is_closed();
        if holes != Holes::Allow && !closed {
            return Err(Problem::Open {
                boundary_edges: topology.boundary_edges,
                inconsistent_edges: topology.inconsistent_edges,
            });
        }
        let mut tree = tree(&mesh);
        let mut touched = Vec::new();
        let by_parity = holes == Holes::Parity;
        if closed && !by_parity {
            // A surface that encloses nothing may be meant as a sheet, where any surface will do.
            let whole = (holes == Holes::Allow).then(|| mesh.clone());
            match (boundary(mesh, &topology, &tree), whole) {
                (Ok(boundary), _) => {
                    notes.extend(boundary.notes);
                    (mesh, touched) = (boundary.mesh, boundary.touched);
                    if boundary.changed {
                        tree = self::tree(&mesh);
                        topology = mesh.topology();
                    }
                }
                (Err(Problem::NoVolume), Some(whole)) => mesh = whole,
                (Err(problem), _) => return Err(problem),
            }
        }
        let own_winding = by_parity.then(|| Winding::new(&mesh));
        if let Some(winding) = &own_winding {
            mesh.flip_those(&faces_inward(&mesh, winding));
        }
        let normals = Pseudonormals::new(&mesh, &topology, &touched);
        let sound = closed && !by_parity && normals.all_trusted();
        Ok(Self {
            bounds: mesh.bounding_box(),
            winding: own_winding.or_else(|| (!sound).then(|| Winding::new(&mesh))),
            rim: if closed { Vec::new() } else { rim(&mesh, &topology) },
            tree,
            normals,
            normals_decide: closed && !by_parity,
            by_parity,
            mesh,
            notes,
        })
    }

    /// The mesh: of a closed one the boundary of its solid.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// What a user should know of the mesh that was given: how it differs from the boundary of its solid, and where.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The closest point of the mesh.
    pub fn nearest(&self, position: DVec3) -> Nearest {
        self.nearest_within(position, f64::INFINITY)
    }

    /// The scene-linear colour at a point of the surface, or `None` where the mesh has no colours.
    pub fn colour(&self, nearest: &Nearest) -> Option<[f32; 3]> {
        let colours = self.mesh.colours()?;
        let [a, b, c] = self.mesh.triangles()[nearest.triangle as usize].map(|v| colours[v as usize]);
        let [v, w] = nearest.weights.map(|weight| weight as f32);
        let u = 1.0 - v - w;
        // The weights' rounding must not carry a colour beyond those of the corners.
        let mixed = |i: usize| {
            let (least, most) = (a[i].min(b[i]).min(c[i]), a[i].max(b[i]).max(c[i]));
            (a[i] * u + b[i] * v + c[i] * w).clamp(least, most)
        };
        Some(std::array::from_fn(mixed))
    }

    /// The place in a material's picture at a point of the surface, or `None` where the mesh has none.
    pub fn place(&self, nearest: &Nearest) -> Option<PicturePlace> {
        let places = self.mesh.places()?;
        let corners = self.mesh.triangles()[nearest.triangle as usize].map(|v| places[v as usize]);
        Some(PicturePlace::between(corners, nearest.weights))
    }

    /// How much longer a way in a picture is than on a triangle, as the roots of the areas are: 1 ÷ world units, for a
    /// picture of one by one. 0 where the triangle has no area.
    pub fn places_a_unit(&self, triangle: u32) -> f32 {
        let Some(places) = self.mesh.places() else { return 0.0 };
        let [a, b, c] =
            self.mesh.triangles()[triangle as usize].map(|v| DVec2::from(places[v as usize].place.map(f64::from)));
        let (in_picture, on_mesh) = ((b - a).perp_dot(c - a).abs(), self.mesh.area_normal(triangle as usize).length());
        if on_mesh > 0.0 { (in_picture / on_mesh).sqrt() as f32 } else { 0.0 }
    }

    /// Whether a position is inside, given its closest point.
    pub fn is_inside(&self, position: DVec3, nearest: &Nearest) -> bool {
        if self.normals_decide {
            let normal = self.normals.of(nearest.triangle, nearest.part);
            if normal != DVec3::ZERO {
                return (position - nearest.point).dot(normal) <= 0.0;
            }
        }
        let goes_round = |number: f64| if self.by_parity { is_odd(number) } else { number > 0.5 };
        self.winding_number(position).is_some_and(goes_round) && self.bounds.contains(position)
    }

    /// An evaluator that also gives closest points.
    pub fn mesh_evaluator(&self) -> MeshEvaluator<'_> {
        MeshEvaluator::new(self)
    }

    /// The closest point, where one is known to lie within some distance. The answer does not depend on it. From what is no
    /// number the distance is none.
    pub(super) fn nearest_within(&self, position: DVec3, within: f64) -> Nearest {
        if position.is_nan() {
            return self.nearest_on(0, position);
        }
        // A little more than asked for, so that rounding hides nobody.
        let within = Nearest { distance_squared: within * within * (1.0 + 1e-9), ..Nearest::NONE };
        let best = Cell::new(within);
        let p = position.to_array();
        self.tree.find_best(
            f64::INFINITY,
            |node: &BvhNode, _| {
                let distance_squared = box_distance_squared(node, p);
                if distance_squared > best.get().distance_squared { f64::MAX } else { distance_squared }
            },
            |triangle, _| {
                let found = self.nearest_on(triangle, position);
                if found.is_before(&best.get()) {
                    best.set(found);
                }
                None::<f64>
            },
        );
        if best.get().triangle == u32::MAX {
            // Nothing within: the caller's bound was wrong, which rounding at huge coordinates can do.
            debug_assert!(within.distance_squared < f64::INFINITY);
            return self.nearest_within(position, f64::INFINITY);
        }
        best.get()
    }

    /// The triangles' boxes.
    pub(super) fn tree(&self) -> &Bvh {
        &self.tree
    }

    /// Calls with every triangle whose box, grown by `margin`, meets the region, until told to stop.
    pub(super) fn visit(&self, region: &Aabb, margin: f64, mut stop: impl FnMut(u32) -> bool) {
        visit(&self.tree, region, margin, &mut stop);
    }

    /// The outward unit normal of a triangle; zero where it has no area.
    pub(super) fn face_normal(&self, triangle: u32) -> DVec3 {
        self.normals.face(triangle)
    }

    /// The outward pseudonormal at a closest point, of any length; that of the face where there is no better.
    pub(super) fn normal(&self, nearest: &Nearest) -> DVec3 {
        let normal = self.normals.of(nearest.triangle, nearest.part);
        if normal != DVec3::ZERO { normal } else { self.normals.face(nearest.triangle) }
    }

    /// The winding number, where the sign may need it.
    pub(super) fn winding_number(&self, position: DVec3) -> Option<f64> {
        self.winding.as_ref().map(|winding| winding.number(position))
    }

    /// Whether the sign changes across the surface only.
    pub(super) fn is_closed(&self) -> bool {
        self.rim.is_empty()
    }

    /// The most that the winding number can change within `reach` of a position when no surface lies there, or
    /// infinity.
    ///
    /// The gradient of a solid angle is the field of a current along the surface's rim (Biot and Savart), so it is
    /// at most length ÷ (4π r²) at a distance r from all of it.
    pub(super) fn winding_change(&self, position: DVec3, reach: f64) -> f64 {
        let distance = |[a, b]: [DVec3; 2]| closest_of_sides([a, b, b], position).point.distance(position);
        let nearest = self.rim.iter().map(|(ends, _)| distance(*ends)).fold(f64::INFINITY, f64::min) - reach;
        let length: f64 = self.rim.iter().map(|([a, b], times)| a.distance(*b) * times).sum();
        if nearest > 0.0 { reach * length / (4.0 * std::f64::consts::PI * nearest * nearest) } else { f64::INFINITY }
    }

    fn closest_on(&self, triangle: u32, position: DVec3) -> Closest {
        let corners = self.mesh.corners(triangle as usize);
        if self.normals.face(triangle) == DVec3::ZERO {
            closest_of_sides(corners, position)
        } else {
            closest(corners, position)
        }
    }

    /// The closest point of one triangle.
    pub(super) fn nearest_on(&self, triangle: u32, position: DVec3) -> Nearest {
        let Closest { point, weights, part } = self.closest_on(triangle, position);
        Nearest { point, distance_squared: point.distance_squared(position), triangle, weights, part }
    }

    pub(super) fn foot_of(&self, position: DVec3, nearest: &Nearest, inside: bool) -> Foot {
        let length = nearest.distance_squared.sqrt();
        let distance = if inside { length } else { -length };
        let apart = (position - nearest.point) / distance;
        // Closer than rounding can tell a direction, the surface's own normal is better than the quotient.
        let scale = position.abs().max_element().max(self.bounds.size().max_element());
        let on_surface = length <= 1e-9 * scale;
        let gradient = if on_surface { -self.normal(nearest).normalize_or(DVec3::Z) } else { apart.normalize() };
        Foot { point: nearest.point, distance, gradient, part: nearest.triangle }
    }

    /// The closest surface point to a position.
    pub(super) fn foot(&self, position: DVec3) -> Foot {
        let nearest = self.nearest(position);
        self.foot_of(position, &nearest, self.is_inside(position, &nearest))
    }
}

impl Field for MeshDistance {
    fn bounding_box(&self) -> Option<Aabb> {
        Some(self.bounds)
    }

    fn slope(&self) -> Slope {
        if self.is_closed() { Slope::Exact { outside: true, inside: true } } else { Slope::Unknown }
    }

    fn reference(&self, position: DVec3) -> f64 {
        self.foot(position).distance
    }

    fn evaluator(&self) -> Box<dyn Evaluator + '_> {
        Box::new(self.mesh_evaluator())
    }
}

impl Distance for MeshDistance {
    fn closest_points(&self, positions: &[DVec3], closest: &mut [Foot]) -> bool {
        positions.iter().zip(closest).for_each(|(position, closest)| *closest = self.foot(*position));
        true
    }
}

fn tree(mesh: &TriangleMesh) -> Bvh {
    let boxes = (0..mesh.triangles().len()).map(|t| {
        let corners = mesh.corners(t);
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        // The closest point of a triangle may lie outside its box by rounding.
        let slack = 1e-12 * low.abs().max(high.abs()).max_element();
        let (low, high) = (low - slack, high + slack);
        (t, ParryBox::new(low.to_array().into(), high.to_array().into()))
    });
    Bvh::from_iter(BvhBuildStrategy::Binned, boxes)
}

fn note_on_copies(mesh: &TriangleMesh, copies: &[u32]) -> String {
    let [a, b, c] = mesh.corners(copies[0] as usize);
    let at = (a + b + c) / 3.0;
    format!(
        "{} triangles are there more than once, one at ({:.4}, {:.4}, {:.4}): each counts once; delete doubled faces \
         to be rid of this",
        copies.len(),
        at.x,
        at.y,
        at.z
    )
}

fn rim(mesh: &TriangleMesh, topology: &Topology) -> Vec<([DVec3; 2], f64)> {
    let ends = |&(triangle, side): &(u32, u8)| {
        let corners = mesh.corners(triangle as usize);
        [corners[side as usize], corners[(side as usize + 1) % 3]]
    };
    let open = topology.edges.iter().filter(|edge| edge.net != 0);
    open.map(|edge| (ends(&edge.uses[0]), f64::from(edge.net.abs()))).collect()
}

fn box_distance_squared(node: &BvhNode, p: [f64; 3]) -> f64 {
    let (low, high) = (node.mins().to_array(), node.maxs().to_array());
    let apart = |i: usize| (low[i] - p[i]).max(p[i] - high[i]).max(0.0);
    let [x, y, z] = [apart(0), apart(1), apart(2)];
    x * x + y * y + z * z
}
