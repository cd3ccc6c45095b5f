//! A scene's text: sources, values that know their places, what is said about them, overrides, files, and the kinds of
//! values that keys may take. What the keys are is known to [`crate::node`].

pub(crate) mod builtin;
pub(crate) mod colour;
pub(crate) mod diagnostic;
pub(crate) mod files;
mod format;
pub(crate) mod frames;
pub mod key;
pub(crate) mod keyed;
pub(crate) mod keyframes;
pub(crate) mod moment;
pub(crate) mod number;
pub(crate) mod overrides;
pub(crate) mod pattern;
pub mod problem;
pub(crate) mod reader;
pub(crate) mod sequence;
pub(crate) mod source;
pub(crate) mod value;

pub use builtin::{builtin_line, builtin_names, builtin_text};
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use files::{FilePlace, FileReference, expand};
pub use format::format_toml;
pub use frames::{BadRange, FrameRange, Shot};
pub use keyed::{Ease, Key, Keys};
pub use moment::Moment;
pub use number::formula::Formula;
pub use number::{BadNumber, Number, NumberValue};
pub use overrides::Overrides;
pub use pattern::{FramePattern, PatternError};
pub use reader::Setting;
pub use sequence::{FileSequence, OutsideFrames};
pub use source::{Place, Span};
pub use value::Origin;
