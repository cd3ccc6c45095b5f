//! Batch evaluation of *two_hundred* (200 balls in a balanced tree of R₀ unions, less 20): the whole tape against the
//! rate of vector square roots of the same width, and against fidget's JIT, which is AVX2 and has R₀ written out (rows 2
//! and 3 of the performance table); and the `f64` reference, and entering a region.
//!
//! `cargo bench -p hfvdb-bench --bench evaluate`; every width that the processor has is measured, medians of repeated runs.

use std::hint::black_box;
use std::time::Instant;

use fidget::jit::JitShape;
use fidget::shape::EzShape;
use glam::{DVec3, Vec3};
use hfvdb::field::{Aabb, BATCH, Evaluator, Field, Gradients, Points, SetSystem, VectorWidth};
use hfvdb_bench::clock::quartiles;
use hfvdb_bench::report::{Goal, Row};
use hfvdb_bench::{jit, scenes};
use multiversion::multiversion;

/// Seconds of a call, the mean of some.
fn time(mut call: impl FnMut()) -> f64 {
    const CALLS: u32 = 20;
    let start = Instant::now();
    (0..CALLS).for_each(|_| call());
    start.elapsed().as_secs_f64() / f64::from(CALLS)
}

/// The median and the borders of the middle half of what is measured again and again.
fn rounds(measure: impl FnMut() -> f64) -> [f64; 3] {
    const ROUNDS: usize = 41;
    quartiles(std::iter::repeat_with(measure).take(ROUNDS))
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
    let balls = scenes::two_hundred();
    let field = balls.expression(SetSystem::R0);
    let mut points = Points::new(DVec3::ZERO);
    for i in 0..BATCH {
        points.push(Vec3::new((i >> 6) as f32, ((i >> 3) & 7) as f32, (i & 7) as f32) * 0.25 - 1.0);
    }
    let operations = (balls.solid.len() - 1 + balls.holes.len()) as f64;
    println!("{} operations, {operations} of them R0", field.operations());
    let shape = jit::shape(&balls, jit::r0_union);
    let (tape, mut rival) = (shape.ez_float_slice_tape(), JitShape::new_float_slice_eval());
    let mut rival = |points: &Points| {
        let values = rival.eval(&tape, &points.x[..], &points.y[..], &points.z[..]).expect("a tape");
        <[f32; BATCH]>::try_from(values).expect("a value a point")
    };

    let row = |number| Row(number, "two_hundred", BATCH as u32);
    let mut answers = Vec::new();
    for width in VectorWidth::ALL.into_iter().filter(|width| *width <= VectorWidth::chosen()) {
        let mut evaluator = field.evaluator_of_width(width);
        let (mut values, mut gradients) = ([0.0; BATCH], Gradients::new());
        let mut scratch = [2.0; BATCH];
        let name = format!("{width:?}");
        let share = rounds(|| {
            let root = time(|| roots(width, black_box(&mut scratch)));
            root * operations / time(|| evaluator.values(black_box(&points), &mut values))
        });
        row("2").spread(&name, share, Goal::AtLeast(0.35));
        let against_jit = rounds(|| {
            let theirs = time(|| {
                black_box(rival(black_box(&points)));
            });
            theirs / time(|| evaluator.values(black_box(&points), &mut values))
        });
        let goal = match width {
            VectorWidth::Sse2 => Goal::None,
            VectorWidth::Avx2 => Goal::AtLeast(0.9),
            VectorWidth::Avx512 => Goal::AtLeast(1.7),
        };
        row("3").spread(&name, against_jit, goal);
        let [batch, ..] = rounds(|| time(|| evaluator.values(black_box(&points), &mut values)));
        let [slopes, ..] = rounds(|| time(|| evaluator.gradients(black_box(&points), &mut gradients)));
        println!(
            "{width:?}: {:.2} us a batch, {:.2} ns a point; with gradients {:.2} times as long",
            batch * 1e6,
            batch * 1e9 / BATCH as f64,
            slopes / batch
        );
        answers.push(values);
    }
    assert!(answers.windows(2).all(|pair| pair[0] == pair[1]), "widths differ");
    // Values depend on the order in which balls are joined, signs do not.
    let alike = |(a, b): (&f32, &f32)| a.is_sign_negative() == b.is_sign_negative();
    assert!(rival(&points).iter().zip(&answers[0]).all(alike), "the rival computes something else");

    let [reference, ..] = rounds(|| {
        time(|| {
            black_box(field.reference(black_box(DVec3::new(0.1, 0.2, 0.3))));
        })
    });
    println!("reference: {:.2} us a point", reference * 1e6);

    for (name, edge) in [("128 voxels of 512", 0.5), ("8 voxels of 512", 1.0 / 32.0)] {
        let mut evaluator = field.evaluator_of_width(VectorWidth::chosen());
        let around = Aabb::new(DVec3::splat(0.1), DVec3::splat(0.1 + edge));
        evaluator.enter(&Aabb::new(DVec3::splat(-0.25), DVec3::splat(0.5)));
        let kept = evaluator.operations();
        let [enter, ..] = rounds(|| {
            time(|| {
                evaluator.enter(black_box(&around));
                black_box(evaluator.bounds());
                evaluator.leave();
            })
        });
        println!("entering {name}: {:.2} us from {kept} operations", enter * 1e6);
    }
}
