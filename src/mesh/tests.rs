//! Distances against exact answers and an independent brute force; evaluators against the plain reference.

use glam::DVec3;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::Triangle;

use super::pieces::{any_overlap, pieces};
use super::shapes::{ball, both, cube, cube_distance};
use super::{Holes, MeshDistance, Problem, TriangleMesh};
use crate::field::{Aabb, BATCH, Evaluator, Field, Gradients, Points, Slope};

/// A repeatable run of numbers in −1 … 1 (SplitMix64).
pub(super) struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    pub fn position(&mut self) -> DVec3 {
        DVec3::new(self.next(), self.next(), self.next())
    }
}

fn distance(mesh: TriangleMesh) -> MeshDistance {
    MeshDistance::new(mesh, Holes::Refuse).unwrap()
}

/// Distance to the surface by parry's triangle, one after another.
fn brute_force(mesh: &TriangleMesh, p: DVec3) -> f64 {
    let to = |t: usize| {
        let [a, b, c] = mesh.corners(t).map(|corner| corner.to_array().into());
        Triangle::new(a, b, c).distance_to_local_point(p.to_array().into(), false)
    };
    (0..mesh.triangles().len()).map(to).fold(f64::INFINITY, f64::min)
}

/// Whether a point is behind every face of a convex mesh.
pub(super) fn in_convex(mesh: &TriangleMesh, p: DVec3) -> bool {
    (0..mesh.triangles().len()).all(|t| mesh.area_normal(t).dot(p - mesh.corners(t)[0]) <= 0.0)
}

#[test]
fn a_cube_has_the_distance_of_a_box() {
    let mut numbers = Numbers(1);
    for cuts in [1, 7] {
        let field = distance(cube(0.8, cuts));
        // Points of a coarse lattice lie on faces, edges, corners, diagonals, the medial axis.
        let lattice =
            (0..1000).map(|i| DVec3::new((i % 10) as f64, (i / 10 % 10) as f64, (i / 100) as f64) * 0.4 - 1.6);
        let random: Vec<DVec3> = (0..3000).map(|_| numbers.position() * 2.0).collect();
        for p in lattice.chain(random) {
            let foot = field.foot(p);
            assert!((foot.distance - cube_distance(0.8, p)).abs() < 1e-14, "at {p}: {}", foot.distance);
            assert!((p - foot.gradient * foot.distance).distance(foot.point) < 1e-14);
            assert!((foot.gradient.length() - 1.0).abs() < 1e-12);
            // Against the gradient F falls at rate 1: outward from outside, towards the foot from inside.
            let behind = field.reference(p - foot.gradient * 1e-3);
            assert!((behind - (foot.distance - 1e-3)).abs() < 1e-13 || foot.distance.abs() < 1e-3);
        }
    }
}

#[test]
fn a_ball_agrees_with_brute_force_and_half_spaces() {
    let centre = DVec3::new(300.0, -2.0, 1e3);
    let mesh = ball(centre, 1.0, 16);
    let field = distance(mesh.clone());
    let mut numbers = Numbers(2);
    for i in 0..1500 {
        let p = numbers.position();
        // Most of them close to the surface, where the side is hard to tell.
        let p = centre + if i % 3 == 0 { p * 1.5 } else { p.normalize() * (1.0 + 0.01 * numbers.next()) };
        let foot = field.foot(p);
        assert!((foot.distance.abs() - brute_force(&mesh, p)).abs() < 1e-12);
        assert_eq!(foot.distance >= 0.0, in_convex(&mesh, p), "at {p}");
    }
    assert_eq!(field.slope(), Slope::Exact { outside: true, inside: true });
}

/// Points on rays out of the poles and other corners, where the closest part is a corner.
#[test]
fn corners_know_their_side() {
    let mesh = ball(DVec3::ZERO, 1.0, 9);
    let field = distance(mesh.clone());
    for &corner in mesh.positions() {
        assert!(field.reference(corner * 1.001) < 0.0);
        assert!(field.reference(corner * 0.999) > 0.0);
    }
}

