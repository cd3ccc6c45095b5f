//! The tools around scenes: nodes searched, first scenes, values at a place, grids of parameters, slices of F.

mod support;

use std::fs;

use support::{Workplace, json};

#[test]
fn nodes_are_searched_and_shown() {
    let place = Workplace::new();
    let all = place.hfvdb("nodes").ok().stdout;
    assert!(all.contains("Solids\n  sphere ") && all.contains("\n  gyroid "), "{all}");
    let one = place.hfvdb("nodes torus_knot").ok().stdout;
    for part in
        ["Takes    ", "Formula  F = ", "Picture  docs/images/nodes/torus_knot.png", "Keys beside it", "torus_knot = "]
    {
        assert!(one.contains(part), "{part}\n{one}");
    }
    assert!(place.hfvdb("nodes involute").ok().stdout.contains("\n  gear "), "texts are searched");
    let both = json(&place.hfvdb("nodes noise --json").ok().stdout);
    assert_eq!(both["nodes"].as_array().map(Vec::len), Some(2), "of colours and of numbers");
    place.hfvdb("nodes gyroyd").fails(1, &["did you mean `gyroid`"]);
}

#[test]
fn first_scenes_are_written_once() {
    let place = Workplace::new();
    for kind in ["shape", "morph", "meshes"] {
        assert_eq!(place.hfvdb(&format!("new {kind}.toml --kind {kind}")).ok().stdout, format!("{kind}.toml\n"));
        place.hfvdb(&format!("check {kind}.toml --no-estimate")).ok();
    }
    let text = fs::read(place.path("shape.toml")).unwrap();
    place.hfvdb("new shape.toml --kind morph").fails(1, &["shape.toml is there already and stays as it is"]);
    assert_eq!(fs::read(place.path("shape.toml")).unwrap(), text);
    place.hfvdb("new shape.txt").fails(2, &["ends in .toml"]);
    place.hfvdb("new none/shape.toml").fails(1, &["shape.toml"]);
}

#[test]
fn a_place_is_probed() {
    let place = Workplace::new();
    place.write("two.toml", "[output]\nshape = 'u'\n[shape.u]\nunion = ['a', 'b']\n[shape.a]\nsphere = 1\ncolor = 'red'\n[shape.b]\nbox = 1\nmove = [3, 0, 0]\n");
    let told = place.hfvdb("probe two.toml 2 0 0").ok().stdout;
    assert!(told.contains("u (union)") && told.contains("  b (box)") && told.contains("distance 0.500000"), "{told}");
    let document = json(&place.hfvdb("probe two.toml -2 0 0 --json").ok().stdout);
    let union = &document["shapes"][0];
    // R₀ of −1 and −4.5, which is no distance; that of the ball is one.
    let joined = -5.5 + (1.0_f64 + 4.5 * 4.5).sqrt();
    assert!(union["value"].as_f64().is_some_and(|value| (value - joined).abs() < 1e-6), "{union}");
    assert!(union["distance"].is_null() && union["made_of"][0]["distance"] == 1.0, "{union}");
    assert_eq!(union["made_of"][0]["colour"][0].as_f64(), Some(1.0));
    place.hfvdb("probe two.toml 1 2").fails(2, &["3"]);
    place.hfvdb("probe two.toml 1 2 inf").fails(2, &["three numbers"]);
    // The two ends of a morph, at any frame.
    let ends = json(&place.hfvdb("probe cube-to-heart 0 0 0 --frame 12 --json").ok().stdout);
    assert_eq!(ends["shapes"].as_array().map(Vec::len), Some(2));
}
