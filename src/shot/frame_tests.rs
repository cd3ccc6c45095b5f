//! Frames made from scenes: where they are inside, how large voxels are, which colours they have.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use crate::attribute::{Colour, LinearRgb, from_srgb};
use crate::field::{BATCH, Points};

use super::*;
use crate::node::*;
use crate::text::*;

pub(crate) fn prepared_with(text: &str, resolution: Option<u32>) -> Result<Prepared, Error> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    let source = Source::Text { name: "scene.toml".into(), text: text.into(), folder };
    let model = load(&source, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}"));
    prepare(model, resolution)
}

fn prepare(model: Model, resolution: Option<u32>) -> Result<Prepared, Error> {
    Arc::new(model).prepare(&options(resolution, &|_, _| ()))
}

pub(crate) fn options(resolution: Option<u32>, progress: &(dyn Fn(f64, &str) + Sync)) -> PrepareOptions<'_> {
    PrepareOptions {
        voxel_size: None,
        resolution,
        half_width: None,
        memory_limit: None,
        cache: None,
        cancel: Arc::default(),
        progress,
    }
}

fn prepared(text: &str) -> Prepared {
    prepared_with(text, None).unwrap_or_else(|error| panic!("{error}"))
}

#[track_caller]
pub(crate) fn refused(text: &str, wanted: &str) {
    let error = prepared_with(text, None).err().expect("it is refused").to_string();
    assert!(error.contains(wanted), "{error}");
}

fn value(frame: &FrameContent, x: f64, y: f64, z: f64) -> f64 {
    frame.field.reference(DVec3::new(x, y, z))
}

fn colour(frame: &FrameContent, x: f64, y: f64, z: f64) -> LinearRgb {
    sample(frame.colour.as_ref().expect("it has a colour").as_ref(), DVec3::new(x, y, z))
}

pub(crate) fn sample(colour: &Colour, at: DVec3) -> LinearRgb {
    let mut points = Points::new(at);
    points.push(Vec3::ZERO);
    let mut out = [[0.0; 3]; BATCH];
    colour.sampler().sample(&points, &mut out);
    out[0]
}

const RED: LinearRgb = [1.0, 0.0, 0.0];
const BLUE: LinearRgb = [0.0, 0.0, 1.0];

#[test]
fn a_ball_and_its_voxels() {
    let ball = prepared("[shape.a]\nsphere = 2\nmove = [1, 0, 0]\n");
    assert!((ball.extent.size().max_element() - 4.0).abs() < 0.02, "{:?}", ball.extent);
    assert!((ball.lattice.voxel_size.get() - 4.0 / 256.0).abs() < 1e-4);
    let frame = ball.frame(7).unwrap();
    assert!((value(&frame, 2.5, 0.0, 0.0) - 0.5).abs() < 1e-12);
    assert!(frame.colour.is_none());
    assert!(frame.info.outside_shot && frame.info.t == 0.0);
    assert!(frame.region.contains(DVec3::new(3.0, 2.0, 2.0)));
    let fine = prepared_with("[shape.a]\nsphere = 2\n[output]\nvoxel_size = 0.5\n", None).unwrap();
    assert_eq!(fine.lattice.voxel_size.get(), 0.5);
    let coarse = prepared_with("[shape.a]\nsphere = 2\n[output]\nvoxel_size = 0.5\n", Some(10)).unwrap();
    assert!((coarse.lattice.voxel_size.get() - 0.4).abs() < 0.01);
}

#[test]
fn rotation_is_about_fixed_x_then_y_then_z() {
    // What Blender 5.0 answers: `Euler((radians(90), 0, radians(90)), 'XYZ').to_matrix() @ Vector((0, 1, 0))` is
    // (0, 0, 1), and of (1, 0, 0) it is (0, 1, 0).
    let text = "[shape.a]\nunion = ['b']\nrotate = [90, 0, 90]\nmove = [0, 0, 5]\n[shape.b]\nsphere = 0.5\n";
    let at = |place: &str| {
        let scene = prepared(&format!("{text}move = {place}\n"));
        let extent = scene.extent.centre();
        (extent * 100.0).round() / 100.0
    };
    assert_eq!(at("[0, 1, 0]"), DVec3::new(0.0, 0.0, 6.0));
    assert_eq!(at("[1, 0, 0]"), DVec3::new(0.0, 1.0, 5.0));
    // Scaled before it is moved.
    let scaled = prepared("[shape.a]\nbox = 1\nscale = [2, 1, 1]\nrotate = [0, 0, 90]\nmove = [10, 0, 0]\n");
    let frame = scaled.frame(1).unwrap();
    assert!(value(&frame, 10.0, 0.9, 0.0) > 0.0 && value(&frame, 10.9, 0.0, 0.0) < 0.0);
}

#[test]
fn set_operations_and_modifiers() {
    let text = |maker: &str| format!("[shape.r]\n{maker}\n[shape.a]\nbox = 2\n[shape.b]\nbox = 2\nmove = [1, 0, 0]\n");
    let inside = |maker: &str, x: f64| value(&prepared(&text(maker)).frame(1).unwrap(), x, 0.0, 0.0) > 0.0;
    let xs = [-0.5, 0.5, 1.5];
    assert_eq!(xs.map(|x| inside("union = ['a', 'b']", x)), [true, true, true]);
    assert_eq!(xs.map(|x| inside("intersection = ['a', 'b']", x)), [false, true, false]);
    assert_eq!(xs.map(|x| inside("difference = ['a', 'b']", x)), [true, false, false]);
    let ball = |modifiers: &str, x: f64| {
        let scene = prepared(&format!("[shape.a]\nsphere = 1\n{modifiers}\n"));
        value(&scene.frame(1).unwrap(), x, 0.0, 0.0) > 0.0
    };
    assert!(ball("offset = 0.5", 1.4) && !ball("offset = 0.5", 1.6));
    assert!(ball("shell = 0.2", 1.05) && ball("shell = 0.2", -0.95) && !ball("shell = 0.2", 0.8));
    assert!(!ball("bounds = 1", 0.6) && ball("bounds = 1", 0.4));
    let cut = prepared("[shape.a]\nformula = '1 - x^2 - y^2 - z^2'\nbounds = [[-2, -2, -2], [0.5, 2, 2]]\n");
    let warnings = cut.warnings.to_string();
    assert!(warnings.starts_with("warning: `bounds` cut `a` off at +x\n --> scene.toml:3:10\n"), "{warnings}");
    assert!(warnings.contains("cut = true"), "{warnings}");
    // Later frames too, with their number.
    let later = prepared("frames = '1-10'\n[shape.a]\nsphere = '1 + t'\nbounds = 2.5\n").warnings.to_string();
    assert!(later.contains("`bounds` cut `a` off at -x, +x, -y, +y, -z, +z in frame"), "{later}");
    let meant = "bounds = { box = [[-2, -2, -2], [0.5, 2, 2]], cut = true }\n";
    let meant = prepared(&format!("[shape.a]\nformula = '1 - x^2 - y^2 - z^2'\n{meant}"));
    assert!(meant.warnings.is_empty(), "{}", meant.warnings);
    assert_eq!(meant.extent.max.x, cut.extent.max.x);
    let mirrored = prepared("[shape.m]\nunion = ['a']\nmirror = 'x'\n[shape.a]\nsphere = 0.5\nmove = [2, 0, 0]\n");
    let frame = mirrored.frame(1).unwrap();
    assert!(value(&frame, 2.0, 0.0, 0.0) > 0.0 && value(&frame, -2.0, 0.0, 0.0) > 0.0);
    let formula = prepared("[param]\nr = 0.5\n[shape.a]\nformula = 'r^2 - x^2 - y^2 - z^2'\nbounds = 3\n");
    assert!((formula.extent.size().x - 1.0).abs() < 0.02);
}