#[test]
fn volumes_orientation_and_pieces() {
    let mut mesh = cube(0.5, 3);
    assert!((mesh.volume() - 1.0).abs() < 1e-14);
    let topology = mesh.topology();
    assert!(topology.is_closed() && topology.non_manifold_edges == 0);
    mesh.flip();
    assert!((mesh.volume() + 1.0).abs() < 1e-14);
    assert!(distance(mesh).reference(DVec3::ZERO) > 0.0, "a mesh that faces inward is turned over");
    let two = both(&cube(0.5, 1), &ball(DVec3::X * 3.0, 1.0, 8));
    let pieces = pieces(&two, &two.topology());
    assert_eq!((pieces.len(), any_overlap(&pieces)), (2, false));
}

#[test]
fn pieces_that_overlap_are_one_solid() {
    let (a, b) = (ball(DVec3::ZERO, 1.0, 12), ball(DVec3::X * 0.9, 0.7, 12));
    let mesh = both(&a, &b);
    let field = distance(mesh.clone());
    let mut numbers = Numbers(3);
    for _ in 0..1500 {
        let p = numbers.position() * 1.7;
        assert_eq!(field.reference(p) >= 0.0, in_convex(&a, p) || in_convex(&b, p), "at {p}");
        let to_faces = brute_force(&mesh, p);
        assert!(field.reference(p).abs() > to_faces - 1e-12 && (field.reference(p) > -to_faces - 1e-12), "at {p}");
    }
    assert_eq!(field.slope(), Slope::Exact { outside: true, inside: true });
}

#[test]
fn a_piece_that_faces_inward_is_a_hollow() {
    let (outer, mut inner) = (ball(DVec3::ZERO, 1.0, 12), ball(DVec3::ZERO, 0.5, 12));
    inner.flip();
    let field = distance(both(&outer, &inner));
    for (x, sign) in [(0.0, -1.0), (0.4, -1.0), (0.6, 1.0), (0.9, 1.0), (1.1, -1.0)] {
        assert_eq!(field.reference(DVec3::new(x, 0.01, 0.02)).signum(), sign, "at {x}");
    }
}

/// A cube whose edges carry triangles without an area.
#[test]
fn slivers_do_not_spoil_the_side() {
    let whole = cube(0.8, 1);
    let (mut positions, mut triangles) = (whole.positions().to_vec(), whole.triangles().to_vec());
    let [a, b, c] = triangles[0];
    positions.push((positions[a as usize] + positions[b as usize]) * 0.5);
    let middle = positions.len() as u32 - 1;
    // One triangle is cut in two; its neighbour is not, so a triangle of no area closes the gap.
    triangles[0] = [a, middle, c];
    triangles.extend([[middle, b, c], [a, b, middle]]);
    let mesh = TriangleMesh::new(positions, triangles, None).unwrap();
    assert!(mesh.topology().is_closed());
    let middle = mesh.positions()[middle as usize];
    let field = distance(mesh);
    let mut numbers = Numbers(4);
    for i in 0..1000 {
        let p =
            numbers.position() * if i % 2 == 0 { 1.5 } else { 0.01 } + if i % 2 == 0 { DVec3::ZERO } else { middle };
        assert!((field.reference(p) - cube_distance(0.8, p)).abs() < 1e-14, "at {p}");
    }
}

fn open_cube() -> TriangleMesh {
    let whole = cube(0.8, 4);
    TriangleMesh::new(whole.positions().to_vec(), whole.triangles()[2..].to_vec(), None).unwrap()
}

#[test]
fn an_open_mesh_is_refused_or_closed_by_winding() {
    let error = MeshDistance::new(open_cube(), Holes::Refuse).unwrap_err();
    assert!(matches!(error, Problem::Open { boundary_edges: 4, inconsistent_edges: 0 }), "{error}");
    let field = MeshDistance::new(open_cube(), Holes::Allow).unwrap();
    let mut numbers = Numbers(5);
    for _ in 0..2000 {
        let p = numbers.position();
        // Near the hole, 0.4 wide in a corner of the face x = −0.8, only the distance is asked for.
        if p.distance(DVec3::new(-0.8, -0.6, -0.6)) > 0.4 {
            assert_eq!(field.reference(p) > 0.0, cube_distance(0.8, p) > 0.0, "at {p}");
        }
    }
    assert_eq!(field.slope(), Slope::Unknown);
}

