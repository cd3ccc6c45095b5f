//! Distance objects against exact distances.

use std::sync::atomic::AtomicBool;

use glam::DVec3;

use super::*;
use crate::field::{BATCH, Gradients, Hint, Interval, Points};

struct Sphere(DVec3, f64);

impl ClosestPoint for Sphere {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        for (p, foot) in positions.iter().zip(feet) {
            let away = *p - self.0;
            let gradient = -away.normalize_or(DVec3::X);
            let distance = self.1 - away.length();
            *foot = Foot { point: *p - gradient * distance, distance, gradient, part: 0 };
        }
    }
}

/// Centred, by half its edges.
struct Cuboid(DVec3);

impl ClosestPoint for Cuboid {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        for (p, foot) in positions.iter().zip(feet) {
            let q = p.abs() - self.0;
            let signs = DVec3::new(1.0_f64.copysign(p.x), 1.0_f64.copysign(p.y), 1.0_f64.copysign(p.z));
            let (distance, gradient) = if q.max_element() > 0.0 {
                let out = q.max(DVec3::ZERO);
                (-out.length(), -out.normalize() * signs)
            } else {
                let axis = if q.x >= q.y && q.x >= q.z {
                    DVec3::X
                } else if q.y >= q.z {
                    DVec3::Y
                } else {
                    DVec3::Z
                };
                (-q.max_element(), -axis * signs)
            };
            *foot = Foot { point: *p - gradient * distance, distance, gradient, part: 0 };
        }
    }
}

/// Around z, by both radii.
struct Torus(f64, f64);

impl ClosestPoint for Torus {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        for (p, foot) in positions.iter().zip(feet) {
            let around = DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X) * self.0;
            let away = *p - around;
            let gradient = -away.normalize_or(DVec3::Z);
            let distance = self.1 - away.length();
            *foot = Foot { point: *p - gradient * distance, distance, gradient, part: 0 };
        }
    }
}

/// Exact outside and inside while they do not touch.
struct Two(Sphere, Sphere);

impl ClosestPoint for Two {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        self.0.feet(positions, feet);
        for (p, foot) in positions.iter().zip(feet) {
            let mut other = *foot;
            self.1.feet(&[*p], std::slice::from_mut(&mut other));
            if other.distance > foot.distance {
                *foot = Foot { part: 1, ..other };
            }
        }
    }
}

/// A function that is no distance, to test what the spline reproduces.
struct Function<F: Fn(DVec3) -> (f64, DVec3) + Sync>(F);

impl<F: Fn(DVec3) -> (f64, DVec3) + Sync> ClosestPoint for Function<F> {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        for (p, foot) in positions.iter().zip(feet) {
            let (distance, gradient) = (self.0)(*p);
            *foot = Foot { point: *p, distance, gradient, part: 0 };
        }
    }
}

fn exact(oracle: &dyn ClosestPoint, position: DVec3) -> Foot {
    let mut foot = [Foot { point: DVec3::ZERO, distance: 0.0, gradient: DVec3::ZERO, part: 0 }];
    oracle.feet(&[position], &mut foot);
    foot[0]
}

fn build_with(oracle: &dyn ClosestPoint, settings: &Settings) -> DistanceObject {
    let (cancel, progress) = (AtomicBool::new(false), |_: f64| {});
    let watch = Watch { cancel: &cancel, progress: &progress };
    DistanceObject::build(oracle, settings, &watch).expect("the test's own surface")
}

fn build(oracle: &dyn ClosestPoint, half: f64, voxel: f64) -> DistanceObject {
    build_with(oracle, &Settings::new(Aabb::new(DVec3::splat(-half), DVec3::splat(half)), voxel))
}

const VOXEL: f64 = 2.0 / 128.0;

