//! A disk that fills up, for which this test mounts a small one. Without the right to mount it says so and is skipped.

mod support;

use std::fs;
use std::path::PathBuf;
use std::process::Command;

use support::{BALL, Workplace};

const BAKE: &str = "bake ball.toml --resolution 24 -o disk/m.####.vdb --resume";

/// A mounted disk; dropped, it is gone.
struct Disk(PathBuf);

impl Disk {
    fn mount(at: PathBuf, options: &str) -> Option<Self> {
        fs::create_dir_all(&at).unwrap();
        let mount = Command::new("mount").args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(&at).output().ok()?;
        mount.status.success().then_some(Self(at))
    }

    fn again(&self, options: &str) {
        let options = format!("remount,{options}");
        assert!(Command::new("mount").args(["-o", &options]).arg(&self.0).status().unwrap().success());
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(&self.0).status();
    }
}

#[test]
fn a_full_disk_at_ten_levels() {
    let place = Workplace::new();
    place.write("ball.toml", BALL.replace("24", "8"));
    for level in 0..10 {
        let kib = 4 + level * 130;
        let Some(disk) = Disk::mount(place.path("disk"), &format!("size={kib}k")) else {
            eprintln!("skipped: this needs the right to mount a small disk (root)");
            return;
        };
        let told = place.hfvdb(&format!("{BAKE} --dry-run")).ok();
        assert!(
            told.stderr.contains("all frames need about") && told.stderr.contains("free in disk"),
            "{}",
            told.stderr
        );
        let run = place.hfvdb(BAKE);
        run.fails(1, &["disk/", "No space left on device", "make room"]);
        for name in place.frames("disk") {
            hfvdb::vdb::walk::walk(place.path("disk").join(&name)).expect("a whole file");
        }
        place.nothing_is_left("disk");
        let before = place.frames("disk").len();
        assert!(before < 8, "{kib} KiB are no full disk");
        disk.again("size=64m");
        let told = place.hfvdb(&format!("{BAKE} --dry-run")).ok();
        assert!(!told.stderr.contains("all frames need about"), "{}", told.stderr);
        let run = place.hfvdb(BAKE).ok();
        let kept = run.stderr.split("resume: ").nth(1).unwrap().split(' ').next().unwrap().parse::<usize>().unwrap();
        // At most the last frame stands without its record.
        assert!(kept + 1 >= before && kept <= before, "{before} frames stood, {kept} were kept");
        place.hfvdb("verify disk").ok();
        place.nothing_is_left("disk");
    }
}

#[test]
fn a_disk_that_is_read_only() {
    let place = Workplace::new();
    place.write("ball.toml", BALL.replace("24", "8"));
    let Some(disk) = Disk::mount(place.path("disk"), "size=64m") else {
        eprintln!("skipped: this needs the right to mount a small disk (root)");
        return;
    };
    place.hfvdb(BAKE).ok();
    disk.again("ro");
    place.hfvdb(BAKE).fails(1, &["disk", "cannot write into this folder", "-o"]);
    place.hfvdb("verify disk").ok();
}
