//! Which part of a morph's first object becomes which of the second.

use super::super::diagnostic::{Diagnostic, clip, listed};
use super::super::model::{Correspondence, Maker, Modifiers, ShapeId};
use super::super::number::NumberValue;
use super::super::reader::Fields;
use super::super::source::Span;
use super::super::value::Value;
use super::Building;
use super::chain::Link;
use crate::attribute::Overlap;

/// One of the two objects: its key in `[morph]`, its name, its parts.
struct Whole<'s> {
    key: &'static str,
    name: String,
    parts: &'s [ShapeId],
}

impl<'r, 'a> Building<'r, 'a> {
    /// `None` where there is none, or where an error was said.
    pub(super) fn correspondence(&self, fields: &Fields<'r, 'a>, chain: Option<&[Link]>) -> Option<Correspondence> {
        let Some(entry) = fields.entry("pairs") else {
            for entry in ["overlap", "master"].into_iter().filter_map(|name| fields.entry(name)) {
                self.reader.say(Diagnostic::error(entry.key_span, format!("`{}` goes with `pairs`", entry.key)));
            }
            return None;
        };
        let value = fields.value("pairs")?;
        let mix = fields.choice("overlap") == Some("mix");
        let master = fields.value("master");
        if fields.entry("through").is_some() {
            let problem = Diagnostic::error(entry.key_span, "`pairs` does not go with `through`");
            self.reader.say(problem.help("it is for a morph of two objects, `from` and `to`"));
            return None;
        }
        let [link] = chain? else { return None };
        let (from, to) = (self.whole(fields, "from", link.from), self.whole(fields, "to", link.to));
        let wholes = [from?, to?];
        let pairs = self.pairs(value, &wholes)?;
        let master = match master {
            Some(value) => Some(self.master(value, &pairs)?),
            None => None,
        };
        Some(Correspondence { pairs, overlap: if mix { Overlap::Mix } else { Overlap::Priority }, master })
    }

    /// An object whose parts can be told apart in every frame: a union that is not changed after it is made.
    fn whole(&self, fields: &Fields<'r, 'a>, key: &'static str, id: ShapeId) -> Option<Whole<'_>> {
        let shape = self.shapes[id.0].as_ref()?;
        let name = clip(&shape.name);
        let Maker::Union { operands, .. } = &shape.maker else {
            let span = fields.entry(key).map_or(shape.span, |entry| entry.value.span);
            let problem = format!("`{name}` is no union, so it has no parts for `pairs`");
            self.reader.say(Diagnostic::error(span, problem).help("union = [\"head\", \"body\"]"));
            return None;
        };
        let Modifiers { at, mirror, offset, shell, displace, .. } = &shape.modifiers;
        let offset = !matches!(offset.value, NumberValue::Constant(0.0));
        let changes = [
            ("at", at.is_some()),
            ("mirror", mirror.is_some()),
            ("offset", offset),
            ("shell", shell.is_some()),
            ("displace", displace.is_some()),
        ];
        for (modifier, _) in changes.into_iter().filter(|(_, there)| *there) {
            let problem = format!("`{name}` has a `{modifier}`, so its parts cannot be told apart for `pairs`");
            self.reader.say(Diagnostic::error(shape.span, problem).help(format!("give its parts the `{modifier}`")));
        }
        let scalars = shape.scalars.keys().map(|name| format!("attribute.{name}"));
        for own in shape.colour.iter().map(|_| "color".into()).chain(scalars) {
            let problem = format!("`{name}` has its own `{own}`, which hides those of its parts from `pairs`");
            self.reader.say(Diagnostic::error(shape.span, problem).help("give it to the parts"));
        }
        Some(Whole { key, name: name.into(), parts: operands })
    }

    fn pairs(&self, value: &Value, wholes: &[Whole<'_>; 2]) -> Option<Vec<[ShapeId; 2]>> {
        let wanted = "a list of pairs, such as [[\"head\", \"lid\"], [\"body\", \"bowl\"]]";
        let Some(list) = value.list().filter(|list| !list.is_empty()) else {
            self.reader.wrong_kind("morph.pairs", wanted, value);
            return None;
        };
        let mut pairs: Vec<[ShapeId; 2]> = Vec::new();
        let mut whole = true;
        for item in list {
            let Some([one, two]) = item.list() else {
                let problem = "`morph.pairs` takes pairs: a part of the first object and one of the second";
                self.reader.say(Diagnostic::error(item.span, problem));
                return None;
            };
            let parts = [(one, 0), (two, 1)].map(|(value, side)| {
                let part = self.part(value, &wholes[side])?;
                if pairs.iter().any(|pair| pair[side] == part) {
                    let problem = format!("`{}` is in two pairs", clip(self.part_name(part)));
                    self.reader.say(Diagnostic::error(value.span, problem));
                    return None;
                }
                Some(part)
            });
            match parts {
                [Some(one), Some(two)] => pairs.push([one, two]),
                _ => whole = false,
            }
        }
        // A name that is wrong is missing elsewhere too: once is enough.
        (whole && self.all_are_paired(value.span, &pairs, wholes)).then_some(pairs)
    }

    fn part(&self, value: &Value, whole: &Whole<'_>) -> Option<ShapeId> {
        let part = self.resolve("shape", &self.shape_ids, value, "morph.pairs")?;
        if whole.parts.contains(&part) {
            return Some(part);
        }
        let names: Vec<&str> = whole.parts.iter().map(|part| self.part_name(*part)).collect();
        let part = clip(self.part_name(part));
        let problem = format!("`{part}` is no part of `{}`, which is `morph.{}`", whole.name, whole.key);
        self.reader.say(Diagnostic::error(value.span, problem).help(format!("its parts are {}", listed(&names))));
        None
    }

    fn all_are_paired(&self, span: Span, pairs: &[[ShapeId; 2]], wholes: &[Whole<'_>; 2]) -> bool {
        let mut all = true;
        for (side, whole) in wholes.iter().enumerate() {
            for part in whole.parts.iter().filter(|part| !pairs.iter().any(|pair| pair[side] == **part)) {
                let problem = format!("`{}`, a part of `{}`, is in no pair", clip(self.part_name(*part)), whole.name);
                let help = "each part of the one object needs one of the other: a union may join several into one";
                self.reader.say(Diagnostic::error(span, problem).help(help));
                all = false;
            }
        }
        all
    }

    /// The pair that a part names.
    fn master(&self, value: &Value, pairs: &[[ShapeId; 2]]) -> Option<usize> {
        let part = self.resolve("shape", &self.shape_ids, value, "morph.master")?;
        let found = pairs.iter().position(|pair| pair.contains(&part));
        if found.is_none() {
            let names: Vec<&str> = pairs.iter().map(|pair| self.part_name(pair[0])).collect();
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
