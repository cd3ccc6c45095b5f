//! What measures a distance: its name, or a table of an adaptive one with its settings.

use super::Building;
use crate::distance::method::{ADF, Choice, NAMES};
use crate::distance::octree::Restore;
use crate::node::keys;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::reader::{Fields, NO_OWNER};
use crate::text::source::Span;

impl<'r, 'a> Building<'r, 'a> {
    /// What the key `distance` of a table chooses, and where; `None` where it is left out or wrong.
    pub(super) fn measured_by(&self, fields: &Fields<'r, 'a>) -> Option<(Choice, Span)> {
        let (value, path) = (fields.value("distance")?, fields.full("distance"));
        if value.table().is_some() {
            let keys = keys::ADF.iter().collect();
            let fields = Fields::of_value(self.reader, &path, NO_OWNER, value.span, value, keys)?;
            let depth = fields.whole("adf").and_then(|depth| u32::try_from(depth).ok());
            let restore = match fields.choice("restore") {
                Some("linear") => Restore::Linear,
                _ => Restore::Spline,
            };
            return Some((Choice { method: ADF, depth: Some(depth?), restore }, value.span));
        }
        let found = NAMES.into_iter().find(|name| value.text() == Some(name));
        if found.is_none() {
            self.reader.choice_problem(&path, &NAMES, value);
        }
        Some((Choice::by(found?), value.span))
    }

    /// The key `step` of a table, which takes the slope on the surface from what is written.
    pub(super) fn step(&self, fields: &Fields<'r, 'a>) -> Option<f64> {
        let step = fields.constant("step")?;
        let span = fields.entry("step").map_or_else(|| fields.main_span(), |entry| entry.value.span);
        let problem =
            format!("`{}`: the distances that are written have no slope on the surface", clip(&fields.full("step")));
        let help = "programs take normals and offsets from that slope; leave `step` out for what is delivered";
        self.reader.say(Diagnostic::warning(span, problem).help(help));
        Some(step)
    }
}
