//! What must hold of every expression.

use glam::DVec3;
use proptest::prelude::*;

use super::recipe::{Recipe, recipe};
use super::{Samples, bits_by_width, slope_at};
use crate::field::{Aabb, BATCH, Expression, Field, Gradients, Graph, Slope};

fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

fn expression(recipe: &Recipe) -> Expression {
    let mut graph = Graph::new();
    let node = recipe.build(&mut graph);
    Expression::new(&graph, node)
}

/// A zero of the reference on a segment whose ends have different signs.
fn zero_between(field: &Expression, mut inside: DVec3, mut outside: DVec3) -> Option<DVec3> {
    if field.reference(inside) < 0.0 || field.reference(outside) >= 0.0 {
        return None;
    }
    for _ in 0..60 {
        let middle = (inside + outside) * 0.5;
        if field.reference(middle) >= 0.0 { inside = middle } else { outside = middle }
    }
    Some(inside)
}

/// Steps of differences.
const STEPS: [f64; 2] = [1e-6, 1e-4];
const WORLD: Aabb = Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0));

/// A random box of a random size in the world.
fn some_region(samples: &mut Samples) -> Aabb {
    let size = 4.0 * 0.5f64.powf(1.0 + 6.0 * samples.next());
    let min = samples.within(&Aabb::new(WORLD.min, WORLD.max - size));
    Aabb::new(min, min + size)
}

