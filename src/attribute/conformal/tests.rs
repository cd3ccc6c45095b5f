//! Interior distances against exact ones: of polygons by the ways along their corners, of rings and shells by tangents and
//! arcs, of convex bodies straight.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec2, DVec3};

use super::accuracy::{HALF, ball, ell, exact, extruded, polygon, prism, sampled, way_around, you};
use super::{Body, Conformal, Ease, Error, Feature, Goal, Interior, Member, Method, Nearest, Zones};
use crate::attribute::{Attribute, Constant, Straight};
use crate::field::tests::Samples;
use crate::field::{Aabb, Expression, Field, Graph};

/// The shortest way inside of a polygon: along its corners, by the ways between those that see each other.
fn way_in_polygon(corners: &[DVec2], from: DVec2, to: DVec2) -> f64 {
    let sees =
        |a: DVec2, b: DVec2| (1..400).all(|step| polygon(corners, a + (b - a) * (f64::from(step) / 400.0)) > -1e-6);
    let mut stops = vec![to];
    stops.extend(corners);
    let mut ways: Vec<f64> =
        stops.iter().map(|stop| if sees(from, *stop) { from.distance(*stop) } else { f64::INFINITY }).collect();
    for _ in 0..4 {
        for i in 1..stops.len() {
            for j in 0..stops.len() {
                let over = ways[i] + stops[i].distance(stops[j]);
                if over < ways[j] && sees(stops[i], stops[j]) {
                    ways[j] = over;
                }
            }
        }
    }
    ways[0]
}

fn never() -> AtomicBool {
    AtomicBool::new(false)
}

fn body(field: &Arc<dyn Field>, along: u32) -> Arc<Body> {
    let body = Body::new(Arc::clone(field), Arc::clone(field), field.bounding_box().unwrap(), along, &never());
    Arc::new(body.expect("a body"))
}

/// A feature with a value.
fn valued(feature: &Arc<Feature>, value: f32) -> Member<1> {
    (Arc::clone(feature), Arc::new(Constant::new([value])))
}

fn feature(body: &Body, field: Arc<dyn Field>) -> Arc<Feature> {
    Arc::new(Feature::new(body, field, &Method::Sight, &never()).expect("a feature"))
}

fn distances(body: &Arc<Body>, feature: &Arc<Feature>, positions: &[DVec3]) -> Vec<f64> {
    let interior = Interior::new(Arc::clone(body), vec![Goal::Feature(Arc::clone(feature))]);
    sampled(&interior, positions).into_iter().map(|[value]| f64::from(value)).collect()
}

/// Points of a field's inside.
fn inside(field: &dyn Field, count: usize) -> Vec<DVec3> {
    let (mut samples, aabb) = (Samples::new(31), field.bounding_box().unwrap());
    let mut all = Vec::new();
    while all.len() < count {
        let p = samples.within(&aabb);
        if field.reference(p) > 0.0 {
            all.push(p);
        }
    }
    all
}

/// The mean and the greatest error of interior distances from a small ball at `from`, in cells; `way` is the exact way
/// to its middle.
fn errors(field: &Arc<dyn Field>, along: u32, from: DVec3, way: impl Fn(DVec3) -> f64) -> (f64, f64) {
    const RADIUS: f64 = 0.02;
    let body = body(field, along);
    let feature = feature(&body, ball(from, RADIUS));
    assert!(!feature.is_outside && feature.apart.is_empty());
    let positions = inside(field.as_ref(), 300);
    let found = distances(&body, &feature, &positions);
    let (mut sum, mut greatest) = (0.0, 0.0f64);
    for (found, p) in found.iter().zip(&positions) {
        let error = (found - (way(*p) - RADIUS).max(0.0)).abs() / body.edge();
        sum += error;
        greatest = greatest.max(error);
    }
    let mean = sum / positions.len() as f64;
    eprintln!("{along} cells: mean {mean:.3}, greatest {greatest:.3}");
    (mean, greatest)
}

