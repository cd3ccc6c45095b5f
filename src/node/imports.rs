//! Other scene files as namespaces: `import.props = "props.toml"` gives `"props/glass"`.
//!
//! What a file brings goes into the families of the scene's tree under its name, before anything of it is read. Names and
//! paths within it mean what they mean there: [`Namespaces`] tells readers which names are whose.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::node::keys::SCENE;
use crate::node::origin::{Source, text_of, tree_of};
use crate::terminal;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::files::{self, Base, FilePlace, Variables};
use crate::text::source::{Sources, Span};
use crate::text::value::{Data, Entry, Table, Value};

/// Families whose members an imported file brings. All else in it is about itself as a scene.
const FAMILIES: [&str; 7] = ["param", "palette", "color", "colour", "cells", "operation", "shape"];
/// The most files that a scene takes in all. Files that import files twice would otherwise grow without end.
const MOST_FILES: usize = 256;

/// What imported files brought.
#[derive(Clone, Debug, Default)]
pub(crate) struct Namespaces {
    /// What stands before the names of each file, such as `props/`; of a file within it, `props/lamps/`.
    prefixes: Vec<String>,
    /// Where the paths of each text begin.
    bases: BTreeMap<usize, Base>,
    /// The files on a disk.
    pub files: Vec<PathBuf>,
}

impl Namespaces {
    /// What stands before the names of the file that brought a name; nothing where the scene itself has it.
    pub fn of<'n>(&self, name: &'n str) -> &'n str {
        let known = self.prefixes.iter().filter(|prefix| name.starts_with(prefix.as_str())).map(String::len);
        &name[..known.max().unwrap_or(0)]
    }

    /// Where paths that a piece of text names begin, if that is not where the scene's own do.
    pub fn base(&self, span: Span) -> Option<&Base> {
        self.bases.get(&span.source)
    }
}

/// Takes the imports out of a scene's tree, and what they bring into it.
pub(crate) fn merge(
    root: &mut Table,
    scene: &Source,
    base: &Base,
    variables: &Variables,
    sources: &mut Sources,
    problems: &mut Vec<Diagnostic>,
) -> Namespaces {
    let way = match scene {
        Source::Path(path) => vec![(terminal::path(path), path.canonicalize().ok())],
        Source::Builtin(_) | Source::Text { .. } => Vec::new(),
    };
    let mut importing = Importing { variables, sources, problems, way, read: 0, found: Namespaces::default() };
    importing.imports(root, base, "");
    importing.found
}

struct Importing<'i> {
    variables: &'i Variables,
    sources: &'i mut Sources,
    problems: &'i mut Vec<Diagnostic>,
    /// The files that import what is read, the scene first: as messages call them, and where they are.
    way: Vec<(String, Option<PathBuf>)>,
    read: usize,
    found: Namespaces,
}

