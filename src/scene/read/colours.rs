//! Colours, palettes and names of both.

use crate::attribute::LinearRgb;

use super::super::colour::{css, linear_list, not_a_colour, srgb_list};
use super::super::diagnostic::{Diagnostic, clip};
use super::super::keys;
use super::super::model::ShapeColour;
use super::super::reader::Fields;
use super::super::value::{Data, Value};
use super::{Building, family};

impl<'r, 'a> Building<'r, 'a> {
    /// Says what is wrong with palettes and named colours, used or not.
    pub(super) fn palettes(&mut self) {
        for name in ["palette", "color", "colour"] {
            self.must_be_table(name);
        }
        for entry in family(self.root, "palette") {
            self.palette(&format!("palette.{}", entry.key), &entry.value);
        }
        for entry in self.named_colours() {
            self.solid(&format!("color.{}", entry.key), &entry.value);
        }
    }

    fn named_colours(&self) -> impl Iterator<Item = &'r super::Entry> + use<'r, 'a> {
        family(self.root, "color").chain(family(self.root, "colour"))
    }

    fn palette(&self, path: &str, value: &Value) -> Option<Vec<LinearRgb>> {
        match value.list() {
            Some([]) | None => {
                self.reader.wrong_kind(path, "a list of colours", value);
                None
            }
            Some(list) => {
                let colours: Vec<_> =
                    list.iter().enumerate().map(|(i, value)| self.solid(&format!("{path}[{i}]"), value)).collect();
                colours.into_iter().collect()
            }
        }
    }

    /// One colour that is the same everywhere.
    fn solid(&self, path: &str, value: &Value) -> Option<LinearRgb> {
        match &value.data {
            Data::Text(text) => {
                let named = self.named_colours().find(|entry| entry.key == *text && entry.value.span != value.span);
                if let Some(entry) = named
                    && !matches!(&entry.value.data, Data::Text(other) if self.named_colours().any(|entry| entry.key == *other))
                {
                    return self.solid(&format!("color.{text}"), &entry.value);
                }
                let colour = css(text);
                if colour.is_none() {
                    let names: Vec<String> = self.named_colours().map(|entry| entry.key.clone()).collect();
                    self.reader.say(not_a_colour(text, value, &names));
                }
                colour
            }
            Data::List(_) => srgb_list(self.reader, path, value),
            Data::Table(table) => {
                let keys = keys::COLOUR.iter().filter(|key| key.name == "linear").collect();
                let fields = Fields::new(self.reader, path, "color", value.span, table, keys);
                let linear = fields.value("linear");
                if linear.is_none() && table.0.is_empty() {
                    self.reader.say(not_a_colour("{}", value, &[]));
                }
                linear_list(self.reader, path, linear?)
            }
            _ => {
                self.reader.wrong_kind(path, "a colour", value);
                None
            }
        }
    }

    /// A shape's colour. `has_cells`: whether the shape has cells that can take colours of a palette.
    pub(super) fn shape_colour(&self, path: &str, value: &'r Value, has_cells: bool) -> Option<ShapeColour> {
        let Some(table) = value.table().filter(|table| table.get("linear").is_none()) else {
            return self.solid(path, value).map(ShapeColour::Solid);
        };
        let fields = Fields::new(self.reader, path, "color", value.span, table, keys::COLOUR.iter().collect());
        let Some(palette) = fields.value("palette") else {
            if table.0.iter().all(|entry| keys::COLOUR.iter().any(|key| key.is_called(&entry.key))) {
                let problem = format!("`{}` says no colour", clip(path));
                self.reader.say(Diagnostic::error(value.span, problem).help("give it `linear` or `palette`"));
            }
            return None;
        };
        fields.choice("by");
        let seed = self.seed_of(fields.whole("seed"), path);
        if !has_cells {
            let problem = "only a shape with `facet` or `at` has cells to take colours";
            self.reader.say(Diagnostic::error(palette.span, problem));
        }
        let colours = match palette.text() {
            None => self.palette(&fields.full("palette"), palette),
            Some(name) => {
                let palettes = family(self.root, "palette").map(|entry| (entry.key.as_str(), &entry.value)).collect();
                let value = self.resolve("palette", &palettes, palette, &fields.full("palette"))?;
                // Its problems were said where it stands.
                let quiet = super::Reader::new(self.reader.sources, self.reader.names.clone());
                let silent = Building::new(&quiet, self.surroundings, self.root, self.seed);
                silent.palette(name, value)
            }
        };
        colours.map(|palette| ShapeColour::ByCell { palette, seed })
    }
}