fn errors_in_polygon(outline: Vec<DVec2>, along: u32, from: DVec3) -> (f64, f64) {
    let way = {
        let outline = outline.clone();
        move |p: DVec3| way_in_polygon(&outline, from.truncate(), p.truncate()).hypot(p.z - from.z)
    };
    errors(&prism(outline), along, from, way)
}

#[test]
fn around_one_corner() {
    for along in [32, 64] {
        let (mean, greatest) = errors_in_polygon(ell(), along, DVec3::new(1.8, 0.4, 0.03));
        assert!(mean < 0.4 && greatest < 1.65, "{along}: {mean}, {greatest}");
    }
}

#[test]
fn around_two_corners() {
    for along in [32, 64] {
        let (mean, greatest) = errors_in_polygon(you(0.5), along, DVec3::new(0.2, 1.4, -0.05));
        assert!(mean < 0.4 && greatest < 1.8, "{along}: {mean}, {greatest}");
    }
}

/// Two arms that are nearer to each other than a cell do not leak.
#[test]
fn arms_side_by_side_stay_apart() {
    let edge = 1.6 / 48.0;
    for gap in [0.3, 0.7, 1.0] {
        let (mean, greatest) = errors_in_polygon(you(gap * edge), 48, DVec3::new(0.2, 1.4, 0.0));
        assert!(mean < 0.4 && greatest < 1.8, "{gap} cells: {mean}, {greatest}");
    }
}

#[test]
fn around_a_hole() {
    let from = DVec3::new(-0.75, 0.1, 0.0);
    let aabb = Aabb::new(DVec3::new(-1.0, -1.0, -HALF), DVec3::new(1.0, 1.0, HALF));
    let ring = exact(aabb, |p| {
        let far = p.truncate().length();
        extruded((1.0 - far).min(far - 0.5), p.z, HALF)
    });
    for along in [32, 64] {
        let way = |p: DVec3| way_around(0.5, from.truncate(), p.truncate()).hypot(p.z - from.z);
        let (mean, greatest) = errors(&ring, along, from, way);
        assert!(mean < 0.4 && greatest < 2.0, "{along}: {mean}, {greatest}");
    }
}

#[test]
fn around_a_hollow() {
    let from = DVec3::new(-0.5, 0.3, 0.5);
    let shell = exact(Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)), |p| (1.0 - p.length()).min(p.length() - 0.6));
    for along in [24, 40] {
        // In the plane of both and the middle.
        let way = |p: DVec3| {
            let angle = (from.dot(p) / (from.length() * p.length())).clamp(-1.0, 1.0).acos();
            way_around(0.6, DVec2::X * from.length(), DVec2::from_angle(angle) * p.length())
        };
        let (mean, greatest) = errors(&shell, along, from, way);
        assert!(mean < 0.5 && greatest < 2.0, "{along}: {mean}, {greatest}");
    }
}

fn cube() -> Arc<dyn Field> {
    exact(Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)), |p| {
        let beside = p.abs() - 1.0;
        -beside.max(DVec3::ZERO).length() - beside.max_element().min(0.0)
    })
}

#[test]
fn in_a_convex_body_ways_are_straight() {
    let (cube, at) = (cube(), [DVec3::new(-0.6, 0.2, 0.1), DVec3::new(0.5, -0.3, 0.4)]);
    let body = body(&cube, 24);
    let features = at.map(|at| feature(&body, ball(at, 0.15)));
    let positions = inside(cube.as_ref(), 400);
    for (feature, at) in features.iter().zip(at) {
        for (found, p) in distances(&body, feature, &positions).into_iter().zip(&positions) {
            assert!((found - (p.distance(at) - 0.15).max(0.0)).abs() < 1e-5, "{p}: {found}");
        }
    }
    let apart = at[0].distance(at[1]) - 0.3;
    let both = [features[0].as_ref(), features[1].as_ref()];
    for (spread, ease) in [(1.0, Ease::Linear), (0.5, Ease::Linear), (0.5, Ease::Smooth)] {
        let members = features.iter().zip([0.0, 1.0]).map(|(feature, value)| valued(feature, value)).collect();
        let zones = Zones::new(&body, &both, spread, ease);
        let conformal = Conformal::new(Arc::clone(&body), members, zones, vec![Straight]);
        for ([found], p) in sampled(&conformal, &positions).into_iter().zip(&positions) {
            let [one, two] = at.map(|at| (p.distance(at) - 0.15).max(0.0));
            let share = ((one - two + spread * apart) / (2.0 * spread * apart)).clamp(0.0, 1.0);
            let wanted = match ease {
                Ease::Linear => share,
                Ease::Smooth => share * share * (3.0 - 2.0 * share),
            };
            assert!((f64::from(found) - wanted).abs() < 1e-5, "{p}: {found}, {wanted}");
        }
    }
}

