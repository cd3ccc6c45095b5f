//! Morphs of shapes of the plane.

use glam::{DVec2, DVec3};

use crate::distance::accuracy::compare;
use crate::shot::Prepared;
use crate::shot::displace_tests::{assert_near, band_of};
use crate::shot::scalar_tests::{prepared, refused, sampled, scalar, wrong};

/// A cylinder about z around a centre, by its radius and half its height.
fn exact_disc(p: DVec3, radius: f64, half: f64) -> f64 {
    let (across, along) = (p.x.hypot(p.y) - radius, p.z.abs() - half);
    -(across.max(along).min(0.0) + across.max(0.0).hypot(along.max(0.0)))
}

/// Two circles that move and grow, whose linear blend is a circle; the whole is turned out of the plane on the way.
const CIRCLES: &str = "frames = '0-4'\n[shape.a]\ncircle = 1\nmove = ['2*t', 0, 0]\n[shape.b]\ncircle = 2\n\
                       move = ['2*t', 0, 0]\n";

#[test]
fn a_linear_blend_of_discs_is_a_disc() {
    let scene = prepared(&format!("{CIRCLES}[morph]\nfrom = 'a'\nto = 'b'\nmode = 'linear'\npace = 't'\n"));
    for frame in 0..=4 {
        let t = frame as f64 / 4.0;
        // An eighth of the longest side, 4.
        assert_near(&scene, frame, |p| exact_disc(p - DVec3::X * 2.0 * t, 1.0 + t, 0.25));
    }
    let size = scene.extent.size();
    assert!((size - DVec3::new(5.0, 4.0, 0.5)).abs().max_element() < 0.05, "{size}");
    let drawn = scene.in_plane(2).expect("a frame").expect("a shape of the plane");
    for x in [-3.0, 0.2, 1.9, 2.4, 2.6, 7.0] {
        let exact = 1.5 - (x - 1.0_f64).abs();
        let (f, distance) = (drawn.0.reference(DVec3::new(x, 0.0, 5.0)), scene.distance_in_plane(2, &drawn));
        let distance = distance.expect("a distance").distance.reference(DVec3::new(x, 0.0, 5.0));
        assert!(
            (f - exact).abs() < 0.02 * exact.abs().max(0.1) && (distance - exact).abs() < 0.02,
            "{f} {distance} {exact}"
        );
    }
}

#[test]
fn a_morph_of_the_plane_turns_in_space() {
    let whole = "rotate = ['90*t', 0, 0]\nmove = [0, 0, '3*t']\nscale = 2\n";
    let scene = prepared(&format!("{CIRCLES}[morph]\nfrom = 'a'\nto = 'b'\nmode = 'linear'\npace = 't'\n{whole}"));
    for frame in 0..=4 {
        let t = frame as f64 / 4.0;
        let turn = glam::DMat3::from_rotation_x((90.0 * t).to_radians());
        let exact = |p: DVec3| {
            let own = turn.transpose() * (p - DVec3::Z * 3.0 * t) / 2.0;
            2.0 * exact_disc(own - DVec3::X * 2.0 * t, 1.0 + t, 0.25)
        };
        assert_near(&scene, frame, exact);
    }
    assert!(scene.in_plane(2).expect("a frame").is_none());
    let moved = prepared(&format!("{CIRCLES}[morph]\nfrom = 'a'\nto = 'b'\nmove = [0, 0, 3]\nheight = 0.3\n"));
    assert!(moved.in_plane(2).expect("a frame").is_some() && (moved.extent.size().z - 0.3).abs() < 1e-9);
    // What `keep` leaves out is not drawn.
    let kept = prepared(&format!("{CIRCLES}[morph]\nfrom = 'a'\nto = 'b'\nkeep = 'largest'\n"));
    assert!(kept.in_plane(2).expect("a frame").is_none());
    // Discs that only turn and move change as if they lay still.
    let [still, moving] = [("", "['2*t', 0, 0]"), (whole, "['2*t', 0, 0]")].map(|(whole, _)| {
        let scene = prepared(&format!("{CIRCLES}[morph]\nfrom = 'a'\nto = 'b'\n{whole}"));
        scene.report(2).expect("a frame").expect("a morph").numbers.volume
    });
    assert!((moving / still - 8.0).abs() < 0.01, "{moving} for {still}");
}

