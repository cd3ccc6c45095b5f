//! Scalars that move a surface, and those that mix what fills a solid.

use std::collections::BTreeSet;

use super::Building;
use crate::node::argument::Arguments;
use crate::node::keys;
use crate::node::model::{Fill, Morph, ScalarName, ShapeId};
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::reader::{Fields, NO_OWNER};
use crate::text::value::Value;

impl<'r, 'a> Building<'r, 'a> {
    /// The scalar that a key names; whether there is one is checked once all shapes are read.
    pub(super) fn scalar_name(&self, fields: &Fields<'r, 'a>, key: &str) -> Option<ScalarName> {
        let value = fields.value(key)?;
        let Some(name) = value.text() else {
            let problem = format!("`{}` must be the name of an attribute", clip(&fields.full(key)));
            let given = if value.number().is_some() { self.reader.sources.text(value.span) } else { "0.1" };
            let help = format!("give the shape one, attribute.bumps = {}, and name it: {key} = \"bumps\"", clip(given));
            let label = format!("this is {}", value.kind());
            self.reader.say(Diagnostic::error(value.span, problem).label(label).help(help));
            return None;
        };
        Some(ScalarName { name: name.into(), span: value.span })
    }

    /// `{ mix = [shape, shape], by = attribute }`.
    pub(super) fn fill(&mut self, value: &'r Value) -> Option<Fill> {
        let keys = keys::FILL.iter().collect();
        let fields = Fields::of_value(self.reader, "morph.fill", NO_OWNER, value.span, value, keys)?;
        let by = self.scalar_name(&fields, "by");
        let mix = fields.value("mix")?;
        let Some([a, b]) = mix.list() else {
            self.reader.wrong_kind("morph.fill.mix", "a list of two shapes", mix);
            return None;
        };
        let structures = [a, b].map(|value| self.shape_reference("morph.fill.mix", value));
        Some(Fill { structures: [structures[0]?, structures[1]?], by: by? })
    }

    /// Says of each shape whether it has the scalar that it is moved by.
    pub(super) fn check_displacements(&self) {
        for (place, shape) in self.shapes.iter().enumerate() {
            let Some(shape) = shape else { continue };
            for by in shape.all_arguments().flat_map(Arguments::scalars) {
                self.check_name_of_scalar(by, &[ShapeId(place)]);
            }
        }
    }

    /// Says whether the objects of a chain have the scalars that their morph uses.
    pub(super) fn check_morph_scalars(&self, morphs: &[Morph]) {
        let objects: Vec<ShapeId> = morphs.iter().flat_map(|morph| [morph.from, morph.to]).collect();
        let Morph { displace, fill, .. } = &morphs[0];
        for by in displace.iter().chain(fill.iter().map(|fill| &fill.by)) {
            self.check_name_of_scalar(by, &objects);
        }
        let Some(by) = displace else { return };
        let moved = |id: &ShapeId| {
            let shape = self.shapes[id.0].as_ref()?;
            shape.all_arguments().flat_map(Arguments::scalars).any(|own| own.name == by.name).then_some(shape)
        };
        if let Some(shape) = objects.iter().find_map(moved) {
            let problem = format!("`{}` moves the surface of `{}` already", clip(&by.name), clip(&shape.name));
            let help =
                "leave one `displace` out: the shape's, and the morph moves what it makes of both; or the morph's";
            self.reader.say(Diagnostic::error(by.span, problem).help(help));
        }
    }

    fn check_name_of_scalar(&self, by: &ScalarName, shapes: &[ShapeId]) {
        let known = self.scalars_of(shapes);
        if known.contains(by.name.as_str()) {
            return;
        }
        let problem = Diagnostic::error(by.span, format!("there is no `attribute.{}` here", clip(&by.name)));
        self.reader.say(if known.is_empty() {
            problem.help(format!("give the shape one, such as attribute.{} = 0.05", clip(&by.name)))
        } else {
            problem.suggest(&by.name, known)
        });
    }

    /// The scalars of some shapes and of all that they are made from.
    fn scalars_of(&self, shapes: &[ShapeId]) -> BTreeSet<&str> {
        let mut found: Vec<ShapeId> = shapes.to_vec();
        let mut next = 0;
        while let Some(id) = found.get(next).copied() {
            next += 1;
            let Some(shape) = &self.shapes[id.0] else { continue };
            for part in shape.painters() {
                if !found.contains(part) {
                    found.push(*part);
                }
            }
        }
        let shapes = found.into_iter().filter_map(|id| self.shapes[id.0].as_ref());
        shapes.flat_map(|shape| shape.scalars.keys().map(String::as_str)).collect()
    }
}
