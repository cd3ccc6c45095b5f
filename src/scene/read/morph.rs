//! The morph and the output.

use crate::distance::without::Keep;
use crate::morph::Round;

use super::super::diagnostic::{Diagnostic, clip, listed};
use super::super::frames::{FrameRange, Shot};
use super::super::keys;
use super::super::model::{Content, Morph, MorphMode, Output, ShapeId};
use super::super::reader::{Fields, is_later};
use super::super::source::Span;
use super::super::value::{Table, Value};
use super::links::Node;
use super::{Building, pair};

impl<'r, 'a> Building<'r, 'a> {
    /// `None` where there is none, or where an error was said.
    pub(super) fn morph(&mut self, shot: &Shot) -> Option<Morph> {
        let entry = self.root.get("morph")?;
        let keys = keys::MORPH.iter().collect();
        let fields = Fields::of_value(self.reader, "morph", "morph", entry.key_span, &entry.value, keys)?;
        let from = fields.value("from").and_then(|value| self.shape_reference("morph.from", value));
        let to = fields.value("to").and_then(|value| self.shape_reference("morph.to", value));
        let cut = fields.value("cut").and_then(|value| self.shape_reference("morph.cut", value));
        let mode = self.morph_mode(&fields);
        let over = self.within_shot(&fields, "over", shot).unwrap_or(shot.range);
        let colour_over = self.within_shot(&fields, "color_over", shot).unwrap_or(over);
        if shot.still {
            let problem = Diagnostic::error(entry.key_span, "a morph needs the scene's `frames`");
            self.reader.say(problem.help("such as frames = \"1-48\""));
        }
        Some(Morph {
            cut,
            keep: Keep {
                largest_only: fields.choice("keep") == Some("largest"),
                least_volume: fields.constant("min_piece").unwrap_or(0.0),
            },
            even_pace: matches!(mode, MorphMode::Volume { .. }) && fields.choice("pace") == Some("even"),
            mode,
            smooth: fields.choice("ease") == Some("smooth"),
            octopus: fields.flag("octopus"),
            colour_space: fields.choice("color_space").unwrap_or("oklab"),
            alpha: fields.constant("alpha").unwrap_or(0.3),
            beta: fields.constant("beta").unwrap_or(0.5),
            over,
            colour_over,
            span: entry.key_span,
            from: from?,
            to: to?,
        })
    }

    fn morph_mode(&self, fields: &Fields<'r, 'a>) -> MorphMode {
        let paper = fields.choice("mode") == Some("paper");
        if !paper {
            for name in keys::PAPER_ONLY {
                if let Some(entry) = fields.entry(name) {
                    let problem = format!("`{}` is for `mode = \"paper\"` only", entry.key);
                    self.reader.say(Diagnostic::error(entry.key_span, problem));
                }
            }
            let bridge = fields.constant("bridge").unwrap_or(0.5);
            return MorphMode::Volume { bridge, volume: fields.required_number("volume") };
        }
        for name in keys::VOLUME_ONLY {
            if let Some(entry) = fields.entry(name) {
                let problem = format!("`{name}` is not for `mode = \"paper\"`");
                self.reader.say(Diagnostic::error(entry.key_span, problem));
            }
        }
        let number = |name| fields.constant(name).unwrap_or(1.0);
        MorphMode::Paper {
            a: [number("a0"), number("a1"), number("a2"), number("a3")],
            s: number("s"),
            slab: fields.value("slab").and_then(|value| pair(self.reader, "morph.slab", value)).unwrap_or([0.0, 1.0]),
            round: fields.value("round").and_then(|value| self.round(value)),
        }
    }

    fn round(&self, value: &'r Value) -> Option<Round> {
        let keys = keys::ROUND.iter().collect();
        let fields = Fields::of_value(self.reader, "morph.round", "round", value.span, value, keys)?;
        let number = |name| fields.constant(name).unwrap_or(1.0);
        Some(Round { a0: number("a0"), reach: number("reach"), a3: number("a3"), depth: number("depth") })
    }

    fn within_shot(&self, fields: &Fields<'r, 'a>, name: &str, shot: &Shot) -> Option<FrameRange> {
        let range = fields.frames(name)?;
        let span = fields.entry(name).map_or(fields.span, |entry| entry.value.span);
        if range.count() < 2 {
            let problem = format!("`{}` needs at least two frames", fields.full(name));
            self.reader.say(Diagnostic::error(span, problem));
        } else if range.first < shot.range.first || range.last > shot.range.last {
            let FrameRange { first, last } = shot.range;
            let problem = format!("`{}` reaches beyond the scene's frames, {first}-{last}", fields.full(name));
            self.reader.say(Diagnostic::warning(span, problem).help("the morph is not whole within the shot"));
        }
        Some(range)
    }

