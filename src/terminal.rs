//! Text of others on a terminal: names and messages out of files, arguments, paths. Characters that a terminal obeys are
//! shown as `\u{1b}` instead.

use std::borrow::Cow;
#[cfg(feature = "cli")]
use std::io::IsTerminal;
use std::path::Path;

/// Whether stderr is a terminal that knows more than to print: `TERM=dumb` says that it does not.
#[cfg(feature = "cli")]
pub fn obeys() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("TERM").is_none_or(|kind| kind != "dumb")
}

/// Whether a terminal obeys a character instead of showing it: control characters (C0, DEL, C1), and those that turn the
/// direction of text round.
fn is_obeyed(c: char) -> bool {
    c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Whether anything in a text is obeyed.
#[cfg(feature = "cli")]
pub fn is_obeyed_in(text: &str) -> bool {
    text.contains(is_obeyed)
}

fn escaped(text: &str, kept: impl Fn(char) -> bool) -> Cow<'_, str> {
    let is_wrong = |c: char| is_obeyed(c) && !kept(c);
    if !text.contains(is_wrong) {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if is_wrong(c) { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out.into()
}

/// Text of others within a line of our own.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, |_| false)
}

/// The same, at most so many characters of it.
pub fn clipped(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        None => one_line(text),
        Some((end, _)) => format!("{}…", one_line(&text[..end])).into(),
    }
}

/// A path within a line of our own. What is not UTF-8 in it shows as `\xff`.
pub fn path(path: &Path) -> String {
    use std::os::unix::ffi::OsStrExt;
    let mut out = String::new();
    for chunk in path.as_os_str().as_bytes().utf8_chunks() {
        out += &one_line(chunk.valid());
        for byte in chunk.invalid() {
            out += &format!("\\x{byte:02x}");
        }
    }
    out
}

/// A whole message of ours, with whatever is in it: lines stay lines.
pub fn message(text: &str) -> Cow<'_, str> {
    escaped(text, |c| c == '\n' || c == '\t')
}

/// The same with colours: their sequences are kept.
#[cfg(feature = "cli")]
pub fn coloured(text: &str) -> Cow<'_, str> {
    escaped(text, |c| matches!(c, '\n' | '\t' | '\u{1b}'))
}

/// JSON, whose strings may hold what a terminal obeys as it is.
#[cfg(feature = "cli")]
pub fn json(text: &str) -> Cow<'_, str> {
    if !text.contains(|c| is_obeyed(c) && c != '\n') {
        return text.into();
    }
    let mut out = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        // All of them are of the basic plane, and stand in strings alone.
        if is_obeyed(c) && c != '\n' { out += &format!("\\u{:04x}", u32::from(c)) } else { out.push(c) }
    }
    out.into()
}

/// Whether messages may have colours.
#[cfg(feature = "cli")]
pub fn styled() -> bool {
    obeys() && std::env::var_os("NO_COLOR").is_none_or(|set| set.is_empty())
}

#[cfg(test)]
mod tests {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;

    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_shown() {
        assert_eq!(one_line("größe ▶ 1"), "größe ▶ 1");
        assert_eq!(one_line("a\u{1b}[31mb\nc\td\u{9b}e\u{202e}f\u{7f}"), r"a\u{1b}[31mb\nc\td\u{9b}e\u{202e}f\u{7f}");
        assert_eq!(message("a\n\tb\r\u{7}"), "a\n\tb\\r\\u{7}");
        assert_eq!(coloured("\u{1b}[1mred\u{9b}\n"), "\u{1b}[1mred\\u{9b}\n");
        assert_eq!(path(Path::new(OsStr::from_bytes(b"a\xff\x1b.toml"))), r"a\xff\u{1b}.toml");
    }

    #[test]
    fn json_stays_json() {
        let document = serde_json::json!({ "name": "a\u{1b}\u{7f}\u{9b}\u{202e}\n" });
        let text = format!("{document:#}\n");
        let shown = json(&text);
        assert!(!shown.contains(|c| is_obeyed(c) && c != '\n'), "{shown:?}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).expect("JSON"), document);
    }
}
