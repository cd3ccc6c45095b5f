//! Mesh files as they come: each is read as its maker meant it, or a message says what is not, and where.

mod support;

use std::fmt::Write;

use serde_json::Value;
use support::{Run, Workplace, json};

/// A file that once was read wrongly.
fn kept(name: &str) -> Vec<u8> {
    let path = format!("{}/tests/data/meshes/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Bakes a mesh alone, with more keys beside `mesh`.
fn bake(name: &str, content: impl AsRef<[u8]>, keys: &str) -> (Workplace, Run) {
    let place = Workplace::new();
    place.write(name, content);
    place.write("s.toml", format!("hfvdb = 1\n[shape.m]\nmesh = \"{name}\"\n{keys}\n"));
    let run = place.hfvdb("bake s.toml -o o.vdb --resolution 48 --json");
    (place, run)
}

fn volume(run: &Run) -> f64 {
    json(&run.stdout)["frames"][0]["volume"].as_f64().unwrap_or_else(|| panic!("no volume: {}", run.stdout))
}

/// Bakes a kept file that must come out with a volume; gives the messages.
fn baked(name: &str, wanted: f64) -> String {
    let (_, run) = bake(name, kept(name), "");
    let run = run.ok();
    assert!((volume(&run) - wanted).abs() < 0.02 * wanted, "{name}: volume {}\n{}", volume(&run), run.stderr);
    run.stderr
}

/// Only that the frame is there.
fn nothing_is_said(text: &str) {
    assert!(text.starts_with("1 frame, ") && text.lines().count() == 1, "{text}");
}

fn says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no \"{part}\" in:\n{text}");
    }
}

/// What `info` says about a grid of a file.
fn grid(place: &Workplace, file: &str, name: &str) -> Value {
    let info = json(&place.hfvdb(&format!("info {file} --json")).ok().stdout);
    let grids = info["files"][0]["grids"].as_array().expect("a list");
    grids.iter().find(|grid| grid["name"] == name).unwrap_or_else(|| panic!("no {name}: {info}")).clone()
}

fn three(value: &Value) -> [f64; 3] {
    std::array::from_fn(|c| value[c].as_f64().unwrap_or_else(|| panic!("{value}")))
}

/// The linear colours of the file that was baked, least and greatest.
fn colours(place: &Workplace) -> [[f64; 3]; 2] {
    let grid = grid(place, "o.vdb", "Cd");
    ["least", "greatest"].map(|end| three(&grid["range"][end]))
}

/// The axis along which a file's surface is longest.
fn longest(place: &Workplace, file: &str) -> usize {
    let index_box = &grid(place, file, "surface")["index_box"];
    let (min, max) = (three(&index_box[0]), three(&index_box[1]));
    (0..3).max_by(|a, b| (max[*a] - min[*a]).total_cmp(&(max[*b] - min[*b]))).expect("three axes")
}

fn is_orange(place: &Workplace) {
    let [min, max] = colours(place);
    for colour in [min, max] {
        // sRGB (255, 128, 0).
        let distance: f64 = colour.iter().zip([1.0, 0.215_861, 0.0]).map(|(a, b)| (a - b).abs()).sum();
        assert!(distance < 1e-5, "{colour:?}");
    }
}

/// A prism of a polygon along z, from −0.5 to 0.5, its ends one face each.
fn prism(outline: &[[f64; 2]]) -> String {
    let (mut text, count) = (String::new(), outline.len());
    for z in [-0.5, 0.5] {
        outline.iter().for_each(|[x, y]| writeln!(text, "v {x:.6} {y:.6} {z}").expect("it is a text"));
    }
    let face = |corners: &mut dyn Iterator<Item = usize>| {
        corners.fold("f".to_owned(), |face, corner| format!("{face} {corner}")) + "\n"
    };
    text += &face(&mut (1..=count).rev());
    text += &face(&mut (count + 1..=2 * count));
    for i in 0..count {
        let next = (i + 1) % count;
        text += &face(&mut [i + 1, next + 1, count + next + 1, count + i + 1].into_iter());
    }
    text
}

#[test]
fn a_hole_joined_by_a_bridge_is_a_hole() {
    nothing_is_said(&baked("bridged-hole.obj", 3.0));
}

