//! Colours, palettes and names of both.

use crate::attribute::{Choice, ColourSpace, Components, LinearRgb, Mixer, Outside, Power};

use super::{Building, family};
use crate::node::keys::{self};
use crate::node::model::{Component, Pieces, ShapeColour, ShapeId, VoxelSource};
use crate::text::colour::{constant, css, limits, not_a_colour};
use crate::text::diagnostic::{Diagnostic, clip, listed};
use crate::text::files::{self, FileReference};
use crate::text::formula::Formula;
use crate::text::key::Limit;
use crate::text::reader::{Fields, Reader};
use crate::text::source::Span;
use crate::text::value::{Data, Entry, Table, Value};

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

    fn named_colours(&self) -> impl Iterator<Item = &'r Entry> + use<'r, 'a> {
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
            Data::List(_) => constant(self.reader, path, value, Components::Srgb),
            Data::Table(table) => {
                let elsewhere = |entry: &&Entry| !PLAIN.iter().any(|(name, _)| *name == entry.key);
                let known = |entry: &&Entry| keys::COLOURS.iter().any(|maker| maker.key.is_called(&entry.key));
                if let Some(entry) = table.0.iter().filter(elsewhere).find(known) {
                    let problem = format!("`{}` is for the `color` of a shape only", entry.key);
                    self.reader.say(Diagnostic::error(entry.key_span, problem));
                    return None;
                }
                let keys = keys::COLOURS.iter().map(|maker| &maker.key);
                let plain = keys.filter(|key| PLAIN.iter().any(|(name, _)| *name == key.name)).collect();
                let fields = Fields::new(self.reader, path, keys::colour_owner, value.span, table, plain);
                let mut given = PLAIN.iter().filter(|(name, _)| fields.entry(name).is_some());
                match (given.next(), given.next()) {
                    (Some((name, meaning)), None) => {
                        constant(self.reader, &fields.full(name), fields.value(name)?, *meaning)
                    }
                    (Some(_), Some(_)) => {
                        self.reader.say(two_makers(path, table, keys::COLOURS));
                        None
                    }
                    (None, _) => {
                        if table.0.is_empty() {
                            self.reader.say(not_a_colour("{}", value, &[]));
                        }
                        None
                    }
                }
            }
            _ => {
                self.reader.wrong_kind(path, "a colour", value);
                None
            }
        }
    }

    /// A shape's colour. `has_cells`: whether the shape has cells that can take colours; `may_nest`: whether shapes
    /// may be written in place in it.
    pub(super) fn shape_colour(
        &mut self,
        path: &str,
        value: &'r Value,
        id: ShapeId,
        has_cells: bool,
        may_nest: bool,
    ) -> Option<ShapeColour> {
        let Some(table) = value.table() else {
            return self.numbers(path, value, Components::Srgb);
        };
        let maker = self.attribute_maker(path, value, table, "color", keys::COLOURS)?;
        let keys = std::iter::once(&maker.key).chain(maker.parameters).collect();
        let fields = Fields::new(self.reader, path, keys::colour_owner, value.span, table, keys);
        let main = fields.value(maker.key.name)?;
        let full = fields.full(maker.key.name);
        if let Some((_, meaning)) = PLAIN.iter().find(|(name, _)| *name == maker.key.name) {
            return self.numbers(&full, main, *meaning);
        }
        match maker.key.name {
            "bands" => self
                .bands(&full, main, "[depth, colour]", |path, value| self.solid(path, value))
                .map(ShapeColour::Bands),
            "parts" => {
                let shapes = self.operands("parts", 1, &fields, id, may_nest);
                let seam = fields.constant("seam").unwrap_or(0.0);
                Some(ShapeColour::Parts { shapes: shapes?, seam })
            }
            "vdb" => self.voxels(&fields, "Cd").map(ShapeColour::Voxels),
            name => {
                let by = self.pieces(&fields, main.span, has_cells);
                let seed = self.seed_of(fields.whole("seed"), path);
                let choice =
                    if name == "palette" { self.named_palette(&full, main) } else { self.range(&fields, main) };
                Some(ShapeColour::Random { choice: choice?, by: by?, seed })
            }
        }
    }

    /// The one maker of the table of a colour or scalar, or the error that names them all.
    pub(super) fn attribute_maker(
        &self,
        path: &str,
        value: &Value,
        table: &'r Table,
        family: &str,
        makers: &'static [keys::Maker],
    ) -> Option<&'static keys::Maker> {
        let mut found = makers.iter().filter(|maker| table.0.iter().any(|entry| maker.key.is_called(&entry.key)));
        match (found.next(), found.next()) {
            (Some(maker), None) => return Some(maker),
            (Some(_), Some(_)) => self.reader.say(two_makers(path, table, makers)),
            _ => {
                let known: Vec<_> =
                    makers.iter().flat_map(|maker| std::iter::once(&maker.key).chain(maker.parameters)).collect();
                let unknown = table.0.iter().any(|entry| !known.iter().any(|key| key.is_called(&entry.key)));
                let owner = if family == "color" { keys::colour_owner } else { keys::scalar_owner };
                Fields::new(self.reader, path, owner, value.span, table, known);
                if !unknown {
                    let names: Vec<&str> = makers.iter().map(|maker| maker.key.name).collect();
                    let noun = if family == "color" { "colour" } else { "number" };
                    let problem = format!("`{}` says no {noun}", clip(path));
                    let problem = Diagnostic::error(value.span, problem);
                    self.reader.say(problem.help(format!("give it one of {}", listed(&names))));
                }
            }
        }
        None
    }

    /// A colour of three numbers, each of which may be a formula or keys; or one that is written otherwise.
    fn numbers(&self, path: &str, value: &'r Value, meaning: Components) -> Option<ShapeColour> {
        let varies = |list: &[Value]| list.iter().any(|part| matches!(part.data, Data::Text(_) | Data::Table(_)));
        if !value.list().is_some_and(varies) {
            return match meaning {
                Components::Srgb => self.solid(path, value),
                _ => constant(self.reader, path, value, meaning),
            }
            .map(ShapeColour::Solid);
        }
        let three = self.reader.three(path, value)?;
        let limits = limits(meaning);
        let component = |i: usize| match three[i].text() {
            None => Some(Component::Number(self.reader.number(&format!("{path}[{i}]"), limits[i], &three[i]))),
            Some(text) => match Formula::of_space(text, self.reader.names.clone()) {
                Ok(formula) => Some(Component::Formula(formula)),
                Err(problems) => {
                    self.reader.say_all(problems, three[i].span, text);
                    None
                }
            },
        };
        let [a, b, c] = [component(0), component(1), component(2)];
        Some(ShapeColour::Formula { components: Box::new([a?, b?, c?]), meaning, span: value.span })
    }

    /// A grid of a file, of this name where none is given.
    pub(super) fn voxels(&self, fields: &Fields<'r, 'a>, usual: &str) -> Option<VoxelSource> {
        let file = self.file("vdb", fields);
        let grid = fields.text("grid").unwrap_or_else(|| usual.to_owned());
        let outside = fields.choice("outside");
        let power = fields.whole("power");
        let outside = match (outside?, fields.entry("power")) {
            ("potential", _) => Outside::Potential(Power::new(u32::try_from(power?).ok()?)?),
            (_, None) => Outside::Foot,
            (_, Some(entry)) => {
                let problem = "`power` is for `outside = \"potential\"` only";
                self.reader.say(Diagnostic::error(entry.key_span, problem));
                return None;
            }
        };
        let file = file?;
        let grid_span = fields.entry("grid").map_or(file.span, |entry| entry.value.span);
        Some(VoxelSource { file, grid, grid_span, outside })
    }

    /// The file that a key names; it is there.
    pub(super) fn file(&self, key: &str, fields: &Fields<'r, 'a>) -> Option<FileReference> {
        let value = fields.value(key)?;
        let Some(text) = value.text() else {
            self.reader.wrong_kind(&fields.full(key), "a file's name", value);
            return None;
        };
        match files::find(text, value.span, &self.surroundings.base, &self.surroundings.variables) {
            Ok(file) => Some(file),
            Err(problem) => {
                self.reader.say(problem);
                None
            }
        }
    }

    /// What takes the values that are chosen at random.
    pub(super) fn pieces(&self, fields: &Fields<'r, 'a>, span: Span, has_cells: bool) -> Option<Pieces> {
        let by_voxel = fields.choice("by") == Some("voxel");
        let edge = fields.constant("voxel_size");
        let problem = match (by_voxel, fields.entry("voxel_size")) {
            (true, Some(_)) => return edge.map(Pieces::Cubes),
            (true, None) => {
                Diagnostic::error(span, format!("`{}` has no `voxel_size`", clip(&fields.path))).help("the cubes' edge")
            }
            (false, Some(entry)) => Diagnostic::error(entry.key_span, "`voxel_size` is for `by = \"voxel\"` only"),
            (false, None) if has_cells => return Some(Pieces::Cells),
            (false, None) => Diagnostic::error(span, "only a shape with `facet` or `at` has cells")
                .help("by = \"voxel\" with a `voxel_size` takes the cubes of a lattice"),
        };
        self.reader.say(problem);
        None
    }

    /// A palette's name, or colours.
    fn named_palette(&self, path: &str, value: &'r Value) -> Option<Choice<3, Mixer>> {
        let Some(name) = value.text() else { return self.palette(path, value).map(Choice::Palette) };
        let palettes = family(self.root, "palette").map(|entry| (entry.key.as_str(), &entry.value)).collect();
        let value = self.resolve("palette", &palettes, value, path)?;
        // Its problems were said where it stands.
        let quiet = Reader::new(self.reader.sources, self.reader.names.clone());
        let silent = Building::new(&quiet, self.surroundings, self.root, self.seed, self.up);
        silent.palette(name, value).map(Choice::Palette)
    }

    /// Two colours.
    fn range(&self, fields: &Fields<'r, 'a>, value: &'r Value) -> Option<Choice<3, Mixer>> {
        let path = fields.full("range");
        let space = fields.choice("color_space").and_then(ColourSpace::named);
        match value.list() {
            Some([from, to]) => {
                let (from, to) = (self.solid(&format!("{path}[0]"), from), self.solid(&format!("{path}[1]"), to));
                let (from, to) = (from?, to?);
                Some(Choice::Range { from, to, mix: Mixer::between(space?, from, to) })
            }
            _ => {
                self.reader.wrong_kind(&path, "a list of two colours", value);
                None
            }
        }
    }

    /// `[[0.0, "red"], [0.1, "#ffffff"]]`.
    pub(super) fn bands<const N: usize>(
        &self,
        path: &str,
        value: &'r Value,
        wanted: &str,
        read: impl Fn(&str, &'r Value) -> Option<[f32; N]>,
    ) -> Option<Vec<(f64, [f32; N])>> {
        let Some(list) = value.list().filter(|list| !list.is_empty()) else {
            self.reader.wrong_kind(path, &format!("a list of {wanted}"), value);
            return None;
        };
        let mut bands: Vec<(f64, [f32; N])> = Vec::with_capacity(list.len());
        for (i, band) in list.iter().enumerate() {
            let path = format!("{path}[{i}]");
            let Some([depth, there]) = band.list() else {
                self.reader.wrong_kind(&path, wanted, band);
                return None;
            };
            let begin = self.reader.constant(&path, Limit::Any, depth);
            if let Some(last) = bands.last().filter(|last| last.0 >= begin) {
                let problem = format!("`{}` begins at {begin}, not below the band before it, {}", clip(&path), last.0);
                self.reader.say(Diagnostic::error(depth.span, problem).help("depths rise from one band to the next"));
                return None;
            }
            bands.push((begin, read(&path, there)?));
        }
        Some(bands)
    }
}

/// Colours of three numbers, as tables.
const PLAIN: [(&str, Components); 2] = [("linear", Components::Linear), ("hsv", Components::Hsv)];

/// The error about a table with two makers of the same family.
fn two_makers(path: &str, table: &Table, makers: &[keys::Maker]) -> Diagnostic {
    let is_maker = |entry: &&Entry| makers.iter().any(|maker| maker.key.is_called(&entry.key));
    let mut found = table.0.iter().filter(is_maker);
    let (first, second) = (found.next(), found.next());
    let name = |entry: Option<&Entry>| entry.map_or_else(String::new, |entry| entry.key.clone());
    let span = second.map_or_else(Span::default, |entry| entry.key_span);
    let problem = format!("`{}` and `{}` both say what `{}` is", name(first), name(second), clip(path));
    Diagnostic::error(span, problem)
}
