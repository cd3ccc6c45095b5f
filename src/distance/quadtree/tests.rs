//! The quadtree against exact distances, and against what a bicubic spline keeps.

use std::sync::atomic::AtomicBool;

use super::*;
use crate::distance::outline::OutlineFeet;
use crate::field::{Expression, Graph, SetSystem};

fn region(reach: f64) -> Aabb {
    Aabb::new(DVec3::splat(-reach), DVec3::splat(reach))
}

fn built(oracle: &dyn ClosestPoint, settings: &Settings) -> Quadtree {
    let cancel = AtomicBool::new(false);
    Quadtree::build(oracle, settings.region, settings, &Watch { cancel: &cancel, progress: &|_| {} }).expect("a tree")
}

/// A foot by value and gradient.
struct By(fn(DVec2) -> (f64, DVec2));

impl ClosestPoint for By {
    fn feet(&self, positions: &[DVec3], feet: &mut [Foot]) {
        for (at, foot) in positions.iter().zip(feet) {
            assert_eq!(at.z, 0.0);
            let (distance, gradient) = (self.0)(at.truncate());
            let gradient = gradient.extend(0.0);
            *foot = Foot { point: *at - gradient * distance, distance, gradient, part: 0 };
        }
    }
}

/// A rectangle of 2 by 1: creases inside, and rounded outside of its corners.
fn rectangle(p: DVec2) -> (f64, DVec2) {
    let (q, signs) = (p.abs() - DVec2::new(1.0, 0.5), DVec2::new(1.0_f64.copysign(p.x), 1.0_f64.copysign(p.y)));
    let out = q.max(DVec2::ZERO);
    match (out != DVec2::ZERO, q.x > q.y) {
        (true, _) => (-out.length(), -out.normalize() * signs),
        (false, true) => (-q.x, DVec2::new(-signs.x, 0.0)),
        (false, false) => (-q.y, DVec2::new(0.0, -signs.y)),
    }
}

/// 0.3 − x³y²/4 + x²y³/5 + xy with its gradient: a bicubic.
fn bicubic(p: DVec2) -> (f64, DVec2) {
    let (x, y) = (p.x, p.y);
    let value = 0.3 - x.powi(3) * y * y / 4.0 + x * x * y.powi(3) / 5.0 + x * y;
    let by_x = -0.75 * x * x * y * y + 0.4 * x * y.powi(3) + y;
    (value, DVec2::new(by_x, -x.powi(3) * y / 2.0 + 0.6 * x * x * y * y + x))
}

/// Where edges of a tree's leaves are crossed: both sides, a rounding error apart.
fn across_edges(tree: &Quadtree) -> Vec<[DVec2; 2]> {
    let mut found = Vec::new();
    for (cell, _) in &tree.leaves {
        for share in [0.0, 0.13, 0.25, 0.5, 0.71, 1.0] {
            for axis in 0..2 {
                let along = f64::from(cell.size) * share;
                let mut at = DVec2::new(f64::from(cell.origin[0]), f64::from(cell.origin[1]));
                at[1 - axis] += along;
                let at = tree.origin + at * tree.step;
                let aside = DVec2::AXES[axis] * 1e-10;
                found.push([at - aside, at + aside]);
            }
        }
    }
    found
}

/// The greatest jumps of value and gradient.
fn jumps(tree: &Quadtree) -> (f64, f64) {
    let jump = |[a, b]: [DVec2; 2]| {
        let ((value, gradient), (other, turned)) = (tree.value_and_gradient(a), tree.value_and_gradient(b));
        ((value - other).abs(), gradient.distance(turned))
    };
    across_edges(tree).into_iter().map(jump).fold((0.0, 0.0), |a, b| (a.0.max(b.0), a.1.max(b.1)))
}

#[test]
fn it_is_smooth_across_cells_of_any_size_and_jumps_where_it_is_linear() {
    let settings = Settings::new(region(1.0), 1.0 / 64.0);
    let spline = built(&By(rectangle), &settings);
    let sizes: std::collections::BTreeSet<u32> = spline.leaves.iter().map(|(cell, _)| cell.size).collect();
    assert!(sizes.len() >= 4 && spline.report().hanging > 50, "{sizes:?} {:?}", spline.report());
    let (value, slope) = jumps(&spline);
    assert!(value < 1e-6 && slope < 1e-6, "{value} {slope}");
    let linear = built(&By(rectangle), &Settings { restore: Restore::Linear, ..settings });
    assert_eq!(linear.leaves.len(), spline.leaves.len());
    let (value, slope) = jumps(&linear);
    assert!(value > 1e-3 && slope > 0.1, "{value} {slope}");
    assert!(linear.jumps() && !spline.jumps());
}

/// Exact on every bicubic, with the mixed derivatives given: across hanging corners too, of cells that differ by many halvings.
#[test]
fn bicubics_are_kept() {
    let settings = Settings { tolerance: 1.0, tolerance_across: 1.0, ..Settings::new(region(0.25), 1.0 / 64.0) };
    let mut tree = built(&By(bicubic), &settings);
    let cells: Vec<Cell> = tree.leaves.iter().map(|(cell, _)| *cell).collect();
    let (mut numbers, mut jets) = (HashMap::new(), Vec::new());
    for place in cells.iter().flat_map(Cell::corners) {
        numbers.entry(place).or_insert_with(|| {
            let p = tree.origin + DVec2::new(f64::from(place[0]), f64::from(place[1])) * tree.step;
            let (value, slope) = bicubic(p);
            jets.push([value, slope.y, slope.x, -1.5 * p.x * p.x * p.y + 1.2 * p.x * p.y * p.y + 1.0]);
            jets.len() as u32 - 1
        });
    }
    tree.restore(&cells, Jets { jets, numbers });
    assert!(tree.report().hanging > 0);
    for i in 0..1000 {
        let p = DVec2::new(f64::from(i % 37) / 37.0 - 0.5, f64::from(i % 101) / 101.0 - 0.5) * 0.99 * tree.edge();
        let p = p.clamp(tree.origin, tree.origin + tree.edge());
        let ((value, slope), (truth, turned)) = (tree.value_and_gradient(p), bicubic(p));
        assert!((value - truth).abs() < 1e-11 && slope.distance(turned) < 1e-10, "{p}: {value} for {truth}");
    }
}

