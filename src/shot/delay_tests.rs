//! Delays of a scene's morph: where they come from, and what is wrong with them.

use super::*;
use crate::shot::prepared::Ready;
use crate::shot::scalar_tests::{prepared, refused, wrong};

const SHAPES: &str = "frames = '1-9'
[shape.one]
box = 1
color = ['0.5 + x', 0.1, 0.1]
attribute.late = '0.4 + 0.4*x'
[shape.two]
sphere = 0.6
color = 'blue'
[morph]
from = 'one'
to = 'two'
";

fn scene(delay: &str) -> String {
    format!("{SHAPES}delay = {delay}\n")
}

/// Whether two points, left and right, are inside at the frames' places.
fn volumes(text: &str) -> Vec<f64> {
    let scene = prepared(text);
    let Ready::Morph(planned) = &scene.content else { panic!("it is a morph") };
    planned[0].morph.report(&[0.25, 0.5, 0.75]).frames.iter().map(|frame| frame.volume).collect()
}

#[test]
fn a_formula_an_attribute_and_a_colour_say_the_same() {
    let formula = volumes(&scene("'0.4 + 0.4*x'"));
    let attribute = volumes(&scene("{ shape = 'one', attribute = 'late', most = 0.95 }"));
    let lighter = volumes(&scene("'0.95*(0.4 + 0.4*x)'"));
    assert_eq!(attribute, lighter);
    assert_ne!(attribute, formula);
    // sRGB 0.1 is 0.0100 in light.
    let colour = volumes(&scene("{ shape = 'two', most = 0.9 }"));
    let luminance = volumes(&scene("0.06498"));
    colour.iter().zip(&luminance).for_each(|(one, other)| assert!((one - other).abs() < 1e-6, "{one} {other}"));
}

#[test]
fn a_frame_alone_is_that_of_the_sequence() {
    let text = scene("'0.5*clamp(0.5 + x, 0, 1)'");
    let (all, alone) = (prepared(&text), prepared(&text));
    let surface = |scene: &Prepared, frame: i64| {
        let field = scene.frame(frame).expect("a frame").field;
        (0..200)
            .map(|i| field.reference(glam::DVec3::new(f64::from(i) * 0.006 - 0.6, 0.1, 0.2)).to_bits())
            .collect::<Vec<_>>()
    };
    let sequence: Vec<_> = (1..=9).map(|frame| surface(&all, frame)).collect();
    assert_eq!(sequence[5], surface(&alone, 6));
}

/// What is found only when the scene is made ready, at the delay's place.
#[track_caller]
fn found_later(delay: &str, wanted: &str) {
    let error = refused(&scene(delay));
    assert!(error.contains(wanted) && error.contains("--> scene.toml:12:"), "{error}");
}

#[test]
fn what_is_wrong_with_a_delay() {
    let said = |delay: &str, wanted: &str| wrong(&scene(delay), wanted);
    said("'0.2*q'", "12:14 nothing here is called `q`; known are `frame`, `t`, `time`, `x`, `y`, `z`, `pi`");
    said("1.5", "12:9 `morph.delay` must be from 0 to 0.95");
    said("{ shape = 'one', attribute = 'lat' }", "12:39 `morph.delay.attribute` cannot be `lat`");
    found_later("'0.2*t'", "`morph.delay` changes over time, and must stand still");
    found_later("'2*x'", "the morph's delay is");
    found_later("{ shape = 'two', attribute = 'late' }", "`two` has no `attribute.late` for `morph.delay`");
    wrong(&format!("{}mode = 'linear'\n", scene("0.2")), "12:1 `delay` is for `mode = \"volume\"` only");
}
