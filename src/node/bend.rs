//! Maps of space: one carries the field, the attributes and the motion of what is moved, bent or copied.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use crate::attribute::CellIndex;
use crate::field::{Aabb, Expression, Field, Graph, Interval, Node, Points, Slope};

/// A map of a shape's own space onto another. Where it is not one to one (mirrors, copies), a *branch* tells which of the
/// images of its own space a position lies in.
pub trait Bend: Send + Sync {
    /// A node read through it.
    fn node(&self, graph: &mut Graph, node: Node) -> Node;
    /// Where a position comes from.
    fn back(&self, position: DVec3) -> DVec3;
    /// A box that holds all that a box comes from.
    fn region(&self, region: &Aabb) -> Aabb;
    /// A vector at the place that a position comes from, as it is at the position.
    fn carried(&self, position: DVec3, vector: DVec3) -> DVec3;

    /// The image that a position lies in.
    fn branch(&self, _position: DVec3) -> u32 {
        0
    }

    /// Where a place of the shape's own space goes in an image; `None` where that is not known.
    fn forth(&self, _own: DVec3, _branch: u32) -> Option<DVec3> {
        None
    }

    /// Whether it goes by the box of what is bent, and so changes whenever that does.
    fn goes_by_box(&self) -> bool {
        false
    }

    /// Its images as cells that take a value each, where they are.
    fn cells(&self) -> Option<Arc<dyn CellIndex>> {
        None
    }

    /// Where a batch comes from.
    fn points_back(&self, points: &Points, out: &mut Points) {
        (out.origin, out.len) = (self.back(points.origin), 0);
        for i in 0..points.len {
            out.push((self.back(points.position(i)) - out.origin).as_vec3());
        }
    }

    /// The vectors at the places that a batch comes from, as they are at the batch.
    fn vectors_carried(&self, points: &Points, vectors: &mut [[f32; 3]]) {
        for (i, vector) in vectors.iter_mut().enumerate().take(points.len) {
            let carried = self.carried(points.position(i), DVec3::from_array(vector.map(f64::from)));
            *vector = carried.as_vec3().to_array();
        }
    }
}

/// A map that keeps straight lines straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight {
    forth: DAffine3,
    back: DAffine3,
}

impl Straight {
    /// `None` where it flattens space.
    pub fn new(forth: DAffine3) -> Option<Self> {
        let back = forth.inverse();
        let determinant = forth.matrix3.determinant();
        (determinant != 0.0 && forth.is_finite() && back.is_finite()).then_some(Self { forth, back })
    }
}

impl Bend for Straight {
    fn node(&self, graph: &mut Graph, node: Node) -> Node {
        if self.forth == DAffine3::IDENTITY {
            return node;
        }
        // It can be undone: `new` looked.
        graph.transform(node, &self.forth).unwrap_or(node)
    }

    fn back(&self, position: DVec3) -> DVec3 {
        self.back.transform_point3(position)
    }

    fn region(&self, region: &Aabb) -> Aabb {
        around(region.corners().map(|corner| self.back(corner)))
    }

    fn carried(&self, _position: DVec3, vector: DVec3) -> DVec3 {
        self.forth.matrix3 * vector
    }

    fn forth(&self, own: DVec3, _branch: u32) -> Option<DVec3> {
        Some(self.forth.transform_point3(own))
    }
}

/// The box around some positions, of which there is at least one.
pub(crate) fn around(corners: impl IntoIterator<Item = DVec3>) -> Aabb {
    let single = |corner: DVec3| Aabb::new(corner, corner);
    corners.into_iter().map(single).reduce(Aabb::union).unwrap_or(single(DVec3::ZERO))
}

/// A place of a shape's own space, where that goes.
pub(crate) type Forth = Box<dyn Fn(DVec3) -> DVec3 + Send + Sync>;

/// Three coordinates as nodes of a graph.
type Coordinates = Box<dyn Fn(&mut Graph) -> [Node; 3] + Send + Sync>;

