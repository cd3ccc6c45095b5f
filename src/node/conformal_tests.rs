//! Colours and numbers that follow the inside of a shape: named in formulas, kept over time, and what is wrong with them.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::row_tests::solids;
use super::solid::Solids;
use super::tests::problems;
use super::trap_tests::field;
use super::variation::Variation;
use crate::attribute::Attribute;
use crate::field::{BATCH, Field, Points};
use crate::node::attributes::{TheColour, TheScalar};
use crate::node::id::{ShapeId, Stage};

/// A bar along x with a ball at its left end.
const BAR: &str = "[output]
shape = 's'
[shape.s]
box = [2, 0.4, 0.4]
attribute.way = { interior = ['tip'], lattice = 24 }
KEYS
[shape.tip]
sphere = 0.1
move = [-0.9, 0, 0]
color = 'red'
attribute.heat = 1
[shape.top]
sphere = 0.1
move = [0.9, 0, 0]
color = 'blue'
attribute.heat = 3
";

fn bar(keys: &str) -> String {
    BAR.replace("KEYS", keys)
}

fn sampled<const N: usize>(attribute: &dyn Attribute<N>, at: DVec3) -> [f32; N] {
    let (mut points, mut out) = (Points::new(at), [[f32::NAN; N]; BATCH]);
    points.push(Vec3::ZERO);
    attribute.sampler().sample(&points, &mut out);
    out[0]
}

fn number(solids: &mut Solids, name: &str, at: DVec3) -> f64 {
    let paint = solids.paint(TheScalar(name), ShapeId(0), Stage::Placed, 0.02).expect("no problem");
    f64::from(sampled(paint.expect("a scalar").attribute.as_ref(), at)[0])
}

const AT: DVec3 = DVec3::new(0.3, 0.1, -0.15);

fn way() -> f64 {
    AT.distance(DVec3::new(-0.9, 0.0, 0.0)) - 0.1
}

#[test]
fn an_attribute_that_is_a_table_is_a_name() {
    let keys = "attribute.twice = '2*way + 1'
attribute.steps = { ramp = [[0, 0], [2, 4]], by = 'attr(\"way\")' }
attribute.of_step = 'steps/2 - way'
let.half = 'way/2'
attribute.quarter = 'half/2'
color = ['way/4', '0', '0']";
    let (mut solids, id) = solids(&bar(keys));
    let far = way();
    for (name, wanted) in
        [("way", far), ("twice", 2.0 * far + 1.0), ("steps", 2.0 * far), ("of_step", 0.0), ("quarter", far / 4.0)]
    {
        let found = number(&mut solids, name, AT);
        assert!((found - wanted).abs() < 1e-5, "{name}: {found}, {wanted}");
    }
    let colour = solids.paint(TheColour, id, Stage::Placed, 0.02).expect("no problem").expect("a colour");
    let red = sampled(colour.attribute.as_ref(), AT)[0];
    let wanted = crate::attribute::from_srgb([far as f32 / 4.0, 0.0, 0.0])[0];
    assert!((red - wanted).abs() < 1e-5, "{red}, {wanted}");
}

#[test]
fn numbers_and_colours_go_over() {
    let keys = "attribute.heat = { conformal = ['tip', 'top'], lattice = 24 }
attribute.cell = { conformal = ['tip', 'top'], show = 'cell', lattice = 24 }
attribute.near = { interior = ['tip', 'top'], lattice = 24 }
attribute.skin = { interior = ['surface'], lattice = 24 }
color = { conformal = ['tip', 'top'], color_space = 'rgb', lattice = 24 }";
    let (mut solids, id) = solids(&bar(keys));
    let (one, two) = (way(), AT.distance(DVec3::new(0.9, 0.0, 0.0)) - 0.1);
    let share = 0.5 + (one - two) / (2.0 * 1.6);
    for (name, wanted) in [("heat", 1.0 + 2.0 * share), ("cell", 1.0), ("near", two), ("skin", 0.05)] {
        let found = number(&mut solids, name, AT);
        assert!((found - wanted).abs() < 1e-5, "{name}: {found}, {wanted}");
    }
    let colour = solids.paint(TheColour, id, Stage::Placed, 0.02).expect("no problem").expect("a colour");
    let found = sampled(colour.attribute.as_ref(), AT).map(f64::from);
    assert!((found[0] - (1.0 - share)).abs() < 1e-5 && (found[2] - share).abs() < 1e-5, "{found:?}, {share}");
    // One feature: its value everywhere.
    let (mut solids, _) = self::solids(&bar("attribute.heat = { conformal = ['top'], lattice = 24 }"));
    assert_eq!(number(&mut solids, "heat", AT), 3.0);
}

