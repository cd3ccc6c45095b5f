//! Formulas that read the distance of other shapes, against distances that are known.

use glam::DVec3;

use super::ShapeId;
use super::row_tests::solids;
use super::tests::{model, only};
use super::variation::Variation;
use crate::field::tests::Samples;
use crate::field::{Aabb, BATCH, Points};
use crate::node::attributes::TheScalar;
use crate::node::id::Stage;

const PARTS: &str =
    "[shape.ball]\nsphere = 0.5\nmove = [0.5, 0, 0]\n[shape.pill]\nellipsoid = [1, 0.5, 0.5]\n[output]\nshape = 's'\n";

#[test]
fn an_exact_distance_is_read_as_it_is() {
    let text = format!("[shape.s]\nformula = \"d - 0.1*sin(9*y)\"\nlet.d = \"dist('ball')\"\nbounds = 4\n{PARTS}");
    let ((mut solids, id), mut samples) = (solids(&text), Samples::new(2));
    // Before its bounds, whose intersection changes F.
    let field = solids.step_field(id, 0).expect("a formula");
    for _ in 0..1000 {
        let p = samples.within(&Aabb::new(DVec3::splat(-1.9), DVec3::splat(1.9)));
        let wanted = 0.5 - (p - DVec3::new(0.5, 0.0, 0.0)).length() - 0.1 * (9.0 * p.y).sin();
        assert!((field.reference(p) - wanted).abs() < 1e-9, "{} is not {wanted} at {p}", field.reference(p));
    }
}

/// F of an ellipsoid is no distance: along its axes the distance to its ends is known.
#[test]
fn what_is_no_distance_is_measured() {
    let text = format!("[shape.s]\nsphere = 2\nattribute.far = \"dist('pill')\"\n{PARTS}");
    let (mut solids, id) = solids(&text);
    let paint = solids.paint(TheScalar("far"), id, Stage::Placed, 0.01).expect("no problem").expect("a scalar");
    let (mut points, mut out) = (Points::new(DVec3::ZERO), [[0.0]; BATCH]);
    let places = [1.2, 1.6, 0.95]
        .map(|x| DVec3::new(x, 0.0, 0.0))
        .into_iter()
        .chain([0.6, 0.9].map(|y| DVec3::new(0.0, y, 0.0)));
    let wanted = [-0.2, -0.6, 0.05, -0.1, -0.4];
    places.for_each(|p| points.push(p.as_vec3()));
    paint.attribute.sampler().sample(&points, &mut out);
    for (i, wanted) in wanted.into_iter().enumerate() {
        assert!((f64::from(out[i][0]) - wanted).abs() < 2e-3, "{} is not {wanted}", out[i][0]);
    }
}

/// Measured around the shape that reads it, it goes on beyond.
#[test]
fn what_is_measured_around_its_reader_goes_on_beyond() {
    for (reader, scale) in [("sphere = 0.3", 1.0), ("box = [2.4, 0.2, 0.2]", 1.0), ("sphere = 0.3", 2.0)] {
        let text = format!(
            "[shape.s]\n{reader}\nattribute.far = \"dist('pill')\"\n{}",
            PARTS.replace("[1, 0.5, 0.5]", &format!("[1, 0.5, 0.5]\nscale = {scale}"))
        );
        let (mut solids, id) = solids(&text);
        let paint = solids.paint(TheScalar("far"), id, Stage::Placed, 0.01).expect("no problem").expect("a scalar");
        let (mut points, mut out) = (Points::new(DVec3::ZERO), [[0.0]; BATCH]);
        let all = [(0.1, 0.4), (0.2, 0.3), (0.3, 0.2), (0.45, 0.05), (2.0, -1.5), (5.0, -4.5)];
        all.iter().for_each(|(y, _)| points.push((DVec3::Y * scale * y).as_vec3()));
        paint.attribute.sampler().sample(&points, &mut out);
        for ([out], (_, wanted)) in out.into_iter().zip(all) {
            let (found, wanted) = (f64::from(out), scale * wanted);
            assert!((found - wanted).abs() < 2e-3 * scale.max(wanted.abs()), "{found} is not {wanted}, {reader}");
        }
    }
}

#[test]
fn what_is_read_decides_what_changes_and_what_is_a_cycle() {
    let moving = model(
        "frames = '1-9'\n[shape.s]\nformula = \"dist('a') + dist('a')\"\nbounds = 3\n[shape.a]\nsphere = 1\nmove = ['t', 0, 0]\n",
    );
    assert!(Variation::of(&moving).own(ShapeId(0)));
    assert_eq!(moving.with_parts(&[ShapeId(0)]), [ShapeId(0), ShapeId(1)]);
    only(
        "[shape.a]\nformula = \"dist('b')\"\nbounds = 2\n[shape.b]\nunion = ['a']\n",
        "2:12 `a` is made from itself; the way is a → b → a",
    );
    only(
        "[shape.a]\nformula = \"dist('c') + x\"\nbounds = 2\n[shape.b]\nsphere = 1\n",
        "2:12 there is no `shape.c`; did you mean `a`?",
    );
    only(
        "[shape.a]\nsphere = \"dist('b')\"\n[shape.b]\nsphere = 1\n[output]\nshape = 'a'\n",
        "2:11 `dist` reads a place, and one number is needed here",
    );
}
