//! Grids beside the surface and its colour, baked by the program and read back: scalars of any name.

mod support;

use std::path::Path;
use std::process::Command;

use glam::DVec3;
use hfvdb::field::Points;
use hfvdb::grid::is_active;
use hfvdb::vdb::{self, StoredGrid, Voxels};
use support::{Workplace, json};

const HEATED: &str = "frames = '1-5'
[shape.ball]
sphere = 0.8
move = [-0.5, 0, 0]
color = 'red'
attribute.heat = 'z'
attribute.mix = 0
[shape.box]
box = 1.2
move = [0.5, 0, 0]
attribute.mix = 1
attribute.heat = { 1 = -3, 5 = 3 }
[morph]
from = 'ball'
to = 'box'
[output]
half = ['mix']
";

fn grid<'g>(contents: &'g vdb::Contents, name: &str) -> &'g StoredGrid {
    contents.grids.iter().find(|grid| grid.name == name).unwrap_or_else(|| panic!("no grid {name}"))
}

fn python_finds_nothing_wrong(place: &Workplace, files: &[&Path]) {
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/check_frames.py");
    place.run(Command::new("/usr/bin/python3").arg(script).args(files)).ok();
}

#[test]
fn scalars_are_float_grids_on_the_voxels_of_the_surface() {
    let place = Workplace::new();
    place.write("heated.toml", HEATED);
    place.hfvdb("bake heated.toml --resolution 48 -o m.####.vdb").ok();
    let files: Vec<_> = (1..=5).map(|frame| place.path(&format!("m.{frame:04}.vdb"))).collect();
    python_finds_nothing_wrong(&place, &files.iter().map(|file| file.as_path()).collect::<Vec<_>>());
    for (frame, file) in files.iter().enumerate() {
        let contents = vdb::read(file).expect("a file of ours");
        let names: Vec<&str> = contents.grids.iter().map(|grid| grid.name.as_str()).collect();
        assert_eq!(names, ["surface", "Cd", "heat", "mix"]);
        let surface = grid(&contents, "surface").to_band().expect("a level set");
        let Voxels::Floats(heat) = &grid(&contents, "heat").voxels else { panic!("heat is of numbers") };
        assert_eq!((&heat.origins, &heat.active), (&surface.origins, &surface.active));
        // On the ball heat is z of the closest point; on the box, at the last frame, 3 everywhere.
        let voxel = surface.lattice.voxel_size.get();
        for ((origin, values), mask) in heat.origins.iter().zip(&heat.values).zip(&heat.active) {
            let centres = Points::of_block(*origin, &surface.lattice);
            for at in (0..values.len()).filter(|&at| is_active(mask, at)) {
                let from_middle = centres.position(at) - DVec3::new(-0.5, 0.0, 0.0);
                let expected = match frame {
                    0 => 0.8 * from_middle.z / from_middle.length(),
                    4 => 3.0,
                    _ => continue,
                };
                assert!((f64::from(values[at]) - expected).abs() < 1e-2 * voxel, "{} {expected}", values[at]);
            }
        }
    }
    let manifest = std::fs::read_to_string(place.path("m.manifest.json")).expect("a manifest");
    let grids = &json(&manifest)["frames"][0]["grids"];
    assert_eq!((&grids[2]["name"], &grids[3]["name"]), (&"heat".into(), &"mix".into()));
    assert_eq!((&grids[3]["least"][0], &grids[3]["greatest"][0]), (&0.0.into(), &0.0.into()));
    let info = vdb::inspect(&files[2]).expect("a file of ours");
    assert_eq!(info.grids.iter().map(|grid| grid.half).collect::<Vec<_>>(), [false, false, false, true]);
}

#[test]
fn options_name_the_grids_that_there_are() {
    let place = Workplace::new();
    place.write("heated.toml", HEATED);
    let bake = "bake heated.toml --resolution 16 --frames 2 -o m.####.vdb";
    place.hfvdb(&format!("{bake} --half heat,Cd")).ok();
    place.hfvdb(&format!("{bake} --overwrite --half heet")).fails(2, &["no grid \"heet\"", "surface, Cd, heat, mix"]);
    let chosen = "--set output.grids=['surface','mix']";
    place.hfvdb(&format!("{bake} --overwrite {chosen}")).ok();
    let contents = vdb::read(place.path("m.0002.vdb")).expect("a file of ours");
    assert_eq!(contents.grids.iter().map(|grid| grid.name.as_str()).collect::<Vec<_>>(), ["surface", "mix"]);
    place.hfvdb(&format!("{bake} --overwrite {chosen} --half heat")).fails(2, &["there are surface, mix"]);
}

