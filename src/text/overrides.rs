//! Variants and `--set`: other values for dotted keys.

use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::key::{Key, Kind};
use crate::text::source::{Sources, Span};
use crate::text::value::{Data, Entry, Origin, Table, Value, parse_toml};

/// What the command line changes in a scene.
#[derive(Clone, Debug, Default)]
pub struct Overrides {
    /// `--set name=value`: a parameter's name, a key at the top of a scene, or a dotted key.
    pub set: Vec<String>,
    /// `--variant NAME`.
    pub variant: Option<String>,
}

/// Applies the variant, then each `--set`, and takes the variants out of the tree.
/// `top` are the keys that a scene has at its top.
pub fn apply(root: &mut Table, top: &[Key], overrides: &Overrides, sources: &mut Sources, out: &mut Vec<Diagnostic>) {
    let variants = root.0.iter().position(|entry| entry.key == "variant").map(|i| root.0.remove(i));
    if let Some(name) = &overrides.variant {
        apply_variant(root, name, variants, sources, out);
    }
    for text in &overrides.set {
        if let Err(problem) = apply_set(root, top, text, sources) {
            out.push(problem);
        }
    }
}

fn apply_variant(root: &mut Table, name: &str, variants: Option<Entry>, sources: &Sources, out: &mut Vec<Diagnostic>) {
    let table = variants.as_ref().and_then(|entry| entry.value.table().cloned()).unwrap_or_default();
    let Some(variant) = table.get(name) else {
        let problem = Diagnostic::without_place(format!("the scene has no variant `{}`", clip(name)));
        out.push(match table.0.is_empty() {
            true => problem,
            false => problem.suggest(name, table.0.iter().map(|entry| entry.key.as_str())),
        });
        return;
    };
    let mut value = variant.value.clone();
    value.set_origin(Origin::Variant);
    match value.data {
        Data::Table(table) => merge(root, undotted(table), sources, 0),
        _ => out.push(Diagnostic::error(value.span, format!("`variant.{}` must be a table", clip(name)))),
    }
}

/// `size=3` or `morph.bridge=0.3`: TOML, or else a text without quotes.
fn apply_set(root: &mut Table, top: &[Key], text: &str, sources: &mut Sources) -> Result<(), Diagnostic> {
    let Some((name, value)) = text.split_once('=') else {
        return Err(Diagnostic::without_place(format!("--set `{}` has no `=`: it is name=value", clip(text))));
    };
    let name = quoted(name);
    let text = format!("{name}={value}");
    let source = sources.add(format!("--set {}", clip(&text)), text.as_str());
    let set = parse_toml(&text, source, Origin::Set)
        .or_else(|_| parse_toml(&format!("{name}={value:?}"), source, Origin::Set))
        .map_err(|_| Diagnostic::without_place(format!("--set `{}` is not name=value", clip(&text))))?;
    let set = match set.0.first() {
        // Of `a.b={ … }`, too, the table of a ends in braces.
        Some(only)
            if !matches!(only.value.data, Data::Table(_))
                || (!name.contains('.') && is_inline(&only.value, sources)) =>
        {
            let known = root.get("param").and_then(|entry| entry.value.table());
            let is_parameter = known.is_some_and(|known| known.get(&only.key).is_some());
            if !is_parameter && top.iter().any(|key| key.kind != Kind::Table && key.is_called(&only.key)) {
                merge(root, set, sources, 0);
                return Ok(());
            }
            if !is_parameter {
                let names = known.map(|known| known.0.iter().map(|entry| entry.key.as_str())).into_iter().flatten();
                return Err(Diagnostic::error(only.key_span, format!("there is no parameter `{}`", clip(&only.key)))
                    .suggest(&only.key, names));
            }
            Table(vec![entry("param".into(), only.key_span, Data::Table(parameter(only, known)), Origin::Set)])
        }
        _ => set,
    };
    merge(root, set, sources, 0);
    Ok(())
}

/// With quotes around parts of the name that hold a /, as those of imported files do: TOML takes them in quotes alone.
fn quoted(name: &str) -> String {
    let part = |part: &str| if part.contains('/') && !part.contains('"') { format!("\"{part}\"") } else { part.into() };
    name.split('.').map(|name| part(name.trim())).collect::<Vec<_>>().join(".")
}

/// `name = 3`, or `name.value = 3` where the scene describes the parameter in a table.
fn parameter(new: &Entry, known: Option<&Table>) -> Table {
    let described = known.and_then(|known| known.get(&new.key)?.value.table()?.get("value"));
    let new = match described {
        None => new.clone(),
        Some(_) => {
            let value = Entry { key: "value".into(), ..new.clone() };
            entry(new.key.clone(), new.key_span, Data::Table(Table(vec![value])), Origin::Set)
        }
    };
    Table(vec![new])
}

fn entry(key: String, span: Span, data: Data, origin: Origin) -> Entry {
    Entry { key, key_span: span, value: Value { data, span, origin } }
}

/// Whether a table is written in braces: a value by itself rather than a path to values.
fn is_inline(value: &Value, sources: &Sources) -> bool {
    matches!(value.data, Data::Table(_)) && sources.text(value.span).starts_with('{')
}

/// Keys such as `"morph.bridge"`, quoted as one, opened into tables.
fn undotted(table: Table) -> Table {
    let mut out = Table::default();
    for Entry { key, key_span, value } in table.0 {
        let mut names = key.rsplit('.');
        let last = names.next().unwrap_or_default().to_owned();
        let mut opened = Entry { key: last, key_span, value };
        for name in names {
            let origin = opened.value.origin;
            opened = entry(name.into(), key_span, Data::Table(Table(vec![opened])), origin);
        }
        match (out.get_mut(&opened.key).map(|entry| &mut entry.value.data), opened.value.data) {
            (Some(Data::Table(there)), Data::Table(more)) => there.0.extend(more.0),
            (_, data) => out.0.push(Entry { value: Value { data, ..opened.value }, ..opened }),
        }
    }
    out
}

/// Tables go into tables; anything else, and a table in braces below `family.name`, replaces what was there.
fn merge(into: &mut Table, from: Table, sources: &Sources, level: usize) {
    for new in from.0 {
        let replaces = level >= 2 && is_inline(&new.value, sources);
        let Some(old) = into.get_mut(&new.key) else {
            into.0.push(new);
            continue;
        };
        match (&mut old.value.data, new.value.data) {
            (Data::Table(old), Data::Table(table)) if !replaces => merge(old, table, sources, level + 1),
            (_, data) => {
                *old = Entry { key: new.key, key_span: new.key_span, value: Value { data, ..new.value } };
            }
        }
    }
}
