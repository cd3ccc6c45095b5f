//! A scene by its path or name, with overrides, as a checked model.

use std::path::Path;
use std::sync::Arc;

use super::read::{self, Surroundings};
use crate::node::example::{node_names, node_scene};
use crate::node::imports;
use crate::node::keys::SCENE;
use crate::node::model::Model;
use crate::node::origin::{Source, text_of, tree_of};
use crate::terminal;
use crate::text::builtin::{builtin_names, builtin_text};
use crate::text::diagnostic::{Diagnostic, Diagnostics, clip};
use crate::text::files::{Base, Variables};
use crate::text::overrides::{self, Overrides};
use crate::text::source::Sources;

/// Reads and checks a scene. Touches no file but the scene itself (files it names must exist, and are not read).
pub fn load(source: &Source, overrides: &Overrides) -> Result<Model, Diagnostics> {
    let variables: Variables = Arc::new(|name| std::env::var(name).ok());
    load_with(source, overrides, variables)
}

/// As [`load`], with the variables of paths given.
pub(crate) fn load_with(source: &Source, overrides: &Overrides, variables: Variables) -> Result<Model, Diagnostics> {
    let (name, text, base) = fetch(source).map_err(alone)?;
    let mut sources = Sources::default();
    let first = sources.add(name.as_str(), text.as_str());
    let mut root = match tree_of(&name, &text, first) {
        Ok(root) => root,
        Err(problem) => return Err(Diagnostics::new(vec![problem], Arc::new(sources))),
    };
    let mut problems = Vec::new();
    let namespaces = imports::merge(&mut root, source, &base, &variables, &mut sources, &mut problems);
    overrides::apply(&mut root, SCENE, overrides, &mut sources, &mut problems);
    read::read(&name, &root, Arc::new(sources), &Surroundings { base, variables, namespaces }, problems)
}

fn alone(problem: Diagnostic) -> Diagnostics {
    Diagnostics::new(vec![problem], Arc::default())
}

/// The name, the text, and where its paths begin.
fn fetch(source: &Source) -> Result<(String, String, Base), Diagnostic> {
    match source {
        Source::Builtin(name) => match builtin_text(name).map(str::to_owned).or_else(|| node_scene(name)) {
            Some(text) => Ok((format!("{name}.toml"), text, Base::BuiltIn)),
            None => {
                let problem = format!("there is no built-in scene `{}`", clip(name));
                Err(Diagnostic::without_place(problem).suggest(name, builtin_names().chain(node_names())))
            }
        },
        Source::Text { name, text, folder } => Ok((name.clone(), text.clone(), Base::Folder(folder.clone()))),
        Source::Path(path) => {
            let folder = path.parent().map(Path::to_owned).unwrap_or_default();
            Ok((terminal::path(path), text_of(path)?, Base::Folder(folder)))
        }
    }
}
