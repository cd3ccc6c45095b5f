//! Morphs whose parts correspond: which pair a point has its attributes from, and what is wrong with pairs.

use glam::DVec3;

use super::*;
use crate::shot::frame_tests::sample;
use crate::shot::prepared::Ready;
use crate::shot::scalar_tests::{prepared, prepared_in_voxels, sampled, scalar, wrong};

/// Two pairs of balls that cross one another on their way, with plain fields: frame 4 is at t = 1/2.
const CROSSING: &str = "frames = '1-7'
[shape.one]
union = ['a', 'b']
[shape.two]
union = ['c', 'd']
[shape.a]
sphere = 0.8
move = [-0.5, 0, 0]
attribute.wear = 1
color = '#ff0000'
[shape.b]
sphere = 0.8
move = [0.5, 0, 0]
attribute.wear = 100
color = '#0000ff'
[shape.c]
sphere = 0.8
move = [-0.5, 1, 0]
attribute.wear = 500
color = '#00ff00'
[shape.d]
sphere = 0.8
move = [0.5, 1, 0]
attribute.wear = 3
color = '#ffffff'
[morph]
from = 'one'
to = 'two'
mode = 'linear'
pace = 't'
pairs = [['a', 'd'], ['b', 'c']]
";

const MIDDLES: [[DVec3; 2]; 2] =
    [[DVec3::new(-0.5, 0.0, 0.0), DVec3::new(0.5, 1.0, 0.0)], [DVec3::new(0.5, 0.0, 0.0), DVec3::new(-0.5, 1.0, 0.0)]];
const WEAR: [[f64; 2]; 2] = [[1.0, 3.0], [100.0, 500.0]];

/// D, which the plan has from the measured objects' boxes.
fn unit(scene: &Prepared) -> f64 {
    let Ready::Morph(planned) = &scene.content else { panic!("it is a morph") };
    planned[0].morph.plan().unit
}

fn and(a: f64, b: f64) -> f64 {
    a + b - a.hypot(b)
}

/// A pair's field and its STTI value (eq. 1 to 5), as it is printed.
fn pair(place: usize, at: DVec3, t: f64, unit: f64) -> [f64; 2] {
    let [first, second] = MIDDLES[place].map(|middle| 0.8 - at.distance(middle));
    let alpha = 0.3;
    // Inside of both g is not the printed one: min(g, 0) keeps weights shares.
    let g1 = and(first / unit, -alpha * t).min(0.0);
    let g2 = and(second / unit, alpha * (t - 1.0)).min(0.0);
    let [from, to] = WEAR[place];
    [(1.0 - t) * first + t * second, (g2 * from + g1 * to) / (g1 + g2)]
}

/// Where points lie: in which of the pairs.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    None,
    First,
    Second,
    Both,
}

/// Each point of a plane with where it is, both pairs' fields and values, and the scalar of the frame there.
fn over_a_plane(scene: &Prepared, frame: i64) -> Vec<(Place, [[f64; 2]; 2], f64)> {
    let content = scene.frame(frame).unwrap();
    let (t, unit) = (content.info.t, unit(scene));
    let mut found = Vec::new();
    for (i, j) in (0..=40).flat_map(|i| (0..=40).map(move |j| (i, j))) {
        let at = DVec3::new(f64::from(i) * 0.05 - 1.0, f64::from(j) * 0.05 - 0.5, 0.05);
        let both = [pair(0, at, t, unit), pair(1, at, t, unit)];
        // Objects are measured, so their fields are not exact: what is too near to call is left out.
        let [first, second] = both.map(|[value, _]| value);
        if [first, second, first - second].iter().any(|value| value.abs() < 0.01) {
            continue;
        }
        let place = match [first > 0.0, second > 0.0] {
            [false, false] => Place::None,
            [true, false] => Place::First,
            [false, true] => Place::Second,
            [true, true] => Place::Both,
        };
        found.push((place, both, f64::from(scalar(&content, "wear", at.to_array()))));
    }
    for place in [Place::None, Place::First, Place::Second, Place::Both] {
        assert!(found.iter().filter(|(there, ..)| *there == place).count() > 20, "too few points in {place:?}");
    }
    found
}

