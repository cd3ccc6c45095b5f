//! The promises of a carried morph, on exact shapes.

use std::sync::Arc;

use glam::{DMat3, DVec3, Vec3};

use super::exact::Exact;
use super::tests::{YELLOW, frames, object, random_points, still};
use super::turn::{turn, vector_near};
use super::*;
use crate::field::{BATCH, Field, Gradients, Points};

fn carrying(carry: Carry) -> Settings {
    Settings { carry, ..Settings::default() }
}

fn carried(from: &Arc<Exact>, to: &Arc<Exact>, carry: Carry) -> Morph {
    carried_by(from, to, carrying(carry))
}

fn carried_by(from: &Arc<Exact>, to: &Arc<Exact>, settings: Settings) -> Morph {
    let [from, to] = [from, to].map(|exact| still(exact.clone(), YELLOW));
    Morph::new(from, to, settings).expect("a morph")
}

fn refused(from: &Arc<Exact>, to: &Arc<Exact>, anchors: &[[DVec3; 2]]) -> Error {
    let [from, to] = [from, to].map(|exact| still(exact.clone(), YELLOW));
    Morph::new(from, to, carrying(Carry::Anchors(anchors.to_vec()))).err().expect("it is refused")
}

fn values(field: &dyn Field, points: &Points) -> [f32; BATCH] {
    let mut values = [0.0; BATCH];
    field.evaluator().values(points, &mut values);
    values
}

fn brick(x: f64, half: [f64; 3]) -> Arc<Exact> {
    Exact::block(x, DVec3::from(half))
}

#[test]
fn ends_are_the_objects_where_they_are() {
    let (from, to) = (brick(-2.0, [0.6, 0.3, 0.2]), brick(1.5, [0.2, 0.4, 0.7]));
    let anchors = vec![[DVec3::new(-1.4, 0.0, 0.0), DVec3::new(1.5, 0.4, 0.7)], [DVec3::X * -2.0, DVec3::X * 1.5]];
    let points = random_points(1, 3.0);
    for carry in [Carry::Centroid, Carry::Inertia, Carry::Anchors(anchors)] {
        let morph = carried(&from, &to, carry);
        for (time, own) in [(-0.5, &from), (0.0, &from), (1.0, &to), (2.0, &to)] {
            assert_eq!(values(morph.field(time).as_ref(), &points), values(own.as_ref(), &points));
            assert_eq!(values(morph.moving_field(time).as_ref(), &points), values(own.as_ref(), &points));
        }
        assert!(morph.report(&frames(9)).frames.iter().all(|frame| frame.pieces == 1));
    }
}

#[test]
fn a_frame_alone_is_that_of_the_sequence_on_any_threads() {
    let (from, to) = (brick(-2.0, [0.6, 0.3, 0.2]), brick(1.5, [0.2, 0.4, 0.7]));
    let points = random_points(2, 3.0);
    let of = |threads: usize, times: &[f64]| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| {
            let morph = carried(&from, &to, Carry::Inertia);
            let last = times.iter().map(|time| values(morph.field(*time).as_ref(), &points)).next_back();
            (morph.plan().clone(), last)
        })
    };
    assert!(of(2, &[0.1, 0.3, 0.2, 0.6]) == of(1, &[0.6]));
}

/// A ball that becomes another is one that goes over, by as much in each frame, and all of it moves alike.
#[test]
fn a_ball_becomes_the_same_ball_elsewhere() {
    let (from, to) = (Exact::ball(-2.0, 0.5), Exact::ball(1.0, 0.5));
    let morph = carried(&from, &to, Carry::Centroid);
    let middle = |time: f64| DVec3::X * (-2.0 + 3.0 * time);
    for time in [0.1, 0.45, 0.9] {
        let (field, moved) = (morph.field(time), Exact::ball(middle(time).x, 0.5));
        for direction in (0..200).map(|seed| random_points(seed, 1.0).position(7).normalize()) {
            for off in [-1e-3, 1e-3] {
                let place = middle(time) + direction * (0.5 - off);
                assert_eq!(field.reference(place) > 0.0, moved.reference(place) > 0.0, "{off} off at {time}");
            }
        }
    }
    assert!((morph.displacement(0.3, 0.5) - 0.6).abs() < 0.2 * morph.plan().grid.edge());
    for (velocity, _) in velocities(&morph, 0.45, 1e-2) {
        assert!(velocity.distance(DVec3::X * 3.0) < 1e-3, "{velocity}");
    }
}

