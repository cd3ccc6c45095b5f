//! Parameters that are distances, of shapes whose F is not one: against exact answers.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;

use super::*;
use crate::distance::accuracy::compare;
use crate::shot::displace_tests::{assert_near, band_of, distance_to_box};
use crate::shot::scalar_tests::{Sampling, prepared, prepared_at, refused, sampled, scalar};

/// The ellipsoid of the cases `offset-of-ellipsoid` and `shell-of-ellipsoid`, and one whose ends are no sharper than walls
/// are thick.
const FLAT: DVec3 = DVec3::new(1.0, 0.5, 0.25);
const ROUND: DVec3 = DVec3::new(1.0, 0.8, 0.6);

/// The distance to the ellipsoid of these half axes, positive inside: the foot is axes²·p/(axes² + t), and its place on
/// the ellipsoid tells t.
fn distance_to_ellipsoid(axes: DVec3, at: DVec3) -> f64 {
    let p = at.abs().max(DVec3::splat(1e-12));
    let squares = axes * axes;
    let excess = |t: f64| (axes * p / (squares + t)).length_squared() - 1.0;
    let (mut low, mut high) = (-squares.min_element(), 1e4);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    let foot = squares * p / (squares + 0.5 * (low + high));
    foot.distance(p) * if (p / axes).length() > 1.0 { -1.0 } else { 1.0 }
}

/// The distance to two balls of radius 1 around the origin and x = 0.5, positive inside.
fn distance_to_balls(p: DVec3) -> f64 {
    let middles = [DVec3::ZERO, DVec3::X * 0.5];
    let value = middles.into_iter().map(|middle| 1.0 - p.distance(middle)).fold(f64::MIN, f64::max);
    if value < 0.0 {
        return value;
    }
    let across = p.with_x(0.0).normalize_or(DVec3::Y);
    let crease = p.distance(DVec3::X * 0.25 + across * (1.0_f64 - 0.0625).sqrt());
    let feet = middles.into_iter().zip([middles[1], middles[0]]).filter_map(|(own, other)| {
        let foot = own + (p - own).normalize_or(DVec3::Y);
        (foot.distance(other) >= 1.0).then(|| foot.distance(p))
    });
    feet.fold(crease, f64::min)
}

const FLAT_SHAPE: &str = "[shape.e]\nformula = '1 - length(x, y/0.5, z/0.25)'\nbounds = 3\n";
const ROUND_SHAPE: &str = "[shape.e]\nformula = '1 - length(x, y/0.8, z/0.6)'\nbounds = 3\n";
const BALLS: &str = "[shape.u]\nunion = ['a', 'b']\n[shape.a]\nsphere = 1\n[shape.b]\nsphere = 1\nmove = [0.5, 0, 0]\n";

#[test]
fn an_ellipsoid_grows_and_shrinks_by_a_distance() {
    for (text, axes, by) in [(FLAT_SHAPE, FLAT, 0.1), (FLAT_SHAPE, FLAT, 0.6), (ROUND_SHAPE, ROUND, -0.1)] {
        let scene = prepared(&format!("{text}offset = {by}\n"));
        assert_near(&scene, 1, |at| distance_to_ellipsoid(axes, at) + by);
        let missed = scene.extent.size() - 2.0 * (axes + by);
        assert!(missed.max_element() < 0.03 && missed.min_element() > -1e-3, "{missed}");
    }
}

/// However far: seeds are taken from the ellipsoid, not from what it becomes.
#[test]
fn an_ellipsoid_grows_by_many_times_its_size() {
    let scene = prepared(&format!("{FLAT_SHAPE}offset = 30\n"));
    assert_near(&scene, 1, |at| distance_to_ellipsoid(FLAT, at) + 30.0);
}