#[test]
fn shapes_change_from_frame_to_frame() {
    let scene = prepared("frames = '1-5'\n[shape.a]\nsphere = '1 + t'\nmove = [{ 1 = 0, 5 = 4 }, 0, 0]\n");
    assert!((scene.extent.min.x + 1.0).abs() < 0.02 && (scene.extent.max.x - 6.0).abs() < 0.02, "{:?}", scene.extent);
    let at = |frame: i64| value(&scene.frame(frame).unwrap(), 0.0, 0.0, 0.0);
    assert!((at(1) - 1.0).abs() < 1e-9 && (at(3) - (1.5 - 2.0)).abs() < 1e-9, "{} {}", at(1), at(3));
    assert_eq!(at(5), at(99));
    refused(
        "frames = '1-5'\n[shape.a]\nsphere = '1 - 2*t'\n",
        "`shape.a.sphere` is 0 at frame 3, and must be greater than 0\n --> scene.toml:3:11",
    );
}

#[test]
fn colours_of_parts() {
    let text = "[shape.u]\nunion = ['a', 'b', 'c']\n[shape.a]\nsphere = 1\ncolor = 'red'\n\
                [shape.b]\nsphere = 1\ncolor = 'blue'\nmove = [3, 0, 0]\n[shape.c]\nsphere = 1\nmove = [6, 0, 0]\n";
    let frame = prepared(text).frame(1).unwrap();
    let grey = colour(&frame, 7.0, 0.0, 0.0);
    assert_eq!([colour(&frame, -1.0, 0.0, 0.0), colour(&frame, 2.0, 0.0, 0.0)], [RED, BLUE]);
    assert!((grey[0] - 0.603_827_4).abs() < 1e-6, "{grey:?}");
    // The whole union in one colour; what is cut shows the first one's.
    let one = prepared(&text.replace("['a', 'b', 'c']", "['a', 'b', 'c']\ncolor = 'blue'")).frame(1).unwrap();
    assert_eq!(colour(&one, -1.0, 0.0, 0.0), BLUE);
    let cut = "[shape.d]\ndifference = ['a', 'b']\nrotate = [0, 0, 90]\n[shape.a]\nsphere = 1\ncolor = 'red'\n\
               [shape.b]\nbox = 2\ncolor = 'blue'\nmove = [1, 0, 0]\n";
    assert_eq!(colour(&prepared(cut).frame(1).unwrap(), 0.0, 0.0, 0.0), RED);
    // Two colours, turned: what was at −x is at −y.
    let turned = "[shape.t]\nunion = ['a', 'b']\nrotate = [0, 0, 90]\n[shape.a]\nsphere = 1\ncolor = 'red'\nmove = [-2, 0, 0]\n\
                  [shape.b]\nsphere = 1\ncolor = 'blue'\nmove = [2, 0, 0]\n";
    let frame = prepared(turned).frame(1).unwrap();
    assert_eq!([colour(&frame, 0.0, -3.0, 0.0), colour(&frame, 0.0, 3.0, 0.0)], [RED, BLUE]);
}

#[test]
fn what_cannot_be_built_is_said_with_its_place() {
    refused("[shape.a]\nformula = '1 - x^2'\n", "`a` may reach to infinity\n --> scene.toml:1:8");
    refused(
        "[shape.u]\nunion = ['a', 'b']\n[shape.a]\nsphere = 1\n[shape.b]\nhalf_space = [0, 0, 1]\n",
        "scene.toml:5:8",
    );
    refused("[shape.a]\nformula = '-1 - x^2 - y^2 - z^2'\nbounds = 2\n", "nothing is inside `a`\n --> scene.toml:1:8");
    refused("[shape.a]\nsphere = 1e-7\n", "are too small for OpenVDB");
    refused(
        "[shape.a]\nunion = ['b', 'c']\n[shape.b]\nsphere = 1\n[shape.c]\nslab = 1\nnormal = [0, 0, 0]\n",
        "a direction needs a length other than 0\n --> scene.toml:7:11",
    );
    refused(
        "frames = '1-9'\n[shape.a]\nsphere = '1 + t'\n[shape.b]\nbox = 1\n[morph]\nfrom = 'a'\nto = 'b'\n",
        "`a` changes its shape over time, and so cannot enter a morph\n --> scene.toml:2:8",
    );
}

#[test]
fn a_morph_begins_and_ends_as_its_objects() {
    let text = "frames = '1-9'\n[shape.a]\nsphere = 1\ncolor = 'red'\nmove = ['-1.5 - t', 0, 0]\n\
                [shape.b]\nbox = 1.5\ncolor = 'blue'\nmove = [1.5, 0, 0]\nscale = [1, 2, 1]\n\
                [morph]\nfrom = 'a'\nto = 'b'\n";
    let scene = prepared_with(text, Some(48)).unwrap_or_else(|error| panic!("{error}"));
    let (first, last) = (scene.frame(1).unwrap(), scene.frame(9).unwrap());
    assert!((value(&first, -1.5, 0.0, 0.0) - 1.0).abs() < 1e-9);
    assert_eq!(colour(&first, -2.5, 0.0, 0.0), RED);
    assert!(value(&last, 1.5, 1.4, 0.0) > 0.0 && value(&last, 1.5, 1.6, 0.0) < 0.0);
    assert_eq!(colour(&last, 1.5, 1.5, 0.0), BLUE);
    let middle = scene.frame(5).unwrap();
    let [red, _, blue] = colour(&middle, 0.0, 0.0, 0.0);
    assert!(red > 0.01 && blue > 0.01, "{red} {blue}");
    assert!(scene.memory_estimate() > 0);
    // Any frame alone: asked for again, and by another preparation, it is the same.
    let again = prepared_with(text, Some(48)).unwrap_or_else(|error| panic!("{error}")).frame(5).unwrap();
    for x in [-1.0, 0.0, 0.3, 2.0] {
        assert_eq!(value(&again, x, 0.1, 0.0), value(&middle, x, 0.1, 0.0));
    }
}