#[test]
fn a_face_of_2600_corners() {
    let outline: Vec<[f64; 2]> = (0..2600)
        .map(|i| {
            let radius = if i / 50 % 2 == 0 { 1.0 } else { 0.5 };
            let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 2600.0).sin_cos();
            [radius * cos, radius * sin]
        })
        .collect();
    let (_, run) = bake("gear.obj", prism(&outline), "");
    let run = run.ok();
    assert!((volume(&run) - 1.9556).abs() < 0.02, "{}", volume(&run));
}

#[test]
fn a_face_that_crosses_itself_is_an_error() {
    let star: Vec<[f64; 2]> = (0..5)
        .map(|i| {
            let (sin, cos) = (f64::from(2 * i) * std::f64::consts::TAU / 5.0).sin_cos();
            [cos, sin]
        })
        .collect();
    let (_, run) = bake("star.obj", prism(&star), "");
    run.fails(
        1,
        &["star.obj, line 11: a face of 5 corners crosses or overlaps itself near (", "export it in triangles"],
    );
}

#[test]
fn a_face_of_four_corners_that_crosses_itself_is_said() {
    let bow = [[-1.0, -1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, 1.2]];
    let (_, run) = bake("bow.obj", prism(&bow), "");
    says(&run.stderr, &["bow.obj, line 9: 2 faces of four corners cross themselves"]);
}

#[test]
fn no_line_is_swallowed() {
    for name in ["comment-ends-in-backslash.obj", "byte-order-mark.obj", "continuation-then-blank.obj"] {
        nothing_is_said(&baked(name, 8.0));
    }
}

#[test]
fn faces_that_bound_nothing_are_said() {
    says(
        &baked("two-corner-face.obj", 8.0),
        &["warning: two-corner-face.obj, line 15: a face of 2 corners bounds nothing: it is left out"],
    );
    says(
        &baked("duplicate-faces.obj", 8.0),
        &["duplicate-faces.obj, line 15: 2 faces are there more than once, this one already as line 9"],
    );
}

#[test]
fn vertices_are_counted_as_in_the_file() {
    let (_, run) = bake("m.obj", kept("numbers-in-messages.obj"), "");
    run.fails(1, &["m.obj, line 2: the colour (2, 0, 0) of vertex 2 is not within"]);
    let cube = kept("colour-called-diffuse.ply");
    let text = String::from_utf8(cube).expect("it is a text").replacen("-1 1 -1", "-1 nan -1", 1);
    let (_, run) = bake("m.ply", text.replace("nan", "1e40"), "");
    run.fails(1, &["m.ply, line 16: vertex 3 (counted from 0) is at (-1, inf", "no usable position"]);
    let (_, run) = bake("m.ply", text.replace("nan", "1").replace("4 3 0 4 7", "4 3 0 4 8"), "");
    run.fails(1, &["m.ply, line 26: a face names vertex 8, but there are 8, counted from 0"]);
}

#[test]
fn colours_of_other_names_and_of_faces() {
    for name in ["colour-called-diffuse.ply", "face-colours-dropped.ply"] {
        let (place, run) = bake(name, kept(name), "");
        assert_eq!(run.ok().stderr.matches("warning").count(), 0, "{name}");
        is_orange(&place);
    }
    let single_letters = String::from_utf8(kept("colour-called-diffuse.ply")).expect("it is a text");
    let single_letters =
        single_letters.replace("diffuse_red", "r").replace("diffuse_green", "g").replace("diffuse_blue", "b");
    let (place, run) = bake("m.ply", single_letters, "");
    run.ok();
    is_orange(&place);
}

#[test]
fn colours_that_are_not_read_are_said() {
    let name = "material-colour-dropped.obj";
    says(
        &baked(name, 8.0),
        &[
            "warning: material-colour-dropped.obj, line 10: ",
            "no material of the mesh is known (`usemtl red`)",
            "`color`",
        ],
    );
    // Where it is not the mesh's colour that is shown there is nothing to say.
    for keys in ["color = 'red'", "[output]\ngrids = ['surface']"] {
        let (_, run) = bake(name, kept(name), keys);
        assert!(!run.ok().stderr.contains("usemtl"), "{keys}");
    }
    let odd = String::from_utf8(kept("colour-called-diffuse.ply")).expect("it is a text");
    let (_, run) = bake("m.ply", odd.replace("diffuse_blue", "emissive_blue"), "");
    says(&run.ok().stderr, &["m.ply: what looks like colours is not read: 'diffuse_red' of 'vertex'"]);
    let textured = odd
        .replace("diffuse_", "n")
        .replace("comment", "")
        .replace("element face", "comment TextureFile t.png\nelement face");
    let (_, run) = bake("m.ply", textured, "");
    says(&run.ok().stderr, &["m.ply: the mesh's texture 't.png' is not read"]);
}

