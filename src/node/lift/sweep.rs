//! A shape of the plane, drawn along the outline of another one.

use crate::field::{Aabb, Side, Slope};
use crate::node::profile::{plane_box, profile};
use crate::node::spec::{Carries, Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind};

/// A shape of the plane, drawn along the outline of another one.
pub const NODE: Spec = Spec {
    key: Key::new(
        "sweep",
        Kind::Shape,
        Required,
        "A shape of the plane drawn along the outline of another one, which lies level: its x points out of that outline, its y is z.",
    ),
    parameters: &[Key::new("path", Kind::Shape, Required, "The shape of the plane whose outline it is drawn along.")],
    formula: "f(−g(x, y), z), g the signed distance of the path",
    example: "sweep = { rectangle = [0.3, 0.5] }\npath = { star = 1, tips = 6, inner = 0.6 }",
    carries: Carries::First,
    plane: Plane::Lifts,
    build: |build| {
        let (section, path) = (profile(build, "sweep")?, profile(build, "path")?);
        let ([min, max], [from, to]) = (plane_box(build, section)?, plane_box(build, path)?);
        let graph = build.graph();
        let known = graph.slope(path);
        if !known.is_exact(Side::Outside) || !known.is_exact(Side::Inside) {
            let problem = "`path` needs a shape whose F is its distance";
            return Err(build
                .wrong("path", problem)
                .help("a single shape other than `superellipse`, without `scale` to different factors"));
        }
        let steep = match graph.slope(section) {
            Slope::Exact { .. } => Slope::Lipschitz(1.0),
            slope => slope,
        };
        let (z, zero) = (graph.z(), graph.constant(0.0));
        let out = graph.neg(path);
        let node = graph.warp(section, [out, z, zero]);
        let reach = max.x.max(0.0);
        let bounds = Aabb::new((from - reach).extend(min.y), (to + reach).extend(max.y));
        Ok(graph.sloped(node, steep, Some(bounds)))
    },
    ..Spec::PLAIN
};
