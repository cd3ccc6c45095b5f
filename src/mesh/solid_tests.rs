//! The solid of meshes whose pieces overlap, nest, touch, are turned over or cross themselves, against judges that know
//! nothing of triangles crossing: pieces are convex, so each one's inside is that of its planes.

use std::path::Path;

use glam::{DMat3, DVec3, EulerRot};

use super::shapes::{ball, both, cube};
use super::tests::{Numbers, in_convex};
use super::{Conventions, Holes, MeshDistance, Problem, TriangleMesh, read};
use crate::field::{Aabb, Evaluator, Field, Slope};

/// A convex piece, and how often the solid goes round its inside: −1 for a hollow.
struct Piece {
    mesh: TriangleMesh,
    times: i32,
    wound_inward: bool,
}

/// Some convex pieces in one mesh.
struct Pieces(Vec<Piece>);

impl Pieces {
    fn mesh(&self) -> TriangleMesh {
        let wound = |piece: &Piece| {
            let mut mesh = piece.mesh.clone();
            if piece.wound_inward {
                mesh.flip();
            }
            mesh
        };
        self.0[1..].iter().fold(wound(&self.0[0]), |all, piece| both(&all, &wound(piece)))
    }

    fn holds(&self, p: DVec3) -> bool {
        self.0.iter().filter(|piece| in_convex(&piece.mesh, p)).map(|piece| piece.times).sum::<i32>() != 0
    }

    /// Points of the boundary, no farther than `spacing` apart.
    fn samples(&self, spacing: f64) -> Vec<DVec3> {
        let mut samples = Vec::new();
        for piece in &self.0 {
            for t in 0..piece.mesh.triangles().len() {
                let [a, b, c] = piece.mesh.corners(t);
                let normal = piece.mesh.area_normal(t).normalize();
                let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
                let cuts = (longest / spacing).ceil() as u32;
                for i in 0..=cuts {
                    for j in 0..=cuts - i {
                        let [v, w] = [i, j].map(|k| f64::from(k) / f64::from(cuts));
                        // Off the edges, where either side may be that of another face.
                        let p = (a + (b - a) * v + (c - a) * w).lerp((a + b + c) / 3.0, 1e-6);
                        if self.holds(p + normal * 1e-6) != self.holds(p - normal * 1e-6) {
                            samples.push(p);
                        }
                    }
                }
            }
        }
        samples
    }
}

fn moved(mesh: &TriangleMesh, turn: DMat3, by: DVec3) -> TriangleMesh {
    let positions = mesh.positions().iter().map(|p| turn * *p + by).collect();
    TriangleMesh::new(positions, mesh.triangles().to_vec(), None).unwrap()
}

/// A random set: cubes on a coarse lattice (which touch, share corners and faces), turned cubes, balls; some turned
/// over, some with a hollow in them.
fn random_pieces(numbers: &mut Numbers) -> Pieces {
    let mut pieces: Vec<Piece> = Vec::new();
    let count = 2 + (numbers.next().abs() * 4.0) as usize;
    for _ in 0..count {
        let kind = (numbers.next().abs() * 3.0) as u32;
        let size = 0.25 * (1.0 + (numbers.next().abs() * 3.0).floor());
        let place = (numbers.position() * 4.0).round() * 0.25;
        let angles = numbers.position() * 3.0;
        let turn = DMat3::from_euler(EulerRot::XYZ, angles.x, angles.y, angles.z);
        let (mesh, centre) = match kind {
            0 => (moved(&cube(size, 1), DMat3::IDENTITY, place), place),
            1 => (moved(&cube(size, 2), turn, place + angles * 0.01), place + angles * 0.01),
            _ => (moved(&ball(DVec3::ZERO, size, 5), turn, place), place),
        };
        // The rules see a piece wound inward within another one as a hollow: these stand by themselves.
        let apart = |other: &Piece| {
            let of_other = other.mesh.bounding_box().centre();
            !in_convex(&other.mesh, centre) && !in_convex(&mesh, of_other)
        };
        let free = pieces.iter().all(apart);
        let wound_inward = free && numbers.next() > 0.4;
        let around = |p: &Piece| p.wound_inward && in_convex(&p.mesh, centre) || p.times < 0;
        if pieces.iter().any(around)
            || pieces.iter().any(|p| p.wound_inward && in_convex(&mesh, p.mesh.bounding_box().centre()))
        {
            continue;
        }
        let hollow = (free && numbers.next() > 0.3).then(|| Piece {
            mesh: moved(&mesh, DMat3::from_diagonal(DVec3::splat(0.5)), centre * 0.5),
            times: -1,
            wound_inward: !wound_inward,
        });
        pieces.push(Piece { mesh, times: 1, wound_inward });
        // What comes after keeps clear of it.
        if let Some(hollow) = hollow {
            pieces.push(hollow);
            break;
        }
    }
    Pieces(pieces)
}