#[test]
fn white_stays_white() {
    let name = "white-mesh-above-one.obj";
    let (place, run) = bake(name, kept(name), "rotate = [10, 20, 30]");
    assert!(!run.ok().stderr.contains("above 1"));
    assert_eq!(colours(&place), [[1.0; 3]; 2]);
    assert!(!place.hfvdb("check o.vdb").ok().stderr.contains("above 1"));
}

#[test]
fn linear_colours_can_be_said_to_be() {
    let text = String::from_utf8(kept("colour-called-diffuse.ply")).expect("it is a text");
    let text = text.replace("uchar diffuse_", "float ").replace("255 128 0", "3.5 0.25 0");
    let (_, run) = bake("m.ply", &text, "");
    run.fails(1, &["m.ply, line 13: the colour (3.5, 0.25, 0) of vertex 0", "vertex_colors = \"linear\""]);
    let (place, run) = bake("m.ply", &text, "vertex_colors = 'linear'");
    run.ok();
    assert_eq!(colours(&place), [[3.5, 0.25, 0.0]; 2]);
}

/// A wedge whose sharp edge points along y, as Blender's export has one that points up.
fn wedge(header: &str) -> String {
    format!(
        "{header}\nv -1 0 -1\nv 1 0 -1\nv 1 0 1\nv -1 0 1\nv 0 3 -1\nv 0 3 1\n\
         f 1 2 3 4\nf 1 5 2\nf 4 3 6\nf 2 5 6 3\nf 1 4 6 5\n"
    )
}

#[test]
fn the_up_axis_of_a_file() {
    let blender = wedge("# Blender 4.2.1 LTS\n# www.blender.org");
    let (place, run) = bake("w.obj", &blender, "");
    says(&run.ok().stderr, &["note: w.obj: the file is by Blender", "`up = \"y\"`"]);
    assert_eq!(longest(&place, "o.vdb"), 1);
    let (place, run) = bake("w.obj", &blender, "up = 'y'");
    assert_eq!(run.ok().stderr.matches("Blender").count(), 0);
    assert_eq!(longest(&place, "o.vdb"), 2);
    // A scene with y up takes such files as they are.
    let place = Workplace::new();
    place.write("w.obj", &blender);
    for (up, axis) in [("", 1), ("up = 'y'\n", 1), ("up = 'z'\n", 2)] {
        place.write("s.toml", format!("hfvdb = 1\nup = 'y'\n[shape.m]\nmesh = 'w.obj'\n{up}"));
        let run = place.hfvdb("bake s.toml -o o.vdb --resolution 32 --overwrite").ok();
        assert!(!run.stderr.contains("Blender"), "{}", run.stderr);
        assert_eq!(longest(&place, "o.vdb"), axis, "{up}");
    }
    place.write("plain.obj", wedge(""));
    let run = place.hfvdb("morph w.obj plain.obj -o m.####.vdb --shot 1-2 --resolution 24 --up y").ok();
    assert!(!run.stderr.contains("Blender"), "{}", run.stderr);
    assert_eq!(longest(&place, "m.0002.vdb"), 2);
}