#[test]
fn a_narrow_spread_gives_cells() {
    let (cube, at) = (cube(), [DVec3::new(-0.6, 0.2, 0.1), DVec3::new(0.5, -0.3, 0.4), DVec3::new(0.1, 0.7, -0.5)]);
    let body = body(&cube, 24);
    let features = at.map(|at| feature(&body, ball(at, 0.1)));
    let positions = inside(cube.as_ref(), 400);
    let cells = sampled(&Nearest { body: Arc::clone(&body), features: features.to_vec() }, &positions);
    let members = features.iter().zip([0.0, 1.0, 2.0]).map(|(feature, value)| valued(feature, value));
    let zones = Zones::new(&body, &[&features[0], &features[1], &features[2]], 1e-6, Ease::Linear);
    let sharp = Conformal::new(Arc::clone(&body), members.collect(), zones, vec![Straight; 2]);
    let mut apart = 0;
    for (([cell], [sharp]), p) in cells.into_iter().zip(sampled(&sharp, &positions)).zip(&positions) {
        let mut ways = at.map(|at| p.distance(at));
        assert_eq!(ways[cell as usize], ways.into_iter().fold(f64::INFINITY, f64::min));
        ways.sort_by(f64::total_cmp);
        // Zones are no narrower than a cell.
        if ways[1] - ways[0] > body.edge() {
            assert_eq!(cell, sharp, "{p}");
            apart += 1;
        }
    }
    assert!(apart > 300);
}

#[test]
fn distances_are_a_metric() {
    let field = prism(you(0.5));
    let body = body(&field, 48);
    let positions = inside(field.as_ref(), 24);
    let features: Vec<_> = positions.iter().take(6).map(|p| feature(&body, ball(*p, 0.01))).collect();
    let from: Vec<_> = features.iter().map(|feature| distances(&body, feature, &positions)).collect();
    let cell = body.edge();
    for i in 0..6 {
        for j in 0..6 {
            assert!((from[i][j] - from[j][i]).abs() < 0.5 * cell, "{i}, {j}: {} and {}", from[i][j], from[j][i]);
        }
        for p in 0..positions.len() {
            for q in 0..p {
                let way = way_in_polygon(&you(0.5), positions[p].truncate(), positions[q].truncate());
                let way = way.hypot(positions[p].z - positions[q].z);
                assert!((from[i][p] - from[i][q]).abs() <= way + cell, "{i}: {p}, {q}");
            }
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let field = prism(ell());
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let body = body(&field, 40);
            let feature = feature(&body, ball(DVec3::new(1.8, 0.3, 0.0), 0.05));
            distances(&body, &feature, &inside(field.as_ref(), 500))
        })
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
}

/// What is thinner than a cell holds nodes, and ways along it are right.
#[test]
fn a_sheet_thinner_than_a_cell() {
    // Half as thick; the cells are 0.06 long.
    for half in [0.004, 0.0004, 0.0001] {
        let aabb = Aabb::new(DVec3::new(-1.0, -1.0, 0.003 - half), DVec3::new(1.0, 1.0, 0.003 + half));
        let sheet = exact(aabb, move |p| extruded((1.0 - p.x.abs()).min(1.0 - p.y.abs()), p.z - 0.003, half));
        let body = body(&sheet, 32);
        let from = DVec3::new(-0.9, -0.8, 0.003);
        let feature = feature(&body, ball(from, 0.02));
        assert!(!feature.is_outside && feature.apart.is_empty(), "{:?}", feature.apart);
        let mut samples = Samples::new(3);
        let positions: Vec<DVec3> = (0..200).map(|_| samples.within(&aabb).truncate().extend(0.003)).collect();
        for (found, p) in distances(&body, &feature, &positions).into_iter().zip(&positions) {
            assert!((found - (p.distance(from) - 0.02)).abs() < 0.2 * body.edge(), "{half}, {p}: {found}");
        }
    }
}

