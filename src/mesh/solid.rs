//! The solid that a closed surface bounds, and the part of the surface that is its boundary.
//!
//! **Rules.** A position is inside where the winding number is not 0. Each closed piece faces outward by itself, which
//! way round it is wound; one that lies mostly in another piece keeps its way, so that a piece wound inward is a hollow
//! in the one around it. Faces with the same side before and behind (inside another piece, back to back) are no
//! boundary; those that others cross are cut along the crossings, and only the parts on the boundary stay.
//!
//! **Guaranteed:** a surface that nothing crosses or touches, whose pieces neither lie in one another nor face inward,
//! stays as it is to the bit. The others' boundary is off by at most [`TOLERANCE`] of the mesh's size. The winding
//! number of a part is that at its middle, where what passes through it (its own triangle, and others in one plane with
//! it) counts by its orientation and the rest by its solid angle.

use glam::DVec3;
use parry3d_f64::partitioning::Bvh;
use rayon::prelude::*;

use super::closest::closest;
use super::contact::{Face, PARALLEL};
use super::cut::{Corner, parts};
use super::material::PicturePlace;
use super::pieces::{Groups, Piece, any_overlap, inside_out, pieces};
use super::visit::visit;
use super::winding::Winding;
use super::{Problem, Topology, TriangleMesh};
use crate::field::Aabb;

/// Surfaces nearer than this share of the mesh's size count as touching: what is left between two that should be one
/// after their coordinates were rounded to single precision. Less leaves skins between them, more closes real gaps.
const TOLERANCE: f64 = 1e-7;
/// Clusters farther than this many radii count as one dipole: exact enough to tell whole numbers apart.
const FAR: f64 = 5.0;
/// Segments that all triangles together are cut along. More would take minutes and gigabytes.
const MOST_CUTS: usize = 5_000_000;

/// The boundary of a mesh's solid.
pub(super) struct Boundary {
    pub mesh: TriangleMesh,
    /// Whether it has other triangles than the mesh given.
    pub changed: bool,
    /// By triangle: whether it touches others than its neighbours, so that the sides around its edges are not known
    /// from its normal. Empty where none does.
    pub touched: Vec<bool>,
    /// What a user should know of the mesh.
    pub notes: Vec<String>,
}

/// The boundary of the solid of a closed mesh.
pub(super) fn boundary(mesh: TriangleMesh, topology: &Topology, tree: &Bvh) -> Result<Boundary, Problem> {
    let size = mesh.bounding_box().size().max_element();
    let farthest = mesh.positions().iter().fold(0.0_f64, |most, p| most.max(p.abs().max_element()));
    let tolerance = TOLERANCE * size + 1e-14 * farthest;
    let pieces = pieces(&mesh, topology);
    let mut notes = Vec::new();
    let mesh = turned_over(mesh, &pieces, &mut notes);
    let turned = !notes.is_empty();
    let contacts = Contacts::of(&mesh, topology, tree, tolerance)?;
    if !contacts.any && !any_overlap(&pieces) {
        return Ok(Boundary { mesh, changed: turned, touched: Vec::new(), notes });
    }
    let sides = Sides { winding: Winding::new(&mesh), tree, mesh: &mesh, faces: &contacts.faces, tolerance };
    let outcomes = outcomes(&sides, topology, &contacts);
    contacts.note(&outcomes, &pieces, &mesh, &mut notes);
    let mesh_is_whole = outcomes.iter().all(|outcome| matches!(outcome, Outcome::Whole { turned: false }));
    if mesh_is_whole {
        return Ok(Boundary { mesh, changed: turned, touched: contacts.touched, notes });
    }
    let (mesh, touched) = assemble(&mesh, &outcomes, &contacts.touched)?;
    Ok(Boundary { mesh, changed: true, touched, notes })
}

fn turned_over(mesh: TriangleMesh, pieces: &[Piece], notes: &mut Vec<String>) -> TriangleMesh {
    let turned = inside_out(&mesh, pieces);
    let Some(&first) = turned.first() else { return mesh };
    let mut triangles = mesh.triangles().to_vec();
    for &piece in &turned {
        pieces[piece].triangles.iter().for_each(|&t| triangles[t as usize].swap(1, 2));
    }
    notes.push(format!(
        "{} wound inside out, {} around {}: turned over; unify the normals to be rid of this",
        of_pieces(turned.len(), pieces.len()),
        if turned.len() == 1 { "the one" } else { "one of them" },
        place(pieces[first].bounds.centre()),
    ));
    mesh.with_triangles(triangles)
}

