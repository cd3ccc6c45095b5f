//! An egg of the plane.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::{Egg, flat};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// An egg of the plane.
pub const NODE: Spec = Spec {
    key: Key::length(
        "egg_2d",
        Required,
        "Egg of the plane, its tip up, around the origin: the radius of its thick end.",
    ),
    parameters: &[
        Key::length("height", Of("egg_2d", 2.6), "From its bottom to its tip."),
        Key::length("tip", Of("egg_2d", 0.5), "The radius of its tip, less than that of the thick end."),
    ],
    formula: "the signed distance to it",
    example: "egg_2d = 0.7",
    plane: Plane::Flat,
    build: |build| {
        let (radius, height, tip) = (build.number("egg_2d")?, build.number("height")?, build.number("tip")?);
        let egg = Egg::new(build, [radius, height, tip])?;
        let mut outline = Outline::new();
        let [thick, thin] = [egg.thick, egg.thin].map(|middle| DVec2::Y * middle);
        let mirrored = |point: DVec2| point * DVec2::new(-1.0, 1.0);
        outline
            .line(thick - DVec2::X * radius)
            .arc(thick + DVec2::X * radius, thick, true)
            .arc(egg.touch, egg.arc, true)
            .arc(mirrored(egg.touch), thin, true)
            .arc(thick - DVec2::X * radius, mirrored(egg.arc), true)
            .close();
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
