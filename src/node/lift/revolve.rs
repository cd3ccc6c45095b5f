//! A shape of the plane, turned about an axis.

use glam::{DVec2, DVec3};

use crate::field::{Aabb, Expression, Field, Graph, Node, Slope};
use crate::node::profile::{plane_box, profile};
use crate::node::spec::{Carries, Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A shape of the plane, turned about an axis.
pub const NODE: Spec = Spec {
    key: Key::new(
        "revolve",
        Kind::Shape,
        Required,
        "A shape of the plane turned about its y axis, which becomes z: its x is the distance from the axis, and what lies at x < 0 is left out.",
    ),
    parameters: &[
        Key::new("axis_offset", Kind::Number, Number(0.0), "How far the shape is moved away from the axis first.")
            .unit("units"),
        Key::new("angle", Kind::Number, Number(360.0), "How far it is turned, its middle on the x axis.")
            .limit(Limit::Within(0.1, 360.0))
            .unit("degrees"),
    ],
    formula: "f(√(x² + y²) − d, z): the signed distance of a whole turn where f is one and no part of the shape lies at x < 0",
    example: "revolve = { star = 0.4 }\naxis_offset = 0.9\nangle = 250",
    carries: Carries::First,
    plane: Plane::Lifts,
    build: |build| {
        let profile = profile(build, "revolve")?;
        let [min, max] = plane_box(build, profile)?;
        let (offset, angle) = (build.number("axis_offset")?, build.number("angle")?);
        if max.x + offset <= 0.0 {
            let problem = "all of the shape lies at x < 0, and nothing is left";
            return Err(build
                .wrong("revolve", problem)
                .help("a greater `axis_offset`, or a shape on the right of the y axis"));
        }
        let reach = max.x + offset;
        let graph = build.graph();
        let known = graph.slope(profile);
        let steep = match known {
            Slope::Exact { .. } => Slope::Lipschitz(1.0),
            slope => slope,
        };
        let (across, z, zero) = (graph.radius_about_z(), graph.z(), graph.constant(0.0));
        let across = graph.linear(across, 1.0, -offset);
        let whole = graph.warp(profile, [across, z, zero]);
        let bounds = Aabb::new(DVec3::new(-reach, -reach, min.y), DVec3::new(reach, reach, max.y));
        let one_side = min.x + offset >= 0.0;
        let slope = if one_side { known } else { steep };
        let whole = graph.sloped(whole, slope, Some(bounds));
        if on_axis(graph, profile, [min, max], offset) {
            let problem = "the shape has an edge on the axis, which would be a surface inside";
            return Err(build.wrong("revolve", problem).help(
                "let the shape cross the axis: what lies beyond is left out. `lathe` takes a polygon with such an edge",
            ));
        }
        if angle >= 360.0 {
            return Ok(whole);
        }
        let half = angle.to_radians() / 2.0;
        let (x, y) = (graph.x(), graph.y());
        let aside = graph.abs(y);
        let (along, aside) = (graph.linear(x, libm::sin(half), 0.0), graph.linear(aside, -libm::cos(half), 0.0));
        let wedge = graph.add(along, aside);
        let piece = graph.min(whole, wedge);
        Ok(graph.sloped(piece, steep, Some(bounds)))
    },
    ..Spec::PLAIN
};

/// Whether F is 0 along a piece of the axis that the solid lies around.
fn on_axis(graph: &Graph, profile: Node, [min, max]: [DVec2; 2], offset: f64) -> bool {
    const STEPS: i32 = 64;
    let size = (max - min).max_element();
    let field = Expression::new(graph, profile);
    let at = |x: f64, i: i32| {
        let y = min.y + (max.y - min.y) * (f64::from(i) + 0.5) / f64::from(STEPS);
        field.reference(DVec3::new(x - offset, y, 0.0))
    };
    let bare = |i: &i32| at(0.0, *i).abs() < 1e-9 * size && at(1e-4 * size, *i) > 1e-5 * size;
    (0..STEPS).filter(bare).count() > 1
}
