//! Every operation that only formulas reach, in every evaluator.

use glam::DVec3;
use proptest::prelude::*;

use super::Samples;
use crate::field::{Aabb, BATCH, Evaluator, Expression, Field, Formula, Gradients, Graph, Names, Points, VectorWidth};

const WORLD: Aabb = Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0));

fn field(text: &str) -> Expression {
    let mut graph = Graph::new();
    let names = Names::space(&mut graph).number("t", 0.3);
    let node = Formula::parse(text).compile(&mut graph, &names).expect(text);
    Expression::new(&graph, node)
}

type Plain = fn(DVec3) -> f64;

/// Formulas with what they say in plain Rust.
const CASES: [(&str, Plain); 24] = [
    ("sin(3*x + y) * cos(z)", |p| (3.0 * p.x + p.y).sin() * p.z.cos()),
    ("sin(x*2)*cos(y*2) + sin(y*2)*cos(z*2) + sin(z*2)*cos(x*2)", |p| {
        let (s, c) = ((p * 2.0).map(f64::sin), (p * 2.0).map(f64::cos));
        s.x * c.y + s.y * c.z + s.z * c.x
    }),
    ("exp(-x^2 - y^2) - 0.5", |p| (-p.x * p.x - p.y * p.y).exp() - 0.5),
    ("log(x^2 + 1) - z", |p| (p.x * p.x + 1.0).ln() - p.z),
    ("cbrt(x + 3) - y", |p| (p.x + 3.0).cbrt() - p.y),
    ("(x^2 + 0.1)^0.7 - y^2", |p| (p.x * p.x + 0.1).powf(0.7) - p.y * p.y),
    ("pow(x + 3, y) - 2", |p| (p.x + 3.0).powf(p.y) - 2.0),
    ("2^x - y", |p| 2f64.powf(p.x) - p.y),
    ("atan2(y + 3, x)", |p| (p.y + 3.0).atan2(p.x)),
    ("x^3 - y^4 + z^5 - x*y*z", |p| p.x.powi(3) - p.y.powi(4) + p.z.powi(5) - p.x * p.y * p.z),
    ("x^-2 * (y + z)", |p| (p.y + p.z) / (p.x * p.x)),
    ("1 / (x + 5) - y / (z + 4)", |p| 1.0 / (p.x + 5.0) - p.y / (p.z + 4.0)),
    ("tanh(4*x) - tan(y/3)", |p| (4.0 * p.x).tanh() - (p.y / 3.0).tan()),
    ("smoothstep(-1, 1, x + y) - 0.5", |p| {
        let s = ((p.x + p.y + 1.0) / 2.0).clamp(0.0, 1.0);
        s * s * (3.0 - 2.0 * s) - 0.5
    }),
    ("clamp(x, -1, t) + mix(y, z, 0.25)", |p| p.x.clamp(-1.0, 0.3) + 0.75 * p.y + 0.25 * p.z),
    ("mod(x, 0.5) - fract(y) + floor(z) + ceil(x) - round(y)", |p| {
        p.x - 0.5 * (p.x / 0.5).floor() - (p.y - p.y.floor()) + p.z.floor() + p.x.ceil() - (p.y + 0.5).floor()
    }),
    ("sign(x) * step(0, y) + z", |p| p.x.signum() * if p.y >= 0.0 { 1.0 } else { 0.0 } + p.z),
    ("max(min(x, y), z^2 - 1, abs(x))", |p| p.x.min(p.y).max(p.z * p.z - 1.0).max(p.x.abs())),
    ("1 - length(x, 2*y, z)", |p| 1.0 - DVec3::new(p.x, 2.0 * p.y, p.z).length()),
    ("1 - x^2 - 4*(z - 0.1)^2", |p| 1.0 - p.x * p.x - 4.0 * (p.z - 0.1).powi(2)),
    ("(y + 0.2)^2 - 0.5", |p| (p.y + 0.2).powi(2) - 0.5),
    ("x^2 + 2*y^2 - z^2", |p| p.x * p.x + 2.0 * p.y * p.y - p.z * p.z),
    ("(x + y)^2 + 3*z^2 - 1", |p| (p.x + p.y).powi(2) + 3.0 * p.z * p.z - 1.0),
    ("sqrt(x^2 + y^2 + 0.01) * (x + y)", |p| (p.x * p.x + p.y * p.y + 0.01).sqrt() * (p.x + p.y)),
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn formulas_mean_what_they_say(seed: u64, scale in 0.01..1.0f64) {
        let mut samples = Samples::new(seed);
        for (text, wanted) in CASES {
            let field = field(text).keeping_values();
            let mut evaluator = field.evaluator();
            let min = samples.within(&Aabb::new(WORLD.min, WORLD.max - 2.0 * scale));
            let region = Aabb::new(min, min + 2.0 * scale);
            let points = samples.batch(&region, 40);
            let (mut whole, mut values, mut gradients) = ([0.0; BATCH], [0.0; BATCH], Gradients::new());
            evaluator.values(&points, &mut whole);
            evaluator.enter(&region.grown(1e-6));
            let bound = evaluator.bounds();
            evaluator.values(&points, &mut values);
            evaluator.gradients(&points, &mut gradients);
            for i in 0..points.len {
                let p = points.position(i);
                let (exact, reference) = (wanted(p), field.reference(p));
                prop_assert!((reference - exact).abs() < 1e-11 * (1.0 + exact.abs()), "{text}: {reference} != {exact}");
                prop_assert!(bound.contains(reference), "{text}: {reference} not in {bound:?}");
                let step = 1e-6;
                let slope = DVec3::AXES.map(|axis| (wanted(p + axis * step) - wanted(p - axis * step)) / (2.0 * step));
                let coarse = DVec3::AXES.map(|axis| (wanted(p + axis * 1e-4) - wanted(p - axis * 1e-4)) / 2e-4);
                // Beside a step or a crease, `f32` may stand on its other side.
                let size = 1.0 + exact.abs() + DVec3::from(slope).length();
                if (DVec3::from(slope) - DVec3::from(coarse)).length() < 1e-3 * size {
                    prop_assert!((f64::from(values[i]) - exact).abs() < 1e-5 * size, "{text}: {} != {exact}", values[i]);
                    let error = (gradients.gradient(i).as_dvec3() - DVec3::from(slope)).length();
                    prop_assert!(error < 2e-3 * size, "{text}: ∇ off by {error} at {p}");
                }
                prop_assert_eq!(values[i].to_bits(), whole[i].to_bits(), "{}: pruned values differ", text);
            }
        }
    }
}

