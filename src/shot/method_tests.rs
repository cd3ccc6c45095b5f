//! Methods that a scene names.

use crate::distance::accuracy::{compare, exact};
use crate::shot::displace_tests::band_of;
use crate::shot::scalar_tests::{prepared, wrong};
use glam::DVec3;

/// Two balls whose union is offset: by each method it is the offset of the solid, and no two methods say the same.
#[test]
fn a_shape_is_measured_by_the_method_that_it_names() {
    let bands = ["closest-point", "vector-dt", "fim"].map(|name| {
        let scene = prepared(&format!("[shape.a]\nellipsoid = [1, 0.8, 0.6]\noffset = 0.15\ndistance = '{name}'\n"));
        let band = band_of(&scene, 1);
        let found = compare(&band, |p| exact::ellipsoid(p, DVec3::new(1.0, 0.8, 0.6)) + 0.15);
        // The level that is baked is not that of the surface: it is as rough as the method.
        assert!(found.max <= 0.3 && found.mean <= 0.1 && found.voxels > 1000, "{name}: {found:?}");
        band.distances
    });
    assert!(bands[0] != bands[1] && bands[1] != bands[2]);
}

/// A ball's F is its distance, which is not measured unless another method is named.
#[test]
fn a_named_method_is_used_where_f_is_the_distance() {
    let surface = |rest: &str| band_of(&prepared(&format!("[shape.a]\nsphere = 1\noffset = 0.1\n{rest}")), 1).distances;
    assert!(surface("") == surface("distance = 'closest-point'"));
    assert!(surface("") != surface("distance = 'fim'"));
}

#[test]
fn the_output_names_a_method_or_takes_that_of_its_shape() {
    let written = |text: &str| prepared(text).model().written_distance();
    assert_eq!(written("[shape.a]\nsphere = 1\n"), "closest-point");
    assert_eq!(written("[shape.a]\nsphere = 1\ndistance = 'fim'\n"), "fim");
    assert_eq!(written("[output]\ndistance = 'vector-dt'\n[shape.a]\nsphere = 1\ndistance = 'fim'\n"), "vector-dt");
    let morph =
        "frames = '1-3'\n[shape.a]\nsphere = 1\ndistance = 'fim'\n[shape.b]\nbox = 1\n[morph]\nfrom = 'a'\nto = 'b'\n";
    assert_eq!(written(morph), "closest-point");
}

#[test]
fn a_morph_measures_its_objects_by_their_methods() {
    let volume = |name: &str| {
        let shapes = format!("[shape.a]\ntorus = 0.7\ntube = 0.25\ndistance = '{name}'\n[shape.b]\nsphere = 0.6\n");
        let scene = prepared(&format!("frames = '1-3'\n{shapes}[morph]\nfrom = 'a'\nto = 'b'\n"));
        scene.report(2).expect("a frame").expect("a morph").numbers.volume
    };
    let (usual, other) = (volume("closest-point"), volume("fim"));
    assert!((usual - other).abs() < 0.02 * usual && usual != other, "{usual} {other}");
}

#[test]
fn a_name_that_is_none_is_told_with_the_nearest() {
    wrong("[shape.a]\nsphere = 1\ndistance = 'fin'\n", "3:13 `shape.a.distance` cannot be `fin`");
    wrong("[output]\ndistance = 'vector'\n[shape.a]\nsphere = 1\n", "2:13 `output.distance` cannot be `vector`");
}
