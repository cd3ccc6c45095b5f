//! Feet and distance objects of general fields against exact distances.

use std::sync::atomic::AtomicBool;

use glam::{DMat3, DVec3};

use super::*;
use crate::distance::accuracy::exact;
use crate::distance::octree::{BuildError, DistanceObject, Settings};
use crate::distance::testing::{Joined, Leaf};
use crate::field::{Expression, Graph, SetSystem};

/// A plain generator with a seed, the same everywhere.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn point(&mut self, half: f64) -> DVec3 {
        DVec3::from(std::array::from_fn(|_| (2.0 * self.unit() - 1.0) * half))
    }
}

const VOXEL: f64 = 2.0 / 64.0;

const NONE: Foot = Foot { point: DVec3::ZERO, distance: 0.0, gradient: DVec3::ZERO, part: 0 };

fn region() -> Aabb {
    Aabb::new(DVec3::splat(-1.1), DVec3::splat(1.1))
}

fn watched<T>(work: impl FnOnce(&Watch) -> T) -> T {
    let cancel = AtomicBool::new(false);
    work(&Watch { cancel: &cancel, progress: &|_| {} })
}

/// Mean and greatest error in voxels of feet in a cube of the given half edge.
fn errors(feet: &dyn ClosestPoint, truth: &dyn Fn(DVec3) -> f64, half: f64, batches: u32) -> (f64, f64) {
    let mut random = Random(3);
    let (mut mean, mut max) = (0.0, 0.0_f64);
    for _ in 0..batches {
        let centre = random.point(half);
        let positions: Vec<DVec3> = (0..50).map(|_| centre + random.point(3.0 * VOXEL)).collect();
        let mut out = vec![NONE; positions.len()];
        feet.feet(&positions, &mut out);
        for (position, foot) in positions.iter().zip(&out) {
            let error = (foot.distance - truth(*position)).abs() / VOXEL;
            mean += error / f64::from(50 * batches);
            max = max.max(error);
            let back = *position - foot.gradient * foot.distance;
            assert!((back - foot.point).length() < 0.06 * VOXEL, "{position} {foot:?}");
        }
    }
    (mean, max)
}

#[test]
fn smooth_fields_that_are_no_distances() {
    let radii = DVec3::new(1.0, 0.5, 0.4);
    let cases: [(Joined, &dyn Fn(DVec3) -> f64); 3] = [
        (Joined::one(Leaf::Sphere(DVec3::ZERO, 0.9)), &|p| exact::sphere(p, DVec3::ZERO, 0.9)),
        (Joined::one(Leaf::Torus(0.7, 0.25)), &|p| exact::torus(p, 0.7, 0.25)),
        (Joined::one(Leaf::Ellipsoid(radii)), &|p| exact::ellipsoid(p, radii)),
    ];
    for (field, truth) in cases {
        let feet = watched(|watch| FieldFeet::new(&field, &region(), VOXEL, watch)).expect("a surface");
        for (half, most) in [(1.1, 0.01), (4.0, 0.02)] {
            let (mean, max) = errors(&feet, truth, half, 40);
            assert!(mean < 0.001 && max < most, "{field:?} within {half}: mean {mean}, max {max}");
        }
    }
}

#[test]
fn creases_and_corners() {
    let axes = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(0.3);
    let half = DVec3::new(0.6, 0.5, 0.4);
    let facets = Facets::new();
    let spheres = vec![Leaf::Sphere(DVec3::X * 0.4, 0.6), Leaf::Sphere(-DVec3::X * 0.4, 0.6)];
    type Case<'a> = (&'a str, Box<dyn Field>, &'a dyn Fn(DVec3) -> f64);
    let cases: [Case; 3] = [
        ("box", Box::new(Joined::oriented_box(axes, half)), &|p| exact::oriented_box(p, axes, half)),
        ("two spheres", Box::new(Joined::union(spheres)), &|p| exact::two_spheres(p, 0.4, 0.6)),
        ("facets", Box::new(facets.field()), &|p| facets.truth(p)),
    ];
    for (name, field, truth) in cases {
        let feet = watched(|watch| FieldFeet::new(&*field, &region(), VOXEL, watch)).expect("a surface");
        for half in [1.1, 4.0] {
            let (mean, max) = errors(&feet, truth, half, 12);
            assert!(mean < 0.005 && max < 0.06, "{name} within {half}: mean {mean}, max {max}");
        }
    }
}

