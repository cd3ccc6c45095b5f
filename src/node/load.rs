//! A scene by its path or name, with overrides, as a checked model.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::read::{self, Surroundings};
use crate::disk;
use crate::node::example::{node_names, node_scene};
use crate::node::imports;
use crate::node::keys::SCENE;
use crate::node::model::Model;
use crate::terminal;
use crate::text::builtin::{builtin_names, builtin_text};
use crate::text::diagnostic::{Diagnostic, Diagnostics, clip, nearest};
use crate::text::files::{Base, Variables};
use crate::text::frames::FrameRange;
use crate::text::overrides::{self, Overrides};
use crate::text::source::Sources;
use crate::text::value::{Origin, parse_json, parse_toml};

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

/// Reads and checks a scene. Touches no file but the scene itself (files it names must exist, and are not read).
pub fn load(source: &Source, overrides: &Overrides) -> Result<Model, Diagnostics> {
    let variables: Variables = Arc::new(|name| std::env::var(name).ok());
    load_with(source, overrides, variables)
}

/// The scene of `hfvdb morph A B`: two meshes, the one becoming the other over a shot, with the colours of their
/// vertices where they have them. Overrides reach it as any scene: `morph.bridge=1`.
pub fn morph_of_meshes(from: &Path, to: &Path, shot: FrameRange, overrides: &Overrides) -> Result<Model, Diagnostics> {
    let text = format!(
        "hfvdb = 1\nframes = \"{}-{}\"\n\n[shape.from]\nmesh = {}\n\n[shape.to]\nmesh = {}\n\n[morph]\nfrom = \"from\"\nto = \"to\"\n",
        shot.first,
        shot.last,
        quoted(from),
        quoted(to),
    );
    load(&Source::Text { name: "hfvdb morph".into(), text, folder: PathBuf::new() }, overrides)
}

/// The scene of a mesh as it stands.
///
/// # Errors
/// Those of [`load`].
pub fn mesh_as_it_is(mesh: &Path, overrides: &Overrides) -> Result<Model, Diagnostics> {
    let text = format!("hfvdb = 1\n\n[shape.mesh]\nmesh = {}\n", quoted(mesh));
    load(&Source::Text { name: "hfvdb convert".into(), text, folder: PathBuf::new() }, overrides)
}

/// A path as text of a scene. A `$` in a name on the command line is the name's own.
fn quoted(path: &Path) -> String {
    let shown = path.display().to_string().replace('$', "$$");
    let escaped = shown.chars().map(|c| match c {
        '"' | '\\' => format!("\\{c}"),
        c if c.is_control() => format!("\\u{:04X}", u32::from(c)),
        c => c.to_string(),
    });
    format!("\"{}\"", escaped.collect::<String>())
}

/// As [`load`], with the variables of paths given.
pub(crate) fn load_with(source: &Source, overrides: &Overrides, variables: Variables) -> Result<Model, Diagnostics> {
    let (name, text, base) = fetch(source).map_err(alone)?;
    let mut sources = Sources::default();
    let is_json = name.to_ascii_lowercase().ends_with(".json");
    sources.add(name.as_str(), text.as_str());
    let tree = if is_json { parse_json(&text, 0) } else { parse_toml(&text, 0, Origin::Scene) };
    let mut root = match tree {
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

/// The text of a scene's file.
pub(crate) fn text_of(path: &Path) -> Result<String, Diagnostic> {
    /// No scene that a person or a script writes is as large; a VDB given by mistake is.
    const MOST_BYTES: u64 = 16 << 20;
    let shown = terminal::path(path);
    let failed = |error: std::io::Error| match error.kind() {
        std::io::ErrorKind::NotFound => not_found(&shown),
        _ => Diagnostic::without_place(format!("the scene `{}` cannot be read: {error}", clip(&shown))),
    };
    let file = disk::open(path).map_err(failed)?;
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(Diagnostic::without_place(format!(
            "`{}` is too large to be a scene, which has {} MiB at most",
            clip(&shown),
            MOST_BYTES >> 20
        )));
    }
    let text = String::from_utf8(bytes)
        .map_err(|_| Diagnostic::without_place(format!("`{}` is not a text in UTF-8", clip(&shown))))?;
    Ok(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

fn not_found(shown: &str) -> Diagnostic {
    let problem = Diagnostic::without_place(format!("there is no scene `{}`", clip(shown)));
    match nearest(shown, builtin_names().chain(node_names())) {
        Some(name) => problem.help(format!("did you mean the built-in scene `{name}`?")),
        None => problem.help("`hfvdb scenes` lists the built-in scenes"),
    }
}
