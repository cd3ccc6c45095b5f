//! Frames baked by the program, read by others: Debian's Python OpenVDB and a reader in pure Rust.

mod support;

use std::fs;
use std::path::Path;
use std::process::Command;

use OpenVDB_rs::prelude::{AnyGrid, Coord, GridClass, Node};
use rayon::prelude::*;
use support::Workplace;

/// The most by which neighbouring voxels may differ, in voxels: as in `check_frames.py`, which says why.
const STEP: f32 = 1.1;

/// A file's bytes without OpenVDB's random identifier.
fn fingerprint(path: &Path) -> Vec<u8> {
    let mut bytes = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    bytes[21..57].fill(0);
    bytes
}

/// Fails unless Debian's Python OpenVDB finds nothing wrong with any file of a folder.
fn python_finds_nothing_wrong(place: &Workplace, folder: &str, frames: usize) {
    let names = place.frames(folder);
    assert_eq!(names.len(), frames);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/check_frames.py");
    let mut command = Command::new("/usr/bin/python3");
    command.arg(script).args(names.iter().map(|name| place.path(folder).join(name)));
    place.run(&mut command).ok();
}

/// Fails unless a reader in pure Rust finds whole level sets in all files of a folder, with colours on the same voxels.
fn rust_finds_nothing_wrong(place: &Workplace, folder: &str, frames: usize) {
    let names = place.frames(folder);
    assert_eq!(names.len(), frames);
    names.par_iter().for_each(|name| {
        let (_, grids) = OpenVDB_rs::io::read_file(place.path(folder).join(name)).expect("a .vdb file");
        let named = |wanted: &str| grids.iter().find(|grid| grid.name() == wanted);
        let (Some(AnyGrid::Float(surface)), Some(AnyGrid::Vec3S(colour)), 2) =
            (named("surface"), named("Cd"), grids.len())
        else {
            panic!("{name}: not the grids surface, of floats, and Cd, of vectors");
        };
        let voxel = surface.uniform_voxel_size().expect("cubic voxels") as f32;
        let background = *surface.background();
        assert_eq!((surface.grid_class(), colour.grid_class()), (GridClass::LevelSet, GridClass::Unknown), "{name}");
        assert!(background >= 1.5 * voxel, "{name}: background {background}");
        assert!(surface.transform().is_approx_equal(colour.transform(), 0.0), "{name}: two transforms");

        assert_eq!((surface.tree().active_tile_count(), colour.tree().active_tile_count()), (0, 0), "{name}");
        let leaves = (surface.tree().leaf_refs(), colour.tree().leaf_refs());
        assert_eq!(leaves.0.len(), leaves.1.len(), "{name}: two topologies");
        assert!(
            leaves.0.iter().zip(&leaves.1).all(|(a, b)| a.origin() == b.origin() && a.has_same_topology(b)),
            "{name}: two topologies"
        );
        assert!(colour.tree().active_voxels().all(|(_, rgb)| rgb.0.iter().all(|c| (0.0..=1.0).contains(c))), "{name}");

        let values = surface.accessor();
        let (mut inside, mut most) = (false, 0.0_f32);
        for leaf in leaves.0 {
            for (at, &value, active) in leaf.iter_all() {
                assert!(value.abs() <= background, "{name}: {value} is beyond the background");
                assert_eq!(active, value.abs() < background, "{name}: active is what is within the band");
                inside |= value < 0.0;
                let Coord([x, y, z]) = leaf.offset_to_global_coord(at);
                for next in [[x + 1, y, z], [x, y + 1, z], [x, y, z + 1], [x - 1, y, z], [x, y - 1, z], [x, y, z - 1]] {
                    most = most.max((values.get_value(&Coord(next)) - value).abs() / voxel);
                }
            }
        }
        assert!(inside, "{name}: nothing inside");
        assert!(most <= STEP, "{name}: neighbours differ by {most} voxels");
        let corner = surface.eval_active_voxel_bbox().min;
        assert_eq!(values.get_value(&Coord(corner.0.map(|along| along - 1))), background, "{name}: outside");
    });
}

