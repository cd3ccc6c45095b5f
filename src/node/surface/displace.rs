//! A surface moved by a scalar of its shape.

use crate::node::displacement::{Displacement, no_greatest};
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};

/// Moved along the normal.
pub const NODE: Spec = Spec {
    key: Key::new(
        "displace",
        Kind::Scalar,
        Nothing,
        "Moves the surface along its normal by an attribute of the shape, outward where that is positive: F = f + d, f the signed distance and d the attribute at the same point, in units.",
    ),
    formula: "f + d",
    source: "STTI, \"scalar displacement\"",
    example: "sphere = 1\nattribute.bumps = \"min(0.05*sin(8*x), 0.05)\"\ndisplace = \"bumps\"",
    measures: |_| true,
    build: |build| {
        let by = build.arguments().scalar("displace").expect("it must be there").clone();
        let bare = build.inner()?;
        let solid = build.solid_box(bare)?;
        let Some(scalar) = build.scalar(&by.name, solid)? else { return Ok(bare) };
        let displacement =
            Displacement::new(scalar, solid).ok_or_else(|| no_greatest(by.span, &by.name, build.name()))?;
        let distance = build.moving_distance(bare, displacement.levels(), "displace")?;
        Ok(displacement.apply(build.graph(), distance))
    },
    ..Spec::PLAIN
};
