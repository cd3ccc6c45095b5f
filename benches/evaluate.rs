//! Batch evaluation of the *two_hundred* scene (200 balls in a balanced tree of R₀ unions, less 20): the whole
//! tape against the rate of vector square roots of the same width, and against the `f64` reference.
//!
//! `cargo bench --bench evaluate`; every width that the processor has is measured, medians of repeated runs.

use std::hint::black_box;
use std::time::Instant;

use glam::{DVec3, Vec3};
use hfvdb::field::{Aabb, BATCH, Evaluator, Expression, Field, Gradients, Graph, Node, Points, SetSystem, VectorWidth};
use multiversion::multiversion;

const BALLS: usize = 200;
const HOLES: usize = 20;

fn two_hundred() -> Expression {
    let mut seed = 1u64;
    let mut next = move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut graph = Graph::new();
    let mut ball = |graph: &mut Graph| {
        let centre = DVec3::new(next(), next(), next()) * 1.7 - 0.85;
        let radius = 0.05 + 0.1 * next();
        let mut sum = graph.constant(radius * radius);
        for axis in 0..3 {
            let form = graph.affine(DVec3::AXES[axis], -centre[axis]);
            let square = graph.square(form);
            sum = graph.sub(sum, square);
        }
        sum
    };
    let balls: Vec<Node> = (0..BALLS).map(|_| ball(&mut graph)).collect();
    let mut solid = graph.union(SetSystem::R0, &balls);
    for _ in 0..HOLES {
        let hole = ball(&mut graph);
        solid = graph.difference(SetSystem::R0, solid, &[hole]);
    }
    Expression::new(&graph, solid)
}

/// Median seconds of a call.
fn time(mut call: impl FnMut()) -> f64 {
    let mut samples: Vec<f64> = (0..41)
        .map(|_| {
            let start = Instant::now();
            for _ in 0..20 {
                call();
            }
            start.elapsed().as_secs_f64() / 20.0
        })
        .collect();
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

#[inline(always)]
fn roots_body(values: &mut [f32; BATCH]) {
    for value in values {
        *value = value.sqrt();
    }
}

#[multiversion(targets("x86_64+avx+avx2"))]
fn roots_avx2(values: &mut [f32; BATCH]) {
    roots_body(values);
}

#[multiversion(targets("x86_64+avx+avx2+avx512f+avx512bw+avx512dq+avx512vl"))]
fn roots_avx512(values: &mut [f32; BATCH]) {
    roots_body(values);
}

fn roots(width: VectorWidth, values: &mut [f32; BATCH]) {
    match width {
        VectorWidth::Sse2 => roots_body(values),
        VectorWidth::Avx2 => roots_avx2(values),
        VectorWidth::Avx512 => roots_avx512(values),
    }
}

fn main() {
    let field = two_hundred();
    let mut points = Points::new(DVec3::ZERO);
    for i in 0..BATCH {
        points.push(Vec3::new((i >> 6) as f32, ((i >> 3) & 7) as f32, (i & 7) as f32) * 0.25 - 1.0);
    }
    let operations = (BALLS - 1 + HOLES) as f64;
    println!("{} operations, {operations} of them R0", field.operations());

    let mut scratch = [2.0; BATCH];
    let mut answers = Vec::new();
    for width in VectorWidth::ALL {
        let root = time(|| roots(width, black_box(&mut scratch)));
        let mut evaluator = field.evaluator_of_width(width);
        let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
        let batch = time(|| evaluator.values(black_box(&points), &mut values));
        let slopes = time(|| evaluator.gradients(black_box(&points), &mut gradients));
        println!(
            "{width:?}: {:.2} us a batch, {:.2} ns a point; {:.3} of the root rate; with gradients {:.2} times as long",
            batch * 1e6,
            batch * 1e9 / BATCH as f64,
            root * operations / batch,
            slopes / batch
        );
        answers.push(values);
    }
    assert!(answers.windows(2).all(|pair| pair[0] == pair[1]), "widths differ");

    let reference = time(|| {
        black_box(field.reference(black_box(DVec3::new(0.1, 0.2, 0.3))));
    });
    println!("reference: {:.2} us a point", reference * 1e6);

    for (name, edge) in [("128 voxels of 512", 0.5), ("8 voxels of 512", 1.0 / 32.0)] {
        let mut evaluator = field.evaluator_of_width(VectorWidth::chosen());
        let around = Aabb::new(DVec3::splat(0.1), DVec3::splat(0.1 + edge));
        evaluator.enter(&Aabb::new(DVec3::splat(-0.25), DVec3::splat(0.5)));
        let kept = evaluator.operations();
        let enter = time(|| {
            black_box(evaluator.enter(black_box(&around)));
            evaluator.leave();
        });
        println!("entering {name}: {:.2} us from {kept} operations", enter * 1e6);
    }
}
