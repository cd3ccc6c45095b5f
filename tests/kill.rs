//! Killed at any moment: files with final names are whole, finished frames are never baked again, and the next run
//! takes away what was left.
//!
//! `HFVDB_KILLS` sets how many times (see `scripts/kill-test.sh`), `HFVDB_KILL_SEED` other moments.

mod support;

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use sha2::{Digest, Sha256};
use support::{BALL, Workplace};

const FRAMES: usize = 24;
const BAKE: &str = "bake ball.toml --resolution 24 -o out/m.####.vdb --resume";

fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).ok().map_or(default, |text| text.parse().unwrap_or_else(|_| panic!("{name}: no number")))
}

/// A small generator with a seed (Knuth's constants), so that a failure can be had again.
struct Random(u64);

impl Random {
    fn share(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The frames that are finished, file and record: for each its inode. Fails where a file is not whole.
fn finished(place: &Workplace) -> BTreeMap<String, u64> {
    let mut finished = BTreeMap::new();
    if !place.path("out").exists() {
        return finished;
    }
    for name in place.frames("out") {
        let path = place.path("out").join(&name);
        hfvdb::vdb::walk::walk(&path).unwrap_or_else(|error| panic!("a broken file under a final name: {error}"));
        let record = place.path(&format!("out/.{}.hfvdb-record.json", name.strip_suffix(".vdb").unwrap()));
        let Ok(record) = fs::read_to_string(record) else { continue };
        let record: serde_json::Value = serde_json::from_str(&record).expect("a whole record");
        let sum: String = Sha256::digest(fs::read(&path).unwrap()).iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(record["record"]["sha256"], sum.as_str(), "{name} is not the file of its record");
        finished.insert(name, fs::metadata(&path).unwrap().ino());
    }
    finished
}

/// Starts a bake in the workplace.
fn start(place: &Workplace) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hfvdb"));
    command.args(BAKE.split(' ')).current_dir(place.root()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("the program starts")
}

fn nothing_was_baked_again(before: &BTreeMap<String, u64>, after: &BTreeMap<String, u64>) {
    for (name, inode) in before {
        assert_eq!(after.get(name), Some(inode), "{name} was finished and was baked again");
    }
}

/// One signal is an orderly end where the work allows it, the second an end by force: neither leaves anything.
#[test]
fn signals_leave_no_locks_and_no_temporaries() {
    let mut random = Random(7);
    let place = Workplace::new();
    place.write("ball.toml", BALL.replace("1-24", "1-400").replace("24 = 1", "400 = 1"));
    for round in 0..30 {
        let mut child = start(&place);
        // The program listens for signals before it makes the folder.
        while !place.path("out").exists() {
            assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
            std::thread::sleep(Duration::from_millis(1));
        }
        std::thread::sleep(Duration::from_secs_f64(0.3 * random.share()));
        let sent = Instant::now();
        let (signal, code) = [("INT", 130), ("TERM", 143)][round % 2];
        for _ in 0..=round / 2 % 2 {
            Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap();
        }
        assert_eq!(child.wait().unwrap().code(), Some(code));
        assert!(sent.elapsed() < Duration::from_secs(2), "{:?}", sent.elapsed());
        // Before the first frame is finished the folder goes, too.
        if place.path("out").exists() {
            place.nothing_is_left("out");
            finished(&place);
            fs::remove_dir_all(place.path("out")).unwrap();
        }
    }
}

#[test]
fn killed_at_any_moment() {
    let (kills, seed) = (number("HFVDB_KILLS", 60), number("HFVDB_KILL_SEED", 1));
    let mut random = Random(seed);
    let place = Workplace::new();
    place.write("ball.toml", BALL);
    let begin = Instant::now();
    place.hfvdb(BAKE).ok();
    let whole = begin.elapsed();
    fs::remove_dir_all(place.path("out")).unwrap();

    let (mut killed, mut sequences, mut left) = (0, 0, 0);
    while killed < kills {
        let before = finished(&place);
        // Sometimes two at once, which share the frames and the folder.
        let count = if random.share() < 0.3 { 2 } else { 1 };
        let mut children: Vec<_> = (0..count).map(|_| start(&place)).collect();
        // A quarter of a whole run at most: so that several kills fall into each sequence.
        std::thread::sleep(Duration::from_secs_f64(whole.as_secs_f64() * 0.25 * random.share()));
        for child in &mut children {
            child.kill().unwrap();
            killed += u64::from(!child.wait().unwrap().success());
        }
        let after = finished(&place);
        nothing_was_baked_again(&before, &after);
        if place.path("out").exists() {
            left += place.names("out").iter().filter(|name| name.ends_with("tmp") || name.ends_with("lock")).count();
        }
        if after.len() == FRAMES || random.share() < 0.1 {
            place.hfvdb(BAKE).ok();
            place.nothing_is_left("out");
            nothing_was_baked_again(&after, &finished(&place));
            assert_eq!(finished(&place).len(), FRAMES);
            place.hfvdb("verify out").ok();
            fs::remove_dir_all(place.path("out")).unwrap();
            sequences += 1;
        }
    }
    println!(
        "seed {seed}: {killed} kills in {:.0} s, {sequences} sequences finished and verified after them, \
         {left} locks and temporaries left by the killed and taken away by the next",
        begin.elapsed().as_secs_f64()
    );
}