#[test]
fn cells_and_copies_take_colours_of_the_palette() {
    let text = "palette.p = ['red', 'blue']\n[cells.c]\noctree = 'block'\ndepth = 2\n[shape.block]\nmesh = 'cube.obj'\n\
                [shape.u]\nunion = ['faces', 'eyes']\n\
                [shape.faces]\nfacet = 'block'\ncells = 'c'\ncolor = { palette = 'p' }\n\
                [shape.eyes]\nsphere = 0.1\nat = { cells = 'c', pick = 0.3 }\ncolor = { palette = ['lime'] }\n";
    let scene = prepared_with(text, Some(32)).unwrap_or_else(|error| panic!("{error}"));
    let frame = scene.frame(1).unwrap();
    assert!(value(&frame, 0.0, 0.0, 0.0) > 0.0 && value(&frame, 1.3, 1.3, 1.3) < 0.0);
    let mut seen = [0; 3];
    // A little inside and outside of the six sides of the cube, whose edge is 1.6.
    for i in 0..2400 {
        let (a, b) = (f64::from(i % 20) / 10.0 - 0.95, f64::from(i / 20 % 20) / 10.0 - 0.95);
        let side = if i / 400 % 2 == 0 { 0.75 } else { -0.85 };
        let (x, y, z) = [(a, b, side), (b, side, a), (side, a, b)][i as usize / 800];
        // On the way out of all parts their colours mix.
        if value(&frame, x, y, z) <= 0.0 {
            continue;
        }
        match colour(&frame, x, y, z) {
            RED => seen[0] += 1,
            BLUE => seen[1] += 1,
            [0.0, 1.0, 0.0] => seen[2] += 1,
            other => panic!("{other:?}"),
        }
    }
    assert!(seen.iter().all(|count| *count > 0), "{seen:?}");
    let open = text.replace("mesh = 'cube.obj'", "slab = 1");
    refused(&open, "`c`: cells need a shape of finite extent");
}

#[test]
fn a_morph_of_two_meshes() {
    let cube = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cube.obj"));
    let shot = FrameRange { first: 1, last: 4 };
    let bridge = Overrides { set: vec!["morph.bridge=1".into(), "shape.to.move=[3, 0, 0]".into()], variant: None };
    let model = morph_of_meshes(&cube, &cube, shot, &bridge).unwrap_or_else(|problems| panic!("{problems}"));
    let scene = prepare(model, Some(24)).unwrap_or_else(|error| panic!("{error}"));
    let (first, last) = (scene.frame(1).unwrap(), scene.frame(4).unwrap());
    let middles = [value(&first, 0.0, 0.0, 0.0), value(&last, 3.0, 0.0, 0.0)];
    assert!(middles.iter().all(|middle| (middle - 0.8).abs() < 1e-9), "{middles:?}");
    assert!(first.colour.is_none());
    let missing =
        morph_of_meshes(&cube, &PathBuf::from("no \"such\" $x.obj"), shot, &Overrides::default()).unwrap_err();
    assert!(missing.to_string().contains("there is no file `no \"such\" $x.obj`"), "{missing}");
}

#[test]
fn a_cut_shows_the_inside() {
    let text = "frames = '1-5'\n[shape.a]\nsphere = 1\ncolor = 'red'\n[shape.b]\nbox = 1.5\n\
                [shape.front]\nhalf_space = [0, 1, 0]\n[morph]\nfrom = 'a'\nto = 'b'\ncut = 'front'\n";
    let scene = prepared_with(text, Some(24)).unwrap_or_else(|error| panic!("{error}"));
    for number in 1..=5 {
        let frame = scene.frame(number).unwrap();
        assert!(value(&frame, 0.0, 0.3, 0.0) > 0.0 && value(&frame, 0.0, -0.3, 0.0) < 0.0);
        assert!(value(&frame, 0.0, 0.0, 0.0).abs() < 1e-9);
        colour(&frame, 0.0, 0.0, 0.0);
    }
}

#[test]
fn built_in_stills_are_made() {
    for name in ["sphere", "heart"] {
        let model = load(&Source::Builtin(name.into()), &Overrides::default()).unwrap();
        let scene = prepare(model, Some(64)).unwrap_or_else(|error| panic!("{error}"));
        let frame = scene.frame(1).unwrap();
        assert!(value(&frame, 0.0, 0.0, 0.0) > 0.0 && frame.colour.is_some());
    }
}

#[track_caller]
fn assert_close(colour: LinearRgb, wanted: LinearRgb) {
    assert!(colour.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-5), "{colour:?} for {wanted:?}");
}

#[test]
fn colours_by_formula() {
    let text = "frames = '1-5'\n[shape.a]\nsphere = 1\nscale = 2\nmove = [10, 0, 0]\n\
                color = ['x', '2*y', { 1 = 0, 5 = 1 }]\n";
    let scene = prepared(text);
    // Space is the shape's own, numbers are sRGB, formulas are held to 0 … 1.
    let at = |frame: i64, x: f64, y: f64| colour(&scene.frame(frame).unwrap(), x, y, 0.0);
    assert_close(at(1, 11.0, 1.5), from_srgb([0.5, 1.0, 0.0]));
    assert_close(at(3, 9.0, 0.5), from_srgb([0.0, 0.5, 0.5]));
    let bright = prepared("[shape.a]\nsphere = 1\ncolor = { linear = ['3*x', '-x', 0.25] }\n").frame(1).unwrap();
    assert_close(colour(&bright, 1.0, 0.0, 0.0), [3.0, 0.0, 0.25]);
    let wheel = prepared("[shape.a]\nsphere = 1\ncolor = { hsv = ['240*x', 1, 1] }\n").frame(1).unwrap();
    assert_close(colour(&wheel, 1.0, 0.0, 0.0), BLUE);
}

