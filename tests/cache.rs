//! Measured objects are kept between runs, and what is kept never changes a voxel.

mod support;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use support::{Run, Workplace};

/// Two objects that take long enough to be kept.
const SCENE: &str = "hfvdb = 1\nframes = \"1-3\"\nmorph = { from = \"small\", to = \"heart\" }\n\
                     [shape.small]\nheart = 1.5\ncolor = \"red\"\n[shape.heart]\nheart = 2\n\
                     move = [\"0.1*t\", 0, 0]\n";
const BAKE: &str = "bake morph.toml --voxel-size 0.04 --frames 2 --overwrite";

fn place() -> Workplace {
    let place = Workplace::new();
    place.write("morph.toml", SCENE);
    place
}

/// Bakes a frame, and gives its bytes without the identifier that OpenVDB makes at random.
fn bake(place: &Workplace, more: &str) -> (Run, Vec<u8>) {
    let run = place.hfvdb(&format!("{BAKE} -o m.vdb {more}")).ok();
    let mut bytes = fs::read(place.path("m.vdb")).expect("a frame");
    bytes.drain(21..57);
    (run, bytes)
}

/// The entries of a kind, and what has no business there.
fn entries_of(place: &Workplace, extension: &str) -> Vec<PathBuf> {
    let all = place.names("kept").into_iter().map(|name| place.path("kept").join(name));
    all.filter(|path| path.extension().is_none_or(|own| own == extension)).collect()
}

fn entries(place: &Workplace) -> Vec<PathBuf> {
    entries_of(place, "distance")
}

fn plans(place: &Workplace) -> usize {
    entries_of(place, "plan").len()
}

#[test]
fn what_is_kept_gives_the_same_bits() {
    let place = place();
    let (_, measured) = bake(&place, "--no-cache");
    let (_, first) = bake(&place, "--cache kept");
    let kept = entries(&place);
    assert_eq!(kept.len(), 2, "both objects, and no lock: {kept:?}");
    let (run, second) = bake(&place, "--cache kept");
    assert!(!run.stderr.contains("warning"), "{}", run.stderr);
    assert!(measured == first && first == second);
    assert_eq!((plans(&place), place.names("kept").len()), (1, 3), "the plan, and no lock");
    // A colour changes no plan; and the way round between hues, which it does change, is found again.
    let opposite = SCENE.replace("[shape.heart]", "[shape.heart]\ncolor = \"#00ffff\"");
    place.write("morph.toml", &opposite);
    let ((_, measured), (_, kept_plan)) = (bake(&place, "--no-cache"), bake(&place, "--cache kept"));
    assert!(measured == kept_plan && plans(&place) == 1);
    // What does not change an object does not change its name: neither its colour, nor its motion, nor the morph.
    let other =
        SCENE.replace("red", "blue").replace("0.1*t", "0.2*t").replace("morph = {", "morph = { ease = \"smooth\",");
    place.write("morph.toml", other);
    bake(&place, "--cache kept");
    assert_eq!((entries(&place), plans(&place)), (kept.clone(), 2));
    // What does, does.
    place.write("morph.toml", SCENE.replace("1.5", "1.51"));
    bake(&place, "--cache kept");
    assert_eq!(entries(&place).len(), 3);
    // Room for one of them only.
    let largest = kept.iter().map(|path| fs::metadata(path).unwrap().len()).max().unwrap();
    place.write("morph.toml", SCENE.replace("1.5", "1.52"));
    bake(&place, &format!("--cache kept --cache-size {largest}"));
    assert!(entries(&place).len() <= 2, "{:?}", entries(&place));
}

