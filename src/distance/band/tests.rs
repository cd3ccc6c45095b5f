use glam::{DMat3, DVec3};

use super::*;
use crate::{
    distance::testing::{Joined, Leaf, exact},
    grid::VoxelSize,
};

struct Errors {
    mean: f64,
    max: f64,
}

/// Measures a band and compares every voxel of every block, and every voxel that no block holds, with the truth.
fn judge(field: &dyn Field, size: f64, truth: impl Fn(DVec3) -> f64) -> Errors {
    let lattice = Lattice { voxel_size: VoxelSize::new(size).unwrap() };
    let region = field.bounding_box().unwrap().grown(4.0 * size);
    let cancel = AtomicBool::new(false);
    let settings = Settings { lattice, half_width: 3.0, region, cancel: &cancel, progress: &|_| {} };
    let start = std::time::Instant::now();
    let measured = measure(field, &settings, || |_: &MeasuredBlock| ()).unwrap();
    eprintln!("{:?} for {} voxels, {:?}", start.elapsed(), measured.band.active_voxels(), measured.report);
    let band = &measured.band;
    let (mut sum, mut max, mut judged) = (0.0, 0.0f64, 0u64);
    for ((&origin, distances), active) in band.origins.iter().zip(&band.distances).zip(&band.active) {
        let points = crate::field::Points::of_block(origin, &lattice);
        for i in 0..BLOCK_VOXELS {
            let exact = truth(points.position(i));
            let clamped = exact.clamp(-3.0 * size, 3.0 * size);
            let error = (f64::from(distances[i]) - clamped).abs() / size;
            assert!(error < 0.05, "{error} at {} (exact {})", points.position(i) / size, exact / size);
            assert!(
                exact.abs() < 1e-4 * size || (exact > 0.0) == (distances[i] > 0.0),
                "sign of {} for {exact} at {}",
                distances[i],
                points.position(i)
            );
            if active[i >> 6] >> (i & 63) & 1 == 1 {
                sum += error;
                max = max.max(error);
                judged += 1;
            }
        }
    }
    assert_eq!((measured.report.cut_voxels, measured.report.thin_voxels), ([0; 6], 0));
    Errors { mean: sum / judged as f64, max }
}

fn check(field: &dyn Field, size: f64, truth: impl Fn(DVec3) -> f64) {
    let errors = judge(field, size, truth);
    eprintln!("mean {} max {}", errors.mean, errors.max);
    assert!(errors.mean <= 0.005 && errors.max <= 0.05, "mean {} max {}", errors.mean, errors.max);
}

#[test]
fn a_sphere_whose_value_is_no_distance() {
    let centre = DVec3::new(0.013, 0.2, 0.07);
    check(&Joined::one(Leaf::Sphere(centre, 1.0)), 1.0 / 48.0, |p| exact::sphere(p, centre, 1.0));
}

#[test]
fn a_torus() {
    check(&Joined::one(Leaf::Torus(0.8, 0.3)), 1.0 / 48.0, |p| exact::torus(p, 0.8, 0.3));
}

#[test]
fn an_ellipsoid() {
    let axes = DVec3::new(1.0, 0.6, 0.4);
    check(&Joined::one(Leaf::Ellipsoid(axes)), 1.0 / 48.0, |p| exact::ellipsoid(p, axes));
}

#[test]
fn a_turned_box_of_six_half_spaces() {
    let axes = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7);
    let half = DVec3::new(0.9, 0.6, 0.4);
    check(&Joined::oriented_box(axes, half), 1.0 / 48.0, |p| exact::oriented_box(p, axes, half));
}

#[test]
fn two_overlapping_spheres() {
    let x = DVec3::new(0.4, 0.0, 0.0);
    let field = Joined::union(vec![Leaf::Sphere(x, 0.7), Leaf::Sphere(-x, 0.7)]);
    check(&field, 1.0 / 48.0, |p| exact::two_spheres(p, 0.4, 0.7));
}

#[test]
fn a_ball_smaller_than_a_voxel_is_found_and_reported() {
    let (centre, radius) = (DVec3::splat(0.43), 0.2);
    let field = Joined::one(Leaf::Sphere(centre, radius));
    let lattice = Lattice { voxel_size: VoxelSize::new(1.0).unwrap() };
    let cancel = AtomicBool::new(false);
    let region = Aabb::new(DVec3::splat(-9.0), DVec3::splat(9.0));
    let settings = Settings { lattice, half_width: 3.0, region, cancel: &cancel, progress: &|_| {} };
    let measured = measure(&field, &settings, || |_: &MeasuredBlock| ()).unwrap();
    for (origin, distances) in measured.band.origins.iter().zip(&measured.band.distances) {
        let points = crate::field::Points::of_block(*origin, &lattice);
        for i in 0..BLOCK_VOXELS {
            let exact = exact::sphere(points.position(i), centre, radius).max(-3.0);
            assert!((f64::from(distances[i]) - exact).abs() < 0.02, "{} for {exact}", distances[i]);
        }
    }
    assert!(measured.report.thin_voxels > 0);
    assert!(measured.report.thin_at.unwrap().distance(centre) < 1.0);
}
