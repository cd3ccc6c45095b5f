//! How a scene's morph is carried: what holds where nothing is said, what is wrong, and what is warned of.

use glam::{DVec3, Vec3};

use crate::field::{BATCH, Points};
use crate::shot::prepared::Ready;
use crate::shot::scalar_tests::{prepared, refused, wrong};

const APART: &str = "frames = '1-9'
output = { grids = ['surface', 'vel'], resolution = 40 }
[shape.one]
box = [1, 0.6, 0.4]
[shape.two]
sphere = 0.5
move = [3, 0, 0]
[morph]
from = 'one'
to = 'two'
";

/// Values of frames, and whether the first morph is carried.
fn frames(text: &str, frames: &[i64]) -> (Vec<u64>, bool) {
    let scene = prepared(text);
    let Ready::Morph(planned) = &scene.content else { panic!("it is a morph") };
    let field = |frame: &i64| scene.frame(*frame).expect("a frame").field;
    let values = frames.iter().map(field).flat_map(|field| {
        (0..60).map(move |i| field.reference(DVec3::new(f64::from(i) * 0.08 - 0.8, 0.1, 0.15)).to_bits())
    });
    (values.collect(), planned[0].morph.is_carried())
}

#[test]
fn what_lies_apart_is_carried_and_what_overlaps_is_not() {
    let (left, carried) = frames(APART, &[2, 5]);
    assert!(carried);
    // A frame alone is that of the sequence.
    assert_eq!(frames(&format!("{APART}carry = 'centroid'\n"), &[5]), (left[60..].to_vec(), true));
    let (none, carried) = frames(&format!("{APART}carry = 'none'\n"), &[5]);
    assert!(!carried && none != left[60..]);
    for same in [
        APART.replace("move = [3, 0, 0]", "move = [0.9, 0, 0]"),
        // They meet on the way, and so their own motion is meant.
        APART.replace("move = [3, 0, 0]", "move = ['3 - 2.5*t', 0, 0]"),
        format!("{APART}mode = 'linear'\n"),
    ] {
        assert!(!frames(&same, &[]).1, "{same}");
    }
}

#[test]
fn what_is_wrong_with_a_carry() {
    let said = |keys: &str, wanted: &str| wrong(&format!("{APART}{keys}\n"), wanted);
    said("carry = 'center'", "11:10 `morph.carry` cannot be `center`");
    said("carry = 'anchors'", "11:10 `carry = \"anchors\"` goes with `anchors`");
    said("carry = 'centroid'\nanchors = [[[0, 0, 0], [3, 0, 0]]]", "12:1 `anchors` is for `carry = \"anchors\"` only");
    said("anchors = []", "11:11 `morph.anchors` must be a list of pairs of places, such as [[[0, 0, 1], [3, 0, 2]]]");
    said(
        "anchors = [[[0, 0, 0]]]",
        "11:12 `morph.anchors` takes pairs: a place of the first shape and one of the last",
    );
    said("anchors = [[[0, 0], [3, 0, 0]]]", "11:13 `morph.anchors` must be three numbers");
    said("anchors = [[[0, 'x', 0], [3, 0, 0]]]", "11:18 `morph.anchors` must be a number that stands still");
    said("mode = 'union'\ncarry = 'centroid'", "12:1 `carry` is not for `mode = \"union\"`");
    let found_later = |anchors: &str, wanted: &str| {
        let error = refused(&format!("{APART}anchors = {anchors}\n"));
        assert!(error.contains(wanted) && error.contains("--> scene.toml:11:"), "{error}");
    };
    found_later(
        "[[[0, 0, 0], [3, 0, 0.8]]]",
        "the anchor [3, 0, 0.8] lies outside of `two`, as that stands at frame 9",
    );
    found_later("[[[0, 0, 0], [3, 0, 0]], [[0.1, 0, 0], [3, 0, 0]]]", "the anchors of an object are all at one place");
    found_later(
        "[[[0, 0, 0], [3, 0, 0]], [[0.1, 0, 0], [3.1, 0, 0]], [[0.2, 0, 0], [3.2, 0, 0]]]",
        "the anchors lie on one line",
    );
}

#[test]
fn axes_that_tell_no_turn_are_warned_of() {
    let warnings = prepared(&format!("{APART}carry = 'inertia'\n")).warnings.to_string();
    assert!(warnings.contains("`two` is about as long in every direction: `carry` turns nothing"), "{warnings}");
    assert!(warnings.contains("scene.toml:8:"), "{warnings}");
    assert!(prepared(APART).warnings.is_empty());
}

/// Through three balls, each by anchors of its own: straight from one to the next, and beside the one between, the velocity
/// is the mean of both ways, all of it.
#[test]
fn a_chain_is_carried_from_each_to_the_next() {
    let text = "frames = '1-9'\noutput.grids = ['surface', 'vel']\n[shape.a]\nsphere = 0.5\n[shape.b]\nsphere = 0.5\nmove = [2, 0, 0]\n\
                [shape.c]\nsphere = 0.5\nmove = [2, 3, 0]\n[morph]\nthrough = ['a', 'b', 'c']\n";
    for carry in ["carry = 'centroid'", "anchors = [[[0, 0, 0.5], [2, 0, 0.5], [2, 3, 0.5]]]"] {
        let scene = prepared(&format!("{text}{carry}\n"));
        let velocity = [DVec3::X, DVec3::new(0.5, 0.75, 0.0), DVec3::Y * 1.5].map(|frame| frame * 12.0);
        for (frame, centre, velocity) in
            [(3, DVec3::X, velocity[0]), (5, DVec3::X * 2.0, velocity[1]), (7, DVec3::new(2.0, 1.5, 0.0), velocity[2])]
        {
            let content = scene.frame(frame).expect("a frame");
            let mut points = Points::new(centre);
            let outward: Vec<Vec3> = [Vec3::X, Vec3::Y, Vec3::Z, -Vec3::ONE].into_iter().map(Vec3::normalize).collect();
            outward.iter().for_each(|outward| points.push(*outward * 0.5));
            for i in 0..points.len {
                assert!(
                    content.field.reference(points.position(i)).abs() < 1e-3,
                    "frame {frame}, {}",
                    points.offset(i)
                );
            }
            let movement = content.movement.expect("velocities");
            let (mut found, mut held) = ([[0.0; 3]; BATCH], [false; BATCH]);
            movement.meter(0.02).velocities(&points, &outward, &mut found, &mut held);
            for found in found[..points.len].iter().map(|found| Vec3::from(*found).as_dvec3()) {
                assert!(found.distance(velocity) < 0.05, "{found}, not {velocity}, at frame {frame}");
            }
        }
    }
}
