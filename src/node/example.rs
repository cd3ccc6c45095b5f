//! Each node as a scene of its own: what `hfvdb scenes NAME` prints and the pictures of the documentation show.

use super::list::{MAKERS, MODIFIERS};
use super::spec::Spec;

/// What examples are made of where they name `a`, `b` and `c`.
const PARTS: [(&str, &str); 3] = [
    ("\"a\"", "\n[shape.a]\nbox = 1.2\ncolor = \"#1b998b\"\n"),
    ("\"b\"", "\n[shape.b]\nsphere = 0.6\nmove = [0.5, -0.5, 0.5]\ncolor = \"#f4a259\"\n"),
    ("\"c\"", "\n[cells.c]\noctree = { sphere = 1 }\ndepth = [1, 2]\n"),
];

/// The names of all nodes that a shape can be or that can be done to one.
pub fn node_names() -> impl Iterator<Item = &'static str> {
    MAKERS.iter().chain(MODIFIERS).map(|spec| spec.key.name)
}

/// A scene that shows one node.
pub fn node_scene(name: &str) -> Option<String> {
    MAKERS.iter().chain(MODIFIERS).find(|spec| spec.key.name == name).map(scene)
}

pub(super) fn scene(spec: &Spec) -> String {
    let name = spec.key.name;
    let parts: Vec<&str> =
        PARTS.iter().filter(|(part, _)| spec.example.contains(part)).map(|(_, text)| *text).collect();
    // Operators show the colours of their parts.
    let colour = if parts.iter().any(|text| text.starts_with("\n[shape")) { "" } else { "color = \"#d7263d\"\n" };
    format!("hfvdb = 1\n\n[output]\nshape = \"{name}\"\n\n[shape.{name}]\n{}\n{colour}{}", spec.example, parts.concat())
}
