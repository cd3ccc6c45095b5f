//! Which functions stand for set operations.

use crate::field::SetSystem;
use crate::node::spec::Build;
use crate::text::key::Absent::{Text, Words};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// The system of a set operation.
pub(crate) const SYSTEM: Key = Key::new(
    "system",
    Kind::Choice(&["r0", "minmax", "cn", "rm"]),
    Text("r0"),
    "What F is away from the surface, which is the same: `r0` is smooth except where surfaces meet, `minmax` is the distance on \
     one side where the operands' F are distances, `cn` (Rvachev's normalised form) is `order` − 1 times differentiable \
     except where surfaces meet, and as steep on the surface as its operands, and `rm` (R_m, `r0` times (a² + b²)^(m/2) of the \
     operands' F with m = `order`) is m times differentiable everywhere, and level where surfaces meet.",
);

/// The order of the systems that have one.
pub(crate) const ORDER: Key = Key::new(
    "order",
    Kind::Whole,
    Words("2 for `cn` and `rm`"),
    "The n of `system = \"cn\"`, from 2: the higher, the nearer to `minmax`. The m of `system = \"rm\"`, to 8: F of k shapes \
     grows with the power (m + 1)^⌈log₂ k⌉ of their size.",
)
.limit(Limit::Within(1.0, 16.0));

/// Where F of two shapes with an order more keeps its value in the range of a float only between 10⁻⁴ and 10⁴.
const MOST_OF_RM: u32 = 8;

/// The system that a node names.
pub(crate) fn system(build: &dyn Build) -> Result<SetSystem, Problem> {
    let order = build.arguments().whole("order").map(|order| *order as u32);
    match (build.arguments().choice("system").copied(), order) {
        (Some("cn"), Some(1)) => {
            Err(build.wrong("order", "`order` of `cn` starts at 2").help("1 is for `system = \"rm\"`"))
        }
        (Some("rm"), Some(order)) if order > MOST_OF_RM => {
            let problem = format!("`order` of `rm` ends at {MOST_OF_RM}: F would leave the range of a float");
            Err(build.wrong("order", problem).help("a lower one is as smooth as a voxel shows"))
        }
        (Some("cn"), order) => Ok(SetSystem::Cn { order: order.unwrap_or(2) }),
        (Some("rm"), order) => Ok(SetSystem::Rm { order: order.unwrap_or(2) }),
        (_, Some(_)) => {
            let problem = "`order` says nothing here: it is that of `system = \"cn\"` and `\"rm\"`";
            Err(build.wrong("order", problem).help("name that system beside it, or leave `order` out"))
        }
        (Some("minmax"), None) => Ok(SetSystem::MinMax),
        _ => Ok(SetSystem::R0),
    }
}
