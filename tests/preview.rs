//! Pictures of scenes and files, read back by decoders of PNG and EXR.

mod support;

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use exr::prelude::{FlatSamples, ReadChannels, ReadLayers, read};
use support::{BALL, Workplace, json, workplace};

/// The frames of a PNG: pixels of four bytes, the edge, and for how many seconds each is shown.
fn pictures(place: &Workplace, name: &str) -> (Vec<Vec<u8>>, usize, Vec<f64>) {
    let file = BufReader::new(File::open(place.path(name)).expect("a picture"));
    let mut reader = png::Decoder::new(file).read_info().expect("a PNG");
    let count = reader.info().animation_control.map_or(1, |control| control.num_frames);
    let edge = reader.info().width as usize;
    let (mut frames, mut seconds) = (Vec::new(), Vec::new());
    for _ in 0..count {
        let mut pixels = vec![0; reader.output_buffer_size().expect("a size")];
        reader.next_frame(&mut pixels).expect("a frame");
        frames.push(pixels);
        let control = reader.info().frame_control;
        seconds.extend(control.map(|control| f64::from(control.delay_num) / f64::from(control.delay_den)));
    }
    (frames, edge, seconds)
}

/// How many pixels differ from the corner's.
fn drawn(pixels: &[u8]) -> usize {
    pixels.chunks_exact(4).filter(|pixel| pixel[..3].iter().zip(&pixels[..3]).any(|(a, b)| a.abs_diff(*b) > 40)).count()
}

#[test]
fn the_name_says_what_is_made() {
    let place = workplace();
    let preview = |rest: &str| place.hfvdb(&format!("preview ball.toml --resolution 32 {rest}"));
    let sheet = json(&preview("-o sheet.png --frames 1,12,24 --size 64 --json").ok().stdout);
    assert_eq!(sheet["frames"].as_array().map(Vec::len), Some(3));
    assert!(pictures(&place, "sheet.png").1 > 3 * 64);

    // Each picture is shown until the next one; the ball grows under a camera that stands still.
    preview("-o ball.apng --frames 1-10x3,24 --size 64").ok();
    let (frames, edge, seconds) = pictures(&place, "ball.apng");
    assert_eq!((frames.len(), edge), (5, 64));
    let expected = [3.0, 3.0, 3.0, 14.0, 14.0].map(|frames| frames / 24.0);
    assert!(seconds.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-4), "{seconds:?}");
    let areas: Vec<usize> = frames.iter().map(|frame| drawn(frame)).collect();
    assert!(areas.is_sorted() && areas[4] > 3 * areas[0], "{areas:?}");

    let files = preview("-o each.####.png --frames 3,7 --size 64").ok();
    assert_eq!(files.stdout, "each.0003.png\neach.0007.png\n");
    assert_eq!(pictures(&place, "each.0007.png").1, 64);
}

/// Files that are no sequence are not taken for one, whatever digits their names end in.
#[test]
fn files_of_several_names_stand_side_by_side() {
    let place = workplace();
    for name in ["beta=0.5", "beta=0.15", "ring.5"] {
        place.hfvdb(&format!("bake ball.toml --resolution 24 --frames 24 -o {name}.vdb")).ok();
    }
    let told = place.hfvdb("preview beta=0.5.vdb beta=0.15.vdb ring.5.vdb --size 64 -o all.png --json").ok();
    let told = json(&told.stdout);
    assert_eq!((0..3).map(|i| told["frames"][i]["frame"].as_i64().unwrap()).collect::<Vec<_>>(), [1, 2, 3]);
    let files = place.hfvdb("preview beta=0.5.vdb ring.5.vdb --size 64 -o each.####.png").ok();
    assert_eq!(files.stdout, "each.0001.png\neach.0002.png\n");
}

