use std::{
    collections::HashMap,
    sync::{Arc, Mutex},
};

use glam::{DMat3, DVec3, Vec3};

use super::*;
use crate::{
    distance::{
        accuracy::exact,
        block::Meter,
        staged::Staged,
        testing::{Joined, Leaf, Saturated},
    },
    field::Points,
    grid::{VoxelSize, block_order, mask},
    node::{Source, load},
    shot::{PrepareOptions, Prepared},
    text::Overrides,
};

struct Errors {
    mean: f64,
    max: f64,
}

fn measure_at(field: &dyn Field, size: f64, chunk: usize) -> Measured<Vec<f32>> {
    let lattice = Lattice { voxel_size: VoxelSize::new(size).unwrap() };
    let region = field.bounding_box().unwrap().grown(4.0 * size);
    let cancel = AtomicBool::new(false);
    let settings =
        Settings { lattice, half_width: 3.0, region, feet: Feet::Nearest, cancel: &cancel, progress: &|_| {} };
    let visitor = || {
        |block: &MeasuredBlock| {
            check_feet(block, size);
            let feet = feet_of(block);
            feet.x[..feet.len].to_vec()
        }
    };
    let start = std::time::Instant::now();
    let measured = measure_opened(field, &settings, &visitor, chunk).unwrap().measured;
    eprintln!("{:?} for {} voxels, {:?}", start.elapsed(), measured.band.active_voxels(), measured.report);
    measured
}

fn feet_of(block: &MeasuredBlock) -> Points {
    let mut feet = Points::new(DVec3::ZERO);
    block.feet_into(&mut feet);
    feet
}

/// Feet and normals agree with the distances.
fn check_feet(block: &MeasuredBlock, size: f64) {
    let (points, feet) = (Points::of_block(block.origin, &block.lattice), feet_of(block));
    assert_eq!(feet.len, mask::count(block.active));
    for (at, i) in mask::places(block.active).enumerate() {
        let normal = Vec3::from(std::array::from_fn::<f32, 3, _>(|axis| block.normals[axis][i]));
        let foot = feet.offset(at) - (points.offset(i) - normal * block.distances[i]);
        assert!((normal.length() - 1.0).abs() < 1e-5 && f64::from(foot.length()) < 1e-5 * size);
        assert!(block.region.contains(feet.position(at)));
    }
    let unused = [&feet.x, &feet.y, &feet.z].map(|offsets| &offsets[feet.len..]);
    assert!(unused.into_iter().flatten().all(|offset| offset.is_finite()));
}

/// Compares every voxel of every block with the truth.
fn judge(measured: &Measured<Vec<f32>>, truth: impl Fn(DVec3) -> f64) -> Errors {
    let band = &measured.band;
    let size = band.lattice.voxel_size.get();
    let (mut sum, mut max, mut judged) = (0.0, 0.0f64, 0u64);
    for ((&origin, distances), active) in band.origins.iter().zip(&band.distances).zip(&band.active) {
        let points = Points::of_block(origin, &band.lattice);
        for i in 0..BLOCK_VOXELS {
            let exact = truth(points.position(i));
            let error = (f64::from(distances[i]) - exact.clamp(-3.0 * size, 3.0 * size)).abs() / size;
            assert!(error < 0.05, "{error} at {} (exact {})", points.position(i) / size, exact / size);
            let same_side = (exact > 0.0) == (distances[i] > 0.0);
            assert!(exact.abs() < 1e-4 * size || same_side, "sign of {} at {}", distances[i], points.position(i));
            if active[i >> 6] >> (i & 63) & 1 == 1 {
                sum += error;
                max = max.max(error);
                judged += 1;
            }
        }
    }
    Errors { mean: sum / judged as f64, max }
}

fn check(field: &dyn Field, size: f64, truth: impl Fn(DVec3) -> f64) {
    let measured = measure_at(field, size, CHUNK);
    let errors = judge(&measured, truth);
    eprintln!("mean {} max {}", errors.mean, errors.max);
    assert!(errors.mean <= 0.005 && errors.max <= 0.05, "mean {} max {}", errors.mean, errors.max);
    assert_eq!((measured.report.cut_voxels, measured.report.thin.len()), ([0; 6], 0));
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
    let settings =
        Settings { lattice, half_width: 3.0, region, feet: Feet::Nearest, cancel: &cancel, progress: &|_| {} };
    let measured = measure(&field, &settings, || |_: &MeasuredBlock| ()).unwrap();
    for (origin, distances) in measured.band.origins.iter().zip(&measured.band.distances) {
        let points = Points::of_block(*origin, &lattice);
        for i in 0..BLOCK_VOXELS {
            let exact = exact::sphere(points.position(i), centre, radius).max(-3.0);
            assert!((f64::from(distances[i]) - exact).abs() < 0.02, "{} for {exact}", distances[i]);
        }
    }
    assert!(measured.report.thin[0].voxels > 0);
    assert!(measured.report.thin[0].at.distance(centre) < 1.0);
}

