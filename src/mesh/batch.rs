//! The closest points of a mesh to a batch of points, from one list of triangles for all of them.
//!
//! The walk down the tree skips triangles that are closest to no point of the batch's box. The distances of each point from
//! the others are measured in single precision, many points at a time, and only the triangles that are closest but for
//! rounding are measured in double precision.
//!
//! **Guaranteed:** the results are those of [`MeshDistance::nearest`], to the bit.

use glam::{DVec3, Vec3};
use multiversion::multiversion;
use parry3d_f64::partitioning::TraversalAction;

use super::{MeshDistance, Nearest};
use crate::field::{Aabb, Points, greater, lesser};

/// Triangles that a batch's list may have. With more, lists of its octants take less time.
const MANY: usize = 256;
/// Triangles that an octant's list may have. With more, the tree finds those of each point faster.
const TOO_MANY: usize = 1024;
/// Points that share a list. Fewer do not repay making it.
const SHARING: usize = 16;
/// Points that are measured at once.
const LANES: usize = 16;
/// Distances in single precision are off by no more than this share of the lengths that they are computed from: each of up
/// to three terms has a few roundings of 6e-8.
const ERROR: f32 = 4e-6;
/// Triangles whose height is below this share of their longest side are always measured in double precision: their
/// normal is not accurate enough to leave one out.
const SLIVER: f64 = 1e-6;

/// A triangle in single precision. A unit vector n and an offset k give n · p + k, where p is from the batch's origin. Each
/// offset is from a point as near to p as the distance that it is for, so that distances are rounded and not positions.
struct Flat {
    /// How far above its plane.
    above: ([f32; 3], f32),
    sides: [Side; 3],
}

/// A side of a triangle.
struct Side {
    /// How far outside of it.
    outward: ([f32; 3], f32),
    /// How far along it from either end.
    along: ([f32; 3], [f32; 2]),
}

/// What a batch needs room for.
#[derive(Default)]
pub(super) struct Batch {
    triangles: Vec<u32>,
    flat: Vec<Flat>,
    /// Of each triangle, squared distances from some points.
    squares: Vec<[f32; LANES]>,
    candidates: Vec<(u32, u8)>,
    members: Vec<u16>,
}

impl Batch {
    /// Puts the closest point of each point into `found`.
    pub fn nearest(&mut self, mesh: &MeshDistance, points: &Points, found: &mut Vec<Nearest>) {
        found.clear();
        found.resize(points.len, Nearest::NONE);
        let mut members = std::mem::take(&mut self.members);
        let all = 0..points.len as u16;
        members.clear();
        members.extend(all.clone());
        if points.len < SHARING || (0..points.len).any(|i| points.position(i).is_nan()) {
            one_by_one(mesh, points, &members, found);
        } else if !self.find(mesh, points, &members, MANY, found) {
            let (low, high) = range(points, &members);
            let octant = |i: u16| points.offset(i.into()).cmpge((low + high) * 0.5).bitmask();
            for which in 0..8 {
                members.clear();
                members.extend(all.clone().filter(|&i| octant(i) == which));
                if !self.find(mesh, points, &members, TOO_MANY, found) {
                    one_by_one(mesh, points, &members, found);
                }
            }
        }
        self.members = members;
    }

    /// The same of some of the points; `false`, and nothing found, where a list does not pay.
    fn find(
        &mut self,
        mesh: &MeshDistance,
        points: &Points,
        members: &[u16],
        many: usize,
        found: &mut [Nearest],
    ) -> bool {
        if members.len() < SHARING || !self.list(mesh, points, members, many) {
            return false;
        }
        let reach = members.iter().map(|&i| points.offset(i.into()).length()).fold(0.0, f32::max);
        for members in members.chunks(LANES) {
            let mut lanes = [[0.0; LANES]; 3];
            for (lane, &i) in members.iter().enumerate() {
                (lanes[0][lane], lanes[1][lane], lanes[2][lane]) = points.offset(i.into()).into();
            }
            closest(&self.flat, &lanes, reach, &mut self.squares, &mut self.candidates);
            for &(place, lane) in &self.candidates {
                let Some(&i) = members.get(usize::from(lane)) else { continue };
                let other = mesh.nearest_on(self.triangles[place as usize], points.position(i.into()));
                let nearest = &mut found[usize::from(i)];
                if other.is_before(nearest) {
                    *nearest = other;
                }
            }
        }
        true
    }

