//! Feet and distance objects of general fields against exact distances.

use std::sync::atomic::AtomicBool;

use glam::{DMat3, DVec3};

use super::*;
use crate::distance::accuracy::exact;
use crate::distance::octree::{DistanceObject, Settings};
use crate::distance::testing::{Joined, Leaf};

#[test]
#[ignore]
fn explore() {
    let cancel = AtomicBool::new(false);
    let watch = Watch { cancel: &cancel, progress: &|_| {} };
    let voxel = 2.0 / 128.0;
    let region = Aabb::new(DVec3::splat(-1.1), DVec3::splat(1.1));
    let axes = DMat3::from_rotation_z(0.4) * DMat3::from_rotation_x(0.3);
    let half = DVec3::new(0.6, 0.5, 0.4);
    let cases: Vec<(&str, Joined, Box<dyn Fn(DVec3) -> f64>)> = vec![
        ("sphere", Joined::one(Leaf::Sphere(DVec3::ZERO, 0.9)), Box::new(|p| exact::sphere(p, DVec3::ZERO, 0.9))),
        ("torus", Joined::one(Leaf::Torus(0.7, 0.25)), Box::new(|p| exact::torus(p, 0.7, 0.25))),
        (
            "ellipsoid",
            Joined::one(Leaf::Ellipsoid(DVec3::new(1.0, 0.5, 0.3))),
            Box::new(|p| exact::ellipsoid(p, DVec3::new(1.0, 0.5, 0.3))),
        ),
        ("box", Joined::oriented_box(axes, half), Box::new(move |p| exact::oriented_box(p, axes, half))),
        (
            "two",
            Joined::union(vec![Leaf::Sphere(DVec3::X * 0.4, 0.6), Leaf::Sphere(-DVec3::X * 0.4, 0.6)]),
            Box::new(|p| exact::two_spheres(p, 0.4, 0.6)),
        ),
    ];
    for (name, field, truth) in &cases {
        let start = std::time::Instant::now();
        let feet = FieldFeet::new(field, &region, voxel, &watch).unwrap();
        let seeded = start.elapsed();
        let object = DistanceObject::build(&feet, &Settings::new(region, voxel), &watch).unwrap();
        println!("{name}: seeds {} in {seeded:?}, built in {:?}: {:?}", feet.seeds(), start.elapsed(), object.report());
        let mut state = 1_u64;
        let mut unit = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        for (what, half) in [("near", 1.2), ("far", 4.0)] {
            let mut positions = Vec::new();
            let (mut mean, mut max, mut count) = (0.0, 0.0_f64, 0);
            let (mut omean, mut omax) = (0.0, 0.0_f64);
            for _ in 0..40 {
                let c = DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5) * 2.0 * half;
                positions.clear();
                for _ in 0..100 {
                    positions.push(c + DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5) * 0.1);
                }
                let mut out = vec![Foot { point: DVec3::ZERO, distance: 0.0, gradient: DVec3::ZERO, part: 0 }; 100];
                feet.feet(&positions, &mut out);
                for (p, foot) in positions.iter().zip(&out) {
                    let e = (foot.distance - truth(*p)).abs() / voxel;
                    mean += e;
                    max = max.max(e);
                    count += 1;
                    let e = (object.reference(*p) - truth(*p)).abs() / truth(*p).abs().max(voxel);
                    omean += e;
                    omax = omax.max(e);
                }
            }
            println!(
                "  {what}: feet mean {} max {} voxels; object relative {} {}",
                mean / f64::from(count),
                max,
                omean / f64::from(count),
                omax
            );
        }
    }
}

/// A cube cut by planes at random tilts: what the facets of a Cubism figure are like.
fn faceted_cube() -> crate::field::Expression {
    use crate::field::{Expression, Graph, SetSystem};
    let mut graph = Graph::new();
    let mut state = 5_u64;
    let mut unit = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let mut planes = Vec::new();
    for i in 0..30 {
        let mut normal = DVec3::new(unit() - 0.5, unit() - 0.5, unit() - 0.5).normalize();
        let mut offset = 0.75 + 0.15 * unit();
        if i < 6 {
            normal = DVec3::AXES[i / 2] * if i % 2 == 0 { 1.0 } else { -1.0 };
            offset = 0.7;
        }
        planes.push(graph.half_space(normal, offset));
    }
    let solid = graph.intersection(SetSystem::R0, &planes);
    Expression::new(&graph, solid)
}

#[test]
#[ignore]
fn explore_facets() {
    let cancel = AtomicBool::new(false);
    let watch = Watch { cancel: &cancel, progress: &|_| {} };
    let voxel = 2.0 / 128.0;
    let region = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
    let field = faceted_cube();
    let start = std::time::Instant::now();
    let feet = FieldFeet::new(&field, &region, voxel, &watch).unwrap();
    println!("facets: seeds {} in {:?}", feet.seeds(), start.elapsed());
    let object = DistanceObject::build(&feet, &Settings::new(region, voxel), &watch).unwrap();
    println!("facets: built in {:?}: {:?}", start.elapsed(), object.report());
}