/// `wanted(place, pairs)` at every point of a plane, to what measured distances leave.
#[track_caller]
fn holds(keys: &str, wanted: impl Fn(Place, [[f64; 2]; 2]) -> f64) {
    let scene = prepared(&format!("{CROSSING}{keys}"));
    for frame in [3, 4, 6] {
        for (place, both, found) in over_a_plane(&scene, frame) {
            let wanted = wanted(place, both);
            assert!((found - wanted).abs() < 0.01 * wanted, "{found}, not {wanted}: {place:?}, {both:?}");
        }
    }
}

#[test]
fn the_later_pair_has_the_overlap_and_the_master_the_gaps() {
    holds("overlap = 'priority'\nmaster = 'a'\n", |place, [[_, first], [_, second]]| match place {
        Place::None | Place::First => first,
        Place::Second | Place::Both => second,
    });
}

#[test]
fn pairs_are_mixed_evenly_where_they_overlap() {
    holds("overlap = 'mix'\nmaster = 'c'\n", |place, [[_, first], [_, second]]| match place {
        Place::First => first,
        Place::None | Place::Second => second,
        Place::Both => 0.5 * (first + second),
    });
}

#[test]
fn without_a_master_gaps_take_the_nearest_pair() {
    holds("", |place, [[near, first], [far, second]]| match place {
        Place::None if near > far => first,
        Place::None => second,
        Place::First => first,
        Place::Second | Place::Both => second,
    });
}

#[test]
fn a_master_of_its_own_has_the_gaps_colour_alone() {
    let scene = prepared(&format!("{CROSSING}master_color = '#00ffff'\n"));
    let content = scene.frame(4).unwrap();
    let (t, unit) = (content.info.t, unit(&scene));
    let colours = content.colour.as_ref().expect("parts have one");
    let mut gaps = 0;
    for i in 0..=40 {
        let at = DVec3::new(f64::from(i) * 0.05 - 1.0, 0.5, 0.05);
        let nearest = [0, 1].map(|place| pair(place, at, t, unit)[0]).into_iter().fold(f64::NEG_INFINITY, f64::max);
        if nearest.abs() < 0.01 {
            continue;
        }
        let found = sample(colours.as_ref(), at);
        assert_eq!(found == [0.0, 1.0, 1.0], nearest < 0.0, "{found:?} at {at}, {nearest}");
        gaps += usize::from(nearest < 0.0);
    }
    assert!((5..36).contains(&gaps), "{gaps}");
}

/// Crossing pairs, so that each colour comes from the other side; the second object moves besides.
#[test]
fn at_both_ends_each_part_has_its_own_attributes() {
    let text = CROSSING.replace("union = ['c', 'd']", "union = ['c', 'd']\nmove = ['3*t', 0, 't']");
    let text = text.replace("mode = 'linear'\npace = 't'\n", "");
    let scene = prepared(&text);
    let moved = DVec3::new(3.0, 0.0, 1.0);
    let parts = [
        (1, MIDDLES[0][0], 1.0, [1.0, 0.0, 0.0]),
        (1, MIDDLES[1][0], 100.0, [0.0, 0.0, 1.0]),
        (7, MIDDLES[0][1] + moved, 3.0, [1.0, 1.0, 1.0]),
        (7, MIDDLES[1][1] + moved, 500.0, [0.0, 1.0, 0.0]),
    ];
    for (frame, middle, wear, colour) in parts {
        let content = scene.frame(frame).unwrap();
        for off in [DVec3::ZERO, DVec3::Z * 0.8, DVec3::Y * -0.2, DVec3::Z * -0.4] {
            let at = middle + off;
            assert_eq!(scalar(&content, "wear", at.to_array()), wear as f32, "frame {frame}, {at}");
            assert_eq!(sampled(content.colour.as_ref().unwrap().as_ref(), at), colour, "frame {frame}, {at}");
        }
    }
}

