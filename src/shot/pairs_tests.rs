//! Ten pairs of objects go over into one another whole and evenly.

use crate::shot::scalar_tests::prepared;

const FRAMES: i64 = 13;
/// The largest change of shape from a frame to the next, in medians.
const MOST_UNEVEN: f64 = 1.3;

/// Pairs and their morphs by name, with the greatest number of pieces at an end.
const PAIRS: [(&str, usize, &str); 10] = [
    ("apart", 1, "[shape.a]\nbox = 1\n[shape.b]\nsphere = 0.6\nmove = [3, 0, 0]\n[morph]\nfrom = 'a'\nto = 'b'\n"),
    ("concentric", 1, "[shape.a]\nbox = 1.2\n[shape.b]\ntorus = 0.9\ntube = 0.3\n[morph]\nfrom = 'a'\nto = 'b'\n"),
    (
        "overlapping",
        1,
        "[shape.a]\nbox = 1\n[shape.b]\nheart = 1.2\nmove = [0.7, 0.2, 0]\n[morph]\nfrom = 'a'\nto = 'b'\n",
    ),
    (
        "one into two",
        2,
        "[shape.a]\nsphere = 0.8\n[shape.b]\nunion = [{ sphere = 0.4, move = [-1, 0, 0] }, { box = 0.7, move = [1, 0, 0] }]\n[morph]\nfrom = 'a'\nto = 'b'\n",
    ),
    ("thin plates", 1, "[shape.a]\nbox = [2, 2, 0.15]\n[shape.b]\nbox = [0.15, 2, 2]\n[morph]\nfrom = 'a'\nto = 'b'\n"),
    (
        "with a hole",
        1,
        "[shape.a]\ndifference = [{ box = [1.6, 1.6, 0.6] }, { cylinder = 0.45, height = 2 }]\n[shape.b]\ncapsule = 0.4\nlength = 1.2\n[morph]\nfrom = 'a'\nto = 'b'\n",
    ),
    (
        "mesh to formula",
        1,
        "[shape.a]\nmesh = 'cube.obj'\n[shape.b]\nformula = '1 - x^2 - 2*y^2 - z^4'\nbounds = 2\n[morph]\nfrom = 'a'\nto = 'b'\n",
    ),
    (
        "chain",
        1,
        "[shape.a]\nbox = 1\n[shape.m]\nsphere = 0.7\nmove = [0.5, 0, 0]\n[shape.b]\ncylinder = 0.4\nheight = 1.4\nmove = [1, 0, 0]\n[morph]\nthrough = ['a', 'm', 'b']\n",
    ),
    (
        "moving",
        1,
        "[shape.a]\nbox = 1\nmove = ['2*t', 0, 0]\n[shape.b]\nsphere = 0.7\nmove = ['2*t', 0.2, 0]\n[morph]\nfrom = 'a'\nto = 'b'\n",
    ),
    (
        "tumbling",
        1,
        "[shape.a]\nbox = [1.6, 0.5, 0.4]\n[shape.b]\ncapsule = 0.3\nlength = 1.2\nrotate = [20, 70, 0]\nmove = [2.5, 1, 0]\n[morph]\nfrom = 'a'\nto = 'b'\ncarry = 'inertia'\n",
    ),
];

#[test]
fn ten_pairs_stay_whole_and_change_evenly() {
    for (name, most, scene) in PAIRS {
        let scene = prepared(&format!("frames = '1-{FRAMES}'\noutput.resolution = 40\n{scene}"));
        let mut changes = Vec::new();
        for frame in 1..=FRAMES {
            let numbers = scene.report(frame).expect("a frame").expect("a morph").numbers;
            assert!(
                (1..=most).contains(&(numbers.pieces as usize)),
                "{name}, frame {frame}: {} pieces",
                numbers.pieces
            );
            if frame > 1 {
                changes.push(scene.change_of_shape(frame - 1, frame).unwrap_or(numbers.change));
            }
        }
        changes.sort_by(f64::total_cmp);
        let (median, greatest) = (changes[changes.len() / 2], changes[changes.len() - 1]);
        assert!(greatest < MOST_UNEVEN * median, "{name}: {greatest} beside a median of {median}");
    }
}
