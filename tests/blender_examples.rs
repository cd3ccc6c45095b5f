//! What users open in Blender (`blender_examples/`), run in real Blender on small files that OpenVDB's own Python module
//! makes. Skipped, and said so, where `HFVDB_BLENDER_PYTHON` names no Python with Blender.

mod support;

use std::env;
use std::fs::{self, File};
use std::io::{self, BufReader, Write};
use std::process::Command;

use support::{Run, Workplace, json};

const EXAMPLES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/blender_examples");

/// A ball of radius ½ as level set and as smoke, green (with a channel of 0), over two frames: hardly moving, slower
/// than what Cycles drops, and at 24 units a second along x.
const MAKER: &str = "
import sys, numpy as np, pyopenvdb as vdb
N, SIZE = 16, 0.05
place = np.indices((2 * N + 1,) * 3) - N
ball = np.sqrt((place ** 2).sum(0)) * SIZE - 0.5
def finish(grid, name):
    grid.name, grid.transform = name, vdb.createLinearTransform(SIZE)
    return grid
def floats(values, background, name, kind):
    grid = vdb.FloatGrid(background)
    grid.copyFromArray(np.ascontiguousarray(values, np.float32), ijk=(-N,) * 3)
    grid.gridClass = kind
    return finish(grid, name)
def vectors(value, background, name):
    grid = vdb.Vec3SGrid(background)
    grid.fill((-N,) * 3, (N,) * 3, value)
    return finish(grid, name)
surface = floats(np.clip(ball, -3 * SIZE, 3 * SIZE), 3 * SIZE, 'surface', vdb.GridClass.LEVEL_SET)
density = floats(np.clip(-ball / (3 * SIZE), 0, 1), 0.0, 'density', vdb.GridClass.FOG_VOLUME)
colour = vectors((0.0, 0.6, 0.1), (0.0, 0.6, 0.1), 'Cd')
for name, speed in (('still', 0.0005), ('fast', 24.0)):
    vel = vectors((speed, 0.0, 0.0), (0.0,) * 3, 'vel')
    vel['vector_type'] = 'contravariant relative'
    for frame in (7, 8):
        path = '%s/%s.%04d.vdb' % (sys.argv[1], name, frame)
        vdb.write(path, grids=[surface, density, colour, vel], metadata={'hfvdb_fps': 25.0})
";

/// Runs the mesh's example as a module, and tells what there is in the scene then.
const TELLER: &str = "
import sys
sys.path.insert(0, sys.argv[1])
import json, bpy, mesh
item = mesh.main(sys.argv[2:-1])
depsgraph = bpy.context.evaluated_depsgraph_get()
volume = next(one for one in bpy.data.objects if one.type == 'VOLUME')
playing = volume.evaluated_get(depsgraph).data
playing.grids.load()
made = item.evaluated_get(depsgraph).to_mesh()
def values(name, field):
    return [list(getattr(one, field)) for one in made.attributes[name].data]
told = {
    'playing': playing.grids.frame_filepath,
    'radii': [vertex.co.length for vertex in made.vertices],
    'outward': sum(face.normal.dot(face.center) > 0 for face in made.polygons) / max(1, len(made.polygons)),
    'colours': values('Cd', 'color'),
    'velocities': values('velocity', 'vector'),
    'frames': [bpy.context.scene.frame_start, bpy.context.scene.frame_end],
    'rate': bpy.context.scene.render.fps / bpy.context.scene.render.fps_base,
    'rendered': [one.name for one in bpy.data.objects if one.type in ('MESH', 'VOLUME') and not one.hide_render],
}
json.dump(told, open(sys.argv[-1], 'w'))
import os
os._exit(0)
";

/// Python with Blender, and a workplace with files; none where there is no Blender.
fn blender() -> Option<(String, Workplace)> {
    let Ok(python) = env::var("HFVDB_BLENDER_PYTHON") else {
        let _ = writeln!(io::stderr(), "SKIPPED: examples in Blender; HFVDB_BLENDER_PYTHON names no Python with bpy");
        return None;
    };
    let place = Workplace::new();
    fs::create_dir(place.path("in")).expect("a folder");
    place.run(Command::new("/usr/bin/python3").args(["-c", MAKER, "in"])).ok();
    Some((python, place))
}

fn example(python: &str, place: &Workplace, script: &str, arguments: &[&str]) -> Run {
    place.run(Command::new(python).arg(format!("{EXAMPLES}/{script}.py")).args(arguments))
}