/// On the way a point of one pair only has that pair's colour as if there were no other.
#[test]
fn inside_one_pair_its_own_colour_and_nothing_else() {
    let scene = prepared(CROSSING);
    let Ready::Morph(planned) = &scene.content else { panic!("it is a morph") };
    let mut compared = 0;
    for frame in 2..=6 {
        let content = scene.frame(frame).unwrap();
        let t = content.info.t;
        for (place, part) in planned[0].parts.iter().enumerate() {
            let alone = part.morph.colour(t);
            for middle in MIDDLES[place] {
                let inside = pair(place, middle, t, 1.0)[0] > 0.05 && pair(1 - place, middle, t, 1.0)[0] < -0.05;
                if inside {
                    let found = sampled(content.colour.as_ref().unwrap().as_ref(), middle);
                    assert_eq!(found, sampled(alone.as_ref(), middle), "frame {frame}, pair {place}");
                    compared += 1;
                }
            }
        }
    }
    assert!(compared >= 8, "{compared} points");
}

/// The whole morph's shape does not ask for pairs.
#[test]
fn pairs_leave_the_shape_alone() {
    let without = CROSSING.replace("pairs = [['a', 'd'], ['b', 'c']]\n", "");
    let [one, two] = [CROSSING, &without].map(|text| prepared(text).frame(4).unwrap());
    for i in 0..50 {
        let at = DVec3::new(f64::from(i) * 0.04 - 1.0, 0.5, 0.1);
        assert_eq!(one.field.reference(at), two.field.reference(at));
    }
}

#[test]
fn wrong_pairs_are_named_with_their_place() {
    let with = |pairs: &str| CROSSING.replace("[['a', 'd'], ['b', 'c']]", pairs);
    for (pairs, problem) in [
        ("[['a', 'd'], ['b', 'e']]", "31:29 there is no `shape.e`"),
        ("[['a', 'd'], ['b', 'a']]", "31:29 `a` is no part of `two`, which is `morph.to`"),
        ("[['c', 'd'], ['b', 'c']]", "31:12 `c` is no part of `one`, which is `morph.from`"),
        ("[['a', 'd'], ['a', 'c']]", "31:24 `a` is in two pairs"),
        ("[['a', 'd'], ['b']]", "31:22 `morph.pairs` takes pairs: a part of the first object and one of the second"),
        (
            "'a'",
            "31:10 `morph.pairs` must be \"auto\", or a list of pairs, such as [[\"head\", \"lid\"], [\"body\", \"bowl\"]]",
        ),
        ("[['a', 'd'], ['b', 'c']]\nmaster = 'one'", "32:11 `morph.master` is `one`, which is in none of `pairs`"),
        (
            "[['a', 'd'], ['b', 'c']]\nmaster = 'a'\nmaster_color = 'red'",
            "33:1 `master` and `master_color` both say what holds where none of `pairs` is",
        ),
        ("[['a', 'd'], ['b', 'c']]\nmaster = 'e'", "32:11 there is no `shape.e`"),
        ("[['a', 'd'], ['b', 'c']]\noverlap = 'blend'", "32:12 `morph.overlap` cannot be `blend`"),
    ] {
        wrong(&with(pairs), problem);
    }
    let unpaired = CROSSING.replace("union = ['a', 'b']", "union = ['a', 'b', 'x']\n[shape.x]\nsphere = 2");
    wrong(&unpaired, "33:9 `x`, a part of `one`, is in no pair");
    wrong(
        &CROSSING.replace("union = ['c', 'd']", "sphere = 1"),
        "28:7 `two` is no union, so it has no parts for `pairs`",
    );
    let mirrored = CROSSING.replace("union = ['c', 'd']", "union = ['c', 'd']\nmirror = 'x'");
    wrong(&mirrored, "4:8 `two` has a `mirror`, so its parts cannot be told apart for `pairs`");
    let painted = CROSSING.replace("union = ['c', 'd']", "union = ['c', 'd']\nattribute.wear = 2");
    wrong(&painted, "4:8 `two` has its own `attribute.wear`, which hides those of its parts from `pairs`");
    wrong(&with("[['a', 'd'], ['b', 'c']]").replace("pairs", "overlap = 'mix' #"), "31:1 `overlap` goes with `pairs`");
    let chain = |pairs: &str| with(pairs).replace("from = 'one'\nto = 'two'", "through = ['one', 'two', 'one']");
    for (pairs, problem) in [
        ("[['a', 'd'], ['b', 'c']]", "30:10 `morph.pairs` takes lists of 3: a part of each shape of `through`"),
        ("[['a', 'd', 'a'], ['b', 'c', 'a']]", "30:39 `a` is in two pairs"),
        ("[['a', 'd', 'c'], ['b', 'c', 'b']]", "30:22 `c` is no part of `one`, which is in `morph.through`"),
    ] {
        wrong(&chain(pairs), problem);
    }
    let doubly = chain("[['a', 'd', 'a'], ['b', 'c', 'b']]").replace("union = ['a', 'b']", "sphere = 1");
    wrong(&doubly, "27:11 `one` is no union, so it has no parts for `pairs`");
}