/// "2 of 7 pieces are".
fn of_pieces(some: usize, all: usize) -> String {
    format!("{some} of {all} pieces {}", if some == 1 { "is" } else { "are" })
}

fn place(p: DVec3) -> String {
    format!("({:.4}, {:.4}, {:.4})", p.x, p.y, p.z)
}

/// Where triangles meet others that are not their neighbours there.
struct Contacts {
    faces: Vec<Face>,
    touched: Vec<bool>,
    any: bool,
    /// Triangles that others cut, with the segments, in rising order.
    cuts: Vec<(u32, Vec<[DVec3; 2]>)>,
}

impl Contacts {
    fn of(mesh: &TriangleMesh, topology: &Topology, tree: &Bvh, tolerance: f64) -> Result<Self, Problem> {
        let count = mesh.triangles().len();
        let face = |t: usize| {
            let corners = mesh.corners(t);
            let longest = (0..3).map(|i| corners[i].distance(corners[(i + 1) % 3])).fold(0.0, f64::max);
            let area_normal = mesh.area_normal(t);
            // A sliver far below the tolerance has no direction, and its neighbours lie where it lies.
            let has_area = area_normal.length() > 1e-3 * tolerance * longest;
            let normal = if has_area { area_normal.normalize_or_zero() } else { DVec3::ZERO };
            Face { corners, welded: mesh.triangles()[t].map(|v| topology.welded[v as usize]), normal }
        };
        let faces: Vec<Face> = (0..count).into_par_iter().map(face).collect();
        let meeting = |t: usize| {
            let face = &faces[t];
            let (mut cuts, mut met) = (Vec::new(), Vec::new());
            if face.normal == DVec3::ZERO {
                return (cuts, met);
            }
            let [a, b, c] = face.corners;
            visit(tree, &Aabb::new(a.min(b).min(c), a.max(b).max(c)), tolerance, |other| {
                let other_face = &faces[other as usize];
                let is_other = other as usize != t && other_face.normal != DVec3::ZERO;
                if is_other && face.meets(other_face, tolerance, &mut cuts) {
                    met.push(other);
                }
                cuts.len() > MOST_CUTS
            });
            (cuts, met)
        };
        let mut all = Self { touched: vec![false; count], any: false, cuts: Vec::new(), faces: Vec::new() };
        let mut total = 0;
        // Chunk by chunk, so that a hopeless mesh is given up before its segments fill the memory.
        for first in (0..count).step_by(1 << 16) {
            let found: Vec<_> = (first..count.min(first + (1 << 16))).into_par_iter().map(meeting).collect();
            for (i, (cuts, met)) in found.into_iter().enumerate() {
                all.any |= !met.is_empty();
                all.touched[first + i] |= !met.is_empty();
                met.into_iter().for_each(|other| all.touched[other as usize] = true);
                total += cuts.len();
                if !cuts.is_empty() {
                    all.cuts.push(((first + i) as u32, cuts));
                }
            }
            if total > MOST_CUTS {
                return Err(Problem::Tangled);
            }
        }
        all.faces = faces;
        Ok(all)
    }

    /// Says what of the mesh is not boundary, and why.
    fn note(&self, outcomes: &[Outcome], pieces: &[Piece], mesh: &TriangleMesh, notes: &mut Vec<String>) {
        let is_gone = |&t: &u32| matches!(outcomes[t as usize], Outcome::Gone);
        let lies_in = |piece: &&Piece| piece.triangles.iter().all(is_gone);
        let inner: Vec<&Piece> = pieces.iter().filter(lies_in).collect();
        let is_whole = |t: u32| matches!(outcomes[t as usize], Outcome::Whole { .. });
        if let Some((_, segments)) = self.cuts.iter().find(|(t, _)| !is_whole(*t)) {
            let [from, to] = segments[0];
            notes.push(format!(
                "{} of {} triangles cross or cover others, one near {}: the surface is that of all the pieces as one \
                 solid; unite them before the export to be rid of this",
                self.cuts.len(),
                mesh.triangles().len(),
                place((from + to) * 0.5),
            ));
        }
        if let Some(first) = inner.first() {
            notes.push(format!(
                "{} within others or without volume, {} around {}: left out; a hollow is a piece wound inward",
                of_pieces(inner.len(), pieces.len()),
                if inner.len() == 1 { "the one" } else { "one of them" },
                place(first.bounds.centre()),
            ));
        }
    }
}

