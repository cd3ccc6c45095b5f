//! A row of the table of a morph's modes: how the shape changes from one object to the other.

use std::sync::Arc;

use crate::morph::{Delay, Mode, OverTime, Pace};
use crate::node::argument::Arguments;
use crate::node::model::{Model, Morph};
use crate::node::over_time::{ends_at, over_time, span_of};
use crate::text::key::{Absent, Key, Kind};
use crate::text::number::Number;
use crate::text::problem::Problem;

/// The keys of `[morph]` that not all modes use.
pub(crate) const SHARED: [&str; 9] = ["pace", "carry", "anchors", "arc", "carry_ease", "ease", "over", "through", "at"];

/// How a morph's shape changes.
pub struct ModeSpec {
    /// Its name, which is the value of `mode`, and what it does.
    pub key: Key,
    /// The keys of `[morph]` that it alone has.
    pub parameters: &'static [Key],
    /// Those of [`SHARED`] that it uses.
    pub shared: &'static [&'static str],
    /// F on the way, where one line says it.
    pub formula: &'static str,
    /// Where it comes from: paper and section.
    pub source: &'static str,
    /// Keys of a morph that show it, TOML.
    pub example: &'static str,
    /// Whether objects that lie apart are carried where the scene says nothing.
    pub carries_apart: bool,
    /// What helps where frames are empty; `None` where none can be.
    pub where_empty: Option<&'static str>,
    /// Whether OpenVDB makes its frames from level sets, each from the one before, of objects that stand still.
    pub by_level_sets: bool,
    /// The mode over scene time.
    pub build: fn(&Setting<'_>) -> Result<Arc<dyn Mode>, Problem>,
}

impl ModeSpec {
    /// A row's name and text.
    pub(crate) const fn named(name: &'static str, text: &'static str) -> Key {
        Key::new(name, Kind::Table, Absent::Nothing, text)
    }
}

impl std::fmt::Debug for ModeSpec {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.key.name)
    }
}

/// What a row's function may ask for.
pub struct Setting<'a> {
    pub(crate) model: &'a Arc<Model>,
    pub(crate) morph: &'a Morph,
    /// The places that wait.
    pub(crate) delay: Option<Delay>,
}

impl Setting<'_> {
    /// The values of the mode's own keys.
    pub fn arguments(&self) -> &Arguments {
        &self.morph.mode.arguments
    }

    /// How t follows the morph's progress.
    pub fn pace(&self) -> Pace {
        if self.morph.even_pace { Pace::Even } else { Pace::Time }
    }

    /// A number over scene time.
    pub fn over_time(&self, number: &Number) -> Result<OverTime<f64>, Problem> {
        over_time(self.model, number)
    }

    /// The number of a key that has a default, over scene time.
    pub fn number(&self, key: &str) -> Result<OverTime<f64>, Problem> {
        self.over_time(self.arguments().number(key).expect("it has a default"))
    }

    /// The same of one that is exactly 1 at both ends of the morph.
    pub fn factor(&self, key: &str) -> Result<OverTime<f64>, Problem> {
        let number = self.arguments().number(key).expect("it has a default");
        ends_at(self.model, self.morph, number, [1.0, 1.0], "such as { 1 = 1, 24 = 1.5, 48 = 1 }")?;
        let inner = self.over_time(number)?;
        if inner.is_still() {
            return Ok(inner);
        }
        let [start, end] = span_of(self.model, self.morph.over);
        Ok(OverTime::moving(move |time| {
            let at = inner.at(time);
            if time <= start || time >= end || (at - 1.0).abs() < super::over_time::ROUNDING { 1.0 } else { at }
        }))
    }
}
