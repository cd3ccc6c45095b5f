//! Nothing half-written, nothing left behind, and one holder for a lock.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use super::register::Register;
use super::*;

fn names(folder: &Path) -> Vec<String> {
    fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn an_interrupted_write_leaves_nothing_behind() {
    // Of its own: the process's register holds the files of the tests that run beside this one.
    static REGISTER: Register = Register::new();
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("ball.vdb");
    let live = Temporary::registered(&REGISTER, &target).unwrap();
    let names_then = names(folder.path());
    assert_eq!(names_then.iter().filter_map(|name| temporary_target(name)).collect::<Vec<_>>(), ["ball.vdb"]);
    drop(REGISTER.remove_all());
    assert!(names(folder.path()).is_empty());
    let error = live.persist(&target, false).expect_err("the file is gone");
    assert!(error.to_string().starts_with(&format!("{}: cannot ", target.display())), "{error}");
    assert!(names(folder.path()).is_empty());
}

#[test]
fn whole_files_replace_whole_files() {
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("a.json");
    for text in ["one", "two"] {
        write_whole(&target, text.as_bytes()).unwrap();
        assert_eq!(fs::read_to_string(&target).unwrap(), text);
    }
    assert_eq!(names(folder.path()), ["a.json"]);
}

#[test]
fn what_replaces_a_file_has_its_permissions() {
    use std::os::unix::fs::PermissionsExt;
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("mine.toml");
    write_new(&target, b"one").unwrap();
    fs::set_permissions(&target, fs::Permissions::from_mode(0o600)).unwrap();
    write_whole(&target, b"two").unwrap();
    assert_eq!(fs::metadata(&target).unwrap().permissions().mode() & 0o777, 0o600);
}

#[test]
fn names_of_temporaries() {
    assert_eq!(temporary_target(".m.0001.vdb.a1B2c3.hfvdb-tmp"), Some("m.0001.vdb"));
    assert_eq!(temporary_target("..m.0001.hfvdb-record.json.a1B2c3.hfvdb-tmp"), Some(".m.0001.hfvdb-record.json"));
    for other in ["m.0001.vdb", ".hfvdb-tmp", ".a.hfvdb-tmp", "m.0001.vdb.x.hfvdb-tmp"] {
        assert_eq!(temporary_target(other), None, "{other}");
    }
}

#[test]
fn a_lock_has_one_holder_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.lock");
    let first = FileLock::try_take(&path).unwrap().expect("it is free");
    assert!(first.enforced());
    assert!(FileLock::try_take(&path).unwrap().is_none());
    drop(first);
    assert!(names(folder.path()).is_empty());

    // The file is deleted and made anew all the time, and still there are never two holders.
    let (holders, turns) = (AtomicUsize::new(0), AtomicUsize::new(0));
    thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for _ in 0..500 {
                    if let Some(_lock) = FileLock::try_take(&path).unwrap() {
                        assert_eq!(holders.fetch_add(1, Ordering::SeqCst), 0);
                        turns.fetch_add(1, Ordering::SeqCst);
                        holders.fetch_sub(1, Ordering::SeqCst);
                    }
                }
            });
        }
    });
    assert!(turns.into_inner() > 0);
    assert!(names(folder.path()).is_empty());
}
