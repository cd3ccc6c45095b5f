//! A shape filled with a structure.

use std::sync::Arc;

use crate::field::{Interval, Node};
use crate::node::displacement::{mixing, structures_mixed};
use crate::node::spec::{Build, Spec};
use crate::text::key::Absent::{Nothing, Number};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// A shape filled with a structure.
pub const NODE: Spec = Spec {
    key: Key::new(
        "fill",
        Kind::Shape,
        Nothing,
        "What its inside is made of: another shape, such as `gyroid`, `foam` or `pores`, where that stands in this one's own \
         space.",
    ),
    parameters: &[
        Key::new(
            "fill_to",
            Kind::Shape,
            Nothing,
            "What `fill` goes over into, by `fill_by`: another structure, or the same one thicker. Sheets of one `gyroid` that differ \
             in `thickness` are as thick as the mean of both by ω. Two `foam`s or two `pores` are one whose cells go over from the \
             size of the first to that of the second, up to 64 times as large; each has the wall or the radius of its middle, and \
             the `seed` is the first one's; an ω that changes over time makes other cells. Two lattices of \
             struts, or two minimal surfaces, of one row go over by halves of the larger cell: each half stands where the wanted \
             size is next to its own.",
        ),
        Key::new(
            "fill_by",
            Kind::Scalar,
            Nothing,
            "The attribute of the shape that says how far, ω: 0 is `fill`, 1 is `fill_to`. A depth, a gradient, the weight of a \
             feature along the inside (`conformal`).",
        ),
        Key::new(
            "skin",
            Kind::Number,
            Number(0.0),
            "How thick the whole material below the surface is; 0 is none: the structure is open.",
        )
        .limit(Limit::NotNegative)
        .unit("units"),
    ],
    formula: "min(f, max((1 − ω)·g + ω·h, s − f)), f the signed distance, g and h the structures",
    source: "HFRep, figure 14; STTI, section 6.5; CONFORMAL, section 5",
    example: "sphere = 1\nfill = { gyroid = 0.6, thickness = 0.12 }",
    measures: |_| true,
    build: |build| {
        let solid = build.inner()?;
        let structure = structure(build, solid)?;
        let (skin, ever) = (build.number("skin")?, build.ever("skin")?);
        let inside = if ever.hi > 0.0 {
            let distance = build.distance(solid, Interval::new(0.0, ever.hi), "skin")?;
            let graph = build.graph();
            let wall = graph.linear(distance, -1.0, skin);
            graph.max(structure, wall)
        } else {
            structure
        };
        let filled = build.graph().min(solid, inside);
        Ok(build.held(filled, solid, 0.0))
    },
    ..Spec::PLAIN
};

/// What it is filled with, which goes over into `fill_to` where there is one.
fn structure(build: &mut dyn Build, solid: Node) -> Result<Node, Problem> {
    let from = *build.arguments().shape("fill").expect("it must be there");
    let (to, by) = (build.arguments().shape("fill_to").copied(), build.arguments().scalar("fill_by").cloned());
    let (to, by) = match (to, by) {
        (None, None) => return build.shape(from),
        (Some(to), Some(by)) => (to, by),
        (Some(_), None) => {
            let problem = build.wrong("fill_to", "`fill_to` goes with `fill_by`");
            return Err(problem.help("the attribute that mixes both: fill_by = \"how_far\""));
        }
        (None, Some(_)) => {
            let problem = build.wrong("fill_by", "`fill_by` goes with `fill_to`");
            return Err(problem.help("the structure that it goes over into: fill_to = \"other\""));
        }
    };
    let aabb = build.solid_box(solid)?;
    let Some(scalar) = build.scalar(&by.name, aabb)? else { return build.shape(from) };
    let omega = mixing(scalar, aabb.size().max_element());
    if let Some(graded) = build.graded([from, to], (&by, Arc::clone(&omega)), (solid, aabb))? {
        return Ok(graded);
    }
    let structures = [build.shape(from)?, build.shape(to)?];
    Ok(structures_mixed(build.graph(), structures, omega))
}