#[test]
fn any_pieces_give_the_solid_of_their_winding_and_the_distance_to_its_boundary() {
    let mut numbers = Numbers(43);
    let (mut inside, mut cut) = (0, 0);
    for case in 0..60 {
        let pieces = random_pieces(&mut numbers);
        let mesh = pieces.mesh();
        let field = MeshDistance::new(mesh.clone(), Holes::Refuse).unwrap_or_else(|error| panic!("{case}: {error}"));
        assert_eq!(field.slope(), Slope::Exact { outside: true, inside: true });
        cut += usize::from(field.mesh().triangles().len() != mesh.triangles().len());
        let samples = pieces.samples(0.05);
        let centre = mesh.bounding_box().centre();
        let size = mesh.bounding_box().size() * 0.6;
        for i in 0..300 {
            // Every other point stands close to the boundary, and half of these on the lattice of the cubes.
            let near = samples[(numbers.next().abs() * samples.len() as f64) as usize % samples.len()];
            let p = match i % 4 {
                0 | 2 => centre + numbers.position() * size,
                1 => near + numbers.position() * 0.01,
                _ => (near * 8.0).round() / 8.0,
            };
            let foot = field.foot(p);
            if foot.distance.abs() > 1e-6 {
                assert_eq!(foot.distance > 0.0, pieces.holds(p), "case {case} at {p}: {}", foot.distance);
                inside += usize::from(foot.distance > 0.0);
            }
            if i % 3 == 0 {
                // No farther than any of the samples, and to a point with both sides around it.
                let nearest = samples.iter().map(|s| s.distance_squared(p)).fold(f64::INFINITY, f64::min).sqrt();
                assert!(foot.distance.abs() < nearest + 1e-5, "case {case} at {p}: {} for {nearest}", foot.distance);
                assert!((foot.point.distance(p) - foot.distance.abs()).abs() < 1e-9);
                let mut seen = [false; 2];
                for _ in 0..2000 {
                    seen[usize::from(pieces.holds(foot.point + numbers.position() * 1e-4))] = true;
                    if seen == [true; 2] {
                        break;
                    }
                }
                assert_eq!(seen, [true; 2], "case {case} at {p}: {} is not on the boundary", foot.point);
            }
        }
    }
    assert!(inside > 3000 && cut > 12, "{inside} points inside, {cut} meshes cut");
}

/// A star drawn in one stroke, as a prism: it goes round its middle twice.
#[test]
fn a_star_that_crosses_itself_is_solid_throughout() {
    let corner = |i: u32, z: f64| {
        let (s, c) = libm::sincos(std::f64::consts::TAU * f64::from(2 * i % 5) / 5.0);
        DVec3::new(c, s, z)
    };
    let mut positions: Vec<DVec3> = (0..5).flat_map(|i| [corner(i, -2.0), corner(i, 2.0)]).collect();
    positions.extend([DVec3::Z * -2.0, DVec3::Z * 2.0]);
    let mut triangles = Vec::new();
    for i in 0..5 {
        let (a, b) = (2 * i, 2 * ((i + 1) % 5));
        triangles.extend([[a, b, b + 1], [a, b + 1, a + 1], [10, b, a], [11, a + 1, b + 1]]);
    }
    let mesh = TriangleMesh::new(positions, triangles, None).unwrap();
    let field = MeshDistance::new(mesh, Holes::Refuse).unwrap();
    // The inner corners are cos 72° ÷ cos 36° from the middle, the sides that cross within only cos 72°.
    let inner = libm::cos(1.2566370614359172) / libm::cos(0.6283185307179586);
    assert!((field.foot(DVec3::ZERO).distance - inner).abs() < 1e-9, "{}", field.foot(DVec3::ZERO).distance);
    for (p, inside) in
        [([0.9, 0.0, 1.9], true), ([-0.5, 0.0, 0.0], false), ([-0.3, 0.0, 0.0], true), ([0.0, 0.0, 2.1], false)]
    {
        assert_eq!(field.reference(p.into()) > 0.0, inside, "{p:?}");
    }
    assert!((field.mesh().volume() - field_volume(inner)).abs() < 1e-6);
    assert!(field.notes()[0].contains("cross or cover others"), "{:?}", field.notes());
}