#[test]
fn vector_widths_give_formulas_the_same_bits() {
    let points = Samples::new(11).batch(&WORLD, 500);
    for (text, _) in CASES {
        let field = field(text);
        let answers = VectorWidth::ALL.map(|width| {
            let mut evaluator = field.evaluator_of_width(width);
            let (mut values, mut out) = ([0.0; BATCH], Gradients::new());
            evaluator.values(&points, &mut values);
            evaluator.gradients(&points, &mut out);
            [values, out.value, out.dx, out.dy, out.dz].map(|array| array.map(f32::to_bits)[..500].to_vec())
        });
        assert!(answers[0] == answers[1] && answers[0] == answers[2], "{text}");
    }
}

#[test]
fn surfaces_far_from_the_origin_are_right_to_a_thousandth_of_a_voxel() {
    let far = DVec3::new(100_000.0, -100_000.0, 100_000.0);
    let mut graph = Graph::new();
    let solids = [graph.sphere(1.0), graph.cuboid(DVec3::splat(1.5)), graph.torus(1.0, 0.3), graph.heart(2.0)];
    let names = Names::space(&mut graph);
    let formula = Formula::parse("1 - sqrt((x - 100000)^2 + (y + 100000)^2 + (z - 100000)^2)");
    let mut far_ones = solids.map(|solid| graph.translate(solid, far).expect("a motion")).to_vec();
    far_ones.push(formula.compile(&mut graph, &names).expect("it compiles"));
    let voxel = 1.0 / 256.0;
    for node in far_ones {
        let field = Expression::new(&graph, node);
        let mut evaluator = field.evaluator();
        let mut samples = Samples::new(1);
        let mut values = [0.0; BATCH];
        for _ in 0..200 {
            // A block of 8 voxels somewhere around the solid.
            let corner = far + samples.within(&WORLD);
            let mut points = Points::new(corner);
            for _ in 0..50 {
                let offset = samples.within(&Aabb::new(DVec3::ZERO, DVec3::splat(8.0 * voxel)));
                points.push(offset.as_vec3());
            }
            evaluator.values(&points, &mut values);
            for i in 0..points.len {
                let error = f64::from(values[i]) - field.reference(points.position(i));
                assert!(error.abs() < 1e-3 * voxel, "{error} at {}", points.position(i));
            }
        }
    }
}

/// Creases under arithmetic make a branch for each choice of sides that says something else, and those are all there is.
#[test]
fn creases_below_one_another_make_no_branches_that_cannot_matter() {
    for (text, count) in [
        // Of five of them.
        ("max(max(min(x, y), min(y, z)), min(z, x)) - 0.3", 3),
        ("max(max(min(x, y), min(y, z)), min(z, x)) - 0.3 + 0.1*abs(x + y)", 6),
        ("0.9 - max(abs(x), abs(y), abs(z))", 6),
        ("0.9 - abs(abs(x) - 0.5) - 0*y", 4),
        ("min(x, min(y, x)) + z", 2),
        ("0.9 - abs(x) - abs(y) - abs(z) - abs(x - y) - abs(x + 2*z)", 1),
        ("1 - x^2 - y^2", 1),
    ] {
        let field = field(text);
        let mut evaluator = field.evaluator();
        assert_eq!(evaluator.branches(), count, "{text}");
        if count == 1 {
            continue;
        }
        let mut samples = Samples::new(7);
        let points = samples.batch(&Aabb::new(DVec3::splat(-1.0), DVec3::ONE), BATCH);
        let mut out = Gradients::new();
        let mut met = [false; BATCH];
        for branch in 0..count {
            evaluator.branch(branch, &points, &mut out);
            let mut own = false;
            for i in 0..BATCH {
                let same = (f64::from(out.value[i]) - field.reference(points.position(i))).abs() < 1e-6;
                (met[i], own) = (met[i] | same, own | same);
            }
            assert!(own, "{text}: branch {branch} is F nowhere");
        }
        assert!(met.iter().all(|met| *met), "{text}");
    }
}
