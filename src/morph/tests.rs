//! The promises of a morph, on exact shapes and on one built as an octree.

use std::sync::{Arc, LazyLock};

use glam::DVec3;

use super::exact::Exact;
use super::mode::Between;
use super::*;
use crate::attribute::{ColourSpace, Constant, LinearRgb};
use crate::distance::Distance;
use crate::field::{Aabb, BATCH, Field, Gradients, Points};

pub(super) const YELLOW: LinearRgb = [0.9, 0.7, 0.03];
const PINK: LinearRgb = [1.0, 0.03, 0.2];

pub(super) fn object(exact: Arc<Exact>, colour: LinearRgb, motion: Motion) -> MorphObject {
    MorphObject { surface: exact.clone(), distance: exact, colour: Arc::new(Constant::new(colour)), motion }
}

pub(super) fn still(exact: Arc<Exact>, colour: LinearRgb) -> MorphObject {
    object(exact, colour, Motion::default())
}

fn morph_with(from: Arc<Exact>, to: Arc<Exact>, settings: Settings) -> Morph {
    Morph::new(still(from, YELLOW), still(to, PINK), settings).expect("a morph")
}

fn flow(mode: Volume) -> Settings {
    Settings { mode: Arc::new(mode), ..Settings::default() }
}

fn paper(numbers: Numbers) -> Settings {
    Settings { mode: Arc::new(Paper(numbers.into())), ..Settings::default() }
}

/// What a morph shows at a time: its stage, and the section with its a₀.
fn shown(morph: &Morph, time: f64) -> (Stage, Option<Section>) {
    let stage = morph.stage(time);
    let section = match morph.settings.mode.between(stage.t(), time) {
        Between::Section(section) => Some(section),
        Between::Enclosing(section) => Some(Section { a0: morph.solved(time).enclosing.a0, ..section }),
        Between::Formula(_) => None,
    };
    (stage, section)
}

pub(super) fn frames(count: usize) -> Vec<f64> {
    (0..count).map(|frame| frame as f64 / (count - 1) as f64).collect()
}

/// Numbers in [0, 1) from a seed.
pub(super) fn random(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

pub(super) fn random_points(seed: u64, reach: f64) -> Points {
    let mut next = random(seed);
    let mut points = Points::new(DVec3::ZERO);
    for _ in 0..BATCH {
        points.push(DVec3::new(next() - 0.5, next() - 0.5, next() - 0.5).as_vec3() * (2.0 * reach) as f32);
    }
    points
}

/// A morph that several tests look at, planned once.
fn usual() -> &'static Morph {
    static USUAL: LazyLock<Morph> =
        LazyLock::new(|| morph_with(Exact::cube(-0.4, 0.5), Exact::torus(0.8, 0.3), Settings::default()));
    &USUAL
}

fn pairs() -> Vec<(&'static str, Arc<Exact>, Arc<Exact>)> {
    let two = Exact::Apart(vec![(*Exact::ball(-0.9, 0.4)).clone(), (*Exact::ball(0.9, 0.4)).clone()]);
    let plates = [DVec3::new(1.0, 1.0, 0.04), DVec3::new(0.04, 1.0, 1.0)].map(|half| Exact::block(0.0, half));
    let [lying, standing] = plates;
    vec![
        ("apart", Exact::cube(-1.2, 0.5), Exact::ball(1.2, 0.5)),
        ("concentric", Exact::cube(0.0, 0.8), Exact::ball(0.0, 0.6)),
        ("cube to torus", Exact::cube(0.0, 0.8), Exact::torus(1.0, 0.3)),
        ("small in big", Exact::ball(0.3, 0.15), Exact::cube(0.0, 1.0)),
        ("one into two", Exact::cube(0.0, 0.6), Arc::new(two)),
        ("thin plates crossing", lying, standing),
        ("far apart", Exact::ball(-4.0, 0.5), Exact::cube(4.0, 0.5)),
    ]
}

#[test]
fn never_empty_on_the_volumes_curve_and_without_pops() {
    for (name, from, to) in pairs() {
        let report = morph_with(from, to, Settings::default()).report(&frames(48));
        for frame in &report.frames {
            let target = frame.target.expect("a flow has a target");
            assert!(frame.volume > 0.0, "{name}: empty at {}", frame.time);
            assert!((frame.volume / target - 1.0).abs() < 1e-4, "{name}: {} for {target}", frame.volume);
        }
        assert!(report.largest_over_median < 2.0, "{name}: {}", report.largest_over_median);
        for frame in [report.frames[1], report.frames[47]] {
            let step = frame.change / report.median_change;
            assert!((0.5..2.0).contains(&step), "{name}: a step of {step} at {}", frame.time);
        }
    }
}

