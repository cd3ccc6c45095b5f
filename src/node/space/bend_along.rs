//! A shape bent along a curve.

use std::sync::Arc;

use glam::DVec3;

use crate::field::{Aabb, Bent, Expression, Folded, Graph, Node, Spine};
use crate::node::bend::Bend;
use crate::node::curves::line_along;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Text, Vector};
use crate::text::key::{Key, Kind};

/// Bent along a curve.
pub const NODE: Spec = Spec {
    key: Key::new(
        "bend_along",
        Kind::Places,
        Nothing,
        "Lays the z axis along a curve of these points, `[[x, y, z], …]`, or of those of a file; x and y stand across it and turn about it no more than they must.",
    )
    .unit("units"),
    parameters: &[
        Key::new(
            "bend_curve",
            Kind::Choice(&["smooth", "bezier", "b_spline"]),
            Text("smooth"),
            "Smooth through the points (Catmull and Rom), or by Bézier or B-spline from the first to the last.",
        ),
        Key::new(
            "bend_fit",
            Kind::Choice(&["whole", "lengths"]),
            Text("whole"),
            "`whole` stretches the shape from the beginning of the curve to its end; with `lengths` its lower end stands there and it keeps its length, and goes straight on beyond the end. A move along z before it changes nothing.",
        ),
        Key::new("bend_up", Kind::Direction, Vector([0.0, 0.0, 1.0]), "Where its y axis points at the beginning, as far as it can."),
    ],
    formula: "f((p − c)·n, (p − c)·b, s), c the nearest place of the curve, at the length s, and n, b across it",
    source: "Wang, Jüttler, Zheng and Liu, Computation of rotation minimizing frames, 2008",
    example: "box = [0.5, 0.16, 2]\ntwist = 180\nbend_along = [[-1, -0.8, 0], [-0.7, 0.3, 0.1], [0, 0.8, 0.3], [0.7, 0.3, 0.5], [1, -0.8, 0.6]]",
    bend: Some(|build| {
        let curve = build.arguments().choice("bend_curve").copied().unwrap_or("smooth");
        let line = line_along(build, "bend_along", curve, false)?;
        let inner = build.inner()?;
        if build.graph().is_flat(inner) {
            let problem = format!("`bend_along` bends solids, and `{}` is a shape of the plane", build.name());
            return Err(build.wrong("bend_along", problem).help("extrude it first, and bend the solid"));
        }
        // What construction tells of a box may be larger than the solid, which would not reach the curve's ends then.
        let own = build.solid_box(inner)?;
        let solid = Expression::new(build.graph(), inner);
        let height = own.max.z - own.min.z;
        let spine = Spine::new(&line, build.direction("bend_up")?);
        let is_whole = build.arguments().choice("bend_fit") != Some(&"lengths");
        if is_whole && height <= 0.0 {
            return Err(build.wrong("bend_along", format!("`{}` has no height to be stretched", build.name())));
        }
        let stretch = if is_whole { height / spine.length() } else { 1.0 };
        match Bent::new(solid, own, spine, own.min.z, stretch) {
            Ok(bent) => Ok(Arc::new(Along(Arc::new(bent)))),
            Err(Folded { at, radius, reach }) => {
                let problem = format!("`{}` folds where the curve turns sharply, at [{:.4}, {:.4}, {:.4}]", build.name(), at.x, at.y, at.z);
                let help = format!("the curve's radius there is {radius:.4} units, and the shape reaches {reach:.4} to its middle: a thinner shape, or points that turn less");
                Err(build.wrong("bend_along", problem).help(help))
            }
        }
    }),
    ..Spec::PLAIN
};

struct Along(Arc<Bent>);

impl Bend for Along {
    fn node(&self, graph: &mut Graph, _node: Node) -> Node {
        let node = graph.field(Arc::clone(&self.0) as _);
        // It is held below minus the distance to its box.
        graph.falling(node, 1.0)
    }

    fn back(&self, position: DVec3) -> DVec3 {
        self.0.back(position)
    }

    fn region(&self, region: &Aabb) -> Aabb {
        self.0.region_back(region)
    }

    fn carried(&self, position: DVec3, vector: DVec3) -> DVec3 {
        self.0.carried(position, vector)
    }

    fn forth(&self, own: DVec3, _branch: u32) -> Option<DVec3> {
        Some(self.0.forth(own))
    }

    fn goes_by_box(&self) -> bool {
        true
    }
}
