//! The length of the way inside of the shape.

use crate::attribute::conformal::{Goal, Interior};
use crate::node::conformal::{LATTICE, lattice};
use crate::node::painted::Paint;
use crate::node::source::Source;
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// The length of the way inside of the shape.
pub const NODE: Source<1> = Source {
    key: Key::new(
        "interior",
        Kind::Goals,
        Required,
        "How long the shortest way is that stays inside of the shape, to the nearest of these features: 0 in them. Outside \
         of the shape it is that of the nearest place of the surface. `\"surface\"` is the shape's own, unless a shape has \
         that name. Features stand in the shape's own space, as it is before what bends that; so do lengths, before `scale`.",
    )
    .unit("units"),
    parameters: &[LATTICE],
    formula: "d(p) = inf of the lengths of paths in the shape from p to a feature (CONFORMAL, eq. 1)",
    example: "{ interior = [\"b\"] }",
    is_conformal: true,
    build: |source| {
        let goals = source.arguments().goals("interior").cloned().unwrap_or_default();
        let shapes: Vec<_> = goals.iter().flatten().copied().collect();
        let (body, features) = source.inside(&shapes, lattice(source), "interior")?;
        let surface = goals.contains(&None).then_some(Goal::Surface);
        Ok(Paint::of(Interior { body, goals: features.into_iter().map(Goal::Feature).chain(surface).collect() }))
    },
    ..Source::PLAIN
};