/// A shell thinner than the coarse cells is born as crumbs: its volume cannot be held to, but it is never empty.
#[test]
fn into_a_thin_shell() {
    let shell = Exact::Shell { of: Box::new((*Exact::ball(0.0, 1.0)).clone()), half: 0.03 };
    let report = morph_with(Exact::ball(0.0, 0.4), Arc::new(shell), Settings::default()).report(&frames(24));
    assert!(report.frames.iter().all(|frame| frame.volume > 0.2));
    assert!(report.largest_over_median < 2.0, "{}", report.largest_over_median);
}

/// F's own zero set, on a finer grid of another kind: the share of cells' middles inside, weighed by F/|∇F|.
fn dense_volume(field: &dyn Field, aabb: Aabb, cells: i32) -> f64 {
    let edge = aabb.size().max_element() / f64::from(cells);
    let count = (aabb.size() / edge).ceil().as_ivec3();
    let mut evaluator = field.evaluator();
    let mut gradients = Gradients::new();
    let mut volume = 0.0;
    for x in 0..count.x {
        for y in 0..count.y {
            let mut points = Points::new(aabb.min);
            for z in 0..count.z {
                points.push(((DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + 0.5) * edge).as_vec3());
            }
            evaluator.gradients(&points, &mut gradients);
            for i in 0..points.len {
                let distance = f64::from(gradients.value[i] / gradients.gradient(i).length());
                volume += (0.5 + distance / edge).clamp(0.0, 1.0);
            }
        }
    }
    volume * edge.powi(3)
}

#[test]
fn the_frames_own_field_has_the_volume_asked_for() {
    let morph = usual();
    let volumes = [1.0, 2.0 * 0.8 * (std::f64::consts::PI * 0.3).powi(2)];
    for time in [0.05, 0.3, 0.5, 0.8, 0.97] {
        let field = morph.field(time);
        let t = morph.stage(time).t();
        let target = volumes[0] + t * (volumes[1] - volumes[0]);
        let volume = dense_volume(field.as_ref(), morph.extent().grown(0.05), 110);
        assert!((volume / target - 1.0).abs() < 0.005, "{volume} for {target} at {time}");
    }
}

#[test]
fn ends_are_the_objects() {
    let (morph, from, to) = (usual(), Exact::cube(-0.4, 0.5), Exact::torus(0.8, 0.3));
    let points = random_points(1, 1.5);
    for (time, own, colour) in [(0.0, &from, YELLOW), (-0.5, &from, YELLOW), (1.0, &to, PINK), (2.0, &to, PINK)] {
        let (mut values, mut expected) = ([0.0; BATCH], [0.0; BATCH]);
        morph.field(time).evaluator().values(&points, &mut values);
        own.evaluator().values(&points, &mut expected);
        assert_eq!(values, expected);
        let mut colours = [[0.0; 3]; BATCH];
        morph.colour(time).sampler().sample(&points, &mut colours);
        assert!(colours.iter().all(|own| *own == colour));
    }
}

#[test]
fn frames_near_the_ends_are_near_the_objects() {
    let (morph, from, to) = (usual(), Exact::cube(-0.4, 0.5), Exact::torus(0.8, 0.3));
    let points = random_points(2, 1.2);
    for (time, own) in [(1e-4, &from), (1.0 - 1e-4, &to)] {
        let mut values = [0.0; BATCH];
        morph.field(time).evaluator().values(&points, &mut values);
        for i in 0..BATCH {
            let distance = own.reference(points.position(i));
            assert!(distance.abs() < 0.002 || (distance > 0.0) == (values[i] > 0.0), "{distance} at {time}");
        }
    }
}

#[test]
fn an_object_morphed_into_itself_does_not_move() {
    for bridge in [0.05, 1.5] {
        let cube = Exact::cube(0.1, 0.5);
        let morph = morph_with(cube.clone(), cube.clone(), flow(Volume { bridge: bridge.into(), ..Volume::default() }));
        let points = random_points(3, 0.9);
        for time in [0.1, 0.5, 0.77] {
            let field = morph.field(time);
            for i in 0..BATCH {
                let position = points.position(i);
                let (distance, value) = (cube.reference(position), field.reference(position));
                assert!(distance.abs() < 1e-4 || (distance > 0.0) == (value > 0.0), "{bridge}: {distance}, {value}");
            }
        }
        let report = morph.report(&frames(8));
        assert!(report.frames.iter().all(|frame| frame.change < 1e-4 * frame.volume), "{report:?}");
    }
}