/// A pattern is the frames that are there, in the order of their numbers, whatever else lies beside them.
#[test]
fn a_pattern_is_the_frames_that_are_there() {
    let place = workplace();
    place.hfvdb("bake ball.toml --resolution 24 --frames 9,12,24 -o ball.#.vdb").ok();
    place.write("ball.notes.vdb", "no frame");
    let shown = |rest: &str| {
        let told = json(&place.hfvdb(&format!("preview {rest} --size 64 -o sheet.png --json")).ok().stdout);
        let frames = told["frames"].as_array().expect("frames").clone();
        frames.iter().map(|frame| frame["frame"].as_i64().expect("a number")).collect::<Vec<_>>()
    };
    for pattern in ["ball.#.vdb", "ball.%d.vdb", "ball.$F.vdb"] {
        assert_eq!(shown(pattern), [9, 12, 24]);
    }
    assert_eq!(shown("ball.#.vdb --frames 9-24x15"), [9, 24]);
    let fails = |arguments: &str, told: &[&str]| place.hfvdb(&format!("preview {arguments} -o no.png")).fails(1, told);
    fails("ball.#.vdb --frames 10-12", &["ball.#.vdb: no frame 10-11; there is 9,12,24"]);
    fails("egg.####.vdb", &["egg.####.vdb: there is no frame with such a name"]);
}

#[test]
fn layers_go_into_an_exr() {
    let place = workplace();
    place.hfvdb("preview ball.toml --resolution 32 --frames 24 --size 64 --view front -o ball.exr").ok();
    let image = read().no_deep_data().largest_resolution_level().all_channels().all_layers().all_attributes();
    let image = image.from_file(place.path("ball.exr")).expect("an EXR");
    let value = |name: &str| {
        let channels = &image.layer_data[0].channel_data.list;
        let channel = channels.iter().find(|channel| channel.name.to_string() == name);
        let samples = &channel.unwrap_or_else(|| panic!("no {name}")).sample_data;
        assert_eq!(matches!(samples, FlatSamples::F32(_)), name == "depth.Z");
        samples.value_by_flat_index(32 * 64 + 32).to_f32()
    };
    // sRGB (0.5, 1, 0), seen from −y.
    for (name, expected) in [
        ("colour.R", 0.214),
        ("colour.G", 1.0),
        ("colour.B", 0.0),
        ("normal.X", 0.0),
        ("normal.Y", -1.0),
        ("normal.Z", 0.0),
        ("mask.A", 1.0),
        ("A", 1.0),
    ] {
        assert!((value(name) - expected).abs() < 0.05, "{name} is {}", value(name));
    }
    assert!(value("depth.Z") > 1.0 && value("depth.Z") < 100.0 && value("G") > value("R"));
    // Several need several files, and a slice has no layers.
    place.hfvdb("preview ball.toml -o ball.exr").fails(2, &["24 frames", "name.####.exr"]);
}

/// The same plane of a scene and of its file: the line of the surface is at the same place, and the colour of the voxels
/// beside it the same. Deep inside, the scene's colour is known, the file's is not.
#[test]
fn slices_of_scenes_and_files_agree() {
    let place = workplace();
    place.hfvdb("bake ball.toml --resolution 64 --frames 24 -o ball.vdb").ok();
    place.hfvdb("preview ball.toml --resolution 64 --frames 24 --slice z=0.25 --size 200 -o scene.png").ok();
    place.hfvdb("preview ball.vdb --slice z=0.25 --size 200 -o file.png").ok();
    let (scene, file) = (pictures(&place, "scene.png").0.remove(0), pictures(&place, "file.png").0.remove(0));
    let green = |pixels: &[u8]| {
        let [red, green, blue] = [0, 1, 2].map(|channel| move |pixel: &[u8]| i32::from(pixel[channel]));
        let is_green = |pixel: &&[u8]| green(pixel) > red(pixel) + 50 && green(pixel) > blue(pixel) + 50;
        pixels.chunks_exact(4).filter(is_green).count()
    };
    // A disc of radius √(1 − 0.25²), at 2.48 units for 200 pixels.
    let disc = std::f64::consts::PI * (1.0 - 0.0625) * (200.0_f64 / 2.48).powi(2);
    let inside = green(&scene) as f64 / disc;
    assert!((0.8..1.0).contains(&inside), "{inside} of the disc, less its lines");
    assert!(green(&file) > 1000 && green(&file) * 2 < green(&scene));
    let middle = (100 * 200 + 100) * 4;
    assert_eq!(file[middle..middle + 3], [204, 204, 204]);

    place.hfvdb("preview ball.toml --slice z=3 -o no.png").fails(1, &["z = 3", "misses the object"]);
    place.hfvdb("preview ball.toml --slice up -o no.png").fails(2, &["such as z=0"]);
    place.hfvdb("preview ball.toml --slice z=0 --view top -o no.png").fails(2, &["--view"]);
    assert!(!place.path("no.png").exists());
}