fn oracles() -> Vec<(&'static str, Box<dyn ClosestPoint>)> {
    let two = Two(Sphere(DVec3::new(-0.5, 0.0, 0.0), 0.4), Sphere(DVec3::new(0.5, 0.1, 0.0), 0.4));
    vec![
        ("sphere", Box::new(Sphere(DVec3::new(0.01, 0.02, 0.03), 0.93))),
        ("box", Box::new(Cuboid(DVec3::new(0.913, 0.7, 0.5)))),
        ("torus", Box::new(Torus(0.7, 0.25))),
        ("two spheres", Box::new(two)),
    ]
}

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

struct Errors {
    mean: f64,
    max: f64,
    wrong_signs: usize,
}

/// Errors in voxels at random points nearer to the surface than `within` voxels; signs are counted where the
/// surface is farther than `clear` voxels.
fn near_errors(object: &DistanceObject, oracle: &dyn ClosestPoint, voxel: f64, within: f64, clear: f64) -> Errors {
    let mut random = Random(7);
    let (mut sum, mut max, mut count, mut wrong_signs) = (0.0, 0.0_f64, 0, 0);
    while count < 40_000 {
        let start = exact(oracle, random.point(1.2)).point;
        let p = start + random.point(within * voxel);
        let truth = exact(oracle, p).distance;
        let value = object.reference(p);
        let error = (value - truth).abs() / voxel;
        sum += error;
        max = max.max(error);
        count += 1;
        wrong_signs += usize::from(truth.abs() > clear * voxel && truth * value < 0.0);
    }
    Errors { mean: sum / f64::from(count), max, wrong_signs }
}

fn leaf_places(object: &DistanceObject) -> Vec<Place> {
    let (mut places, mut open) = (Vec::new(), vec![object.root()]);
    while let Some(place) = open.pop() {
        match object.nodes[place.node as usize] {
            node if node & LEAF != 0 => places.push(place),
            node => open.extend((0..8).map(|child| place.nth_child(node, child))),
        }
    }
    places
}

/// The greatest jumps of value (over the smaller cell's edge) and of gradient across faces between leaves, and how
/// many of the faces are between leaves of different size. Numbers at corners are `f32`: where a value is so many times
/// the cell's edge, its rounding is as much of a gradient, and is taken for so much less.
fn jumps(object: &DistanceObject) -> (f64, f64, usize) {
    let mut random = Random(11);
    let (mut value, mut gradient, mut changes) = (0.0_f64, 0.0_f64, 0);
    let top = f64::from(object.root_size());
    for place in leaf_places(object) {
        let patch = object.patch(place);
        for face in 0..6 {
            let (axis, side) = (face / 2, f64::from(face as u32 % 2));
            let mut t = [random.unit(), random.unit(), random.unit()];
            t[axis] = side;
            let size = f64::from(place.size);
            let at: [f64; 3] = std::array::from_fn(|i| f64::from(place.origin[i]) + t[i] * size);
            let mut over = at;
            over[axis] += side - 0.5;
            if over[axis] < 0.0 || over[axis] > top {
                continue;
            }
            let (other, _) = object.find(object.origin + DVec3::from(over) * object.step);
            if other.size > place.size {
                continue;
            }
            let other_t = std::array::from_fn(|i| (at[i] - f64::from(other.origin[i])) / f64::from(other.size));
            let (a, b) = (patch.jet(t), object.patch(other).jet(other_t));
            changes += usize::from(other.size != place.size);
            let edge = f64::from(other.size) * object.step;
            let rounding = (a[0].abs() / edge).max(1.0);
            value = value.max((a[0] - b[0]).abs() / edge);
            gradient = [4, 2, 1].iter().map(|&i: &usize| (a[i] - b[i]).abs() / rounding).fold(gradient, f64::max);
        }
    }
    (value, gradient, changes)
}

#[test]
fn smooth_across_every_change_of_size() {
    for (name, oracle) in oracles() {
        let object = build(&*oracle, 1.5, VOXEL);
        let (value, gradient, changes) = jumps(&object);
        assert!(changes > 500, "{name} has {changes} changes of size");
        assert!(value < 1e-6 && gradient < 1e-6, "{name} jumps by {value}, its gradient by {gradient}");
    }
}

