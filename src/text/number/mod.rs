//! Numbers of a scene: constants, formulas of time, [keys](crate::text::keyed); and the moments at which they are asked.
//! Formulas may name numbers, so they stand here.

pub(crate) mod formula;

use std::sync::Arc;

use crate::text::key::Limit;
use crate::text::keyed::Keys;
use crate::text::moment::Moment;
use crate::text::number::formula::Formula;
use crate::text::source::Span;

/// A number that may change over time.
#[derive(Clone, Debug)]
pub struct Number {
    /// How its value comes about.
    pub value: NumberValue,
    /// What it may be.
    pub limit: Limit,
    /// What messages call it, such as `shape.ball.sphere`.
    pub name: Arc<str>,
    /// Where it stands.
    pub span: Span,
}

/// How a number's value comes about.
#[derive(Clone, Debug)]
pub enum NumberValue {
    /// Always the same.
    Constant(f64),
    /// A formula of t, frame, time and parameters.
    Formula(Formula),
    /// Keys.
    Keys(Keys),
}

impl Number {
    /// A number that stays.
    pub fn constant(value: f64, name: &str, span: Span) -> Self {
        Self { value: NumberValue::Constant(value), limit: Limit::Any, name: name.into(), span }
    }

    /// Its value where it never changes.
    pub fn as_constant(&self) -> Option<f64> {
        if let NumberValue::Constant(value) = self.value { Some(value) } else { None }
    }

    /// Its value at a moment, or what is wrong with it.
    pub fn at(&self, moment: &Moment) -> Result<f64, BadNumber> {
        let value = match &self.value {
            NumberValue::Constant(value) => *value,
            NumberValue::Formula(formula) => formula.number(moment),
            NumberValue::Keys(keys) => keys.at(moment.frame),
        };
        let Some(wanted) = self.limit.out_of_range(value) else { return Ok(value) };
        Err(BadNumber {
            message: format!(
                "`{}` is {} at frame {}, and must be {wanted}",
                self.name,
                plain_number(value),
                crate::text::frames::plain(moment.frame),
            ),
            span: self.span,
        })
    }
}

/// A number in words: digits as long as they are few.
pub fn plain_number(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || !size.is_finite() || (1e-6..1e15).contains(&size) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// A number that came out as one that cannot be used.
#[derive(Clone, Debug, PartialEq)]
pub struct BadNumber {
    /// What is wrong.
    pub message: String,
    /// Where the number stands.
    pub span: Span,
}
