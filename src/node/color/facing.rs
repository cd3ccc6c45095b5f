//! Where the surface faces.

use std::sync::Arc;

use crate::attribute::Facing;
use crate::node::pattern::{COLOURS, EASE, SPACE, colour_from, direction_of};
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Where the surface faces.
pub const NODE: Source<3> = Source {
    key: Key::new(
        "facing",
        Kind::Direction,
        Required,
        "How much the surface faces a direction: the first colour away from it, the last towards it.",
    ),
    parameters: &[COLOURS, SPACE, EASE],
    formula: "(1 + n·d)/2, n the outward normal",
    example: "{ facing = \"z\", colors = [\"#3d2c2e\", \"#9c6644\", \"#f1faee\"] }",
    build: |source| {
        let direction = direction_of(source, "facing")?;
        let solid = source.solid()?;
        let step = source.voxel();
        Ok(colour_from(source, Arc::new(Facing { solid, direction }), [-1.0, 1.0], step))
    },
    ..Source::PLAIN
};
