//! Operations of a scene's own: against the nodes of the same formula, and what is refused.

use glam::DVec3;

use super::row_tests::solids;
use super::tests::{only, problems};
use super::trap_tests::field;
use crate::field::tests::Samples;
use crate::field::{Aabb, Expression, Field, Slope};

const SHAPES: &str = "[shape.a]\nsphere = 0.7\n[shape.b]\nbox = 1\nmove = [0.6, 0.1, 0]\n[output]\nshape = 's'\n";

/// A shape of two, by an operation of its own with these keys.
fn own(operation: &str, shape: &str) -> String {
    format!("[shape.s]\nown = ['a', 'b']\n{shape}\n{SHAPES}[operation.own]\nfields = ['a', 'b']\n{operation}\n")
}

fn built_in(shape: &str) -> Expression {
    field(&format!("[shape.s]\n{shape}\n{SHAPES}"))
}

#[track_caller]
fn same(one: &Expression, other: &Expression, tolerance: f64) {
    let mut samples = Samples::new(3);
    for _ in 0..2000 {
        let p = samples.within(&Aabb::new(DVec3::splat(-2.0), DVec3::splat(2.0)));
        let (one, other) = (one.reference(p), other.reference(p));
        assert!((one - other).abs() <= tolerance, "{one}, {other} at {p}");
    }
}

#[test]
fn the_formula_of_a_node_is_the_node() {
    let max = field(&own("formula = 'max(a, b)'", ""));
    same(&max, &built_in("union = ['a', 'b']\nsystem = 'minmax'"), 0.0);
    let r0 = field(&own("formula = 'a + b + sqrt(a^2 + b^2)'", ""));
    same(&r0, &built_in("union = ['a', 'b']"), 1e-12);
    let smooth = "param.w = 0.25\nformula = 'max(a, b) + max(w - abs(a - b), 0)^2/(4*w)'";
    let wide = "smooth_union = ['a', 'b']\nkernel = 'quadratic'\nblend_radius = ";
    for (given, radius) in [("", 0.25), ("w = 0.5", 0.5), ("w = '0.2 + 0.1*time'", 0.2)] {
        let one = field(&own(smooth, given));
        same(&one, &built_in(&format!("{wide}{radius}")), 1e-12);
    }
}

#[test]
fn what_is_declared_is_used() {
    let steep = |keys: &str| {
        let (mut solids, id) = solids(&own(keys, ""));
        solids.values(id).expect("a field").slope()
    };
    let smooth = "formula = 'max(a, b) + max(0.25 - abs(a - b), 0)^2'\n";
    assert_eq!(steep(&format!("{smooth}lipschitz = 2")), Slope::Lipschitz(2.0));
    // Interval bounds of a quotient find no box; F at ever lower levels of all fields does.
    let hard = "formula = 'a + b + 1 - 0.9*exp(a)/(1e-9 + exp(a))'\n";
    let whole = field(&own(&format!("{hard}rises_in = ['a', 'b']"), ""));
    let (found, mut samples) = (whole.bounding_box().expect("a box"), Samples::new(6));
    for _ in 0..4000 {
        let p = samples.within(&Aabb::new(DVec3::splat(-4.0), DVec3::splat(4.0)));
        assert!(found.contains(p) || whole.reference(p) < 0.0, "{p} is outside of {found:?}");
    }
}

#[test]
fn promises_that_are_not_kept_are_refused_with_the_place() {
    let found = problems(&own("formula = 'a - b'\nrises_in = ['a', 'b']", ""));
    assert!(found.len() == 1, "{found:?}");
    for part in ["F of `own` falls while `b` rises; it is ", " at a = ", ", and ", ": leave `b` out of `rises_in`"] {
        assert!(found[0].contains(part), "{found:?}");
    }
    let found = problems(&own("formula = 'a + 3*b'\nlipschitz = 3.9", ""));
    assert!(
        found.len() == 1 && found[0].contains("F of `own` is steeper than its `lipschitz`; from a = "),
        "{found:?}"
    );
    for sound in [
        "formula = 'a + 3*b'\nlipschitz = 4",
        "formula = 'a - b'\nrises_in = ['a']",
        "formula = 'max(a, b)'\nrises_in = ['a', 'b']\nlipschitz = 1",
    ] {
        assert_eq!(problems(&own(sound, "")), [] as [&str; 0], "{sound}");
    }
    // By the numbers that shapes give.
    let by_number = "param.k = 1\nformula = 'a + k*b'\nlipschitz = 2.5";
    assert_eq!(problems(&own(by_number, "")), [] as [&str; 0]);
    assert_eq!(problems(&own(by_number, "k = 2")).len(), 1);
}