#[test]
fn a_frames_gradients_are_those_of_its_values() {
    for time in [0.1, 0.5, 0.85] {
        let field = usual().field(time);
        let mut evaluator = field.evaluator();
        let (points, mut gradients, mut values) = (random_points(7, 1.2), Gradients::new(), [0.0; BATCH]);
        evaluator.gradients(&points, &mut gradients);
        evaluator.values(&points, &mut values);
        assert_eq!(values, gradients.value);
        let mut wrong = 0;
        for i in 0..BATCH {
            let position = points.position(i);
            assert!((field.reference(position) - f64::from(values[i])).abs() < 2e-6, "at {position}");
            let slope = |axis: DVec3| {
                (field.reference(position + axis * 1e-5) - field.reference(position - axis * 1e-5)) / 2e-5
            };
            let expected = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
            wrong += usize::from(gradients.gradient(i).as_dvec3().distance(expected) > 1e-3);
        }
        // On the medial axes of both objects there is no gradient.
        assert!(wrong <= 2, "{wrong} wrong gradients at {time}");
    }
}

#[test]
fn bounds_hold_all_samples() {
    let turned = Similarity::new(1.3, DVec3::new(30.0, -40.0, 75.0), DVec3::new(0.2, 0.1, -0.1)).expect("sound");
    let from = object(Exact::ball(-0.4, 0.4), YELLOW, Motion::still(turned));
    let by_ball = Morph::new(from, still(Exact::ball(0.5, 0.3), PINK), Settings::default()).expect("a morph");
    let by_hand = Numbers { a: [-0.3, 1.0, 1.0, 1.0], ..Numbers::default() };
    let by_hand = morph_with(Exact::cube(-0.4, 0.5), Exact::ball(0.5, 0.4), paper(by_hand));
    for (morph, time) in [(&by_ball, 0.5), (&by_ball, 0.1), (usual(), 0.4), (&by_hand, 0.3)] {
        let field = morph.field(time);
        let mut evaluator = field.evaluator();
        let mut next = random(8);
        let mut decided = 0;
        for _ in 0..60 {
            let centre = DVec3::new(next() - 0.5, next() - 0.5, next() - 0.5) * 3.0;
            let half = 10f64.powf(-2.5 * next());
            evaluator.enter(&Aabb::new(centre - half, centre + half));
            let bounds = evaluator.bounds();
            decided += usize::from(!bounds.contains(0.0));
            let mut points = random_points((next() * 1e9) as u64, half);
            points.origin = centre;
            let mut values = [0.0; BATCH];
            evaluator.values(&points, &mut values);
            evaluator.leave();
            for i in 0..BATCH {
                let exact = field.reference(points.position(i));
                assert!(bounds.contains(exact) && bounds.contains(f64::from(values[i])), "{bounds:?} {exact}");
            }
        }
        assert!(decided >= 30, "only {decided} of 60 regions have a sign");
    }
}

#[test]
fn nothing_lies_outside_the_box() {
    for time in [0.2, 0.5, 0.9] {
        let field = usual().field(time);
        let aabb = field.bounding_box().expect("a box");
        let points = (0..40).map(|seed| random_points(seed, 3.0));
        for position in points.flat_map(|points| (0..BATCH).map(move |i| points.position(i))) {
            assert!(aabb.contains(position) || field.reference(position) < 0.0, "{position} at {time}");
        }
        // The plan's box holds what is inside, to within a cell.
        let extent = usual().extent().grown(usual().plan().grid.edge());
        for position in
            (0..40).map(|seed| random_points(seed, 1.5)).flat_map(|points| (0..BATCH).map(move |i| points.position(i)))
        {
            assert!(extent.contains(position) || field.reference(position) < 0.0, "{position} at {time}");
        }
    }
}