#[test]
fn distances_are_taken_as_they_are() {
    let mut graph = Graph::new();
    let sphere = graph.sphere(0.6);
    let field = Expression::new(&graph, sphere);
    assert!(matches!(field.slope(), Slope::Exact { inside: true, outside: true }));
    let feet = watched(|watch| FieldFeet::new(&field, &region(), VOXEL, watch)).expect("a surface");
    assert_eq!(feet.seeds(), 0);
    let (_, max) = errors(&feet, &|p| exact::sphere(p, DVec3::ZERO, 0.6), 2.0, 20);
    assert!(max < 1e-4, "{max}");
}

fn object(field: &dyn Field, settings: &Settings, watch: &Watch) -> Result<DistanceObject, BuildError> {
    let feet = FieldFeet::new(field, &settings.region, settings.smallest_cell, watch)?;
    DistanceObject::build(&feet, settings, watch)
}

#[test]
fn objects_of_general_fields() {
    let facets = Facets::new();
    let field = facets.field();
    let settings = Settings::new(region(), VOXEL);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of a few threads");
        pool.install(|| watched(|watch| object(&field, &settings, watch)).expect("a surface"))
    };
    let (object, other) = (on(2), on(1));
    assert_eq!(object.report(), other.report());
    let report = object.report();
    assert!(report.error_at_surface < 0.05 * VOXEL && report.error_relative < 0.2, "{report:?}");
    let mut random = Random(8);
    let (mut mean, mut count) = (0.0, 0);
    for _ in 0..150 {
        let p = random.point(1.1);
        let (value, truth) = (object.reference(p), facets.truth(p));
        assert_eq!(value.to_bits(), other.reference(p).to_bits());
        assert!(truth.abs() < 0.2 * VOXEL || truth * value > 0.0, "sign at {p}: {value} {truth}");
        assert!((value - truth).abs() < 0.15 * truth.abs().max(VOXEL), "at {p}: {value} {truth}");
        if truth.abs() < 6.0 * VOXEL {
            mean += (value - truth).abs() / VOXEL;
            count += 1;
        }
    }
    assert!(mean / f64::from(count) < 0.02, "mean error {} of {count}", mean / f64::from(count));
}

#[test]
fn what_has_no_surface_says_so() {
    let nothing = Joined { leaves: vec![Leaf::Sphere(DVec3::splat(9.0), 0.1)], union: true, bounds: region() };
    let error = watched(|watch| object(&nothing, &Settings::new(region(), VOXEL), watch)).err();
    assert_eq!(error, Some(BuildError::Surface(band::Error::Empty { solid: false })));
}

/// A cube cut by planes at random tilts: what the facets of a Cubism figure are like.
struct Facets {
    /// Unit normals outward, and offsets.
    planes: Vec<(DVec3, f64)>,
}

impl Facets {
    fn new() -> Self {
        let mut random = Random(5);
        let planes = (0..30)
            .map(|i| {
                if i < 6 {
                    return (DVec3::AXES[i / 2] * if i % 2 == 0 { 1.0 } else { -1.0 }, 0.7);
                }
                (random.point(1.0).normalize(), 0.75 + 0.15 * random.unit())
            })
            .collect();
        Self { planes }
    }

    fn field(&self) -> Expression {
        let mut graph = Graph::new();
        let planes: Vec<_> = self.planes.iter().map(|&(normal, offset)| graph.half_space(normal, offset)).collect();
        let solid = graph.intersection(SetSystem::R0, &planes);
        Expression::new(&graph, solid)
    }

    fn holds(&self, p: DVec3) -> bool {
        self.planes.iter().all(|(normal, offset)| normal.dot(p) <= offset + 1e-9)
    }

    /// The signed distance by trying every face, edge and corner.
    fn truth(&self, p: DVec3) -> f64 {
        let inside = self.planes.iter().map(|(normal, offset)| offset - normal.dot(p)).fold(f64::INFINITY, f64::min);
        if inside >= 0.0 {
            return inside;
        }
        let planes = &self.planes;
        let mut best = f64::INFINITY;
        let mut consider = |q: DVec3| {
            if q.distance(p) < best && self.holds(q) {
                best = q.distance(p);
            }
        };
        for (i, &(n, a)) in planes.iter().enumerate() {
            consider(p - n * (n.dot(p) - a));
            for (j, &(m, b)) in planes.iter().enumerate().skip(i + 1) {
                let (c, line) = (n.dot(m), n.cross(m));
                let sine = 1.0 - c * c;
                let (x, y) = (a - n.dot(p), b - m.dot(p));
                consider(p + n * ((x - c * y) / sine) + m * ((y - c * x) / sine));
                for &(l, d) in &planes[j + 1..] {
                    consider((m.cross(l) * a + l.cross(n) * b + line * d) / line.dot(l));
                }
            }
        }
        -best
    }
}
