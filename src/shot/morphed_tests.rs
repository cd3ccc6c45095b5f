//! A morph as a shape is the scene's own morph at one time; blends by the weights of a morph.

use glam::{DVec3, Vec3};

use crate::field::{BATCH, Points};
use crate::shot::prepared::FrameContent;
use crate::shot::scalar_tests::{prepared, refused, wrong};

const TWO: &str = "[shape.a]\nbox = 1.2\ncolor = '#d7263d'\nattribute.m = 0\n\
                   [shape.b]\nsphere = 0.7\ndo = [{ move = [0.4, 0, 0.2] }]\ncolor = '#1b998b'\nattribute.m = 1\n";

/// F, colour and the scalar at places across both shapes.
fn samples(frame: &FrameContent) -> Vec<[f32; 5]> {
    let mut points = Points::new(DVec3::ZERO);
    for i in 0..200 {
        let along = |by: usize| (i * by % 200) as f32 / 200.0 - 0.5;
        points.push(Vec3::new(2.6 * along(1) + 0.2, 2.0 * along(37), 2.0 * along(91)));
    }
    let (mut colours, mut scalars) = ([[0.0; 3]; BATCH], [[0.0; 1]; BATCH]);
    frame.colour.as_ref().expect("it has a colour").sampler().sample(&points, &mut colours);
    frame.scalars[0].1.sampler().sample(&points, &mut scalars);
    let at = |i: usize| {
        let [r, g, b] = colours[i];
        [frame.field.reference(points.position(i)) as f32, r, g, b, scalars[i][0]]
    };
    (0..200).map(at).collect()
}

#[track_caller]
fn assert_alike(one: &FrameContent, other: &FrameContent) {
    for (one, other) in samples(one).iter().zip(samples(other)) {
        // Both measure the objects, on cells that are not quite the same: to a thirtieth of a voxel.
        assert!(one.iter().zip(other).all(|(a, b)| (a - b).abs() < 1e-3), "{one:?} {other:?}");
    }
}

#[test]
fn a_morph_as_a_shape_is_a_frame_of_the_scenes() {
    // Where they overlap, and apart, where they are carried.
    for shapes in [TWO.to_owned(), TWO.replace("[0.4, 0, 0.2]", "[1.6, 0, 0.2]")] {
        let scene = prepared(&format!("frames = '1-5'\n{shapes}[morph]\nfrom = 'a'\nto = 'b'\nbridge = 0.3\n"));
        let still =
            prepared(&format!("output.shape = 'm'\n{shapes}[shape.m]\nmorph = ['a', 'b']\nmix = 0.25\nbridge = 0.3\n"));
        assert_alike(&still.frame(1).unwrap(), &scene.frame(2).unwrap());
        let keys = "output.shape = 'm'\nframes = '1-5'\n";
        let moving = prepared(&format!("{keys}{shapes}[shape.m]\nmorph = ['a', 'b']\nmix = 't'\nbridge = 0.3\n"));
        for frame in [1, 2, 5] {
            assert_alike(&moving.frame(frame).unwrap(), &scene.frame(frame).unwrap());
        }
    }
}

#[test]
fn a_morph_is_an_operand_and_is_morphed_again() {
    let shapes = format!("{TWO}[shape.m]\nmorph = ['a', 'b']\n");
    let plain = prepared(&format!("output.shape = 'm'\n{shapes}"));
    let cut = prepared(&format!(
        "output.shape = 'c'\n{shapes}[shape.c]\ndifference = ['m', 'd']\n[shape.d]\nbox = 4\nmove = [0, 2, 0]\n"
    ));
    let (plain, cut) = (plain.frame(1).unwrap(), cut.frame(1).unwrap());
    for (x, y) in [(0.0, -0.3), (0.4, -0.1), (0.0, 0.3), (1.6, -0.2)] {
        let at = DVec3::new(x, y, 0.1);
        assert_eq!(cut.field.reference(at) > 0.0, plain.field.reference(at) > 0.0 && y < 0.0, "{at}");
    }
    let again = prepared(&format!("frames = '1-3'\n{shapes}[morph]\nfrom = 'm'\nto = 'a'\n"));
    let first = again.frame(1).unwrap();
    for (one, other) in samples(&first).iter().zip(samples(&plain)) {
        assert!((one[0] - other[0]).abs() < 1e-6, "{one:?} {other:?}");
    }
}

