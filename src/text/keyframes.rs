//! `{ 1 = 0, 24 = { value = 0.5, out = [4, 0.2] }, 48 = 1, ease = "bezier" }`.

use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::frames::MOST_FRAME;

use crate::text::key::Absent::{Required, Words};
use crate::text::key::{self, Kind, Limit};
use crate::text::keyed::{Ease, Key, Keys};
use crate::text::reader::{Fields, NO_OWNER, Reader};
use crate::text::source::Span;
use crate::text::value::{Entry, Table, Value};

/// A key of a number by keys, where it is a table.
pub const KEY: &[key::Key] = &[
    key::Key::new("value", Kind::Constant, Required, "The value at the frame."),
    key::Key::new(
        "in",
        Kind::Table,
        Words("level at a turn, else without overshoot"),
        "The handle towards the key before: `[frames, value]` from the key, frames 0 or less.",
    ),
    key::Key::new(
        "out",
        Kind::Table,
        Words("level at a turn, else without overshoot"),
        "The handle towards the next key: `[frames, value]` from the key, frames 0 or more.",
    ),
];

/// What keys look like, for messages.
const LOOK: &str = "keys are `{ frame = value, ease = \"smooth\" }`";

impl Reader<'_> {
    /// A number by keys; `None` where an error was said.
    pub fn keys(&self, name: &str, limit: Limit, table: &Table, span: Span) -> Option<Keys> {
        let mut read: Vec<(Key, &Entry)> = Vec::new();
        let mut ease = Ease::Linear;
        for entry in &table.0 {
            if entry.key == "ease" {
                ease = self.ease(name, &entry.value);
                continue;
            }
            let Some(frame) = entry.key.parse::<f64>().ok().filter(|frame| frame.abs() <= MOST_FRAME as f64) else {
                let problem = format!("`{}` is not a frame", clip(&entry.key));
                self.say(Diagnostic::error(entry.key_span, problem).help(LOOK));
                return None;
            };
            read.push((self.key(&format!("{name}.{}", entry.key), limit, frame, &entry.value)?, entry));
        }
        if read.is_empty() {
            self.say(Diagnostic::error(span, format!("`{}` has no keys", clip(name))).help(LOOK));
            return None;
        }
        if let Some([(before, _), (_, entry)]) = read.array_windows().find(|[a, b]| out_of_order(a, b)) {
            let (name, frame, earlier) = (clip(name), clip(&entry.key), before.frame);
            let problem = format!("`{name}`: the key at frame {frame} stands after the one at {earlier}");
            self.say(Diagnostic::error(entry.key_span, problem).help("frames rise from key to key"));
            return None;
        }
        // Keys of a variant or `--set` come last, and belong in between.
        read.sort_by(|(a, _), (b, _)| a.frame.total_cmp(&b.frame));
        if let Some([_, (key, entry)]) = read.array_windows().find(|[(a, _), (b, _)]| a.frame == b.frame) {
            let problem = format!("`{}` has two keys at frame {}", clip(name), key.frame);
            self.say(Diagnostic::error(entry.key_span, problem));
            return None;
        }
        let handles = read.iter().find(|(key, _)| key.before.is_some() || key.after.is_some());
        if let Some((_, entry)) = handles.filter(|_| ease != Ease::Bezier) {
            let problem = format!("`{}` has handles", clip(&format!("{name}.{}", entry.key)));
            self.say(Diagnostic::error(entry.value.span, problem).help("they go with `ease = \"bezier\"`"));
        }
        for [(from, first), (to, second)] in read.array_windows() {
            let most = to.frame - from.frame;
            let reach = [(from.after, first, "out"), (to.before, second, "in")];
            for (_, entry, side) in reach.iter().filter(|(handle, ..)| handle.is_some_and(|[x, _]| x.abs() > most)) {
                let problem = format!("the handle `{}.{side}` reaches beyond the neighbouring key", clip(&entry.key));
                self.say(Diagnostic::error(entry.value.span, problem).help(format!("it is {most} frames away")));
            }
        }
        Some(Keys { keys: read.into_iter().map(|(key, _)| key).collect(), ease })
    }

    fn ease(&self, name: &str, value: &Value) -> Ease {
        let found = Ease::NAMES.iter().find(|(known, _)| value.text() == Some(*known));
        found.map_or_else(
            || {
                self.choice_problem(&format!("{name}.ease"), &Ease::NAMES.map(|(name, _)| name), value);
                Ease::Linear
            },
            |(_, ease)| *ease,
        )
    }

    /// A value, or `{ value = 0.5, in = [-4, 0], out = [4, 0.2] }`.
    fn key(&self, name: &str, limit: Limit, frame: f64, value: &Value) -> Option<Key> {
        if let Some(at) = value.number() {
            self.check_limit(name, limit, at, value.span);
            return Some(Key { frame, value: at, before: None, after: None });
        }
        let Some(table) = value.table() else {
            self.wrong_kind(name, "a number", value);
            return None;
        };
        // TOML reads `12.5 = 3` as the key 12 with a table in which 5 = 3.
        if let Some(entry) = table.0.iter().find(|entry| is_digits(&entry.key)) {
            let problem = format!("unknown key `{}` in `{}`", clip(&entry.key), clip(name));
            let help = format!("a key with a point stands in quotes: \"{frame}.{}\"", clip(&entry.key));
            self.say(Diagnostic::error(entry.key_span, problem).help(help));
            return None;
        }
        let fields = Fields::new(self, name, NO_OWNER, value.span, table, KEY.iter().collect());
        let at = fields.constant("value")?;
        self.check_limit(&format!("{name}.value"), limit, at, value.span);
        let handle = |side: &str, sign: f64| {
            let value = fields.value(side)?;
            let numbers: Option<Vec<f64>> = value.list().and_then(|list| list.iter().map(Value::number).collect());
            match numbers.as_deref() {
                Some(&[frames, rise])
                    if frames * sign >= 0.0 && Limit::Any.allows(frames) && Limit::Any.allows(rise) =>
                {
                    Some([frames, rise])
                }
                _ => {
                    let problem = format!("`{}` takes [frames, value], counted from the key", clip(&fields.full(side)));
                    let help = if sign < 0.0 { "such as in = [-4, 0]" } else { "such as out = [4, 0]" };
                    self.say(Diagnostic::error(value.span, problem).help(help));
                    None
                }
            }
        };
        Some(Key { frame, value: at, before: handle("in", -1.0), after: handle("out", 1.0) })
    }
}

fn is_digits(key: &str) -> bool {
    !key.is_empty() && key.bytes().all(|byte| byte.is_ascii_digit())
}

/// Whether two keys beside one another in one text stand in the wrong order.
fn out_of_order((before, first): &(Key, &Entry), (key, second): &(Key, &Entry)) -> bool {
    let one_text = first.value.origin == second.value.origin && first.key_span.source == second.key_span.source;
    one_text && key.frame < before.frame
}
