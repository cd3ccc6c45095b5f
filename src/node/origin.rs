//! Where a scene's text comes from.

use std::path::{Path, PathBuf};

use crate::disk;
use crate::mesh::is_mesh;
use crate::node::example::{node_names, node_scene};
use crate::terminal;
use crate::text::builtin::{builtin_names, builtin_text};
use crate::text::diagnostic::{Diagnostic, clip, nearest};
use crate::text::value::{Origin, Table, parse_json, parse_toml};

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Source {
    /// A file: TOML, or JSON where its name ends in `.json`.
    Path(PathBuf),
    /// A scene inside the program, or a node as a scene of its own.
    Builtin(String),
    /// A text that is no file.
    Text {
        /// What messages call it; JSON where it ends in `.json`.
        name: String,
        /// All of it.
        text: String,
        /// Where relative paths in it begin.
        folder: PathBuf,
    },
}

impl Source {
    /// What an argument of the command line means: a built-in scene's name, or a node's, where no such file exists. (A folder is none.)
    pub fn of_argument(argument: &str) -> Self {
        let path = Path::new(argument);
        let is_known = builtin_text(argument).is_some() || node_scene(argument).is_some();
        let is_name = is_known && (path.is_dir() || !path.exists());
        if is_name { Self::Builtin(argument.into()) } else { Self::Path(argument.into()) }
    }
}

/// A scene's text, or that of a file that it imports, as a tree: JSON where its name ends in `.json`.
pub(crate) fn tree_of(name: &str, text: &str, source: usize) -> Result<Table, Diagnostic> {
    if name.to_ascii_lowercase().ends_with(".json") {
        return parse_json(text, source);
    }
    parse_toml(text, source, Origin::Scene)
}

/// The text of a scene's file.
pub(crate) fn text_of(path: &Path) -> Result<String, Diagnostic> {
    /// No scene that a person or a script writes is as large; a VDB given by mistake is.
    const MOST_BYTES: u64 = 16 << 20;
    let shown = terminal::path(path);
    let failed = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => not_found(&shown),
        std::io::ErrorKind::FileTooLarge => Diagnostic::without_place(format!(
            "`{}` is too large to be a scene, which has {} MiB at most",
            clip(&shown),
            MOST_BYTES >> 20
        )),
        _ => Diagnostic::without_place(format!("the scene `{}` cannot be read: {error}", clip(&shown))),
    };
    let bytes = disk::read_at_most(path, MOST_BYTES).map_err(failed)?;
    let text = String::from_utf8(bytes)
        .map_err(|_| Diagnostic::without_place(format!("`{}` is no scene, which is a text in UTF-8", clip(&shown))))
        .map_err(|problem| {
            match path.extension().and_then(|end| end.to_str()).map(str::to_ascii_lowercase).as_deref() {
                _ if is_mesh(path) => {
                    problem.help("`hfvdb check` tells of meshes, and `hfvdb convert` makes voxels of one")
                }
                Some("vdb") => problem.help("`hfvdb info` tells what a .vdb file holds"),
                Some("exr" | "png" | "apng" | "jpg" | "jpeg") => problem.help("it is a picture by its name"),
                _ => problem,
            }
        })?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

fn not_found(shown: &str) -> Diagnostic {
    let problem = Diagnostic::without_place(format!("there is no scene `{}`", clip(shown)));
    match nearest(shown, builtin_names().chain(node_names())) {
        Some(name) => problem.help(format!("did you mean the built-in scene `{name}`?")),
        None => problem.help("`hfvdb scenes` lists the built-in scenes"),
    }
}
