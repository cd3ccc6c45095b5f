//! `hfvdb scenes`: the built-in scenes, as a list or as text to start from.

use clap::Args;

use super::failure::Failure;
use super::options::Global;
use crate::{node, text};

/// Arguments of `hfvdb scenes`.
#[derive(Args)]
pub struct Arguments {
    /// Print this scene's text, ready to be redirected into a file and changed. The name of a node, such as `cone`, prints a
    /// scene that shows it
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// Runs the command.
pub fn run(arguments: &Arguments, global: &Global) -> Result<(), Failure> {
    let Some(name) = &arguments.name else {
        return list(global);
    };
    let text = text::builtin_text(name).map(str::to_owned).or_else(|| node::node_scene(name)).ok_or_else(|| {
        let known: Vec<_> = text::builtin_names().chain(node::node_names()).collect();
        Failure::work(format!("there is no built-in scene \"{name}\"; there are {}", known.join(", ")))
    })?;
    if global.json {
        return super::print_json(&serde_json::json!({ "name": name, "text": text }));
    }
    super::print(&text)
}

fn list(global: &Global) -> Result<(), Failure> {
    let scenes = text::builtin_names().map(|name| (name, text::builtin_line(name).unwrap_or_default()));
    if global.json {
        let scenes: Vec<_> = scenes.map(|(name, line)| serde_json::json!({ "name": name, "about": line })).collect();
        return super::print_json(&serde_json::json!({ "scenes": scenes }));
    }
    let scenes: String = scenes.map(|(name, line)| format!("{name:16} {line}\n")).collect();
    let nodes: Vec<&str> = node::node_names().collect();
    super::print(&format!("{scenes}\nNodes, each as a scene of its own: {}\n", nodes.join(" ")))
}