/// Fails unless all frames are one piece, and none changes by more than twice what half of them do.
fn nothing_pops(place: &Workplace, folder: &str) {
    let files: Vec<String> = place.frames(folder).iter().map(|name| format!("{folder}/{name}")).collect();
    let sheet = place.hfvdb(&format!("preview {} -o sheet.png --pictures 1 --json", files.join(" "))).ok();
    let sheet: serde_json::Value = serde_json::from_str(&sheet.stdout).expect("one JSON document");
    let frames = sheet["frames"].as_array().expect("a list of frames");
    assert_eq!(frames.len(), files.len());
    let mut changes: Vec<f64> = frames.iter().filter_map(|frame| frame["change"].as_f64()).collect();
    assert_eq!(changes.len(), frames.len() - 1);
    changes.sort_by(f64::total_cmp);
    let (median, most) = (changes[changes.len() / 2], changes[changes.len() - 1]);
    assert!(most <= 2.0 * median, "one frame changes by {most}, half of them by less than {median}");
    for frame in frames {
        assert_eq!(frame["pieces"], 1, "{frame}");
    }
}

#[test]
fn every_frame_of_cubism_is_a_whole_level_set() {
    let place = Workplace::new();
    place.hfvdb("bake cubism --resolution 96 -o out/m.####.vdb").ok();
    python_finds_nothing_wrong(&place, "out", 48);
    rust_finds_nothing_wrong(&place, "out", 48);
    nothing_pops(&place, "out");
}

#[test]
fn every_frame_of_cube_to_heart_is_a_whole_level_set() {
    let place = Workplace::new();
    place.hfvdb("bake cube-to-heart --resolution 48 -o out/m.####.vdb").ok();
    python_finds_nothing_wrong(&place, "out", 24);
    rust_finds_nothing_wrong(&place, "out", 24);
    nothing_pops(&place, "out");
}

#[test]
fn a_frame_alone_and_any_number_of_threads_give_the_same_bytes() {
    let place = Workplace::new();
    place.hfvdb("bake cubism --resolution 48 --frames 16-18 --threads 2 -o two/m.####.vdb").ok();
    place.hfvdb("bake cubism --resolution 48 --frames 17 --threads 1 --cache kept -o one/m.####.vdb").ok();
    assert_eq!(
        fingerprint(&place.path("two/m.0017.vdb")),
        fingerprint(&place.path("one/m.0017.vdb")),
        "frame 17 depends on the threads or on the frames beside it"
    );
    // Cubism's frame of kept objects, which take long to measure; those of another morph are measured at each width.
    for width in ["sse2", "avx2", "avx512"] {
        for scene in ["cubism --frames 17 --cache kept", "cube-to-heart --frames 9"] {
            let mut command = Command::new(env!("CARGO_BIN_EXE_hfvdb"));
            let output = format!("{width}-{}.vdb", &scene[..6]);
            command.args(format!("bake {scene} --resolution 48 -o {output}").split(' '));
            place.run(command.env("HFVDB_SIMD", width)).ok();
        }
        for (made, wanted) in [("cubism", "one/m.0017.vdb"), ("cube-t", "sse2-cube-t.vdb")] {
            assert_eq!(
                fingerprint(&place.path(wanted)),
                fingerprint(&place.path(&format!("{width}-{made}.vdb"))),
                "a frame depends on the vector width {width}"
            );
        }
    }
}

#[test]
fn all_compressions_hold_the_same_voxels() {
    let place = Workplace::new();
    for kind in ["blosc", "zip", "none"] {
        place.hfvdb(&format!("bake heart --resolution 48 --compression {kind} -o {kind}/m.vdb")).ok();
        python_finds_nothing_wrong(&place, kind, 1);
    }
}
