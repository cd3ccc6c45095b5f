//! Morphs on their way to being ready: what they tell of it, and what stops them before.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use super::*;
use crate::node::*;
use crate::shot::frame_tests::options;
use crate::text::*;

/// Whether its objects are measured one after the other or at once.
#[test]
fn a_morph_tells_how_far_it_is_made_ready() {
    let text =
        "frames = '1-9'\nmorph = { from = 'a', to = 'b' }\n[shape.a]\nsphere = 1\n[shape.b]\nbox = [1, 1.4, 1]\n";
    let source = Source::Text { name: "scene.toml".into(), text: text.into(), folder: PathBuf::new() };
    let model = Arc::new(load(&source, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}")));
    let told = |threads: usize| {
        let told = Mutex::new(Vec::new());
        let progress = |share, _: &str| told.lock().unwrap().push(share);
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of a few threads");
        pool.install(|| model.prepare(&options(Some(128), &progress))).unwrap_or_else(|error| panic!("{error}"));
        told.into_inner().unwrap()
    };
    let count = |told: &[f64], part: Range<f64>| told.iter().filter(|share| part.contains(share)).count();
    let (one, two) = (told(1), told(2));
    // One thread measures an object after the other: each tells of itself, before it is done.
    for object in [0.0..0.45, 0.45..0.9] {
        assert!(count(&one, object) > 10, "{one:?}");
    }
    assert!(one.is_sorted(), "{one:?}");
    // What two threads tell at once may be out of order.
    assert_eq!(two.len(), one.len());
    assert!(count(&two, 0.0..0.9) > 20, "{two:?}");
    let back = two.windows(2).map(|two| two[0] - two[1]).fold(0.0, f64::max);
    assert!(back < 0.05, "{two:?}");
    for told in [one, two] {
        assert_eq!(told.last(), Some(&1.0));
        assert!(told.iter().all(|share| (0.0..=1.0).contains(share)), "{told:?}");
    }
}

/// Nothing is measured for it: nothing is told of progress.
#[test]
fn a_morph_without_room_for_its_colours_is_refused_before_it_is_measured() {
    let scene = |colour: &str| {
        format!(
            "frames = \"1-9\"\nmorph = {{ from = \"a\", to = \"b\" }}\n\
             [shape.parts]\nunion = [{{ sphere = 1{colour} }}]\n[shape.a]\nfacet = \"parts\"\ncells = \"c\"\n\
             [shape.b]\nbox = 2\n[cells.c]\noctree = \"parts\"\n"
        )
    };
    let prepare = |colour: &str, limit: u64| {
        let source = Source::Text { name: "scene.toml".into(), text: scene(colour), folder: ".".into() };
        let model = load(&source, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}"));
        let began = AtomicBool::new(false);
        let progress = |_: f64, _: &str| began.store(true, Ordering::Relaxed);
        let limited = PrepareOptions { memory_limit: Some(limit as usize), ..options(Some(64), &progress) };
        let result = Arc::new(model).prepare(&limited).map(|_| ());
        (result, began.into_inner())
    };
    let needed = |result: Result<(), Error>| match result {
        Err(Error::Memory { needed, .. }) => needed,
        other => panic!("{other:?}"),
    };
    let (plain, began) = prepare("", 1);
    let plain = needed(plain);
    assert!(!began);
    let (coloured, began) = prepare(", color = \"red\"", plain + 1);
    assert!(!began && needed(coloured) > 2 * plain);
    let (with_room, _) = prepare("", plain + 1);
    assert!(!matches!(with_room, Err(Error::Memory { .. })), "{with_room:?}");
}

/// A rough look tells of a morph's box and its voxels what making it ready finds; where nothing is measured, all of it.
#[test]
fn an_outlook_is_about_what_becomes() {
    for (name, is_rough) in [("cube-to-heart", true), ("heart", false)] {
        let model = Arc::new(load(&Source::Builtin(name.into()), &Overrides::default()).unwrap());
        let options = options(Some(64), &|_, _| ());
        let exact = model.prepare(&options).unwrap_or_else(|error| panic!("{error}"));
        let outlook = model.outlook(&options).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!((outlook.is_rough(), exact.is_rough()), (is_rough, false));
        let apart = (outlook.extent.size() / exact.extent.size() - 1.0).abs().max_element();
        assert!(apart <= if is_rough { 0.05 } else { 0.0 }, "{name}: {apart}");
        for frame in [1, 12, 24] {
            let of = |prepared: &Prepared| {
                let content = prepared.frame(frame).unwrap_or_else(|error| panic!("{error}"));
                crate::bake::estimate(prepared, &content, 1).voxels
            };
            let ratio = of(&outlook) / of(&exact);
            // Rather too much than too little.
            let right = if is_rough { 0.8..1.3 } else { 1.0..1.0 + f64::EPSILON };
            assert!(right.contains(&ratio), "{name}, frame {frame}: {ratio}");
        }
        model.examine(&options).unwrap_or_else(|error| panic!("{error}"));
    }
}
