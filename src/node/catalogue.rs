//! All nodes in words: what `hfvdb nodes` prints, and `docs/nodes.md`.

use std::fmt::Write;

use super::list::{COLOURS, MAKERS, MODES, MODIFIERS, PLACERS, ROOMS, SCALARS};
use super::morph_mode::ModeSpec;
use super::source::Source;
use super::spec::Spec;
use crate::text::key::{Absent, Key, Limit};

/// A node in words.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Entry {
    /// Its key.
    pub name: &'static str,
    /// Other names that mean the same.
    pub also: &'static [&'static str],
    /// Its kin.
    pub group: &'static str,
    /// What it is.
    pub text: &'static str,
    /// What its key takes.
    pub takes: String,
    /// What holds where the key has no value of its own; empty where it must have one.
    pub default: String,
    /// Its function, where one line says it: F of a shape, c of a colour, a of a number.
    pub formula: String,
    /// Where that comes from.
    pub source: &'static str,
    /// TOML that shows it.
    pub example: &'static str,
    /// The keys beside it.
    pub parameters: Vec<Parameter>,
    /// Its picture, from the repository's root.
    pub picture: Option<String>,
}

/// A key beside a node's own.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Parameter {
    /// Its name.
    pub name: &'static str,
    /// Other names that mean the same.
    pub also: &'static [&'static str],
    /// What it takes: kind, range and unit.
    pub takes: String,
    /// What holds where it is left out.
    pub default: String,
    /// What it does.
    pub text: &'static str,
}

/// All nodes, in the order of the tables.
pub fn catalogue() -> Vec<Entry> {
    let mut all = Vec::new();
    for (table, group, names) in ROOMS {
        for name in *names {
            let is_it = |key: &Key| key.name == *name;
            let of_shape = |specs: &'static [Spec]| {
                specs.iter().find(|spec| is_it(&spec.key)).map(|spec| of_spec(group, spec, *table != "PLACERS"))
            };
            all.extend(match *table {
                "MAKERS" => of_shape(MAKERS),
                "MODIFIERS" => of_shape(MODIFIERS),
                "PLACERS" => of_shape(PLACERS),
                "COLOURS" => COLOURS.iter().find(|row| is_it(&row.key)).map(|row| of_source(group, row, "c")),
                "MODES" => MODES.iter().find(|row| is_it(&row.key)).map(|row| of_mode(group, row)),
                _ => SCALARS.iter().find(|row| is_it(&row.key)).map(|row| of_source(group, row, "a")),
            });
        }
    }
    all
}

fn of_spec(group: &'static str, spec: &'static Spec, has_picture: bool) -> Entry {
    Entry {
        formula: formula("F", spec.formula),
        source: spec.source,
        example: spec.example,
        parameters: spec.parameters.iter().map(parameter).collect(),
        picture: has_picture.then(|| format!("docs/images/nodes/{}.png", spec.key.name)),
        ..of_key(group, &spec.key)
    }
}

fn of_source<const N: usize>(group: &'static str, source: &'static Source<N>, symbol: &str) -> Entry {
    Entry {
        formula: formula(symbol, source.formula),
        example: source.example,
        parameters: source.parameters.iter().map(parameter).collect(),
        ..of_key(group, &source.key)
    }
}

fn of_mode(group: &'static str, mode: &'static ModeSpec) -> Entry {
    Entry {
        takes: String::new(),
        formula: formula("F", mode.formula),
        source: mode.source,
        example: mode.example,
        parameters: mode.parameters.iter().map(parameter).collect(),
        ..of_key(group, &mode.key)
    }
}

fn of_key(group: &'static str, key: &Key) -> Entry {
    Entry {
        name: key.name,
        also: key.also,
        group,
        text: key.text,
        takes: takes(key),
        default: match key.default {
            Absent::Required | Absent::Nothing => String::new(),
            _ => left_out(key),
        },
        formula: String::new(),
        source: "",
        example: "",
        parameters: Vec::new(),
        picture: None,
    }
}

fn formula(symbol: &str, formula: &str) -> String {
    if formula.is_empty() { String::new() } else { format!("{symbol} = {formula}") }
}

fn parameter(key: &Key) -> Parameter {
    Parameter { name: key.name, also: key.also, takes: takes(key), default: left_out(key), text: key.text }
}

/// Kind, range and unit.
pub(super) fn takes(key: &Key) -> String {
    let mut words = vec![key.kind.words()];
    if !matches!(key.limit, Limit::Any) {
        words.push(key.limit.words());
    }
    if !key.unit.is_empty() {
        words.push(key.unit.into());
    }
    words.join(", ")
}

pub(super) fn left_out(key: &Key) -> String {
    match key.default {
        Absent::Required => "must be there".into(),
        Absent::Nothing => "–".into(),
        Absent::Number(value) => format!("{value}"),
        Absent::Vector([x, y, z]) => format!("[{x}, {y}, {z}]"),
        Absent::Text(text) => format!("`{text}`"),
        Absent::Of(other, share) => format!("{share} · `{other}`"),
        Absent::Words(words) => words.into(),
    }
}

/// A table of keys.
pub(super) fn table(out: &mut String, keys: impl Iterator<Item = Parameter>) {
    out.push_str("| key | takes | when left out | what it does |\n|---|---|---|---|\n");
    for Parameter { name, also, takes, default, text } in keys {
        let also = also.iter().map(|name| format!(", `{name}`")).collect::<String>();
        let _ = writeln!(out, "| `{name}`{also} | {takes} | {default} | {text} |");
    }
}