/// Times by a speed: of the same all along, of one that changes along the bar, and from the surface inward.
#[test]
fn ways_take_a_speed() {
    let keys = "attribute.long = { interior = ['tip'], method = 'eikonal', lattice = 64 }
attribute.fast = { interior = ['tip'], method = 'eikonal', speed = 2, lattice = 64 }
attribute.slower = { interior = ['tip'], method = 'eikonal', speed = '1 + x^2', lattice = 64 }
attribute.skin = { interior = ['surface'], method = 'eikonal', speed = '4', lattice = 64 }
attribute.heat = { conformal = ['tip', 'top'], method = 'eikonal', speed = 0.01, lattice = 64 }";
    let (mut solids, _) = solids(&bar(keys));
    let (cell, middle) = (2.0 / 64.0, DVec3::new(0.3, 0.0, 0.0));
    let found = |solids: &mut Solids, name: &str| number(solids, name, middle);
    assert!((found(&mut solids, "long") - 1.1).abs() < cell, "{}", found(&mut solids, "long"));
    assert!((2.0 * found(&mut solids, "fast") - found(&mut solids, "long")).abs() < cell);
    let wanted = libm::atan(0.3) + libm::atan(0.8);
    assert!((found(&mut solids, "slower") - wanted).abs() < cell, "{} {wanted}", found(&mut solids, "slower"));
    assert!((found(&mut solids, "skin") - 0.2 / 4.0).abs() < cell / 4.0, "{}", found(&mut solids, "skin"));
    let share = 0.5 + (1.1 - 0.5) / (2.0 * 1.6);
    assert!((found(&mut solids, "heat") - (1.0 + 2.0 * share)).abs() < cell, "{}", found(&mut solids, "heat"));
    // Each method and speed is its own.
    assert_eq!(solids.insides.features.len(), 6);
}

#[test]
fn features_at_one_place_are_told() {
    let twins = "attribute.heat = { conformal = ['tip', 'twin', 'top'], lattice = 24 }";
    let twin = "[shape.twin]\nsphere = 0.1\nmove = [-0.9, 0, 0]\nattribute.heat = 2\n";
    let warned = |text: &str| {
        let (mut solids, _) = solids(text);
        let found = number(&mut solids, "heat", DVec3::new(-0.9, 0.0, 0.0));
        let warnings = solids.insides.take_warnings().into_iter().map(|found| found.message);
        (found, warnings.collect::<Vec<_>>())
    };
    let text = format!("{}{twin}", bar(twins));
    assert_eq!(warned(&text), (2.0, vec!["`tip` and `twin` are at the same place".to_owned()]));
    assert!(warned(&text.replace("[-0.9, 0, 0]\nattribute.heat = 2", "[-0.6, 0, 0]\nattribute.heat = 2")).1.is_empty());
}

/// The surface is moved by what follows the inside of what it was.
#[test]
fn it_moves_the_surface() {
    let moved = field(&bar("attribute.swell = '0.1*way'\ndisplace = 'swell'"));
    for x in [-0.5, 0.0, 0.5] {
        let (mut inside, mut outside) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = (inside + outside) / 2.0;
            *(if moved.reference(DVec3::new(x, 0.0, middle)) > 0.0 { &mut inside } else { &mut outside }) = middle;
        }
        let far = DVec3::new(x, 0.0, 0.2).distance(DVec3::new(-0.9, 0.0, 0.0)) - 0.1;
        assert!((inside - (0.2 + 0.1 * far)).abs() < 2e-3, "{x}: {inside}, {far}");
    }
}