/// One line each, with the file and the line.
#[test]
fn what_is_wrong_with_a_ply() {
    let place = Workplace::new();
    place.write("m.ply", kept("line-of-letters.ply"));
    place.write("s.toml", "hfvdb = 1\n[shape.m]\nmesh = \"m.ply\"\n");
    place
        .hfvdb("check s.toml")
        .fails(1, &["m.ply, line 10: 'AAAA", "are not the numbers that the header announces of 'vertex': x y z"]);
    let good = String::from_utf8(kept("face-colours-dropped.ply")).expect("it is a text");
    for (from, to, message) in [
        ("ply\n", "plx\n", "m.ply: does not begin with the line 'ply'"),
        ("property float y", "property half y", "m.ply, line 5: 'property half y' is no line of a header"),
        ("property float y", "property float x", "m.ply, line 5: 'x' is there twice in the header"),
        ("property float y", "property float why", "m.ply: its vertices have no number 'y'"),
        ("property list uchar int", "property list uchar float", "m.ply: its faces' 'vertex_indices' are no list"),
        ("vertex_indices", "corners", "m.ply: its faces have no list 'vertex_indices'"),
        ("element vertex 8", "element vertex 9", "m.ply, line 27: ends within the 6 of 'face'"),
        ("element face 6", "element face 7", "ends within the 7 of 'face': the file is cut short"),
        ("element face 6", "element tristrips 6", "m.ply: holds triangle strips ('tristrips')"),
        ("end_header\n", "", "m.ply, line 12: '-1 -1 -1' is no line of a header"),
        ("\n", "\r", "m.ply: its header's lines end in CR alone"),
        ("ply", "\u{1b}[31mply", "m.ply: does not begin"),
        ("-1 -1 -1", "-1 \u{1b}[31m -1", "m.ply, line 13: '-1 \\u{1b}[31m -1' are not"),
    ] {
        place.write("m.ply", good.replacen(from, to, if from == "\n" { 99 } else { 1 }));
        let run = place.hfvdb("check s.toml");
        run.fails(1, &[message]);
        let first = run.stderr.lines().next().unwrap_or_default();
        assert!(first.starts_with("error: m.ply") && !run.stderr.contains('\u{1b}'), "{}", run.stderr);
        assert_eq!(run.stderr.lines().count(), 5, "{}", run.stderr);
    }
    for (from, to) in [
        ("uchar int", "uint8 uint32"),
        ("uchar int", "int short"),
        ("indices", "index"),
        ("ply\n", "\u{feff}ply\n"),
        ("\n", "\r\n"),
    ] {
        place.write("m.ply", good.replacen(from, to, if from == "\n" { 99 } else { 1 }));
        place.hfvdb("check s.toml").ok();
    }
}

#[test]
fn text_of_other_encodings() {
    let cube = String::from_utf8(kept("two-corner-face.obj")).expect("it is a text").replace("f 1 2\n", "");
    let wide = |mark: bool, little: bool| -> Vec<u8> {
        let units = mark.then_some(0xfeff).into_iter().chain(cube.encode_utf16());
        units.flat_map(|unit| if little { unit.to_le_bytes() } else { unit.to_be_bytes() }).collect()
    };
    for (mark, little) in [(true, true), (true, false), (false, true), (false, false)] {
        let (_, run) = bake("m.obj", wide(mark, little), "");
        run.fails(1, &["m.obj: is text in UTF-16", "save it as UTF-8"]);
    }
    for ends in ["\r", "\r\n"] {
        let (_, run) = bake("m.obj", cube.replace('\n', ends), "");
        assert!((volume(&run.ok()) - 8.0).abs() < 0.1);
    }
    // Scenes saved by an editor that begins them with a mark.
    let place = Workplace::new();
    place.write("m.obj", &cube);
    place.write("s.toml", "\u{feff}hfvdb = 1\n[shape.m]\nmesh = \"m.obj\"\n");
    place.write("s.json", "\u{feff}{\"hfvdb\": 1, \"shape\": {\"m\": {\"mesh\": \"m.obj\"}}}");
    place.hfvdb("check s.toml").ok();
    place.hfvdb("check s.json").ok();
    place.write("wide.toml", wide(true, true));
    place.hfvdb("check wide.toml").fails(1, &["wide.toml", "UTF-8"]);
}

/// A cube of edge 2 with a picture on its upper side, which is red along x and green along y in equal steps of light.
fn pictured(folder: &Workplace) {
    let encoded = |light: f64| {
        let encoded = if light <= 0.003_130_8 { 12.92 * light } else { 1.055 * light.powf(1.0 / 2.4) - 0.055 };
        (encoded * 255.0).round() as u8
    };
    let picture = image::RgbImage::from_fn(128, 128, |x, y| {
        let along = |at: u32| encoded((f64::from(at) + 0.5) / 128.0);
        image::Rgb([along(x), along(127 - y), 0])
    });
    picture.save(folder.path("skin.png")).expect("it can be written");
    let cube = "mtllib a.mtl\nv -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
                vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl plain\nf 1 4 3 2\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n\
                usemtl skin\nf 5/1 6/2 7/3 8/4\n";
    folder.write("a.obj", cube);
    folder.write("a.mtl", "newmtl plain\nKd 0.25 0.5 0.75\nnewmtl skin\nKd 0.1 0.1 0.1\nmap_Kd -clamp on skin.png\n");
}