/// Counts the leaves of 8³ voxels that bounds leave open around a band of three voxels, and those that hold a voxel of it.
fn leaves(field: &dyn Field, aabb: Aabb, voxel: f64) -> [usize; 2] {
    fn descend(
        evaluator: &mut dyn crate::field::Evaluator,
        corner: DVec3,
        edge: f64,
        voxel: f64,
        out: &mut [usize; 2],
    ) {
        let node = Aabb::new(corner, corner + edge);
        evaluator.enter(&node.grown(2.5 * voxel));
        let bounds = evaluator.bounds();
        if bounds.contains(0.0) && edge > 8.5 * voxel {
            for child in Aabb::new(corner, corner + edge * 0.5).corners() {
                descend(evaluator, child, edge * 0.5, voxel, out);
            }
        } else if bounds.contains(0.0) {
            let (mut points, mut gradients) = (Points::new(node.centre()), Gradients::new());
            for i in 0..BATCH {
                let place = DVec3::new((i >> 6) as f64, (i >> 3 & 7) as f64, (i & 7) as f64) - 3.5;
                points.push((place * voxel).as_vec3());
            }
            evaluator.gradients(&points, &mut gradients);
            let near = |i: usize| gradients.value[i].abs() / gradients.gradient(i).length() < 3.0 * voxel as f32;
            out[0] += 1;
            out[1] += usize::from((0..BATCH).any(near));
        }
        evaluator.leave();
    }
    let mut edge = 8.0 * voxel;
    while edge < aabb.size().max_element() {
        edge *= 2.0;
    }
    let mut out = [0; 2];
    descend(field.evaluator().as_mut(), aabb.centre() - edge * 0.5, edge, voxel, &mut out);
    out
}

#[test]
fn few_leaves_are_opened_in_vain() {
    use crate::distance::nearest::Watch;
    use crate::distance::octree::{DistanceObject, Settings as OctreeSettings};
    use std::sync::atomic::AtomicBool;
    let cancel = AtomicBool::new(false);
    let watch = Watch { cancel: &cancel, progress: &|_| () };
    let octree = |exact: Arc<Exact>| -> Arc<dyn Distance> {
        let region = exact.bounding_box().expect("a box").grown(0.3);
        Arc::new(DistanceObject::build(exact.as_ref(), &OctreeSettings::new(region, 0.02), &watch).expect("built"))
    };
    let placed = |exact: Arc<Exact>, colour| MorphObject { distance: octree(exact.clone()), ..still(exact, colour) };
    // Between blocks that stand side by side distances bend at once: cells there are the steepest.
    let blocks = (0..27).map(|number| {
        let place = [number / 9, number / 3 % 3, number % 3].map(|place| f64::from(place) - 1.0);
        Exact::Block { centre: DVec3::from(place) * 0.35 - DVec3::X * 0.25, half: DVec3::splat(0.13) }
    });
    let (cube, ball) = (Exact::cube(-0.25, 0.5), Exact::ball(0.35, 0.5));
    for from in [cube, Arc::new(Exact::Apart(blocks.collect()))] {
        let morph = Morph::new(placed(from, YELLOW), placed(ball.clone(), PINK), Settings::default()).expect("a morph");
        for time in [0.1, 0.3, 0.5, 0.7, 0.9] {
            let [opened, needed] = leaves(morph.field(time).as_ref(), morph.extent().grown(0.1), 1.6 / 256.0);
            assert!(
                needed > 1000 && opened as f64 <= 1.3 * needed as f64,
                "{opened} opened, {needed} needed at {time}"
            );
        }
    }
}

#[test]
fn moving_objects_change_evenly_too() {
    let swing = |from: f64, side: f64| {
        Motion::moving(move |time| {
            let turn = DVec3::new(0.0, 30.0 * time, 90.0 * side * time);
            let place = DVec3::new(from + side * 0.2 * libm::sin(std::f64::consts::TAU * time), 0.0, 0.1 * time);
            Similarity::new(1.0 + 0.2 * time, turn, place).expect("sound")
        })
    };
    let from = object(Exact::cube(0.0, 0.4), YELLOW, swing(-0.7, 1.0));
    let to = object(Exact::ball(0.0, 0.45), PINK, swing(0.7, -1.0));
    let morph = Morph::new(from.clone(), to, Settings::default()).expect("a morph");
    let report = morph.report(&frames(48));
    assert!(report.frames.iter().all(|frame| frame.volume > 0.1));
    assert!(report.largest_over_median < 2.0, "{}", report.largest_over_median);
    for frame in &report.frames {
        assert!((frame.volume / frame.target.expect("a target") - 1.0).abs() < 1e-4);
    }
    let start = from.motion.at(0.0).to_world(DVec3::new(0.4, 0.0, 0.0));
    assert!(morph.field(0.0).reference(start).abs() < 1e-12);
}

