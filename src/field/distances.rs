//! Distances of set operations, from those of their operands.
//!
//! Outside of a union the nearest surface is that of the nearest operand, and inside an intersection likewise: there the
//! maximum and the minimum of exact distances are exact distances, where R₀ functions have no more than the zero set in
//! common with them. On the other side, and wherever an operand's value is not a distance, one has to be measured.

use std::collections::BTreeMap;

use super::Slope;
use super::graph::{Graph, Node};
use super::leaf::Affine;
use super::op::{Binary, Op, Set, Unary};

/// A side of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Side {
    /// Where F < 0.
    Outside,
    /// Where F > 0.
    Inside,
}

impl Side {
    fn other(self) -> Self {
        match self {
            Self::Outside => Self::Inside,
            Self::Inside => Self::Outside,
        }
    }
}

impl Slope {
    /// Whether the value is the distance on a side.
    pub fn is_exact(self, side: Side) -> bool {
        matches!(
            (self, side),
            (Self::Exact { outside: true, .. }, Side::Outside) | (Self::Exact { inside: true, .. }, Side::Inside)
        )
    }
}

/// Where the distance of a solid on one side comes from.
enum Origin {
    /// It is the value.
    Value,
    /// It is this form of unit slope.
    Plane(Affine),
    /// The maximum or minimum of two solids' distances on the same side.
    Of(Binary, [Node; 2]),
    /// It is another solid's.
    Same(Node),
    /// It is that of the complement's other side, turned.
    Turned(Node),
    /// Nothing tells it.
    Unknown,
}

/// A solid's distance on a side.
type Wanted = (Node, Side);

impl Graph {
    fn origin_of(&self, (solid, side): Wanted) -> Origin {
        if self.slope(solid).is_exact(side) {
            return Origin::Value;
        }
        let both = |a: u32, b: u32| [Node(a), Node(b)];
        match (self.op(solid), side) {
            (Op::Affine(index), _) => {
                let form = self.affines[index as usize];
                let length = form.slope.length();
                if length > 0.0 { Origin::Plane(form.linear(1.0 / length, 0.0)) } else { Origin::Unknown }
            }
            (Op::Binary(operation, a, b), _) => match (operation.nature().set, side) {
                (Some(Set::Union), Side::Outside) => Origin::Of(Binary::Max, both(a, b)),
                (Some(Set::Intersection), Side::Inside) => Origin::Of(Binary::Min, both(a, b)),
                _ => Origin::Unknown,
            },
            (Op::Unary(Unary::Linear { scale, offset: 0.0 }, a), _) if scale > 0.0 => Origin::Same(Node(a)),
            (Op::Unary(Unary::Linear { scale, offset: 0.0 }, a), _) if scale < 0.0 => Origin::Turned(Node(a)),
            _ => Origin::Unknown,
        }
    }

    /// What a solid's distance on a side comes from, each before what comes from it, as far as it is not known; with its
    /// place in the order in which operations name their operands.
    fn origins(
        &self,
        solid: Node,
        side: Side,
        known: &BTreeMap<(Node, Side), Node>,
    ) -> BTreeMap<Wanted, (usize, Origin)> {
        let mut origins = BTreeMap::new();
        let mut open = vec![(solid, side)];
        while let Some(wanted) = open.pop() {
            if known.contains_key(&wanted) || origins.contains_key(&wanted) {
                continue;
            }
            let origin = self.origin_of(wanted);
            match origin {
                Origin::Of(_, [a, b]) => open.extend([(a, wanted.1), (b, wanted.1)]),
                Origin::Same(a) => open.push((a, wanted.1)),
                Origin::Turned(a) => open.push((a, wanted.1.other())),
                Origin::Value | Origin::Plane(_) | Origin::Unknown => {}
            }
            origins.insert(wanted, (origins.len(), origin));
        }
        origins
    }