/// Values and gradients in nested regions equal the reference to the bit, and no interval misses a value.
#[test]
fn regions_change_nothing() {
    let fine_cube = cube(0.8, 40);
    let overlapping = both(&cube(0.7, 2), &ball(DVec3::splat(0.5), 0.5, 10));
    let meshes = [cube(0.8, 1), fine_cube, ball(DVec3::ZERO, 1.0, 24), overlapping, open_cube()];
    for mesh in meshes {
        let field = MeshDistance::new(mesh, Holes::Allow).unwrap();
        let mut evaluator = field.mesh_evaluator();
        let mut numbers = Numbers(6);
        let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
        for _ in 0..40 {
            let middle = numbers.position() * 1.2;
            let outer = Aabb::new(middle, middle).grown(0.3 + 0.3 * numbers.next());
            let inner = Aabb::new(middle, middle).grown(0.05).intersection(outer).unwrap();
            evaluator.enter(&outer);
            let first = evaluator.bounds();
            evaluator.enter(&inner);
            let second = evaluator.bounds();
            for (region, interval) in [(inner, second), (outer, first)] {
                let mut points = Points::new(region.centre());
                for _ in 0..40 {
                    points.push((numbers.position() * region.size() * 0.499).as_vec3());
                }
                evaluator.values(&points, &mut values);
                evaluator.gradients(&points, &mut gradients);
                for i in 0..points.len {
                    let foot = field.foot(points.position(i));
                    assert_eq!(values[i], foot.distance as f32);
                    assert_eq!(gradients.value[i], foot.distance as f32);
                    assert_eq!(gradients.gradient(i), foot.gradient.as_vec3());
                    assert!(interval.contains(foot.distance), "{interval:?} misses {}", foot.distance);
                }
                evaluator.leave();
            }
        }
    }
}

/// Far enough from the surface, even of an open mesh, a region is known to be on one side.
#[test]
fn intervals_leave_out_what_is_far() {
    for mesh in [cube(0.8, 3), open_cube()] {
        let field = MeshDistance::new(mesh, Holes::Allow).unwrap();
        let mut evaluator = field.evaluator();
        let sides = [(DVec3::splat(0.3), 1.0), (DVec3::splat(2.0), -1.0), (DVec3::new(0.95, 0.0, 0.0), -1.0)];
        for (middle, side) in sides {
            evaluator.enter(&Aabb::new(middle, middle).grown(0.05));
            let interval = evaluator.bounds();
            assert!(interval.lo * side > 0.0 && interval.hi * side > 0.0, "{interval:?} at {middle}");
            evaluator.leave();
        }
    }
}

#[test]
fn branches_are_the_planes_of_creases() {
    for cuts in [1, 30] {
        let field = distance(cube(0.8, cuts));
        let mut evaluator = field.evaluator();
        for (middle, count) in [(DVec3::splat(0.8), 3), (DVec3::new(0.8, 0.8, 0.0), 2), (DVec3::new(0.0, 0.0, 0.8), 1)]
        {
            evaluator.enter(&Aabb::new(middle, middle).grown(0.1));
            assert_eq!(evaluator.branches(), count);
            let mut points = Points::new(middle);
            points.push(glam::Vec3::new(-0.03125, -0.0625, -0.015625));
            let mut out = Gradients::new();
            let mut found: Vec<(f32, [f32; 3])> = (0..count)
                .map(|branch| {
                    evaluator.branch(branch, &points, &mut out);
                    (out.value[0], out.gradient(0).to_array())
                })
                .collect();
            found.sort_by(|a, b| a.0.total_cmp(&b.0));
            let expected = [(0.015625, [0.0, 0.0, -1.0]), (0.03125, [-1.0, 0.0, 0.0]), (0.0625, [0.0, -1.0, 0.0])];
            let met = expected.into_iter().filter(|(_, n)| (0..3).all(|i| n[i] == 0.0 || middle[i] == 0.8));
            for (found, expected) in found.iter().zip(met) {
                assert!((found.0 - expected.0).abs() < 1e-7 && found.1 == expected.1, "{found:?} {expected:?}");
            }
            evaluator.leave();
        }
    }
    let smooth = distance(ball(DVec3::ZERO, 1.0, 40));
    let mut evaluator = smooth.evaluator();
    evaluator.enter(&Aabb::new(DVec3::splat(0.2), DVec3::splat(1.0)));
    assert_eq!(evaluator.branches(), 1);
}