impl Importing<'_> {
    fn say(&mut self, span: Span, problem: impl Into<String>, help: impl Into<String>) {
        self.problems.push(Diagnostic::error(span, problem).help(help));
    }

    /// Takes all imports of one file's tree, whose names begin so.
    fn imports(&mut self, root: &mut Table, base: &Base, prefix: &str) {
        let Some(place) = root.0.iter().position(|entry| entry.key == "import") else { return };
        let entry = root.0.remove(place);
        let Data::Table(all) = entry.value.data else {
            return self.say(entry.value.span, "`import` must be a table of files", "import.props = \"props.toml\"");
        };
        for Entry { key, key_span, value } in all.0 {
            let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            let Some(text) = value.text() else {
                let problem = format!("`import.{}` must be a file's name", clip(&key));
                self.say(value.span, problem, "import.props = \"props.toml\"");
                continue;
            };
            if key.is_empty() || !key.chars().all(is_name) {
                let problem = format!("`{}` cannot stand before names", clip(&key));
                self.say(key_span, problem, "letters, digits, _ and -");
                continue;
            }
            if let Some(brought) = self.file(text, value.span, base, &format!("{prefix}{key}/")) {
                self.compare_units(root, &brought, value.span);
                take(root, brought, &format!("{key}/"));
            }
        }
    }

    /// One file with all that it imports; `None` where an error was said.
    fn file(&mut self, text: &str, span: Span, base: &Base, prefix: &str) -> Option<Table> {
        let file = match files::find(text, span, base, self.variables) {
            Ok(file) => file,
            Err(problem) => {
                self.problems.push(problem);
                return None;
            }
        };
        let (name, path) = (
            file.name(),
            match &file.place {
                FilePlace::Disk(path) => Some(path.clone()),
                FilePlace::BuiltIn(_) => None,
            },
        );
        let real = path.as_deref().and_then(|path| path.canonicalize().ok());
        if let Some(first) = self.way.iter().position(|(_, known)| known.is_some() && *known == real) {
            let way: Vec<&str> =
                self.way[first..].iter().map(|(name, _)| name.as_str()).chain([name.as_str()]).collect();
            let way = way.join(" → ");
            self.say(span, format!("`{}` imports itself", clip(&name)), format!("the way is {way}"));
            return None;
        }
        self.read += 1;
        if self.read > MOST_FILES {
            if self.read == MOST_FILES + 1 {
                self.say(
                    span,
                    format!("a scene imports at most {MOST_FILES} files"),
                    "each counts as often as it is imported",
                );
            }
            return None;
        }
        let mut root = self.tree(&name, path.as_deref(), &file, span)?;
        let folder = match path {
            Some(path) => {
                let folder = Base::Folder(path.parent().map(Path::to_owned).unwrap_or_default());
                self.found.files.push(path);
                folder
            }
            None => Base::BuiltIn,
        };
        self.found.bases.insert(self.sources.last(), folder.clone());
        self.found.prefixes.push(prefix.to_owned());
        self.check_top(&root);
        self.way.push((name, real));
        self.imports(&mut root, &folder, prefix);
        self.way.pop();
        Some(root)
    }

    fn tree(&mut self, name: &str, path: Option<&Path>, file: &files::FileReference, span: Span) -> Option<Table> {
        let text = match path {
            Some(path) => text_of(path),
            None => file
                .read()
                .ok()
                .and_then(|bytes| String::from_utf8(bytes).ok())
                .ok_or_else(|| Diagnostic::without_place(format!("`{}` is not a text in UTF-8", clip(name)))),
        };
        let text = match text {
            Ok(text) => text,
            Err(problem) => {
                self.problems.push(Diagnostic { span: Some(span), ..problem });
                return None;
            }
        };
        let source = self.sources.add(name, text.as_str());
        tree_of(name, &text, source).map_err(|problem| self.problems.push(problem)).ok()
    }

    /// What no scene has at its top is a mistake here too.
    fn check_top(&mut self, root: &Table) {
        for entry in root.0.iter().filter(|entry| !SCENE.iter().any(|key| key.is_called(&entry.key))) {
            let problem = format!("unknown key `{}` at the top of a scene", clip(&entry.key));
            let problem = Diagnostic::error(entry.key_span, problem);
            self.problems.push(problem.suggest(&entry.key, SCENE.iter().map(|key| key.name)));
        }
    }

    /// Numbers are taken as they are.
    fn compare_units(&mut self, root: &Table, brought: &Table, span: Span) {
        for (key, default) in [("unit", "m"), ("up", "z")] {
            let of = |table: &Table| table.get(key).and_then(|entry| entry.value.text()).unwrap_or(default).to_owned();
            let (ours, theirs) = (of(root), of(brought));
            if ours != theirs {
                let problem = format!("the file has {key} = \"{}\", and this scene \"{}\"", clip(&theirs), clip(&ours));
                let help = "its numbers are taken as they are: scale and turn its shapes where they are used";
                self.problems.push(Diagnostic::warning(span, problem).help(help));
            }
        }
    }
}

/// What a file has in its families goes into those of another, under a name before its own.
fn take(root: &mut Table, brought: Table, prefix: &str) {
    for Entry { key: family, key_span, value } in brought.0 {
        if !FAMILIES.contains(&family.as_str()) {
            continue;
        }
        if root.get(&family).is_none() {
            let nothing = Value { data: Data::Table(Table::default()), ..value };
            root.0.push(Entry { key: family.clone(), key_span, value: nothing });
        }
        let members = root.get_mut(&family).and_then(|entry| entry.value.table_mut());
        // What is no table is said where the scene is read.
        if let (Some(members), Data::Table(more)) = (members, value.data) {
            members.0.extend(more.0.into_iter().map(|entry| Entry { key: format!("{prefix}{}", entry.key), ..entry }));
        }
    }
}
