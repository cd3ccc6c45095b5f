//! Paths on the command line, as the shell would have them: in quotes it leaves `~/` and `$NAME` to the program.

use std::path::{Path, PathBuf};

use clap::builder::{OsStringValueParser, StringValueParser, TypedValueParser};

use crate::text::expand;

/// Reads a path.
pub fn path() -> impl TypedValueParser<Value = PathBuf> {
    OsStringValueParser::new().try_map(|argument| match argument.to_str() {
        Some(text) => expanded(text, &environment).map(PathBuf::from),
        // What is no text has no variables.
        None => Ok(PathBuf::from(argument)),
    })
}

/// Reads a path that may also be a name.
pub fn text() -> impl TypedValueParser<Value = String> {
    StringValueParser::new().try_map(|text| expanded(&text, &environment))
}

fn environment(name: &str) -> Option<String> {
    std::env::var(name).ok()
}

/// `~/` is the home folder, `$NAME` and `${NAME}` are variables as in scenes, and `$F4` stays the frame's number. What
/// exists under the very name that was given is that.
fn expanded(text: &str, variables: &dyn Fn(&str) -> Option<String>) -> Result<String, String> {
    let home = text.strip_prefix('~').filter(|rest| rest.is_empty() || rest.starts_with('/'));
    if home.is_none() && (!text.contains('$') || Path::new(text).exists()) {
        return Ok(text.into());
    }
    let known = |name: &str| if is_frame(name) { Some(format!("${name}")) } else { variables(name) };
    let rest = expand(home.unwrap_or(text), &known)?;
    if home.is_none() {
        return Ok(rest);
    }
    let home = variables("HOME").filter(|home| !home.is_empty());
    Ok(home.ok_or("`~` is the home folder, and the variable `$HOME` is not set")? + &rest)
}

/// Whether the name after a `$` is the frame's number: `F`, digits, and nothing that belongs to a longer word.
fn is_frame(name: &str) -> bool {
    let rest = name.strip_prefix('F').map(|digits| digits.trim_start_matches(|c: char| c.is_ascii_digit()));
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('_'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn home_and_variables_as_in_a_shell() {
        let variables = |name: &str| match name {
            "HOME" => Some("/home/me".into()),
            "SHOT" => Some("/s/010".into()),
            _ => None,
        };
        let read = |text: &str| expanded(text, &variables);
        for (text, path) in [
            ("~/a.####.vdb", "/home/me/a.####.vdb"),
            ("~", "/home/me"),
            ("~you/a.vdb", "~you/a.vdb"),
            ("a~/b", "a~/b"),
            ("$SHOT/m.$F4.vdb", "/s/010/m.$F4.vdb"),
            ("${SHOT}/m_$F4_v2.vdb", "/s/010/m_$F4_v2.vdb"),
            ("~/$SHOT", "/home/me//s/010"),
            ("m.$F.vdb", "m.$F.vdb"),
            ("a$$SHOT", "a$SHOT"),
            ("heart", "heart"),
        ] {
            assert_eq!(read(text).as_deref(), Ok(path), "{text}");
        }
        assert_eq!(read("$SHOTS/a.vdb"), Err("the variable `$SHOTS` is not set".into()));
        assert_eq!(read("$FOO/a.vdb"), Err("the variable `$FOO` is not set".into()));
        assert!(expanded("~/a", &|_| None).is_err_and(|problem| problem.contains("HOME")));
    }
}
