//! Which part of a morph's first object becomes which of the second, and so on along a chain.

use super::Building;
use super::chain::Link;
use crate::attribute::Overlap;
use crate::node::argument::Argument;
use crate::node::model::{Correspondence, Master, Modifier, Pairs, ShapeId};
use crate::node::spec::Carries;
use crate::text::diagnostic::{Diagnostic, clip, listed};
use crate::text::number::NumberValue;
use crate::text::reader::Fields;
use crate::text::source::Span;
use crate::text::value::Value;

/// One of the objects: where it stands in `[morph]`, its name, its parts.
#[derive(Clone)]
struct Whole<'s> {
    key: &'static str,
    name: String,
    parts: &'s [ShapeId],
}

impl Whole<'_> {
    /// Its place in words.
    fn place(&self) -> String {
        match self.key {
            "through" => "in `morph.through`".into(),
            key => format!("`morph.{key}`"),
        }
    }
}

impl<'r, 'a> Building<'r, 'a> {
    /// One for each link of the chain; `None` where there is none, or where an error was said.
    pub(super) fn correspondence(
        &self,
        fields: &Fields<'r, 'a>,
        chain: Option<&[Link]>,
    ) -> Option<Vec<Correspondence>> {
        if fields.entry("pairs").is_none() {
            for entry in ["overlap", "master", "master_color"].into_iter().filter_map(|name| fields.entry(name)) {
                self.reader.say(Diagnostic::error(entry.key_span, format!("`{}` goes with `pairs`", entry.key)));
            }
            return None;
        }
        let value = fields.value("pairs")?;
        let overlap = if fields.choice("overlap") == Some("mix") { Overlap::Mix } else { Overlap::Priority };
        let master = fields.value("master");
        let colour = fields.value("master_color").and_then(|value| self.solid("morph.master_color", value));
        let chain = chain?;
        let wholes = self.wholes(fields, chain)?;
        if value.text() == Some("auto") {
            if let Some(entry) = fields.entry("master") {
                let problem = Diagnostic::error(entry.key_span, "`master` is for pairs that are named");
                self.reader
                    .say(problem.help("what `pairs = \"auto\"` finds is in the notes of `hfvdb check`: name those"));
            }
            let of_link = |two: &[Whole<'_>; 2]| Correspondence {
                pairs: Pairs::Nearest(two.each_ref().map(|whole| whole.parts.to_vec())),
                overlap,
                master: colour.map(Master::Colour),
            };
            return Some(wholes.array_windows().map(of_link).collect());
        }
        let rows = self.rows(value, &wholes)?;
        if let (Some(_), Some(entry)) = (master, fields.entry("master_color")) {
            let problem = "`master` and `master_color` both say what holds where none of `pairs` is";
            self.reader.say(Diagnostic::error(entry.key_span, problem).help("leave one of them out"));
            return None;
        }
        let master = match master {
            Some(value) => Some(Master::Pair(self.master(value, &rows)?)),
            None => colour.map(Master::Colour),
        };
        let of_link = |link| Correspondence {
            pairs: Pairs::Named(rows.iter().map(|row| [row[link], row[link + 1]]).collect()),
            overlap,
            master,
        };
        Some((0..chain.len()).map(of_link).collect())
    }