#[test]
fn operations_that_are_wrong() {
    let plain = "formula = 'a + b'";
    let cases = [
        (own("formula = 'a + c'", ""), "13:16 nothing here is called `c`; known are `a`, `b`, "),
        (own(plain, "k = 2"), "3:1 unknown key `k` in `shape.s`"),
        (own("param.k = 1\nformula = 'a + k*b'", "k = true"), "3:5 `shape.s.k` must be a number, a formula or keys"),
        (own("param.k = { value = 1, min = 0 }\nformula = 'a + k*b'", "k = -1"), "3:5 `shape.s.k` must be at least 0"),
        (
            own("param.scale = 1\nformula = 'a + b'", ""),
            "13:7 `scale` of `operation.own` is the name of a node; give the parameter another name",
        ),
        (own("param.a = 1\nformula = 'a + b'", ""), "12:12 `a` is the name of something else in this formula already"),
        (own("rises_in = ['c']\nformula = 'a + b'", ""), "13:14 `c` is none of `fields`; did you mean `a`?"),
        (
            own("lipschitz = 2\nformula = 'a + x*b'", ""),
            "13:1 `lipschitz` is about the fields alone, and the formula names `x`; leave it out",
        ),
        (own(plain, "twist = 10\nfoo = 1"), "4:1 unknown key `foo` in `shape.s`"),
        (own(plain, "sphere = 1"), "3:1 `own` and `sphere` both say what `shape.s` is"),
        (
            own(plain, "").replace("own = ['a', 'b']", "own = ['a']"),
            "2:7 `shape.s.own` takes 2 shapes, and these are 1; one for each of its fields, `a` and `b`",
        ),
        (
            own(plain, "").replace("own = ['a', 'b']", "onw = ['a', 'b']"),
            "2:1 unknown key `onw` in `shape.s`; did you mean `own`?",
        ),
        (
            own(plain, "").replace("own", "twist"),
            "11:12 `twist` is the name of a node; give the operation another name",
        ),
        (
            own("param.swirl_radius = 1\nformula = 'a + swirl_radius*b'", "swirl_radius = 2\nswirl = 3"),
            "3:1 `swirl_radius` of `shape.s` could go with `own` or with `swirl`",
        ),
    ];
    for (text, wanted) in cases {
        let found = problems(&text);
        assert!(found.iter().any(|found| found.starts_with(wanted)), "{wanted}\n{found:#?}\n{text}");
    }
    only(
        &own("", ""),
        "11:12 `operation.own` has no `formula`; F of the whole, positive inside, of the fields, `param` names of its own, and all that formulas know.",
    );
}

/// Colours are mixed as those of a blend are: that of each shape alone, and between them by convex weights.
#[test]
fn colours_go_along() {
    let colours = "[shape.a]\nsphere = 0.5\ncolor = { linear = [1, 0, 0] }\nmove = [-1, 0, 0]\n[shape.b]\nsphere = 0.5\n\
                   color = { linear = [0, 0, 1] }\nmove = [1, 0, 0]\n[output]\nshape = 's'\n";
    let of = |text: String| {
        let (mut solids, id) = solids(&text);
        let paint = solids.paint(crate::node::attributes::TheColour, id, crate::node::id::Stage::Placed, 0.01);
        let paint = paint.expect("no problem").expect("a colour");
        let mut points = crate::field::Points::new(DVec3::ZERO);
        (-12..=12).for_each(|i| points.push(glam::Vec3::new(i as f32 / 8.0, 0.0, 0.0)));
        let mut out = [[0.0; 3]; crate::field::BATCH];
        paint.attribute.sampler().sample(&points, &mut out);
        out[..25].to_vec()
    };
    let ours = of("[operation.own]\nfields = ['p', 'q']\nformula = 'p + q + sqrt(p^2 + q^2)'\n".to_owned()
        + "[shape.s]\nown = ['a', 'b']\n"
        + colours);
    let node = of(format!("[shape.s]\nblend = ['a', 'b']\n{colours}"));
    assert_eq!(ours, node);
    assert!(ours.iter().all(|[red, green, blue]| *green == 0.0 && (red + blue - 1.0).abs() < 1e-6));
    assert!(ours[0] == [1.0, 0.0, 0.0] && ours[24] == [0.0, 0.0, 1.0] && (ours[12][0] - 0.5).abs() < 1e-6, "{ours:?}");
}