#[test]
fn pictures_and_materials_are_the_colour() {
    let place = Workplace::new();
    pictured(&place);
    let run = place.hfvdb("convert a.obj -o a.vdb --voxel-size 0.02").ok();
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    let contents = hfvdb::vdb::read(place.path("a.vdb")).expect("a file of ours");
    let band = contents.grids[0].to_band().expect("a level set");
    let hfvdb::vdb::Voxels::Vectors(colours) = &contents.grids[1].voxels else { panic!("Cd is of colours") };
    let (mut upper, mut sides) = (0, 0);
    for ((origin, values), mask) in colours.origins.iter().zip(&colours.values).zip(&colours.active) {
        let centres = hfvdb::field::Points::of_block(*origin, &band.lattice);
        for at in (0..values.len()).filter(|&at| hfvdb::grid::is_active(mask, at)) {
            let p = centres.position(at);
            let [r, g, b] = values[at].map(f64::from);
            if p.x.abs().max(p.y.abs()) < 0.9 && p.z > 0.0 {
                upper += 1;
                // By 8 bits of sRGB light is known to 1/255 · the slope of the curve, which is 2.3 at most.
                let off = (r - (1.0 + p.x) / 2.0).abs().max((g - (1.0 + p.y) / 2.0).abs()).max(b);
                assert!(off < 0.005, "{r} {g} {b} at {p}");
            } else if p.z.abs() < 0.9 {
                sides += 1;
                assert!((r - 0.25).abs().max((g - 0.5).abs()).max((b - 0.75).abs()) < 1e-6, "{r} {g} {b} at {p}");
            }
        }
    }
    assert!(upper > 10_000 && sides > 10_000, "{upper} {sides}");

    // What its materials name is part of what identifies the scene.
    let again = |name: &str| place.hfvdb(&format!("convert a.obj -o {name} --voxel-size 0.1")).ok();
    again("b.vdb");
    place.hfvdb("convert a.obj -o b.vdb --voxel-size 0.1 --resume").ok();
    place.write("a.mtl", "newmtl plain\nKd 1 0 0\n");
    let run = place.hfvdb("convert a.obj -o b.vdb --voxel-size 0.1 --resume");
    run.fails(1, &["another scene"]);
}

#[test]
fn surfaces_with_holes_and_sheets() {
    let place = Workplace::new();
    pictured(&place);
    let cube = std::fs::read_to_string(place.path("a.obj")).expect("it was written");
    place.write("open.obj", cube.replace("f 5/1 6/2 7/3 8/4\n", ""));
    place
        .hfvdb("convert open.obj -o open.vdb --voxel-size 0.1")
        .fails(1, &["4 boundary edges", "sign = \"winding\"", "thickness"]);
    let volume = |options: &str| {
        let command = format!("convert open.obj -o open.vdb --overwrite --json --voxel-size 0.05 {options}");
        volume(&place.hfvdb(&command).ok())
    };
    // From any point of the open side the other five fill half of what there is to see: the sheet across it is flat.
    let closed = volume("--sign winding");
    assert!((closed - 8.0).abs() < 0.1, "{closed}");
    // Five sides of 2 by 2, and the rounded rims: a sheet of 0.2 on both sides of them.
    let sheet = volume("--thickness 0.2");
    assert!((sheet - 20.0 * 0.2).abs() < 0.3, "{sheet}");
}

/// What `check` says of a mesh.
fn checked(place: &Workplace, file: &str) -> Value {
    json(&place.hfvdb(&format!("check {file} --json")).ok().stdout)["files"][0]["mesh"].clone()
}

