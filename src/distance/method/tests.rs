//! Every method on what is no distance.

use std::sync::atomic::AtomicBool;

use glam::{DVec3, IVec3};

use super::blocks::Blocks;
use super::*;
use crate::distance::accuracy::{compare, exact};
use crate::distance::band;
use crate::distance::testing::{Joined, Leaf};
use crate::field::{BATCH, Gradients, Points, Strut, Struts};
use crate::grid::{Lattice, VoxelSize};

/// Each method measures what is no distance itself.
#[test]
fn every_method_measures_a_ring() {
    let field: Arc<dyn Field> = Arc::new(Joined::one(Leaf::Torus(0.7, 0.25)));
    let (voxel, solid) = (0.03, Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)));
    let request = Request { field: &field, solid, detail: voxel, settings: Settings::new(solid, voxel) };
    for (row, method) in METHODS.into_iter().enumerate() {
        let name = method.name();
        assert!(METHODS[..row].iter().all(|other| other.name() != name), "{name} stands twice");
        assert_eq!(NAMES[row], name);
        let found = named(name);
        let cancel = AtomicBool::new(false);
        let watch = Watch { cancel: &cancel, progress: &|_| {} };
        let Measured { distance, bytes, .. } = found.measure(&request, &watch).expect("a ring");
        assert!(bytes > 0);
        for place in 0..200 {
            let p = DVec3::from([1, 6, 36].map(|step| f64::from(place / step % 6) * 0.37 - 0.95));
            let (value, truth) = (distance.reference(p), exact::torus(p, 0.7, 0.25));
            assert!((value - truth).abs() < 0.2 * truth.abs().max(voxel), "{name} at {p}: {value} for {truth}");
        }
        cancel.store(true, std::sync::atomic::Ordering::Relaxed);
        assert_eq!(found.measure(&request, &watch).err(), Some(BuildError::Cancelled), "{name} goes on");
    }
}

/// A rough distance is right to a cell or two of its lattice, and has the sign of F.
#[test]
fn a_rough_distance_is_about_right() {
    let field: Arc<dyn Field> = Arc::new(Joined::one(Leaf::Torus(0.7, 0.25)));
    let solid = Aabb::new(DVec3::new(-0.95, -0.95, -0.25), DVec3::new(0.95, 0.95, 0.25));
    let request = Request { field: &field, solid, detail: 0.01, settings: Settings::new(solid, 0.01) };
    let cancel = AtomicBool::new(false);
    let rough = Rough.measure(&request, &Watch { cancel: &cancel, progress: &|_| {} }).expect("a ring").distance;
    let cell = 1.9 / rough::CELLS;
    for place in 0..1000 {
        let p = DVec3::from([1, 10, 100].map(|step| f64::from(place / step % 10) * 0.23 - 1.05));
        let (value, truth) = (rough.reference(p), exact::torus(p, 0.7, 0.25));
        assert!((value - truth).abs() < 1.5 * cell, "{p}: {value} for {truth}");
        assert!(truth.abs() < cell || (value < 0.0) == (truth < 0.0), "{p}: {value} for {truth}");
    }
}

/// Of a rod that slips through the lattice everywhere there is a distance too.
#[test]
fn what_is_thin_everywhere_has_a_rough_distance() {
    for radius in [0.02, 0.001] {
        let (from, to) = (DVec3::new(-1.0, -0.01, 0.02), DVec3::new(1.0, 0.03, -0.04));
        let field = crate::field::Joined::shared(Struts::new(vec![Strut::new(from, to, [radius; 2])]));
        let solid = field.bounding_box().expect("it ends");
        let request = Request { field: &field, solid, detail: 0.5 * radius, settings: Settings::new(solid, radius) };
        let watch = Watch { cancel: &AtomicBool::new(false), progress: &|_| {} };
        let rough = Rough.measure(&request, &watch).expect("a rod").distance;
        let found = rough.bounding_box().expect("a box");
        assert!(found.size().is_finite() && found.size().x > 1.8, "{radius}: {found:?}");
        for x in [-0.9, 0.0, 0.7] {
            let p = DVec3::new(x, 0.5, -0.3);
            let (value, truth) = (rough.reference(p), field.reference(p));
            assert!((value - truth).abs() < 1.5 * 2.0 / rough::CELLS, "{radius} {p}: {value} for {truth}");
        }
    }
}