#[test]
fn smooth_across_the_root_and_as_steep_as_declared() {
    for (name, oracle) in oracles() {
        let object = build(&*oracle, 1.5, 2.0 * VOXEL);
        let Slope::Lipschitz(slope) = object.slope() else { panic!("a slope is declared") };
        let (root, mut random) = (object.root_box(), Random(5));
        let half = root.size().x / 2.0;
        let (mut value, mut gradient) = (0.0_f64, 0.0_f64);
        for i in 0..3000 {
            // Beside a face, and also where an edge or corner of the root is near.
            let mut p = random.point(1.2 * half);
            let axis = i % 3;
            p[axis] = if i % 2 == 0 { root.min[axis] } else { root.max[axis] };
            let nudge = DVec3::AXES[axis] * 1e-9;
            let (a, da) = object.value_and_gradient(p + nudge);
            let (b, db) = object.value_and_gradient(p - nudge);
            value = value.max((a - b).abs());
            gradient = gradient.max((da - db).length());
        }
        assert!(value < 1e-7 && gradient < 1e-6, "{name} jumps by {value}, its gradient by {gradient}");
        for _ in 0..20_000 {
            let p = random.point(3.0 * half);
            let steep = object.value_and_gradient(p).1.length();
            assert!(steep <= slope, "{name}: slope {steep} at {p}, {slope} declared");
        }
        // Differences agree with the gradient, beyond the root too.
        for _ in 0..500 {
            let p = random.point(2.0 * half);
            let (_, gradient) = object.value_and_gradient(p);
            for axis in 0..3 {
                let step = DVec3::AXES[axis] * 1e-5;
                let difference = (object.reference(p + step) - object.reference(p - step)) / 2e-5;
                assert!((difference - gradient[axis]).abs() < 1e-4, "{name} at {p}: {difference} {gradient}");
            }
        }
        for _ in 0..500 {
            let p = random.point(1.0);
            let p = p / p.abs().max_element() * half * 20.0;
            let (value, truth) = (object.reference(p), exact(&*oracle, p).distance);
            assert!((value / truth - 1.0).abs() < 0.1, "{name} at {p}: {value}, the distance is {truth}");
        }
    }
}

#[test]
fn linear_functions_are_kept() {
    let slope = DVec3::new(0.3, -0.5, 0.8);
    let plane = Function(|p: DVec3| (slope.dot(p) + 0.1, slope));
    let object = build(&plane, 1.0, 0.05);
    let mut random = Random(1);
    for _ in 0..1000 {
        let p = random.point(1.0);
        let (value, gradient) = object.value_and_gradient(p);
        assert!((value - slope.dot(p) - 0.1).abs() < 1e-6 && (gradient - slope).length() < 1e-6, "at {p}");
    }
    // It crosses the whole root, in cells of a few smallest ones.
    let most = object.root_size().pow(2) as usize / 8;
    assert!(object.report().cells < most, "a plane needs few cells: {:?}", object.report());
}

/// Errors are in voxels. Creases are rounded by a sixth of the smallest cell.
#[test]
fn near_the_surface_distances_hold() {
    for (name, oracle) in oracles() {
        let object = build(&*oracle, 1.5, VOXEL);
        let creased = name == "box";
        let errors = near_errors(&object, &*oracle, VOXEL, 0.3, if creased { 0.17 } else { 0.05 });
        let (mean, max) = if creased { (0.02, 0.17) } else { (0.003, 0.015) };
        assert!(errors.mean < mean && errors.max < max, "{name}: mean {}, max {}", errors.mean, errors.max);
        assert_eq!(errors.wrong_signs, 0, "{name}");
    }
}

