//! Scalars of shapes: the table of `attribute`.

use std::collections::BTreeMap;

use crate::attribute::{Choice, Straight};

use super::Building;
use crate::node::keys::{self};
use crate::node::model::{Component, ShapeId, ShapeScalar};
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::formula::Formula;
use crate::text::key::Limit;
use crate::text::number::NumberValue;
use crate::text::reader::Fields;
use crate::text::value::{Data, Entry, Value};

impl<'r, 'a> Building<'r, 'a> {
    /// `attribute.NAME = …`, as many as there are.
    pub(super) fn scalars(
        &mut self,
        path: &str,
        value: &'r Value,
        id: ShapeId,
        has_cells: bool,
        may_nest: bool,
    ) -> BTreeMap<String, ShapeScalar> {
        let Some(table) = value.table() else {
            self.reader.wrong_kind(path, "a table", value);
            return BTreeMap::new();
        };
        let mut scalars = BTreeMap::new();
        for entry in &table.0 {
            let name_is_sound = self.check_name(entry);
            let scalar = self.scalar(&format!("{path}.{}", entry.key), &entry.value, id, has_cells, may_nest);
            if name_is_sound {
                // One that is wrong was said; those who name it are not.
                scalars.insert(entry.key.clone(), scalar.unwrap_or(ShapeScalar::Solid([0.0])));
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
    fn scalar(
        &mut self,
        path: &str,
        value: &'r Value,
        id: ShapeId,
        has_cells: bool,
        may_nest: bool,
    ) -> Option<ShapeScalar> {
        let formula =
            |component| ShapeScalar::Formula { components: Box::new([component]), meaning: (), span: value.span };
        if let Some(text) = value.text() {
            return match Formula::of_space(text, self.reader.names.clone()) {
                Ok(of_space) => Some(formula(Component::Formula(of_space))),
                Err(problems) => {
                    self.reader.say_all(problems, value.span, text);
                    None
                }
            };
        }
        let is_frame = |entry: &Entry| entry.key == "ease" || entry.key.parse::<f64>().is_ok();
        let table = match &value.data {
            Data::Table(table) if !table.0.iter().all(is_frame) || table.0.is_empty() => table,
            _ => {
                let number = self.reader.number(path, Limit::Any, value);
                return Some(match number.value {
                    NumberValue::Constant(constant) => ShapeScalar::Solid([constant as f32]),
                    _ => formula(Component::Number(number)),
                });
            }
        };
        let maker = self.attribute_maker(path, value, table, "attribute", keys::SCALARS)?;
        let keys = std::iter::once(&maker.key).chain(maker.parameters).collect();
        let fields = Fields::new(self.reader, path, keys::scalar_owner, value.span, table, keys);
        let main = fields.value(maker.key.name)?;
        let full = fields.full(maker.key.name);
        match maker.key.name {
            "bands" => {
                let one = |path: &str, value: &'r Value| Some(self.one(path, value));
                self.bands(&full, main, "[depth, number]", one).map(ShapeScalar::Bands)
            }
            "parts" => {
                let shapes = self.operands("parts", 1, &fields, id, may_nest);
                let seam = fields.constant("seam").unwrap_or(0.0);
                Some(ShapeScalar::Parts { shapes: shapes?, seam })
            }
            "vdb" => {
                let name = path.rsplit('.').next().unwrap_or(path);
                self.voxels(&fields, name).map(ShapeScalar::Voxels)
            }
            name => {
                let by = self.pieces(&fields, main.span, has_cells);
                let seed = self.seed_of(fields.whole("seed"), path);
                let choice = if name == "values" { self.values(&full, main) } else { self.ends(&full, main) };
                Some(ShapeScalar::Random { choice: choice?, by: by?, seed })
            }
        }
    }

    /// A number that stands still.
    fn one(&self, path: &str, value: &Value) -> [f32; 1] {
        [self.reader.constant(path, Limit::Any, value) as f32]
    }

    /// Numbers to choose from.
    fn values(&self, path: &str, value: &Value) -> Option<Choice<1, Straight>> {
        match value.list() {
            Some([]) | None => {
                self.reader.wrong_kind(path, "a list of numbers", value);
                None
            }
            Some(list) => Some(Choice::Palette(list.iter().map(|value| self.one(path, value)).collect())),
        }
    }

    /// Two numbers to choose between.
    fn ends(&self, path: &str, value: &Value) -> Option<Choice<1, Straight>> {
        match value.list() {
            Some([from, to]) => {
                Some(Choice::Range { from: self.one(path, from), to: self.one(path, to), mix: Straight })
            }
            _ => {
                self.reader.wrong_kind(path, "a list of two numbers", value);
                None
            }
        }
    }
}