#[test]
fn colours_by_formula_change_in_a_morph_too() {
    let text = "frames = '1-5'\n[shape.a]\nsphere = 1\ncolor = [1, 't', 0]\n[shape.b]\nbox = 1.5\ncolor = [0, 0, 't']\n\
                move = [0, 0, 't']\n[morph]\nfrom = 'a'\nto = 'b'\n";
    let scene = prepared_with(text, Some(24)).unwrap_or_else(|error| panic!("{error}"));
    assert_close(colour(&scene.frame(1).unwrap(), 1.0, 0.0, 0.0), RED);
    assert_close(colour(&scene.frame(5).unwrap(), 0.0, 0.0, 1.0), BLUE);
    let still =
        prepared_with(&text.replace("[1, 't', 0]", "[1, 0, 0]"), Some(24)).unwrap_or_else(|error| panic!("{error}"));
    let green = |scene: &Prepared| colour(&scene.frame(3).unwrap(), 0.0, 0.0, -0.9)[1];
    assert!(green(&scene) > green(&still) + 0.01, "{} {}", green(&scene), green(&still));
}

#[test]
fn bands_go_by_distance_below_the_surface() {
    // F of the first is no distance, that of the second is: both have the same bands.
    for (maker, x) in [("formula = '4 - x^2 - y^2 - z^2'\nbounds = 5", 2.0), ("sphere = 2", 2.0)] {
        let text = format!(
            "[shape.d]\ndifference = ['a', {{ half_space = [0, 1, 0] }}]\n[shape.a]\n{maker}\n\
             color = {{ bands = [[0, 'red'], [0.5, 'blue'], [1.25, 'lime']] }}\n"
        );
        let frame = prepared_with(&text, Some(64)).unwrap_or_else(|error| panic!("{error}")).frame(1).unwrap();
        let found = [0.02, 0.47, 0.53, 1.22, 1.28].map(|depth| colour(&frame, x - depth, 0.0, 0.0));
        assert_eq!(found, [RED, RED, BLUE, BLUE, [0.0, 1.0, 0.0]], "{maker}");
        // On the surface, and outside.
        assert_eq!([colour(&frame, x, 0.0, 0.0), colour(&frame, x + 1.0, 0.0, 0.0)], [RED, RED]);
    }
}

#[test]
fn voxels_of_a_lattice_take_colours() {
    let text = |colour: &str| format!("[shape.a]\nbox = 1\ncolor = {{ {colour}, by = 'voxel', voxel_size = 0.2 }}\n");
    let frame = |colour: &str| prepared_with(&text(colour), Some(32)).unwrap().frame(1).unwrap();
    let on_top = |frame: &FrameContent| {
        let places = (0..25).map(|i| (f64::from(i % 5) * 0.2 - 0.4, f64::from(i / 5) * 0.2 - 0.4));
        places.map(|(x, y)| colour(frame, x, y, 0.5)).collect::<Vec<_>>()
    };
    let palette = frame("palette = ['red', 'blue']");
    let top = on_top(&palette);
    assert!(top.contains(&RED) && top.contains(&BLUE), "{top:?}");
    // One colour a cube, up to its faces.
    for (x, y) in [(0.09, 0.0), (-0.09, 0.05), (0.0, -0.09)] {
        assert_eq!(colour(&palette, x, y, 0.5), colour(&palette, 0.0, 0.0, 0.45));
    }
    assert_ne!(
        on_top(&frame("palette = ['red', 'blue'], seed = 4")),
        on_top(&frame("palette = ['red', 'blue'], seed = 5"))
    );
    let between = on_top(&frame("range = ['black', 'red'], color_space = 'rgb'"));
    assert!(between.iter().all(|[r, g, b]| (0.0..=1.0).contains(r) && *g == 0.0 && *b == 0.0), "{between:?}");
    assert!(between.windows(2).any(|pair| pair[0] != pair[1]));
}

#[test]
fn parts_colour_a_shape_they_do_not_make() {
    let text = "[shape.a]\nbox = 2\nmove = [5, 0, 0]\ncolor = { parts = ['low', { sphere = 0.5, color = 'lime' }] }\n\
                [shape.low]\nhalf_space = [0, 0, 1]\noffset_along = -0.75\ncolor = 'red'\n";
    let frame = prepared(text).frame(1).unwrap();
    assert!(value(&frame, 5.0, 0.0, -0.9) > 0.0 && value(&frame, 5.0, 0.0, -1.1) < 0.0);
    assert_eq!(colour(&frame, 5.9, 0.0, -0.9), RED);
    assert_eq!(colour(&frame, 5.0, 0.0, 0.4), [0.0, 1.0, 0.0]);
    // Outside of both by the inverse of the distances (STTI, eq. 6): 1.75 to the one, 0.5 to the other.
    let lime = 1.75 / (1.75 + 0.5);
    assert_close(colour(&frame, 5.0, 0.0, 1.0), [1.0 - lime, lime, 0.0]);
}

#[test]
fn a_seam_softens_a_union() {
    let text = "[shape.u]\nunion = ['a', 'b']\nseam = 0.4\n[shape.a]\nsphere = 1\ncolor = 'red'\n\
                [shape.b]\nsphere = 1\ncolor = 'blue'\nmove = [1, 0, 0]\n";
    let blue = |text: &str, x: f64| colour(&prepared(text).frame(1).unwrap(), x, 0.0, 0.0)[2];
    assert_eq!([blue(text, -0.5), blue(text, 0.5)], [0.0, 1.0]);
    assert!((blue(text, -0.05) - 0.375).abs() < 0.01 && (blue(text, 0.05) - 0.625).abs() < 0.01);
    assert_eq!(blue(&text.replace("0.4", "0"), -0.05), 0.0);
}

#[test]
fn a_morphs_volume_is_on_its_keys() {
    let text = "frames = '1-9'\n[shape.a]\nsphere = 1\n[shape.b]\nsphere = 1\nmove = [0.5, 0, 0]\n\
                [morph]\nfrom = 'a'\nto = 'b'\nvolume = { 1 = 1, 4 = 2, 9 = 1 }\n";
    let scene = prepared_with(text, Some(48)).unwrap_or_else(|error| panic!("{error}"));
    let radius = |frame: i64| {
        let frame = scene.frame(frame).unwrap();
        (0..200).map(|i| f64::from(i) * 0.01).find(|y| value(&frame, 0.25, *y, 0.0) < 0.0).unwrap()
    };
    // Twice the volume of nearly a ball.
    assert!((radius(4) - 2.0_f64.cbrt()).abs() < 0.07, "{}", radius(4));
    refused(
        &text.replace("1 = 1, 4", "1 = 1.5, 4"),
        "`morph.volume` is 1.5 at frame 1, and must be 1 there\n  --> scene.toml:10:10",
    );
}