#[test]
fn finer_cells_round_creases_less() {
    let cuboid = Cuboid(DVec3::new(0.913, 0.7, 0.5));
    let object = build(&cuboid, 1.2, VOXEL / 2.0);
    let errors = near_errors(&object, &cuboid, VOXEL, 0.3, 0.1);
    assert!(errors.mean < 0.007 && errors.max < 0.1, "mean {}, max {}", errors.mean, errors.max);
    assert_eq!(errors.wrong_signs, 0);
}

/// Errors are over the distance, or a voxel where that is more. The medial axis is rounded by up to 0.3 of cells an eighth of
/// it.
#[test]
fn far_from_the_surface_distances_hold() {
    for (name, oracle) in oracles() {
        let object = build(&*oracle, 1.5, VOXEL);
        let mut random = Random(3);
        let (mut sum, mut max) = (0.0, 0.0_f64);
        let count = 50_000;
        for _ in 0..count {
            let p = random.point(object.root_box().size().x / 2.0);
            let (truth, value) = (exact(&*oracle, p).distance, object.reference(p));
            let error = (value - truth).abs() / truth.abs().max(VOXEL);
            sum += error;
            max = max.max(error);
            assert!(truth.abs() < 0.2 * VOXEL || truth * value > 0.0, "{name}: sign at {p}");
        }
        let mean = sum / f64::from(count);
        assert!(mean < 1e-3 && max < 0.05, "{name}: mean {mean}, max {max}");
        let report = object.report();
        assert!(report.error_relative < 0.1 && report.error_at_surface < 0.01 * VOXEL, "{name}: {report:?}");
    }
}

/// Points of a block of voxels around a position.
fn block_at(position: DVec3, voxel: f64) -> Points {
    let lattice = crate::grid::Lattice { voxel_size: crate::grid::VoxelSize::new(voxel).expect("positive") };
    Points::of_block(crate::grid::block_origin(lattice.nearest(position)), &lattice)
}

#[test]
fn batches_agree_with_the_reference() {
    for (name, oracle) in oracles() {
        let object = build(&*oracle, 1.5, VOXEL);
        let (mut random, mut evaluator) = (Random(9), object.evaluator());
        let half = object.root_box().size().x / 2.0;
        let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
        let (mut single, mut one) = ([0.0; BATCH], Gradients::new());
        for i in 0..100 {
            let points =
                block_at(random.point(if i % 2 == 0 { 1.1 } else { 1.2 * half }), VOXEL * f64::from(1 + i % 3));
            evaluator.values(&points, &mut values);
            evaluator.gradients(&points, &mut gradients);
            for k in 0..points.len {
                let (value, gradient) = object.value_and_gradient(points.position(k));
                let error = (f64::from(values[k]) - value).abs();
                assert!(error < 2e-6 * value.abs().max(VOXEL), "{name}: {} for {value}", values[k]);
                assert!((gradients.gradient(k).as_dvec3() - gradient).length() < 2e-5, "{name}: {gradient}");
            }
            // A point alone goes another way than its block, to the same bits.
            for k in (0..points.len).step_by(5) {
                let mut alone = Points::new(points.origin);
                alone.push(points.offset(k));
                evaluator.values(&alone, &mut single);
                evaluator.gradients(&alone, &mut one);
                assert_eq!(single[0].to_bits(), values[k].to_bits(), "{name}");
                assert_eq!(one.value[0].to_bits(), gradients.value[k].to_bits(), "{name}");
                assert_eq!(one.gradient(0), gradients.gradient(k), "{name}");
            }
            // So does a block in a region, the innermost or not.
            let around = points.bounding_box().expect("points");
            evaluator.enter(&around.grown(0.3));
            for _ in 0..2 {
                evaluator.gradients(&points, &mut one);
                assert_eq!(one.value.map(f32::to_bits), gradients.value.map(f32::to_bits), "{name}");
                assert_eq!((one.dx, one.dy, one.dz), (gradients.dx, gradients.dy, gradients.dz), "{name}");
                evaluator.enter(&around);
            }
            (0..3).for_each(|_| evaluator.leave());
        }
    }
}

