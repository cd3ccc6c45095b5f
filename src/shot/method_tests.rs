//! Methods and travel times that a scene names.

use crate::bake::{self, Bytes, Computed, Interrupt};
use crate::distance::accuracy::{compare, exact};
use crate::distance::method::Choice;
use crate::distance::octree::Restore;
use crate::distance::step::smooth_step;
use crate::shot::Prepared;
use crate::shot::displace_tests::band_of;
use crate::shot::scalar_tests::{loaded, prepared, refused, scalar, wrong};
use glam::{DVec2, DVec3};

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
    let written = |text: &str| prepared(text).model().written_distance().method;
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

/// A tree that is coarser than what is written loses what is thin.
#[test]
fn a_depth_that_is_coarser_than_voxels_is_told() {
    let said = |distance: &str| prepared(&format!("[shape.a]\nsphere = 1\n{distance}\n")).warnings.to_string();
    // The root is 8 long, and a voxel a 32nd.
    let coarse = said("distance = { adf = 6 }");
    assert!(coarse.contains("`adf = 6` has cells as large as 4.0 voxels") && coarse.contains("`adf = 8`"), "{coarse}");
    for fine in ["distance = { adf = 8 }", "distance = 'adf'", ""] {
        assert!(!said(fine).contains("cells as large"), "{fine}");
    }
}

#[test]
fn a_name_that_is_none_is_told_with_the_nearest() {
    wrong("[shape.a]\nsphere = 1\ndistance = 'fin'\n", "3:13 `shape.a.distance` cannot be `fin`");
    wrong("[output]\ndistance = 'vector'\n[shape.a]\nsphere = 1\n", "2:13 `output.distance` cannot be `vector`");
}

/// A table is `adf` with its settings; a depth of what has none is unknown.
#[test]
fn an_adaptive_distance_takes_a_depth() {
    let written = |text: &str| prepared(&format!("[shape.a]\nsphere = 1\n{text}")).model().written_distance();
    let adf = Choice { depth: Some(7), ..Choice::by("adf") };
    assert_eq!(written("distance = { adf = 7 }\n"), adf);
    let linear = Choice { restore: Restore::Linear, ..adf };
    assert_eq!(written("distance = { adf = 7, restore = 'linear' }\n"), linear);
    assert_eq!(written("[output]\ndistance = { adf = 7, restore = 'linear' }\n"), linear);
    wrong(
        "[shape.a]\nsphere = 1\ndistance = { adf = 7, restore = 'cubic' }\n",
        "3:34 `shape.a.distance.restore` cannot be `cubic`",
    );
    for (text, told) in
        [("{ fim = 7 }", "fim"), ("{ adf = 30 }", "adf"), ("{ adf = 2 }", "adf"), ("{}", "adf"), ("7", "distance")]
    {
        let problems = loaded(&format!("[shape.a]\nsphere = 1\ndistance = {text}\n")).expect_err(text);
        assert!(problems.to_string().contains(told) && problems.to_string().contains("scene.toml:3:"), "{problems}");
    }
}

/// Deeper trees are more right, and linear ones less, at the offset surface of a ball.
#[test]
fn depth_and_restoration_are_those_of_the_distance() {
    let error = |distance: &str| {
        let scene = prepared(&format!("[shape.a]\nellipsoid = [1, 0.999, 1]\noffset = 0.15\ndistance = {distance}\n"));
        compare(&band_of(&scene, 1), |p| exact::sphere(p, DVec3::ZERO, 1.15)).mean
    };
    let [coarse, fine, linear] = ["{ adf = 5 }", "{ adf = 8 }", "{ adf = 5, restore = 'linear' }"].map(error);
    assert!(fine < 0.05 && coarse > 2.0 * fine && linear > 2.0 * coarse, "{coarse} {fine} {linear}");
}

#[test]
fn an_octree_that_fits_into_no_memory_is_refused_where_its_depth_stands() {
    let said = refused("[shape.a]\nellipsoid = [1, 0.9, 0.8]\noffset = 0.1\ndistance = { adf = 20 }\n");
    assert!(said.contains("scene.toml:4:12") && said.contains("take a smaller depth"), "{said}");
    let scene = prepared("[output]\ndistance = { adf = 20 }\n[shape.a]\nsphere = 1\n");
    let error = computed(&scene).expect_err("too deep").to_string();
    assert!(error.contains("scene.toml:2:12") && error.contains("take a smaller depth"), "{error}");
}

fn computed(scene: &Prepared) -> Result<Computed, bake::Error> {
    bake::compute_frame(scene, 1, 1, Bytes(4 << 30), &Interrupt::default(), &|_| {})
}

/// A disc by a function that is not its distance, moved outward in the plane.
#[test]
fn shapes_of_the_plane_are_measured_there() {
    let disc = "[shape.a]\nextrude = 'd'\nheight = 0.5\n[shape.d]\nsuperellipse = 1\nexponent = 2\noffset = 0.25\n";
    for distance in ["closest-point", "adf"] {
        let scene = prepared(&format!("{disc}distance = '{distance}'\n"));
        let found = compare(&band_of(&scene, 1), |p| exact_disc(p, 1.25, 0.25));
        assert!(found.voxels > 1000 && found.max < 0.1 && found.wrong_signs == 0, "{distance}: {found:?}");
    }
    let said = refused(&format!("{disc}distance = 'fim'\n"));
    assert!(said.contains("`fim` measures solids only") && said.contains("scene.toml:8:13"), "{said}");
}