#[test]
fn feet_travel_where_newton_fails_and_across_chunks_and_threads() {
    let size = 1.0 / 24.0;
    // The value saturates half a voxel from the surface; farther away its gradient is zero in f32.
    let field = Saturated { inner: Joined::one(Leaf::Sphere(DVec3::splat(0.02), 1.0)), width: 0.2 * size };
    let truth = |p| exact::sphere(p, DVec3::splat(0.02), 1.0);
    let pool = |threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let mut results = Vec::new();
    for (chunk, threads) in [(CHUNK, 1), (CHUNK, 3), (32, 2)] {
        let measured = pool(threads).install(|| measure_at(&field, size, chunk));
        let errors = judge(&measured, truth);
        eprintln!("mean {} max {}", errors.mean, errors.max);
        assert!(errors.mean <= 0.005);
        results.push(measured);
    }
    assert_eq!(results[0].band.distances, results[1].band.distances);
    assert_eq!(results[0].visits, results[1].visits);
    assert_eq!(results[0].band.origins, results[2].band.origins);
}

#[test]
fn what_cannot_be_measured_says_why() {
    let field = Joined::one(Leaf::Sphere(DVec3::ZERO, 1.0));
    let run = |half: f64, size: f64, stop: bool| {
        let cancel = AtomicBool::new(stop);
        let region = Aabb::new(DVec3::splat(-half), DVec3::splat(half));
        let lattice = Lattice { voxel_size: VoxelSize::new(size).unwrap() };
        let settings =
            Settings { lattice, half_width: 3.0, region, feet: Feet::Nearest, cancel: &cancel, progress: &|_| {} };
        measure(&field, &settings, || |_: &MeasuredBlock| ()).map(|measured| measured.report)
    };
    assert_eq!(run(0.1, 0.01, false).unwrap_err(), Error::Empty { solid: true });
    assert_eq!(run(1.0, 0.05, true).unwrap_err(), Error::Cancelled);
    assert!(matches!(run(1.0, 1e-10, false).unwrap_err(), Error::TooFar { .. }));
    let cut = run(0.8, 0.05, false).unwrap().cut_voxels;
    // The region's blocks end at voxels −16 and 24, the solid at ± 20.
    for side in [0, 2, 4] {
        assert!(cut[side] > 100 && cut[side + 1] == 0, "{cut:?}");
    }
}

/// A scene of ours at a resolution of 48.
fn prepared(scene: &str) -> Prepared {
    let model = load(&Source::Builtin(scene.into()), &Overrides::default()).unwrap();
    let options = PrepareOptions {
        voxel_size: None,
        resolution: Some(48),
        half_width: None,
        memory_limit: None,
        cache: None,
        cancel: Arc::default(),
        progress: &|_, _| {},
    };
    Arc::new(model).prepare(&options).unwrap()
}

/// Facets of about a voxel, cut, in chunks so small that many blocks are measured again for what later ones offer.
#[test]
fn measuring_a_block_again_brings_no_foot_farther() {
    let prepared = prepared("cubism-sliced");
    let Prepared { lattice, half_width, .. } = prepared;
    let cancel = AtomicBool::new(false);
    for frame in [2, 3, 6] {
        let content = prepared.frame(frame).unwrap();
        let settings = Settings {
            lattice,
            half_width,
            region: content.region,
            feet: Feet::Nearest,
            cancel: &cancel,
            progress: &|_| {},
        };
        let visits = Mutex::new(HashMap::<IVec3, Vec<[f32; BLOCK_VOXELS]>>::new());
        let visitor =
            || |block: &MeasuredBlock| visits.lock().unwrap().entry(block.origin).or_default().push(*block.distances);
        measure_opened(&*content.field, &settings, &visitor, 4).unwrap();
        let visits = visits.into_inner().unwrap();
        let again: Vec<_> = visits.values().flat_map(|of_block| of_block.windows(2)).collect();
        let farther = |pair: &[[f32; BLOCK_VOXELS]]| (0..BLOCK_VOXELS).any(|i| pair[1][i].abs() > pair[0][i].abs());
        let worse = again.iter().filter(|pair| farther(pair)).count();
        assert!(!again.is_empty() && worse == 0, "{worse} of {} in frame {frame}", again.len());
    }
}

