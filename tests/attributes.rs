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