    /// The objects of a chain in order of time.
    fn wholes(&self, fields: &Fields<'r, 'a>, chain: &[Link]) -> Option<Vec<Whole<'_>>> {
        let keys: &[&'static str] = if fields.entry("through").is_some() { &["through"] } else { &["from", "to"] };
        let shapes = std::iter::once(chain[0].from).chain(chain.iter().map(|link| link.to));
        let mut known: Vec<(ShapeId, Option<Whole<'_>>)> = Vec::new();
        for (id, key) in shapes.zip(keys.iter().cycle()) {
            // What is wrong with an object that a chain shows twice is said once.
            let before = known.iter().find(|(other, _)| *other == id).map(|(_, whole)| whole.clone());
            known.push((id, before.unwrap_or_else(|| self.whole(fields, key, id))));
        }
        known.into_iter().map(|(_, whole)| whole).collect()
    }

    /// An object whose parts can be told apart in every frame: a union that is not changed after it is made.
    fn whole(&self, fields: &Fields<'r, 'a>, key: &'static str, id: ShapeId) -> Option<Whole<'_>> {
        let shape = self.shapes[id.0].as_ref()?;
        let name = clip(&shape.name);
        if shape.spec.carries != Carries::Union {
            let span = fields.entry(key).map_or(shape.span, |entry| entry.value.span);
            let problem = format!("`{name}` is no union, so it has no parts for `pairs`");
            self.reader.say(Diagnostic::error(span, problem).help("union = [\"head\", \"body\"]"));
            return None;
        }
        // A cut leaves the parts as they are.
        let changes = |modifier: &&Modifier| {
            // By its main value: that of another key may be 0 and change nothing of what is done.
            match modifier.arguments.get(modifier.spec.key.name) {
                Some(Argument::Box(_)) => false,
                Some(Argument::Number(by)) => !matches!(by.value, NumberValue::Constant(0.0)),
                _ => true,
            }
        };
        for modifier in shape.modifiers.iter().filter(changes).map(|modifier| modifier.spec.key.name) {
            let problem = format!("`{name}` has a `{modifier}`, so its parts cannot be told apart for `pairs`");
            self.reader.say(Diagnostic::error(shape.span, problem).help(format!("give its parts the `{modifier}`")));
        }
        let scalars = shape.scalars.keys().map(|name| format!("attribute.{name}"));
        for own in shape.colour.iter().map(|_| "color".into()).chain(scalars) {
            let problem = format!("`{name}` has its own `{own}`, which hides those of its parts from `pairs`");
            self.reader.say(Diagnostic::error(shape.span, problem).help("give it to the parts"));
        }
        Some(Whole { key, name: name.into(), parts: shape.painters() })
    }

    /// Parts that become one another, each list with one of each object.
    fn rows(&self, value: &Value, wholes: &[Whole<'_>]) -> Option<Vec<Vec<ShapeId>>> {
        let wanted = "\"auto\", or a list of pairs, such as [[\"head\", \"lid\"], [\"body\", \"bowl\"]]";
        let Some(list) = value.list().filter(|list| !list.is_empty()) else {
            self.reader.wrong_kind("morph.pairs", wanted, value);
            return None;
        };
        let mut rows: Vec<Vec<ShapeId>> = Vec::new();
        let mut whole = true;
        for item in list {
            let Some(parts) = item.list().filter(|parts| parts.len() == wholes.len()) else {
                let problem = match wholes.len() {
                    2 => "`morph.pairs` takes pairs: a part of the first object and one of the second".into(),
                    count => format!("`morph.pairs` takes lists of {count}: a part of each shape of `through`"),
                };
                self.reader.say(Diagnostic::error(item.span, problem));
                return None;
            };
            let part = |(side, value): (usize, &Value)| {
                let part = self.part(value, &wholes[side])?;
                if rows.iter().any(|row| row[side] == part) {
                    let problem = format!("`{}` is in two pairs", clip(self.part_name(part)));
                    self.reader.say(Diagnostic::error(value.span, problem));
                    return None;
                }
                Some(part)
            };
            let row: Vec<Option<ShapeId>> = parts.iter().enumerate().map(part).collect();
            match row.into_iter().collect() {
                Some(row) => rows.push(row),
                None => whole = false,
            }
        }
        // A name that is wrong is missing elsewhere too: once is enough.
        (whole && self.all_are_paired(value.span, &rows, wholes)).then_some(rows)
    }

    fn part(&self, value: &Value, whole: &Whole<'_>) -> Option<ShapeId> {
        let part = self.resolve("shape", &self.shape_ids, value, "morph.pairs")?;
        if whole.parts.contains(&part) {
            return Some(part);
        }
        let names: Vec<&str> = whole.parts.iter().map(|part| self.part_name(*part)).collect();
        let part = clip(self.part_name(part));
        let problem = format!("`{part}` is no part of `{}`, which is {}", whole.name, whole.place());
        self.reader.say(Diagnostic::error(value.span, problem).help(format!("its parts are {}", listed(&names))));
        None
    }

    fn all_are_paired(&self, span: Span, rows: &[Vec<ShapeId>], wholes: &[Whole<'_>]) -> bool {
        let mut all = true;
        for (side, whole) in wholes.iter().enumerate() {
            for part in whole.parts.iter().filter(|part| !rows.iter().any(|row| row[side] == **part)) {
                let problem = format!("`{}`, a part of `{}`, is in no pair", clip(self.part_name(*part)), whole.name);
                let help = "each part of the one object needs one of the other: a union may join several into one";
                self.reader.say(Diagnostic::error(span, problem).help(help));
                all = false;
            }
        }
        all
    }

    /// The pair that a part names.
    fn master(&self, value: &Value, rows: &[Vec<ShapeId>]) -> Option<usize> {
        let part = self.resolve("shape", &self.shape_ids, value, "morph.master")?;
        let found = rows.iter().position(|row| row.contains(&part));
        if found.is_none() {
            let names: Vec<&str> = rows.iter().map(|row| self.part_name(row[0])).collect();
            let part = clip(self.part_name(part));
            let problem = format!("`morph.master` is `{part}`, which is in none of `pairs`");
            self.reader.say(Diagnostic::error(value.span, problem).help(format!("name one of {}", listed(&names))));
        }
        found
    }

    fn part_name(&self, id: ShapeId) -> &str {
        self.shapes[id.0].as_ref().map_or("", |shape| &shape.name)
    }
}
