//! The way that a morph's objects are carried along, as the morph takes it.

use glam::DVec3;

use crate::field::Aabb;
use crate::morph::{self, Motion, Side, Untold};

use crate::node::model::{Anchor, Model, Morph, MorphCarry};
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::problem::Problem;

/// Times of a morph's span at which boxes are compared.
const STEPS: usize = 160;

/// The carry of a morph from one solid to another, each by its box in its own space and its motion; `over` are the scene
/// times at which the shape starts and ends to change.
pub(crate) fn carry(morph: &Morph, solids: [(Aabb, &Motion); 2], over: [f64; 2]) -> morph::Carry {
    match &morph.carry {
        MorphCarry::Left if morph.mode.spec.carries_apart && !meet(solids, over) => morph::Carry::Centroid,
        MorphCarry::Left | MorphCarry::None => morph::Carry::None,
        MorphCarry::Centroid => morph::Carry::Centroid,
        MorphCarry::Inertia => morph::Carry::Inertia,
        MorphCarry::Anchors(pairs) => {
            let place = |anchor: Anchor| DVec3::from_array(anchor.at);
            morph::Carry::Anchors(pairs.iter().map(|pair| pair.map(place)).collect())
        }
    }
}

/// Whether the boxes of two solids meet at any time.
fn meet(solids: [(Aabb, &Motion); 2], [start, end]: [f64; 2]) -> bool {
    let last = if solids.iter().all(|(_, motion)| motion.is_still()) { 0 } else { STEPS };
    (0..=last).any(|step| {
        let time = start + (end - start) * (step as f64 / STEPS as f64);
        let [one, two] = solids.map(|(solid, motion)| motion.at(time).box_to_world(solid));
        one.intersection(two).is_some()
    })
}

/// What is wrong with the anchors of a morph; `None` where the error is another.
pub(crate) fn anchors_problem(model: &Model, morph: &Morph, error: &morph::Error) -> Option<Problem> {
    let MorphCarry::Anchors(pairs) = &morph.carry else { return None };
    let problem = match error {
        morph::Error::AnchorOutside { place, side } => {
            let (which, id, frame) = match side {
                Side::From => (0, morph.from, morph.over.first),
                Side::To => (1, morph.to, morph.over.last),
            };
            let anchor = pairs.get(*place)?[which];
            let name = clip(&model.shape(id).name);
            let [x, y, z] = anchor.at;
            let what = format!("the anchor [{x}, {y}, {z}] lies outside of `{name}`, as that stands at frame {frame}");
            Problem::new(anchor.span, what).help("anchors are places in the world, in a shape or on it")
        }
        morph::Error::AnchorsAlike => Problem::new(pairs[0][0].span, error.to_string()).help("move them apart"),
        morph::Error::AnchorsInLine => Problem::new(pairs[0][0].span, error.to_string())
            .help("two tell the least turn; or add one beside the line"),
        _ => return None,
    };
    Some(problem)
}

/// What the carry of a morph leaves out, as nothing decides it.
pub(crate) fn untold<'a>(
    model: &'a Model,
    morph: &'a Morph,
    planned: &'a morph::Morph,
) -> impl Iterator<Item = Diagnostic> + 'a {
    let name = |side: Side| clip(&model.shape(if side == Side::From { morph.from } else { morph.to }).name);
    planned.untold().iter().map(move |untold| match untold {
        Untold::Axes(side) => {
            let what = format!("`{}` is about as long in every direction: `carry` turns nothing", name(*side));
            Diagnostic::warning(morph.span, what).help("carry = \"anchors\" with two places or more tells a turn")
        }
        Untold::AboutAxis(side) => {
            let name = name(*side);
            let what =
                format!("only one axis of `{name}` is clearly longer or shorter: `carry` does not turn about it");
            Diagnostic::warning(morph.span, what).help("carry = \"anchors\" with three places or more tells all turns")
        }
        Untold::HalfTurn => {
            let span = match &morph.carry {
                MorphCarry::Anchors(pairs) => pairs[0][0].span,
                _ => morph.span,
            };
            let what = "the anchors ask for half a turn, which goes about any axis across: that nearest to z is taken";
            Diagnostic::warning(span, what).help("a third anchor tells which")
        }
    })
}