#[test]
fn frames_as_polygons_are_closed_and_sharp() {
    let place = Workplace::new();
    place.write(
        "box.toml",
        "hfvdb = 1\n[shape.a]\nbox = [1, 0.8, 0.6]\nrotate = [10, 20, 30]\ncolor = '#804020'\nattribute.wear = 'x'\n",
    );
    for ending in ["ply", "glb"] {
        place.hfvdb(&format!("bake box.toml --voxel-size 0.05 -o a.{ending}")).ok();
        let mesh = checked(&place, &format!("a.{ending}"));
        let edges = ["boundary_edges", "inconsistent_edges", "non_manifold_edges"].map(|key| mesh[key].as_u64());
        assert_eq!(edges, [Some(0); 3], "{ending}");
        // Corners and edges are sharp but where one passes a cell without crossing its edges: without that 0.003 is missing.
        let volume = mesh["volume"].as_f64().expect("a number");
        assert!((volume - 0.48).abs() < 5e-4, "{ending}: {volume}");
        assert_eq!(mesh["vertex_colours"], true);
    }
    place.hfvdb("bake box.toml --voxel-size 0.05 -o a.obj").fails(2, &["no attributes such as `wear`", ".ply"]);
    place.hfvdb("bake box.toml --voxel-size 0.05 -o b.ply --half-width 1.5").fails(2, &["2.5 voxels"]);

    // Where it is smooth its vertices are on it, as many pieces as meet in a cell.
    place.write("ball.toml", "hfvdb = 1\n[shape.a]\ndifference = ['b', 'c', 'd']\n[shape.b]\nsphere = 1\n[shape.c]\nsphere = 0.97\n[shape.d]\nbox = 1.1\n");
    place.hfvdb("bake ball.toml --voxel-size 0.05 -o s.obj").ok();
    let mesh = checked(&place, "s.obj");
    assert_eq!((mesh["boundary_edges"].as_u64(), mesh["inconsistent_edges"].as_u64()), (Some(0), Some(0)));
    place.write("one.toml", "hfvdb = 1\n[shape.a]\nsphere = 1\n");
    place.hfvdb("bake one.toml --voxel-size 0.1 -o one.obj").ok();
    let text = std::fs::read_to_string(place.path("one.obj")).expect("it was written");
    let mut vertices = 0;
    for line in text.lines().filter_map(|line| line.strip_prefix("v ")) {
        let along: Vec<f64> = line.split(' ').take(3).map(|word| word.parse().expect("a number")).collect();
        let radius = along.iter().map(|x| x * x).sum::<f64>().sqrt();
        // A cell's planes touch the ball where its edges do, at most half of its diagonal away: (√3/2·h)²/2 outside of it.
        assert!((-1e-6..0.00375).contains(&(radius - 1.0)), "{radius}");
        vertices += 1;
    }
    assert!(vertices > 1000, "{vertices}");
    // And what was written comes back in as a shape, a morph among them.
    place.hfvdb("bake cube-to-heart --resolution 40 --frames 12 -o m.####.glb").ok();
    assert_eq!(checked(&place, "m.0012.glb")["boundary_edges"], 0);
    place.hfvdb("convert m.0012.glb -o m.vdb --resolution 40").ok();
}

#[test]
fn voxels_become_polygons() {
    let place = Workplace::new();
    let scene = "hfvdb = 1\nframes = '1-3'\nunit = 'cm'\n[shape.a]\nsphere = '0.8 + 0.1*t'\n\
                 color = { linear = ['0.5+0.4*x', '0.5+0.4*y', 0.25] }\nattribute.wear = 'z'\n\
                 [output]\ngrids = ['surface', 'density', 'Cd', 'wear', 'vel']\n";
    place.write("ball.toml", scene);
    place.hfvdb("bake ball.toml --voxel-size 0.05 -o a.####.vdb").ok();
    let run = place.hfvdb("mesh a.####.vdb -o a.####.ply").ok();
    assert!(run.stderr.contains("its velocity is left out"), "{}", run.stderr);
    for frame in 1..=3 {
        let name = format!("a.000{frame}.ply");
        let mesh = checked(&place, &name);
        assert_eq!((mesh["boundary_edges"].as_u64(), mesh["inconsistent_edges"].as_u64()), (Some(0), Some(0)));
        let radius = 0.8 + 0.05 * f64::from(frame - 1);
        let exact = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        assert!((mesh["volume"].as_f64().expect("a number") / exact - 1.0).abs() < 0.01, "{mesh}");
        // Read by hand: x, y, z, three bytes of colour, the attribute.
        let bytes = std::fs::read(place.path(&name)).expect("it was written");
        let end = bytes.windows(11).position(|window| window == b"end_header\n").expect("a header") + 11;
        let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
        assert!(head.contains("comment unit cm"), "{head}");
        let count = head.lines().find_map(|line| line.strip_prefix("element vertex ")).expect("vertices");
        for vertex in bytes[end..].chunks_exact(19).take(count.parse().expect("a number")) {
            let float = |at: usize| f64::from(f32::from_le_bytes(vertex[at..at + 4].try_into().expect("four bytes")));
            let [x, y, z] = [0, 4, 8].map(float);
            assert!(((x * x + y * y + z * z).sqrt() - radius).abs() < 0.005, "{x} {y} {z}");
            assert!((float(15) - z).abs() < 0.003, "{} at z = {z}", float(15));
            for (byte, linear) in vertex[12..15].iter().zip([0.5 + 0.4 * x, 0.5 + 0.4 * y, 0.25]) {
                let srgb = 1.055 * linear.powf(1.0 / 2.4) - 0.055;
                assert!((f64::from(*byte) / 255.0 - srgb).abs() < 2.0 / 255.0, "{byte}, not {srgb}");
            }
        }
    }
    // Fog from a value on, and what such files are made of is said.
    let run = place.hfvdb("convert a.0001.vdb -o fog.obj --grid density --threshold 0.25 --voxel-size 0.1").ok();
    assert!(run.stderr.contains("wear: left out; .obj has no attributes"), "{}", run.stderr);
    assert_eq!(checked(&place, "fog.obj")["boundary_edges"], 0);
    // And back into voxels, by frame, with what they have.
    place.hfvdb("convert a.####.vdb -o b.####.vdb --frames 2").ok();
    let info = place.hfvdb("info b.0002.vdb").ok().stdout;
    assert!(info.contains("grid wear") && info.contains("grid vel") && info.contains("hfvdb_unit: cm"), "{info}");
    for (command, wanted) in [
        ("mesh a.0001.vdb -o b.vdb", "mesh writes polygons"),
        ("mesh fog.obj -o b.ply", "mesh takes .vdb files"),
        ("convert fog.obj -o b.vdb --threshold 0.3", "are about .vdb files"),
        ("convert a.0001.vdb -o b.ply --sign winding", "--sign is about meshes"),
        ("mesh a.####.vdb -o b.ply", "3 frames would go into one file"),
    ] {
        place.hfvdb(command).fails(2, &[wanted]);
    }
    place.hfvdb("mesh c.####.vdb -o b.####.ply").fails(1, &["no frame with such a name"]);
    place.hfvdb("mesh a.0001.vdb -o b.ply --grid wearr").fails(1, &["there is no grid 'wearr'"]);
    place.write("bad.vdb", "no voxels");
    place.hfvdb("mesh bad.vdb -o b.ply").fails(1, &["bad.vdb"]);
}

