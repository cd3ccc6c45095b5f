//! Scalars of shapes: where they come from, how they go through set operations and morphs, what is wrong with them.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, Vec3};

use crate::attribute::Attribute;
use crate::field::{BATCH, Points};

use super::*;
use crate::node::*;
use crate::text::*;

pub(crate) fn loaded(text: &str) -> Result<Model, Diagnostics> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    load(&Source::Text { name: "scene.toml".into(), text: text.into(), folder }, &Overrides::default())
}

pub(crate) fn prepared(text: &str) -> Prepared {
    prepared_at(Sampling::Resolution(64), Arc::default(), text).unwrap_or_else(|error| panic!("{error}"))
}

/// The same with voxels of an edge that does not depend on the objects.
#[track_caller]
pub(crate) fn prepared_in_voxels(edge: f64, text: &str) -> Prepared {
    prepared_at(Sampling::VoxelSize(edge), Arc::default(), text).unwrap_or_else(|error| panic!("{error}"))
}

/// What is wrong with a scene that can be read.
#[track_caller]
pub(crate) fn refused(text: &str) -> String {
    prepared_at(Sampling::Resolution(32), Arc::default(), text).err().expect("the scene is wrong").to_string()
}

pub(crate) enum Sampling {
    Resolution(u32),
    VoxelSize(f64),
}

pub(crate) fn prepared_at(sampling: Sampling, cancel: Arc<AtomicBool>, text: &str) -> Result<Prepared, Error> {
    let model = loaded(text).unwrap_or_else(|problems| panic!("{problems}"));
    let (voxel_size, resolution) = match sampling {
        Sampling::Resolution(resolution) => (None, Some(resolution)),
        Sampling::VoxelSize(edge) => (Some(edge), None),
    };
    let options = PrepareOptions {
        voxel_size,
        resolution,
        half_width: None,
        memory_limit: None,
        cache: None,
        cancel,
        progress: &|_, _| (),
    };
    Arc::new(model).prepare(&options)
}

/// Every problem as `line:column message`.
#[track_caller]
pub(crate) fn wrong(text: &str, wanted: &str) {
    let problems = loaded(text).expect_err("the scene is wrong");
    let line = |diagnostic: &Diagnostic| {
        let at = problems.place(diagnostic).expect("a place");
        format!("{}:{} {}", at.line, at.column, diagnostic.message)
    };
    let said: Vec<String> =
        problems.list().iter().filter(|problem| problem.severity == Severity::Error).map(line).collect();
    assert_eq!(said, [wanted], "of:\n{text}");
}

pub(crate) fn sampled<const N: usize>(attribute: &dyn Attribute<N>, at: DVec3) -> [f32; N] {
    let mut points = Points::new(at);
    points.push(Vec3::ZERO);
    let mut out = [[0.0; N]; BATCH];
    attribute.sampler().sample(&points, &mut out);
    out[0]
}

#[track_caller]
pub(crate) fn scalar(frame: &FrameContent, name: &str, at: [f64; 3]) -> f32 {
    let (_, scalar) = frame.scalars.iter().find(|(known, _)| known == name).expect("the scalar is there");
    sampled(scalar.as_ref(), at.into())[0]
}

#[test]
fn a_scalar_is_a_number_keys_or_a_formula() {
    let scene = prepared(
        "frames = '1-5'\n[shape.a]\nsphere = 1\nmove = [2, 0, 0]\nattribute.still = -0.25\n\
         attribute.keyed = { 1 = 0, 5 = 8 }\nattribute.formula = 'x + 10*t'\n",
    );
    let names: Vec<String> = scene.frame(1).unwrap().scalars.into_iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["formula", "keyed", "still"]);
    for (frame, keyed, t) in [(1, 0.0, 0.0), (2, 2.0, 2.5), (5, 8.0, 10.0)] {
        let content = scene.frame(frame).unwrap();
        let at = [2.5, 0.0, 0.0];
        let found = ["still", "keyed", "formula"].map(|name| scalar(&content, name, at));
        assert_eq!(found, [-0.25, keyed, 0.5 + t], "frame {frame}");
        assert!(content.colour.is_none());
    }
}

