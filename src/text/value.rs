//! The text as a tree of values that know their places. TOML and JSON become the same tree.

use std::collections::BTreeSet;

use serde::de::{Deserialize, Deserializer, MapAccess, Visitor};
use serde_json::value::RawValue;

use crate::text::diagnostic::Diagnostic;
use crate::text::source::Span;

/// Who gave a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// Nobody: it is the format's default.
    Default,
    /// The scene.
    Scene,
    /// The variant that was asked for.
    Variant,
    /// The command line.
    Set,
}

/// A value and its place.
#[derive(Clone, Debug)]
pub struct Value {
    /// What it is.
    pub data: Data,
    /// Where it stands.
    pub span: Span,
    /// Who gave it.
    pub origin: Origin,
}

/// What a value is.
#[derive(Clone, Debug)]
pub enum Data {
    /// A string.
    Text(String),
    /// A whole number.
    Integer(i64),
    /// Any other number.
    Float(f64),
    /// True or false.
    Flag(bool),
    /// An array.
    List(Vec<Value>),
    /// A table.
    Table(Table),
}

/// A table's entries in the order of the text.
#[derive(Clone, Debug, Default)]
pub struct Table(pub Vec<Entry>);

/// A key with its value.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The key.
    pub key: String,
    /// Where the key stands.
    pub key_span: Span,
    /// What it is set to.
    pub value: Value,
}

impl Table {
    /// The entry of a key.
    pub fn get(&self, key: &str) -> Option<&Entry> {
        self.0.iter().find(|entry| entry.key == key)
    }

    /// The entry of a key, to be changed.
    pub fn get_mut(&mut self, key: &str) -> Option<&mut Entry> {
        self.0.iter_mut().find(|entry| entry.key == key)
    }

    /// Appends the table in a form that spacing, comments, the order of keys and the spelling of numbers do not change.
    /// What the scene's hash is made from.
    pub fn canonical(&self, out: &mut String) {
        use std::fmt::Write;
        let mut entries: Vec<&Entry> = self.0.iter().collect();
        entries.sort_by(|a, b| a.key.cmp(&b.key));
        out.push('{');
        for entry in entries {
            // Writing to a string cannot fail.
            let _ = write!(out, "{:?}:", entry.key);
            entry.value.canonical(out);
            out.push(',');
        }
        out.push('}');
    }
}

impl Value {
    /// What kind of value it is, for messages.
    pub fn kind(&self) -> &'static str {
        match self.data {
            Data::Text(_) => "a string",
            Data::Integer(_) => "a whole number",
            Data::Float(_) => "a number",
            Data::Flag(_) => "true or false",
            Data::List(_) => "a list",
            Data::Table(_) => "a table",
        }
    }

    /// The number, whole or not.
    pub fn number(&self) -> Option<f64> {
        match self.data {
            Data::Integer(value) => Some(value as f64),
            Data::Float(value) => Some(value),
            _ => None,
        }
    }

    /// The string.
    pub fn text(&self) -> Option<&str> {
        if let Data::Text(text) = &self.data { Some(text) } else { None }
    }

    /// The table.
    pub fn table(&self) -> Option<&Table> {
        if let Data::Table(table) = &self.data { Some(table) } else { None }
    }

    /// The table, to be changed.
    pub fn table_mut(&mut self) -> Option<&mut Table> {
        if let Data::Table(table) = &mut self.data { Some(table) } else { None }
    }

    /// The list.
    pub fn list(&self) -> Option<&[Value]> {
        if let Data::List(list) = &self.data { Some(list) } else { None }
    }

    /// Says of this value and all below who gave it.
    pub fn set_origin(&mut self, origin: Origin) {
        self.origin = origin;
        match &mut self.data {
            Data::List(list) => list.iter_mut().for_each(|value| value.set_origin(origin)),
            Data::Table(table) => table.0.iter_mut().for_each(|entry| entry.value.set_origin(origin)),
            _ => {}
        }
    }

    fn canonical(&self, out: &mut String) {
        use std::fmt::Write;
        let written = match &self.data {
            Data::Text(text) => write!(out, "{text:?}"),
            Data::Integer(value) => write!(out, "{:?}", *value as f64),
            Data::Float(value) => write!(out, "{value:?}"),
            Data::Flag(value) => write!(out, "{value}"),
            Data::List(list) => {
                out.push('[');
                for value in list {
                    value.canonical(out);
                    out.push(',');
                }
                write!(out, "]")
            }
            Data::Table(table) => {
                table.canonical(out);
                Ok(())
            }
        };
        written.expect("a string takes everything");
    }
}