/// Each link of a chain has its pairs: its frames are those of the morph of two alone.
#[test]
fn parts_correspond_along_a_chain() {
    let third = "[shape.three]\nunion = ['e', 'f']\n[shape.e]\nsphere = 0.8\nmove = [0, -1, 0]\nattribute.wear = 7
[shape.f]\nsphere = 0.8\nmove = [0.9, -1, 0]\nattribute.heat = 9\ncolor = '#123456'\n[morph]";
    let text = CROSSING.replace("[morph]", third);
    let morph = |ends: &str, pairs: &str| {
        let text = text.replace("from = 'one'\nto = 'two'", ends).replace("[['a', 'd'], ['b', 'c']]", pairs);
        prepared_in_voxels(0.05, &text)
    };
    let chain = morph("through = ['one', 'two', 'three']\nat = [1, 3, 7]", "[['a', 'd', 'e'], ['b', 'c', 'f']]");
    let links = [
        (2, morph("from = 'one'\nto = 'two'\nover = '1-3'", "[['a', 'd'], ['b', 'c']]")),
        (4, morph("from = 'two'\nto = 'three'\nover = '3-7'", "[['d', 'e'], ['c', 'f']]")),
        (6, morph("from = 'two'\nto = 'three'\nover = '3-7'", "[['d', 'e'], ['c', 'f']]")),
    ];
    let points: Vec<DVec3> =
        (0..60).map(|i| DVec3::new(f64::from(i % 12) * 0.2 - 1.1, f64::from(i / 12) * 0.5 - 1.3, 0.1)).collect();
    for (frame, link) in links {
        let (whole, alone) = (chain.frame(frame).unwrap(), link.frame(frame).unwrap());
        let names = |content: &FrameContent| content.scalars.iter().map(|(name, _)| name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&whole), ["heat", "wear"]);
        for at in &points {
            assert_eq!(whole.field.reference(*at), alone.field.reference(*at), "frame {frame} at {at}");
            let wear = |content: &FrameContent| scalar(content, "wear", at.to_array());
            assert_eq!(wear(&whole), wear(&alone), "frame {frame} at {at}");
        }
    }
}

#[test]
fn a_stretched_object_has_no_pairs() {
    let text = CROSSING.replace("union = ['c', 'd']", "union = ['c', 'd']\nscale = [1, 2, 1]");
    frame_tests::refused(&text, "`two` is stretched, and so its parts cannot be told apart for `pairs`");
}

/// The same attributes as of the pairs that lie nearest, named; a note names them.
#[test]
fn pairs_that_are_found() {
    let with = |pairs: &str| prepared(&CROSSING.replace("[['a', 'd'], ['b', 'c']]", pairs));
    let (found, named) = (with("'auto'"), with("[['a', 'c'], ['b', 'd']]"));
    let points = (0..60).map(|i| DVec3::new(f64::from(i) / 30.0 - 1.0, 0.5, 0.1));
    let frames = [found.frame(4).unwrap(), named.frame(4).unwrap()];
    for at in points {
        let [one, two] = frames.each_ref().map(|frame| scalar(frame, "wear", at.to_array()));
        assert_eq!(one, two, "{at}");
    }
    let said: Vec<&str> = found.warnings.list().iter().map(|note| note.message.as_str()).collect();
    assert_eq!(said, ["`pairs = \"auto\"` is [[\"a\", \"c\"], [\"b\", \"d\"]]"]);
    assert!(named.warnings.is_empty());
    wrong(
        &CROSSING.replace("[['a', 'd'], ['b', 'c']]", "'auto'\nmaster = 'a'"),
        "32:1 `master` is for pairs that are named",
    );
}