#[test]
fn an_empty_frame_is_a_blank_tile_where_that_is_allowed() {
    let place = Workplace::new();
    place.write(
        "gone.toml",
        "hfvdb = 1\nframes = \"1-3\"\n[shape.ball]\nsphere = 0.5\n[shape.box]\nbox = 1\nmove = [{ 1 = 0, 3 = 1.5 }, 0, 0]\n\
         [shape.both]\nintersection = [\"ball\", \"box\"]\n",
    );
    place.hfvdb("preview gone.toml --resolution 16 -o gone.apng").fails(1, &["frame 3 is empty", "--allow-empty"]);
    assert!(!place.path("gone.apng").exists());
    let run = place.hfvdb("preview gone.toml --resolution 16 --size 64 --allow-empty -o gone.apng").ok();
    assert!(run.stderr.contains("frame 3 is empty"), "{}", run.stderr);
    let frames = pictures(&place, "gone.apng").0;
    assert!(drawn(&frames[0]) > 100 && drawn(&frames[2]) == 0);
    place.hfvdb("preview gone.toml --resolution 16 --size 64 --allow-empty -o gone.png").ok();
    // An empty file is one on purpose.
    place.hfvdb("bake gone.toml --resolution 16 --allow-empty --frames 3 -o gone.vdb").ok();
    place.hfvdb("preview gone.vdb --slice z=0 --size 64 -o file.png").ok();
}

/// Debian's Python OpenVDB makes a level set whose deepest voxel lies 0.02 voxels inside: `check` and `preview` say so.
#[test]
fn a_level_set_without_inside_is_told() {
    const MAKER: &str = "
import numpy as np, pyopenvdb as vdb
size = 0.1
distance = np.abs(np.indices((17,) * 3)[2] - 8.0) * size - 0.02 * size
grid = vdb.FloatGrid(3 * size)
grid.copyFromArray(np.clip(distance, -3 * size, 3 * size).astype(np.float32), ijk=(-8,) * 3)
grid.gridClass, grid.name, grid.transform = vdb.GridClass.LEVEL_SET, 'surface', vdb.createLinearTransform(size)
for frame in (1, 2):
    vdb.write('skin.%04d.vdb' % frame, grids=[grid])
";
    let place = workplace();
    place.run(Command::new("/usr/bin/python3").args(["-c", MAKER])).ok();
    place.hfvdb("check skin.0001.vdb").fails(1, &["nothing is inside", "0.02 voxels below the surface"]);
    place
        .hfvdb("preview skin.0001.vdb -o skin.png --size 64")
        .fails(1, &["frame 1 has nothing inside", "nothing is inside in any frame", "--allow-empty"]);
    assert!(!place.path("skin.png").exists());
    place.hfvdb("preview skin.####.vdb -o skin.png --size 64").fails(1, &["frame 1 has nothing inside", "frame 2 has"]);
    place.hfvdb("preview skin.0001.vdb -o skin.png --size 64 --allow-empty").ok();
    // Beside frames that show something it is a frame without.
    place.hfvdb("bake ball.toml --resolution 16 -o skin.####.vdb --frames 2 --overwrite").ok();
    let run = place.hfvdb("preview skin.####.vdb -o skin.png --size 64").ok();
    assert!(run.stderr.contains("frame 1 has nothing inside") && !run.stderr.contains("frame 2"), "{}", run.stderr);
}

