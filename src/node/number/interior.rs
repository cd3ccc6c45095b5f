//! The length of the way inside of the shape.

use crate::attribute::conformal::{Goal, Interior};
use crate::node::conformal::{LATTICE, METHOD, OUTSIDE, SPEED, inside, is_smooth_outside, speed_is_used};
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
        "How long the shortest way is that stays inside of the shape, to the nearest of these features: 0 in them. \
         `\"surface\"` is the shape's own, unless a shape has that name. Features stand in the shape's own space, as it is \
         before what bends that; so do lengths, before `scale`.",
    )
    .unit("units"),
    parameters: &[LATTICE, METHOD, SPEED, OUTSIDE],
    formula: "d(p) = inf of the lengths of paths in the shape from p to a feature (CONFORMAL, eq. 1); with a speed of ∫ ds/speed",
    example: "{ interior = [\"b\"] }",
    is_conformal: true,
    check: speed_is_used,
    build: |source| {
        let goals = source.arguments().goals("interior").cloned().unwrap_or_default();
        // Without a speed the shape's own surface is as far as the depth.
        let has_speed = source.arguments().get("speed").is_some();
        let spread: Vec<_> = goals.iter().copied().filter(|goal| has_speed || goal.is_some()).collect();
        let (body, features) = inside(source, &spread, "interior")?;
        let surface = (!has_speed && goals.contains(&None)).then_some(Goal::Surface);
        let interior = Interior::new(body, features.into_iter().map(Goal::Feature).chain(surface).collect());
        Ok(Paint::of(if is_smooth_outside(source) { interior.smooth() } else { interior }))
    },
    ..Source::PLAIN
};