/// A box inside a box, half its size.
fn some_part(samples: &mut Samples, region: &Aabb) -> Aabb {
    let half = region.size() * 0.5;
    let min = samples.within(&Aabb::new(region.min, region.min + half));
    Aabb::new(min, min + half)
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn the_reference_is_the_textbook(recipe in recipe().prop_filter("insets", |r| !r.has_inset()), seed: u64) {
        let (field, mut samples) = (expression(&recipe), Samples::new(seed));
        for _ in 0..100 {
            let p = samples.within(&WORLD);
            let (ours, wanted) = (field.reference(p), recipe.value(p));
            prop_assert!((ours - wanted).abs() < 1e-9 * (1.0 + wanted.abs()), "{ours} != {wanted} at {p}");
        }
    }

    #[test]
    fn batches_are_the_reference(recipe in recipe(), seed: u64) {
        let (field, mut samples) = (expression(&recipe), Samples::new(seed));
        let mut evaluator = field.evaluator();
        let points = samples.batch(&WORLD, 300);
        let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
        evaluator.values(&points, &mut values);
        evaluator.gradients(&points, &mut gradients);
        for i in 0..points.len {
            let p = points.position(i);
            let wanted = field.reference(p);
            prop_assert!((f64::from(values[i]) - wanted).abs() < 2e-5 * (1.0 + wanted.abs()), "{} != {wanted} at {p}", values[i]);
            prop_assert!((values[i] - gradients.value[i]).abs() <= 1e-5 * (1.0 + values[i].abs()));
            // Beside a power, which is large far away, R₀'s weights of what is small are rounded off.
            if let Some(slope) = slope_at(&field, p, STEPS).filter(|_| !recipe.has_power()) {
                let ours = gradients.gradient(i).as_dvec3();
                // Beside a crease of the reference a rounded position may lie on its other side.
                let near = slope_at(&field, p + DVec3::splat(1e-5), STEPS).is_some() && slope_at(&field, p - DVec3::splat(1e-5), STEPS).is_some();
                prop_assert!(!near || (ours - slope).length() < 3e-3 * (1.0 + slope.length()), "{ours} != {slope} at {p}");
            }
        }
    }

    #[test]
    fn bounds_hold_and_pruning_keeps_signs(recipe in recipe(), seed: u64) {
        let (field, mut samples) = (expression(&recipe), Samples::new(seed));
        let exact = field.clone().keeping_values();
        let (mut whole, mut pruned, mut kept) = (field.evaluator(), field.evaluator(), exact.evaluator());
        let (mut all, mut some, mut same) = ([0.0; BATCH], [0.0; BATCH], [0.0; BATCH]);
        for _ in 0..6 {
            let outer = some_region(&mut samples);
            let inner = some_part(&mut samples, &outer);
            pruned.enter(&outer);
            kept.enter(&outer);
            let wide = [pruned.bounds(), kept.bounds()];
            pruned.enter(&inner);
            kept.enter(&inner);
            let tight = [pruned.bounds(), kept.bounds()];
            let points = samples.batch(&inner, 200);
            whole.values(&points, &mut all);
            pruned.values(&points, &mut some);
            kept.values(&points, &mut same);
            for i in 0..points.len {
                let (p, value) = (points.position(i), field.reference(points.position(i)));
                if WORLD.contains(p) && inner.contains(p) {
                    prop_assert!(wide[1].contains(value) && tight[1].contains(value), "{value} not in {wide:?} {tight:?}");
                    // Bounds of a pruned program are right in sign.
                    for bound in [wide[0], tight[0]] {
                        prop_assert!((bound.lo <= 0.0 || value > 0.0) && (bound.hi >= 0.0 || value < 0.0));
                    }
                    if value.abs() > 1e-5 {
                        prop_assert_eq!(some[i] > 0.0, value > 0.0, "sign at {} where F = {}", p, value);
                    }
                }
                prop_assert_eq!(same[i], all[i]);
            }
            for _ in 0..2 {
                pruned.leave();
                kept.leave();
            }
        }
    }

    #[test]
    fn pruned_values_and_gradients_hold_on_the_surface(recipe in recipe(), seed: u64) {
        let (field, mut samples) = (expression(&recipe), Samples::new(seed));
        let mut pruned = field.evaluator();
        for _ in 0..40 {
            let Some(p) = zero_between(&field, samples.within(&WORLD), samples.within(&WORLD)) else { continue };
            let Some(slope) = slope_at(&field, p, STEPS) else { continue };
            pruned.enter(&Aabb::new(p, p).grown(0.05));
            let mut points = crate::field::Points::new(p);
            points.push(glam::Vec3::ZERO);
            let mut out = Gradients::new();
            pruned.gradients(&points, &mut out);
            pruned.leave();
            prop_assert!(out.value[0].abs() < 1e-5, "{} at {p}", out.value[0]);
            let found = out.gradient(0).as_dvec3();
            if !recipe.has_power() {
                prop_assert!((found - slope).length() < 3e-3 * (1.0 + slope.length()));
            } else if slope.length() > 0.1 {
                // Of R_m its direction is kept.
                prop_assert!((found.normalize() - slope.normalize()).length() < 1e-2, "{found}, {slope} at {p}");
            }
        }
    }

    #[test]
    fn some_branch_is_zero_where_the_field_is(recipe in recipe(), seed: u64) {
        let (field, mut samples) = (expression(&recipe), Samples::new(seed));
        let mut evaluator = field.evaluator();
        let mut out = Gradients::new();
        for _ in 0..20 {
            let Some(p) = zero_between(&field, samples.within(&WORLD), samples.within(&WORLD)) else { continue };
            evaluator.enter(&Aabb::new(p, p).grown(0.3 * samples.next()));
            let mut points = crate::field::Points::new(p);
            points.push(glam::Vec3::ZERO);
            let count = evaluator.branches();
            prop_assert!(count >= 1);
            let least = (0..count).map(|branch| {
                evaluator.branch(branch, &points, &mut out);
                out.value[0].abs()
            }).fold(f32::INFINITY, f32::min);
            evaluator.leave();
            prop_assert!(least < 2e-5, "least of {count} branches is {least} at {p}");
        }
    }

    #[test]
    fn declared_slopes_and_boxes_hold(recipe in recipe(), seed: u64) {
        let (field, mut samples) = (expression(&recipe), Samples::new(seed));
        for _ in 0..100 {
            let (p, q) = (samples.within(&WORLD), samples.within(&WORLD));
            let q = p + (q - p) * samples.next().powi(4);
            let (first, second) = (field.reference(p), field.reference(q));
            let bound = match field.slope() {
                Slope::Exact { .. } => 1.0,
                Slope::Lipschitz(bound) => bound,
                Slope::Unknown => f64::INFINITY,
            };
            if bound.is_finite() {
                prop_assert!((first - second).abs() <= bound * (p - q).length() * (1.0 + 1e-9) + 1e-12);
            }
            if let Some(bounds) = field.bounding_box() {
                prop_assert!(first < 0.0 || bounds.contains(p), "{p} is inside, {bounds:?}");
            }
            if let (Slope::Exact { outside, inside }, Some(slope)) = (field.slope(), slope_at(&field, p, STEPS))
                && if first < 0.0 { outside } else { inside }
            {
                let foot = p - slope * first;
                prop_assert!(field.reference(foot).abs() < 1e-3 * first.abs() + 1e-6, "{p} is not {first} from the surface");
            }
        }
    }

    #[test]
    fn vector_widths_give_the_same_bits(recipe in recipe(), seed: u64) {
        let (field, mut samples) = (expression(&recipe), Samples::new(seed));
        let points = samples.batch(&WORLD, 130);
        let answers = bits_by_width(&field, &points);
        prop_assert_eq!(&answers[0], &answers[1]);
        prop_assert_eq!(&answers[0], &answers[2]);
    }
}