/// Which thread measures which blocks, and so what its scratch memory holds before each, changes from run to run.
#[test]
fn a_block_is_independent_of_the_blocks_before() {
    let prepared = prepared("microstructure");
    let Prepared { lattice, half_width, .. } = prepared;
    let cancel = AtomicBool::new(false);
    let content = prepared.frame(24).unwrap();
    let settings = Settings {
        lattice,
        half_width,
        region: content.region,
        feet: Feet::Nearest,
        cancel: &cancel,
        progress: &|_| {},
    };
    let scope = settings.scope();
    let blocks = descent::descend(&*content.field, &scope, &cancel).unwrap().blocks;
    let measure = |meter: &mut Meter, origin: IVec3| {
        let mut block = Staged::new();
        meter.enter_nodes(origin);
        meter.measure(origin, &mut block).unwrap();
        (block.distances.map(f32::to_bits), block.normals.map(|normals| normals.map(f32::to_bits)))
    };
    let mut meter = Meter::new(&*content.field, &scope, Feet::Nearest);
    let forward: Vec<_> = blocks.iter().map(|origin| measure(&mut meter, *origin)).collect();
    for (origin, known) in blocks.iter().zip(&forward).rev() {
        assert!(measure(&mut meter, *origin) == *known, "{origin}");
    }
}

/// To first order a torus by its polynomial is right to d² by its radius, with the same signs and, but at its edge, the same
/// band.
#[test]
fn first_order_is_the_distance_of_what_is_smooth() {
    let field = Joined::one(Leaf::Torus(0.8, 0.25));
    let size = 0.02;
    let lattice = Lattice { voxel_size: VoxelSize::new(size).unwrap() };
    let region = field.bounding_box().unwrap().grown(4.0 * size);
    let cancel = AtomicBool::new(false);
    let of = |feet| {
        let settings = Settings { lattice, half_width: 3.0, region, feet, cancel: &cancel, progress: &|_| {} };
        measure(&field, &settings, || |_: &MeasuredBlock| ()).unwrap().band
    };
    let (nearest, first) = (of(Feet::Nearest), of(Feet::FirstOrder));
    for (place, origin) in nearest.origins.iter().enumerate() {
        let other = first.origins.binary_search_by_key(&block_order(*origin), |origin| block_order(*origin));
        for i in mask::places(&nearest.active[place]) {
            let exact = f64::from(nearest.distances[place][i]);
            let Ok(other) = other else {
                assert!(exact.abs() > 2.8 * size, "{exact}");
                continue;
            };
            let nearly = f64::from(first.distances[other][i]);
            assert_eq!(exact >= 0.0, nearly >= 0.0);
            // The torus curves by its tube's radius, and its polynomial by no more.
            assert!((exact - nearly).abs() <= exact * exact / 0.25 + 1e-5, "{exact} {nearly}");
        }
    }
}

/// Of a cone, sharp at its rim and its tip, first order is nearly the distance beside the surface.
#[test]
fn first_order_goes_around_edges() {
    // Voxels lie on the base; stretched it knows no distance.
    for text in ["cone = 0.6", "cone = 0.6\nscale = [1, 1, 1.01]"] {
        let text = format!("[shape.a]\n{text}\nheight = 0.6\n");
        let source = Source::Text { name: "cone".into(), text, folder: ".".into() };
        let model = Arc::new(load(&source, &Overrides::default()).unwrap());
        first_order_is_near(
            &model.prepare(&PrepareOptions { resolution: Some(140), ..PrepareOptions::default() }).unwrap(),
        );
    }
}

fn first_order_is_near(scene: &Prepared) {
    let content = scene.frame(1).unwrap();
    let cancel = AtomicBool::new(false);
    let voxel = scene.lattice.voxel_size.get();
    let of = |feet| {
        let settings = Settings {
            lattice: scene.lattice,
            half_width: 3.0,
            region: content.region,
            feet,
            cancel: &cancel,
            progress: &|_| {},
        };
        measure(&*content.field, &settings, || |_: &MeasuredBlock| ()).unwrap().band
    };
    let (nearest, first) = (of(Feet::Nearest), of(Feet::FirstOrder));
    for (place, origin) in nearest.origins.iter().enumerate() {
        let other = first.origins.binary_search_by_key(&block_order(*origin), |origin| block_order(*origin));
        for i in mask::places(&nearest.active[place]) {
            let exact = f64::from(nearest.distances[place][i]) / voxel;
            let Ok(other) = other else {
                assert!(exact.abs() > 2.0, "{exact}");
                continue;
            };
            let nearly = f64::from(first.distances[other][i]) / voxel;
            assert!(exact.abs() > 1.0 || (exact - nearly).abs() < 0.2, "{exact} {nearly} at {origin}");
        }
    }
}
