//! Cubist versions of a shape: the piece of it in each cell on its surface is cut by a plane tilted at random and
//! grown a little, at random too, so that facets meet in steps.
//!
//! Our reading of "local faceting and distortions" in dynamic 4D heterogeneous cubism (papers: heterogeneous STB,
//! section 3.1). The result is one expression over the shape's own value, so the shape is evaluated once a point
//! however many cells there are.

mod cut;
mod mend;
mod pieces;
#[cfg(test)]
mod tests;

use glam::DVec3;

use super::cells::{CellId, Cells};
use super::{Aabb, Expression, Field, Gradients, Graph, Node, Points, SetSystem};
use cut::{Piece, Plane};
pub use pieces::Pieces;

/// How facets are cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// The most a facet is tilted from the shape's surface, degrees, 0 … 60.
    pub tilt: f64,
    /// The deepest cut below the shape's surface, world units. In a small or thin cell it is less: no more than half
    /// the cell's edge and half the depth of the shape in it, so that a cut takes no cell off the body.
    pub cut: f64,
    /// What all random choices are drawn from.
    pub seed: u64,
}

/// A faceted shape.
#[derive(Clone)]
pub struct Facet {
    /// The solid in the graph, positive inside; not a distance.
    pub node: Node,
    /// What it is made of, its core not counted.
    pub pieces: Pieces,
    /// How many cells were left whole, since cutting them would have left a crumb or a hollow.
    pub mended: usize,
}

/// The faceted version of a shape whose surface the cells were built on.
pub fn facet(graph: &mut Graph, shape: Node, cells: &Cells, options: &Options) -> Facet {
    let field = Expression::new(graph, shape).keeping_values();
    let (pieces, mended) = mend::sound_pieces(&field, cells, options);
    let node = assemble(graph, shape, &pieces);
    Facet { node, pieces: Pieces::new(field, pieces, cells), mended }
}

/// Copies of a shape around the points of another's surface that are nearest to the middles of some cells; nothing
/// where no cells are given. `host` is the field the cells were built on.
pub fn scatter(graph: &mut Graph, shape: Node, host: &dyn Field, cells: &Cells, picked: &[CellId]) -> Node {
    let copy = |at: DVec3| {
        // A translation by a finite vector can always be undone.
        graph.translate(shape, at).unwrap_or(shape)
    };
    let copies: Vec<Node> = surface_points(host, cells, picked).into_iter().map(copy).collect();
    graph.union(SetSystem::MinMax, &copies)
}

/// For each cell, a point of the shape's surface close to its middle, found by Newton steps along the gradient.
pub fn surface_points(field: &dyn Field, cells: &Cells, of: &[CellId]) -> Vec<DVec3> {
    let mut evaluator = field.evaluator();
    let mut out = Gradients::new();
    let mut project = |&id: &CellId| {
        let bounds = cells.cell(id).bounds;
        let mut position = bounds.centre();
        for _ in 0..12 {
            let mut points = Points::new(position);
            points.push(glam::Vec3::ZERO);
            evaluator.gradients(&points, &mut out);
            let gradient = out.gradient(0).as_dvec3();
            let step = gradient * (f64::from(out.value[0]) / gradient.length_squared());
            // No way to go, or out of the neighbourhood: the cell's middle, at worst, is where it was.
            if !step.is_finite() || !bounds.grown(bounds.size().x).contains(position - step) {
                break;
            }
            position -= step;
        }
        position
    };
    of.iter().map(&mut project).collect()
}

/// The union of all pieces and of what no cut reaches.
fn assemble(graph: &mut Graph, shape: Node, pieces: &[Piece]) -> Node {
    let deepest = pieces.iter().map(|piece| piece.depth).fold(0.0, f64::max);
    let solids: Vec<Node> = pieces.iter().map(|piece| one(graph, shape, piece)).collect();
    // Walls between cells end here: without the core every wall inside the body would look like a surface to bounds.
    let core = graph.offset(shape, -deepest);
    let shell = graph.union(SetSystem::MinMax, &solids);
    graph.union(SetSystem::MinMax, &[core, shell])
}

fn one(graph: &mut Graph, shape: Node, piece: &Piece) -> Node {
    let Aabb { min, max } = piece.bounds;
    let mut parts = vec![graph.offset(shape, piece.lift)];
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        parts.push(graph.half_space(-axis, -min.dot(axis)));
        parts.push(graph.half_space(axis, max.dot(axis)));
    }
    parts.extend(piece.planes.iter().map(|&Plane { normal, offset }| graph.half_space(normal, offset)));
    let solid = graph.intersection(SetSystem::MinMax, &parts);
    graph.bounded(solid, piece.bounds)
}