/// Bricks of one size turn and move over as one rigid brick.
#[test]
fn a_brick_turns_to_the_other() {
    let (from, to) = (brick(-1.5, [0.8, 0.3, 0.15]), brick(1.5, [0.3, 0.8, 0.15]));
    let own = brick(0.0, [0.8, 0.3, 0.15]);
    // Two of the same brick: lengthwise along x, and along y; the shorter way is a quarter turn about z.
    let anchors = [[-1.5, 0.0, 0.0], [-0.7, 0.0, 0.0], [-1.5, 0.3, 0.0]].map(DVec3::from);
    let then = [[1.5, 0.0, 0.0], [1.5, 0.8, 0.0], [1.2, 0.0, 0.0]].map(DVec3::from);
    let pairs: Vec<[DVec3; 2]> = anchors.into_iter().zip(then).map(|(from, to)| [from, to]).collect();
    for carry in [Carry::Inertia, Carry::Anchors(pairs.clone()), Carry::Anchors(pairs[..2].to_vec())] {
        let morph = carried(&from, &to, carry.clone());
        let by_centre = !matches!(&carry, Carry::Anchors(_));
        for time in [0.25, 0.5, 0.8] {
            let turned = turn(DVec3::Z * (std::f64::consts::FRAC_PI_2 * time));
            let (centres, count) = match &carry {
                Carry::Anchors(pairs) => (pairs.iter().map(|pair| pair[0]).sum::<DVec3>(), pairs.len() as f64),
                _ => (DVec3::X * -1.5, 1.0),
            };
            let ends = match &carry {
                Carry::Anchors(pairs) => pairs.iter().map(|pair| pair[1]).sum::<DVec3>() / count,
                _ => DVec3::X * 1.5,
            };
            let centre = centres / count;
            let there = centre.lerp(ends, time);
            let field = morph.field(time);
            for position in (0..BATCH).map(|i| random_points(5, 1.0).position(i)) {
                let inside = own.reference(position);
                let world = there + turned * (position + DVec3::X * -1.5 - centre);
                let close = if by_centre { 2e-3 } else { 1e-4 };
                assert!(
                    inside.abs() < close || (inside > 0.0) == (field.reference(world) > 0.0),
                    "{carry:?} is wrong at {position}, {inside} inside, at {time}"
                );
            }
        }
    }
}

/// Velocities of surface points by scene time, from instants so far away, and where the points lie.
fn velocities(morph: &Morph, time: f64, step: f64) -> Vec<(DVec3, DVec3)> {
    let around = Instant::around(step, None).into_iter().map(|instant| Around {
        instant,
        field: morph.moving_field(time + instant.seconds),
        own: morph.own_way(time, time + instant.seconds),
    });
    let movement =
        Movement { around: around.collect(), given: None, max_speed: 1e3, max_change: 1e3, frame_seconds: 0.04 };
    let field = morph.field(time);
    let extent = field.bounding_box().expect("a box");
    let (mut points, mut gradients) = (Points::new(extent.centre()), Gradients::new());
    for i in 0..BATCH {
        points.push((random_points(3, 0.5).position(i) * extent.size()).as_vec3());
    }
    let mut evaluator = field.evaluator();
    for _ in 0..40 {
        evaluator.gradients(&points, &mut gradients);
        for i in 0..BATCH {
            let gradient = gradients.gradient(i);
            let step = gradient * (gradients.value[i] / gradient.length_squared().max(1e-12));
            let place = points.offset(i) - step.clamp_length_max(0.1);
            (points.x[i], points.y[i], points.z[i]) = place.into();
        }
    }
    evaluator.gradients(&points, &mut gradients);
    let outward: Vec<Vec3> = (0..BATCH).map(|i| -gradients.gradient(i).normalize_or_zero()).collect();
    let (mut found, mut held) = ([[0.0; 3]; BATCH], [false; BATCH]);
    movement.meter(0.002).velocities(&points, &outward, &mut found, &mut held);
    let on = |i: &usize| gradients.value[*i].abs() < 1e-5 * gradients.gradient(*i).length() && !held[*i];
    let found = |i: usize| (Vec3::from(found[i]).as_dvec3(), points.position(i));
    let all: Vec<(DVec3, DVec3)> = (0..BATCH).filter(on).map(found).collect();
    assert!(all.len() > BATCH / 4, "{} points on the surface", all.len());
    all
}

/// Points of a surface that is carried, turned and blended, moved by their velocities for a little while, lie on the
/// surface that there is then: nearer than by what bends within that while.
#[test]
fn velocities_are_those_of_the_frames_around() {
    let (from, to) = (brick(-2.0, [0.8, 0.3, 0.2]), brick(1.5, [0.25, 0.35, 0.9]));
    let morph = carried(&from, &to, Carry::Inertia);
    for time in [0.3, 0.6] {
        let left = |step: f64| {
            let later = morph.field(time + step);
            let mut left: Vec<f64> = velocities(&morph, time, 1e-3)
                .into_iter()
                .map(|(velocity, place)| distance_to(later.as_ref(), place + velocity * step))
                .collect();
            left.sort_by(f64::total_cmp);
            left[left.len() / 2]
        };
        let (coarse, fine) = (left(0.02), left(0.005));
        assert!(coarse < 0.005 && fine < coarse / 8.0, "{coarse} off, {fine} off in a quarter of the time, at {time}");
    }
}

