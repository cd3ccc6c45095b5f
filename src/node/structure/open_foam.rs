//! Open foam.

use std::sync::Arc;

use glam::DVec3;

use crate::field::{Joined, OpenFoam, Seeds, Strut, Struts, edges_of, shares_at};
use crate::node::keys::seed;
use crate::node::lattice::{of_radius, radii, radius};
use crate::node::spec::Spec;
use crate::node::structure::pores::JITTER;
use crate::text::key::Absent::Required;
use crate::text::key::Key;

/// Of the largest size, a cell reaches nowhere farther from its point: darts leave no gap of that size.
const FAR: f64 = 2.0;

/// Open foam.
pub const NODE: Spec = Spec {
    key: Key::length(
        "open_foam",
        Required,
        "Open foam: round struts where the cells of points at random meet, one point in each cube of a lattice: the cubes' edge. \
         Unbounded: cut it with `bounds`, `intersection`, or as what a shape is filled with.",
    ),
    parameters: &[radius("open_foam"), JITTER, seed("The number that the points start from.")],
    formula: "r − the distance to the nearest edge of a Voronoi cell",
    source: "Voronoi cells",
    example: "open_foam = 0.6\nbounds = { box = 1.6, cut = true }",
    is_endless: true,
    graded: Some(|build, grading| {
        let Some(radius) = radii(build, grading, "open_foam")? else { return Ok(None) };
        let size = grading.ends(build, "open_foam")?;
        let cells = grading.cells(build, "open_foam", size)?;
        let edges = edges_of(cells.into_iter().map(|cell| cell.at).collect(), FAR * size.0[0].max(size.0[1]));
        let ends = shares_at(grading.by.as_ref(), edges.as_flattened());
        let ends = ends.map_err(|error| grading.failed(build, "open_foam", size, error))?;
        let strut =
            |([from, to], ends): (&[DVec3; 2], &[f64; 2])| Strut::new(*from, *to, ends.map(|share| radius.at(share)));
        let struts: Vec<Strut> = edges.iter().zip(ends.as_chunks().0).map(strut).collect();
        if struts.is_empty() {
            return Err(build.wrong("open_foam", "there are fewer than four cells, between which there are no struts"));
        }
        Ok(Some(build.graph().field(Joined::shared(Struts::new(struts)))))
    }),
    build: |build| {
        let (edge, jitter) = (build.number("open_foam")?, build.constant("jitter"));
        let seeds = Seeds { edge, jitter, seed: *build.arguments().seed("seed").expect("it has a default") };
        of_radius(build, |graph, radius| graph.field(Arc::new(OpenFoam { seeds, radius })))
    },
    ..Spec::PLAIN
};