/// Moved, turned, or both, from where it is at rest: the pair has the same D, t and change at every frame as at rest.
#[test]
fn what_carries_both_objects_changes_no_pace() {
    let bend: fn(f64) -> f64 = |time| time * time * (3.0 - 2.0 * time);
    let carry = |turn: f64, way: f64| {
        move |time: f64| {
            let time = time - 0.1;
            Similarity::new(1.0, DVec3::Z * turn * bend(time), DVec3::new(way * time, 0.3 * way * bend(time), 0.0))
                .expect("sound")
        }
    };
    let settings = || Settings { over: [0.1, 0.8], ..Settings::default() };
    let pair = |motion: &dyn Fn() -> Motion| {
        let from = object(Exact::cube(-0.9, 0.5), YELLOW, motion());
        Morph::new(from, object(Exact::ball(0.9, 0.4), PINK, motion()), settings()).expect("a morph")
    };
    let rest = pair(&Motion::default);
    let expected = rest.report(&frames(12));
    for (turn, way) in [(400.0, 0.0), (-90.0, 6.0)] {
        let moved = pair(&|| Motion::moving(carry(turn, way)));
        assert!((moved.plan().unit / rest.plan().unit - 1.0).abs() < 1e-9);
        let report = moved.report(&frames(12));
        for (own, expected) in report.frames.iter().zip(&expected.frames) {
            let at = format!("turned by {turn}, moved by {way}, at {}", own.time);
            assert!((own.t - expected.t).abs() < 1e-3, "{at}: t = {} for {}", own.t, expected.t);
            assert!((own.change - expected.change).abs() < 2e-3 * expected.volume, "{at}: {} changes", own.change);
            // The frame is the one at rest, carried.
            let place = carry(turn, way)(own.time);
            let (here, there) = (moved.field(own.time), rest.field(own.time));
            for position in [DVec3::ZERO, DVec3::new(-0.7, 0.3, 0.2), DVec3::new(0.6, -0.2, 0.1)] {
                let off = here.reference(place.to_world(position)) - there.reference(position);
                assert!(off.abs() < 5e-3, "{at}: F is off by {off}");
            }
        }
        assert!(report.largest_over_median < 2.0, "{}", report.largest_over_median);
    }
}

/// Held for most of the shot: frames that rest are none of those that the others are measured by.
#[test]
fn frames_that_rest_make_no_pops_of_others() {
    let settings = Settings { over: [0.4, 0.7], ..Settings::default() };
    let report = morph_with(Exact::cube(-0.9, 0.5), Exact::ball(0.9, 0.5), settings).report(&frames(48));
    assert!(report.median_change > 0.0);
    assert!(report.largest_over_median < 2.0, "{}", report.largest_over_median);
}

#[test]
fn a_span_and_an_ease_of_ones_own() {
    let (from, to) = (Exact::cube(-1.2, 0.5), Exact::ball(1.2, 0.5));
    let settings = Settings { over: [0.25, 0.75], ease: Ease::Smooth, ..Settings::default() };
    let morph = morph_with(from, to, settings);
    assert_eq!([0.0, 0.25, 0.75, 1.0].map(|time| morph.stage(time).t()), [0.0, 0.0, 1.0, 1.0]);
    let report = morph.report(&(0..=40).map(|step| 0.25 + f64::from(step) / 80.0).collect::<Vec<_>>());
    // Eased changes run as 6u(1 − u).
    let whole: f64 = report.frames.iter().map(|frame| frame.change).sum();
    for (step, frame) in report.frames.iter().enumerate().skip(1) {
        let smooth = |u: f64| u * u * (3.0 - 2.0 * u);
        let share = |step: usize| smooth(step as f64 / 40.0);
        let expected = (share(step) - share(step - 1)) * whole;
        assert!((frame.change - expected).abs() < 0.2 * whole / 40.0, "step {step}: {} for {expected}", frame.change);
    }
}

/// An ease that rests in the middle, goes back, and comes to its end: every frame is what its progress says.
#[test]
fn an_ease_by_keys_rests_and_goes_back() {
    let keys = [[0.0, 0.0], [0.2, 0.5], [0.4, 0.5], [0.6, 0.25], [1.0, 1.0]];
    let progress = move |time: f64| {
        let after = keys.partition_point(|key| key[0] <= time).clamp(1, keys.len() - 1);
        let ([x0, y0], [x1, y1]) = (keys[after - 1], keys[after]);
        y0 + (y1 - y0) * ((time - x0) / (x1 - x0))
    };
    let (from, to) = (Exact::cube(-1.2, 0.5), Exact::ball(1.2, 0.5));
    let eased = Settings { ease: Ease::Keyed(OverTime::moving(progress)), ..Settings::default() };
    let (eased, plain) = (morph_with(from.clone(), to.clone(), eased), morph_with(from, to, Settings::default()));
    for time in [0.0, 0.1, 0.2, 0.31, 0.4, 0.5, 0.6, 0.8, 1.0] {
        // Nothing moves, so the same progress is the same frame.
        assert_eq!(shown(&eased, time), shown(&plain, progress(time)), "{time}");
    }
    let report = eased.report(&frames(41));
    assert!(report.frames[9..=16].iter().all(|frame| frame.change == 0.0 || frame.time <= 0.2));
    let wrong = Settings { ease: Ease::Keyed(OverTime::moving(|time| 2.0 * time)), ..Settings::default() };
    assert!(wrong.check().expect_err("refused").to_string().contains("ease is"), "{:?}", wrong.check());
}

