//! Scalars of shapes: the table of `attribute`.

use std::collections::BTreeMap;

use super::{Building, Host};
use crate::node::argument::{Argument, Arguments};
use crate::node::direct::VALUE;
use crate::node::keys;
use crate::node::model::{Component, ShapeScalar};
use crate::node::table;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::key::Limit;
use crate::text::number::NumberValue;
use crate::text::source::Span;
use crate::text::value::{Data, Entry, Value};

impl<'r, 'a> Building<'r, 'a> {
    /// `attribute.NAME = …`, as many as there are.
    pub(super) fn scalars(&mut self, path: &str, value: &'r Value, host: Host) -> BTreeMap<String, ShapeScalar> {
        let Some(table) = value.table() else {
            self.reader.wrong_kind(path, "a table", value);
            return BTreeMap::new();
        };
        let mut scalars = BTreeMap::new();
        for entry in &table.0 {
            let name_is_sound = self.check_name(entry);
            let scalar = self.scalar(&format!("{path}.{}", entry.key), &entry.value, host);
            if name_is_sound {
                // One that is wrong was said; those who name it are not.
                scalars.insert(
                    entry.key.clone(),
                    scalar.unwrap_or_else(|| given(Argument::Numbers(vec![0.0]), entry.value.span)),
                );
            }
        }
        scalars
    }

    /// Whether a name can be that of a scalar's grid; says what keeps it from that.
    fn check_name(&self, Entry { key, key_span, .. }: &Entry) -> bool {
        let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
        let problem = if keys::GRIDS.contains(&key.as_str()) {
            Diagnostic::error(*key_span, format!("`{key}` is the name of another grid")).help("choose another name")
        } else if !key.chars().all(is_name) || key.starts_with(|c: char| c.is_ascii_digit()) || key.is_empty() {
            Diagnostic::error(*key_span, format!("`{}` cannot be the name of a grid", clip(key)))
                .help("letters, digits and _, no digit first: what programs take as an attribute's name")
        } else {
            return true;
        };
        self.reader.say(problem);
        false
    }

    /// A number, formula, keys, or a table that makes one of them here and there.
    fn scalar(&mut self, path: &str, value: &'r Value, host: Host) -> Option<ShapeScalar> {
        let formula = |component| given(Argument::Components(vec![component]), value.span);
        if let Some(text) = value.text() {
            return self
                .reader
                .formula_of_space(text, value.span)
                .map(|of_space| formula(Component::Formula(of_space)));
        }
        let is_frame = |entry: &Entry| entry.key == "ease" || entry.key.parse::<f64>().is_ok();
        let table = match &value.data {
            Data::Table(table) if !table.0.iter().all(is_frame) || table.0.is_empty() => table,
            _ => {
                let number = self.reader.number(path, Limit::Any, value);
                return Some(match number.value {
                    NumberValue::Constant(constant) => given(Argument::Numbers(vec![constant as f32]), value.span),
                    _ => formula(Component::Number(number)),
                });
            }
        };
        self.given(path, value, table, &table::SCALAR, host)
    }

    /// A number that stands still.
    pub(super) fn one(&self, path: &str, value: &Value) -> [f32; 1] {
        [self.reader.constant(path, Limit::Any, value) as f32]
    }

    /// Numbers to choose from.
    pub(super) fn several(&self, path: &str, value: &Value) -> Option<Vec<f32>> {
        match value.list() {
            Some([]) | None => {
                self.reader.wrong_kind(path, "a list of numbers", value);
                None
            }
            Some(list) => Some(list.iter().map(|value| self.one(path, value)[0]).collect()),
        }
    }

    /// Two numbers to choose between.
    pub(super) fn two_numbers(&self, path: &str, value: &Value) -> Option<Vec<f32>> {
        match value.list() {
            Some([from, to]) => Some(vec![self.one(path, from)[0], self.one(path, to)[0]]),
            _ => {
                self.reader.wrong_kind(path, "a list of two numbers", value);
                None
            }
        }
    }
}

/// A scalar written without a table.
fn given(value: Argument, span: Span) -> ShapeScalar {
    ShapeScalar { source: &VALUE, arguments: Arguments(vec![("value", value)]), span }
}