#[test]
fn what_cannot_be_a_picture_is_refused() {
    let place = workplace();
    place.hfvdb("preview ball.toml -o ball.jpg").fails(2, &["ball.jpg", ".apng"]);
    place.hfvdb("preview ball.toml -o ball.####.apng").fails(2, &["leave the frame token out"]);
    place.hfvdb("preview ball.toml egg.toml -o ball.png").fails(2, &["one scene"]);
    place.hfvdb("preview m.vdb --frames 3 -o ball.png").fails(2, &["--frames"]);
    place.hfvdb("preview ball.toml --resolution 16 --frames 1 -o no/such/ball.exr").fails(1, &["no/such/ball.exr"]);
}

/// A scene that is saved: wrong, then right, and each time the picture is that of what was saved last.
#[test]
fn a_watched_scene_is_followed() {
    let place = workplace();
    let mut command = Command::new(env!("CARGO_BIN_EXE_hfvdb"));
    command.args(["preview", "ball.toml", "-o", "ball.png", "--watch", "--open"]);
    command.args(["--frames", "24", "--size", "48", "--resolution", "16"]).current_dir(place.root());
    // No browser is to be opened by a test.
    command.env("PATH", "/nonexistent").stdout(Stdio::null()).stderr(Stdio::piped());
    let mut child = command.spawn().expect("the program starts");
    let mut said = BufReader::new(child.stderr.take().expect("its messages"));
    let mut wait_for = |text: &str| {
        let mut line = String::new();
        while !line.contains(text) {
            line.clear();
            assert!(said.read_line(&mut line).expect("a line") > 0, "it ended before it said {text:?}");
        }
    };
    wait_for("ball.html");
    wait_for("waiting for changes");
    let first = pictures(&place, "ball.png").0;
    place.write("ball.toml", BALL.replace("sphere", "sphare"));
    wait_for("sphare");
    assert_eq!(pictures(&place, "ball.png").0, first, "the last good picture stays");
    place.write("ball.toml", BALL.replace("0.5, \"t\", 0", "0, 0, \"t\""));
    wait_for("waiting for changes");
    assert_ne!(pictures(&place, "ball.png").0, first);
    let page = std::fs::read_to_string(place.path("ball.html")).expect("a page");
    assert!(page.contains("src=\"ball.png\""), "{page}");
    let killed = Command::new("/bin/kill").args(["-INT", &child.id().to_string()]).status().expect("a signal");
    assert!(killed.success());
    assert_eq!(child.wait().expect("its end").code(), Some(130));
    place.hfvdb("preview sphere -o ball.png --watch").fails(2, &["hfvdb scenes sphere > sphere.toml"]);
}

/// Through a pipe there are no pixels to be shown: half blocks, in colours.
#[test]
fn a_terminal_shows_blocks() {
    let place = workplace();
    let run = place.hfvdb("preview ball.toml --terminal --frames 24 --size 48 --resolution 16").ok();
    assert!(run.stdout.matches('\u{2584}').count() > 200, "{}", run.stdout);
    assert!(run.stdout.contains("\u{1b}["), "in colours");
    place.hfvdb("preview ball.toml").fails(2, &["--output"]);
    place.hfvdb("preview ball.toml --terminal -o ball.apng").fails(2, &["what a .png holds"]);
}

/// A draft and a final picture show the same: few pixels differ by more than a little.
#[test]
fn a_draft_is_like_the_final_picture() {
    let place = workplace();
    for quality in ["draft", "final"] {
        let of_all = "--frames 24 --size 200 --resolution 90";
        place.hfvdb(&format!("preview ball.toml {of_all} --quality {quality} -o {quality}.png")).ok();
    }
    let (draft, fin) = (pictures(&place, "draft.png").0, pictures(&place, "final.png").0);
    let apart = |(a, b): (&[u8], &[u8])| a.iter().zip(b).map(|(a, b)| a.abs_diff(*b)).max().unwrap_or(0);
    let all = || draft[0].chunks_exact(4).zip(fin[0].chunks_exact(4)).map(apart);
    let (count, far) = (all().count(), all().filter(|&apart| apart > 12).count());
    assert!(far * 100 < count, "{far} of {count} pixels");
    assert!(all().any(|apart| apart > 0), "both are the same picture");
}

