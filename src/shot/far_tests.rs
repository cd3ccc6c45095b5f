//! What is far from the origin.

use crate::shot::scalar_tests::prepared;

/// A pattern goes with the shape that has it; that of a whole whose part was put far away goes by coarse coordinates.
#[test]
fn coordinates_that_are_too_large_for_patterns_are_told() {
    let said = |text: &str| prepared(text).warnings.to_string();
    let wood = "color = { wood = 0.25, colors = ['red', 'blue'] }";
    assert_eq!(said(&format!("[shape.a]\nsphere = 1\nmove = [1e6, 0, 0]\n{wood}\n")), "");
    let whole = |far: &str, paint: &str| {
        format!("[shape.a]\nsphere = 1\nmove = [{far}, 0, 0]\n[shape.u]\nunion = ['a']\n{paint}\n")
    };
    let far = said(&whole("1e6", wood));
    assert!(
        far.contains("`u` reaches 1000001 units")
            && far.contains("scene.toml:6:")
            && far.contains("0.0625 apart, 2.0 voxels"),
        "{far}"
    );
    let formula = said(&whole("1e6", "attribute.q = 'sin(25*x)'"));
    assert!(formula.contains("`u` reaches 1000001 units"), "{formula}");
    let ramp = "color = { ramp = [[0, 'red'], [1, 'blue']], by = 'x' }";
    assert!(said(&whole("1e6", ramp)).contains("`u` reaches 1000001 units"));
    // What goes by other coordinates, by time or by a distance, is as fine as ever.
    for fine in ["['y+0.5', 0.5, 0.5]", "['t', 0.5, 0.5]", "[\"dist('a')\", 0.5, 0.5]"] {
        assert_eq!(said(&whole("1e6", &format!("color = {fine}"))), "", "{fine}");
    }
    assert_eq!(said(&whole("1e6", "color = 'red'")), "");
    assert_eq!(said(&whole("1e6", "attribute.q = { noise = 0.25 }")), "");
    assert_eq!(said(&whole("1e3", wood)), "");
}