#[test]
fn a_scalar_that_is_no_number_is_an_error_that_shows_its_formula() {
    let place = Workplace::new();
    place.write("bad.toml", "[shape.a]\nsphere = 1\nattribute.wear = '1/(x - x)'\n");
    let run = place.hfvdb("bake bad.toml --resolution 16 -o bad.vdb");
    run.fails(1, &["`wear` at (", "bad.toml:3:19", "finite"]);
    assert!(!place.path("bad.vdb").exists());
}

/// A ball whose colour and wear follow its radius from a point, in all of it.
const CORED: &str = "[shape.a]
sphere = 1
color = { linear = ['0.2 + 0.1*x', '0.5', '0.3 + 0.2*z'] }
attribute.wear = 'x*y'
attribute.plain = 2
[output]
inside = true
grids = ['surface', 'density', 'Cd', 'wear', 'plain']
";

/// The value of a grid at a voxel: of its block, else of the active tile there.
fn value_at<T: Copy>(blocks: &vdb::SparseBlocks<T>, voxel: glam::IVec3) -> Option<T> {
    use hfvdb::grid::{block_origin, node_origin, voxel_offset};
    if let Ok(at) = hfvdb::grid::place_of(&blocks.origins, block_origin(voxel)) {
        let offset = voxel_offset(voxel);
        return is_active(&blocks.active[at], offset).then(|| blocks.values[at][offset]);
    }
    let is_around = |tile: &&vdb::Tile<T>| tile.active && node_origin(voxel, tile.edge) == tile.origin;
    blocks.tiles.iter().find(is_around).map(|tile| tile.value)
}

#[test]
fn the_inside_has_colours_attributes_and_density() {
    let place = Workplace::new();
    place.write("cored.toml", CORED);
    place.hfvdb("bake cored.toml --voxel-size 0.04 -o cored.vdb").ok();
    let file = place.path("cored.vdb");
    let contents = vdb::read(&file).expect("a file of ours");
    let Voxels::Floats(density) = &grid(&contents, "density").voxels else { panic!("density is of numbers") };
    assert_eq!(grid(&contents, "density").class, vdb::StoredClass::FogVolume);
    let Voxels::Floats(wear) = &grid(&contents, "wear").voxels else { panic!("wear is of numbers") };
    let Voxels::Floats(plain) = &grid(&contents, "plain").voxels else { panic!("plain is of numbers") };
    let Voxels::Vectors(colour) = &grid(&contents, "Cd").voxels else { panic!("Cd is of colours") };
    let mut inside = 0;
    for number in 0..60_i32.pow(3) {
        let voxel = glam::IVec3::new(number / 3600, number / 60 % 60, number % 60) - 30;
        let position = voxel.as_dvec3() * 0.04;
        let depth = 1.0 - position.length();
        let ramp = (depth / 0.12).clamp(0.0, 1.0);
        let found = value_at(density, voxel);
        assert!((f64::from(found.unwrap_or(0.0)) - ramp).abs() < 1e-4, "density {found:?} {ramp} at {position}");
        if depth < 0.0 {
            assert_eq!(found, None, "{position}");
            continue;
        }
        inside += u64::from(depth > 1e-6);
        let found = value_at(colour, voxel).expect("a colour wherever it is inside");
        // Near the surface it is that of the closest point, at the band's inner end the voxel's own.
        let reach = if depth >= 0.1201 { 1e-6 } else { 0.1 * depth.min(0.08) + 1e-4 };
        let own = [0.2 + 0.1 * position.x, 0.5, 0.3 + 0.2 * position.z];
        for (found, own) in found.into_iter().zip(own) {
            assert!((f64::from(found) - own).abs() <= 2.0 * reach, "{found} {own} at {position}");
        }
        assert_eq!(value_at(plain, voxel), Some(2.0), "{position}");
        if depth >= 0.1201 {
            let found = value_at(wear, voxel).expect("wear wherever it is inside");
            assert!((f64::from(found) - position.x * position.y).abs() < 1e-6, "{found} at {position}");
        }
    }
    assert!(inside > 60_000, "{inside}");
    // What is constant inside takes no blocks there.
    assert!(plain.tiles.iter().any(|tile| tile.active) && plain.origins.len() < wear.origins.len());

    let manifest = std::fs::read_to_string(place.path("cored.manifest.json")).expect("a manifest");
    let records = &json(&manifest)["frames"][0]["grids"];
    assert_eq!((&records[1]["name"], &records[1]["greatest"][0]), (&"density".into(), &1.0.into()));
    // Of voxels that are on the surface itself rounding decides.
    let told = records[1]["active_voxels"].as_u64().expect("a number");
    assert!(told.abs_diff(inside) <= 60, "{told} {inside}");
}