/// What becomes of a triangle.
enum Outcome {
    Gone,
    Whole { turned: bool },
    Parts(Vec<(Vec<Corner>, bool)>),
}

/// Tells the sides of the surface apart.
struct Sides<'a> {
    winding: Winding,
    tree: &'a Bvh,
    mesh: &'a TriangleMesh,
    faces: &'a [Face],
    tolerance: f64,
}

impl Sides<'_> {
    /// Whether a position in a triangle is on the boundary, and if so whether the triangle faces inward there. Of several
    /// in one plane the first is the boundary.
    fn at(&self, triangle: u32, position: DVec3) -> Option<bool> {
        let normal = self.faces[triangle as usize].normal;
        let mut through = Vec::new();
        visit(self.tree, &Aabb::new(position, position), self.tolerance, |other| {
            let face = &self.faces[other as usize];
            let along = face.normal.dot(normal);
            if other == triangle || along.abs() > PARALLEL && distance(face, position) <= self.tolerance {
                through.push((other, along > 0.0));
            }
            false
        });
        through.sort_unstable();
        let skipped: Vec<u32> = through.iter().map(|&(other, _)| other).collect();
        let rest = self.winding.number_without(position, FAR, &skipped);
        let jump: f64 = through.iter().map(|&(_, same)| if same { 1.0 } else { -1.0 }).sum();
        let is_in = |number: f64| number.round() != 0.0;
        let (before, behind) = (is_in(rest - 0.5 * jump), is_in(rest + 0.5 * jump));
        let is_first = through.first().is_some_and(|&(first, _)| first == triangle);
        (before != behind && is_first).then_some(before)
    }

    /// A part of a triangle; `None` where it is too narrow to tell: then its neighbours are as near.
    fn of_part(&self, triangle: u32, part: &[Corner]) -> Option<Option<bool>> {
        let normal = self.faces[triangle as usize].normal;
        let middle = part.iter().map(|corner| corner.position).sum::<DVec3>() / part.len() as f64;
        let to_side = |i: usize| {
            let (from, to) = (part[i].position, part[(i + 1) % part.len()].position);
            normal.cross(to - from).normalize_or_zero().dot(middle - from)
        };
        let inner_radius = (0..part.len()).map(to_side).fold(f64::INFINITY, f64::min);
        (inner_radius > 2.0 * self.tolerance).then(|| self.at(triangle, middle))
    }
}

fn distance(face: &Face, position: DVec3) -> f64 {
    closest(face.corners, position).point.distance(position)
}

/// What becomes of every triangle.
fn outcomes(sides: &Sides, topology: &Topology, contacts: &Contacts) -> Vec<Outcome> {
    let count = sides.mesh.triangles().len();
    let has_area = |t: u32| contacts.faces[t as usize].normal != DVec3::ZERO;
    // From one triangle that touches nothing to the next the sides stay the same.
    let mut groups = Groups::new(count);
    let is_free = |t: u32| !contacts.touched[t as usize] && has_area(t);
    for edge in topology.edges.iter().filter(|edge| edge.is_regular()) {
        let (a, b) = (edge.uses[0].0, edge.uses[1].0);
        if is_free(a) && is_free(b) {
            groups.join(a, b);
        }
    }
    let group: Vec<u32> = (0..count as u32).map(|t| groups.of(t)).collect();
    let area = |t: u32| sides.mesh.area_normal(t as usize).length_squared();
    let mut largest: Vec<u32> = (0..count as u32).collect();
    for t in (0..count as u32).filter(|&t| is_free(t)) {
        let best = &mut largest[group[t as usize] as usize];
        if area(t) > area(*best) {
            *best = t;
        }
    }
    let whole = |turned: Option<bool>| turned.map_or(Outcome::Gone, |turned| Outcome::Whole { turned });
    let of_group = |t: u32| {
        let asks = is_free(t) && group[t as usize] == t;
        asks.then(|| {
            let [a, b, c] = sides.mesh.corners(largest[t as usize] as usize);
            sides.at(largest[t as usize], (a + b + c) / 3.0)
        })
    };
    let of_groups: Vec<Option<Option<bool>>> = (0..count as u32).into_par_iter().map(of_group).collect();
    let of_triangle = |t: u32| {
        if !has_area(t) {
            return Outcome::Gone;
        }
        if is_free(t) {
            return whole(of_groups[group[t as usize] as usize].flatten());
        }
        let place = contacts.cuts.binary_search_by_key(&t, |(t, _)| *t);
        let segments = place.map_or_else(|_| Vec::new(), |place| contacts.cuts[place].1.clone());
        let face = &contacts.faces[t as usize];
        let parts = parts(face.corners, face.normal, segments, sides.tolerance);
        let known: Vec<_> = parts.iter().filter_map(|part| Some((part, sides.of_part(t, part)?))).collect();
        match known.first() {
            None => Outcome::Gone,
            Some(&(_, first)) if known.iter().all(|(_, side)| *side == first) => whole(first),
            Some(_) => {
                let kept = known.iter().filter_map(|(part, side)| Some(((*part).clone(), (*side)?)));
                Outcome::Parts(kept.collect())
            }
        }
    };
    (0..count as u32).into_par_iter().map(of_triangle).collect()
}

