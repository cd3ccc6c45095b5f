//! What the rows of colours and numbers that follow the inside of a shape have in common.

use std::sync::Arc;

use crate::attribute::Mix;
use crate::attribute::conformal::{Conformal, Ease, Feature, Member, Method, Zones};
use crate::node::argument::Component;
use crate::node::id::ShapeId;
use crate::node::paint::last_of_each;
use crate::node::painted::Paint;
use crate::node::source::{Inside, InsideRequest, Sourcing};
use crate::text::diagnostic::Diagnostic;
use crate::text::key::Absent::{Nothing, Number, Text};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;
use crate::text::reader::Fields;

/// The most features of one attribute.
const MOST: usize = 64;

/// The most cells of a lattice along the longest side.
pub(crate) const MOST_ALONG: f64 = 512.0;
/// How fine the lattice is.
pub(crate) const LATTICE: Key = Key::new(
    "lattice",
    Kind::Whole,
    Number(96.0),
    "Cells along the longest side of the shape, of a lattice of its own on which ways are sought: the same whatever the \
     voxels are. A way is right to a few hundredths of a cell for each corner that it goes around; arms that are both thinner \
     and nearer to each other than a cell may be taken for one. Walls between rooms are seen down to a twenty-fifth of a \
     cell; of thinner ones a warning tells.",
)
.also(&["cells"])
.limit(Limit::Within(16.0, MOST_ALONG));

/// How the length of ways is found.
pub(crate) const METHOD: Key = Key::new(
    "method",
    Kind::Choice(&["sight", "eikonal"]),
    Text("sight"),
    "How the length of ways is found: by straight lines from bend to bend, right to a fraction of a cell, or by the \
     eikonal equation to first order, about a cell or two too long, which takes a `speed`.",
);

/// How fast ways are gone.
pub(crate) const SPEED: Key = Key::new(
    "speed",
    Kind::OfSpace,
    Nothing,
    "`method = \"eikonal\"`: how fast ways are gone, greater than 0 everywhere inside: what counts is the time, in seconds, of \
     the quickest way. Through the air, where no way inside leads, it is 1.",
)
.limit(Limit::Positive)
.unit("units/s");

/// What holds outside.
pub(crate) const OUTSIDE: Key = Key::new(
    "outside",
    Kind::Choice(&["nearest", "smooth"]),
    Text("nearest"),
    "What holds outside of the shape: what the nearest place of its surface has, which jumps where two places are as near, \
     or the same averaged there, on 64 cells along the longest side: for morphs and for `delay`, which ask outside too, and \
     show such a jump as an edge. The surface and the inside are the same.",
);

/// Whether nothing is to jump outside.
pub(crate) fn is_smooth_outside<const N: usize>(source: &dyn Sourcing<N>) -> bool {
    source.arguments().choice("outside") == Some(&"smooth")
}

/// `speed` goes with one of the methods.
pub(crate) fn speed_is_used(fields: &Fields<'_, '_>, _has_cells: bool) -> Option<Diagnostic> {
    let is_eikonal = fields.entry("method").is_some_and(|entry| entry.value.text() == Some("eikonal"));
    let entry = fields.entry("speed").filter(|_| !is_eikonal)?;
    let problem = Diagnostic::error(entry.key_span, "`speed` is for `method = \"eikonal\"` only");
    Some(problem.help("`sight` measures lengths: add `method = \"eikonal\"`, or leave `speed` out"))
}

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

/// The inside of the shape with some features, `None` the shape's own surface, as the row's keys have it.
pub(crate) fn inside<const N: usize>(
    source: &mut dyn Sourcing<N>,
    features: &[Option<ShapeId>],
    key: &'static str,
) -> Result<Inside, Problem> {
    let arguments = source.arguments();
    let along = arguments.whole("lattice").and_then(|cells| u32::try_from(*cells).ok()).expect("it has a default");
    let is_eikonal = arguments.choice("method") == Some(&"eikonal");
    let component = arguments.component("speed").cloned();
    let speed = component.as_ref().map(Component::span);
    let method = match (is_eikonal, &component) {
        (false, _) => Method::Sight,
        (true, None) => Method::Eikonal { speed: None },
        (true, Some(component)) => Method::Eikonal { speed: Some(source.component(component)?) },
    };
    source.inside(&InsideRequest { features, along, method, speed, key })
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
    let mut found = Vec::with_capacity(shapes.len());
    for shape in &shapes {
        found.push(source.of_shape(*shape)?);
    }
    if found.iter().all(Option::is_none) {
        return Err(source.none_has(&shapes));
    }
    let absent = source.absent();
    let paints: Vec<Paint<N>> = found.into_iter().map(|paint| paint.unwrap_or_else(|| Paint::solid(absent))).collect();
    let goals: Vec<_> = shapes.into_iter().map(Some).collect();
    let (body, features) = inside(source, &goals, "conformal")?;
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
    let conformal = Conformal::new(body, members, zones, mixes);
    Ok(if is_smooth_outside(source) { Paint::of(conformal.smooth()) } else { Paint::of(conformal) })
}
