//! A spiral stroke.

use crate::field::{Joined, Struts};
use crate::node::profile::polar;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// A spiral stroke.
pub const NODE: Spec = Spec {
    key: Key::length(
        "spiral",
        Required,
        "Archimedean spiral around the origin as a stroke with round ends: the radius at its outer end.",
    ),
    parameters: &[
        Key::new("turns", Kind::Number, Number(3.0), "How many turns.").limit(Limit::Within(0.05, 200.0)),
        Key::new("inner", Kind::Number, Number(0.0), "The radius at its inner end.")
            .limit(Limit::NotNegative)
            .unit("units"),
        Key::length("width", Of("spiral", 0.1), "The width of the stroke."),
    ],
    formula: "w/2 − |p − q|, q the nearest of the spiral, of straight pieces",
    example: "spiral = 0.9",
    plane: Plane::Flat,
    build: |build| {
        let (outer, inner) = (build.number("spiral")?, build.number("inner")?);
        let (turns, wide) = (build.number("turns")?, build.number("width")? / 2.0);
        let at = |share: f64| polar(inner + (outer - inner) * share, 360.0 * turns * share).extend(0.0);
        let pieces = (96.0 * turns).ceil() as usize;
        Ok(build.graph().field(Joined::shared(Struts::along(at, |_| wide, pieces).flattened())))
    },
    ..Spec::PLAIN
};
