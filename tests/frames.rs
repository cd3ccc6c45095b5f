//! Frames baked by the program, read by others: Debian's Python OpenVDB and a reader in pure Rust.

mod support;

use std::fs;
use std::path::Path;
use std::process::Command;

use support::Workplace;

/// A file's bytes without OpenVDB's random identifier.
fn fingerprint(path: &Path) -> Vec<u8> {
    let mut bytes = fs::read(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    bytes[21..57].fill(0);
    bytes
}

/// Fails unless Debian's Python OpenVDB finds nothing wrong with any file of a folder.
fn python_finds_nothing_wrong(place: &Workplace, folder: &str, frames: usize, options: &[&str]) {
    let names = place.names(folder);
    assert_eq!(names.len(), frames);
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/check_frames.py");
    let mut command = Command::new("/usr/bin/python3");
    command.arg(script).args(options).args(names.iter().map(|name| place.path(folder).join(name)));
    place.run(&mut command).ok();
}

#[test]
fn every_frame_of_cubism_is_a_whole_level_set() {
    let place = Workplace::new();
    place.hfvdb("bake cubism --resolution 96 -o out/m.####.vdb").ok();
    // Its facets' steps are thinner than a voxel in places.
    python_finds_nothing_wrong(&place, "out", 48, &["--thin"]);
}

#[test]
fn every_frame_of_cube_to_heart_is_a_whole_level_set() {
    let place = Workplace::new();
    place.hfvdb("bake cube-to-heart --resolution 64 -o out/m.####.vdb").ok();
    python_finds_nothing_wrong(&place, "out", 24, &[]);
}

#[test]
fn a_frame_alone_and_any_number_of_threads_give_the_same_bytes() {
    let place = Workplace::new();
    place.hfvdb("bake cubism --resolution 48 --frames 16-18 --threads 2 -o two/m.####.vdb").ok();
    place.hfvdb("bake cubism --resolution 48 --frames 17 --threads 1 -o one/m.####.vdb").ok();
    assert_eq!(
        fingerprint(&place.path("two/m.0017.vdb")),
        fingerprint(&place.path("one/m.0017.vdb")),
        "frame 17 depends on the threads or on the frames beside it"
    );
    for width in ["sse2", "avx2", "avx512"] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hfvdb"));
        command.args("bake cubism --resolution 48 --frames 17 -o".split(' ')).arg(format!("{width}.vdb"));
        place.run(command.env("HFVDB_SIMD", width)).ok();
        assert_eq!(
            fingerprint(&place.path("one/m.0017.vdb")),
            fingerprint(&place.path(&format!("{width}.vdb"))),
            "frame 17 depends on the vector width {width}"
        );
    }
}

#[test]
fn all_compressions_hold_the_same_voxels() {
    let place = Workplace::new();
    for kind in ["blosc", "zip", "none"] {
        place.hfvdb(&format!("bake heart --resolution 48 --compression {kind} -o {kind}/m.vdb")).ok();
        python_finds_nothing_wrong(&place, kind, 1, &[]);
    }
}