/// The same of keys.
pub(super) fn table_of<'k>(out: &mut String, keys: impl Iterator<Item = &'k Key>) {
    table(out, keys.map(parameter));
}

const BEGINNING: &str = "\
# Nodes

Everything that a scene can name: what a shape can be, what can be done to one, where its colour and its numbers come from.
This page is made from the tables that scenes are checked by; [scene.md](scene.md) is the scene format around them, and
[adding-a-node.md](adding-a-node.md) adds to it. `hfvdb nodes` searches it (`hfvdb nodes lattice`, `hfvdb nodes gyroid`).
F is positive inside.

![all nodes](images/nodes.png)

Each that has a picture is a scene by its name: `hfvdb preview torus_knot -o knot.png`, `hfvdb scenes torus_knot > knot.toml`.
Pictures show the example.

";

/// What stands before the first group of a table.
fn chapter(table: &str) -> &'static str {
    match table {
        "MAKERS" => "## What a shape is\n\nA shape has exactly one of these keys.\n",
        "MODIFIERS" => "## What can be done to a shape\n\nIn this order, whatever the order of the text.\n",
        "PLACERS" => {
            "## Where a shape stands\n\nLast of all, in this order; in a list of `do` anywhere, each as often as it is wanted.\n"
        }
        "COLOURS" => {
            "## Where a colour comes from\n\nKeys of `color = { … }`, of which a colour as a table has exactly one; see [colours](scene.md#colours-as-tables).\n"
        }
        "MODES" => {
            "## How a morph's shape changes\n\nThe values of `mode` of [`[morph]`](scene.md#morph), each with the keys that it alone has.\n"
        }
        _ => {
            "## Where a number comes from\n\nKeys of `attribute.NAME = { … }`, of which a number as a table has exactly one; see [attributes](scene.md#attribute-numbers-that-go-with-the-surface).\n"
        }
    }
}

/// The text of `docs/nodes.md`.
pub fn nodes_page() -> String {
    let mut out = String::from(BEGINNING);
    for (_, group, names) in ROOMS {
        let names: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        let _ = writeln!(out, "- [{group}](#{}): {}", anchor(group), names.join(" "));
    }
    let all = catalogue();
    let mut entries = all.iter();
    let mut last = "";
    for (table, group, names) in ROOMS {
        if *table != last {
            let _ = write!(out, "\n{}", chapter(table));
            last = table;
        }
        let _ = write!(out, "\n### {group}\n");
        for entry in entries.by_ref().take(names.len()) {
            out.push('\n');
            section(&mut out, entry);
        }
    }
    out
}

/// Where a heading is linked to.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase().replace(' ', "-");
    kept.chars().filter(|letter| letter.is_alphanumeric() || *letter == '-').collect()
}

fn section(out: &mut String, entry: &Entry) {
    let left_out = if entry.default.is_empty() { String::new() } else { format!(" When left out: {}.", entry.default) };
    let also: Vec<String> = entry.also.iter().map(|name| format!("`{name}`")).collect();
    let also = if also.is_empty() { String::new() } else { format!(" Also called {}.", also.join(", ")) };
    let takes = if entry.takes.is_empty() { String::new() } else { format!(" Takes: {}.", entry.takes) };
    let _ = write!(out, "#### `{}`\n\n{}{takes}{left_out}{also}\n", entry.name, entry.text);
    match (entry.formula.as_str(), entry.source) {
        ("", "") => {}
        (formula, "") => _ = write!(out, "\n{formula}\n"),
        ("", source) => _ = write!(out, "\nAfter {source}.\n"),
        (formula, source) => _ = write!(out, "\n{formula} ({source})\n"),
    }
    match &entry.picture {
        Some(picture) => {
            let picture = picture.trim_start_matches("docs/");
            let _ = write!(out, "\n```toml\n{}\n```\n\n![{}]({picture})\n", entry.example, entry.name);
        }
        None if entry.example.is_empty() => {}
        None if entry.example.contains('\n') => _ = write!(out, "\n```toml\n{}\n```\n", entry.example),
        None => _ = write!(out, "\n`{}`\n", entry.example),
    }
    if !entry.parameters.is_empty() {
        out.push('\n');
        table(out, entry.parameters.iter().cloned());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `UPDATE_DOCS=1 cargo test` writes the page anew.
    #[test]
    fn the_page_of_nodes_is_what_the_tables_say() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/nodes.md");
        if std::env::var_os("UPDATE_DOCS").is_some() {
            std::fs::write(path, nodes_page()).unwrap();
        }
        let page = std::fs::read_to_string(path).unwrap_or_default();
        assert!(page == nodes_page(), "docs/nodes.md is out of date: UPDATE_DOCS=1 cargo test the_page");
    }

    /// Every row of every table is in it once.
    #[test]
    fn nothing_is_left_out() {
        let all = catalogue();
        let shapes = MAKERS.len() + MODIFIERS.len() + PLACERS.len();
        assert_eq!(all.len(), shapes + COLOURS.len() + SCALARS.len() + MODES.len());
        let mut groups: Vec<&str> = ROOMS.iter().map(|(_, group, _)| anchor(group).leak() as &str).collect();
        groups.sort_unstable();
        groups.dedup();
        assert_eq!(groups.len(), ROOMS.len(), "two groups have one name");
    }
}