/// Two balls, 1 and 2 in radius, around one centre: a morph between them is a ball, whose radius tells its progress.
fn radius(scene: &Prepared, frame: i64) -> f64 {
    let frame = scene.frame(frame).unwrap();
    let (mut low, mut high) = (0.0, 4.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if value(&frame, 0.0, middle, 0.0) > 0.0 { low = middle } else { high = middle }
    }
    low
}

const BALLS: &str = "frames = '1-9'\n[shape.a]\nsphere = 1\n[shape.b]\nsphere = 2\n[morph]\nfrom = 'a'\nto = 'b'\n";

#[test]
fn a_morphs_ease_by_keys_and_formula() {
    let radii = |keys: &str, frames: &[i64]| -> Vec<f64> {
        let scene = prepared_with(&format!("{BALLS}{keys}\n"), Some(32)).unwrap_or_else(|error| panic!("{error}"));
        frames.iter().map(|frame| radius(&scene, *frame)).collect()
    };
    let even = radii("", &[1, 3, 5, 7, 9]);
    assert!((even[0] - 1.0).abs() < 1e-9 && (even[4] - 2.0).abs() < 1e-9, "{even:?}");
    // Progress 0.25 at frame 2, rest, back to 0.25, to the end; the same progress is the same frame.
    let keyed = radii("ease = { 1 = 0, 2 = 0.25, 3 = 0.75, 5 = 0.75, 6 = 0.25, 9 = 1 }", &[1, 2, 3, 4, 5, 6, 9]);
    let wanted = [even[0], even[1], even[3], even[3], even[3], even[1], even[4]];
    assert!(keyed.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9), "{keyed:?} {wanted:?}");
    // A formula of the scene's t; keys as F-curves: smooth from rest to rest.
    assert_eq!(radii("ease = 't^2'", &[1, 5, 9]), [even[0], even[1], even[4]]);
    let smooth = radii("ease = 'smooth'", &[1, 3, 5, 8]);
    let bezier = radii("ease = { 1 = 0, 9 = 1, ease = 'bezier' }", &[1, 3, 5, 8]);
    assert!(smooth.iter().zip(&bezier).all(|(a, b)| (a - b).abs() < 1e-9), "{smooth:?} {bezier:?}");
    refused(
        &format!("{BALLS}ease = {{ 1 = 0.2, 9 = 1 }}\n"),
        "`morph.ease` is 0.2 at frame 1, and must be 0 there\n --> scene.toml:9:8",
    );
    refused(&format!("{BALLS}ease = '1.5*t'\n"), "`morph.ease` is 1.5 at frame 9, and must be from 0 to 1");
    // Frames beyond the shot are not seen, so nothing is asked of them.
    radii("over = '-8-9'\nease = { 1 = 0.5, 9 = 1 }", &[1, 9]);
}

#[test]
fn a_chain_of_objects() {
    let shapes = "frames = '1-9'\noutput.voxel_size = 0.06\n[shape.a]\nsphere = 1\ncolor = 'red'\n[shape.b]\nbox = 1.4\nmove = [0.2, 0, 't']\n\
                  [shape.c]\nsphere = 0.6\ncolor = 'blue'\n[morph]\ncolor_space = 'rgb'\n";
    let of = |keys: &str| prepared_with(&format!("{shapes}{keys}\n"), None).unwrap_or_else(|error| panic!("{error}"));
    let chain = of("through = ['a', 'b', 'c']\nat = [1, 4, 9]\nvolume = { 1 = 1, 4 = 1, 6 = 1.3, 9 = 1 }");
    // Each key frame is its object, to the bit.
    let (first, middle, last) = (chain.frame(1).unwrap(), chain.frame(4).unwrap(), chain.frame(9).unwrap());
    assert_eq!(value(&first, 0.7, 0.0, 0.0), 1.0 - 0.7);
    assert!((value(&middle, 0.2 + 0.6, 0.0, 0.375) - 0.1).abs() < 1e-12);
    assert_eq!(value(&last, 0.0, 0.5, 0.0), 0.6 - 0.5);
    assert_eq!([colour(&first, 1.0, 0.0, 0.0), colour(&last, 0.6, 0.0, 0.0)], [RED, BLUE]);
    let [r, g, b] = colour(&middle, 0.9, 0.0, 0.3);
    assert!(r == g && g == b && r > 0.5, "{r} {g} {b}");
    // Its parts are the morphs of two by themselves.
    let parts = [
        of("from = 'a'\nto = 'b'\nover = '1-4'"),
        of("from = 'b'\nto = 'c'\nover = '4-9'\nvolume = { 4 = 1, 6 = 1.3, 9 = 1 }"),
    ];
    for (part, frames) in parts.iter().zip([1..=3, 4..=9]) {
        for number in frames {
            let (whole, alone) = (chain.frame(number).unwrap(), part.frame(number).unwrap());
            for (x, y, z) in [(0.4, 0.5, 0.1), (-0.7, 0.1, 0.6), (0.9, 0.2, -0.3)] {
                assert_eq!(value(&whole, x, y, z), value(&alone, x, y, z), "frame {number}");
                assert_eq!(colour(&whole, x, y, z), colour(&alone, x, y, z), "frame {number}");
            }
        }
    }
    // The numbers of a frame: of the way to it, whichever morph that is of.
    let numbers = |frame: i64| chain.report(frame).unwrap().expect("a morph");
    let t = |frame: i64| numbers(frame).numbers.t;
    assert_eq!((numbers(1).numbers.change, t(1), t(4), t(5) > 0.0), (0.0, 0.0, 1.0, true));
    for frame in 2..=9 {
        let MorphReport { numbers, displacement } = numbers(frame);
        assert!(numbers.change > 0.0 && displacement > 0.01 && numbers.pieces == 1, "{frame}: {numbers:?}");
    }
    // Evenly where nobody says when: at frames 1, 5 and 9.
    let even = of("through = ['a', 'b', 'c']");
    assert!((value(&even.frame(5).unwrap(), 0.8, 0.0, 0.5) - 0.1).abs() < 1e-12);
    refused(
        &format!("{shapes}through = ['a', 'b', 'c']\nvolume = {{ 1 = 1, 5 = 2, 9 = 1 }}\n"),
        "`morph.volume` is 2 at frame 5, and must be 1 there",
    );
}