/// A map given by the three coordinates, as nodes of a graph, that a position comes from.
pub(crate) struct Mapped {
    make: Coordinates,
    coordinates: [Expression; 3],
    /// How steep the map is at most, where that is known everywhere.
    steepest: Option<f64>,
    /// A box that holds the mapped shape, where it is known.
    solid: Option<Aabb>,
    forth: Option<Forth>,
}

impl Mapped {
    /// The map that takes a position to these coordinates.
    pub fn new(make: impl Fn(&mut Graph) -> [Node; 3] + Send + Sync + 'static) -> Self {
        let mut graph = Graph::new();
        let nodes = make(&mut graph);
        let coordinates = nodes.map(|node| Expression::new(&graph, node).keeping_values());
        Self { make: Box::new(make), coordinates, steepest: None, solid: None, forth: None }
    }

    /// Two positions come from places no farther apart than this times their distance.
    pub fn steepest(self, bound: f64) -> Self {
        Self { steepest: Some(bound), ..self }
    }

    /// The box of the mapped shape.
    pub fn solid(self, solid: Option<Aabb>) -> Self {
        Self { solid, ..self }
    }

    /// Where places go.
    pub fn forth(self, forth: impl Fn(DVec3) -> DVec3 + Send + Sync + 'static) -> Self {
        Self { forth: Some(Box::new(forth)), ..self }
    }

    /// How the place that a position comes from changes with it.
    fn slopes(&self, position: DVec3) -> DMat3 {
        let step = 1e-6 * (1.0 + position.abs().max_element());
        let along =
            |axis: DVec3| (self.back(position + axis * step) - self.back(position - axis * step)) / (2.0 * step);
        DMat3::from_cols(along(DVec3::X), along(DVec3::Y), along(DVec3::Z))
    }
}

impl Bend for Mapped {
    fn node(&self, graph: &mut Graph, node: Node) -> Node {
        let slope = graph.slope(node);
        let coordinates = (self.make)(graph);
        let mut mapped = graph.warp(node, coordinates);
        let bound = match slope {
            Slope::Exact { .. } => Some(1.0),
            Slope::Lipschitz(bound) => Some(bound),
            Slope::Unknown => None,
        };
        if let Some(bound) = bound.zip(self.steepest).map(|(bound, steepest)| bound * steepest) {
            mapped = graph.no_steeper(mapped, bound);
        }
        match self.solid {
            Some(solid) => graph.bounded(mapped, solid),
            None => mapped,
        }
    }

    fn back(&self, position: DVec3) -> DVec3 {
        let [x, y, z] = &self.coordinates;
        DVec3::new(x.reference(position), y.reference(position), z.reference(position))
    }

    fn region(&self, region: &Aabb) -> Aabb {
        let bounds = self.coordinates.each_ref().map(|coordinate| {
            let mut evaluator = coordinate.evaluator();
            evaluator.enter(region);
            evaluator.bounds()
        });
        let corner = |end: fn(&Interval) -> f64| DVec3::from_array(bounds.each_ref().map(end));
        Aabb::new(corner(|bounds| bounds.lo), corner(|bounds| bounds.hi))
    }

    fn carried(&self, position: DVec3, vector: DVec3) -> DVec3 {
        let slopes = self.slopes(position);
        // Where it is flat there is nothing to carry a vector by.
        if slopes.determinant().abs() < 1e-9 { DVec3::ZERO } else { slopes.inverse() * vector }
    }

    fn forth(&self, own: DVec3, _branch: u32) -> Option<DVec3> {
        self.forth.as_ref().map(|forth| forth(own))
    }
}

/// A box that holds all of one turned about z by any angle.
pub(crate) fn turned_about_z(own: &Aabb) -> Aabb {
    let far = own.min.abs().max(own.max.abs());
    let reach = far.x.hypot(far.y);
    Aabb::new(DVec3::new(-reach, -reach, own.min.z), DVec3::new(reach, reach, own.max.z))
}