#[test]
fn outside_of_the_body_the_nearest_surface_counts() {
    let ball_body = ball(DVec3::ZERO, 1.0);
    let body = body(&ball_body, 24);
    let feature = feature(&body, ball(DVec3::new(0.5, 0.0, 0.0), 0.1));
    let mut samples = Samples::new(3);
    let directions: Vec<DVec3> =
        (0..100).map(|_| samples.within(&Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0))).normalize()).collect();
    let on: Vec<f64> = distances(&body, &feature, &directions);
    for far in [1.01, 1.1, 2.0, 9.0] {
        let there: Vec<DVec3> = directions.iter().map(|direction| *direction * far).collect();
        for (there, on) in distances(&body, &feature, &there).into_iter().zip(&on) {
            assert!((there - on).abs() < 1e-4, "{far}: {there}, {on}");
        }
    }
}

/// A feature outside: straight to the surface, then inside. In a convex body that is straight.
#[test]
fn a_feature_outside() {
    let field = ball(DVec3::ZERO, 1.0);
    let body = body(&field, 32);
    let at = DVec3::new(1.6, 0.3, 0.0);
    let feature = feature(&body, ball(at, 0.2));
    assert!(feature.is_outside && feature.apart.is_empty());
    let positions = inside(field.as_ref(), 200);
    for (found, p) in distances(&body, &feature, &positions).into_iter().zip(&positions) {
        assert!((found - (p.distance(at) - 0.2)).abs() < body.edge(), "{p}: {found}");
    }
    // On the wall it is partly inside, as long as a cell of it is.
    for at in [1.0, 1.15] {
        assert!(!self::feature(&body, ball(DVec3::X * at, 0.2)).is_outside, "{at}");
    }
}

/// What no way inside leads to is reached through the air.
#[test]
fn a_piece_without_the_feature() {
    let aabb = Aabb::new(DVec3::new(-1.5, -0.5, -0.5), DVec3::new(1.5, 0.5, 0.5));
    let pair = exact(aabb, |p| 0.5 - p.distance(DVec3::X).min(p.distance(-DVec3::X)));
    let body = body(&pair, 48);
    let at = DVec3::new(-1.0, 0.2, 0.0);
    let feature = feature(&body, ball(at, 0.1));
    let [piece] = feature.apart[..] else { panic!("{:?}", feature.apart) };
    assert!(piece.at.distance(DVec3::X) < 0.2 && piece.nodes > 1000, "{piece:?}");
    let positions = inside(pair.as_ref(), 300);
    for (found, p) in distances(&body, &feature, &positions).into_iter().zip(&positions) {
        assert!((found - (p.distance(at) - 0.1).max(0.0)).abs() < body.edge(), "{p}: {found}");
    }
}

#[test]
fn the_own_surface_as_a_goal_is_the_depth() {
    let cube = cube();
    let body = body(&cube, 16);
    let interior = Interior::new(Arc::clone(&body), vec![Goal::Surface]);
    let positions = inside(cube.as_ref(), 200);
    for ([found], p) in sampled(&interior, &positions).into_iter().zip(&positions) {
        assert!((f64::from(found) - (1.0 - p.abs().max_element())).abs() < 1e-6);
    }
    let [bounds] = interior.sampler().bounds(&Aabb::new(DVec3::ZERO, DVec3::ONE));
    assert!(bounds.lo == 0.0 && bounds.hi > 0.99 && bounds.hi < 1.5, "{bounds:?}");
}

