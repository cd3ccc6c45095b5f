//! The way that a morph's objects are carried along, and so on along a chain.

use super::Building;
use super::chain::Link;
use crate::node::model::{Anchor, MorphCarry};
use crate::text::diagnostic::Diagnostic;
use crate::text::key::Limit;
use crate::text::reader::Fields;
use crate::text::value::Value;

const ANCHORS: &str = "morph.anchors";

impl<'r, 'a> Building<'r, 'a> {
    /// One for each link of the chain; `None` where an error was said.
    pub(super) fn carry(&self, fields: &Fields<'r, 'a>, chain: Option<&[Link]>) -> Option<Vec<MorphCarry>> {
        let said = fields.entry("carry");
        let named = fields.choice("carry");
        let alike = |carry: MorphCarry| Some(vec![carry; chain?.len()]);
        if let Some(anchors) = fields.entry("anchors") {
            let value = fields.value("anchors");
            if named == Some("none") {
                return alike(MorphCarry::None);
            }
            if said.is_some() && named != Some("anchors") {
                let problem = format!("`{}` is for `carry = \"anchors\"` only", anchors.key);
                self.reader.say(Diagnostic::error(anchors.key_span, problem));
                return None;
            }
            return self.anchors(value?, chain?.len());
        }
        let of_a_way = ["carry_ease", "arc"].into_iter().find_map(|name| fields.entry(name));
        match (named, said, of_a_way) {
            (Some("none"), _, Some(entry)) => {
                let problem =
                    format!("`{}` says how objects are carried, and `carry = \"none\"` carries none", entry.key);
                self.reader.say(Diagnostic::error(entry.key_span, problem).help("leave out one of the two"));
                None
            }
            // Who says how they go wants them to go.
            (None, None, Some(_)) => alike(MorphCarry::Centroid),
            (Some("none"), ..) => alike(MorphCarry::None),
            (Some("centroid"), ..) => alike(MorphCarry::Centroid),
            (Some("inertia"), ..) => alike(MorphCarry::Inertia),
            (Some(_), Some(entry), _) => {
                let problem = Diagnostic::error(entry.value.span, "`carry = \"anchors\"` goes with `anchors`");
                self.reader
                    .say(problem.help("anchors = [[[0, 0, 1], [3, 0, 2]]], a place of the first and of the last"));
                None
            }
            _ => alike(MorphCarry::Left),
        }
    }

    /// Three numbers that stand still.
    pub(super) fn fixed_vector(&self, path: &str, value: &Value) -> Option<[f64; 3]> {
        let three = self.reader.three(path, value)?;
        Some(three.each_ref().map(|number| self.reader.constant(path, Limit::Any, number)))
    }

    /// Rows of places, one of each shape of the chain, as pairs for each of its links.
    fn anchors(&self, value: &Value, links: usize) -> Option<Vec<MorphCarry>> {
        let Some(list) = value.list().filter(|list| !list.is_empty()) else {
            let wanted = "a list of pairs of places, such as [[[0, 0, 1], [3, 0, 2]]]";
            self.reader.wrong_kind(ANCHORS, wanted, value);
            return None;
        };
        let mut rows: Vec<Vec<Anchor>> = Vec::new();
        for item in list {
            let Some(places) = item.list().filter(|places| places.len() == links + 1) else {
                let problem = match links {
                    1 => "`morph.anchors` takes pairs: a place of the first shape and one of the last".into(),
                    _ => format!("`morph.anchors` takes lists of {}: a place of each shape of `through`", links + 1),
                };
                self.reader.say(Diagnostic::error(item.span, problem).help("a place is [x, y, z]"));
                return None;
            };
            let place = |value: &Value| Some(Anchor { at: self.fixed_vector(ANCHORS, value)?, span: value.span });
            rows.push(places.iter().map(place).collect::<Option<_>>()?);
        }
        let link = |link: usize| MorphCarry::Anchors(rows.iter().map(|row| [row[link], row[link + 1]]).collect());
        Some((0..links).map(link).collect())
    }
}
