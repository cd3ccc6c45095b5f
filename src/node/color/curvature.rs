//! How the surface is bent.

use std::sync::Arc;

use crate::attribute::Curvature;
use crate::node::pattern::{COLOURS, EASE, SPACE, colour_from, size};
use crate::node::source::Source;

/// How the surface is bent.
pub const NODE: Source<3> = Source {
    key: size(
        "curvature",
        "The mean curvature: the first colour in hollows of this radius, the middle where it is flat, the last on balls of this radius.",
    ),
    parameters: &[COLOURS, SPACE, EASE],
    formula: "1/2 + length/4 · div n, n the outward normal",
    example: "{ curvature = 0.3, colors = [\"#1d3557\", \"#f1faee\", \"#e63946\"] }",
    build: |source| {
        let length = *source.arguments().constant("curvature").expect("it must be there");
        let solid = source.solid()?;
        Ok(colour_from(source, Arc::new(Curvature { solid, length }), [-1.0, 1.0], 0.1 * length))
    },
    ..Source::PLAIN
};