#[test]
fn scalars_go_through_set_operations_as_colours_do() {
    let scene = prepared(
        "[shape.all]\nunion = ['a', 'b', 'c']\n[shape.a]\nsphere = 1\nattribute.wear = 0.5\n[shape.b]\nsphere = 1\n\
         move = [4, 0, 0]\nattribute.wear = -2\n[shape.c]\nsphere = 1\nmove = [0, 0, 4]\n",
    );
    let frame = scene.frame(1).unwrap();
    // c has none: it counts as 0.
    for (at, value) in [([0.3, 0.0, 0.0], 0.5), ([4.0, 0.5, 0.0], -2.0), ([0.0, 0.0, 4.0], 0.0)] {
        assert_eq!(scalar(&frame, "wear", at), value);
    }
    // Outside, STTI's eq. 6.
    let at = DVec3::new(1.7, 0.0, 0.0);
    let weights = [DVec3::ZERO, DVec3::X * 4.0, DVec3::Z * 4.0].map(|middle| 1.0 / (at.distance(middle) - 1.0));
    let mean = (0.5 * weights[0] - 2.0 * weights[1]) / weights.iter().sum::<f64>();
    assert!((f64::from(scalar(&frame, "wear", at.to_array())) - mean).abs() < 1e-5);
    let cut = prepared(
        "[shape.cut]\ndifference = ['a', 'b']\n[shape.a]\nbox = 2\nattribute.wear = 3\n[shape.b]\nsphere = 0.9\n\
         attribute.wear = 7\n",
    );
    assert_eq!(scalar(&cut.frame(1).unwrap(), "wear", [0.9, 0.0, 0.0]), 3.0);
}

#[test]
fn tables_make_scalars_as_they_make_colours() {
    let scene = prepared(
        "[shape.a]\nbox = 2\nattribute.rings = { bands = [[0, 1], [0.25, 2], [0.5, 3]] }\n\
         attribute.cubes = { range = [5, 6], by = 'voxel', voxel_size = 0.5 }\n\
         attribute.some = { values = [1, 4], by = 'voxel', voxel_size = 0.5 }\n\
         attribute.inner = { parts = ['core', 'rest'] }\n\
         [shape.core]\nsphere = 0.5\nattribute.inner = 9\n[shape.rest]\nbox = 4\nbounds = [[0.6, -2, -2], [2, 2, 2]]\n\
         [output]\nshape = 'a'\n",
    );
    let frame = scene.frame(1).unwrap();
    for (x, ring) in [(0.9, 1.0), (0.7, 2.0), (0.2, 3.0)] {
        assert_eq!(scalar(&frame, "rings", [x, 0.0, 0.0]), ring);
    }
    let cubes: Vec<f32> = (-1..=1).map(|cube| scalar(&frame, "cubes", [f64::from(cube) * 0.5, 0.0, 0.0])).collect();
    assert!(cubes.iter().all(|value| (5.0..6.0).contains(value)) && cubes[0] != cubes[1], "{cubes:?}");
    assert_eq!(scalar(&frame, "cubes", [0.1, 0.1, 0.0]), cubes[1]);
    assert!([1.0, 4.0].contains(&scalar(&frame, "some", [0.0; 3])));
    assert_eq!([0.0, 0.8].map(|x| scalar(&frame, "inner", [x, 0.0, 0.0])), [9.0, 0.0]);
    let cells = prepared(
        "[cells.c]\noctree = 'b'\ndepth = 2\n[shape.b]\nbox = 1\n[shape.f]\nfacet = 'b'\ncells = 'c'\ncut = 0\n\
         attribute.heat = { range = [0, 1], by = 'cell' }\n",
    );
    let frame = cells.frame(1).unwrap();
    let heat = |x: f64| scalar(&frame, "heat", [x, 0.1, 0.5]);
    assert!(heat(0.05) == heat(0.2) && heat(0.2) != heat(0.3), "{} {} {}", heat(0.05), heat(0.2), heat(0.3));
}