/// The band of a field, by a method, on so many threads.
fn band_of(field: &dyn Field, solid: Aabb, voxel: f64, method: &dyn Method, threads: usize) -> Band {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    pool.install(|| {
        let cancel = AtomicBool::new(false);
        let lattice = Lattice { voxel_size: VoxelSize::new(voxel).expect("a size") };
        let region = solid.grown(4.0 * voxel);
        let settings = band::Settings {
            lattice,
            half_width: 3.0,
            region,
            feet: band::Feet::Nearest,
            cancel: &cancel,
            progress: &|_| {},
        };
        let mut band = band::measure(field, &settings, || |_: &band::MeasuredBlock| ()).expect("a surface").band;
        let watch = Watch { cancel: &cancel, progress: &|_| {} };
        let as_chosen = AsChosen { choice: Choice::by(method.name()), memory_limit: usize::MAX };
        method.measure_band(field, &mut band, as_chosen, &watch).expect("a band");
        band
    })
}

/// A torus with a tube of ten voxels: bars of smooth shapes.
#[test]
fn bands_are_right_to_a_part_of_a_voxel() {
    let (field, voxel) = (Joined::one(Leaf::Torus(0.7, 0.25)), 0.025);
    for (name, mean, max) in
        [("closest-point", 0.005, 0.05), ("vector-dt", 0.1, 0.2), ("fim", 0.05, 0.15), ("adf", 0.01, 0.1)]
    {
        let band = band_of(&field, field.bounds, voxel, named(name), 2);
        let found = compare(&band, |p| exact::torus(p, 0.7, 0.25));
        assert!(found.voxels > 10_000 && found.wrong_signs == 0, "{name}: {found:?}");
        assert!(found.mean <= mean && found.max <= max, "{name}: {found:?}");
    }
}

/// An error in voxels that goes down with the voxels is of first order or better in units.
#[test]
fn the_eikonal_equation_is_solved_to_first_order() {
    let field = Joined::one(Leaf::Sphere(DVec3::splat(0.013), 1.0));
    let error = |voxel: f64| {
        let band = band_of(&field, field.bounds, voxel, named("fim"), 2);
        compare(&band, |p| exact::sphere(p, DVec3::splat(0.013), 1.0)).mean * voxel
    };
    let (coarse, fine) = (error(0.1), error(0.05));
    assert!(libm::log2(coarse / fine) > 0.9, "{coarse} {fine}");
}

/// Where two balls meet there is a crease, and voxels on it have two sides to take their points from.
#[test]
fn threads_change_no_bit_and_voxels_keep_their_sides() {
    let field = Joined::union(vec![Leaf::Sphere(DVec3::X * 0.3, 0.6), Leaf::Sphere(DVec3::X * -0.3, 0.55)]);
    for method in METHODS {
        let [one, two] = [1, 2].map(|threads| band_of(&field, field.bounds, 0.04, method, threads));
        let bits = |band: &Band| -> Vec<u32> { band.distances.iter().flatten().map(|value| value.to_bits()).collect() };
        assert!(bits(&one) == bits(&two), "{}", method.name());
        let usual = band_of(&field, field.bounds, 0.04, METHODS[0], 2);
        assert!(one.active == usual.active && one.inside_tiles == usual.inside_tiles);
        for (found, known) in one.distances.iter().flatten().zip(usual.distances.iter().flatten()) {
            assert_eq!(found.is_sign_negative(), known.is_sign_negative(), "{}", method.name());
            assert!(found.abs() <= one.background());
        }
    }
}