    /// The parts of a solid whose distances have to be measured, and on which side, for that of the solid on one side. In
    /// an order that does not hang on what else the graph holds.
    pub fn to_measure(&self, solid: Node, side: Side) -> Vec<(Node, Side)> {
        let unknown = |(wanted, (place, origin))| matches!(origin, Origin::Unknown).then_some((place, wanted));
        let origins = self.origins(solid, side, &BTreeMap::new());
        let mut parts: Vec<(usize, Wanted)> = origins.into_iter().filter_map(unknown).collect();
        parts.sort_unstable_by_key(|(place, _)| *place);
        parts.into_iter().map(|(_, wanted)| wanted).collect()
    }

    /// A solid's distance on a side, a node with the same zero set, from those that were measured; `None` where some of
    /// [`Self::to_measure`] is not among these.
    pub fn distance(&mut self, solid: Node, side: Side, measured: &BTreeMap<(Node, Side), Node>) -> Option<Node> {
        let mut made = measured.clone();
        // Arguments come before their operation, and so do their distances.
        for (wanted, (_, origin)) in self.origins(solid, side, measured) {
            let (node, side) = wanted;
            let distance = match origin {
                Origin::Value => node,
                Origin::Plane(form) => self.affine_leaf(form),
                Origin::Of(operation, [a, b]) => self.binary(operation, made[&(a, side)], made[&(b, side)]),
                Origin::Same(a) => made[&(a, side)],
                Origin::Turned(a) => self.neg(made[&(a, side.other())]),
                Origin::Unknown => return None,
            };
            made.insert(wanted, distance);
        }
        made.get(&(solid, side)).copied()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::{Expression, Field, SetSystem};
    use glam::DVec3;

    fn balls(graph: &mut Graph) -> [Node; 2] {
        let ball = graph.sphere(1.0);
        [ball, graph.translate(ball, DVec3::X * 0.5).expect("it moves")]
    }

    #[test]
    fn outside_of_a_union_the_nearest_operand_is_as_far() {
        let mut graph = Graph::new();
        let [a, b] = balls(&mut graph);
        let union = graph.union(SetSystem::R0, &[a, b]);
        assert_eq!(graph.to_measure(union, Side::Outside), []);
        assert_eq!(graph.to_measure(union, Side::Inside), [(union, Side::Inside)]);
        let distance = graph.distance(union, Side::Outside, &BTreeMap::new()).expect("nothing is measured");
        assert!(graph.slope(distance).is_exact(Side::Outside));
        let field = Expression::new(&graph, distance);
        for (at, wanted) in
            [(DVec3::X * 2.0, -0.5), (DVec3::X * -3.0, -2.0), (DVec3::new(0.25, 3.0, 0.0), 1.0 - 9.0625_f64.sqrt())]
        {
            assert!((field.reference(at) - wanted).abs() < 1e-12, "{at}");
        }
    }

    #[test]
    fn what_is_taken_away_counts_by_its_other_side() {
        let mut graph = Graph::new();
        let [a, b] = balls(&mut graph);
        let egg = graph.ellipsoid(DVec3::new(1.0, 0.5, 0.5));
        let (rest, other) = (graph.difference(SetSystem::R0, a, &[b]), graph.difference(SetSystem::R0, a, &[egg]));
        let distance = graph.distance(rest, Side::Inside, &BTreeMap::new()).expect("nothing is measured");
        assert!((Expression::new(&graph, distance).reference(DVec3::X * -0.8) - 0.2).abs() < 1e-12);
        assert!((Expression::new(&graph, distance).reference(DVec3::X * -0.6) - 0.1).abs() < 1e-12);
        let parts = graph.to_measure(other, Side::Inside);
        assert_eq!(parts.len(), 1);
        assert_eq!(graph.distance(other, Side::Inside, &BTreeMap::new()), None);
        let measured = BTreeMap::from([(parts[0], graph.neg(b))]);
        assert_eq!(graph.distance(other, Side::Inside, &measured), Some(distance));
    }

    #[test]
    fn planes_of_any_length_are_distances() {
        let mut graph = Graph::new();
        let steep = graph.affine(DVec3::new(3.0, 0.0, 4.0), 10.0);
        let distance = graph.distance(steep, Side::Outside, &BTreeMap::new()).expect("nothing is measured");
        assert_eq!(Expression::new(&graph, distance).reference(DVec3::ZERO), 2.0);
    }
}