/// A cube of two materials: roughness plain, and of one by a picture whose half of black and white is a half, not what sRGB
/// makes of that.
#[test]
fn roughness_of_materials_is_a_number() {
    let mut cube = String::from("mtllib cube.mtl\nvt 0.5 0.5\n");
    for i in 0..8 {
        let at = |bit: i32| if i >> bit & 1 == 0 { -1 } else { 1 };
        let _ = writeln!(cube, "v {} {} {}", at(0), at(1), at(2));
    }
    for (material, faces) in [
        ("plain", &[[1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3]][..]),
        ("drawn", &[[2, 4, 8, 6], [1, 3, 4, 2], [5, 6, 8, 7]]),
    ] {
        let _ = writeln!(cube, "usemtl {material}");
        for [a, b, c, d] in faces {
            let _ = writeln!(cube, "f {a}/1 {b}/1 {c}/1 {d}/1");
        }
    }
    let place = Workplace::new();
    place.write("cube.obj", &cube);
    place.write("cube.mtl", "newmtl plain\nPr 0.25\nPm 1\nnewmtl drawn\nKd 1 0 0\nmap_Pr half.png\n");
    let mut picture = std::io::BufWriter::new(std::fs::File::create(place.path("half.png")).unwrap());
    let mut encoder = png::Encoder::new(&mut picture, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[128, 0, 0]).unwrap();
    drop(picture);
    let scene = |which: &str| {
        format!(
            "hfvdb = 1\n[output]\ngrids = ['surface', 'n']\n[shape.m]\nmesh = 'cube.obj'\nattribute.n = {{ material = '{which}' }}\n"
        )
    };
    for (which, least, greatest) in [("roughness", 0.25, 128.0 / 255.0), ("metallic", 1.0, 1.0)] {
        place.write("s.toml", scene(which));
        place.hfvdb("bake s.toml -o o.vdb --resolution 24 --overwrite").ok();
        let range = &grid(&place, "o.vdb", "n")["range"];
        for (end, wanted) in [("least", least), ("greatest", greatest)] {
            let found = range[end][0].as_f64().unwrap();
            assert!((found - wanted).abs() < 1e-6, "{which}: {range}");
        }
    }
    // What says none, and what has no materials.
    place.write("cube.mtl", "newmtl plain\nKd 1 1 1\nnewmtl drawn\nKd 1 0 0\n");
    place.hfvdb("check s.toml").fails(1, &["no material in the file of `m` says its metallic", "`Pr`"]);
    place.write("s.toml", scene("roughness").replace("mesh = 'cube.obj'", "sphere = 1"));
    place.hfvdb("check s.toml").fails(1, &["`m` has no materials: only a shape of a `mesh` has"]);
}