/// Regions smaller than a cell and larger, on the borders of nodes too, and points that are not quite in them.
#[test]
fn a_region_entered_changes_no_bits() {
    for (name, oracle) in oracles() {
        let object = build(&*oracle, 1.5, VOXEL);
        let (mut plain, mut inside) = (object.evaluator(), object.evaluator());
        let mut random = Random(21);
        let (mut expected, mut found) = (Gradients::new(), Gradients::new());
        for i in 0..600 {
            let mut centre = random.point(1.2);
            let size = VOXEL * [0.3, 1.0, 2.0, 4.0, 8.0, 16.0][i % 6];
            if i % 2 == 0 {
                // Corners of the region are corners of cells.
                centre = object.origin + ((centre - object.origin) / size).round() * size;
            }
            let region = Aabb::new(centre - size, centre + size);
            let mut points = Points::new(centre);
            (0..BATCH).for_each(|_| points.push((random.point(1.1) * size).as_vec3()));
            plain.gradients(&points, &mut expected);
            inside.enter(&region.grown(size));
            inside.enter(&region);
            inside.gradients(&points, &mut found);
            inside.leave();
            inside.leave();
            assert_eq!(found.value.map(f32::to_bits), expected.value.map(f32::to_bits), "{name} in {region:?}");
            assert_eq!((found.dx, found.dy, found.dz), (expected.dx, expected.dy, expected.dz), "{name} in {region:?}");
        }
    }
}

#[test]
fn bounds_hold_and_are_tight() {
    for (name, oracle) in oracles() {
        let object = build(&*oracle, 1.5, VOXEL);
        let mut random = Random(13);
        let half = object.root_box().size().x / 2.0;
        let mut evaluator = object.evaluator();
        let mut width = 0.0;
        for i in 0..400 {
            let centre = random.point(if i % 4 == 0 { 2.0 * half } else { 1.2 });
            let size = DVec3::splat(VOXEL) * [0.5, 8.0, 30.0, 200.0][i % 4] * (0.5 + random.unit());
            let region = Aabb::new(centre - size, centre + size);
            let bounded = object.bounds(&region);
            evaluator.enter(&region);
            let value = evaluator.bounds();
            assert_eq!((value, evaluator.hints(Hint::Steepest).steepest), (bounded.value, Some(bounded.steepest)));
            let mut met = Interval::new(f64::INFINITY, f64::NEG_INFINITY);
            let (mut points, mut out) = (Points::new(centre), Gradients::new());
            for _ in 0..BATCH {
                points.push((random.point(0.999) * size).as_vec3());
            }
            evaluator.gradients(&points, &mut out);
            for k in 0..BATCH {
                let f = f64::from(out.value[k]);
                assert!(value.contains(f), "{name}: {f} out of {value:?} in {region:?}");
                for axis in 0..3 {
                    let slope = f64::from(out.gradient(k)[axis]);
                    assert!(bounded.gradient[axis].contains(slope), "{name}: {slope} {:?}", bounded.gradient[axis]);
                }
                let slope = f64::from(out.gradient(k).length());
                assert!(slope <= bounded.steepest, "{name}: {slope} above {}", bounded.steepest);
                met = Interval::new(met.lo.min(f), met.hi.max(f));
            }
            if i % 4 == 1 {
                let wide = (value.hi - value.lo) / (met.hi - met.lo);
                assert!(wide < 3.0, "{name}: bounds {wide} times as wide as what was met in {region:?}");
                width += wide / 100.0;
            }
            evaluator.leave();
        }
        assert!(width < 1.5, "{name}: bounds of blocks are {width} times as wide as what was met");
    }
}