/// Objects that answer everywhere: inside exactly where F is, in values, bounds and gradients.
#[test]
fn a_restored_distance_has_the_sign_of_f() {
    let joined = Joined::union(vec![Leaf::Sphere(DVec3::X * 0.3, 0.6), Leaf::Sphere(DVec3::X * -0.3, 0.55)]);
    let solid = joined.bounds;
    let field: Arc<dyn Field> = Arc::new(joined);
    for name in ["vector-dt", "fim"] {
        let request = Request { field: &field, solid, detail: 0.06, settings: Settings::new(solid, 0.06) };
        let cancel = AtomicBool::new(false);
        let watch = Watch { cancel: &cancel, progress: &|_| {} };
        let found = named(name).measure(&request, &watch).expect("two balls");
        let again = named(name).restored(Arc::clone(&found.object), &field).distance;
        let (mut evaluator, mut signs) = (found.distance.evaluator(), field.evaluator());
        let (mut values, mut truth, mut gradients) = ([0.0; BATCH], [0.0; BATCH], Gradients::new());
        for x in -5..5 {
            // A thin slice through the surface, most of whose points are nearer to it than the nodes are.
            let mut points = Points::new(DVec3::new(0.2 * f64::from(x), 0.0, 0.0));
            for i in 0..BATCH {
                let turn = i as f32 * 0.1;
                points.push(glam::Vec3::new(0.0, turn.cos(), turn.sin()) * (i as f32 / BATCH as f32));
            }
            let region = points.bounding_box().expect("points").grown(1e-6);
            evaluator.enter(&region);
            let bounds = evaluator.bounds();
            evaluator.values(&points, &mut values);
            evaluator.gradients(&points, &mut gradients);
            evaluator.leave();
            signs.values(&points, &mut truth);
            for i in 0..BATCH {
                let at = points.position(i);
                assert_eq!(values[i] >= 0.0, truth[i] >= 0.0, "{name} at {at}");
                assert!(bounds.contains(f64::from(values[i])), "{name} at {at}: {} of {bounds:?}", values[i]);
                assert!((values[i] - gradients.value[i]).abs() < 1e-6, "{name} at {at}");
                assert!((found.distance.reference(at) - f64::from(values[i])).abs() < 1e-5, "{name} at {at}");
                assert_eq!(again.reference(at).to_bits(), found.distance.reference(at).to_bits());
            }
        }
    }
}

/// Two halves, one twice as fast: along the border the fast half sends a wave into the slow one, at the angle of total
/// reflection. From a plane of sources at x = 0 the exact times are x/2 and min(x, x/2 + |y|·√3/2).
#[test]
fn a_speed_of_two_halves_bends_the_way() {
    let error = |nodes: i32| {
        let step = 1.0 / f64::from(nodes);
        let blocks = Blocks::filling(IVec3::new(0, -nodes, 0), IVec3::new(nodes, nodes, 0));
        let seeds: Vec<(usize, f64)> =
            (0..blocks.nodes()).filter(|&node| blocks.voxel(node).x == 0).map(|node| (node, 0.0)).collect();
        let slowness = |node: usize| if blocks.voxel(node).y < 0 { 1.0 } else { 0.5 };
        let cancel = AtomicBool::new(false);
        let watch = Watch { cancel: &cancel, progress: &|_| {} };
        let times = fim::arrivals(&blocks, step, &seeds, slowness, |_, _| true, &watch).expect("times");
        let (mut sum, mut count) = (0.0, 0);
        for (node, time) in times.iter().enumerate() {
            let at = blocks.voxel(node).as_dvec3() * step;
            // Beyond the square the ends of the nodes themselves reflect nothing, so all nodes count.
            let late = at.x / 2.0 + at.y.abs() * 0.75_f64.sqrt();
            let truth = if at.y < 0.0 { at.x.min(late) } else { at.x / 2.0 };
            sum += (time - truth).abs();
            count += 1;
        }
        sum / f64::from(count)
    };
    let (coarse, fine) = (error(64), error(128));
    assert!(coarse <= 1.5 / 64.0 && libm::log2(coarse / fine) > 0.8, "{coarse} {fine}");
}

/// Nothing passes a wall, and what is behind it is reached around its end.
#[test]
fn a_wall_is_gone_around() {
    let blocks = Blocks::filling(IVec3::ZERO, IVec3::new(31, 31, 0));
    let is_wall = |voxel: IVec3| voxel.x == 16 && voxel.y < 24;
    let slowness = |node: usize| if is_wall(blocks.voxel(node)) { f64::INFINITY } else { 1.0 };
    let cancel = AtomicBool::new(false);
    let watch = Watch { cancel: &cancel, progress: &|_| {} };
    let seed = blocks.node(IVec3::ZERO).expect("a node");
    let times = fim::arrivals(&blocks, 1.0, &[(seed, 0.0)], slowness, |_, _| true, &watch).expect("times");
    let time = |x: i32, y: i32| times[blocks.node(IVec3::new(x, y, 0)).expect("a node")];
    assert_eq!(time(16, 3), f64::INFINITY);
    let around = f64::hypot(16.0, 24.0) + f64::hypot(4.0, 24.0);
    assert!((time(20, 0) - around).abs() < 0.06 * around, "{} {around}", time(20, 0));
}
