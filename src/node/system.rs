//! Which functions stand for set operations.

use crate::field::SetSystem;
use crate::node::spec::Build;
use crate::text::key::Absent::{Text, Words};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// The system of a set operation.
pub(crate) const SYSTEM: Key = Key::new(
    "system",
    Kind::Choice(&["r0", "minmax", "cn"]),
    Text("r0"),
    "What F is away from the surface, which is the same: `r0` is smooth except where surfaces meet, `minmax` is the distance on \
     one side where the operands' F are distances, and `cn` (Rvachev's normalised form) is `order` − 1 times differentiable \
     except where surfaces meet, and as steep on the surface as its operands.",
);

/// The order of the system that has one.
pub(crate) const ORDER: Key = Key::new(
    "order",
    Kind::Whole,
    Words("2 for `cn`"),
    "The n of `system = \"cn\"`: the higher, the nearer to `minmax`.",
)
.limit(Limit::Within(2.0, 16.0));

/// The system that a node names.
pub(crate) fn system(build: &dyn Build) -> Result<SetSystem, Problem> {
    let order = build.arguments().whole("order").map(|order| *order as u32);
    match (build.arguments().choice("system").copied(), order) {
        (Some("cn"), order) => Ok(SetSystem::Cn { order: order.unwrap_or(2) }),
        (_, Some(_)) => {
            let problem = "`order` says nothing here: it is that of `system = \"cn\"`";
            Err(build.wrong("order", problem).help("name that system beside it, or leave `order` out"))
        }
        (Some("minmax"), None) => Ok(SetSystem::MinMax),
        _ => Ok(SetSystem::R0),
    }
}
