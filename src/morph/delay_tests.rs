//! What is promised of places that wait: they show the same morph, later.

use std::sync::Arc;

use glam::DVec3;

use super::course::{Course, LEAST_TIME, Place, Timed};
use super::curves::Looked;
use super::exact::Exact;
use super::*;
use crate::attribute::{ColourSpace, Constant, FieldValue, Scalar};
use crate::field::{Aabb, BATCH, Expression, Formula, Gradients, Graph, Interval, Names, Points};

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];

fn formula(text: &str) -> Arc<Scalar> {
    let mut graph = Graph::new();
    let names = Names::space(&mut graph);
    let node = Formula::parse(text).compile(&mut graph, &names).expect("known names");
    Arc::new(FieldValue(Arc::new(Expression::new(&graph, node).keeping_values())))
}

fn tried(delay: Option<&str>) -> Result<Morph, Error> {
    let object = |exact: Arc<Exact>, colour| MorphObject {
        surface: exact.clone(),
        distance: exact,
        colour: Arc::new(Constant::new(colour)),
        motion: Motion::default(),
    };
    let mode = Arc::new(Volume { delay: delay.map(|text| Delay(formula(text))), ..Volume::default() });
    let settings = Settings { mode, colour_space: ColourSpace::Rgb, ..Settings::default() };
    Morph::new(object(Exact::cube(-0.4, 0.5), RED), object(Exact::torus(0.8, 0.3), BLUE), settings)
}

fn morph(delay: &str) -> Morph {
    tried(Some(delay)).expect("a morph")
}

/// Points all over the box of the morph.
fn points() -> Vec<DVec3> {
    let steps = |n: i32| (0..=n).map(move |i| f64::from(i) / f64::from(n) * 2.0 - 1.0);
    steps(16)
        .flat_map(|x| steps(14).flat_map(move |y| steps(10).map(move |z| DVec3::new(1.3 * x, 1.3 * y, 0.7 * z))))
        .collect()
}

/// How far the surface of a field is from each of the points, to first order, where it is near.
fn near(morph: &Morph, time: f64) -> Vec<f64> {
    let field = morph.field(time);
    let mut evaluator = field.evaluator();
    let (mut gradients, mut out) = (Gradients::new(), Vec::new());
    for chunk in points().chunks(BATCH) {
        let mut at = Points::new(DVec3::ZERO);
        chunk.iter().for_each(|point| at.push(point.as_vec3()));
        evaluator.enter(&Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0)));
        evaluator.gradients(&at, &mut gradients);
        evaluator.leave();
        out.extend((0..at.len).map(|i| f64::from(gradients.value[i] / gradients.gradient(i).length().max(1e-9))));
    }
    out
}

/// Signs agree but for points as near as this to both surfaces.
fn assert_alike(one: &[f64], other: &[f64], within: f64, what: &str) {
    let bad = one.iter().zip(other).filter(|(a, b)| (**a >= 0.0) != (**b >= 0.0) && a.abs().min(b.abs()) > within);
    assert_eq!(bad.count(), 0, "{what}");
}

#[test]
fn without_a_wait_it_is_the_morph_itself() {
    let (plain, delayed) = (tried(None).unwrap(), morph("0"));
    for time in [0.0, 0.05, 0.1, 0.3, 0.5, 0.77, 0.95, 0.99, 1.0] {
        assert_alike(&near(&plain, time), &near(&delayed, time), 2e-3, &format!("at {time}"));
        let volumes = [&plain, &delayed].map(|morph| morph.report(&[time]).frames[0].volume);
        assert!((volumes[0] / volumes[1] - 1.0).abs() < 2e-3, "{volumes:?} at {time}");
    }
}

/// The same wait everywhere is a morph that starts later.
#[test]
fn a_wait_everywhere_is_a_later_start() {
    let (plain, delayed) = (tried(None).unwrap(), morph("0.4"));
    for time in [0.2, 0.4, 0.5, 0.7, 0.9, 1.0] {
        let own = ((time - 0.4) / 0.6_f64).max(0.0);
        assert_alike(&near(&plain, own), &near(&delayed, time), 2e-3, &format!("at {time}"));
        let colours = [(&plain, own), (&delayed, time)].map(|(morph, time)| {
            let (mut at, mut out) = (Points::new(DVec3::ZERO), [[0.0; 3]; BATCH]);
            points().iter().step_by(7).take(BATCH).for_each(|point| at.push(point.as_vec3()));
            morph.colour(time).sampler().sample(&at, &mut out);
            out[..at.len].to_vec()
        });
        // At its start, outside of the first object, STTI has some of the other's colour already.
        let same = colours[0].iter().zip(&colours[1]).all(|(a, b)| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-4));
        assert!(same || own == 0.0, "colours at {time}");
    }
}

