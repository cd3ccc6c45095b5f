//! Records, manifests, and `hfvdb verify`, which holds frames against them.

mod support;

use std::fs;
use std::process::Command;

use serde_json::Value;
use support::{BAKE, json, manifest, workplace};

#[test]
fn records_tell_what_the_files_hold() {
    let place = workplace();
    place.hfvdb(&format!("{BAKE} --frames 5-7 --half Cd")).ok();
    let manifest = manifest(&place);
    assert_eq!(manifest["pattern"], "m.####.vdb");
    assert_eq!(manifest["asked"], "5-7");
    assert_eq!(manifest["identity"]["resolution"], 16);
    assert_eq!(manifest["identity"]["half"][0], "Cd");
    assert_eq!(manifest["source"]["scene"], "ball.toml");
    let frames = manifest["frames"].as_array().expect("a list");
    assert_eq!(frames.len(), 3);
    for frame in frames {
        let file = frame["file"].as_str().expect("a name");
        let path = format!("out/{file}");
        let sum = place.run(Command::new("sha256sum").arg(&path)).ok();
        assert_eq!(sum.stdout.split(' ').next(), frame["sha256"].as_str());
        assert_eq!(fs::metadata(place.path(&path)).unwrap().len(), frame["bytes"].as_u64().unwrap());
        let info = json(&place.hfvdb(&format!("info {path} --json")).ok().stdout);
        assert_eq!(info["files"][0]["metadata"]["hfvdb_scene"], manifest["identity"]["scene"]);
        for (grid, read) in frame["grids"].as_array().unwrap().iter().zip(info["files"][0]["grids"].as_array().unwrap())
        {
            assert_eq!((&grid["name"], &grid["active_voxels"]), (&read["name"], &read["active_voxels"]));
            // 16 bits keep 11 of a value's digits.
            let close = |a: &Value, b: &Value| (a.as_f64().unwrap() - b.as_f64().unwrap()).abs() <= 1.0 / 2048.0;
            for end in ["least", "greatest"] {
                let (told, read) = (grid[end].as_array().unwrap(), read["range"][end].as_array().unwrap());
                assert_eq!(told.len(), read.len());
                assert!(
                    told.iter().zip(read).all(|(a, b)| close(a, b)),
                    "{end} of {}: {told:?}, {read:?}",
                    grid["name"]
                );
            }
        }
        let stem = file.strip_suffix(".vdb").unwrap();
        let record = json(&fs::read_to_string(place.path(&format!("out/.{stem}.hfvdb-record.json"))).unwrap());
        assert_eq!((&record["record"], &record["identity"]), (frame, &manifest["identity"]));
    }
    place.nothing_is_left("out");
}

#[test]
fn verify_finds_any_flipped_bit_and_missing_and_foreign_frames() {
    let place = workplace();
    place.hfvdb(&format!("{BAKE} --frames 1-3")).ok();
    place.write("out/notes.txt", "not ours");
    place.write("out/other.0001.vdb", "not ours");
    place.write("out/other.manifest.json", "{\"name\": \"of another program\"}");
    for what in ["out", "out/m.%04d.vdb", "out/m.manifest.json"] {
        let run = place.hfvdb(&format!("verify {what}")).ok();
        assert!(
            run.stdout.starts_with("out/m.####.vdb: 3 frames, ") && run.stdout.ends_with(", whole\n"),
            "{}",
            run.stdout
        );
    }
    // Bits of all files that count, at random from a fixed seed.
    let mut state: u64 = 20250917;
    for name in ["m.0001.vdb", "m.0002.vdb", "m.manifest.json", ".m.0003.hfvdb-record.json"].repeat(6) {
        let path = place.path("out").join(name);
        let whole = fs::read(&path).unwrap();
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        let bit = (state >> 20) as usize % (whole.len() * 8);
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        fs::write(&path, &bytes).unwrap();
        place.hfvdb("verify out").fails(1, &[name]);
        fs::write(&path, &whole).unwrap();
    }
    place.hfvdb("verify out").ok();

    fs::rename(place.path("out/m.0002.vdb"), place.path("out/m.0009.vdb")).unwrap();
    let run = place.hfvdb("verify out --json");
    run.fails(1, &["m.0002.vdb: missing", "m.0009.vdb: foreign"]);
    assert_eq!(json(&run.stdout)["sequences"][0]["findings"].as_array().map(Vec::len), Some(2));
    fs::rename(place.path("out/m.0009.vdb"), place.path("out/m.0002.vdb")).unwrap();

    // A delivery without the hidden records, and a folder whose manifest was lost.
    fs::create_dir(place.path("copy")).unwrap();
    for name in ["m.0001.vdb", "m.0002.vdb", "m.0003.vdb", "m.manifest.json"] {
        fs::copy(place.path("out").join(name), place.path("copy").join(name)).unwrap();
    }
    place.hfvdb("verify copy").ok();
    let before = manifest(&place)["frames"].clone();
    fs::remove_file(place.path("out/m.manifest.json")).unwrap();
    place.hfvdb("verify out").ok();
    assert_eq!(manifest(&place)["frames"], before);

    place.hfvdb("verify nowhere").fails(1, &["nowhere: there is no such folder"]);
    place.hfvdb("verify out/m.0001.vdb").fails(1, &["m.0001.vdb", "nothing is known", "give the folder"]);
    assert!(!place.path("out/m.0001.manifest.json").exists());
    fs::create_dir(place.path("bare")).unwrap();
    place.hfvdb("verify bare").fails(1, &["bare: nothing to verify"]);
    place.hfvdb("verify bare/x.####.vdb").fails(1, &["x.####.vdb", "no manifest and no record"]);
    place.hfvdb("verify bare/x.manifest.json").fails(1, &["x.manifest.json: there is no such manifest"]);
}