#[test]
fn an_attribute_stands_for_the_density() {
    let place = Workplace::new();
    place.write("fog.toml", "[shape.a]\nsphere = 1\nattribute.density = '2 + x'\n");
    place.hfvdb("bake fog.toml --voxel-size 0.05 -o fog.vdb").ok();
    let contents = vdb::read(place.path("fog.vdb")).expect("a file of ours");
    assert_eq!(contents.grids.iter().map(|grid| grid.name.as_str()).collect::<Vec<_>>(), ["surface", "density"]);
    let Voxels::Floats(density) = &grid(&contents, "density").voxels else { panic!("density is of numbers") };
    for (x, expected) in [(-8, 1.6), (0, 2.0), (12, 2.6)] {
        assert_eq!(
            value_at(density, glam::IVec3::new(x, 0, 0)).map(|value| (value * 1e4).round() / 1e4),
            Some(expected)
        );
    }
    place.write("thin.toml", "[shape.a]\nsphere = 1\nattribute.density = 'x'\n");
    let run = place.hfvdb("bake thin.toml --voxel-size 0.05 -o thin.vdb");
    run.fails(1, &["`density` at (-", "cannot be negative", "thin.toml:3:"]);
    // A thousand units of fog in voxels of a thousandth.
    place.write("vast.toml", "[shape.a]\nbox = 20\nattribute.density = '20 + x'\n");
    let run = place.hfvdb("bake vast.toml --voxel-size 0.01 --max-memory 4G -o vast.vdb");
    run.fails(3, &["of memory", "4.0 GiB"]);
}

/// The distances of a file's level set, on its active voxels, beside the exact ones.
fn farthest_off(file: &Path, exact: impl Fn(DVec3) -> f64) -> f64 {
    let contents = vdb::read(file).expect("a file of ours");
    let band = grid(&contents, "surface").to_band().expect("a level set");
    let mut farthest: f64 = 0.0;
    for ((origin, values), mask) in band.origins.iter().zip(&band.distances).zip(&band.active) {
        let centres = Points::of_block(*origin, &band.lattice);
        for at in (0..values.len()).filter(|&at| is_active(mask, at)) {
            farthest = farthest.max((f64::from(values[at]) - exact(centres.position(at))).abs());
        }
    }
    farthest
}

