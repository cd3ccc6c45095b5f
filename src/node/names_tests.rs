//! Names that shapes give their formulas, against the same formulas with what the names stand for.

use glam::{DVec3, Vec3};

use super::row_tests::solids;
use super::tests::{only, problems};
use super::trap_tests::field;
use crate::field::tests::Samples;
use crate::field::{Aabb, BATCH, Field, Points};
use crate::node::attributes::TheScalar;
use crate::node::id::Stage;

#[track_caller]
fn same(one: &str, other: &str) {
    let (one, other, mut samples) = (field(one), field(other), Samples::new(9));
    for _ in 0..500 {
        let p = samples.within(&Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0)));
        assert_eq!(one.reference(p), other.reference(p), "at {p}");
    }
}

#[test]
fn a_name_is_what_it_stands_for() {
    let plain = "[shape.a]\nformula = '1 - hypot'\nbounds = 3\n";
    let text = |formula: &str, lets: &str| format!("{}{lets}", plain.replace("1 - hypot", formula));
    let spelt = text("1 - sqrt(x^2 + y^2) + 0.2*sin(3*(x^2 + y^2))", "");
    same(&text("1 - r + 0.2*sin(3*s)", "let.r = 'sqrt(s)'\nlet.s = 'x^2 + y^2'\n"), &spelt);
    same(&text("1 - r + 0.2*sin(k*s)", "let.k = 3\nlet.r = 'sqrt(s)'\nlet.s = 'x^2 + y^2'\n"), &spelt);
    same(
        &text("1 - r + 0.2*sin(k*s)", "let.k = { 1 = 3, 9 = 5 }\nlet.r = 'sqrt(s)'\nattribute.s = 'x^2 + y^2'\n"),
        &spelt,
    );
    let quoted = text("1 - attr('r') + 0.2*sin(3*attr( 's' ))", "let.r = 'sqrt(s)'\nattribute.s = 'x^2 + y^2'\n");
    same(&quoted.replacen("formula = '", "formula = \"\"\"", 1).replacen("))'\n", "))\"\"\"\n", 1), &spelt);
    // Numbers of time take names too, and a shape in place has its own.
    same("[shape.a]\nsphere = 'r'\nlet.r = '0.5 + 2*t'\n", "[shape.a]\nsphere = 0.5\n");
    same("[shape.a]\nlet.r = 5\nunion = [{ sphere = 'r', let.r = 1 }]\n", "[shape.a]\nunion = [{ sphere = 1 }]\n");
}

/// A parameter of the same name keeps its meaning, as in scenes from before.
#[test]
fn parameters_come_before_attributes() {
    let text = "[shape.a]\nsphere = 'size'\nattribute.size = '3*size'\n[param]\nsize = 0.5\n";
    same(text, "[shape.a]\nsphere = 0.5\n");
    let (mut solids, id) = solids(text);
    let paint = solids.paint(TheScalar("size"), id, Stage::Placed, 0.01).expect("no problem").expect("a scalar");
    let (mut points, mut out) = (Points::new(DVec3::ZERO), [[0.0]; BATCH]);
    points.push(Vec3::ZERO);
    paint.attribute.sampler().sample(&points, &mut out);
    assert_eq!(out[0], [1.5]);
}

#[test]
fn what_changes_by_a_name_changes() {
    let model = super::tests::model(
        "frames = '1-9'\n[shape.a]\nformula = '1 - r'\nlet.r = 'k*x'\nlet.k = { 1 = 1, 9 = 2 }\nbounds = 2\n",
    );
    assert!(super::variation::Variation::of(&model).own(super::ShapeId(0)));
    let still = super::tests::model(
        "frames = '1-9'\n[shape.a]\nformula = '1 - r'\nlet.r = 'x'\nlet.k = { 1 = 1, 9 = 2 }\nbounds = 2\n",
    );
    assert!(!super::variation::Variation::of(&still).own(super::ShapeId(0)));
}

#[test]
fn names_that_are_wrong() {
    let shape = |keys: &str| format!("[shape.a]\nsphere = 1\n{keys}\n[param]\nsize = 1\n");
    let cases = [
        (
            "let.a = 'b'\nlet.b = 'c + 1'\nlet.c = 'a'",
            "3:10 `shape.a.let.a` is made from itself; the way is a → b → c → a",
        ),
        ("attribute.r = 'r + 1'", "3:16 `shape.a.attribute.r` is made from itself; the way is r → r"),
        ("let.size = 2", "3:5 `size` is the name of a parameter of the scene already; choose another name"),
        ("let.x = 2", "3:5 `x` already means something in formulas"),
        ("let.r = true", "3:9 `shape.a.let.r` must be a number, a formula or keys"),
        ("let.r = 'sni(x)'", "3:10 there is no function `sni`; did you mean `sin`?"),
        ("let.r = 'qq + x'", "3:10 nothing here is called `qq`"),
        ("let = 3", "3:7 `shape.a.let` must be a table, such as { r = \"length(x, y)\" }"),
        ("let.r = 'x'\nmove = ['r', 0, 0]", "4:10 `r` differs from place to place, and one number is needed here"),
        ("let.r = 1\nattribute.r = 2", "3:5 `r` is the name of an attribute of the shape already; choose another name"),
        ("attribute.q = \"attr(r)\"", "3:21 the name stands in quotes: `attr('name')`"),
    ];
    for (keys, wanted) in cases {
        let found = problems(&shape(keys));
        assert!(found.iter().any(|found| found.starts_with(wanted)), "{wanted}\n{found:#?}");
    }
    only(&shape("let.r = 'x'\nlte.r = 2"), "4:1 unknown key `lte` in `shape.a`; did you mean `let`?");
}