/// All of a morph moved: F and colours are those of the morph where it was, lengths as much longer.
#[test]
fn a_morph_moves_as_a_whole() {
    let text = "frames = '1-9'\n[output]\nvoxel_size = 0.04\n[shape.a]\nbox = [1, 2, 1]\ncolor = 'red'\nrotate = [0, 0, '40*t']\n\
                [shape.b]\nsphere = 0.7\ncolor = 'blue'\nmove = [0.3, 0, 0]\n[morph]\nfrom = 'a'\nto = 'b'\n";
    let still = prepared(text);
    let moved = "scale = 1.5\nrotate = [0, 0, '90*t']\nmove = [0, '2*t', 1]\n";
    let moving = prepared(&format!("{}{moved}", text.replace("0.04", "0.06")));
    for frame in [1, 4, 7, 9] {
        let [here, there] = [&still, &moving].map(|scene| scene.frame(frame).unwrap());
        assert!((here.info.t - there.info.t).abs() < 1e-3, "{} {}", here.info.t, there.info.t);
        let t = (frame - 1) as f64 / 8.0;
        let turn = glam::DMat3::from_rotation_z((90.0 * t).to_radians());
        for at in [[0.2, 0.1, 0.3], [-0.4, 0.8, 0.2], [0.5, -0.5, 0.0], [0.9, 0.4, -0.3]].map(DVec3::from_array) {
            let to = turn * (at * 1.5) + DVec3::new(0.0, 2.0 * t, 1.0);
            let (before, after) = (here.field.reference(at) * 1.5, there.field.reference(to));
            assert!((before - after).abs() < 0.02, "{before} {after} at {at}, frame {frame}");
            let [one, two] =
                [(&here, at), (&there, to)].map(|(frame, at)| sample(frame.colour.as_ref().unwrap().as_ref(), at));
            assert!(one.iter().zip(two).all(|(one, two)| (one - two).abs() < 0.03), "{one:?} {two:?} at {at}");
        }
    }
    let movement = moving.movement(1).ok().expect("a scene that moves has one");
    assert!(!movement.around.is_empty());
    refused(&format!("{text}scale = '1 + t'\n"), "`morph.scale` changes over time");
    let problem = "the morph is moved over time";
    refused(
        &format!(
            "{}mode = 'openvdb'\nmove = ['t', 0, 0]\n",
            text.replace("rotate = [0, 0, '40*t']", "rotate = [0, 0, 1]")
        ),
        problem,
    );
}

/// Balls that grow along a chain: what frames on both sides of a link change is all that was added.
#[test]
fn change_of_shape_goes_on_over_the_links_of_a_chain() {
    let text = "frames = '1-9'\n[output]\nvoxel_size = 0.05\n[shape.a]\nsphere = 0.5\nmove = ['t', 0, 0]\n[shape.b]\n\
                sphere = 0.8\nmove = ['t', 0, 0]\n[shape.c]\nsphere = 1.1\nmove = ['t', 0, 0]\n[morph]\n\
                through = ['a', 'b', 'c']\n";
    let scene = prepared(text);
    let volume = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    for (before, frame, wanted) in [(1, 5, volume(0.8) - volume(0.5)), (1, 9, volume(1.1) - volume(0.5))] {
        let change = scene.change_of_shape(before, frame).unwrap();
        assert!((change / wanted - 1.0).abs() < 0.03, "{change} {wanted}");
    }
    let [one, two, both] =
        [(3, 5), (5, 7), (3, 7)].map(|(before, frame)| scene.change_of_shape(before, frame).unwrap());
    assert!((one + two - both).abs() < 1e-9 && one > 0.1 && two > 0.1, "{one} {two} {both}");
}

#[test]
fn linear_blending_and_the_plain_union() {
    let text = "frames = '1-9'\n[shape.a]\nsphere = 1\ncolor = 'red'\n[shape.b]\nbox = 1.4\ncolor = 'blue'\nmove = [0.6, 0, 0]\n\
                [morph]\nfrom = 'a'\nto = 'b'\npace = 't'\n";
    let scene =
        |keys: &str| prepared_with(&format!("{text}{keys}\n"), Some(32)).unwrap_or_else(|error| panic!("{error}"));
    let linear = scene("mode = 'linear'");
    assert!(linear.warnings.is_empty(), "{}", linear.warnings);
    // Along −x both distances are known: 1 − |x| of the ball, 0.7 − |x − 0.6| of the box.
    for (frame, t) in [(2, 0.125), (5, 0.5), (8, 0.875)] {
        for x in [-1.3, -0.95, -0.6] {
            let wanted = (1.0 - t) * (1.0 - f64::abs(x)) + t * (0.7 - f64::abs(x - 0.6));
            let found = value(&linear.frame(frame).unwrap(), x, 0.0, 0.0);
            assert!((found - wanted).abs() < 2e-3, "{found} for {wanted} at {x}");
        }
    }
    let union = prepared_with(&format!("{}mode = 'union'\n", text.replace("pace = 't'\n", "")), Some(32));
    let union = union.unwrap_or_else(|error| panic!("{error}"));
    let at = |frame: i64, x: f64, y: f64| value(&union.frame(frame).unwrap(), x, y, 0.0) > 0.0;
    assert_eq!([at(1, -0.9, 0.0), at(1, 1.2, 0.6), at(9, -0.9, 0.0), at(9, 1.2, 0.6)], [true, false, false, true]);
    for frame in [2, 5, 8] {
        assert_eq!([at(frame, -0.9, 0.0), at(frame, 1.2, 0.6), at(frame, 1.2, 0.8)], [true, true, false]);
    }
    // Apart, nothing is left of a linear blend half way.
    let apart = prepared_with(&format!("{}mode = 'linear'\n", text.replace("0.6", "5")), Some(32));
    let warnings = apart.unwrap_or_else(|error| panic!("{error}")).warnings.to_string();
    assert!(warnings.contains("the morph is empty in frames 3-") && warnings.contains("scene.toml:9:2"), "{warnings}");
    assert!(warnings.contains("linear blending needs objects that overlap"), "{warnings}");
}

#[test]
fn a_blend_without_end_is_said_with_its_frame() {
    let keys = "mode = 'paper'\nslab = [-1, 2]\na0 = { 1 = 0.1, 5 = 1000 }\na1 = 100\na2 = 100";
    let error = prepared_with(&format!("{BALLS}{keys}\n"), None).err().expect("it is refused").to_string();
    assert!(error.contains("the in-betweens spread far outside both objects, first at t = "), "{error}");
    assert!(error.contains(" (frame "), "{error}");
}