/// A leaf with a face to either side encloses nothing, and a sheet of it does.
#[test]
fn doubled_faces_are_a_sheet() {
    let leaf = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 4 3 2 1\n";
    let (_, run) = bake("leaf.obj", leaf, "thickness = 0.2");
    // With round edges.
    let exact = 0.2 + 4.0 * std::f64::consts::PI * 0.1 * 0.1 / 2.0 + 4.0 / 3.0 * std::f64::consts::PI * 0.001;
    let run = run.ok();
    assert!((volume(&run) - exact).abs() < 0.01, "{} {exact}", volume(&run));
    let (_, run) = bake("leaf.obj", leaf, "");
    run.fails(1, &["encloses no volume", "thickness"]);
}

/// A cube of this half edge.
fn cube(half: f64) -> String {
    let mut text = String::new();
    for corner in 0..8 {
        let side = |bit: i32| if corner >> bit & 1 == 1 { half } else { -half };
        writeln!(text, "v {} {} {}", side(2), side(1), side(0)).unwrap();
    }
    for [a, b, c, d] in [[1, 2, 4, 3], [5, 7, 8, 6], [1, 5, 6, 2], [3, 4, 8, 7], [1, 3, 7, 5], [2, 6, 8, 4]] {
        writeln!(text, "f {a} {b} {c} {d}").unwrap();
    }
    text
}

#[test]
fn frames_need_only_their_own_files() {
    let place = Workplace::new();
    for number in [1, 2, 3, 5, 6] {
        place.write(&format!("m.{number:04}.obj"), cube(0.5 + 0.05 * f64::from(number)));
    }
    place.write("s.toml", "hfvdb = 1\nframes = \"1-6\"\n[shape.m]\nmesh = \"m.####.obj\"\n");
    let bake = |frames: &str| place.hfvdb(&format!("bake s.toml -o out/m.####.vdb --voxel-size 0.1 {frames}"));
    let missing = "frame 4 of `m.####.obj` is missing: there is 1-3, 5-6";
    place.hfvdb("check s.toml").fails(1, &["s.toml:4:9", missing, "m.0004.obj"]);
    bake("").fails(1, &["s.toml:4:9", missing]);
    let shows = "frame 4 shows files of `m.####.obj` that are missing: there is 1-3, 5-6";
    bake("--frames 3-5").fails(1, &["s.toml:4:9", shows, "write m.0004.obj first"]);
    place.hfvdb("preview s.toml --frames 4 -o p.png").fails(1, &[shows]);
    place.hfvdb("probe s.toml 0 0 0 --frame 4").fails(1, &[shows]);
    assert!(!place.path("out").exists(), "nothing was begun");

    says(&bake("--frames 2-3,5").ok().stderr, &[missing, "none of the frames asked for shows them"]);
    assert_eq!(place.frames("out"), ["m.0002.vdb", "m.0003.vdb", "m.0005.vdb"]);
    // A frame is its file's, also beside a gap.
    place.write("alone.toml", "hfvdb = 1\n[shape.m]\nmesh = \"m.0003.obj\"\n");
    place.hfvdb("bake alone.toml -o alone.vdb --voxel-size 0.1").ok();
    let range = |file: &str| {
        [grid(&place, file, "surface")["range"].clone(), grid(&place, file, "surface")["index_box"].clone()]
    };
    assert_eq!(range("out/m.0003.vdb"), range("alone.vdb"));
    says(&bake("--frames 2-3,5 --resume").ok().stderr, &["3 of 3 frames are done"]);

    // What one of its files has changed makes a frame anew, and what was missing.
    place.write("m.0003.obj", cube(0.9));
    let before = range("out/m.0003.vdb");
    bake("--frames 3 --overwrite").ok();
    assert_ne!(range("out/m.0003.vdb"), before);
    place.write("m.0004.obj", cube(0.7));
    let whole = bake("--overwrite").ok();
    assert!(!whole.stderr.contains("missing"), "{}", whole.stderr);
    assert_eq!(place.frames("out").len(), 6);
}