/// The area of what a frame shows in the plane, by points of a fine lattice.
fn area(scene: &Prepared, frame: i64) -> f64 {
    const STEP: f64 = 0.005;
    let (field, aabb) = scene.in_plane(frame).expect("a frame").expect("a shape of the plane");
    let [x, y] = [aabb.min.x, aabb.min.y];
    let [width, height] = aabb.size().truncate().to_array().map(|size| (size / STEP) as u32 + 2);
    let at = |i: u32, j: u32| DVec3::new(x + f64::from(i) * STEP, y + f64::from(j) * STEP, 0.0);
    let inside = (0..width).flat_map(|i| (0..height).map(move |j| (i, j)));
    inside.filter(|(i, j)| field.reference(at(*i, *j)) >= 0.0).count() as f64 * STEP * STEP
}

const SHAPES: &str = "frames = '1-9'\n[shape.a]\nstar = 1\ncolor = 'red'\nattribute.q = 1\n[shape.b]\n\
                      rectangle = [1.4, 0.6]\nmove = [0.9, 0.3, 0]\ncolor = 'blue'\nattribute.q = 3\n";

#[test]
fn the_area_goes_from_one_shape_to_the_other() {
    let scene = prepared(&format!("{SHAPES}[morph]\nfrom = 'a'\nto = 'b'\n"));
    let [first, last] = [1, 9].map(|frame| area(&scene, frame));
    let mut changes = Vec::new();
    for frame in 2..=9 {
        let numbers = scene.report(frame).expect("a frame").expect("a morph").numbers;
        let (between, expected) = (area(&scene, frame), first + numbers.t * (last - first));
        assert!((between - expected).abs() < 0.003 * first, "{frame}: {between} for {expected}");
        // Boxes of the plane: an eighth of the star's side.
        let height = scene.extent.size().z;
        assert!((numbers.volume - between * height).abs() < 0.003 * first * height, "{frame}: {numbers:?}");
        changes.push(numbers.change);
    }
    let mean = changes.iter().sum::<f64>() / changes.len() as f64;
    assert!(changes.iter().all(|change| (change / mean - 1.0).abs() < 0.1), "{changes:?}");
    let content = scene.frame(5).expect("a frame");
    let colour = content.colour.as_ref().expect("a colour");
    // Colours and numbers know no z.
    for p in [DVec2::new(-0.5, 0.1), DVec2::new(0.9, 0.3), DVec2::new(0.3, 0.2)] {
        let [low, high] = [-0.1, 0.1].map(|z| sampled(colour.as_ref(), p.extend(z)));
        assert_eq!(low, high);
        assert_eq!(scalar(&content, "q", [p.x, p.y, -0.1]), scalar(&content, "q", [p.x, p.y, 0.1]));
    }
}

/// The ends are what the shapes are by themselves, extruded alike; and the morph as a shape is what `[morph]` shows.
#[test]
fn a_morph_as_a_shape_is_one_of_the_plane() {
    let height = "height = 0.24";
    let morph = prepared(&format!("{SHAPES}[morph]\nfrom = 'a'\nto = 'b'\n"));
    let half = morph.extent.size().z / 2.0;
    let end = prepared(&format!("output.shape = 'e'\n{SHAPES}[shape.e]\nextrude = 'a'\nheight = {}\n", 2.0 * half));
    let voxel = morph.lattice.voxel_size.get();
    let exact = end.frame(1).expect("a frame").field;
    let found = compare(&band_of(&morph, 1), |p| exact.reference(p));
    assert!(found.wrong_signs == 0 && found.max < 1e-3, "{found:?} {voxel}");
    // Half of the way.
    let shape = "[shape.m]\nmorph = ['a', 'b']\nmix = 0.5\n";
    let flat = prepared(&format!("output.shape = 'm'\n{SHAPES}{shape}"));
    let (one, other) =
        (flat.in_plane(5).expect("a frame").expect("flat"), morph.in_plane(5).expect("a frame").expect("flat"));
    for (x, y) in [(-0.9, 0.1), (0.2, 0.3), (0.9, 0.1), (1.4, 0.7), (0.0, -0.6)] {
        let p = DVec3::new(x, y, 0.0);
        let (one, other) = (one.0.reference(p), other.0.reference(p));
        assert!((one - other).abs() < 0.01, "{p}: {one} {other}");
    }
    let solid = prepared(&format!("output.shape = 's'\n{SHAPES}{shape}[shape.s]\nextrude = 'm'\n{height}\n"));
    assert!((solid.extent.size().z - 0.24).abs() < 1e-6, "{}", solid.extent.size());
    let mixed = format!("output.shape = 'm'\n{SHAPES}[shape.c]\nsphere = 1\n[shape.m]\nmorph = ['a', 'c']\n");
    wrong(&mixed, "15:11 `morph` needs solids, and `a` is a shape of the plane");
}