/// A scalar that is 0 on the one and 1 on the other object is the second object's weight: the red of colours that are
/// mixed in linear RGB.
#[test]
fn scalars_go_through_a_morph_by_the_weights_of_colours() {
    let scene = prepared(
        "frames = '1-9'\n[shape.a]\nsphere = 1\nmove = [-1, 0, 0]\ncolor = { linear = [0, 0, 1] }\n[shape.b]\nbox = 1.5\n\
         move = ['1 + t', 0, 0]\ncolor = { linear = [1, 0, 0] }\nattribute.mix = 1\nattribute.heat = { 1 = 2, 9 = 4 }\n\
         [morph]\nfrom = 'a'\nto = 'b'\ncolor_space = 'rgb'\n",
    );
    let ends = [1, 9].map(|frame| scene.frame(frame).unwrap());
    assert_eq!(scalar(&ends[0], "mix", [-1.0, 0.0, 1.0]), 0.0);
    assert_eq!(scalar(&ends[1], "mix", [2.0, 0.0, 0.75]), 1.0);
    assert_eq!(scalar(&ends[1], "heat", [2.0, 0.0, 0.75]), 4.0);
    for frame in 2..9 {
        let content = scene.frame(frame).unwrap();
        for x in [-1.9, -0.4, 0.3, 1.1, 2.2] {
            let at = [x, 0.4, 0.2];
            let red = sampled(content.colour.as_deref().expect("a colour"), at.into())[0];
            let (mix, heat) = (scalar(&content, "mix", at), scalar(&content, "heat", at));
            assert!((mix - red).abs() < 1e-6, "{mix} {red}");
            let keyed = 2.0 + (frame - 1) as f32 * 0.25;
            assert!((heat - red * keyed).abs() < 1e-5, "{heat} {red} at frame {frame}");
        }
    }
}

/// Past the end of `color_over` the second object's colour creeps on outward with `octopus`, and stands without.
#[test]
fn the_octopus_goes_on_past_the_end_of_the_colours() {
    let mix = |octopus: bool, frame: i64, at: [f64; 3]| {
        let scene = prepared(&format!(
            "frames = '1-9'\n[shape.a]\nsphere = 1\nmove = [-1, 0, 0]\n[shape.b]\nsphere = 1\nmove = [1, 0, 0]\n\
             attribute.mix = 1\n[morph]\nfrom = 'a'\nto = 'b'\ncolor_over = '1-5'\noctopus = {octopus}\n"
        ));
        scalar(&scene.frame(frame).unwrap(), "mix", at)
    };
    let outside = [-1.2, 0.2, 0.0];
    let creeping = [5, 6, 8].map(|frame| mix(true, frame, outside));
    assert!(creeping[0] < creeping[1] && creeping[1] < creeping[2] && creeping[2] < 1.0, "{creeping:?}");
    assert_eq!([6, 8].map(|frame| mix(false, frame, outside)), [creeping[0]; 2]);
    assert_eq!([5, 8].map(|frame| mix(true, frame, [1.5, 0.0, 0.0])), [1.0; 2]);
}

#[test]
fn grids_choose_what_is_computed() {
    let text = |grids: &str| {
        format!("[shape.a]\nsphere = 1\ncolor = 'red'\nattribute.b = 1\nattribute.c = 2\n[output]\n{grids}\n")
    };
    let names = |grids: &str| {
        let frame = prepared(&text(grids)).frame(1).unwrap();
        let scalars: Vec<String> = frame.scalars.into_iter().map(|(name, _)| name).collect();
        (frame.colour.is_some(), scalars.join(" "))
    };
    assert_eq!(names(""), (true, "b c".into()));
    assert_eq!(names("grids = ['surface', 'c']"), (false, "c".into()));
    assert_eq!(names("grids = ['surface', 'Cd']"), (true, String::new()));
    assert_eq!(names("color_name = 'rgb'\ngrids = ['surface', 'rgb']"), (true, String::new()));
}