#[test]
fn places_start_apart_and_end_together() {
    let (plain, delayed) = (tried(None).unwrap(), morph("0.6*clamp(2*x + 0.5, 0, 1)"));
    let (first, all) = (near(&plain, 0.0), points());
    for time in [0.2, 0.5] {
        let (waiting, going) = (near(&delayed, time), near(&plain, time));
        // A cell of the coarse grid is a thirtieth of the box.
        let right: Vec<usize> = (0..all.len()).filter(|&i| all[i].x > 0.4).collect();
        let left: Vec<usize> = (0..all.len()).filter(|&i| all[i].x < -0.4).collect();
        let of = |places: &[usize], list: &[f64]| places.iter().map(|&i| list[i]).collect::<Vec<_>>();
        assert_alike(&of(&right, &waiting), &of(&right, &first), 1e-3, "the right side waits");
        assert_alike(&of(&left, &waiting), &of(&left, &going), 2e-3, "the left side goes");
    }
    let late = near(&delayed, 0.999);
    assert_alike(&late, &near(&plain, 1.0), 0.02, "all have ended");
    let report = delayed.report(&[0.0, 0.25, 0.5, 0.75, 1.0]);
    assert!(report.frames.iter().all(|frame| frame.target.is_none() && frame.volume > 0.5));
}

#[test]
fn gradients_are_those_of_the_values_and_bounds_hold_them() {
    let morph = morph("0.5*clamp(0.5 + 0.4*x + 0.3*sin(3*y), 0, 1)");
    for time in [0.02, 0.3, 0.6, 0.93] {
        let field = morph.field(time);
        let mut evaluator = field.evaluator();
        let (step, mut gradients, mut values) = (1e-4, Gradients::new(), [0.0; BATCH]);
        for chunk in points().chunks(BATCH) {
            let mut at = Points::new(DVec3::ZERO);
            chunk.iter().for_each(|point| at.push(point.as_vec3()));
            let region = Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0));
            evaluator.enter(&region);
            evaluator.gradients(&at, &mut gradients);
            evaluator.values(&at, &mut values);
            let bounds = evaluator.bounds();
            evaluator.leave();
            for i in (0..at.len).step_by(3) {
                let position = at.position(i);
                let slope = |axis: DVec3| {
                    (field.reference(position + axis * step) - field.reference(position - axis * step)) / (2.0 * step)
                };
                let by_differences = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
                let off = (gradients.gradient(i).as_dvec3() - by_differences).length();
                // Exact distances have creases of their own.
                let crease = position.x.abs() < 1e-3 || (position.truncate().length() < 0.05);
                assert!(
                    off < 2e-2 * (1.0 + by_differences.length()) || crease || on_a_crease(position),
                    "{off} at {position} ({time})"
                );
                assert!((f64::from(values[i]) - field.reference(position)).abs() < 1e-5);
                assert!(bounds.contains(f64::from(values[i])));
            }
        }
        // Beyond the lattice of delays too.
        let mut far = Points::new(DVec3::new(0.1, 0.0, 0.2));
        Aabb::new(DVec3::splat(-4.0), DVec3::splat(4.0)).corners().iter().for_each(|corner| far.push(corner.as_vec3()));
        evaluator.values(&far, &mut values);
        for (i, value) in values[..far.len].iter().enumerate() {
            assert!((f64::from(*value) - field.reference(far.position(i))).abs() < 1e-5, "{value}");
        }
        for (number, middle) in points().into_iter().enumerate().step_by(5) {
            let half = [0.3, 0.1, 0.02, 0.004][number % 4];
            let region = Aabb::new(middle - half, middle + half);
            evaluator.enter(&region);
            let bounds = evaluator.bounds();
            let mut at = Points::new(middle);
            for i in 0..64 {
                let corner = DVec3::new(f64::from(i & 3), f64::from(i >> 2 & 3), f64::from(i >> 4)) / 1.5 - 1.0;
                at.push((corner * half).as_vec3());
            }
            evaluator.values(&at, &mut values);
            evaluator.leave();
            let low = values[..64].iter().fold(f32::INFINITY, |least, value| least.min(*value));
            let high = values[..64].iter().fold(f32::NEG_INFINITY, |most, value| most.max(*value));
            assert!(bounds.lo <= f64::from(low) && f64::from(high) <= bounds.hi, "{bounds:?} {low} {high} at {middle}");
        }
    }
}