#[test]
fn what_cannot_be_spread_is_an_error() {
    let cube = cube();
    let body = body(&cube, 16);
    let mut graph = Graph::new();
    let before = graph.affine(-DVec3::X, 0.5);
    let root = graph.sqrt(before);
    let outside = graph.neg(root);
    let nowhere: Arc<dyn Field> = Arc::new(Expression::new(&graph, outside));
    let Err(Error::NotANumber(at)) = Feature::new(&body, nowhere, &Method::Sight, &never()) else { panic!("a number") };
    assert!(at.x > 0.5);
    let stop = AtomicBool::new(true);
    assert_eq!(Body::new(Arc::clone(&cube), Arc::clone(&cube), body.aabb(), 16, &stop).err(), Some(Error::Cancelled));
    let empty = exact(body.aabb(), |_| -9.0);
    assert_eq!(Body::new(Arc::clone(&empty), empty, body.aabb(), 16, &never()).err(), Some(Error::Empty));
    assert!(matches!(
        Body::new(Arc::clone(&cube), cube, Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0)), 512, &never()),
        Err(Error::TooMany { .. })
    ));
    assert!(body.admit(64).is_ok() && matches!(body.admit(1 << 20), Err(Error::TooMany { .. })));
}

/// Features with the same place share it: the later counts inside of both, and both alike elsewhere.
#[test]
fn two_features_at_one_place() {
    let cube = cube();
    let body = body(&cube, 24);
    let features = [0.2, 0.2].map(|radius| feature(&body, ball(DVec3::ZERO, radius)));
    let members = features.iter().zip([0.0, 1.0]).map(|(feature, value)| valued(feature, value));
    let zones = Zones::new(&body, &[&features[0], &features[1]], 1.0, Ease::Linear);
    let both = Conformal::new(Arc::clone(&body), members.collect(), zones, vec![Straight]);
    assert_eq!(sampled(&both, &[DVec3::ZERO, DVec3::new(0.5, 0.1, 0.0)]), [[1.0], [0.5]]);
}

/// Across the gap of a U, between its arms, what the nearest places have jumps; averaged it does not, and is the same inside
/// and at the surface.
#[test]
fn outside_it_can_go_without_jumps() {
    let field = prism(you(0.5));
    let body = body(&field, 48);
    let features = [[0.2, 1.4, 0.0], [1.1, 1.4, 0.0]].map(|at| feature(&body, ball(DVec3::from(at), 0.05)));
    let zones = || Zones::new(&body, &[&features[0], &features[1]], 1.0, Ease::Linear);
    let members = || features.iter().zip([0.0, 1.0]).map(|(feature, value)| valued(feature, value)).collect();
    let weights = || Conformal::new(Arc::clone(&body), members(), zones(), vec![Straight]);
    let ways = || Interior::new(Arc::clone(&body), vec![Goal::Feature(Arc::clone(&features[0]))]);
    let across: Vec<DVec3> = (0..=600).map(|i| DVec3::new(0.35 + f64::from(i) * 1e-3, 1.2, 0.0)).collect();
    let leap = |attribute: &dyn Attribute<1>| {
        let found = sampled(attribute, &across);
        found.array_windows().map(|[[one], [two]]| (one - two).abs()).fold(0.0, f32::max)
    };
    let [weight, way] = [leap(&weights()), leap(&ways())];
    assert!(weight > 0.8 && way > 2.0, "{weight}, {way}");
    let [weight, way] = [leap(&weights().smooth()), leap(&ways().smooth())];
    assert!(weight < 0.02 && way < 0.05, "{weight}, {way}");
    let mut here = inside(field.as_ref(), 200);
    here.extend([0.4 - 1e-9, 0.4, 0.4 + 1e-6].map(|x| DVec3::new(x, 1.2, 0.0)));
    for (one, two) in sampled(&weights(), &here).into_iter().zip(sampled(&weights().smooth(), &here)) {
        assert!((one[0] - two[0]).abs() < 1e-5, "{one:?} {two:?}");
    }
    // Far away, where there is no lattice.
    for [value] in sampled(&weights().smooth(), &[DVec3::splat(1e6), DVec3::splat(-50.0)]) {
        assert!((0.0..=1.0).contains(&value), "{value}");
    }
}