/// Distances as far as the picture goes, and an attribute inside; what is not there is told with what there is.
#[test]
fn slices_show_distances_and_attributes() {
    let place = Workplace::new();
    let ball = "[shape.a]\nellipsoid = [1, 0.8, 0.6]\nattribute.heat = '10*y'\n";
    place.write("ball.toml", ball);
    let slice = |of: &str, file: &str| {
        format!("preview ball.toml --slice z=0 --size 60 --resolution 32 --slice-of {of} -o {file}")
    };
    place.hfvdb(&slice("distance", "far.png")).ok();
    place.hfvdb(&slice("heat", "heat.png")).ok();
    place.hfvdb(&slice("heta", "no.png")).fails(2, &["no such attribute", "band, distance, f, gradient, heat"]);
    place.hfvdb("bake ball.toml --resolution 16 -o ball.vdb").ok();
    place.hfvdb("preview ball.vdb --slice z=0 --slice-of distance -o no.png").fails(2, &["has its band alone"]);
    assert!(!place.names(".").contains(&"no.png".to_owned()));
    // Far from the band the distance is that of the surface, and not what the band ends with.
    place.hfvdb(&slice("distance", "far.exr")).ok();
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.from_file(place.path("far.exr")).expect("an EXR");
    let channels = &image.layer_data.channel_data.list;
    let distance = channels.iter().find(|channel| channel.name.to_string() == "distance.V").expect("distances");
    let distance: Vec<f32> = distance.sample_data.values_as_f32().collect();
    let pixel = 2.0 * 1.24 / 60.0;
    // The corner of the picture sees the ellipse at about its own height.
    let corner = f64::from(distance[0]);
    let at = (29.5 * pixel, 29.5 * pixel);
    let nearest = (0..1000).map(|i| f64::from(i) * std::f64::consts::FRAC_PI_2 / 1000.0);
    let nearest = nearest.map(|turn| (at.0 - turn.cos()).hypot(at.1 - 0.8 * turn.sin())).fold(f64::MAX, f64::min);
    assert!((corner + nearest).abs() < 0.05 * nearest, "{corner} {nearest}");
    let told = place.hfvdb("check ball.toml -v --set shape.a.distance={adf=6}").ok().stdout;
    assert!(told.contains("adf: octree of depth 6, "), "{told}");
}

#[test]
fn a_slice_of_numbers_has_all_of_them() {
    let place = Workplace::new();
    let refused = place.hfvdb("preview sphere --slice z=0 --slice-of f -o f.exr");
    refused.fails(2, &["leave --slice-of out"]);
}

/// A slice as numbers: what a shape of the plane has of distance, F, colour and attributes.
#[test]
fn slices_are_numbers_in_an_exr() {
    let place = Workplace::new();
    place.write(
        "disc.toml",
        "hfvdb = 1\n[output]\ngrids = ['surface', 'Cd', 'heat']\n[shape.disc]\ncircle = 1\ncolor = ['x+0.5', 0.25, 0]\nattribute.heat = '10*y'\n",
    );
    place.hfvdb("preview disc.toml --slice z=0 --resolution 64 --size 50 -o disc.exr").ok();
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.from_file(place.path("disc.exr")).expect("an EXR");
    let channel = |name: &str| {
        let channels = &image.layer_data.channel_data.list;
        let found = channels.iter().find(|channel| channel.name.to_string() == name);
        found.unwrap_or_else(|| panic!("no {name}")).sample_data.values_as_f32().collect::<Vec<f32>>()
    };
    let [distance, f, red, inside, heat] = ["distance.V", "F.V", "R", "A", "heat.V"].map(channel);
    // The picture is a little larger than the disc.
    let pixel = 2.0 * 1.24 / 50.0;
    for i in 0..50 * 50 {
        let (x, y) = ((f64::from(i % 50) + 0.5 - 25.0) * pixel, (25.0 - f64::from(i / 50) - 0.5) * pixel);
        let exact = 1.0 - x.hypot(y);
        let i = i as usize;
        // Beside the rim, and not where the slab's own faces are nearer.
        assert!(
            (f64::from(distance[i]) - exact).abs() < 2e-3 || !(-0.3..=0.1).contains(&exact),
            "{} {exact}",
            distance[i]
        );
        assert!((f64::from(f[i]) - exact).abs() < 1e-5 || exact > 0.1, "{} {exact}", f[i]);
        assert_eq!(inside[i], f32::from(distance[i] >= 0.0));
        assert!((f64::from(heat[i]) - 10.0 * y).abs() < 1e-4, "{} {y}", heat[i]);
        // Colours in scenes are sRGB.
        let expected = if inside[i] == 1.0 { ((x + 0.5 + 0.055) / 1.055).powf(2.4).min(1.0) } else { 0.0 };
        assert!(exact.abs() < 0.02 || x < -0.4 || (f64::from(red[i]) - expected).abs() < 1e-2, "{} {expected}", red[i]);
    }
}

