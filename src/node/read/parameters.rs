//! Numbers with names: `[param]`, and those of an operation.

use std::sync::Arc;

use crate::node::keys;
use crate::node::model::Model;
use crate::node::parameter::Parameter;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::frames::sampled_frames;
use crate::text::key::{GREATEST, Limit};
use crate::text::number::formula::{RESERVED, Scope};
use crate::text::number::{Number, NumberValue, plain_number};
use crate::text::reader::{Fields, NO_OWNER, Reader};
use crate::text::source::Span;
use crate::text::value::{Entry, Value};

/// The parameters of a table, whose whole name is given.
pub(super) fn parameters<'r>(
    reader: &Reader<'_>,
    family: &str,
    entries: impl Iterator<Item = &'r Entry>,
) -> Vec<Parameter> {
    // Formulas of parameters know time only.
    let time_only = Reader::new(reader.sources, Scope::default());
    let all = entries.map(|entry| parameter(reader, &time_only, &format!("{family}.{}", entry.key), entry)).collect();
    time_only.into_parts().0.into_iter().for_each(|diagnostic| reader.say(diagnostic));
    all
}

fn parameter(reader: &Reader<'_>, time_only: &Reader<'_>, path: &str, entry: &Entry) -> Parameter {
    let name = entry.key.clone();
    // A table without a value is one of keys.
    let described = entry.value.table().filter(|table| {
        table.get("value").is_some()
            || table.0.iter().any(|entry| keys::PARAMETER.iter().any(|key| key.is_called(&entry.key)))
    });
    let Some(table) = described else {
        reader.note_value(path, &entry.value);
        return Parameter { name, value: time_only.number(path, Limit::Any, &entry.value), text: None };
    };
    let fields = Fields::new(reader, path, NO_OWNER, entry.key_span, table, keys::PARAMETER.iter().collect());
    let mut value = match fields.value("value") {
        Some(value) => time_only.number(path, Limit::Any, value),
        None => Number::constant(1.0, path, entry.key_span),
    };
    let text = fields.text("text");
    if let Some(limit) = range(&fields) {
        value.limit = limit;
        if let NumberValue::Constant(constant) = value.value
            && let Some(wanted) = limit.out_of_range(constant)
        {
            let problem = format!("`{}` must be {wanted}, and is {}", clip(path), plain_number(constant));
            let about = text.as_ref().map_or_else(String::new, |text| format!("it is \"{}\"", clip(text)));
            reader.say(Diagnostic::error(value.span, problem).help(about));
        }
    }
    Parameter { name, value, text }
}

/// A name that formulas can hold and that means nothing else there; says what keeps it from that.
pub(super) fn check_name(reader: &Reader<'_>, name: &str, span: Span) {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    if RESERVED.contains(&name) {
        reader.say(Diagnostic::error(span, format!("`{name}` already means something in formulas")));
    } else if name.is_empty() || !name.chars().all(is_name) || name.starts_with(|c: char| c.is_ascii_digit()) {
        let problem = format!("`{}` cannot be a name in formulas", clip(name));
        reader.say(Diagnostic::error(span, problem).help("letters, digits and _, no digit first"));
    }
}

/// What `min`, `max` or `range` say.
fn range(fields: &Fields<'_, '_>) -> Option<Limit> {
    let (min, max) = (fields.constant("min"), fields.constant("max"));
    if let Some(entry) = fields.entry("range") {
        let (path, reader) = (fields.full("range"), fields.reader);
        if min.or(max).is_some() {
            let problem = format!("`{}` says what `min` and `max` say", clip(&path));
            reader.say(Diagnostic::error(entry.key_span, problem));
        }
        return fields.value("range").and_then(|value| pair(reader, &path, value));
    }
    if let (Some(least), Some(most), Some(entry)) = (min, max, fields.entry("max"))
        && least >= most
    {
        let problem = format!("`{}` must be greater than `min`", clip(&fields.full("max")));
        fields.reader.say(Diagnostic::error(entry.value.span, problem));
        return None;
    }
    min.or(max)?;
    Some(Limit::Within(min.unwrap_or(-GREATEST), max.unwrap_or(GREATEST)))
}

/// `[least, greatest]`.
fn pair(reader: &Reader<'_>, name: &str, value: &Value) -> Option<Limit> {
    let numbers: Option<Vec<f64>> = value.list().map(|list| list.iter().filter_map(Value::number).collect());
    match numbers.as_deref() {
        Some(&[least, greatest]) if least < greatest => Some(Limit::Within(least, greatest)),
        _ => {
            let problem = format!("`{}` takes two numbers, [least, greatest]", clip(name));
            reader.say(Diagnostic::error(value.span, problem));
            None
        }
    }
}

/// An error for each parameter that leaves its range somewhere in the shot.
pub(super) fn out_of_range(model: &Model) -> Vec<Diagnostic> {
    let ranged = |parameter: &&Parameter| {
        parameter.value.limit != Limit::Any && !matches!(parameter.value.value, NumberValue::Constant(_))
    };
    let first_problem = |parameter: &Parameter| {
        let frames = sampled_frames(model.shot.range).into_iter();
        let mut moments = frames.map(|frame| model.shot.moment(frame, Arc::new([])));
        let bad = moments.find_map(|moment| parameter.value.at(&moment).err())?;
        Some(Diagnostic::error(bad.span, bad.message))
    };
    model.parameters.iter().filter(ranged).filter_map(first_problem).collect()
}