#[test]
fn a_blend_with_a_mix_has_the_weights_of_a_morph() {
    let shapes = "[shape.a]\nsphere = 0.5\nmove = [-0.6, 0, 0]\ncolor = [1, 0, 0]\nattribute.m = 0\n\
                  [shape.b]\nsphere = 0.3\nmove = [0.6, 0, 0]\ncolor = [0, 0, 1]\nattribute.m = 1\n";
    let at = |mix: f64, x: f32| {
        let text = format!("output.shape = 's'\n{shapes}[shape.s]\nblend = ['a', 'b']\nmix = {mix}\nalpha = 0.2\n");
        let frame = prepared(&text).frame(1).unwrap();
        let mut points = Points::new(DVec3::ZERO);
        points.push(Vec3::new(x, 0.1, 0.0));
        let mut scalars = [[0.0; 1]; BATCH];
        frame.scalars[0].1.sampler().sample(&points, &mut scalars);
        f64::from(scalars[0][0])
    };
    // The paper's weights in the open, of distances in halves of the diagonal of the box of both.
    let unit = DVec3::new(2.0, 1.0, 1.0).length() / 2.0;
    let weight = |mix: f64, x: f64| {
        let distance = |middle: f64, radius: f64| (radius - (x - middle).hypot(0.1)) / unit;
        let and = |a: f64, b: f64| a + b - a.hypot(b);
        let g1 = and(distance(-0.6, 0.5).min(0.0), -0.2 * mix);
        let g2 = and(distance(0.6, 0.3).min(0.0), 0.2 * (mix - 1.0));
        g1 / (g1 + g2)
    };
    for mix in [0.25, 0.5, 0.8] {
        for x in [0.0, 0.15, 0.2] {
            let (found, exact) = (at(mix, x), weight(mix, f64::from(x)));
            assert!((found - exact).abs() < 2e-3, "mix {mix} at {x}: {found} {exact}");
        }
    }
}

#[test]
fn what_is_wrong_with_a_morph_as_a_shape() {
    wrong(&format!("{TWO}[shape.m]\nmorph = ['a', 'b', 'a']\n"), "11:21 `shape.m.morph` takes two shapes");
    wrong(&format!("{TWO}[shape.m]\nmorph = ['a']\n"), "11:9 `shape.m.morph` needs at least two shapes");
    wrong(&format!("{TWO}[shape.m]\nmorph = ['a', 'b']\nmix = 1.5\n"), "12:7 `shape.m.mix` must be from 0 to 1");
    wrong(&format!("{TWO}[shape.m]\nengrave = ['a', 'b', 'a']\n"), "11:23 `shape.m.engrave` takes two shapes");
    wrong(
        "[shape.a]\ncircle = 1\n[shape.b]\nsphere = 1\n[shape.m]\nmorph = ['a', 'b']\n",
        "6:11 `morph` needs solids, and `a` is a shape of the plane",
    );
    let keys = "output.shape = 's'\n";
    let said = refused(&format!("{keys}{TWO}[shape.s]\nblend = ['a', 'b', {{ sphere = 1 }}]\nmix = 0.5\n"));
    assert!(said.contains("`blend` has more than two") && said.contains("scene.toml:13:7"), "{said}");
    let said = refused(&format!("{keys}{TWO}[shape.s]\nblend = ['a', 'b']\nalpha = 0.5\n"));
    assert!(said.contains("`alpha` counts beside `mix`") && said.contains("scene.toml:13:9"), "{said}");
}