/// Of the prism over a star with outer radius 1, height 4.
fn field_volume(inner: f64) -> f64 {
    4.0 * 5.0 * inner * libm::sin(0.6283185307179586)
}

fn case(name: &str) -> MeshDistance {
    let mesh = read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(name), &Conventions::default())
        .unwrap()
        .mesh;
    MeshDistance::new(mesh, Holes::Refuse).unwrap()
}

fn has_volume(field: &MeshDistance, volume: f64, note: &str) {
    let found = field.mesh().volume();
    assert!((found - volume).abs() < 1e-5, "a volume of {found}");
    assert!(field.notes().iter().any(|text| text.contains(note)), "{:?}", field.notes());
}

#[test]
fn a_cube_in_the_corner_of_another_is_no_hollow() {
    let field = case("mesh-two-solids-share-a-corner.obj");
    has_volume(&field, 27.0, "cross or cover others");
    for (p, distance) in [([0.0; 3], 1.0), ([-0.9; 3], 0.1), ([0.5; 3], 1.5), ([2.5, 0.0, 0.0], -0.5), ([-1.0; 3], 0.0)]
    {
        assert!((field.reference(p.into()) - distance).abs() < 1e-6, "{p:?}: {}", field.reference(p.into()));
    }
}

#[test]
fn a_piece_inside_out_is_turned_over() {
    let field = case("mesh-one-piece-inside-out.obj");
    has_volume(&field, 16.0, "1 of 2 pieces is wound inside out");
    assert!(field.notes()[0].contains("(2.0000, 0.0000, 0.0000)"), "{:?}", field.notes());
    for (x, distance) in [(-2.0, 1.0), (2.0, 1.0), (0.0, -1.0), (2.75, 0.25), (3.5, -0.5)] {
        assert!((field.reference(DVec3::X * x) - distance).abs() < 1e-12, "{x}");
    }
}

#[test]
fn a_double_sided_card_has_no_volume_and_no_surface() {
    let field = case("mesh-double-sided-card.obj");
    has_volume(&field, 8.0, "1 of 2 pieces is within others or without volume");
    assert!((field.reference(DVec3::X * 2.0) + 1.0).abs() < 1e-12);
    assert!(field.bounding_box().unwrap().max.x == 1.0);
    // The card alone has nothing to bake.
    let card = TriangleMesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2], [2, 1, 0]], None);
    let error = MeshDistance::new(card.unwrap(), Holes::Refuse).unwrap_err();
    assert!(matches!(error, Problem::NoVolume), "{error}");
}

#[test]
fn faces_within_other_pieces_are_no_surface() {
    let field = case("mesh-overlapping-pieces.obj");
    has_volume(&field, 16.0 - 1.8 * 1.7, "cross or cover others");
    // Both cubes' walls lie within the other one here.
    for (x, distance) in [(1.0, 0.8), (0.0, 0.8), (-0.7, 0.3), (1.7, 0.3)] {
        let p = DVec3::new(x, 0.2, 0.1);
        let found = field.reference(p);
        assert!(found > distance - 1e-9, "{p}: {found}");
    }
}

#[test]
fn faces_written_twice_count_once() {
    let whole = cube(1.0, 3);
    let mut triangles = whole.triangles().to_vec();
    triangles.extend_from_within(4..9);
    let mesh = TriangleMesh::new(whole.positions().to_vec(), triangles, None).unwrap();
    let field = MeshDistance::new(mesh, Holes::Refuse).unwrap();
    has_volume(&field, 8.0, "5 triangles are there more than once");
    // All of them twice.
    let field = MeshDistance::new(both(&whole, &whole), Holes::Refuse).unwrap();
    has_volume(&field, 8.0, "108 triangles are there more than once");
    assert_eq!(field.mesh().triangles(), whole.triangles());
}

/// Walls that two boxes share are none, also where rounding leaves a gap between them.
#[test]
fn boxes_side_by_side_are_one_body() {
    for gap in [0.0, 3e-9, -3e-9] {
        let smaller = moved(&cube(0.5, 2), DMat3::IDENTITY, DVec3::new(1.5 + gap, 0.2, 0.1));
        let field = MeshDistance::new(both(&cube(1.0, 1), &smaller), Holes::Refuse).unwrap();
        has_volume(&field, 9.0, "cross or cover others");
        let middle = field.reference(DVec3::new(1.0, 0.2, 0.1));
        assert!((middle - 0.5).abs() < 1e-6, "gap {gap}: {middle}");
    }
}