/// Values, gradients and bounds agree, in the root and beyond it.
#[test]
fn bounds_hold_and_gradients_are_those_of_values() {
    let tree = built(&By(rectangle), &Settings::new(region(1.0), 1.0 / 32.0));
    let mut evaluator = tree.evaluator();
    for i in 0..400 {
        let at = DVec3::new(f64::from(i % 20) - 9.7, f64::from(i / 20) - 9.9, 0.3) * 0.6;
        let region = Aabb::new(at, at + 0.05 * (1.0 + f64::from(i % 7)));
        let mut points = Points::new(region.centre());
        for step in 0..64 {
            let share = DVec3::new(f64::from(step % 8), f64::from(step / 8), 0.0) / 7.0;
            points.push((region.min + region.size() * share - region.centre()).as_vec3());
        }
        evaluator.enter(&region);
        let bounds = evaluator.bounds();
        let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
        evaluator.values(&points, &mut values);
        evaluator.gradients(&points, &mut gradients);
        evaluator.leave();
        for (step, value) in values.iter().enumerate().take(64) {
            assert!(bounds.contains(f64::from(*value)), "{value} of {bounds:?}");
            assert_eq!(*value, gradients.value[step]);
            let (p, h) = (points.position(step), 1e-6);
            let slope = |axis: usize| {
                let by = DVec3::AXES[axis] * h;
                (tree.reference(p + by) - tree.reference(p - by)) / (2.0 * h)
            };
            let found = DVec2::new(slope(0), slope(1));
            assert!(found.distance(gradients.gradient(step).as_dvec3().truncate()) < 1e-3, "{found} at {p}");
        }
        // Beyond the root it is continued, and only about as far.
        let (value, truth) = (tree.reference(at), rectangle(at.truncate()).0);
        let is_in_root = at.truncate().abs().max_element() < 0.5 * tree.edge();
        let share = if is_in_root { 0.02 } else { 0.1 };
        assert!((value - truth).abs() < share * truth.abs().max(0.5), "{at}: {value} for {truth}");
    }
}

/// Two discs as r² − |p|² under R₀: closest points by a field that is not a distance and does not know z, as a scene asks for
/// them.
#[test]
fn fields_of_the_plane_are_measured_by_their_zero_set() {
    let mut graph = Graph::new();
    let discs = [-0.4, 0.4].map(|at| {
        let (x, y) = (graph.affine(DVec3::X, -at), graph.y());
        let (x, y) = (graph.square(x), graph.square(y));
        let sum = graph.add(x, y);
        graph.linear(sum, -1.0, 0.25)
    });
    let node = graph.union(SetSystem::R0, &discs);
    let field = Expression::new(&graph, node);
    let cancel = AtomicBool::new(false);
    let watch = Watch { cancel: &cancel, progress: &|_| {} };
    let [min, max] = [-1.0, 1.0].map(|at| DVec3::new(at, at, 0.0));
    let feet = OutlineFeet::new(&field, &Aabb::new(min, max), 1.0 / 64.0, &watch).expect("an outline");
    let tree = built(&feet, &Settings::new(Aabb::new(min, max), 1.0 / 128.0));
    let mut worst = 0.0_f64;
    for i in 0..1600 {
        let p = DVec2::new(f64::from(i % 40) - 19.5, f64::from(i / 40) - 19.5) / 20.0;
        let disc = |at: f64| 0.5 - p.distance(DVec2::new(at, 0.0));
        // The nearest of both arcs and of the corners between them; inside, what is beyond the other disc is no outline.
        let corner = p.abs().distance(DVec2::new(0.0, 0.3));
        let side = 0.4_f64.copysign(p.x);
        let foot = (p - DVec2::X * side).normalize() * 0.5 + DVec2::X * side;
        let is_outline = foot.x * side >= 0.0;
        let truth = if disc(side) >= 0.0 && !is_outline { corner } else { disc(side) };
        worst = worst.max((tree.reference(p.extend(0.7)) - truth).abs() / truth.abs().max(1.0 / 128.0));
    }
    assert!(worst < 0.1, "{worst}");
}

#[test]
fn it_is_refused_like_an_octree() {
    let cancel = AtomicBool::new(false);
    let watch = Watch { cancel: &cancel, progress: &|_| {} };
    let settings = Settings::new(region(1.0), 1.0 / 64.0);
    let short = Settings { memory_limit: 1000, ..settings };
    assert!(matches!(
        Quadtree::build(&By(rectangle), settings.region, &short, &watch),
        Err(BuildError::Memory { limit: 1000, .. })
    ));
    let none = By(|_| (1.0, DVec2::X));
    assert_eq!(Quadtree::build(&none, settings.region, &settings, &watch).err(), Some(BuildError::NoSurface));
    cancel.store(true, std::sync::atomic::Ordering::Relaxed);
    assert_eq!(Quadtree::build(&By(rectangle), settings.region, &settings, &watch).err(), Some(BuildError::Cancelled));
}