/// Reads a TOML text.
pub fn parse_toml(text: &str, source: usize, origin: Origin) -> Result<Table, Diagnostic> {
    let mut root = toml_span::parse(text).map_err(|error| {
        let span = Span::new(source, error.span.into());
        let diagnostic = Diagnostic::error(span, format!("not TOML: {error}"));
        match error.kind {
            toml_span::ErrorKind::UnquotedString => diagnostic.help("text stands in quotes"),
            toml_span::ErrorKind::DottedKeyInvalidType { .. } => diagnostic
                .help("a point in a key opens a table; a key with a point of its own stands in quotes: \"12.5\""),
            toml_span::ErrorKind::Wanted { found: "a comment", .. } => {
                diagnostic.help("what begins with # is a comment: a colour stands in quotes, \"#d7263d\"")
            }
            toml_span::ErrorKind::ExceededDepthLimit => nested_too_deeply(span),
            _ => diagnostic,
        }
    })?;
    match from_toml(&mut root, source, origin).data {
        Data::Table(table) => Ok(table),
        _ => Ok(Table::default()),
    }
}

fn from_toml(value: &mut toml_span::Value<'_>, source: usize, origin: Origin) -> Value {
    use toml_span::value::ValueInner;
    let span = Span::new(source, value.span.into());
    let data = match value.take() {
        ValueInner::String(text) => Data::Text(text.into_owned()),
        ValueInner::Integer(value) => Data::Integer(value),
        ValueInner::Float(value) => Data::Float(value),
        ValueInner::Boolean(value) => Data::Flag(value),
        ValueInner::Array(list) => {
            Data::List(list.into_iter().map(|mut value| from_toml(&mut value, source, origin)).collect())
        }
        ValueInner::Table(table) => {
            let mut entries: Vec<Entry> = table
                .into_iter()
                .map(|(key, mut value)| Entry {
                    key: key.name.into_owned(),
                    key_span: Span::new(source, key.span.into()),
                    value: from_toml(&mut value, source, origin),
                })
                .collect();
            entries.sort_by_key(|entry| entry.key_span.start);
            Data::Table(Table(entries))
        }
    };
    Value { data, span, origin }
}

/// How deep tables and lists of a JSON scene may stand in one another: 64 shapes in place, each in a list, and what they
/// stand in. Deeper, a text of brackets could overflow the stack. (TOML's parser has a limit of its own.)
const DEEPEST: usize = 132;

fn nested_too_deeply(span: Span) -> Diagnostic {
    Diagnostic::error(span, "tables and lists are nested too deeply")
        .help("give one of the shapes on the way a name: [shape.NAME]")
}

/// The byte at which JSON is nested too deeply, if it is. Whether it is JSON otherwise is for its parser.
fn too_deep(text: &str) -> Option<usize> {
    let (mut depth, mut in_string, mut escaped) = (0_usize, false, false);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => in_string = !in_string,
            _ if in_string => {}
            b'{' | b'[' => {
                depth += 1;
                if depth > DEEPEST {
                    return Some(at);
                }
            }
            b'}' | b']' => depth = depth.saturating_sub(1),
            _ => {}
        }
    }
    None
}