#[test]
fn the_wall_of_an_ellipsoid_is_as_thick_as_it_says() {
    let scene = prepared(&format!("{ROUND_SHAPE}shell = 0.1\n"));
    assert_near(&scene, 1, |at| 0.05 - distance_to_ellipsoid(ROUND, at).abs());
    let scene = prepared(&format!("{FLAT_SHAPE}shell = 0.1\n"));
    for (axis, half) in DVec3::AXES.into_iter().zip(FLAT.to_array()) {
        let field = scene.frame(1).unwrap().field;
        let inside = [-0.055, -0.045, 0.045, 0.055].map(|step| field.reference(axis * (half + step)) > 0.0);
        assert_eq!(inside, [false, true, true, false], "{axis}");
    }
}

#[test]
fn a_union_of_balls_grows_and_shrinks_by_a_distance() {
    let scene = prepared(&BALLS.replace("['a', 'b']\n", "['a', 'b']\noffset = 0.2\n"));
    assert!(scene.frame(1).unwrap().field.slope().is_exact(crate::field::Side::Outside));
    for (x, inside) in [(-1.2 + 1e-6, true), (-1.2 - 1e-6, false), (1.7 - 1e-6, true), (1.7 + 1e-6, false)] {
        assert_eq!(scene.frame(1).unwrap().field.reference(DVec3::X * x) > 0.0, inside, "{x}");
    }
    // Shrinking turns the crease into a piece of a ring.
    let scene = prepared(&BALLS.replace("['a', 'b']\n", "['a', 'b']\noffset = -0.2\n"));
    let accuracy = compare(&band_of(&scene, 1), |at| distance_to_balls(at) - 0.2);
    assert!(accuracy.mean < 0.005 && accuracy.max < 0.05, "{accuracy:?}");
}

/// Planes joined by minima are not the distance beside their edges.
#[test]
fn what_is_cut_by_planes_grows_round() {
    let planes: Vec<String> = (0..6)
        .map(|i| {
            let mut normal = [0; 3];
            normal[i / 2] = if i % 2 == 0 { 1 } else { -1 };
            format!("[shape.p{i}]\nhalf_space = {normal:?}\noffset_along = 0.5\n")
        })
        .collect();
    let names: Vec<String> = (0..6).map(|i| format!("'p{i}'")).collect();
    let scene = |by: f64| {
        let operands = names.join(", ");
        prepared(&format!("[shape.all]\nintersection = [{operands}]\noffset = {by}\n{}", planes.concat()))
    };
    assert_near(&scene(0.2), 1, |at| distance_to_box(at, 0.5) + 0.2);
    assert_near(&scene(-0.2), 1, |at| distance_to_box(at, 0.3));
    // A convex mesh is made of such planes where only its sign is asked for.
    let mesh = |by: f64| {
        prepared(&format!(
            "[shape.all]\nunion = ['m', 'far']\n[shape.m]\nmesh = 'cube.obj'\noffset = {by}\n[shape.far]\nbox = 0.1\nmove = [2, 0, 0]\n"
        ))
    };
    for by in [0.2, -0.2] {
        let exact = |at: DVec3| if by > 0.0 { distance_to_box(at, 0.8) + by } else { distance_to_box(at, 0.8 + by) };
        assert_near(&mesh(by), 1, |at| exact(at).max(distance_to_box(at - DVec3::X * 2.0, 0.05)));
    }
}