/// Two discs as one shape of the plane, read in a formula far from its outline, whatever z.
#[test]
fn a_formula_reads_the_distance_in_the_plane() {
    let scene = prepared(
        "output.shape = 'r'\n[shape.r]\nrectangle = 2\nattribute.q = \"dist('c')\"\n\
         [shape.c]\nunion = [{ circle = 0.3, move = [-0.2, 0, 0] }, { circle = 0.3, move = [0.2, 0, 0] }]\n",
    );
    let frame = scene.frame(1).expect("a frame");
    for (x, y) in [(0.9, 0.1), (-0.3, 0.05), (0.6, -0.7)] {
        let exact = 0.3 - (f64::abs(x) - 0.2).hypot(y);
        for z in [0.0, 0.1] {
            let value = f64::from(scalar(&frame, "q", [x, y, z]));
            assert!((value - exact).abs() < 0.02, "{x} {y} {z}: {value} for {exact}");
        }
    }
}

/// A cylinder about z, by its radius and half its height.
fn exact_disc(p: DVec3, radius: f64, half: f64) -> f64 {
    let (across, along) = (p.x.hypot(p.y) - radius, p.z.abs() - half);
    -(across.max(along).min(0.0) + across.max(0.0).hypot(along.max(0.0)))
}

/// What a slice draws of a shape of the plane is the plane's: F, and the distance by quadtrees of two depths, everywhere.
#[test]
fn a_slice_draws_the_plane() {
    let star = "[shape.s]\nintersection = [{ circle = 1, move = [-0.4, 0, 0] }, { circle = 1, move = [0.4, 0, 0] }]\n";
    let error = |distance: &str| {
        let scene = prepared(&format!("{star}distance = {distance}\n"));
        let shape = scene.in_plane(1).expect("a frame").expect("a shape of the plane");
        let drawn = scene.distance_in_plane(1, &shape).expect("a distance");
        let mut worst = 0.0_f64;
        for i in 0..400 {
            let p = DVec3::new(f64::from(i % 20) - 9.5, f64::from(i / 20) - 9.5, 3.0) * 0.15;
            // A lens: its arcs, and beyond the ends of these its corners.
            let far = p + DVec3::X * 0.4_f64.copysign(p.x);
            let arc = 1.0 - far.truncate().length();
            let foot = far.truncate().normalize();
            let is_arc = foot.y.abs() <= 0.84_f64.sqrt();
            let corner = -(p.truncate().abs() - DVec2::new(0.0, 0.84_f64.sqrt())).length();
            let truth = if is_arc { arc } else { corner };
            assert_eq!(shape.0.reference(p) >= 0.0, truth >= 0.0, "{p}");
            assert_eq!(drawn.distance.reference(p) >= 0.0, truth >= 0.0, "{p}");
            worst = worst.max((drawn.distance.reference(p) - truth).abs() / truth.abs().max(0.1));
        }
        (worst, drawn.report)
    };
    let (usual, coarse, linear) = (error("'adf'"), error("{ adf = 6 }"), error("{ adf = 6, restore = 'linear' }"));
    let exact = error("'closest-point'");
    assert!(exact.0 < 1e-4 && exact.1.is_none(), "{exact:?}");
    let trees = [coarse.1, linear.1].map(|report| report.expect("a tree"));
    assert!(usual.0 < 0.03 && coarse.0 > usual.0 && linear.0 > coarse.0, "{usual:?} {coarse:?} {linear:?}");
    assert!(trees[0].depth == 6 && trees[0].hanging > 0 && trees[0].cells == trees[1].cells, "{trees:?}");
    assert!(prepared("[shape.a]\nsphere = 1\n").in_plane(1).expect("a frame").is_none());
}

/// Distances with the smooth step: what is written, what is drawn, and a warning that says what is lost.
#[test]
fn a_smooth_step_takes_the_place_of_the_sign() {
    let scene = prepared("[shape.a]\nsphere = 1\nstep = 2\n");
    let voxel = scene.lattice.voxel_size.get();
    let warnings = scene.model().warnings.to_string();
    assert!(warnings.contains("no slope on the surface") && warnings.contains("scene.toml:3:8"), "{warnings}");
    let band = computed(&scene).expect("a frame").band;
    let found = compare(&band, |p| smooth_step(exact::sphere(p, DVec3::ZERO, 1.0), 2.0 * voxel));
    assert!(found.wrong_signs == 0 && found.mean < 1e-3, "{found:?}");
    let content = scene.frame(1).expect("a frame");
    let drawn = scene.distance(1, &content.field, 1 << 30).expect("a distance").distance;
    for x in [0.0, 0.9, 0.99, 1.0, 1.03, 1.5] {
        let truth = smooth_step(1.0 - x, 2.0 * voxel);
        assert!((drawn.reference(DVec3::X * x) - truth).abs() < 0.02 * truth.abs().max(voxel), "{x}");
    }
    let plain = prepared("[shape.a]\nsphere = 1\n");
    assert!(plain.model().written_step().is_none());
    assert_eq!(prepared("[output]\nstep = 0.5\n[shape.a]\nsphere = 1\n").model().written_step(), Some(0.5));
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
