//! Which functions stand for set operations.

use crate::field::SetSystem;
use crate::node::spec::Build;
use crate::text::key::Absent::Text;
use crate::text::key::{Key, Kind};

/// The system of a set operation.
pub(crate) const SYSTEM: Key = Key::new(
    "system",
    Kind::Choice(&["r0", "minmax"]),
    Text("r0"),
    "What F is away from the surface, which is the same: `r0` is smooth, `minmax` is the distance on one side where the operands' \
     F are distances.",
);

/// The system that a node names.
pub(crate) fn system(build: &dyn Build) -> SetSystem {
    match build.arguments().choice("system") {
        Some(&"minmax") => SetSystem::MinMax,
        _ => SetSystem::R0,
    }
}