/// How far a place is from F = 0, along the gradient.
fn distance_to(field: &dyn Field, from: DVec3) -> f64 {
    let (mut place, mut gradients) = (from, Gradients::new());
    let mut evaluator = field.evaluator();
    for _ in 0..8 {
        let mut points = Points::new(place);
        points.push(Vec3::ZERO);
        evaluator.gradients(&points, &mut gradients);
        let gradient = gradients.gradient(0).as_dvec3();
        place -= gradient * f64::from(gradients.value[0]) / gradient.length_squared().max(1e-12);
    }
    place.distance(from)
}

/// What carries is no change: apart and carried, a pair has the D, t and a₀ that it has where its centres lie together; and
/// so it has where all of it moves besides.
#[test]
fn a_way_changes_no_pace() {
    let together = carried(&Exact::cube(0.0, 0.5), &Exact::ball(0.0, 0.4), Carry::None);
    let apart = carried(&Exact::cube(-1.5, 0.5), &Exact::ball(2.0, 0.4), Carry::Centroid);
    let expected = together.report(&frames(12));
    let close = |found: &Morph, why: &str| {
        assert!((found.plan().unit / together.plan().unit - 1.0).abs() < 1e-9, "{why}");
        for (found, expected) in found.report(&frames(12)).frames.iter().zip(&expected.frames) {
            assert!((found.t - expected.t).abs() < 1e-3, "{why}: t = {} for {} at {}", found.t, expected.t, found.time);
            assert!((found.a0 - expected.a0).abs() < 1e-3 * expected.a0.max(0.1), "{why}");
        }
    };
    close(&apart, "carried");
    let spin = |time: f64| Similarity::new(1.0, DVec3::new(0.0, 30.0, 500.0) * time, DVec3::Y * time).expect("sound");
    let moving = |exact: Arc<Exact>| object(exact, YELLOW, Motion::moving(spin));
    let settings = carrying(Carry::Centroid);
    let moved = Morph::new(moving(Exact::cube(-1.5, 0.5)), moving(Exact::ball(2.0, 0.4)), settings).expect("a morph");
    close(&moved, "carried and moved");
    // The frame is the one at rest, moved.
    for time in [0.2, 0.7] {
        let (here, there) = (moved.field(time), apart.field(time));
        for position in (0..40).map(|i| random_points(4, 2.0).position(i)) {
            let off = here.reference(spin(time).to_world(position)) - there.reference(position);
            assert!(off.abs() < 5e-3, "F is off by {off} at {time}");
        }
    }
}

/// The turn of objects that turn on and on against each other goes on too, and does not jump to the other way round.
#[test]
fn a_turn_is_followed_past_half_a_turn() {
    let spin = |time: f64| Similarity::new(1.0, DVec3::Z * 700.0 * time, DVec3::ZERO).expect("sound");
    let from = object(brick(-2.0, [0.8, 0.3, 0.2]), YELLOW, Motion::default());
    let to = object(brick(0.0, [0.9, 0.25, 0.2]), YELLOW, Motion::moving(spin));
    let morph = Morph::new(from, to.clone(), carrying(Carry::Inertia)).expect("a morph");
    let placed = |time: f64| morph.to.motion.at(time).rotation();
    let mut before = DVec3::ZERO;
    for step in 1..=400 {
        let time = f64::from(step) / 400.0;
        let now = vector_near(&(placed(time) * placed(0.0).transpose()), before);
        // The turn itself is as fast as 700 degrees in all; eased over both it is at most twice as fast.
        assert!(now.distance(before) < 2.0 * 700f64.to_radians() / 400.0, "{before} to {now} at {time}");
        before = now;
    }
    assert_eq!(morph.to.motion.at(1.0), to.motion.at(1.0));
}

#[test]
fn centres_and_axes_are_those_of_the_volume() {
    use super::inertia::{Axes, Inertia};
    let two = Exact::Apart(vec![
        Exact::Block { centre: DVec3::new(-1.0, 0.0, 0.0), half: DVec3::splat(0.4) },
        Exact::Block { centre: DVec3::new(1.0, 0.0, 0.0), half: DVec3::splat(0.2) },
    ]);
    let found = Inertia::of(&still(Arc::new(two), YELLOW)).expect("bounded");
    let (large, small) = (0.8f64.powi(3), 0.4f64.powi(3));
    assert!((found.centre.x - (small - large) / (small + large)).abs() < 2e-3, "{}", found.centre);
    assert!(matches!(found.axes, Axes::One { axis, place: 0 } if axis.x.abs() > 1.0 - 1e-9));
    let Axes::All(axes) = Inertia::of(&still(brick(0.3, [0.3, 0.9, 0.5]), YELLOW)).expect("bounded").axes else {
        panic!("a brick has three axes")
    };
    let wanted = DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X);
    (0..3).for_each(|i| assert!(axes.col(i).dot(wanted.col(i)).abs() > 1.0 - 1e-9, "{axes}"));
}

