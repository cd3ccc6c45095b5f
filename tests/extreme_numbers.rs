//! Scenes with extreme numbers in every numeric place of every built-in scene: no panic, no abort, no hang, and every
//! error names the scene.

mod support;

use std::collections::BTreeSet;
use std::ops::Range;
use std::panic::AssertUnwindSafe;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use hfvdb::node::{Model, Source};
use hfvdb::shot::{Error, PrepareOptions};
use hfvdb::text::{Overrides, builtin_names, builtin_text};
use rayon::prelude::*;
use support::Workplace;

const EXTREMES: [&str; 9] =
    ["1e308", "-1e308", "1e-308", "9223372036854775807", "9223372036854775808", "nan", "inf", "-0.0", "0"];

/// A scene stops here where it hangs.
const PATIENCE: Duration = Duration::from_secs(180);

/// How many places are made ready: all of them takes many minutes.
const PREPARED: usize = 30;

/// The numbers of a text, without its comments: values, keys, frames, and those in formulas.
fn numbers(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let is_word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    let (mut found, mut at, mut in_string) = (Vec::new(), 0, false);
    while at < bytes.len() {
        match bytes[at] {
            b'"' => in_string = !in_string,
            b'#' if !in_string => {
                at += text[at..].find('\n').unwrap_or(text.len() - at);
                continue;
            }
            // A colour such as "#d7263d".
            b'#' => at += text[at..].find('"').unwrap_or(0) - 1,
            byte if is_word(byte) => {
                let end = at + text[at..].find(|c: char| !(is_word(c as u8) || c == '.')).unwrap_or(text.len() - at);
                if byte.is_ascii_digit() {
                    found.push(at..end);
                }
                at = end;
                continue;
            }
            _ => {}
        }
        at += 1;
    }
    found
}

/// The variants of a scene, and none.
fn variants(text: &str) -> BTreeSet<Option<String>> {
    let names = text.split("[variant.").skip(1).filter_map(|rest| rest.split([']', '.']).next());
    names.map(|name| Some(name.to_owned())).chain([None]).collect()
}

fn load(name: &str, text: &str, variant: &Option<String>) -> Result<Model, String> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/scenes"));
    let source = Source::Text { name: format!("{name}.toml"), text: text.into(), folder };
    let overrides = Overrides { set: Vec::new(), variant: variant.clone() };
    hfvdb::node::load(&source, &overrides).map_err(|problems| problems.to_string())
}

/// Makes a model ready, coarsely; the error in words.
fn prepare(model: Model) -> Option<String> {
    let cancel = Arc::new(AtomicBool::new(false));
    let done = Arc::new(AtomicBool::new(false));
    let watch = std::thread::spawn({
        let (cancel, done, start) = (Arc::clone(&cancel), Arc::clone(&done), Instant::now());
        move || {
            while !done.load(Ordering::Relaxed) {
                cancel.store(start.elapsed() > PATIENCE, Ordering::Relaxed);
                std::thread::park_timeout(Duration::from_millis(200));
            }
        }
    });
    let options = PrepareOptions {
        voxel_size: None,
        resolution: Some(12),
        half_width: None,
        memory_limit: Some(1 << 30),
        cache: None,
        cancel,
        progress: &|_, _| {},
    };
    let result = Arc::new(model).prepare(&options);
    done.store(true, Ordering::Relaxed);
    watch.thread().unpark();
    watch.join().expect("the watch");
    match result {
        Ok(_) | Err(Error::Memory { .. }) => None,
        Err(Error::Scene(problems)) => Some(problems.to_string()),
        Err(Error::Cancelled) => panic!("it takes longer than {PATIENCE:?}"),
    }
}

/// A scene with one number replaced.
fn changed(text: &str, place: &Range<usize>, number: &str) -> String {
    format!("{}{number}{}", &text[..place.start], &text[place.end..])
}

#[test]
fn every_number_of_every_built_in_scene() {
    let mut cases = Vec::new();
    for name in builtin_names() {
        let text = builtin_text(name).expect("it is built in");
        let places = numbers(text);
        assert!(places.len() >= 2, "{name} has more numbers than {places:?}");
        // A variant is read for its own numbers, the scene as it is for all others.
        let of_variant = |place: &Range<usize>| {
            let header = text[..place.start].rfind("\n[").map_or("", |header| &text[header + 2..]);
            header.strip_prefix("variant.").and_then(|rest| rest.split([']', '.']).next()).map(str::to_owned)
        };
        let all = variants(text);
        cases.extend(places.into_iter().map(|place| {
            let variant = of_variant(&place);
            assert!(all.contains(&variant), "{name} has no {variant:?}");
            (name, text, variant, place)
        }));
    }
    // All are read; of those that can be, some are made ready, with another number from place to place.
    let step = cases.len().div_ceil(PREPARED);
    cases.par_iter().enumerate().for_each(|(turn, (name, text, variant, place))| {
        let mut sound = Vec::new();
        for number in EXTREMES {
            let scene = changed(text, place, number);
            let what = || format!("{name} ({variant:?}) with {number} at {place:?} for {}", &text[place.clone()]);
            match load(name, &scene, variant) {
                Ok(model) => sound.push((what(), model)),
                Err(problem) => assert!(problem.contains(&format!("{name}.toml")), "{}: {problem}", what()),
            }
        }
        if sound.is_empty() || turn % step != 0 {
            return;
        }
        let (what, model) = sound.swap_remove(turn / step % sound.len());
        let Ok(problem) = std::panic::catch_unwind(AssertUnwindSafe(|| prepare(model))) else {
            panic!("{what}: a panic")
        };
        let problem = problem.unwrap_or_else(|| format!("{name}.toml"));
        assert!(problem.contains(&format!("{name}.toml")), "{what}: {problem}");
    });
}

/// The program itself, on some of them.
#[test]
fn the_program_ends_with_an_error_or_a_file() {
    let place = Workplace::new();
    let mut turn = 0;
    for name in builtin_names() {
        let text = builtin_text(name).expect("it is built in");
        for number in numbers(text).iter().skip(turn % 5).step_by(61) {
            turn += 1;
            let extreme = EXTREMES[turn % EXTREMES.len()];
            place.write("scene.toml", changed(text, number, extreme));
            let run = place.hfvdb("bake scene.toml -o out.####.vdb --frames 2 --resolution 16 --overwrite --threads 1");
            let what = format!("{name} with {extreme} at {number:?}: {}", run.stderr);
            assert!((0..=3).contains(&run.code) && !run.stderr.contains("panicked"), "{what}");
            assert!(run.code == 0 || run.code == 3 || run.stderr.contains("scene.toml"), "{what}");
        }
    }
}