/// A picture's pixels and its edge.
fn picture(place: &Workplace, name: &str) -> (Vec<u8>, usize) {
    let file = BufReader::new(File::open(place.path(name)).expect("a picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
    let info = reader.next_frame(&mut pixels).expect("pixels");
    assert_eq!((info.bit_depth, info.color_type), (png::BitDepth::Eight, png::ColorType::Rgba));
    (pixels, info.width as usize)
}

/// How many pixels of the row that has the most are not background.
fn widest(pixels: &[u8], edge: usize) -> usize {
    let drawn = |pixel: &&[u8]| pixel.iter().zip(&pixels[..4]).any(|(a, b)| a.abs_diff(*b) > 6);
    pixels.chunks_exact(4 * edge).map(|row| row.chunks_exact(4).filter(drawn).count()).max().expect("rows")
}

#[test]
fn the_mesh_is_where_it_should_be_in_its_colours_with_its_motion() {
    let Some((python, place)) = blender() else { return };
    let files = ["in/fast.0007.vdb", "in/fast.0008.vdb"];
    let arguments = [&["-c", TELLER, EXAMPLES], &files[..], &["--frame", "8", "told.json"]].concat();
    place.run(Command::new(&python).args(arguments)).ok();
    let told = json(&fs::read_to_string(place.path("told.json")).expect("a report"));
    assert!(told["playing"].as_str().is_some_and(|path| path.ends_with("fast.0008.vdb")), "{}", told["playing"]);
    let radii = told["radii"].as_array().expect("a list");
    // Threshold 0.1 would make them 0.6.
    assert!(radii.len() > 500 && radii.iter().all(|radius| (radius.as_f64().unwrap() - 0.5).abs() < 2e-3));
    assert_eq!(told["outward"], 1.0);
    let all = |name: &str, expected: [f64; 3]| {
        told[name]
            .as_array()
            .expect("a list")
            .iter()
            .all(|value| (0..3).all(|axis| (value[axis].as_f64().unwrap() - expected[axis]).abs() < 1e-4))
    };
    assert!(all("colours", [0.0, 0.6, 0.1]) && all("velocities", [24.0, 0.0, 0.0]));
    assert_eq!((&told["frames"], &told["rate"]), (&serde_json::json!([7, 8]), &serde_json::json!(25.0)));
    assert_eq!(told["rendered"], serde_json::json!(["fast mesh"]), "neither the volume nor the startup's cube");
}

#[test]
fn meshes_and_smoke_are_green_and_blurred_by_their_motion() {
    let Some((python, place)) = blender() else { return };
    for script in ["mesh", "fog"] {
        let mut widths = Vec::new();
        for name in ["still", "fast"] {
            let (files, out) =
                ([7, 8].map(|frame| format!("in/{name}.000{frame}.vdb")), format!("{script}-{name}.png"));
            let options =
                ["--frame", "8", "--size", "128", "--samples", "8", "--save", "scene.blend", "--render", &out];
            let arguments: Vec<&str> = files.iter().map(String::as_str).chain(options).collect();
            example(&python, &place, script, &arguments).ok();
            let (pixels, edge) = picture(&place, &out);
            let middle = &pixels[(edge / 2 * edge + edge / 2) * 4..][..3];
            // Smoke that loses its colour is grey, and nearly black by a wrong integrator.
            assert!(middle[1] > 60 && middle[1] > 2 * middle[0] && middle[1] > 2 * middle[2], "{out}: {middle:?}");
            widths.push(widest(&pixels, edge));
        }
        assert!(widths[1] >= widths[0] + 3, "{script}: {} pixels wide at rest, {} in motion", widths[0], widths[1]);
    }
    assert!(place.path("scene.blend").exists());
}

/// Files of hfvdb in centimetres: 160 units large, and lit; smoke is made of the level set where there is no density.
#[test]
fn what_is_large_is_lit_and_what_has_no_density_is_smoke_all_the_same() {
    let Some((python, place)) = blender() else { return };
    let scene = "hfvdb = 1\nframes = \"1-2\"\nunit = \"cm\"\n[shape.a]\nsphere = 80\ncolor = \"#40c080\"\n";
    place.write("ball.toml", scene);
    place.hfvdb("bake ball.toml --resolution 32 -o m.####.vdb").ok();
    for script in ["mesh", "fog"] {
        let out = format!("{script}.png");
        let options = ["m.0001.vdb", "m.0002.vdb", "--size", "96", "--samples", "8", "--render", &out];
        let run = example(&python, &place, script, &options).ok();
        assert_eq!(run.stderr.contains("'surface' is filled with smoke"), script == "fog", "{}", run.stderr);
        let (pixels, edge) = picture(&place, &out);
        let [red, green, blue] = [0, 1, 2].map(|i| pixels[(edge / 2 * edge + edge / 2) * 4 + i]);
        assert!(green > 60 && green > red + 20 && green > blue + 10, "{out}: {red} {green} {blue}");
        let across = widest(&pixels, edge) as f64 / edge as f64;
        assert!((0.3..0.9).contains(&across), "{out}: {across} of the picture");
    }
}

#[test]
fn what_blender_would_show_wrong_without_a_word_is_refused() {
    let Some((python, place)) = blender() else { return };
    let refused = |script: &str, arguments: &[&str], part: &str| {
        let run = example(&python, &place, script, arguments);
        assert!(run.code != 0 && run.stderr.contains(part), "{arguments:?}: {} {}", run.code, run.stderr);
    };
    refused("mesh", &["in/still.0007.vdb", "--surface", "sdf"], "no FLOAT grid 'sdf'");
    refused(
        "fog",
        &["in/still.0007.vdb", "--density", "smoke", "--surface", "sdf"],
        "no FLOAT grid 'sdf' for the smoke",
    );
    refused("mesh", &["in/none.0007.vdb"], "no such file");
    fs::copy(place.path("in/still.0007.vdb"), place.path("in/still.0010.vdb")).expect("a copy");
    refused("mesh", &["in/still.0007.vdb", "in/still.0008.vdb", "in/still.0010.vdb"], "frames are missing");
    fs::copy(place.path("in/still.0007.vdb"), place.path("in/still_v.vdb")).expect("a copy");
    refused("fog", &["in/still.0007.vdb", "in/still_v.vdb"], "has to stand last");
    let bytes = fs::read(place.path("in/still.0007.vdb")).expect("a file");
    place.write("cut.vdb", &bytes[..bytes.len() / 2]);
    refused("mesh", &["cut.vdb"], "cut.vdb");
}