/// A bridge and the papers' numbers over time: at any time they are those of a morph that has them all the way.
#[test]
fn parameters_over_time() {
    let pair = || (Exact::cube(-0.9, 0.5), Exact::ball(0.9, 0.5));
    let with = |settings: Settings| morph_with(pair().0, pair().1, settings);
    let timed = |bridge: OverTime<f64>| flow(Volume { bridge, pace: Pace::Time, ..Volume::default() });
    let moving = with(timed(OverTime::moving(|time| 0.1 + time)));
    for time in [0.25, 0.5, 0.8] {
        assert_eq!(shown(&moving, time), shown(&with(timed((0.1 + time).into())), time));
    }
    let at = |time: f64| Numbers {
        a: [0.3 * time, 1.0 + time, 2.0, 0.3],
        slab: [-1.0 - time, 2.0],
        time_scale: 0.25 + 0.1 * time,
        round: Some(Round { a0: -0.1 * time, reach: 1.0, a3: 1.0, depth: 1.0 }),
    };
    let moving = with(Settings { mode: Arc::new(Paper(OverTime::moving(at))), ..Settings::default() });
    for time in [0.25, 0.5, 0.75] {
        assert_eq!(shown(&moving, time), (Stage::Between(time), Some(at(time).section(time))));
    }
    let transfer = |alpha: OverTime<f64>, beta: OverTime<f64>| {
        let morph = with(Settings { alpha, beta, ..timed(0.5.into()) });
        let (points, mut colours) = (random_points(11, 1.2), [[0.0; 3]; BATCH]);
        morph.colour(0.5).sampler().sample(&points, &mut colours);
        colours
    };
    let moving = transfer(OverTime::moving(|time| 2.0 * time), OverTime::moving(|time| 0.6 * time));
    assert_eq!(moving, transfer(1.0.into(), 0.3.into()));
    assert_ne!(moving, transfer(2.0.into(), 0.3.into()));
}

/// Whatever ease and pace do to t: at half of the span the volume is the curve's middle.
#[test]
fn a_volume_of_ones_own() {
    for (ease, pace) in [(Ease::Linear, Pace::Even), (Ease::Smooth, Pace::Even), (Ease::Smooth, Pace::Time)] {
        let (from, to) = (Exact::cube(0.0, 0.5), Exact::ball(0.2, 0.6));
        let volume = OverTime::moving(|time| 1.0 + 0.3 * (1.0 - (4.0 * time - 2.0).abs()).max(0.0));
        let mode = Arc::new(Volume { volume, pace, ..Volume::default() });
        let morph =
            morph_with(from, to, Settings { mode, over: [0.25, 0.75], ease: ease.clone(), ..Settings::default() });
        let report = morph.report(&(0..=40).map(|step| 0.25 + f64::from(step) / 80.0).collect::<Vec<_>>());
        let [first, middle, last] = [report.frames[0], report.frames[20], report.frames[40]];
        let straight = (1.0 - middle.t) * first.volume + middle.t * last.volume;
        assert!((middle.volume / straight - 1.3).abs() < 1e-3, "{ease:?} {pace:?}: {}", middle.volume / straight);
        for frame in &report.frames {
            assert!((frame.volume / frame.target.expect("a target") - 1.0).abs() < 1e-4);
        }
    }
}

#[test]
fn the_papers_mode_is_empty_next_to_its_ends() {
    let morph = morph_with(Exact::cube(0.0, 0.8), Exact::ball(0.0, 0.6), paper(Numbers::default()));
    let report = morph.report(&[0.0, 0.02, 0.5, 0.98, 1.0]);
    let volumes: Vec<f64> = report.frames.iter().map(|frame| frame.volume).collect();
    assert!((volumes[0] - 4.096).abs() < 1e-3 && volumes[1] == 0.0 && volumes[3] == 0.0, "{volumes:?}");
    assert_eq!(morph.stage(0.3).t(), 0.3);
}