    /// The output, and the shape that it names.
    pub(super) fn output(&mut self) -> (Output, Option<(ShapeId, Span)>) {
        let keys = keys::OUTPUT.iter().collect();
        let entry = self.root.get("output");
        let span = entry.map_or_else(Span::default, |entry| entry.key_span);
        let fields = match entry {
            Some(entry) => Fields::of_value(self.reader, "output", "output", span, &entry.value, keys),
            None => Some(Fields::new(self.reader, "output", "output", span, &NOTHING, keys)),
        };
        let Some(fields) = fields else { return (default_output(), None) };
        let chosen =
            fields.value("shape").and_then(|value| Some((self.shape_reference("output.shape", value)?, value.span)));
        if let (Some(size), Some(_)) = (fields.entry("voxel_size"), fields.entry("resolution")) {
            let problem = "`voxel_size` and `resolution` say the same thing twice";
            self.reader.say(Diagnostic::error(size.key_span, problem));
        }
        let name = fields.text("color_name").unwrap_or_else(|| "Cd".into());
        let taken = name == "surface" || name == "vel" || self.is_scalar(&name);
        if name.is_empty() || taken || name.contains(char::is_whitespace) {
            let problem = format!("a grid cannot be called `{}`", clip(&name));
            self.reader
                .say(Diagnostic::error(fields.entry("color_name").map_or(span, |entry| entry.value.span), problem));
        }
        let output = Output {
            voxel_size: fields.constant("voxel_size"),
            resolution: fields.whole("resolution").unwrap_or(256).clamp(1, i64::from(u32::MAX)) as u32,
            half_width: fields.constant("half_width").unwrap_or(3.0),
            grids: self.grids(&fields, "grids", &name),
            half: self.grids(&fields, "half", &name).unwrap_or_default(),
            compression: fields.choice("compression").unwrap_or("blosc"),
            colour_name: name,
            max_speed: fields.constant("max_speed"),
        };
        (output, chosen)
    }

    /// Whether a shape has a scalar of this name.
    fn is_scalar(&self, name: &str) -> bool {
        self.shapes.iter().flatten().any(|shape| shape.scalars.contains_key(name))
    }

    /// Names of grids that this scene's frames may have; `None` where they are left out.
    fn grids(&self, fields: &Fields<'r, 'a>, key: &str, colour: &str) -> Option<Vec<String>> {
        let value = fields.value(key)?;
        let path = fields.full(key);
        let scalars = self.shapes.iter().flatten().flat_map(|shape| shape.scalars.keys().map(String::as_str));
        let mut known: Vec<&str> = ["surface", colour, "vel"].into_iter().chain(scalars).collect();
        known.sort_unstable();
        known.dedup();
        let Some(list) = value.list().filter(|list| key != "grids" || !list.is_empty()) else {
            self.reader.wrong_kind(&path, &format!("a list of {}", listed(&known)), value);
            return None;
        };
        let mut names = Vec::new();
        for value in list {
            match value.text() {
                Some(name) if known.contains(&name) => names.push(name.to_owned()),
                Some(name) if is_later("grid", name) => {
                    let problem = format!("the grid `{name}` is not supported in this version");
                    self.reader.say(Diagnostic::error(value.span, problem));
                }
                _ => self.reader.choice_problem(&path, &known, value),
            }
        }
        if key == "grids" && !names.iter().any(|name| name == "surface") {
            let problem =
                Diagnostic::error(value.span, "`output.grids` has no `surface`, on whose voxels all others stand");
            self.reader.say(problem.help("add it to the list"));
        }
        Some(names)
    }

    /// What is baked: the morph, else the shape that is named, else the one that nobody uses.
    pub(super) fn content(&self, morph: Option<Morph>, chosen: Option<(ShapeId, Span)>) -> Option<Content> {
        if let Some(morph) = morph {
            if let Some((_, span)) = chosen {
                self.reader.say(Diagnostic::warning(span, "`output.shape` is not used: the morph is what is baked"));
            }
            return Some(Content::Morph(Box::new(morph)));
        }
        if self.root.get("morph").is_some() {
            return None;
        }
        if let Some((id, _)) = chosen {
            return Some(Content::Shape(id));
        }
        let used = |id: ShapeId| self.links.iter().any(|link| link.to == Node::Shape(id));
        let mut free = self.shape_ids.iter().filter(|(_, id)| !used(**id));
        match (free.next(), free.next()) {
            (Some((_, id)), None) => Some(Content::Shape(*id)),
            (None, _) if self.shape_ids.is_empty() => {
                if self.root.get("shape").is_some_and(|entry| entry.value.table().is_none()) {
                    return None;
                }
                self.reader
                    .say(Diagnostic::without_place("the scene has no shape").help("[shape.ball] with sphere = 1"));
                None
            }
            // A cycle, which is said elsewhere.
            (None, _) => None,
            (Some((first, _)), Some((second, id))) => {
                let span = family_span(self, *id);
                let problem = format!("what is to be baked, `{}` or `{}`?", clip(first), clip(second));
                self.reader
                    .say(Diagnostic::error(span, problem).help("join them, or name one: [output] with shape = \"…\""));
                None
            }
        }
    }
}

/// The output table of a scene without one.
static NOTHING: Table = Table(Vec::new());

fn family_span(building: &Building<'_, '_>, id: ShapeId) -> Span {
    super::family(building.root, "shape").nth(id.0).map_or_else(Span::default, |entry| entry.key_span)
}

fn default_output() -> Output {
    Output {
        voxel_size: None,
        resolution: 256,
        half_width: 3.0,
        grids: None,
        half: Vec::new(),
        compression: "blosc",
        colour_name: "Cd".into(),
        max_speed: None,
    }
}
