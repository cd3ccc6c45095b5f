//! A row of the table of a morph's modes: how the shape changes from one object to the other.

use std::sync::Arc;

use crate::morph::{Delay, Mode, OverTime, Pace};
use crate::node::argument::Arguments;
use crate::text::frames::FrameRange;
use crate::text::key::{Absent, Key, Kind};
use crate::text::number::Number;
use crate::text::problem::Problem;
use crate::text::source::Span;

/// The keys of `[morph]` that not all modes use.
pub(crate) const SHARED: [&str; 9] = ["pace", "carry", "anchors", "arc", "carry_ease", "ease", "over", "through", "at"];

/// How a row makes its mode.
pub type ModeOf = fn(&dyn Setting) -> Result<Arc<dyn Mode>, Problem>;

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
    pub build: ModeOf,
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
pub trait Setting {
    /// The values of the mode's own keys.
    fn arguments(&self) -> &Arguments;
    /// How t follows the morph's progress.
    fn pace(&self) -> Pace;
    /// The places that wait.
    fn delay(&self) -> Option<Delay>;
    /// The shot's frames.
    fn frames(&self) -> FrameRange;
    /// Where the morph stands in the scene.
    fn span(&self) -> Span;
    /// A number over scene time.
    fn over_time(&self, number: &Number) -> Result<OverTime<f64>, Problem>;
    /// The number of a key that has a default, over scene time; exactly 1 at both ends of the morph.
    fn factor(&self, key: &str) -> Result<OverTime<f64>, Problem>;

    /// The number of a key that has a default, over scene time.
    fn number(&self, key: &str) -> Result<OverTime<f64>, Problem> {
        self.over_time(self.arguments().number(key).expect("it has a default"))
    }
}
