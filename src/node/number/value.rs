//! A number, or a formula of space.

use std::sync::Arc;

use crate::attribute::FieldValue;
use crate::node::argument::Argument;
use crate::node::attributes::Paint;
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A scalar written without a table.
pub static VALUE: Source<1> = Source {
    key: Key::new("value", Kind::Number, Required, ""),
    build: |source| {
        Ok(match source.arguments().get("value") {
            Some(Argument::Numbers(value)) => Paint::solid([value[0]]),
            Some(Argument::Components(component)) => {
                Paint::shared(Arc::new(FieldValue(source.component(&component[0])?)))
            }
            other => unreachable!("a scalar is {other:?}"),
        })
    },
    ..Source::PLAIN
};
