//! The shapes of a morph and their frames: two, or a chain of them.

use super::Building;
use crate::node::keys;
use crate::node::model::{MorphEase, ShapeId};
use crate::text::diagnostic::Diagnostic;
use crate::text::frames::{FrameRange, Shot};
use crate::text::reader::Fields;
use crate::text::value::{Data, Value};

/// One shape becoming the next.
pub(super) struct Link {
    pub from: ShapeId,
    pub to: ShapeId,
    pub over: FrameRange,
    pub colour_over: FrameRange,
}

impl<'r, 'a> Building<'r, 'a> {
    /// The morph's links in order of time; `None` where an error was said.
    pub(super) fn chain(
        &mut self,
        fields: &Fields<'r, 'a>,
        eases: &[(&str, Option<&MorphEase>)],
        shot: &Shot,
    ) -> Option<Vec<Link>> {
        let over = self.within_shot(fields, "over", shot);
        let Some(through) = fields.entry("through") else {
            if let Some(at) = fields.entry("at") {
                self.reader.say(Diagnostic::error(at.key_span, "`at` goes with `through`"));
            }
            let over = over.unwrap_or(shot.range);
            let colour_over = self.within_shot(fields, "color_over", shot).unwrap_or(over);
            let [from, to] = ["from", "to"].map(|name| self.end(fields, name));
            return Some(vec![Link { from: from?, to: to?, over, colour_over }]);
        };
        self.not_with_through(fields, eases);
        let shapes = self.through(fields, &through.value)?;
        let frames = self.key_frames(fields, shapes.len(), over, shot)?;
        let links = shapes.array_windows().zip(frames.array_windows()).map(|(&[from, to], &[first, last])| {
            let over = FrameRange { first, last };
            Link { from, to, over, colour_over: over }
        });
        Some(links.collect())
    }

    fn end(&mut self, fields: &Fields<'r, 'a>, name: &str) -> Option<ShapeId> {
        if fields.entry(name).is_none() {
            let text = keys::morph_keys().find(|key| key.name == name).map_or("", |key| key.text);
            let problem = format!("`morph` has no `{name}`");
            self.reader.say(Diagnostic::error(fields.span, problem).help(text));
        }
        let value = fields.entry(name).and_then(|_| fields.value(name))?;
        self.shape_reference(&fields.full(name), value)
    }

    fn not_with_through(&self, fields: &Fields<'r, 'a>, eases: &[(&str, Option<&MorphEase>)]) {
        for name in ["from", "to"] {
            if let Some(entry) = fields.entry(name) {
                let problem = format!("`{name}` and `through` say the same thing twice");
                self.reader.say(Diagnostic::error(entry.key_span, problem));
            }
        }
        if let Some(entry) = fields.entry("color_over") {
            let problem = format!("`{}` does not go with `through`", entry.key);
            self.reader.say(Diagnostic::error(entry.key_span, problem).help("colours change from shape to shape"));
        }
        if let (Some(entry), Some(_)) = (fields.entry("over"), fields.entry("at")) {
            self.reader.say(Diagnostic::error(entry.key_span, "`over` and `at` say the same thing twice"));
        }
        for (name, ease) in eases {
            let Some(MorphEase::Progress(progress)) = ease else { continue };
            let problem =
                format!("`morph.{name}` by keys or formula is the progress of one morph, and `through` makes several");
            let help = "\"linear\" and \"smooth\" are of each";
            self.reader.say(Diagnostic::error(progress.span, problem).help(help));
        }
    }

    fn through(&mut self, fields: &Fields<'r, 'a>, value: &'r Value) -> Option<Vec<ShapeId>> {
        fields.value("through");
        let Some(list) = value.list().filter(|list| list.len() >= 2) else {
            let problem = "`morph.through` must be at least two shapes, such as [\"a\", \"b\", \"c\"]";
            self.reader.say(Diagnostic::error(value.span, problem));
            return None;
        };
        let found: Vec<Option<ShapeId>> =
            list.iter().map(|value| self.shape_reference("morph.through", value)).collect();
        found.into_iter().collect()
    }

    /// A frame for each shape: those given, or evenly over a range.
    fn key_frames(
        &self,
        fields: &Fields<'r, 'a>,
        count: usize,
        over: Option<FrameRange>,
        shot: &Shot,
    ) -> Option<Vec<i64>> {
        let FrameRange { first, last } = shot.range;
        let Some(value) = fields.value("at").filter(|_| fields.entry("at").is_some()) else {
            let over = over.unwrap_or(shot.range);
            if over.count() < count && !shot.still {
                let span = fields.entry("over").map_or(fields.span, |entry| entry.value.span);
                let problem = format!("{} frames are too few for {count} shapes, one after the other", over.count());
                self.reader.say(Diagnostic::error(span, problem));
                return None;
            }
            let (length, last) = (over.last - over.first, count as i64 - 1);
            // To the nearest frame.
            return Some((0..=last).map(|i| over.first + (2 * i * length + last) / (2 * last)).collect());
        };
        let say = |span, problem: String| self.reader.say(Diagnostic::error(span, problem));
        let Some(list) = value.list() else {
            self.reader.wrong_kind("morph.at", "a frame for each shape of `through`, such as [1, 24, 48]", value);
            return None;
        };
        if list.len() != count {
            say(value.span, format!("`morph.at` has {} frames for {count} shapes", list.len()));
            return None;
        }
        let mut frames: Vec<i64> = Vec::new();
        for value in list {
            match value.data {
                // As far as file names and metadata hold them.
                Data::Integer(frame) if frame.abs() <= 999_999_999 => {
                    if frames.last().is_some_and(|before| *before >= frame) {
                        say(value.span, "`morph.at` must rise from shape to shape".into());
                        return None;
                    }
                    frames.push(frame);
                }
                _ => {
                    say(value.span, "`morph.at` must be whole frames".into());
                    return None;
                }
            }
        }
        if frames[0] < first || frames[count - 1] > last {
            let problem = format!("`morph.at` reaches beyond the scene's frames, {first}-{last}");
            let problem = Diagnostic::warning(value.span, problem);
            self.reader.say(problem.help("the morph is not whole within the shot"));
        }
        Some(frames)
    }
}