/// Cut short, a bit flipped, another program's: each is made again, said, and mended.
#[test]
fn damaged_entries_are_made_again() {
    let place = place();
    let (_, measured) = bake(&place, "--cache kept");
    let damaged = |entry: &Path, bytes: &[u8]| {
        let whole = fs::read(entry).unwrap();
        fs::write(entry, bytes).unwrap();
        let (run, again) = bake(&place, "--cache kept");
        assert!(again == measured);
        assert!(run.stderr.contains("is damaged"), "{}", run.stderr);
        assert!(fs::read(entry).unwrap() == whole, "not mended: {}", run.stderr);
    };
    let flipped = |entry: &Path| {
        let mut bytes = fs::read(entry).unwrap();
        let middle = bytes.len() / 2;
        bytes[middle] ^= 1;
        bytes
    };
    let [object, plan] = ["distance", "plan"].map(|kind| entries_of(&place, kind).remove(0));
    let whole = fs::read(&object).unwrap();
    for bytes in [flipped(&object), whole[..whole.len() / 3].to_vec(), Vec::new(), b"something else".to_vec()] {
        damaged(&object, &bytes);
    }
    damaged(&plan, &flipped(&plan));
}

/// A folder that cannot be made or written into, or that holds folders in place of entries.
#[test]
fn no_folder_is_no_reason_to_fail() {
    let place = place();
    let (_, measured) = bake(&place, "--no-cache");
    place.write("file", "not a folder");
    let (run, baked) = bake(&place, "--cache file/kept");
    assert!(baked == measured && run.stderr.contains("nothing is kept"), "{}", run.stderr);
    bake(&place, "--cache kept");
    for entry in entries(&place) {
        fs::remove_file(&entry).unwrap();
        fs::create_dir(&entry).unwrap();
    }
    let (run, baked) = bake(&place, "--cache kept");
    assert!(baked == measured && run.stderr.contains("measured again"), "{}", run.stderr);
}

#[test]
fn many_at_once_with_a_cold_cache_make_the_same() {
    let place = place();
    let (_, measured) = bake(&place, "--no-cache");
    let start = |number: usize| {
        let output = format!("{number}.vdb");
        let mut command = Command::new(env!("CARGO_BIN_EXE_hfvdb"));
        command.args(BAKE.split(' ')).args(["-o", &output, "--cache", "kept"]).current_dir(place.root());
        command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts")
    };
    let all: Vec<_> = (0..10).map(start).collect();
    for (number, child) in all.into_iter().enumerate() {
        let run = Run::from(child.wait_with_output().unwrap()).ok();
        assert!(!run.stderr.contains("warning"), "{}", run.stderr);
        let mut bytes = fs::read(place.path(&format!("{number}.vdb"))).unwrap();
        bytes.drain(21..57);
        assert!(bytes == measured, "task {number}");
    }
    assert_eq!(entries(&place).len(), 2, "{:?}", entries(&place));
}

/// A distance that a shape needs while it is made is kept too.
#[test]
fn what_is_measured_within_a_shape_is_kept() {
    let place = Workplace::new();
    let scene = "hfvdb = 1\n[shape.grown]\nheart = 1\ncolor = \"red\"\noffset = 0.2\n";
    place.write("grown.toml", scene);
    let bake = |more: &str| {
        let run = place.hfvdb(&format!("bake grown.toml --voxel-size 0.05 --overwrite -o m.vdb {more}")).ok();
        assert!(!run.stderr.contains("warning"), "{}", run.stderr);
        let mut bytes = fs::read(place.path("m.vdb")).expect("a frame");
        bytes.drain(21..57);
        bytes
    };
    let (measured, first) = (bake("--no-cache"), bake("--cache kept"));
    let kept = entries(&place);
    assert_eq!(kept.len(), 1);
    let time = || fs::metadata(&kept[0]).unwrap().modified().unwrap();
    let before = time();
    assert!(measured == first && first == bake("--cache kept"));
    assert!(time() > before, "not read");
    place.write("grown.toml", scene.replace("red", "blue"));
    bake("--cache kept");
    assert_eq!(entries(&place), kept);
    place.write("grown.toml", scene.replace("0.2", "0.21"));
    bake("--cache kept");
    assert_eq!(entries(&place).len(), 2);
}