#[test]
fn what_no_axis_decides_is_not_turned_and_told() {
    let (rod, plate) = (brick(-2.0, [1.0, 0.2, 0.2]), brick(2.0, [0.2, 1.0, 1.0]));
    let turns = |morph: &Morph| morph.from.motion.at(0.5).rotation() != DMat3::IDENTITY;
    let ball = carried(&rod, &Exact::ball(2.0, 0.5), Carry::Inertia);
    assert_eq!(ball.untold(), [Untold::Axes(Side::To)]);
    assert!(!turns(&ball));
    let cubes = carried(&Exact::cube(-2.0, 0.5), &Exact::ball(2.0, 0.5), Carry::Inertia);
    assert_eq!(cubes.untold(), [Untold::Axes(Side::From), Untold::Axes(Side::To)]);
    let laid = carried(&rod, &plate, Carry::Inertia);
    assert_eq!(laid.untold(), [Untold::AboutAxis(Side::From), Untold::AboutAxis(Side::To)]);
    assert!(turns(&laid));
    let told = carried(&brick(-2.0, [0.9, 0.5, 0.2]), &brick(2.0, [0.2, 0.9, 0.5]), Carry::Inertia);
    assert!(told.untold().is_empty() && turns(&told));
    let half = [[DVec3::X * -2.5, DVec3::X * 2.1], [DVec3::X * -1.5, DVec3::X * 1.9]];
    assert_eq!(carried(&rod, &plate, Carry::Anchors(half.to_vec())).untold(), [Untold::HalfTurn]);
}

#[test]
fn anchors_that_tell_nothing_are_refused() {
    let (from, to) = (Exact::cube(-2.0, 0.5), Exact::cube(2.0, 0.5));
    let (a, b) = (DVec3::X * -2.0, DVec3::X * 2.0);
    let moved = |x: f64, y: f64| [a + DVec3::new(x, y, 0.0), b + DVec3::new(x, y, 0.0)];
    let outside = refused(&from, &to, &[[a, b], [a, DVec3::X * 2.6]]);
    assert_eq!(outside, Error::AnchorOutside { place: 1, side: Side::To });
    assert_eq!(refused(&from, &to, &[[b, b]]), Error::AnchorOutside { place: 0, side: Side::From });
    assert_eq!(refused(&from, &to, &[[a, b], [a, b + DVec3::Y * 0.3]]), Error::AnchorsAlike);
    assert_eq!(refused(&from, &to, &[moved(-0.3, -0.3), moved(0.1, 0.1), moved(0.4, 0.4)]), Error::AnchorsInLine);
    assert!(matches!(refused(&from, &to, &[]), Error::Setting { .. }));
    // On the surface, and one alone: no turn.
    let one = carried(&from, &to, Carry::Anchors(vec![moved(0.5, 0.5)]));
    assert_eq!(one.from.motion.at(0.5).rotation(), DMat3::IDENTITY);
}

/// The blend is the same as on the straight way, off it by the arc; along it by an easing of its own.
#[test]
fn an_arc_and_an_easing_of_the_way() {
    let of = |settings: Settings| carried_by(&Exact::cube(-1.5, 0.5), &Exact::ball(2.0, 0.4), settings);
    let arc = DVec3::new(0.3, -0.7, 1.2);
    let straight = of(carrying(Carry::Centroid));
    let bent = of(Settings { arc, ..carrying(Carry::Centroid) });
    let late = of(Settings { carry_ease: Some(Ease::Smooth), ..carrying(Carry::Centroid) });
    for time in [0.0, 0.25, 0.5, 0.9, 1.0] {
        let fields = [&straight, &bent, &late].map(|morph| morph.field(time));
        let off = arc * (4.0 * time * (1.0 - time));
        // The way leads 3.5 units along x.
        let behind = DVec3::X * 3.5 * (time * time * (3.0 - 2.0 * time) - time);
        for at in (0..40).map(|i| random_points(4, 2.0).position(i)) {
            let there = fields[0].reference(at);
            assert!((fields[1].reference(at + off) - there).abs() < 1e-5, "an arc at {time}");
            assert!((fields[2].reference(at + behind) - there).abs() < 1e-5, "an easing at {time}");
        }
    }
}