/// Nothing about a sound mesh changes, whatever it looks like: colours, seams, slivers, a hollow.
#[test]
fn a_sound_mesh_stays_as_it_is() {
    let mut hollow = ball(DVec3::ZERO, 0.5, 9);
    hollow.flip();
    let apart = both(&cube(0.5, 2), &ball(DVec3::splat(0.9), 0.3, 7));
    for mesh in [cube(0.8, 9), ball(DVec3::splat(7.0), 2.0, 30), both(&ball(DVec3::ZERO, 1.0, 9), &hollow), apart] {
        let field = MeshDistance::new(mesh.clone(), Holes::Refuse).unwrap();
        assert_eq!((field.mesh().positions(), field.mesh().triangles()), (mesh.positions(), mesh.triangles()));
        assert!(field.notes().is_empty(), "{:?}", field.notes());
    }
}

/// Colours of cut triangles are those that the triangle has there.
#[test]
fn cut_faces_keep_their_colours() {
    let coloured = |mesh: &TriangleMesh| {
        let colours = mesh.positions().iter().map(|p| [0.5 + 0.2 * p.x, 0.4, 0.5 - 0.1 * p.y].map(|c| c as f32));
        TriangleMesh::new(mesh.positions().to_vec(), mesh.triangles().to_vec(), Some(colours.collect())).unwrap()
    };
    let mesh = coloured(&both(&cube(1.0, 1), &moved(&cube(0.7, 1), DMat3::from_rotation_y(0.3), DVec3::splat(0.8))));
    let field = MeshDistance::new(mesh, Holes::Refuse).unwrap();
    let mut numbers = Numbers(8);
    for _ in 0..500 {
        let nearest = field.nearest(numbers.position() * 2.0);
        let [r, _, b] = field.colour(&nearest).unwrap().map(f64::from);
        let p = nearest.point;
        assert!((r - 0.5 - 0.2 * p.x).abs() < 1e-5 && (b - 0.5 + 0.1 * p.y).abs() < 1e-5, "{p}");
    }
}

/// By parity what lies in one piece is a hollow, in two solid again, and where two pieces cross is outside, whichever way any
/// of them is wound.
#[test]
fn parity_counts_pieces() {
    let (outer, inner) = (cube(1.0, 3), cube(0.25, 2));
    let aside = moved(&cube(0.45, 2), DMat3::IDENTITY, DVec3::new(1.0, 0.1, 0.05));
    for flips in 0..16 {
        let turned = |mesh: TriangleMesh, bit: u32| {
            let mut mesh = mesh;
            if flips >> bit & 1 == 1 {
                mesh.flip();
            }
            mesh
        };
        let nested = both(&turned(outer.clone(), 0), &turned(cube(0.5, 2), 1));
        let mesh = both(&both(&nested, &turned(inner.clone(), 2)), &turned(aside.clone(), 3));
        let field = MeshDistance::new(mesh, Holes::Parity).unwrap();
        let value = |at: [f64; 3]| field.reference(DVec3::from(at));
        for (at, wanted) in [
            ([0.0, 0.0, 0.0], 0.25),
            ([0.35, 0.0, 0.0], -0.1),
            // Between the walls at 0.5 and at 1.
            ([-0.8, 0.0, 0.0], 0.2),
            ([0.8, 0.1, 0.05], -0.2),
            ([1.2, 0.1, 0.05], 0.2),
            ([-1.5, 0.0, 0.0], -0.5),
        ] {
            assert!((value(at) - wanted).abs() < 1e-9, "{flips}: {} at {at:?}, not {wanted}", value(at));
        }
        let mut numbers = Numbers(3);
        let mut evaluator = field.mesh_evaluator();
        for _ in 0..60 {
            let at = numbers.position() * 1.4;
            let size = 0.1;
            let region = Aabb::new(at, at + size);
            evaluator.enter(&region);
            let bounds = evaluator.bounds();
            evaluator.leave();
            assert!(bounds.contains(field.reference(at + size / 3.0)), "{flips}: {at} not in {bounds:?}");
        }
    }
    let hole = TriangleMesh::new(outer.positions().to_vec(), outer.triangles()[1..].to_vec(), None).unwrap();
    assert!(MeshDistance::new(hole, Holes::Parity).unwrap_err().to_string().contains("boundary edges"));
}