/// Reads a JSON text.
pub fn parse_json(text: &str, source: usize) -> Result<Table, Diagnostic> {
    if let Some(at) = too_deep(text) {
        return Err(nested_too_deeply(Span::new(source, at..at + 1)));
    }
    let root: &RawValue = serde_json::from_str(text).map_err(|error| {
        let at = offset_of(text, error.line(), error.column());
        let message = error.to_string();
        let message = message.split(" at line ").next().unwrap_or_default();
        Diagnostic::error(Span::new(source, at..at + 1), format!("not JSON: {message}"))
    })?;
    let mut diagnostics = Ok(());
    let root = from_json(root, text, source, &mut diagnostics);
    diagnostics?;
    match root.data {
        Data::Table(table) => Ok(table),
        _ => Err(Diagnostic::error(root.span, "a scene is a JSON object").label(format!("this is {}", root.kind()))),
    }
}

/// A JSON value whose parts are still text, so that their places are known. Each level is read once more, so
/// the work grows with depth, which is [limited](DEEPEST).
fn from_json(raw: &RawValue, text: &str, source: usize, problem: &mut Result<(), Diagnostic>) -> Value {
    // Both lie in one string, so the difference of the addresses is the offset.
    let start = raw.get().as_ptr() as usize - text.as_ptr() as usize;
    let span = Span::new(source, start..start + raw.get().len());
    let piece = raw.get();
    let data = match piece.as_bytes().first() {
        Some(b'{') => {
            let members: Members<'_> = serde_json::from_str(piece).unwrap_or_default();
            let mut entries: Vec<Entry> = Vec::new();
            let mut known = BTreeSet::new();
            for (key, raw) in members.0 {
                let value = from_json(raw, text, source, problem);
                let key_span = key_before(text, value.span);
                if !known.insert(key.clone()) && problem.is_ok() {
                    *problem = Err(Diagnostic::error(key_span, format!("not JSON: duplicate key: `{key}`")));
                }
                entries.push(Entry { key, key_span, value });
            }
            Data::Table(Table(entries))
        }
        Some(b'[') => {
            let list: Vec<&RawValue> = serde_json::from_str(piece).unwrap_or_default();
            Data::List(list.into_iter().map(|raw| from_json(raw, text, source, problem)).collect())
        }
        Some(b'"') => Data::Text(serde_json::from_str(piece).unwrap_or_default()),
        Some(b't' | b'f') => Data::Flag(piece == "true"),
        Some(b'n') => {
            if problem.is_ok() {
                *problem = Err(Diagnostic::error(span, "null stands for nothing here").help("leave the key out"));
            }
            Data::Flag(false)
        }
        _ => match piece.parse::<i64>() {
            Ok(value) => Data::Integer(value),
            Err(_) => Data::Float(piece.parse().unwrap_or(f64::NAN)),
        },
    };
    Value { data, span, origin: Origin::Scene }
}

/// The members of a JSON object in their order, doubles included.
#[derive(Default)]
struct Members<'t>(Vec<(String, &'t RawValue)>);

impl<'t> Deserialize<'t> for Members<'t> {
    fn deserialize<D: Deserializer<'t>>(deserializer: D) -> Result<Self, D::Error> {
        struct InOrder;
        impl<'t> Visitor<'t> for InOrder {
            type Value = Members<'t>;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'t>>(self, mut map: A) -> Result<Members<'t>, A::Error> {
                let mut members = Vec::new();
                while let Some(member) = map.next_entry()? {
                    members.push(member);
                }
                Ok(Members(members))
            }
        }
        deserializer.deserialize_map(InOrder)
    }
}

/// The place of the key that stands before a value in JSON.
fn key_before(text: &str, value: Span) -> Span {
    let end = text[..value.start].trim_end().strip_suffix(':').map_or(value.start, |before| before.trim_end().len());
    let inside = end.saturating_sub(1);
    let is_open = |&(i, _): &(usize, &str)| {
        let backslashes = text[..i].len() - text[..i].trim_end_matches('\\').len();
        backslashes.is_multiple_of(2)
    };
    let start = text[..inside].rmatch_indices('"').find(is_open).map_or(value.start, |(i, _)| i + 1);
    Span::new(value.source, start..inside.max(start))
}

/// The byte at a line and a column of bytes, both from 1, as serde_json counts them.
fn offset_of(text: &str, line: usize, column: usize) -> usize {
    let line_start: usize = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum();
    (line_start + column.saturating_sub(1)).min(text.len().saturating_sub(1))
}