/// What ends needs no bounds, whatever is done to it.
#[test]
fn nothing_finite_is_refused_for_bounds() {
    let makers = [
        "sphere = 1",
        "box = 1.5",
        "ellipsoid = [1, 0.7, 0.5]",
        "cylinder = 0.8",
        "torus = 1\ntube = 0.3",
        "capsule = 0.5",
        "heart = 2",
        "mesh = 'cube.obj'",
        "formula = '1 - x^2 - y^2 - z^4'\nbounds = 3",
        "union = ['one', 'two']",
        "intersection = ['one', 'two']",
        "difference = ['one', 'two']",
        "blend = ['one', 'two']",
        "blend = ['one', 'two', 'three']",
        "heart = 2\nscale = [1, 2, 1]",
    ];
    let parts = "[shape.one]\nellipsoid = [1, 0.6, 0.6]\n[shape.two]\nmesh = 'cube.obj'\nmove = [0.9, 0.2, 0.1]\n\
                 [shape.three]\nheart = 1\nmove = [0, 1, 0]\n";
    let modifiers = ["shell = 0.1", "offset = 0.1", "offset = -0.1", "displace = 'bump'\nattribute.bump = 0.1"];
    for (place, maker) in makers.into_iter().enumerate() {
        // Each takes a second or two: every modifier and every maker, but not all of the one with all of the other.
        let modifier = modifiers[place % modifiers.len()];
        let text = format!("[output]\nshape = 's'\n[shape.s]\n{maker}\n{modifier}\n{parts}");
        let result = prepared_at(Sampling::Resolution(12), Arc::default(), &text);
        assert!(result.is_ok(), "{maker} {modifier}: {}", result.err().unwrap());
        if place % 5 != 0 {
            continue;
        }
        let text = format!("[output]\nshape = 'b'\n[shape.b]\nblend = ['s', 'one']\n[shape.s]\n{maker}\n{parts}");
        let result = prepared_at(Sampling::Resolution(12), Arc::default(), &text);
        assert!(result.is_ok(), "{maker} blended: {}", result.err().unwrap());
    }
}

/// The case `heart-with-shell-refused`.
#[test]
fn a_heart_has_a_wall_without_bounds() {
    let (plain, walled) = (prepared("[shape.h]\nheart = 1\n"), prepared("[shape.h]\nheart = 1\nshell = 0.1\n"));
    let grown = walled.extent.size() - plain.extent.size();
    assert!((grown - 0.1).abs().max_element() < 0.02, "{grown}");
    let field = walled.frame(1).unwrap().field;
    let outside = |x: f64| field.reference(DVec3::new(x, 0.0, 0.0)) < 0.0;
    assert!(outside(0.0) && outside(0.35) && (0..1000).any(|i| !outside(f64::from(i) * 1e-3)));
}

#[test]
fn what_is_endless_and_no_distance_asks_for_bounds() {
    let said = refused(
        "[shape.body]\nintersection = ['ball', 'waves']\n[shape.ball]\nsphere = 1\n[shape.waves]\n\
         formula = 'sin(9*x)*cos(9*y) + sin(9*y)*cos(9*z) + sin(9*z)*cos(9*x)'\nshell = 0.1\n",
    );
    assert!(said.contains("`shell` needs the distance to `waves`, which may reach to infinity"), "{said}");
    assert!(said.contains(":7:9") && said.contains("`bounds`"), "{said}");
    prepared(
        "[shape.body]\nintersection = ['ball', 'wall']\n[shape.ball]\nsphere = 1\n[shape.wall]\nslab = 1\nshell = 0.1\n",
    );
}

/// Told to stop after it is ready, a frame ends where it measures something.
fn stopped_once_ready(text: &str) -> Prepared {
    let cancel = Arc::<AtomicBool>::default();
    let scene =
        prepared_at(Sampling::Resolution(16), Arc::clone(&cancel), text).unwrap_or_else(|error| panic!("{error}"));
    cancel.store(true, Ordering::Relaxed);
    scene
}

#[test]
fn what_does_not_change_is_measured_once() {
    let (ellipsoid, union) = ("formula = '1 - length(x, y/0.7, z/0.5)'\nbounds = 3", "union = ['a', 'b']");
    for (maker, keyed) in [
        (ellipsoid, "offset = { 1 = 0, 9 = 0.2 }"),
        (union, "offset = { 1 = -0.1, 9 = 0.2 }"),
        (ellipsoid, "shell = { 1 = 0.1, 9 = 0.2 }"),
    ] {
        let text = format!(
            "frames = '1-9'\n[output]\nshape = 's'\n[shape.s]\n{maker}\n{keyed}\n\
             [shape.a]\nmesh = 'cube.obj'\n[shape.b]\nheart = 1\nmove = [0.3, 0.2, 0]\n"
        );
        let scene = stopped_once_ready(&text);
        for frame in [1, 4, 9] {
            assert!(scene.frame(frame).is_ok(), "{keyed} of {maker}, frame {frame}");
        }
    }
    // What stands still in its own space is measured there.
    let moving = "frames = '1-9'\n[shape.all]\nblend = ['e', 'ball']\n[shape.ball]\nsphere = 0.5\n[shape.e]\n\
                  formula = '1 - length(x, y/0.7, z/0.5)'\nbounds = 3\nmove = ['t', 0, 0]\nrotate = [0, 0, '90*t']\n";
    let scene = stopped_once_ready(moving);
    assert!(scene.frame(5).is_ok());
    let changing = moving.replace("0.7", "(0.7 + 0.1*t)");
    assert!(matches!(stopped_once_ready(&changing).frame(5), Err(Error::Cancelled)));
}