#[test]
fn damaged_records_and_manifests_are_named() {
    let place = workplace();
    place.hfvdb(&format!("{BAKE} --frames 1-3")).ok();
    let manifest = fs::read_to_string(place.path("out/m.manifest.json")).unwrap();
    for bad in ["", "{", &manifest[..200], &manifest.replace("\"asked\": \"1-3\"", "\"asked\": \"1-2\"")] {
        place.write("out/m.manifest.json", bad);
        for command in [format!("{BAKE} --frames 4"), format!("{BAKE} --frames 1-4 --resume")] {
            place.hfvdb(&command).fails(1, &["m.manifest.json", "damaged", "delete it"]);
        }
    }
    place.hfvdb("verify out").fails(1, &["m.manifest.json", "damaged", "delete it"]);
    fs::remove_file(place.path("out/m.manifest.json")).unwrap();
    place.write("out/.m.0002.hfvdb-record.json", "{}");
    place.hfvdb("verify out").fails(1, &[".m.0002.hfvdb-record.json", "damaged", "--resume"]);
    let run = place.hfvdb(&format!("{BAKE} --frames 1-4 --resume")).ok();
    assert!(run.stderr.contains(".m.0002.hfvdb-record.json") && run.stderr.contains("2 of 4 frames"), "{}", run.stderr);
    place.hfvdb("verify out").ok();
}

/// Some frames finer than all others: those are the ones that verify names and that the first bake, resumed, bakes again.
#[test]
fn the_fewer_frames_are_of_another_bake_to_verify_and_to_resume() {
    let place = workplace();
    place.hfvdb(&format!("{BAKE} --frames 1-24")).ok();
    let finer = BAKE.replace("16", "20");
    place.hfvdb(&format!("{finer} --frames 12-20 --overwrite")).ok();
    let run = place.hfvdb("verify out");
    run.fails(
        1,
        &["frames 12-20 (", "of another bake than most", "resolution 20 there, resolution 16 here", "9 files"],
    );
    assert!(run.stdout.contains("24 frames, 9 problems"), "{}", run.stdout);
    let dry = place.hfvdb(&format!("{BAKE} --resume --dry-run")).ok();
    assert!(dry.stdout.contains("9 frames to bake, 15 to keep"), "{}", dry.stdout);
    place.hfvdb(&format!("{BAKE} --resume")).ok();
    place.hfvdb("verify out").ok();
    // As many of one as of another: the last bake's are those that are meant.
    place.hfvdb(&format!("{finer} --frames 13-24 --overwrite")).ok();
    place.hfvdb("verify out").fails(1, &["frames 1-12 (", "resolution 16 there, resolution 20 here"]);
}

/// What --resume cannot mend, it is not advised for.
#[test]
fn a_foreign_file_that_no_bake_asks_for_is_to_be_taken_away() {
    let place = workplace();
    place.hfvdb(&format!("{BAKE} --frames 1-3")).ok();
    fs::copy(place.path("out/m.0001.vdb"), place.path("out/m.0009.vdb")).unwrap();
    let run = place.hfvdb("verify out");
    run.fails(1, &["m.0009.vdb: foreign", "take it away"]);
    assert!(!run.stderr.contains("--resume"), "{}", run.stderr);
    place.hfvdb(&format!("{BAKE} --frames 1-3 --resume")).ok();
    place.hfvdb("verify out").fails(1, &["m.0009.vdb: foreign"]);
    fs::remove_file(place.path("out/m.0009.vdb")).unwrap();
    place.hfvdb("verify out").ok();

    // One that a bake was asked for is baked again.
    fs::remove_file(place.path("out/.m.0002.hfvdb-record.json")).unwrap();
    fs::remove_file(place.path("out/m.manifest.json")).unwrap();
    place.hfvdb(&format!("{BAKE} --frames 5 --resume")).ok();
    place.hfvdb("verify out").fails(1, &["m.0002.vdb: foreign", "take it away"]);
    place.hfvdb(&format!("{BAKE} --frames 1-5 --resume")).ok();
    place.hfvdb("verify out").ok();
}

/// The commands of the page that a new user reads first, in their order, on a scene that takes no time.
#[test]
fn the_readmes_commands_run_in_order() {
    let place = workplace();
    let page = include_str!("../README.md");
    let section =
        |title: &str| page.split_once(title).and_then(|(_, rest)| rest.split("\n##").next()).expect("a section");
    let mut count = 0;
    for line in [section("### Bake\n"), section("### Bake on a farm\n")].iter().flat_map(|section| section.lines()) {
        let Some(command) = line.strip_prefix("$ hfvdb ") else { continue };
        let command = command.split(" # ").next().unwrap_or(command).replace('\'', "");
        let words: Vec<&str> =
            command.split_whitespace().map(|word| if word == "cubism" { "ball.toml" } else { word }).collect();
        let command = words.join(" ").replace("--resolution 512", "--resolution 40");
        let makes_frames = command.starts_with("bake") || command.starts_with("preview");
        let small = if makes_frames && !command.contains("--resolution") { " --resolution 24" } else { "" };
        place.hfvdb(&format!("{command}{small}")).ok();
        count += 1;
    }
    assert!(count >= 10, "{count} commands");
    place.hfvdb("verify out farm").ok();
}
