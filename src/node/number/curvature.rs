//! How the surface is bent.

use crate::attribute::Curvature;
use crate::node::painted::Paint;
use crate::node::pattern::size;
use crate::node::source::Source;

/// How the surface is bent.
pub const NODE: Source<1> = Source {
    key: size(
        "curvature",
        "The mean curvature, times this length: 1 on a ball of this radius, 0 where it is flat, −1 in a hollow of this radius. Detail of less than a tenth of it does not show.",
    ),
    formula: "length/2 · div n, n the outward normal",
    example: "{ curvature = 0.3 }",
    build: |source| {
        let length = *source.arguments().constant("curvature").expect("it must be there");
        Ok(Paint::of(Curvature { solid: source.solid()?, length }))
    },
    ..Source::PLAIN
};
