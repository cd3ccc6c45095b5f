//! An egg.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::{Egg, revolved};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// An egg.
pub const NODE: Spec = Spec {
    key: Key::length("egg", Required, "Egg along z, its tip up, around the origin: the radius of its thick end."),
    parameters: &[
        Key::length("height", Of("egg", 2.6), "From its bottom to its tip."),
        Key::length("tip", Of("egg", 0.5), "The radius of its tip, less than that of the thick end."),
    ],
    formula: "the signed distance to it: a ball below, one above, and between them an arc that touches both",
    example: "egg = 0.7",
    build: |build| {
        let (radius, height, tip) = (build.number("egg")?, build.number("height")?, build.number("tip")?);
        let egg = Egg::new(build, [radius, height, tip])?;
        let [thick, thin] = [egg.thick, egg.thin].map(|middle| DVec2::Y * middle);
        let mut outline = Outline::new();
        outline
            .line(thick - DVec2::Y * radius)
            .arc(thick + DVec2::X * radius, thick, true)
            .arc(egg.touch, egg.arc, true)
            .arc(thin + DVec2::Y * tip, thin, true)
            .close();
        Ok(revolved(build, outline))
    },
    ..Spec::PLAIN
};
