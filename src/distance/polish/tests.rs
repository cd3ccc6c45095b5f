use glam::{DMat3, DVec3, IVec3, Vec3};

use super::{Polisher, Request};
use crate::{
    distance::{
        accuracy::exact,
        testing::{Joined, Leaf},
    },
    field::{BATCH, Field, Points},
    grid::{Lattice, VoxelSize},
};

const UNIT: f64 = 1.0 / 32.0;
const REACH: f64 = 3.0 * UNIT;

/// The worst error in units over all blocks around the origin, for queries with a foot within reach.
fn worst(field: &Joined, truth: impl Fn(DVec3) -> f64) -> f64 {
    let lattice = Lattice { voxel_size: VoxelSize::new(UNIT).unwrap() };
    let mut polisher = Polisher::new();
    let mut evaluator = field.evaluator();
    let mut distances = [0.0; BATCH];
    let mut worst = 0.0f64;
    let mut judged = 0;
    for block in 0..12 * 12 * 12 {
        let origin = (IVec3::new(block / 144, block / 12 % 12, block % 12) - 6) * 8;
        let queries = Points::of_block(origin, &lattice);
        let corner = queries.offset(0).as_dvec3();
        let region = crate::field::Aabb::new(queries.origin + corner, queries.origin - corner).grown(REACH + UNIT);
        evaluator.enter(&region);
        let mut feet = queries.clone();
        let request = Request { unit: UNIT as f32, least: 1e-4, reach: REACH as f32, region };
        let inside = std::array::from_fn(|i| field.reference(queries.position(i)) >= 0.0);
        polisher.closest(&mut *evaluator, &request, &queries, &inside, &mut feet, &mut distances);
        evaluator.leave();
        for i in 0..BATCH {
            let distance = truth(queries.position(i)).abs();
            if distance < REACH {
                judged += 1;
                let error = (f64::from(distances[i]) - distance).abs() / UNIT;
                assert!(error < 0.05, "{error} at {} (distance {})", queries.position(i) / UNIT, distance / UNIT);
                worst = worst.max(error);
                let foot_error = ((feet.position(i) - queries.position(i)).length() - distance).abs() / UNIT;
                assert!(foot_error < 0.05, "foot {foot_error}");
            }
        }
    }
    assert!(judged > 10_000, "only {judged} queries within reach");
    worst
}

#[test]
fn smooth_shapes() {
    let centre = DVec3::new(0.1, 0.05, -0.03);
    let sphere = Joined::one(Leaf::Sphere(centre, 0.8));
    assert!(worst(&sphere, |p| exact::sphere(p, centre, 0.8)) < 0.005);
    let torus = Joined::one(Leaf::Torus(0.8, 0.3));
    assert!(worst(&torus, |p| exact::torus(p, 0.8, 0.3)) < 0.005);
    let axes = DVec3::new(1.2, 0.7, 0.5);
    assert!(worst(&Joined::one(Leaf::Ellipsoid(axes)), |p| exact::ellipsoid(p, axes)) < 0.005);
}

#[test]
fn edges_and_corners_of_a_box() {
    let axes = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7);
    let half = DVec3::new(0.7, 0.5, 0.31);
    assert!(worst(&Joined::oriented_box(axes, half), |p| exact::oriented_box(p, axes, half)) < 0.02);
}

#[test]
fn the_concave_crease_of_two_spheres() {
    let x = DVec3::new(0.4, 0.0, 0.0);
    let field = Joined::union(vec![Leaf::Sphere(x, 0.6), Leaf::Sphere(-x, 0.6)]);
    assert!(worst(&field, |p| exact::two_spheres(p, 0.4, 0.6)) < 0.02);
}

#[test]
fn small_balls_and_far_queries() {
    // Outside a ball of one unit the plain projection overshoots; the share must find itself.
    let field = Joined::one(Leaf::Sphere(DVec3::ZERO, UNIT));
    let mut queries = Points::new(DVec3::ZERO);
    for i in 1..100 {
        queries.push(Vec3::new(0.3, 0.8, -0.5) * (i as f32 * 0.1 * UNIT as f32));
    }
    // Seeds on the far side of the ball's equator.
    let mut feet = queries.clone();
    for i in 0..queries.len {
        (feet.x[i], feet.y[i], feet.z[i]) = (UNIT as f32, 0.0, 0.0);
    }
    let region = crate::field::Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
    let request = Request { unit: UNIT as f32, least: 1e-4, reach: 1.0, region };
    let mut distances = [0.0; BATCH];
    Polisher::new().closest(&mut *field.evaluator(), &request, &queries, &[false; BATCH], &mut feet, &mut distances);
    for i in 0..queries.len {
        let truth = exact::sphere(queries.position(i), DVec3::ZERO, UNIT).abs();
        let error = (f64::from(distances[i]) - truth).abs() / UNIT;
        assert!(error < 0.01, "{error} at distance {}", truth / UNIT);
    }
}

/// Feet of queries so far from a slab's faces that no branch has one near, from seeds beside them: what the polisher did
/// before, about another origin, makes no difference.
#[test]
fn a_batch_is_independent_of_the_batch_before() {
    let field = Joined::oriented_box(DMat3::IDENTITY, DVec3::new(0.5, 3.0, 3.0));
    let region = crate::field::Aabb::new(DVec3::splat(-5.0), DVec3::splat(5.0));
    let request = Request { unit: UNIT as f32, least: 1e-4, reach: 0.3, region };
    let closest = |polisher: &mut Polisher, origin: DVec3| {
        let (mut queries, mut feet) = (Points::new(origin), Points::new(origin));
        for i in 0..20 {
            let query = DVec3::new(2.0, 0.03 * f64::from(i), -0.02 * f64::from(i));
            queries.push((query - origin).as_vec3());
            feet.push((query.with_x(0.5) + DVec3::new(0.0, 0.4, -0.3) - origin).as_vec3());
        }
        let mut distances = [0.0; BATCH];
        polisher.closest(&mut *field.evaluator(), &request, &queries, &[false; BATCH], &mut feet, &mut distances);
        distances[..queries.len].to_vec()
    };
    let origin = DVec3::new(2.0, 0.0, 0.0);
    let fresh = closest(&mut Polisher::new(), origin);
    assert!(fresh.iter().all(|distance| (distance - 1.5).abs() < 0.01 * UNIT as f32), "{fresh:?}");
    for before in [DVec3::ZERO, DVec3::new(-1.0, 2.0, 0.5)] {
        let mut polisher = Polisher::new();
        let mut near = Points::new(before);
        near.push((DVec3::new(0.6, 0.0, 0.0) - before).as_vec3());
        let mut feet = near.clone();
        polisher.closest(&mut *field.evaluator(), &request, &near, &[false; BATCH], &mut feet, &mut [0.0; BATCH]);
        assert_eq!(closest(&mut polisher, origin), fresh);
    }
}