    /// Lists the triangles that can be closest to some points; `false` where there are more than `many`.
    ///
    /// With c the centre of the points' box, q the closest point to it and h half the box's size: no p in the box is farther
    /// from the mesh than from q, so a triangle counts only if it has an x with |p − x| ≤ |p − q| for some p in the box,
    /// which is Σ (x − c)² − 2 h |x − q| ≤ |c − q|² over the axes. The least of it over a node's box is that of each axis.
    fn list(&mut self, mesh: &MeshDistance, points: &Points, members: &[u16], many: usize) -> bool {
        let (low, high) = range(points, members);
        let bounds = Aabb::new(points.origin + low.as_dvec3(), points.origin + high.as_dvec3());
        let (centre, half) = (bounds.centre(), bounds.size() * 0.5);
        let nearest = mesh.nearest(centre);
        let reach = nearest.distance_squared.sqrt() + half.length();
        // Rounding, here and of points on the mesh, leaves nothing out.
        let error = 1e-9 * reach + 1e-14 * bounds.min.abs().max(bounds.max.abs()).max_element();
        let most = nearest.distance_squared + 16.0 * error * (reach + error);
        let (c, q, h) = (centre.to_array(), nearest.point.to_array(), half.to_array());
        self.triangles.clear();
        mesh.tree().traverse(|node| {
            let (low, high) = (node.mins().to_array(), node.maxs().to_array());
            let least = |i: usize| {
                // −2 h |x − q| is the lesser of two lines, and with each of them the least is at c ± h or an end.
                let with = |h: f64| {
                    let x = (c[i] + h).max(low[i]).min(high[i]);
                    (x - c[i]) * (x - c[i]) - 2.0 * h * (x - q[i])
                };
                with(h[i]).min(with(-h[i]))
            };
            if least(0) + least(1) + least(2) > most {
                return TraversalAction::Prune;
            }
            self.triangles.extend(node.leaf_data());
            if self.triangles.len() > many { TraversalAction::EarlyExit } else { TraversalAction::Continue }
        });
        if self.triangles.is_empty() || self.triangles.len() > many {
            return false;
        }
        self.flat.clear();
        self.flat.extend(self.triangles.iter().map(|&t| Flat::new(mesh.mesh().corners(t as usize), points.origin)));
        true
    }
}

/// The closest points by the tree alone.
fn one_by_one(mesh: &MeshDistance, points: &Points, members: &[u16], found: &mut [Nearest]) {
    let mut last: Option<(DVec3, f64)> = None;
    for &i in members {
        let position = points.position(i.into());
        let by_last = last.map_or(f64::INFINITY, |(from, distance)| distance + from.distance(position));
        // By what is no number nothing is known.
        let within = by_last.min(f64::INFINITY);
        // The sum of two roots may round below the truth.
        let nearest = mesh.nearest_within(position, within * (1.0 + 1e-12));
        last = Some((position, nearest.distance_squared.sqrt()));
        found[usize::from(i)] = nearest;
    }
}

fn range(points: &Points, members: &[u16]) -> (Vec3, Vec3) {
    let offsets = || members.iter().map(|&i| points.offset(i.into()));
    (offsets().fold(Vec3::INFINITY, Vec3::min), offsets().fold(Vec3::NEG_INFINITY, Vec3::max))
}

impl Flat {
    /// No distance from it is a number.
    const UNKNOWN: Self = {
        const SIDE: Side = Side { outward: ([0.0; 3], f32::NAN), along: ([0.0; 3], [f32::NAN; 2]) };
        Self { above: ([0.0; 3], f32::NAN), sides: [SIDE; 3] }
    };

    fn new([a, b, c]: [DVec3; 3], origin: DVec3) -> Self {
        let cross = (b - a).cross(c - a);
        let longest = (b - a).length_squared().max((c - a).length_squared());
        let length = cross.length();
        if length <= SLIVER * longest {
            return Self::UNKNOWN;
        }
        let normal = cross / length;
        let offset = |direction: DVec3, from: DVec3| direction.dot(origin - from) as f32;
        let single = |direction: DVec3| direction.as_vec3().to_array();
        let side = |from: DVec3, to: DVec3| {
            let along = (to - from) / (to - from).length();
            let outward = along.cross(normal);
            Side {
                outward: (single(outward), offset(outward, from)),
                along: (single(along), [from, to].map(|end| offset(along, end))),
            }
        };
        Self { above: (single(normal), offset(normal, a)), sides: [side(a, b), side(b, c), side(c, a)] }
    }
}

/// The triangles that are closest to some points but for rounding, each as its place in the list with the point's lane.
#[multiversion(targets = "simd")]
fn closest(
    all: &[Flat],
    [x, y, z]: &[[f32; LANES]; 3],
    reach: f32,
    squares: &mut Vec<[f32; LANES]>,
    candidates: &mut Vec<(u32, u8)>,
) {
    squares.clear();
    candidates.clear();
    let mut least = [f32::INFINITY; LANES];
    for Flat { above, sides } in all {
        let dot = |[nx, ny, nz]: &[f32; 3]| -> [f32; LANES] {
            let mut dot = [0.0; LANES];
            for i in 0..LANES {
                dot[i] = nx * x[i] + ny * y[i] + nz * z[i];
            }
            dot
        };
        let (mut farthest, mut beside) = ([0.0; LANES], [f32::INFINITY; LANES]);
        for Side { outward, along } in sides {
            let (out, on, [start, end]) = (dot(&outward.0), dot(&along.0), along.1);
            for i in 0..LANES {
                let out = out[i] + outward.1;
                let beyond = greater(greater(on[i] + end, -on[i] - start), 0.0);
                farthest[i] = greater(out, farthest[i]);
                beside[i] = lesser(out * out + beyond * beyond, beside[i]);
            }
        }
        let mut square = dot(&above.0);
        for i in 0..LANES {
            let above = square[i] + above.1;
            square[i] = above * above + if farthest[i] > 0.0 { beside[i] } else { 0.0 };
            least[i] = lesser(square[i], least[i]);
        }
        squares.push(square);
    }
    let mut limits = [0.0; LANES];
    for i in 0..LANES {
        let distance = least[i].sqrt();
        let limit = distance + 2.0 * ERROR * (reach + distance);
        // Squares below the least normal number are off by more.
        limits[i] = limit * limit + f32::MIN_POSITIVE;
    }
    for (place, square) in squares.iter().enumerate() {
        // The usual answer is no, and a loop without a way out finds that out fast.
        let mut any = false;
        for i in 0..LANES {
            any |= may_be_within(square[i], limits[i]);
        }
        if any {
            let within = (0..LANES).filter(|&i| may_be_within(square[i], limits[i]));
            candidates.extend(within.map(|i| (place as u32, i as u8)));
        }
    }
}

