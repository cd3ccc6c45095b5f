//! Attributes written without a table: a colour of three numbers or formulas, a number or a formula.

use std::sync::Arc;

use crate::attribute::{ByFormula, Components, FieldValue};
use crate::node::argument::Argument;
use crate::node::painted::Paint;
use crate::node::source::{Source, Sourcing};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;

/// A colour: sRGB.
pub static SRGB: Source<3> = Source {
    key: Key::new("srgb", Kind::Components(Components::Srgb), Required, ""),
    build: |source| of_components(source, "srgb", Components::Srgb),
    ..Source::PLAIN
};

/// A scalar.
pub static VALUE: Source<1> = Source {
    key: Key::new("value", Kind::Number, Required, ""),
    build: |source| {
        Ok(match source.arguments().get("value").cloned() {
            Some(Argument::Numbers(value)) => Paint::solid([value[0]]),
            Some(Argument::Components(component)) => {
                Paint::shared(Arc::new(FieldValue(source.component(&component[0])?)))
            }
            other => unreachable!("a scalar is {other:?}"),
        })
    },
    ..Source::PLAIN
};

/// A colour of three numbers or formulas.
pub(crate) fn of_components(source: &mut dyn Sourcing<3>, key: &str, meaning: Components) -> Result<Paint<3>, Problem> {
    Ok(match source.arguments().get(key).cloned() {
        Some(Argument::Colour(colour)) => Paint::solid(colour),
        Some(Argument::Components(components)) => {
            let [a, b, c] = &components[..] else { unreachable!("a colour has three") };
            let components = [source.component(a)?, source.component(b)?, source.component(c)?];
            Paint::shared(Arc::new(ByFormula { components, meaning }))
        }
        other => unreachable!("a colour is {other:?}"),
    })
}
