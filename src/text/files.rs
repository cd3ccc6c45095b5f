//! Files that a scene names: variables expanded, relative to the scene, there or not.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::disk;
use crate::terminal;
use crate::text::diagnostic::{Diagnostic, clip, nearest};
use crate::text::problem::Problem;
use crate::text::source::Span;

/// What a file is read from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilePlace {
    /// A disk.
    Disk(PathBuf),
    /// The program itself: the files of its built-in scenes.
    BuiltIn(&'static str),
}

/// A file that a scene names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileReference {
    /// What it is read from.
    pub place: FilePlace,
    /// Where the scene names it.
    pub span: Span,
}

/// Where relative paths begin.
#[derive(Clone, Debug)]
pub enum Base {
    /// At this folder.
    Folder(PathBuf),
    /// At the program's own files.
    BuiltIn,
}

/// The values of variables in paths.
pub type Variables = Arc<dyn Fn(&str) -> Option<String> + Send + Sync>;

/// Finds the file that a scene names; it must be there.
pub fn find(text: &str, span: Span, base: &Base, variables: &Variables) -> Result<FileReference, Diagnostic> {
    let expanded = expand(text, variables.as_ref()).map_err(|problem| {
        Diagnostic::error(span, problem).help("variables are those of the environment; `$$` is a dollar sign")
    })?;
    if expanded.is_empty() {
        return Err(Diagnostic::error(span, "the file has no name"));
    }
    let path = match base {
        Base::BuiltIn => match crate::text::builtin::file(&expanded) {
            Some((name, _)) => return Ok(FileReference { place: FilePlace::BuiltIn(name), span }),
            None => PathBuf::from(&expanded),
        },
        Base::Folder(folder) => folder.join(&expanded),
    };
    match std::fs::metadata(&path) {
        Ok(metadata) if metadata.is_dir() => {
            Err(Diagnostic::error(span, format!("`{}` is a folder, not a file", clip(&expanded))))
        }
        Ok(_) => Ok(FileReference { place: FilePlace::Disk(path), span }),
        Err(error) => {
            // A built-in scene, redirected into a file and changed, still names the cube inside the program.
            if let Some((name, _)) = crate::text::builtin::file(&expanded) {
                return Ok(FileReference { place: FilePlace::BuiltIn(name), span });
            }
            let problem = match error.kind() {
                std::io::ErrorKind::NotFound => format!("there is no file `{}`", clip(&expanded)),
                _ => format!("`{}` cannot be read: {error}", clip(&expanded)),
            };
            Err(suggest_neighbour(Diagnostic::error(span, problem), &path))
        }
    }
}

/// With the nearest name in the folder.
pub(super) fn suggest_neighbour(diagnostic: Diagnostic, path: &Path) -> Diagnostic {
    const MOST_LOOKED_AT: usize = 1000;
    let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else { return diagnostic };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return diagnostic.help(format!("there is no folder `{}`", clip(&terminal::path(folder))));
    };
    let mut names: Vec<String> =
        entries.take(MOST_LOOKED_AT).flatten().map(|entry| entry.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    match nearest(&name.to_string_lossy(), names.iter().map(String::as_str)) {
        Some(near) => diagnostic.help(format!("did you mean `{near}`?")),
        None => diagnostic.help("paths are relative to the scene's own folder"),
    }
}

/// Replaces `$NAME` and `${NAME}`; `$$` is a dollar sign.
///
/// # Errors
/// What is wrong with it, in words; a variable that is not set is.
pub fn expand(text: &str, variables: &dyn Fn(&str) -> Option<String>) -> Result<String, String> {
    let mut out = String::new();
    let mut rest = text;
    while let Some(dollar) = rest.find('$') {
        out.push_str(&rest[..dollar]);
        rest = &rest[dollar + 1..];
        if let Some(after) = rest.strip_prefix('$') {
            out.push('$');
            rest = after;
            continue;
        }
        let (name, after) = match rest.strip_prefix('{') {
            Some(braced) => braced.split_once('}').ok_or("a `${` in the path has no `}`")?,
            None => {
                let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).unwrap_or(rest.len());
                rest.split_at(end)
            }
        };
        if name.is_empty() {
            return Err("a `$` in the path is followed by no name".into());
        }
        let value = variables(name).ok_or_else(|| format!("the variable `${}` is not set", clip(name)))?;
        out.push_str(&value);
        rest = after;
    }
    out.push_str(rest);
    Ok(out)
}

impl FileReference {
    /// The name for messages.
    pub fn name(&self) -> String {
        match &self.place {
            FilePlace::Disk(path) => terminal::path(path),
            FilePlace::BuiltIn(name) => (*name).into(),
        }
    }

    /// The file's bytes.
    pub fn read(&self) -> std::io::Result<Vec<u8>> {
        match &self.place {
            FilePlace::Disk(path) => disk::read(path),
            FilePlace::BuiltIn(name) => {
                Ok(crate::text::builtin::file(name).map_or_else(Vec::new, |(_, bytes)| bytes.to_vec()))
            }
        }
    }
}

impl FileReference {
    /// The file's bytes, at most so many.
    ///
    /// # Errors
    /// Why it cannot be read, with its name.
    pub fn read_at_most(&self, most: u64) -> Result<Vec<u8>, Problem> {
        let bytes = match &self.place {
            FilePlace::Disk(path) => disk::read_at_most(path, most),
            FilePlace::BuiltIn(_) => self.read(),
        };
        bytes.map_err(|error| self.problem(format!("it cannot be read: {error}")))
    }

    /// What is wrong with the file, after its name.
    pub fn problem(&self, problem: impl std::fmt::Display) -> Problem {
        Problem::new(self.span, format!("{}: {problem}", self.name()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variables_are_expanded_and_must_be_set() {
        let variables: Variables = Arc::new(|name| (name == "SHOT").then(|| "/s/010".into()));
        assert_eq!(expand("$SHOT/a.obj", variables.as_ref()), Ok("/s/010/a.obj".into()));
        assert_eq!(expand("${SHOT}x", variables.as_ref()), Ok("/s/010x".into()));
        assert_eq!(expand("plain", variables.as_ref()), Ok("plain".into()));
        assert_eq!(expand("a$$SHOT", variables.as_ref()), Ok("a$SHOT".into()));
        assert_eq!(expand("$SHOTS/a", variables.as_ref()), Err("the variable `$SHOTS` is not set".into()));
        assert!(expand("${SHOT", variables.as_ref()).is_err());
        assert!(expand("$/a", variables.as_ref()).is_err());
    }
}