/// A file's other grids are channels of a slice, as cubes, with vectors part by part.
#[test]
fn slices_of_files_have_their_other_grids() {
    let place = Workplace::new();
    place.write(
        "ball.toml",
        "frames = '1-3'\n[shape.a]\nsphere = 1\nmove = ['t', 0, 0]\ncolor = ['x+0.5', 0.25, 0]\nattribute.heat = '10*y'\n\
         [output]\nvoxel_size = 0.1\ngrids = ['surface', 'density', 'Cd', 'heat', 'vel']\n",
    );
    place.hfvdb("bake ball.toml --frames 1 -o ball.vdb").ok();
    let told = place.hfvdb("preview ball.vdb --slice z=0.03 --size 60 -o ball.exr").ok();
    assert_eq!(told.stderr, "");
    let image = read().no_deep_data().largest_resolution_level().all_channels().first_valid_layer().all_attributes();
    let image = image.from_file(place.path("ball.exr")).expect("an EXR");
    let channels = &image.layer_data.channel_data.list;
    let names: Vec<String> = channels.iter().map(|channel| channel.name.to_string()).collect();
    assert_eq!(names, ["A", "B", "G", "R", "density.V", "distance.V", "heat.V", "vel.x", "vel.y", "vel.z"]);
    let channel = |name: &str| {
        let found = channels.iter().find(|channel| channel.name.to_string() == name).unwrap();
        found.sample_data.values_as_f32().collect::<Vec<f32>>()
    };
    let stored = hfvdb::vdb::read(place.path("ball.vdb")).unwrap();
    let comment = image.layer_data.attributes.comments.as_ref().unwrap().to_string();
    let numbers: Vec<f64> = comment
        .split(|c: char| !(c.is_ascii_digit() || "-.".contains(c)))
        .filter_map(|number| number.parse().ok())
        .collect();
    let [_, x, y, _, pixel] = numbers[..] else { panic!("{comment}") };
    for (name, at) in [("density.V", None), ("heat.V", None), ("vel.x", Some(0)), ("vel.z", Some(2))] {
        let grid = stored.grids.iter().find(|grid| name.starts_with(&grid.name)).unwrap();
        let values = channel(name);
        let mut known = 0;
        for i in 0..60 * 60 {
            let place = [x + f64::from(i % 60) * pixel, y - f64::from(i / 60) * pixel, 0.03];
            let voxel = glam::DVec3::from(place.map(|along| (along / 0.1).round())).as_ivec3();
            let origin = voxel & glam::IVec3::splat(!7);
            let local = voxel - origin;
            let offset = (local.x * 64 + local.y * 8 + local.z) as usize;
            let exact = match &grid.voxels {
                hfvdb::vdb::Voxels::Floats(blocks) => {
                    blocks.origins.iter().position(|known| *known == origin).map(|block| blocks.values[block][offset])
                }
                hfvdb::vdb::Voxels::Vectors(blocks) => blocks
                    .origins
                    .iter()
                    .position(|known| *known == origin)
                    .map(|block| blocks.values[block][offset][at.unwrap_or(0)]),
            };
            let Some(exact) = exact else { continue };
            known += 1;
            assert!((values[i as usize] - exact).abs() < 1e-6, "{name} at {place:?}: {} {exact}", values[i as usize]);
        }
        assert!(known > 500, "{known} pixels in blocks");
    }
}
