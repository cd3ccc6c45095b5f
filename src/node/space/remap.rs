//! A shape read where formulas say.

use std::sync::Arc;

use crate::node::bend::Mapped;
use crate::node::space::warp::components;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};

/// Read where formulas say.
pub const NODE: Spec = Spec {
    key: Key::new(
        "remap",
        Kind::Formulas,
        Nothing,
        "Each place shows what is at this one: x, y and z, each a formula of the place. It may have no end: then it needs \
         `bounds`, after it in `do`.",
    )
    .unit("units"),
    formula: "f(g(p))",
    example: "sphere = 0.4\ndo = [{ remap = [\"x - 0.3*z^2\", \"y*(1 + 0.5*z^2)\", \"z/2\"] }, { bounds = { box = 3, cut = true } }]",
    bend: Some(|build| {
        let coordinates = components(build, "remap")?;
        Ok(Arc::new(Mapped::new(move |graph| coordinates.each_ref().map(|way| way.add_to(graph)))))
    }),
    ..Spec::PLAIN
};