/// The modes without space-time blending: their formulas, their volumes on the coarse grid, and their bounds.
#[test]
fn the_plain_modes_are_their_formulas() {
    let (from, to) = (Exact::cube(-0.3, 0.5), Exact::ball(0.4, 0.6));
    let modes: [(Arc<dyn Mode>, f64); 3] = [
        (Arc::new(Linear { pace: Pace::Time }), 0.3),
        (Arc::new(Linear { pace: Pace::Even }), f64::NAN),
        (Arc::new(Union), 0.3),
    ];
    for (mode, t_of) in modes {
        let is_union = !mode.carries();
        let morph = morph_with(from.clone(), to.clone(), Settings { mode: mode.clone(), ..Settings::default() });
        let (field, t) = (morph.field(0.3), morph.stage(0.3).t());
        assert!(t_of.is_nan() || t == t_of, "{t}");
        let points = random_points(12, 1.2);
        let mut values = [0.0; BATCH];
        field.evaluator().values(&points, &mut values);
        for i in 0..BATCH {
            let (one, two) = (from.reference(points.position(i)), to.reference(points.position(i)));
            let wanted = if is_union { one.max(two) } else { (1.0 - t) * one + t * two };
            assert!(
                (f64::from(values[i]) - wanted).abs() < 1e-6
                    && (field.reference(points.position(i)) - wanted).abs() < 1e-9
            );
        }
        let aabb = field.bounding_box().expect("a box");
        assert!(points_outside(&aabb).all(|position| field.reference(position) < 0.0));
        let volume = dense_volume(field.as_ref(), aabb.grown(0.05), 90);
        let report = morph.report(&[0.0, 0.3, 1.0]);
        assert!((report.frames[1].volume / volume - 1.0).abs() < 0.005, "{} for {volume}", report.frames[1].volume);
        assert!((report.frames[0].volume - 1.0).abs() < 1e-3 && report.frames[1].target.is_none());
        if mode.pace() == Pace::Even {
            let report = morph.report(&frames(48));
            assert!(report.largest_over_median < 2.0, "{}", report.largest_over_median);
        }
    }
}

/// A shape that stays, and takes on the other's colour first where the other is near.
#[test]
fn a_still_shape_takes_colours_alone() {
    let (from, to) = (Exact::ball(-0.3, 0.5), Exact::ball(1.2, 0.4));
    let settings = Settings { mode: Arc::new(Still), colour_over: [0.0, 0.5], octopus: true, ..Settings::default() };
    let morph = morph_with(from.clone(), to, settings);
    let cell = DVec3::splat(morph.plan().grid.edge());
    assert!(morph.extent().min.cmpge(DVec3::new(-0.8, -0.5, -0.5) - cell).all());
    assert!(morph.extent().max.cmple(DVec3::new(0.2, 0.5, 0.5) + cell).all());
    let points = random_points(3, 1.5);
    for time in [0.0, 0.4, 1.0] {
        assert_eq!(morph.stage(time), Stage::From);
        let field = morph.field(time);
        assert!((0..BATCH).all(|i| field.reference(points.position(i)) == from.reference(points.position(i))));
    }
    let report = morph.report(&[0.0, 0.5, 1.0]);
    assert!(report.frames.iter().all(|frame| frame.volume == report.frames[0].volume && frame.change == 0.0));
    // How near the colour is to the other's, where the other is near and where it is far.
    let mut feet = Points::new(DVec3::ZERO);
    feet.push(glam::Vec3::new(0.2, 0.0, 0.0));
    feet.push(glam::Vec3::new(-0.8, 0.0, 0.0));
    let share = |time: f64| -> [f32; 2] {
        let mut out = [[0.0; 3]; BATCH];
        morph.colour(time).sampler().sample(&feet, &mut out);
        let distance = |a: LinearRgb, b: LinearRgb| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>().sqrt();
        std::array::from_fn(|i| 1.0 - distance(out[i], PINK) / distance(YELLOW, PINK))
    };
    let shares = [0.0, 0.25, 0.5, 1.0].map(share);
    assert!(shares[0].iter().all(|share| share.abs() < 1e-6));
    assert!(shares[1..].iter().all(|[near, far]| near > far), "{shares:?}");
    assert!(shares.windows(2).all(|two| two[1][0] > two[0][0] && two[1][1] > two[0][1]), "{shares:?}");
}

fn points_outside(aabb: &Aabb) -> impl Iterator<Item = DVec3> {
    let points = (0..20).map(|seed| random_points(seed, 2.0));
    points.flat_map(|points| (0..BATCH).map(move |i| points.position(i))).filter(|position| !aabb.contains(*position))
}