#[test]
fn what_stands_still_is_spread_once() {
    let found = |keys: &str| {
        let text = format!("frames = '1-9'\n{}", bar(keys));
        let (mut solids, id) = solids(&text);
        let variation = Variation::of(&solids.model());
        solids.paint(TheScalar("way"), id, Stage::Placed, 0.02).expect("no problem");
        let before = solids.insides.features.values().next().cloned().expect("it is spread");
        let mut later = solids.at(solids.model().moment(5.0), &variation);
        later.paint(TheScalar("way"), id, Stage::Placed, 0.02).expect("no problem");
        let after = later.insides.features.values().next().cloned().expect("it is spread");
        (Arc::ptr_eq(&before, &after), variation.painted(id))
    };
    assert_eq!(found("move = ['t', 0, 0]\nrotate = [0, 0, '90*t']"), (true, false));
    assert_eq!(found("scale = ['1 + t', 1, 1]"), (true, false));
    assert_eq!(found("offset = '0.01*t'"), (false, true));
    // A feature that moves.
    let text = format!("frames = '1-9'\n{}", bar("").replace("[-0.9, 0, 0]", "['t - 0.9', 0, 0]"));
    let (mut solids, id) = solids(&text);
    let variation = Variation::of(&solids.model());
    assert!(variation.painted(id));
    solids.paint(TheScalar("way"), id, Stage::Placed, 0.02).expect("no problem");
    let mut later = solids.at(solids.model().moment(5.0), &variation);
    assert!((number(&mut later, "way", AT) - (AT.distance(DVec3::new(-0.4, 0.0, 0.0)) - 0.1)).abs() < 1e-5);
}

/// What bends a shape carries its numbers along; features stand where it is straight.
#[test]
fn bends_carry_it_along() {
    let (mut straight, _) = solids(&bar(""));
    let (mut turned, _) = solids(&bar("do = [{ rotate = [0, 0, 90] }, { twist = 0 }]"));
    let found = number(&mut turned, "way", DVec3::new(-AT.y, AT.x, AT.z));
    assert!((found - number(&mut straight, "way", AT)).abs() < 1e-5, "{found}");
}

/// The shape of that name comes before the shape's own surface.
#[test]
fn a_shape_may_be_called_surface() {
    let text = bar("attribute.far = { interior = ['surface'], lattice = 24 }");
    let text = format!("{text}[shape.surface]\nsphere = 0.1\nmove = [0.9, 0, 0]\n");
    let found = number(&mut solids(&text).0, "far", AT);
    assert!((found - (AT.distance(DVec3::new(0.9, 0.0, 0.0)) - 0.1)).abs() < 1e-5, "{found}");
}

/// Ways go around a wall between two rooms that are open to one another at one end, where it is not very thin beside a
/// cell, and it is told where it is.
#[test]
fn no_way_leads_through_a_thin_wall_unsaid() {
    let rooms = |wall: f64, lattice: u32| {
        let walled = format!("difference = ['all', {{ box = [1.6, {wall}, 1], move = [-0.2, 0.013, 0] }}]");
        let text =
            bar("").replace("box = [2, 0.4, 0.4]", &walled).replace("lattice = 24", &format!("lattice = {lattice}"));
        format!("{}[shape.all]\nbox = [2, 0.4, 0.4]\n", text.replace("[-0.9, 0, 0]", "[-0.85, 0.12, 0]"))
    };
    let (start, end) = (DVec3::new(-0.85, 0.12, 0.0), DVec3::new(0.6, 0.013, 0.0));
    let says = |wall: f64, lattice: u32| {
        let (mut solids, _) = solids(&rooms(wall, lattice));
        let mut leads_around = true;
        for (x, y) in [(-0.9, -0.1), (-0.7, -0.02), (0.0, -0.15)] {
            let at = DVec3::new(x, y, 0.0);
            let around = start.distance(end) + end.distance(at) - 0.1;
            let found = number(&mut solids, "way", at);
            leads_around &= found > around - 1e-3 && found < around + 1.8 * 2.0 / f64::from(lattice);
        }
        let said = solids.insides.take_warnings();
        assert!(leads_around || !said.is_empty(), "a wall of {wall} in {lattice}");
        said
    };
    for (wall, lattice) in [(0.02, 24), (0.004, 24)] {
        assert!(says(wall, lattice).is_empty(), "{wall}, {lattice}");
    }
    let said = says(0.001, 24);
    assert!(said[0].message.starts_with("ways inside of `s` may lead through a wall about 1."), "{}", said[0].message);
    let lattice = said[0].help.strip_prefix("a `lattice` of ").and_then(|help| help.split(' ').next());
    assert!(says(0.001, lattice.expect("a lattice").parse().expect("a number")).is_empty());
    assert!(says(1e-4, 24)[0].help.starts_with("a `lattice` of 512, the most, sees walls of 1."));
}

