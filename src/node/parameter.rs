//! A number with a name, for formulas.

use crate::text::number::Number;

/// A number with a name.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: Number,
    /// What it is, in the scene's words.
    pub text: Option<String>,
}