#[test]
fn a_morphs_parameters_by_keys_and_formula() {
    let middle = |keys: &str, frame: i64| {
        let text = format!(
            "frames = '1-9'\n[shape.a]\nsphere = 1\ncolor = 'red'\n[shape.b]\nsphere = 1\ncolor = 'blue'\n\
             move = [1.5, 0, 0]\n[morph]\nfrom = 'a'\nto = 'b'\npace = 't'\n{keys}\n"
        );
        let scene = prepared_with(&text, Some(24)).unwrap_or_else(|error| panic!("{error}"));
        let frame = scene.frame(frame).unwrap();
        (value(&frame, 0.75, 0.9, 0.0), colour(&frame, 0.3, 0.2, 0.0))
    };
    assert_eq!(middle("bridge = { 1 = 0.1, 5 = 1.2, 9 = 0.1 }", 5), middle("bridge = 1.2", 5));
    assert_eq!(middle("bridge = '0.2 + t'", 3), middle("bridge = 0.45", 3));
    assert_ne!(middle("bridge = 0.1", 5), middle("bridge = 1.2", 5));
    assert_eq!(middle("alpha = '4*t'\nbeta = { 1 = 0, 5 = 0.4 }", 5), middle("alpha = 2\nbeta = 0.4", 5));
    let paper = |keys: &str| {
        let keys = keys.replace("pace = 't'", "");
        let text = format!("{BALLS}mode = 'paper'\n{keys}\n");
        let scene = prepared_with(&text, Some(24)).unwrap_or_else(|error| panic!("{error}"));
        value(&scene.frame(5).unwrap(), 1.2, 0.0, 0.0)
    };
    let still = "a0 = 0.3\na1 = 1.5\na2 = 2\na3 = 0.5\ns = 0.25\nslab = [-1, 2]\nround = { a0 = -0.1, depth = 0.5 }";
    let keyed = "a0 = { 1 = 0, 5 = 0.3, 9 = 0 }\na1 = '1 + t'\na2 = '4*t'\na3 = { 5 = 0.5 }\ns = 't/2 + 1e-3*(t - 0.5)'\n\
                 slab = ['-2*t', { 1 = 1, 5 = 2 }]\nround = { a0 = '-0.2*t', depth = 't' }";
    // Some of these are out of their range at the first frame.
    let error = prepared_with(&format!("{BALLS}mode = 'paper'\n{keyed}\n"), Some(24)).err().expect("it is refused");
    assert!(error.to_string().contains("`morph.a2` is 0 at frame 1, and must be greater than 0"), "{error}");
    let keyed = keyed.replace("'4*t'", "'2 + 4*max(0, t - 0.5)'").replace("'t/2 + 1e-3*(t - 0.5)'", "'0.125 + t/4'");
    assert_eq!(paper(&keyed), paper(still));
    refused(
        &format!("{BALLS}mode = 'paper'\nslab = [0, '1 - 2*t']\n"),
        "`morph.slab` is [0, 0] at frame 5, and must end after it starts\n  --> scene.toml:10:9",
    );
    refused(&format!("{BALLS}bridge = '1 - t'\n"), "`morph.bridge` is 0 at frame 9, and must be from 0.05 to 100");
}

#[test]
fn the_papers_round_reaches_the_morph() {
    let text = "frames = '1-9'\n[shape.a]\nsphere = 1\n[shape.b]\nsphere = 1\nmove = [0.5, 0, 0]\n\
                [morph]\nfrom = 'a'\nto = 'b'\nmode = 'paper'\nslab = [-1, 2]\ns = 0.25\na0 = 0.2\n";
    let middle = |text: &str| {
        let scene = prepared_with(text, Some(24)).unwrap_or_else(|error| panic!("{error}"));
        value(&scene.frame(5).unwrap(), 0.25, 0.0, 0.0)
    };
    let plain = middle(text);
    let rounded = middle(&format!("{text}round = {{ a0 = -0.1 }}\n"));
    assert!(rounded < plain - 0.01, "{rounded} {plain}");
}

#[test]
fn empty_frames_of_the_papers_mode_are_named_once() {
    let text =
        "frames = '1-9'\n[shape.a]\nsphere = 1\n[shape.b]\nbox = 1.4\n[morph]\nfrom = 'a'\nto = 'b'\nmode = 'paper'\n";
    for round in ["", "round = { a0 = -0.2, depth = 0.3 }\n"] {
        let scene = prepared_with(&format!("{text}{round}"), Some(24)).unwrap_or_else(|error| panic!("{error}"));
        let warnings = scene.warnings.to_string();
        assert_eq!(
            warnings.matches("the morph is empty in frames 2-8 (t = 0.125 to 0.875)\n --> scene.toml:6:2").count(),
            1,
            "{warnings}"
        );
    }
    let alive =
        prepared_with(&format!("{text}slab = [-1, 2]\ns = 0.25\na0 = 0.3\na1 = 2.5\na2 = 2.5\na3 = 0.3\n"), Some(24))
            .unwrap_or_else(|error| panic!("{error}"));
    assert!(alive.warnings.is_empty(), "{}", alive.warnings);
}

#[test]
fn what_is_left_out_of_a_round_shape_goes_by_its_radius() {
    let size = |text: &str| prepared(&format!("[shape.a]\n{text}\n")).extent.size();
    for (short, long) in [
        ("torus = 40", "torus = 40\ntube = 10"),
        ("cylinder = 0.02", "cylinder = 0.02\nheight = 0.04"),
        ("capsule = 3", "capsule = 3\nlength = 6"),
    ] {
        assert_eq!(size(short), size(long), "{short}");
    }
    assert!((size("torus = 40").z - 20.0).abs() < 0.2);
}

