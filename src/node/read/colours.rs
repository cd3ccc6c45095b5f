//! Colours, palettes and names of both.

use crate::attribute::{Components, LinearRgb};

use super::{Building, Host, family};
use crate::node::argument::{Argument, Arguments};
use crate::node::direct::SRGB;
use crate::node::list;
use crate::node::model::{Component, ShapeColour};
use crate::node::source::{Given, Source};
use crate::node::table::{self, Family};
use crate::text::colour::{constant, css, limits, not_a_colour};
use crate::text::diagnostic::{Diagnostic, clip, listed};
use crate::text::files::{self, FileReference};
use crate::text::key::{Key, Kind, Limit};
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
            self.enter(&entry.key);
            self.palette(&format!("palette.{}", entry.key), &entry.value);
        }
        for entry in self.named_colours() {
            self.enter(&entry.key);
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
    pub(super) fn solid(&self, path: &str, value: &Value) -> Option<LinearRgb> {
        match &value.data {
            Data::Text(text) => {
                let called = |name: &str| {
                    let name = self.global(name);
                    self.named_colours().find(|entry| entry.key == name)
                };
                if let Some(entry) = called(text).filter(|entry| entry.value.span != value.span)
                    && !matches!(&entry.value.data, Data::Text(other) if called(other).is_some())
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
                let is_plain = |source: &&'static Source<3>| matches!(source.key.kind, Kind::Components(_));
                let named = |entry: &Entry| list::COLOURS.iter().find(|source| source.key.is_called(&entry.key));
                if let Some(entry) = table.0.iter().find(|entry| named(entry).is_some_and(|source| !is_plain(&source)))
                {
                    let problem = format!("`{}` is for the `color` of a shape only", entry.key);
                    self.reader.say(Diagnostic::error(entry.key_span, problem));
                    return None;
                }
                let plain: Vec<&'static Key> =
                    list::COLOURS.iter().filter(is_plain).map(|source| &source.key).collect();
                let fields = Fields::new(self.reader, path, table::COLOUR.owner, value.span, table, plain.clone());
                let mut given = plain.into_iter().filter(|key| fields.entry(key.name).is_some());
                match (given.next(), given.next()) {
                    (Some(Key { name, kind: Kind::Components(meaning), .. }), None) => {
                        constant(self.reader, &fields.full(name), fields.value(name)?, *meaning)
                    }
                    (Some(_), Some(_)) => {
                        self.reader.say(two_makers(path, table, list::COLOURS));
                        None
                    }
                    _ => {
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

    /// A shape's colour.
    pub(super) fn shape_colour(&mut self, path: &str, value: &'r Value, host: Host) -> Option<ShapeColour> {
        match value.table() {
            Some(table) => self.given(path, value, table, &table::COLOUR, host),
            None => {
                let arguments = Arguments(vec![("srgb", self.components(path, value, Components::Srgb)?)]);
                Some(ShapeColour { source: &SRGB, arguments, span: value.span })
            }
        }
    }

    /// An attribute written as a table, of whose keys one says where it comes from.
    pub(super) fn given<const N: usize>(
        &mut self,
        path: &str,
        value: &'r Value,
        table: &'r Table,
        family: &Family<N>,
        host: Host,
    ) -> Option<Given<N>> {
        let source = self.source_of(path, value, table, family)?;
        let fields = Fields::new(self.reader, path, family.owner, value.span, table, source.keys().collect());
        let arguments = self.arguments(source.keys(), &fields, host.id);
        if let Some(problem) = (source.check)(&fields, host.has_cells) {
            self.reader.say(problem);
            return None;
        }
        Some(Given { source, arguments: arguments?, span: fields.main_span() })
    }

    /// The one source that a table names, or the error that names them all.
    fn source_of<const N: usize>(
        &self,
        path: &str,
        value: &Value,
        table: &'r Table,
        Family { sources, owner, noun }: &Family<N>,
    ) -> Option<&'static Source<N>> {
        let mut found = sources.iter().filter(|source| table.0.iter().any(|entry| source.key.is_called(&entry.key)));
        match (found.next(), found.next()) {
            (Some(source), None) => return Some(source),
            (Some(_), Some(_)) => self.reader.say(two_makers(path, table, sources)),
            _ => {
                let known: Vec<_> = sources.iter().flat_map(Source::keys).collect();
                let unknown = table.0.iter().any(|entry| !known.iter().any(|key| key.is_called(&entry.key)));
                Fields::new(self.reader, path, *owner, value.span, table, known);
                if !unknown {
                    let names: Vec<&str> = sources.iter().map(|source| source.key.name).collect();
                    let problem = format!("`{}` says no {noun}", clip(path));
                    let problem = Diagnostic::error(value.span, problem);
                    self.reader.say(problem.help(format!("give it one of {}", listed(&names))));
                }
            }
        }
        None
    }

    /// A colour of three numbers, each of which may be a formula or keys; or one that is written otherwise.
    pub(super) fn components(&self, path: &str, value: &'r Value, meaning: Components) -> Option<Argument> {
        let varies = |list: &[Value]| list.iter().any(|part| matches!(part.data, Data::Text(_) | Data::Table(_)));
        if !value.list().is_some_and(varies) {
            return match meaning {
                Components::Srgb => self.solid(path, value),
                _ => constant(self.reader, path, value, meaning),
            }
            .map(Argument::Colour);
        }
        let three = self.reader.three(path, value)?;
        let limits = limits(meaning);
        let component = |i: usize| match three[i].text() {
            None => Some(Component::Number(self.reader.number(&format!("{path}[{i}]"), limits[i], &three[i]))),
            Some(text) => self.reader.formula_of_space(text, three[i].span).map(Component::Formula),
        };
        // All are read, so that all errors come together.
        let [a, b, c] = [component(0), component(1), component(2)];
        Some(Argument::Components(vec![a?, b?, c?]))
    }

    /// Three numbers or formulas of space.
    pub(super) fn formulas(&self, path: &str, value: &'r Value) -> Option<Vec<Component>> {
        let three = self.reader.three(path, value)?;
        let component = |i: usize| match three[i].text() {
            None => Some(Component::Number(self.reader.number(&format!("{path}[{i}]"), Limit::Any, &three[i]))),
            Some(text) => self.reader.formula_of_space(text, three[i].span).map(Component::Formula),
        };
        // All are read, so that all errors come together.
        let all = [component(0), component(1), component(2)];
        all.into_iter().collect()
    }

    /// The file that a key names; it is there.
    pub(super) fn file(&self, key: &str, fields: &Fields<'r, 'a>) -> Option<FileReference> {
        let value = fields.value(key)?;
        let Some(text) = value.text() else {
            self.reader.wrong_kind(&fields.full(key), "a file's name", value);
            return None;
        };
        let base = self.surroundings.namespaces.base(value.span).unwrap_or(&self.surroundings.base);
        match files::find(text, value.span, base, &self.surroundings.variables) {
            Ok(file) => Some(file),
            Err(problem) => {
                self.reader.say(problem);
                None
            }
        }
    }

    /// A palette's name, or colours.
    pub(super) fn named_palette(&self, path: &str, value: &'r Value) -> Option<Vec<LinearRgb>> {
        let Some(name) = value.text() else { return self.palette(path, value) };
        let palettes = family(self.root, "palette").map(|entry| (entry.key.as_str(), &entry.value)).collect();
        let found = self.resolve("palette", &palettes, value, path)?;
        // Its problems were said where it stands.
        let quiet = Reader::new(self.reader.sources, self.reader.scope());
        let mut silent = Building::new(&quiet, self.surroundings, self.root, self.seed, self.shot);
        silent.enter(&self.global(name));
        silent.palette(name, found)
    }

    /// Two colours.
    pub(super) fn two_colours(&self, path: &str, value: &'r Value) -> Option<Vec<LinearRgb>> {
        match value.list() {
            Some([from, to]) => {
                let (from, to) = (self.solid(&format!("{path}[0]"), from), self.solid(&format!("{path}[1]"), to));
                Some(vec![from?, to?])
            }
            _ => {
                self.reader.wrong_kind(path, "a list of two colours", value);
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
                let (problem, help) = if wanted.starts_with("[depth") {
                    let problem =
                        format!("`{}` begins at {begin}, not below the band before it, {}", clip(&path), last.0);
                    (problem, "depths rise from one band to the next")
                } else {
                    let problem = format!("`{}` is at {begin}, not after the stop before it, {}", clip(&path), last.0);
                    (problem, "stops rise from one to the next")
                };
                self.reader.say(Diagnostic::error(depth.span, problem).help(help));
                return None;
            }
            bands.push((begin, read(&path, there)?));
        }
        Some(bands)
    }
}

/// The error about a table with two makers of the same family.
fn two_makers<const N: usize>(path: &str, table: &Table, sources: &[Source<N>]) -> Diagnostic {
    let is_maker = |entry: &&Entry| sources.iter().any(|source| source.key.is_called(&entry.key));
    let mut found = table.0.iter().filter(is_maker);
    let (first, second) = (found.next(), found.next());
    let name = |entry: Option<&Entry>| entry.map_or_else(String::new, |entry| entry.key.clone());
    let span = second.map_or_else(Span::default, |entry| entry.key_span);
    let problem = format!("`{}` and `{}` both say what `{}` is", name(first), name(second), clip(path));
    Diagnostic::error(span, problem)
}
