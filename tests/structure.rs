//! The rooms of `src/` and the arrows between them, as `src/lib.rs` draws them: a room uses those below it only.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Each room with those that it may use.
const ARROWS: &[(&str, &[&str])] = &[
    (
        "cli",
        &["bake", "render", "shot", "node", "text", "attribute", "distance", "mesh", "field", "grid", "vdb", "disk"],
    ),
    ("bake", &["shot", "node", "text", "morph", "attribute", "distance", "field", "grid", "vdb", "disk"]),
    ("render", &["attribute", "field", "grid"]),
    ("shot", &["node", "text", "morph", "attribute", "distance", "field", "grid", "vdb", "disk"]),
    ("node", &["text", "morph", "attribute", "distance", "mesh", "field", "grid", "vdb", "disk"]),
    ("text", &["attribute", "field", "disk"]),
    ("morph", &["attribute", "distance", "field", "grid"]),
    ("attribute", &["distance", "mesh", "field", "grid"]),
    ("mesh", &["distance", "field", "disk"]),
    ("distance", &["field", "grid"]),
    ("field", &["grid"]),
    ("vdb", &["grid", "disk"]),
    ("grid", &[]),
    ("disk", &[]),
];

/// All files of a room but its tests, by their paths in `src/`.
fn files(room: &str) -> Vec<(String, String)> {
    fn visit(folder: &Path, out: &mut Vec<PathBuf>) {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() { visit(&path, out) } else { out.push(path) }
        }
    }
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut paths = Vec::new();
    visit(&source.join(room), &mut paths);
    let name = |path: &Path| path.strip_prefix(&source).unwrap().to_str().unwrap().to_owned();
    let is_code = |name: &String| name.ends_with(".rs") && !name.contains("test");
    let mut all: Vec<(String, String)> = paths
        .iter()
        .map(|path| (name(path), path))
        .filter(|(name, _)| is_code(name))
        .map(|(name, path)| {
            let text = std::fs::read_to_string(path).unwrap();
            // Tests stand at the end of their file and may use what they like; what documentation links to is no use.
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
            (name, lines.collect::<Vec<_>>().join("\n"))
        })
        .collect();
    all.sort();
    all
}

/// The paths after each `crate::` of a text: a room and what follows it.
fn uses(text: &str) -> impl Iterator<Item = Vec<&str>> {
    text.split("crate::").skip(1).map(|rest| {
        let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':')).unwrap_or(rest.len());
        rest[..end].split("::").filter(|part| !part.is_empty()).collect()
    })
}

#[test]
fn a_room_uses_those_below_it() {
    let rooms: BTreeSet<&str> = ARROWS.iter().map(|(room, _)| *room).collect();
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in std::fs::read_dir(source).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().into_string().unwrap();
        assert!(!entry.path().is_dir() || rooms.contains(name.as_str()), "the room `{name}` has no arrows here");
    }
    for (room, below) in ARROWS {
        for (name, text) in files(room) {
            for path in uses(&text).filter(|path| !path.is_empty() && rooms.contains(path[0]) && path[0] != *room) {
                assert!(below.contains(&path[0]), "{name} uses {}", path.join("::"));
            }
        }
    }
}

#[test]
fn files_do_not_use_one_another_in_a_circle() {
    for (room, _) in ARROWS {
        let files = files(room);
        // A folder of a room is one place: its `mod.rs` and its files.
        let place = |name: &str| name.split('/').nth(1).unwrap().trim_end_matches(".rs").to_owned();
        let mut links: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (name, text) in files.iter().filter(|(name, _)| !name.ends_with("/mod.rs")) {
            let by_room = uses(text).filter(|path| path.first() == Some(room)).filter_map(|path| path.get(1).copied());
            // Of a file that stands in the room itself, and of one in a folder of it.
            let above = "super::".repeat(name.split('/').count() - 1);
            let by_place = text.match_indices(&above).filter_map(|(at, _)| {
                let before = text[..at].chars().next_back();
                let rest = &text[at + above.len()..];
                let end = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
                (before.is_none_or(|before| !before.is_alphanumeric() && before != ':')).then_some(&rest[..end])
            });
            let used = by_room.chain(by_place);
            let known = used.filter(|used| files.iter().any(|(name, _)| place(name) == *used)).map(str::to_owned);
            links.entry(place(name)).or_default().extend(known.filter(|used| *used != place(name)));
        }
        // Places that use nothing that is left are taken away, until none is left or all are in circles or lead to one.
        while let Some(free) = links.iter().find(|(_, used)| used.iter().all(|used| !links.contains_key(used))) {
            let free = free.0.clone();
            links.remove(&free);
        }
        assert!(links.is_empty(), "circles in `{room}`: {links:?}");
    }
}
