//! Colours of three numbers or formulas: as they are, scene-linear, and by hue.

use std::sync::Arc;

use crate::attribute::{ByFormula, Components};
use crate::node::argument::Argument;
use crate::node::attributes::Paint;
use crate::node::source::{Source, Sourcing};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;

/// A colour written without a table: sRGB.
pub static SRGB: Source<3> = Source {
    key: Key::new("srgb", Kind::Components(Components::Srgb), Required, ""),
    build: |source| build(source, "srgb", Components::Srgb),
    ..Source::PLAIN
};

/// Scene-linear numbers.
pub const LINEAR: Source<3> = Source {
    key: Key::new(
        "linear",
        Kind::Components(Components::Linear),
        Required,
        "Scene-linear red, green, blue, each 0 or greater. Formulas are held to that.",
    ),
    example: "{ linear = [\"0.5 + x\", 0.2, 1.5] }",
    build: |source| build(source, "linear", Components::Linear),
    ..Source::PLAIN
};

/// Hue, saturation and value.
pub const HSV: Source<3> = Source {
    key: Key::new(
        "hsv",
        Kind::Components(Components::Hsv),
        Required,
        "Hue in degrees, saturation and value from 0 to 1, of the sRGB-encoded colour. Formulas are held to that.",
    ),
    example: "{ hsv = [\"360*x\", 0.8, 1] }",
    build: |source| build(source, "hsv", Components::Hsv),
    ..Source::PLAIN
};

fn build(source: &mut dyn Sourcing<3>, key: &str, meaning: Components) -> Result<Paint<3>, Problem> {
    Ok(match source.arguments().get(key) {
        Some(Argument::Colour(colour)) => Paint::solid(*colour),
        Some(Argument::Components(components)) => {
            let [a, b, c] = &components[..] else { unreachable!("a colour has three") };
            let components = [source.component(a)?, source.component(b)?, source.component(c)?];
            Paint::shared(Arc::new(ByFormula { components, meaning }))
        }
        other => unreachable!("a colour is {other:?}"),
    })
}
