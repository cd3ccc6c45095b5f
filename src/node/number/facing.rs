//! Where the surface faces.

use crate::attribute::Facing;
use crate::node::painted::Paint;
use crate::node::pattern::direction_of;
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// Where the surface faces.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "facing",
        Kind::Direction,
        Required,
        "How much the surface faces a direction: 1 towards it, 0 across it, −1 away from it.",
    ),
    formula: "n·d, n the outward normal",
    example: "{ facing = \"z\" }",
    build: |source| {
        let direction = direction_of(source, "facing")?;
        Ok(Paint::of(Facing { solid: source.solid()?, direction }))
    },
    ..Source::PLAIN
};
