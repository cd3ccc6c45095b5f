//! Morphs on their way to being ready: what they tell of it, and what stops them before.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use super::frame_tests::options;
use super::*;

/// In order but for what two threads tell at once; an object whose cells end early takes a step.
#[test]
fn a_morph_tells_how_far_it_is_made_ready() {
    let text =
        "frames = '1-9'\nmorph = { from = 'a', to = 'b' }\n[shape.a]\nsphere = 1\n[shape.b]\nbox = [1, 1.4, 1]\n";
    let source = Source::Text { name: "scene.toml".into(), text: text.into(), folder: PathBuf::new() };
    let model = load(&source, &Overrides::default()).unwrap_or_else(|problems| panic!("{problems}"));
    let told = Mutex::new(Vec::new());
    let progress = |share| told.lock().unwrap().push(share);
    Arc::new(model).prepare(&options(Some(64), &progress)).unwrap_or_else(|error| panic!("{error}"));
    let told = told.into_inner().unwrap();
    assert_eq!(told.last(), Some(&1.0));
    assert!(told.iter().all(|share| (0.0..=1.0).contains(share)), "{told:?}");
    // Of each object, before it is done.
    for object in [0.0..0.45, 0.45..0.9] {
        assert!(told.iter().filter(|share| object.contains(*share)).count() > 10, "{told:?}");
    }
    let back = told.windows(2).map(|two| two[0] - two[1]).fold(0.0, f64::max);
    assert!(back < 0.05, "{told:?}");
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
        let progress = |_| began.store(true, Ordering::Relaxed);
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