#[inline(always)]
fn may_be_within(square: f32, limit: f32) -> bool {
    (square <= limit) | square.is_nan()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{ball, both, cube};
    use crate::mesh::tests::Numbers;
    use crate::mesh::{Holes, TriangleMesh};

    /// All triangles, one after the other.
    fn reference(mesh: &MeshDistance, position: DVec3) -> Nearest {
        let all = (0..mesh.mesh().triangles().len() as u32).map(|triangle| mesh.nearest_on(triangle, position));
        all.fold(Nearest::NONE, |best, other| if other.is_before(&best) { other } else { best })
    }

    /// A block's points, or some anywhere around.
    fn points(origin: DVec3, voxel: f64, len: usize, numbers: &mut Numbers) -> Points {
        let mut points = Points::new(origin);
        for i in 0..len {
            let of_block = DVec3::from([i >> 6, i >> 3 & 7, i & 7].map(|k| k as f64 - 3.5));
            points.push((voxel * if len == 512 { of_block } else { numbers.position() * 4.0 }).as_vec3());
        }
        points
    }

    /// Formulas that bend space may lead nowhere.
    #[test]
    fn points_that_are_no_numbers() {
        let mesh = MeshDistance::new(ball(DVec3::ZERO, 1.0, 12), Holes::Refuse).unwrap();
        let (mut batch, mut found, mut numbers) = (Batch::default(), Vec::new(), Numbers(8));
        for len in [3, 512] {
            let mut points = points(DVec3::X, 0.1, len, &mut numbers);
            points.y[1] = f32::NAN;
            batch.nearest(&mesh, &points, &mut found);
            assert!(found[1].distance_squared.is_nan());
            for i in (0..len).step_by(40) {
                assert_eq!(found[i].point, reference(&mesh, points.position(i)).point);
            }
        }
    }

    #[test]
    fn the_closest_of_all_triangles() {
        let thin = cube(0.8, 6);
        let thin_positions = thin.positions().iter().map(|p| *p * DVec3::new(1.0, 1e-7, 1.0)).collect();
        let thin = TriangleMesh::new(thin_positions, thin.triangles().to_vec(), None).unwrap();
        let far = ball(DVec3::new(300.0, -2.0, 1e3), 1.0, 80);
        let crossing = both(&cube(0.7, 2), &ball(DVec3::splat(0.5), 0.5, 10));
        let mut numbers = Numbers(7);
        let (mut batch, mut found) = (Batch::default(), Vec::new());
        // Lists of all points, of octants, and none.
        let mut ways = [0; 3];
        for mesh in [cube(0.8, 1), cube(0.8, 24), cube(1e-20, 8), cube(1e25, 4), far, crossing, thin] {
            let mesh = MeshDistance::new(mesh, Holes::Allow).unwrap();
            let bounds = mesh.mesh().bounding_box();
            let size = bounds.size().max_element();
            for k in 0..20 {
                let voxel = 0.2 * size * 0.5_f64.powi(k / 2);
                let somewhere = bounds.centre() + numbers.position() * size;
                let origin = mesh.nearest(somewhere).point + numbers.position() * 8.0 * voxel;
                let len = if k % 2 == 0 { 512 } else { 1 + k as usize * 97 % 511 };
                let points = points(origin, voxel, len, &mut numbers);
                batch.nearest(&mesh, &points, &mut found);
                if len >= SHARING {
                    ways[[MANY, TOO_MANY].partition_point(|many| *many < batch.triangles.len())] += 1;
                }
                assert_eq!(found.len(), len);
                for i in (0..len).step_by(29) {
                    let (found, expected) = (found[i], reference(&mesh, points.position(i)));
                    assert_eq!(found.triangle, expected.triangle, "{found:?} {expected:?}");
                    assert_eq!((found.point, found.weights), (expected.point, expected.weights));
                }
            }
        }
        assert!(ways.iter().all(|taken| *taken > 1), "{ways:?}");
    }
}
