//! What is wrong with a scene while it is made into fields: one message with its place.

use crate::text::diagnostic::Diagnostic;
use crate::text::number::BadNumber;
use crate::text::source::Span;

/// A problem with its place, before the scene's texts are at hand.
#[derive(Clone, Debug, PartialEq)]
pub struct Problem(pub Box<Diagnostic>);

impl Problem {
    /// About a piece of the scene.
    pub fn new(span: Span, message: impl Into<String>) -> Self {
        Self(Box::new(Diagnostic::error(span, message)))
    }

    /// With what to do next.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.0.help = help.into();
        self
    }
}

impl From<BadNumber> for Problem {
    fn from(bad: BadNumber) -> Self {
        Self::new(bad.span, bad.message)
    }
}