#[test]
fn what_a_morph_of_the_plane_cannot_do_is_told() {
    let said = |shape: &str, morph: &str| {
        refused(&format!("{SHAPES}{shape}[shape.c]\ncircle = 1\n{morph}\n[morph]\nfrom = 'a'\nto = 'c'\n"))
    };
    let turned = said("", "rotate = [20, 0, 0]");
    assert!(turned.contains("`c`, a shape of the plane, leaves it") && turned.contains("morph.rotate"), "{turned}");
    let later = said("", "rotate = ['20*t', 0, 0]");
    assert!(later.contains("leaves it"), "{later}");
    let method = said("", "distance = 'fim'");
    assert!(method.contains("`fim` measures solids only"), "{method}");
    let warned = prepared(&format!("{SHAPES}[morph]\nfrom = 'a'\nto = 'b'\n")).model().warnings.to_string();
    assert!(warned.contains("extruded by an eighth of their longest side"), "{warned}");
    let solid =
        "frames = '1-3'\n[shape.a]\nsphere = 1\n[shape.b]\nbox = 1\n[morph]\nfrom = 'a'\nto = 'b'\nheight = 1\n";
    wrong(solid, "6:2 `morph.height` is of morphs of shapes of the plane, in all modes but `openvdb`");
    let far = "frames = '0-4'\n[shape.a]\ncircle = 1\n[shape.b]\ncircle = 1\nmove = ['500*t', 0, 0]\n[output]\nvoxel_size = 0.1\n";
    let far = refused(&format!("{far}[morph]\nfrom = 'a'\nto = 'b'\n"));
    assert!(
        far.contains("the objects go so far that only 2.7 cells") && far.contains("`carry = \"centroid\"`"),
        "{far}"
    );
    // OpenVDB's morph is one of level sets: both are extruded first.
    let sets = prepared(&format!("{SHAPES}[morph]\nfrom = 'a'\nto = 'b'\nmode = 'openvdb'\n"));
    assert!(sets.model().warnings.to_string().contains("`a` is a shape of the plane: it is extruded"));
    assert!(sets.in_plane(3).expect("a frame").is_none());
}

/// What is done to a morph's frames is done to the solid: surfaces moved, cut and filled; parts and anchors are of the plane.
#[test]
fn a_morph_of_the_plane_is_dressed_as_a_solid() {
    let volume = |rest: &str| {
        let scene = prepared(&format!(
            "{SHAPES}[shape.k]\nbox = [9, 9, 1]\nmove = [0, 0, 0.5]\n[morph]\nfrom = 'a'\nto = 'b'\n{rest}"
        ));
        let band = band_of(&scene, 5);
        (crate::grid::measure::volume(&band), scene)
    };
    let (whole, scene) = volume("");
    let (cut, _) = volume("cut = 'k'\n");
    assert!((cut / whole - 0.5).abs() < 0.01, "{cut} of {whole}");
    let exact = area(&scene, 5) * scene.extent.size().z;
    assert!((whole / exact - 1.0).abs() < 0.01, "{whole} for {exact}");
    let (carried, _) =
        volume("carry = 'anchors'\nanchors = [[[0, 0, 0], [0.9, 0.3, 0]], [[0.3, 0, 0.4], [1.2, 0.3, 0]]]\n");
    assert!((carried / whole - 1.0).abs() < 0.2, "{carried}");
    let (inertia, _) = volume("carry = 'inertia'\n");
    assert!((inertia / whole - 1.0).abs() < 0.2, "{inertia}");
    let (late, _) = volume("delay = '0.3*(x > 0)'\n");
    assert!(late > 0.5 * whole, "{late}");
}