#[test]
fn same_bits_on_any_number_of_threads() {
    let torus = Torus(0.7, 0.25);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of a few threads");
        pool.install(|| build(&torus, 1.2, VOXEL))
    };
    let (one, two) = (on(1), on(2));
    assert_eq!(one.nodes, two.nodes);
    assert_eq!(one.leaves, two.leaves);
    assert_eq!(one.slope.to_bits(), two.slope.to_bits());
    let bits = |object: &DistanceObject| -> Vec<u32> {
        object.numbers.iter().flatten().map(|number| number.to_bits()).collect()
    };
    assert_eq!(bits(&one), bits(&two));
}

#[test]
fn what_cannot_be_built_says_why() {
    let sphere = Sphere(DVec3::ZERO, 0.5);
    let go = |oracle: &dyn ClosestPoint, settings: Settings, cancel: bool| {
        let (cancel, progress) = (AtomicBool::new(cancel), |_: f64| {});
        DistanceObject::build(oracle, &settings, &Watch { cancel: &cancel, progress: &progress }).err()
    };
    let region = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
    let good = Settings::new(region, 0.02);
    assert_eq!(go(&sphere, good, true), Some(BuildError::Cancelled));
    assert!(matches!(
        go(&sphere, Settings { memory_limit: 10_000, ..good }, false),
        Some(BuildError::Memory { limit: 10_000, .. })
    ));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(go(&sphere, Settings::new(region, bad), false), Some(BuildError::Settings));
    }
    let nowhere = Aabb::new(DVec3::splat(f64::NAN), DVec3::ONE);
    assert_eq!(go(&sphere, Settings::new(nowhere, 0.1), false), Some(BuildError::Settings));
    let Some(BuildError::TooFine { smallest_cell }) = go(&sphere, Settings::new(region, 1e-9), false) else {
        panic!("cells too fine to count")
    };
    assert!(root(&Settings::new(region, smallest_cell)).is_ok());
    let broken = Function(|p: DVec3| (if p.x > 0.3 { f64::NAN } else { p.x }, DVec3::X));
    assert!(matches!(go(&broken, good, false), Some(BuildError::NotFinite { .. })));
    let nothing = Sphere(DVec3::ZERO, -0.5);
    assert_eq!(go(&nothing, good, false), Some(BuildError::NoSurface));
}

/// Kept as bytes and read back, an object answers with the same bits; bytes that are none of it are no object.
#[test]
fn bytes_give_the_object_back() {
    let object = build(&Torus(0.6, 0.25), 1.0, 0.05);
    let bytes = object.to_bytes();
    let again = DistanceObject::from_bytes(&bytes).expect("its own bytes");
    assert_eq!(again.report(), object.report());
    assert_eq!(again.bounding_box(), object.bounding_box());
    let answers = |object: &DistanceObject| {
        let mut points = Points::new(DVec3::new(0.1, 0.2, 0.0));
        for i in 0..BATCH {
            points.push(DVec3::from([1, 8, 64].map(|step| (i / step % 8) as f64 * 0.4 - 1.5)).as_vec3());
        }
        let mut found = Gradients::default();
        let mut evaluator = object.evaluator();
        evaluator.enter(&Aabb::new(DVec3::splat(-0.3), DVec3::splat(0.9)));
        let bounds = evaluator.bounds();
        evaluator.leave();
        evaluator.gradients(&points, &mut found);
        let numbers = |i: usize| [found.value[i], found.dx[i], found.dy[i], found.dz[i]].map(f32::to_bits);
        ((0..BATCH).map(numbers).collect::<Vec<_>>(), bounds)
    };
    assert_eq!(answers(&again), answers(&object));
    // Whatever is changed or cut off, it is an object or none, and never a panic.
    for place in (0..bytes.len()).step_by(bytes.len() / 200) {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x41;
        let _ = DistanceObject::from_bytes(&damaged);
        assert!(DistanceObject::from_bytes(&bytes[..place]).is_none());
    }
}