#[test]
fn scalars_that_are_wrong_are_refused_with_their_place() {
    let scene = |line: &str| format!("[shape.a]\nsphere = 1\n{line}\n");
    wrong(&scene("attribute = 3"), "3:13 `shape.a.attribute` must be a table");
    wrong(&scene("attribute.Cd = 3"), "3:11 `Cd` is the name of another grid");
    wrong(&scene("attribute.vel = 3"), "3:11 `vel` is the name of another grid");
    wrong(&scene("attribute.surface = 3"), "3:11 `surface` is the name of another grid");
    wrong(&scene("attribute.'a b' = 3"), "3:12 `a b` cannot be the name of a grid");
    wrong(&scene("attribute.2d = 3"), "3:11 `2d` cannot be the name of a grid");
    wrong(
        &scene("attribute.wear = 'x + u'"),
        "3:23 nothing here is called `u`; known are `frame`, `t`, `time`, `x`, `y`, `z`, `pi`",
    );
    wrong(&scene("attribute.wear = true"), "3:18 `shape.a.attribute.wear` must be a number, a formula or keys");
    wrong(&scene("attribute.wear = inf"), "3:18 `shape.a.attribute.wear` must be finite");
    wrong(&scene("attribute.wear = {}"), "3:18 `shape.a.attribute.wear` says no number");
    wrong(&scene("attribute.wear = { bonds = 3 }"), "3:20 unknown key `bonds` in `shape.a.attribute.wear`");
    wrong(
        &scene("attribute.wear = { range = [0, 1], values = [1] }"),
        "3:36 `range` and `values` both say what `shape.a.attribute.wear` is",
    );
    wrong(
        &scene("attribute.wear = { range = [0, 1, 2], by = 'voxel', voxel_size = 1 }"),
        "3:28 `shape.a.attribute.wear.range` must be a list of two numbers",
    );
    wrong(&scene("attribute.wear = { values = [1] }"), "3:29 only a shape with `facet` or `at` has cells");
    wrong(
        &scene("attribute.wear = { bands = [[1, 2], [0, 'x']] }"),
        "3:38 `shape.a.attribute.wear.bands[1]` begins at 0, not below the band before it, 1",
    );
    wrong(&scene("attribute.wear = 1\n[output]\ngrids = ['surface', 'waer']"), "5:22 `output.grids` cannot be `waer`");
    wrong(&scene("[output]\nmax_speed = 0"), "4:13 `output.max_speed` must be greater than 0");
    wrong(&scene("[output]\ngrids = ['Cd']"), "4:9 `output.grids` has no `surface`, on whose voxels all others stand");
    wrong(&scene("attribute.wear = 1\n[output]\ncolor_name = 'wear'"), "5:15 a grid cannot be called `wear`");
}

/// What none of them has would be 0, or grey, everywhere.
#[test]
fn what_none_of_the_parts_has_is_told() {
    let of = |keys: &str| {
        refused(&format!(
            "[shape.a]\nsphere = 1\n{keys}\n[shape.b]\nsphere = 0.2\nmove = [-0.7, 0, 0]\n[shape.c]\nsphere = 0.2\n\
             move = [0.7, 0, 0]\nattribute.cold = 1\n[output]\nshape = \"a\"\n"
        ))
    };
    for row in ["parts", "conformal"] {
        let said = of(&format!("attribute.heat = {{ {row} = ['b', 'c'] }}"));
        assert!(said.contains("`a` takes `attribute.heat` from `b`, `c`, and none of them has it"), "{said}");
        assert!(of(&format!("color = {{ {row} = ['b', 'c'] }}")).contains("takes a colour from `b`, `c`"));
    }
}