#[test]
fn what_is_worth_saying() {
    let warned = |text: &str, wanted: &[&str]| {
        let (mut solids, id) = solids(text);
        solids.paint(TheScalar("way"), id, Stage::Placed, 0.02).expect("no problem");
        let found: Vec<String> = solids.insides.take_warnings().into_iter().map(|found| found.message).collect();
        assert!(found.len() == wanted.len(), "{found:?}");
        found.iter().zip(wanted).for_each(|(found, wanted)| assert!(found.starts_with(wanted), "{found}"));
        solids
    };
    warned(&bar(""), &[]);
    warned(&bar("").replacen("[-0.9, 0, 0]", "[0, 0.6, 0]", 1), &["all of `tip` is outside of `s`"]);
    // On the wall it is partly inside.
    warned(&bar("").replacen("[-0.9, 0, 0]", "[-1, 0, 0]", 1), &[]);
    let pieces = bar("").replace(
        "box = [2, 0.4, 0.4]",
        "union = [{ box = 0.4, move = [-0.8, 0, 0] }, { box = 0.4, move = [0.8, 0, 0] }, { box = 0.3 }]",
    );
    let mut solids =
        warned(&pieces, &["no way inside of `s` leads from `tip` to 2 pieces of it, the largest around (0."]);
    let found = number(&mut solids, "way", DVec3::new(0.7, 0.0, 0.0));
    assert!((found - 1.5).abs() < 0.1, "{found}");
}

#[test]
fn what_is_wrong() {
    let wrong = |text: &str, line: &str, wanted: &str| {
        let found = problems(text);
        assert!(found.iter().any(|found| found.starts_with(line) && found.contains(wanted)), "{wanted}\n{found:#?}");
    };
    let keys = |keys: &str, wanted: &str| wrong(&bar(keys), "6:", wanted);
    keys("attribute.a = { interior = [] }", "`shape.s.attribute.a.interior` needs at least one shape");
    keys("attribute.a = { interior = 'tip' }", "`shape.s.attribute.a.interior` must be a list of shapes");
    keys("attribute.a = { interior = ['tpi'] }", "`shape.tpi`");
    keys("attribute.a = { interior = ['tip', 'surface', 'tpi'] }", "`shape.tpi`");
    keys("attribute.a = { interior = ['s'] }", "`s` is made from itself");
    keys("attribute.a = { conformal = ['surface'] }", "`shape.surface`");
    keys("attribute.a = { interior = ['tip'], lattice = 8 }", "from 16 to 512");
    keys("color = { conformal = ['tip'], spread = 0 }", "from 0.000001 to 1");
    keys("color = { conformal = ['tip'], speed = 2 }", "`speed` is for `method = \"eikonal\"` only");
    keys(
        "attribute.a = { interior = ['tip'], method = 'sight', speed = 'x' }",
        "`speed` is for `method = \"eikonal\"`",
    );
    keys("attribute.a = { interior = ['tip'], method = 'eikonal', speed = 0 }", "must be greater than 0");
    keys("offset = 'way'", "`way` differs from place to place, and one number is needed here");
    keys(
        "attribute.b = { ramp = [[0, 0], [1, 1]], by = 'c' }\nattribute.c = '1 - b'",
        "`shape.s.attribute.b` is made from itself",
    );
    wrong(
        &bar("").replace("box = [2, 0.4, 0.4]", "formula = '1 - way'\nbounds = 2"),
        "4:",
        "`way` is an attribute of the shape that this formula makes",
    );
    // What is found once the shape is built.
    let failed = |text: &str, wanted: &str| {
        let (mut solids, id) = solids(text);
        let problem = solids.paint(TheScalar("way"), id, Stage::Placed, 0.02).err().expect(wanted);
        assert!(problem.0.message.starts_with(wanted), "{}", problem.0.message);
    };
    failed(
        &bar("").replace("lattice = 24", "lattice = 512").replace("0.4, 0.4]", "1.9, 1.9]"),
        "the inside of `s` takes about",
    );
    failed(&bar("").replace("lattice = 24", "method = 'eikonal', speed = 'x', lattice = 24"), "the speed at (-0.");
    failed(
        &bar("").replace("sphere = 0.1\nmove = [-0.9, 0, 0]", "formula = '-1'\nbounds = 1"),
        "nothing is inside `tip`, whose distance `interior` needs",
    );
    failed(&bar("").replace("box = [2, 0.4, 0.4]", "formula = '-1 - x^2'\nbounds = 2"), "nothing is inside `s`");
    let others: String = (10..74).map(|i| format!(", {{ sphere = 0.0{i} }}")).collect();
    let features = format!("'tip'{others}");
    let many = bar("").replace("interior = ['tip'], lattice = 24", &format!("conformal = [{features}], lattice = 24"));
    failed(&many, "`conformal` has 65 features, and 64 are the most");
}