/// Whether the cube's distance has no gradient near a place: where two of its faces are equally far.
fn on_a_crease(p: DVec3) -> bool {
    let from = (p - DVec3::new(-0.4, 0.0, 0.0)).abs() - 0.5;
    let [a, b, c] = from.to_array();
    [a - b, b - c, a - c].iter().any(|way| way.abs() < 2e-3)
        || from.to_array().iter().any(|way| (way + 0.5).abs() < 2e-3)
}

#[test]
fn a_course_changes_as_its_rate_says() {
    let time = |progress: f64| progress.clamp(LEAST_TIME, 1.0 - LEAST_TIME);
    let a0 = |progress: &f64| 0.7 * time(*progress) * (1.0 - time(*progress)) * (1.0 + 0.3 * time(*progress).powi(3));
    let timed = |progress: f64| {
        let time = time(progress);
        Timed { time, reach: 0.4 + time * (1.0 - time) }
    };
    let course = |range: Interval| {
        let nodes = Course::nodes(range);
        Course::new(&nodes, &nodes.iter().map(a0).collect::<Vec<_>>(), timed).unwrap()
    };
    // Of a part of it, it is the same there.
    let parts = [(0.0, 0.3), (0.3, 0.55), (0.5, 0.5), (0.7, 1.0)].map(|(lo, hi)| Interval::new(lo, hi));
    let (all, parts) = (course(Interval::new(0.0, 1.0)), parts.map(|range| (range, course(range))));
    for progress in (0..=200).map(|step| f64::from(step) / 200.0) {
        let within = parts.iter().filter(|(range, _)| range.contains(progress));
        within.for_each(|(_, course)| assert_eq!(course.at(progress), all.at(progress)));
    }
    let course = all;
    // Between its nodes too it is what it is made of, at the turn of the reach as well.
    for progress in (10..=1990).map(|step| f64::from(step) / 2000.0) {
        let ([time_there, _, reach], exact) = (course.at(progress), timed(progress));
        assert!((time_there - exact.time).abs() < 1e-6 && (reach - exact.reach).abs() < 2e-5, "{reach} at {progress}");
        assert!((course.a0(progress) - a0(&progress)).abs() < 2e-5, "{} at {progress}", course.a0(progress));
    }
    let mut looked = Looked::new();
    // At 0.8 the first distance is that to the cut in time.
    for progress in (1..=60).map(|step| 0.001 + 0.01637 * f64::from(step)).chain([0.8]) {
        course.look_up(&[progress as f32], true, &mut looked);
        let [values, rates] = [&looked.values, &looked.rates].map(|found| found.map(|lanes| lanes[0]));
        let place = Place::new(progress as f32, values);
        for (first, second) in [(-0.2, -0.1), (0.1, -0.3), (-0.01, 0.2), (0.2, 0.3)] {
            let (step, at) = (1e-6, |progress: f64| course.place(progress).value(first, second));
            let by_differences = (at(progress + step) - at(progress - step)) / (2.0 * step);
            let rate = f64::from(place.rate(progress as f32, values, rates, [first as f32, second as f32]));
            assert!(
                (rate - by_differences).abs() < 1e-4 * (1.0 + rate.abs()),
                "{rate} {by_differences} at {progress}, {first}, {second}"
            );
            let around = Interval::new(progress - 0.01, progress + 0.01);
            let [lo, hi] = course.sections(around).bounds([first; 2], [second; 2]);
            assert!((-10..=10).all(|i| (lo..=hi).contains(&at(progress + 1e-3 * f64::from(i)))));
        }
    }
}

#[test]
fn delays_out_of_range_are_refused() {
    for (text, says) in [("1.2", "1.2"), ("x", "delay"), ("sqrt(x)", "NaN")] {
        let error = tried(Some(text)).err().expect("it is refused").to_string();
        assert!(error.contains("delay") && error.contains(says) && error.contains("0.95"), "{error}");
    }
}