#[test]
fn a_keyed_offset_is_a_distance_in_every_frame() {
    let scene = prepared(&format!("frames = '1-9'\n{ROUND_SHAPE}offset = {{ 1 = -0.04, 9 = 0.12 }}\n"));
    for frame in [1, 2, 6, 9] {
        let by = 0.02 * (frame - 3) as f64;
        assert_near(&scene, frame, |at| distance_to_ellipsoid(ROUND, at) + by);
    }
}

#[test]
fn a_keyed_wall_is_as_thick_as_it_says_in_every_frame() {
    let scene = prepared(&format!("frames = '1-9'\n{ROUND_SHAPE}shell = {{ 1 = 0.06, 9 = 0.22 }}\n"));
    for frame in [1, 5, 9] {
        let half = 0.03 + 0.01 * (frame - 1) as f64;
        assert_near(&scene, frame, |at| half - distance_to_ellipsoid(ROUND, at).abs());
    }
}

#[test]
fn a_blend_reaches_as_far_as_its_radius() {
    // The second is so far that it adds next to nothing to F.
    let scene = prepared(
        "[shape.all]\nblend = ['e', 'far']\nblend_radius = 0.1\n[shape.e]\nformula = '1 - length(x, y/0.5, z/0.25)'\nbounds = 3\n[shape.far]\nsphere = 0.1\nmove = [0, 0, 2]\n",
    );
    let field = scene.frame(1).unwrap().field;
    for at in
        [DVec3::new(1.05, 0.0, 0.0), DVec3::new(1.1, 0.1, 0.0), DVec3::new(0.0, 0.55, 0.0), DVec3::new(0.6, 0.5, 0.1)]
    {
        let (a, b) = (distance_to_ellipsoid(FLAT, at), 0.1 - at.distance(DVec3::Z * 2.0));
        let wanted = a + b + a.hypot(b) + 0.1 / (1.0 + (a * a + b * b) / 0.01);
        assert!((field.reference(at) - wanted).abs() < 2e-3, "{} {wanted} at {at}", field.reference(at));
    }
}

#[test]
fn a_seam_is_as_wide_as_it_says() {
    let scene = prepared(
        "[shape.all]\nunion = ['e', 'ball']\nseam = 0.2\n[shape.e]\nformula = '1 - length(x, y/0.5, z/0.25)'\nbounds = 3\nattribute.part = 0\n\
         [shape.ball]\nformula = '1 - length(x/0.4, y/0.8, z/0.4)'\nbounds = 3\nattribute.part = 1\nmove = [1, 0, 0]\n",
    );
    let frame = scene.frame(1).unwrap();
    let part = |x: f64| scalar(&frame, "part", [x, 0.0, 0.0]);
    // The second's nearest point is its end along x, from where its cover goes from 0 to 1.
    assert!(part(0.49) < 0.01 && part(0.71) > 0.99, "{} {}", part(0.49), part(0.71));
    assert!((part(0.55) - 0.25).abs() < 0.04 && (part(0.65) - 0.75).abs() < 0.04, "{} {}", part(0.55), part(0.65));
}

const BANDS: &str = "[shape.s]\ndifference = ['a', 'b']\nattribute.ring = { bands = [[0, 1], [0.1, 2]] }\n\
                     [shape.a]\nformula = '1 - length(x, y/0.9, z/0.8)'\nbounds = 3\n[shape.b]\nsphere = 0.5\n";