/// The motion of what is done to a shape, by the displacement of its places from frame to frame.
#[test]
fn what_is_done_to_a_shape_moves_it() {
    let velocity = |shape: &str, at: DVec3| {
        let scene =
            prepared(&format!("frames = '1-3'\nfps = 1\n[output]\nshape = 's'\ngrids = ['surface', 'vel']\n{shape}"));
        let movement = scene.movement(2).unwrap_or_else(|_| panic!("it moves: {shape}"));
        let after = movement.around.iter().find(|around| around.instant.seconds > 0.0).expect("an instant after it");
        let own = after.own.as_ref().expect("it moves");
        DVec3::from_array(sample(own.as_ref(), at).map(f64::from)) / after.instant.seconds
    };
    let near = |found: DVec3, wanted: DVec3| assert!((found - wanted).length() < 2e-2, "{found}, not {wanted}");
    // One unit a frame, before a turn by a right angle.
    let moved = "do = [{ move = ['frame', 0, 0] }, { rotate = [0, 0, 90] }, { shear = [0, 0, 0] }]";
    near(velocity(&format!("[shape.s]\nsphere = 0.5\n{moved}\n"), DVec3::new(0.0, 2.5, 0.0)), DVec3::Y);
    // A part's own motion goes through copies and twists.
    let part = "[shape.p]\nsphere = 0.2\nmove = ['frame/10', 0, 0]\n";
    let copies = format!("[shape.s]\nunion = ['p']\nplaces = [[0, 0, 0], [0, 3, 0, 0, 0, 90, 2]]\n{part}");
    near(velocity(&copies, DVec3::new(0.4, 0.0, 0.0)), DVec3::X * 0.1);
    near(velocity(&copies, DVec3::new(0.0, 3.8, 0.0)), DVec3::Y * 0.2);
    // Copies that spread: the second goes, the first stays.
    let spread = "[shape.s]\nsphere = 0.2\narray = [2, 1, 1]\nspacing = ['frame', 1, 1]\nfrom = 'first'\n";
    near(velocity(spread, DVec3::new(2.2, 0.0, 0.0)), DVec3::X);
    near(velocity(spread, DVec3::new(0.2, 0.0, 0.0)), DVec3::ZERO);
    // Each level turns as fast as the twist says.
    let twist = "[shape.s]\nbox = [1, 1, 4]\ntwist = '10*frame'\n";
    near(velocity(twist, DVec3::new(0.5, 0.0, 1.0)), DVec3::new(0.0, 0.5 * 10_f64.to_radians(), 0.0));
}

/// Colours go along with what moves, bends and copies; of copies each may have one of its own.
#[test]
fn colours_go_with_what_is_done_to_a_shape() {
    let colour_at = |shape: &str, at: [f64; 3]| {
        let scene = prepared(&format!("[output]\nshape = 's'\n[shape.s]\n{shape}\n"));
        colour(&scene.frame(1).unwrap(), at[0], at[1], at[2])
    };
    let near = |found: LinearRgb, wanted: f32| assert!((found[0] - wanted).abs() < 1e-4, "{found:?}, not {wanted}");
    let red = "box = [1, 0.2, 0.2]\ncolor = { linear = ['0.5 + x', 0.2, 0.2] }\n";
    near(colour_at(&format!("{red}do = [{{ move = [3, 0, 0] }}, {{ twist = 90 }}]"), [3.4, 0.0, 0.0]), 0.9);
    near(colour_at(&format!("{red}array = [3, 1, 1]\nspacing = 2"), [-2.3, 0.0, 0.1]), 0.2);
    near(colour_at(&format!("{red}mirror = [0, 1, 0]\nmirror_offset = -0.05"), [0.3, -0.15, 0.0]), 0.8);
    // Two bends in turn: the later one is undone first.
    near(
        colour_at(
            &format!("{red}do = [{{ rotate = [0, 0, 90] }}, {{ array = [1, 3, 1], spacing = 2 }}, {{ offset = 0 }}]"),
            [0.0, 2.3, 0.0],
        ),
        0.8,
    );
    let scene = prepared(
        "[output]\nshape = 's'\n[shape.s]\nsphere = 0.2\narray = [40, 1, 1]\ncolor = { palette = ['red', 'lime', 'blue'], by = 'cell' }\n",
    );
    let frame = scene.frame(1).unwrap();
    let found: Vec<LinearRgb> = (0..40).map(|i| colour(&frame, i as f64 - 19.5, 0.0, 0.2)).collect();
    assert!([0, 1, 2].into_iter().all(|channel| found.iter().any(|colour| colour[channel] == 1.0)), "{found:?}");
    assert_eq!(colour(&frame, -19.5, 0.2, 0.0), found[0]);
}

/// A band of depth is one of the shape as it is at last, however it was bent.
#[test]
fn depth_is_that_of_the_bent_shape() {
    let scene = prepared(
        "[output]\nshape = 's'\n[shape.s]\nsphere = 1\ncolor = { bands = [[0, 'red'], [0.5, 'blue']] }\ndo = [{ move = [0.2, 0, 0] }, { twist = 5 }]\n",
    );
    let frame = scene.frame(1).unwrap();
    assert_eq!(colour(&frame, 1.2, 0.0, 0.0), from_srgb([1.0, 0.0, 0.0]));
    assert_eq!(colour(&frame, 0.3, 0.0, 0.0), from_srgb([0.0, 0.0, 1.0]));
}

/// A cube's corner, out of what has none: how far the surface is from it shrinks from frame to frame, and no frame does much
/// more than its share.
#[test]
fn corners_come_back_evenly() {
    const FRAMES: usize = 24;
    for (from, way) in [("sphere = 1", DVec3::ONE), ("heart = 2.0", DVec3::ONE), ("heart = 2.0", DVec3::NEG_ONE)] {
        let scene = prepared(&format!(
            "frames = '1-{FRAMES}'\n[output]\nvoxel_size = 0.03\n[shape.a]\n{from}\n[shape.b]\nbox = 1.6\n[morph]\n\
             from = 'a'\nto = 'b'\n"
        ));
        let gap = |frame: usize| {
            let content = scene.frame(frame as i64).unwrap();
            let (mut outside, mut inside) = (1.2, 0.1);
            for _ in 0..40 {
                let middle = 0.5 * (outside + inside);
                let is_inside = content.field.reference(way * middle) >= 0.0;
                *(if is_inside { &mut inside } else { &mut outside }) = middle;
            }
            0.8 - inside
        };
        let gaps: Vec<f64> = (1..=FRAMES).map(gap).collect();
        let (whole, tenth) = (gaps[0], FRAMES / 10);
        let greatest = gaps.array_windows().map(|[before, after]| before - after).fold(0.0, f64::max);
        assert!(gaps.is_sorted_by(|before, after| before > after), "{gaps:?}");
        assert!(whole > 0.2 && gaps[FRAMES - 1].abs() < 1e-3, "{gaps:?}");
        assert!(gaps[FRAMES - 1 - tenth] < 0.2 * whole, "{gaps:?}");
        assert!(greatest < 2.3 * whole / (FRAMES - 1) as f64, "{greatest} of {whole}");
    }
}