#[test]
fn files_of_voxels_are_shapes() {
    let place = Workplace::new();
    place.write("ball.toml", "hfvdb = 1\n[shape.a]\nsphere = 0.8\nmove = [0.1, 0.2, 0.3]\ncolor = 'red'\n[output]\ngrids = ['surface', 'density', 'Cd']\n");
    place.hfvdb("bake ball.toml --voxel-size 0.04 -o ball.vdb").ok();
    let middle = DVec3::new(0.1, 0.2, 0.3);
    let scene = |keys: &str| {
        place.write("again.toml", format!("hfvdb = 1\n[shape.a]\nvdb = 'ball.vdb'\n{keys}\n"));
        place.hfvdb("bake again.toml --voxel-size 0.03 --overwrite -o again.vdb")
    };
    scene("").ok();
    // Between voxels a ball's distance is off by h²/8 times its curvature, 1/r along two axes: 0.0005.
    let off = farthest_off(&place.path("again.vdb"), |p| 0.8 - p.distance(middle));
    assert!(off < 0.001, "{off}");
    let contents = vdb::read(place.path("again.vdb")).expect("a file of ours");
    let Voxels::Vectors(colour) = &grid(&contents, "Cd").voxels else { panic!("Cd is of colours") };
    assert!(colour.background[0] == 1.0 && colour.background[1] == 0.0, "{:?}", colour.background);
    // The fog rises from 0 to 1 over three voxels of the file.
    let run = scene("grid = 'density'\nthreshold = 0.25").ok();
    assert!(!run.stderr.contains("note"), "{}", run.stderr);
    let off = farthest_off(&place.path("again.vdb"), |p| 0.8 - 0.25 * 0.12 - p.distance(middle));
    assert!(off < 0.002, "{off}");
    assert!(scene("grid = 'density'").ok().stderr.contains("fog 'density' is solid from 0.5 on"));
    // It is a shape like any other.
    scene("offset = 0.1\nmove = [1, 0, 0]").ok();
    let off = farthest_off(&place.path("again.vdb"), |p| 0.9 - p.distance(middle + DVec3::X));
    assert!(off < 0.003, "{off}");
    scene("grid = 'dens'").fails(1, &["no grid 'dens'", "did you mean `density`?", "again.toml:4:"]);
    scene("grid = 'Cd'").fails(1, &["no single number a voxel", "density (float)"]);
    scene("threshold = 0.1").fails(1, &["is a level set, whose surface is at 0"]);
    scene("grid = 'density'\nthreshold = 2").fails(1, &["has nothing inside", "`threshold`"]);
    std::fs::write(place.path("ball.vdb"), b" BDVgarbage").expect("it can be written");
    scene("").fails(1, &["ball.vdb"]);
}

/// Turned, and with voxels that are no cubes, as other programs write them.
#[test]
fn a_shape_of_voxels_stands_where_its_transform_puts_it() {
    let place = Workplace::new();
    let script = "import pyopenvdb as vdb\n\
                  g = vdb.createLevelSetSphere(radius=1, voxelSize=0.05, halfWidth=3)\n\
                  g.transform.scale((2, 1, 1))\n\
                  g.transform.rotate(0.5)\n\
                  g.name = 'surface'\n\
                  vdb.write('long.vdb', grids=[g])\n";
    place.run(Command::new("/usr/bin/python3").args(["-c", script])).ok();
    place.write("long.toml", "hfvdb = 1\n[shape.a]\nvdb = 'long.vdb'\n");
    let run = place.hfvdb("bake long.toml --voxel-size 0.05 -o out.vdb --json").ok();
    let volume = json(&run.stdout)["frames"][0]["volume"].as_f64().expect("a number");
    let exact = 8.0 / 3.0 * std::f64::consts::PI;
    assert!((volume / exact - 1.0).abs() < 0.01, "{volume} {exact}");
}