/// Depths are measured once a point off the surface asks for one: of what nothing cuts, none does.
#[test]
fn bands_measure_nothing_before_they_are_asked_below_the_surface() {
    let scene = stopped_once_ready(BANDS);
    let frame = scene.frame(1).unwrap();
    for at in [[1.0, 0.0, 0.0], [0.0, 0.9, 0.0], [0.0, 0.0, 0.5], [0.6, 0.0, 0.64]] {
        assert_eq!(scalar(&frame, "ring", at), 1.0, "{at:?}");
    }
    // And what cannot be measured is told, with its place.
    assert!(scalar(&frame, "ring", [0.7, 0.0, 0.0]).is_nan());
    let said = scene.attribute_problem("ring", "a problem").expect("it is told").to_string();
    assert!(said.contains("`s`: stopped while measuring distances") && said.contains(":1:"), "{said}");
}

#[test]
fn bands_lie_at_their_depths() {
    let scene = prepared(BANDS);
    let frame = scene.frame(1).unwrap();
    for (at, wanted) in [(0.52, 1.0), (0.59, 1.0), (0.61, 2.0), (0.75, 2.0), (0.89, 2.0), (0.91, 1.0), (0.98, 1.0)] {
        assert_eq!(scalar(&frame, "ring", [at, 0.0, 0.0]), wanted, "{at}");
    }
    // Inside what is cut from distances nothing is measured.
    let scene = stopped_once_ready(&BANDS.replace("formula = '1 - length(x, y/0.9, z/0.8)'\nbounds = 3", "box = 2"));
    let frame = scene.frame(1).unwrap();
    for (at, wanted) in [(0.59, 1.0), (0.61, 2.0), (0.89, 2.0), (0.91, 1.0)] {
        assert_eq!(scalar(&frame, "ring", [at, 0.0, 0.0]), wanted, "{at}");
    }
}

/// Many threads that all find nothing measured wait for the one that measures, and none for itself.
#[test]
fn many_threads_ask_bands_at_once() {
    use rayon::prelude::*;
    let scene = prepared(BANDS);
    let ring = Arc::clone(&scene.frame(1).unwrap().scalars[0].1);
    let found: Vec<f32> = (0..64_u32)
        .into_par_iter()
        .map(|i| sampled(ring.as_ref(), DVec3::X * (0.7 + 1e-3 * f64::from(i)))[0])
        .collect();
    assert!(found.iter().all(|value| *value == 2.0), "{found:?}");
}

/// What is extruded is measured in the plane: it has no box in space.
#[test]
fn what_is_done_to_an_extruded_shape_measures_it_in_the_plane() {
    // An ellipse by a scaled circle, whose F is no distance, is nowhere as bent as a circle of the radius of its edges.
    let of = |done: &str| {
        prepared(&format!(
            "[output]\nshape = 'e'\n[shape.s]\ncircle = 1\nscale = [1, 0.8, 1]\n[shape.x]\nextrude = 's'\nheight = 1\n\
             [shape.e]\n{done}\n"
        ))
    };
    for (done, by, tolerance) in [
        ("extrude = 's'\nheight = 1\nround = 0.1", 0.0, 2e-3),
        ("union = ['x']\noffset = -0.1", -0.1, 2e-3),
        ("union = ['x']\noffset = 0.1", 0.1, 2e-3),
    ] {
        let field = of(done).frame(1).expect("a frame").field;
        for (along, radius) in [(DVec3::X, 1.0), (DVec3::NEG_X, 1.0), (DVec3::Y, 0.8), (DVec3::NEG_Y, 0.8)] {
            let [inside, outside] = [-tolerance, tolerance].map(|off| field.reference(along * (radius + by + off)));
            assert!(inside > 0.0 && outside < 0.0, "{done} {along}: {inside} {outside}");
        }
        let (below, above) = (field.reference(DVec3::Z * (0.497 + by)), field.reference(DVec3::Z * (0.503 + by)));
        assert!(below > 0.0 && above < 0.0, "{done}: {below} {above}");
    }
}