/// A ball that moves without changing, and balls around one centre: the farthest that their surfaces go is known.
#[test]
fn the_surfaces_farthest_way() {
    let ball = || Exact::ball(0.0, 0.7);
    let way = || Motion::moving(|time| Similarity::new(1.0, DVec3::ZERO, DVec3::X * time).expect("sound"));
    let moving = Morph::new(object(ball(), YELLOW, way()), object(ball(), PINK, way()), Settings::default());
    let moving = moving.expect("a morph");
    let cell = moving.plan().grid.edge();
    for (from, to, wanted) in [(0.3, 0.4, 0.1), (0.4, 0.9, 0.5), (0.9, 0.9, 0.0)] {
        let found = moving.displacement(from, to);
        assert!((found - wanted).abs() < 0.2 * cell, "{found} for {wanted}");
    }
    let growing = morph_with(Exact::ball(0.0, 0.5), Exact::ball(0.0, 0.9), Settings::default());
    let radius = |time: f64| {
        let field = growing.field(time);
        (0..9000).map(|i| f64::from(i) * 1e-4).find(|x| field.reference(DVec3::X * *x) < 0.0).unwrap_or(0.9)
    };
    let cell = growing.plan().grid.edge();
    for (from, to) in [(0.0, 0.2), (0.2, 0.7), (0.7, 1.0)] {
        let (found, wanted) = (growing.displacement(from, to), radius(to) - radius(from));
        assert!((found - wanted).abs() < 0.2 * cell, "{found} for {wanted}");
    }
    // Two that lie apart, one shrinking as the other grows: two pieces on the way.
    let bridge = OverTime::still(0.05);
    let apart = morph_with(Exact::ball(-1.0, 0.5), Exact::ball(1.0, 0.5), flow(Volume { bridge, ..Volume::default() }));
    let pieces: Vec<usize> = apart.report(&[0.0, 0.5, 1.0]).frames.iter().map(|frame| frame.pieces).collect();
    assert_eq!(pieces, [1, 2, 1]);
}

#[test]
fn the_same_bits_on_one_thread_and_two() {
    let plan = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let morph = morph_with(Exact::cube(-0.5, 0.5), Exact::torus(0.8, 0.3), Settings::default());
            (morph.plan().clone(), shown(&morph, 0.37), morph.report(&frames(5)))
        })
    };
    let (one, two) = (plan(1), plan(2));
    assert!(one == two);
}

#[test]
fn a_plan_outlives_its_morph() {
    let (from, to) = (still(Exact::cube(-0.4, 0.5), YELLOW), still(Exact::torus(0.8, 0.3), PINK));
    let text = serde_json::to_string(usual().plan()).expect("written");
    let plan = serde_json::from_str(&text).expect("read");
    let again = Morph::with_plan(from, to, Settings::default(), plan).expect("a morph");
    assert_eq!(usual().plan(), again.plan());
    assert_eq!(shown(usual(), 0.61), shown(&again, 0.61));
}

#[test]
fn settings_out_of_range_are_refused_by_name() {
    let refused = |settings: Settings| settings.check().expect_err("refused").to_string();
    assert!(refused(flow(Volume { bridge: 0.0.into(), ..Volume::default() })).contains("bridge is 0"));
    assert!(
        refused(Settings { beta: 1.5.into(), ..Settings::default() })
            .contains("beta is 1.5; it must lie between 0 and 1")
    );
    assert!(refused(Settings { alpha: f64::NAN.into(), ..Settings::default() }).contains("alpha"));
    assert!(refused(Settings { over: [1.0, 0.5], ..Settings::default() }).contains("must end after it starts"));
    let volume = OverTime::moving(|time| 1.0 + time);
    assert!(refused(flow(Volume { volume, ..Volume::default() })).contains("it must be 1"));
    assert!(refused(paper(Numbers { a: [1.0, 0.0, 1.0, 1.0], ..Numbers::default() })).contains("a1 is 0"));
}

#[test]
fn colour_runs_from_one_object_to_the_other() {
    let settings = Settings { colour_space: ColourSpace::Rgb, ..Settings::default() };
    let morph = morph_with(Exact::cube(0.0, 0.5), Exact::ball(0.0, 0.6), settings);
    let points = random_points(9, 0.8);
    let mean = |time: f64| {
        let mut colours = [[0.0; 3]; BATCH];
        morph.colour(time).sampler().sample(&points, &mut colours);
        let within =
            |c: &LinearRgb| (0..3).all(|i| (YELLOW[i].min(PINK[i])..=YELLOW[i].max(PINK[i]) + 1e-6).contains(&c[i]));
        assert!(colours.iter().all(within));
        colours.iter().map(|colour| colour[1]).sum::<f32>() / BATCH as f32
    };
    let greens = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0].map(mean);
    assert!(greens.windows(2).all(|two| two[1] < two[0]), "{greens:?}");
}