/// Colours in other primaries are those of Rec.709 by a matrix, say so, and come back as they were.
#[test]
fn colours_in_other_primaries_say_so_and_come_back() {
    let colours = |file: &Path| {
        let contents = vdb::read(file).expect("a file of ours");
        let cd = grid(&contents, "Cd");
        let tag = cd.metadata.get("colorInteropID").cloned();
        let Voxels::Vectors(blocks) = &cd.voxels else { panic!("colours are vectors") };
        let tiles = blocks.tiles.iter().map(|tile| tile.value);
        let all: Vec<[f32; 3]> = blocks.values.iter().flatten().copied().chain(tiles).collect();
        (tag, all)
    };
    // ACES, S-2014-004: each row adds up to 1, so that white stays white.
    let to_ap1 = |[r, g, b]: [f32; 3]| {
        [
            0.613_097_4 * r + 0.339_523_15 * g + 0.047_379_45 * b,
            0.070_193_72 * r + 0.916_353_9 * g + 0.013_452_4 * b,
            0.020_615_59 * r + 0.109_569_77 * g + 0.869_814_63 * b,
        ]
    };
    let near = |a: &[[f32; 3]], b: &[[f32; 3]]| {
        a.len() == b.len() && a.iter().flatten().zip(b.iter().flatten()).all(|(a, b)| (a - b).abs() < 2e-6)
    };
    for inside in [false, true] {
        let place = Workplace::new();
        let scene = |space: &str| {
            format!(
                "hfvdb = 1\n[shape.a]\nsphere = 1\ncolor = ['0.5 + 0.4*x', 0.2, 'abs(z)']\n[output]\ninside = {inside}\n{space}"
            )
        };
        place.write("plain.toml", scene(""));
        place.write("ap1.toml", scene("color_space = 'lin_ap1_scene'"));
        place.write("tagged.toml", scene("color_space = 'lin_rec709_scene'"));
        for name in ["plain", "ap1", "tagged"] {
            place.hfvdb(&format!("bake {name}.toml --resolution 24 -o {name}.vdb")).ok();
        }
        let [plain, ap1, tagged] = ["plain", "ap1", "tagged"].map(|name| colours(&place.path(&format!("{name}.vdb"))));
        assert_eq!(plain.0, None);
        assert_eq!(ap1.0, Some("lin_ap1_scene".into()));
        assert_eq!(tagged.0, Some("lin_rec709_scene".into()));
        assert_eq!(plain.1, tagged.1);
        let wanted: Vec<[f32; 3]> = plain.1.iter().map(|colour| to_ap1(*colour)).collect();
        assert!(near(&ap1.1, &wanted), "inside = {inside}");
        // A shape from the file has the colours that were asked for, not those that are in it.
        if !inside {
            for name in ["plain", "ap1"] {
                place.write("again.toml", format!("hfvdb = 1\n[shape.a]\nvdb = '{name}.vdb'\n"));
                place.hfvdb(&format!("bake again.toml --voxel-size 0.1 -o again-{name}.vdb")).ok();
            }
            let [one, other] = ["plain", "ap1"].map(|name| colours(&place.path(&format!("again-{name}.vdb"))).1);
            assert!(near(&one, &other));
        }
    }
}

#[test]
fn colours_of_an_unknown_space_are_refused_and_polygons_keep_theirs() {
    let place = Workplace::new();
    place.write(
        "ap1.toml",
        "hfvdb = 1\n[shape.a]\nsphere = 1\ncolor = 'red'\n[output]\ncolor_space = 'lin_ap1_scene'\n",
    );
    place.hfvdb("bake ap1.toml --resolution 24 -o a.ply").fails(2, &["polygons have colours of Rec.709", "write .vdb"]);
    place.write("no.toml", "hfvdb = 1\n[shape.a]\nsphere = 1\n[output]\ncolor_space = 'acescg'\n");
    place.hfvdb("check no.toml").fails(1, &["`lin_ap1_scene`"]);
}

/// A density is the ramp times its attribute, also where that is the same everywhere.
#[test]
fn a_constant_density_has_the_ramp() {
    let place = Workplace::new();
    let total = |attribute: &str| {
        place.write(
            "fog.toml",
            format!("hfvdb = 1\n[shape.a]\nbox = 1.2\n{attribute}\n[output]\ngrids = ['surface', 'density']\n"),
        );
        place.hfvdb("bake fog.toml -o fog.vdb --resolution 40 --overwrite").ok();
        let contents = vdb::read(place.path("fog.vdb")).expect("a file of ours");
        let Voxels::Floats(fog) = &grid(&contents, "density").voxels else { panic!("it is of numbers") };
        let in_blocks = fog.values.iter().zip(&fog.active).flat_map(|(values, mask)| {
            values.iter().enumerate().filter(|(at, _)| is_active(mask, *at)).map(|(_, value)| f64::from(*value))
        });
        let in_tiles = fog.tiles.iter().filter(|tile| tile.active);
        in_blocks.sum::<f64>() + in_tiles.map(|tile| f64::from(tile.value) * f64::from(tile.edge).powi(3)).sum::<f64>()
    };
    let [plain, one, half] = ["", "attribute.density = 1", "attribute.density = 0.5"].map(total);
    assert!(plain > 1000.0 && (one - plain).abs() < 1e-6 * plain, "{plain} {one}");
    assert!((half - plain / 2.0).abs() < 1e-6 * plain, "{plain} {half}");
}
