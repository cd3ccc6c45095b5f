//! What the rows of colours and numbers that follow the inside of a shape have in common.

use std::sync::Arc;

use crate::attribute::Mix;
use crate::attribute::conformal::{Conformal, Ease, Feature, Member, Zones};
use crate::node::id::ShapeId;
use crate::node::paint::last_of_each;
use crate::node::painted::Paint;
use crate::node::source::Sourcing;
use crate::text::key::Absent::{Number, Text};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// The most features of one attribute.
const MOST: usize = 64;

/// How fine the lattice is.
pub(crate) const LATTICE: Key = Key::new(
    "lattice",
    Kind::Whole,
    Number(96.0),
    "Cells along the longest side of the shape, of a lattice of its own on which ways are sought: the same whatever the \
     voxels are. A way is too long by a fraction of a cell for each corner that it goes around; arms that are both thinner \
     and nearer to each other than a cell may be taken for one.",
)
.also(&["cells"])
.limit(Limit::Within(16.0, 512.0));

/// How wide the zones are.
pub(crate) const SPREAD: Key = Key::new(
    "spread",
    Kind::Constant,
    Number(1.0),
    "The share of the way between two features over which they go over into one another, in the middle of it; none is \
     narrower than a cell, so that 0.01 gives cells.",
)
.limit(Limit::Within(1e-6, 1.0));

/// How values go over.
pub(crate) const EASE: Key = Key::new(
    "ease",
    Kind::Choice(&["linear", "smooth"]),
    Text("linear"),
    "How they go over: in a straight line, or from rest to rest, without an edge at the ends of the zones.",
);

/// The cells along the longest side.
pub(crate) fn lattice<const N: usize>(source: &dyn Sourcing<N>) -> u32 {
    source.arguments().whole("lattice").and_then(|cells| u32::try_from(*cells).ok()).expect("it has a default")
}

/// The features of a row.
pub(crate) fn features<const N: usize>(source: &dyn Sourcing<N>) -> Result<Vec<ShapeId>, Problem> {
    let features = last_of_each(source.arguments().shapes("conformal").map_or(&[], |shapes| shapes));
    match features.len() > MOST {
        true => Err(source.problem(&format!("`conformal` has {} features, and {MOST} are the most", features.len()))),
        false => Ok(features),
    }
}

/// What features have, by the ways to them. `mix`: how what comes before a feature is mixed with it, from a value of each.
pub(crate) fn conformal<const N: usize, M: Mix<N> + 'static>(
    source: &mut dyn Sourcing<N>,
    mix: impl Fn([f32; N], [f32; N]) -> M,
) -> Result<Paint<N>, Problem> {
    let shapes = features(source)?;
    let mut paints = Vec::with_capacity(shapes.len());
    for shape in &shapes {
        let absent = source.absent();
        paints.push(source.of_shape(*shape)?.unwrap_or_else(|| Paint::solid(absent)));
    }
    let (body, features) = source.inside(&shapes, lattice(source), "conformal")?;
    if let Some(value) = paints[0].solid.filter(|value| paints.iter().all(|paint| paint.solid == Some(*value))) {
        return Ok(Paint::solid(value));
    }
    let arguments = source.arguments();
    let spread = *arguments.constant("spread").expect("it has a default");
    let ease = if arguments.choice("ease") == Some(&"smooth") { Ease::Smooth } else { Ease::Linear };
    let all: Vec<&Feature> = features.iter().map(Arc::as_ref).collect();
    let zones = Zones::new(&body, &all, spread, ease);
    // Nearly opposite hues go the way of plain colours; of others any.
    let plain = |paint: &Paint<N>| paint.solid.unwrap_or_else(|| source.absent());
    let mixes = paints.array_windows().map(|[one, two]| mix(plain(one), plain(two))).collect();
    let members: Vec<Member<N>> = features.into_iter().zip(paints.into_iter().map(|paint| paint.attribute)).collect();
    Ok(Paint::of(Conformal { body, members, zones, mixes }))
}
