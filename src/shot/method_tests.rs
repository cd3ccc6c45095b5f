//! Methods and travel times that a scene names.

use crate::distance::accuracy::{compare, exact};
use crate::shot::displace_tests::band_of;
use crate::shot::scalar_tests::{prepared, refused, scalar, wrong};
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

const BAR: &str = "[shape.match]\nbox = [0.4, 2, 2]\nmove = [-1.2, 0, 0]\n[output]\nshape = 'bar'\n[shape.bar]\nbox = [2, 0.4, 0.4]\n";

/// From one end of a bar to the other, and what is made of it.
#[test]
fn a_scalar_is_the_time_that_travelling_takes() {
    let scene = prepared(&format!(
        "{BAR}attribute.late = {{ travel = ['match'], speed = 0.5 }}\nattribute.soon = {{ travel = ['match'], speed = 'x + 2' }}\n"
    ));
    let frame = scene.frame(1).expect("a frame");
    for x in [-0.9, -0.3, 0.0, 0.4, 0.95] {
        let at = [x, 0.2, 0.1];
        let value = scalar(&frame, "late", at);
        assert!((f64::from(value) - (x + 1.0) / 0.5).abs() < 1.5 / 32.0 / 0.5, "{x}: {value}");
        let value = scalar(&frame, "soon", at);
        assert!((f64::from(value) - libm::log(x + 2.0)).abs() < 1.5 / 32.0, "{x}: {value}");
    }
}

/// It displaces the surface that it is found for, and delays a morph.
#[test]
fn a_travel_time_moves_surfaces_and_delays_morphs() {
    let moved = prepared(&format!("{BAR}attribute.w = {{ travel = ['match'], speed = 20 }}\ndisplace = 'w'\n"));
    let found = compare(&band_of(&moved, 1), |p| {
        // Near the middle of a side, which stays a plane but for the slope.
        if p.x.abs() < 0.5 && p.y > 0.1 && p.z.abs() < 0.05 {
            (0.2 + (p.x + 1.0) / 20.0 - p.y) / (1.0_f64 + 1.0 / 400.0).sqrt()
        } else {
            f64::NAN
        }
    });
    assert!(found.max < 0.3, "{found:?}");
    let morph = "[shape.ball]\nsphere = 0.5\n[morph]\nfrom = 'bar'\nto = 'ball'\n\
                 delay = { shape = 'bar', attribute = 'w', most = 0.9 }\n";
    let text = BAR.replace("[output]\nshape = 'bar'\n", "");
    let scene = prepared(&format!("frames = '1-5'\n{text}attribute.w = {{ travel = ['match'], speed = 4 }}\n{morph}"));
    assert!(scene.report(3).expect("a frame").expect("a morph").numbers.volume > 0.0);
}

#[test]
fn what_cannot_be_travelled_is_told() {
    let told = |rest: &str, wanted: &str| {
        let error = refused(&format!("{BAR}attribute.w = {rest}\n"));
        assert!(error.contains(wanted), "{error}");
    };
    told("{ travel = ['match'], speed = 'x' }", "the speed at (-");
    told("{ travel = ['match'], speed = 'x' }", "--> scene.toml:8:");
    told("{ travel = ['match'], speed = 'sqrt(-1 - x*x)' }", "is NaN: it must be a finite number greater than 0");
    let far = BAR.replace("-1.2", "-5");
    let error = refused(&format!("{far}attribute.w = {{ travel = ['match'] }}\n"));
    assert!(error.contains("nothing that it starts from meets the inside"), "{error}");
    let two = "[shape.a]\nunion = ['b', 'c']\nattribute.w = { travel = ['b'] }\n[shape.b]\nsphere = 1\n[shape.c]\nsphere = 1\nmove = [4, 0, 0]\n";
    let error = refused(two);
    assert!(error.contains("no way inside leads to (3") && error.contains("add a shape there"), "{error}");
    wrong(
        &format!("{BAR}attribute.w = {{ travel = 'match' }}\n"),
        "8:27 `shape.bar.attribute.w.travel` must be a list of shapes",
    );
    wrong(
        &format!("{BAR}attribute.w = {{ travel = ['match'], speed = -1 }}\n"),
        "8:45 `shape.bar.attribute.w.speed` must be greater than 0",
    );
}