/// The mesh of what stays.
fn assemble(mesh: &TriangleMesh, outcomes: &[Outcome], touched: &[bool]) -> Result<(TriangleMesh, Vec<bool>), Problem> {
    let mut out = Assembly {
        mesh,
        number: vec![u32::MAX; mesh.positions().len()],
        positions: Vec::new(),
        colours: mesh.colours().map(|_| Vec::new()),
        places: mesh.places().map(|_| Vec::new()),
        triangles: Vec::new(),
    };
    let mut of_triangles = Vec::new();
    for (t, outcome) in outcomes.iter().enumerate() {
        match outcome {
            Outcome::Gone => {}
            Outcome::Whole { turned } => {
                let corners = mesh.triangles()[t].map(|v| out.vertex(v));
                out.push(corners, *turned);
            }
            Outcome::Parts(parts) => {
                for (part, turned) in parts {
                    let corners: Vec<u32> = part.iter().map(|corner| out.corner(t, corner)).collect();
                    for i in 2..corners.len() {
                        out.push([corners[0], corners[i - 1], corners[i]], *turned);
                    }
                }
            }
        }
        of_triangles.resize(out.triangles.len(), touched[t]);
    }
    if out.triangles.is_empty() {
        return Err(Problem::NoVolume);
    }
    let whole = TriangleMesh::new(out.positions, out.triangles, out.colours)?;
    let whole = match out.places {
        Some(places) => whole.with_places(places),
        None => whole,
    };
    Ok((whole, of_triangles))
}

struct Assembly<'a> {
    mesh: &'a TriangleMesh,
    /// The new number of each vertex.
    number: Vec<u32>,
    positions: Vec<DVec3>,
    colours: Option<Vec<[f32; 3]>>,
    places: Option<Vec<PicturePlace>>,
    triangles: Vec<[u32; 3]>,
}

impl Assembly<'_> {
    fn push(&mut self, [a, b, c]: [u32; 3], turned: bool) {
        self.triangles.push(if turned { [a, c, b] } else { [a, b, c] });
    }

    /// A vertex of the mesh.
    fn vertex(&mut self, v: u32) -> u32 {
        if self.number[v as usize] == u32::MAX {
            self.number[v as usize] = self.positions.len() as u32;
            self.positions.push(self.mesh.positions()[v as usize]);
            if let (Some(out), Some(colours)) = (&mut self.colours, self.mesh.colours()) {
                out.push(colours[v as usize]);
            }
            if let (Some(out), Some(places)) = (&mut self.places, self.mesh.places()) {
                out.push(places[v as usize]);
            }
        }
        self.number[v as usize]
    }

    /// A corner of a part of a triangle, with the colour and the place in a picture that the triangle has there.
    fn corner(&mut self, triangle: usize, corner: &Corner) -> u32 {
        let vertices = self.mesh.triangles()[triangle];
        if let Some(i) = corner.original {
            return self.vertex(vertices[usize::from(i)]);
        }
        self.positions.push(corner.position);
        let weights = closest(self.mesh.corners(triangle), corner.position).weights;
        if let (Some(out), Some(places)) = (&mut self.places, self.mesh.places()) {
            out.push(PicturePlace::between(vertices.map(|v| places[v as usize]), weights));
        }
        if let (Some(out), Some(colours)) = (&mut self.colours, self.mesh.colours()) {
            let [v, w] = weights.map(|weight| weight as f32);
            let [a, b, c] = vertices.map(|v| colours[v as usize]);
            out.push(std::array::from_fn(|i| (a[i] * (1.0 - v - w) + b[i] * v + c[i] * w).max(0.0)));
        }
        self.positions.len() as u32 - 1
    }
}
