//! A flat shape laid around a cylinder.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::DVec3;

use crate::field::Aabb;
use crate::node::bend::Mapped;
use crate::node::own_box::own_box;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::Key;
use crate::text::problem::Problem;

/// Laid around a cylinder.
pub const NODE: Spec = Spec {
    key: Key::length(
        "wrap_cylinder",
        Nothing,
        "Lays the plane z = 0 around a cylinder about z of this radius: x becomes the way around, from the x axis on, y the \
         height, z the height above the cylinder.",
    ),
    formula: "f(r·atan2(y, x), z, |(x, y)| − r)",
    example: "box = [4, 0.5, 0.2]\nwrap_cylinder = 0.8",
    bend: Some(|build| {
        let radius = build.number("wrap_cylinder")?;
        let own = own_box(build)?;
        let problem = |message: String| Problem::new(build.span(), message);
        if own.min.x.abs().max(own.max.x.abs()) > PI * radius {
            let problem = problem(format!("`{}` reaches farther than once around its `wrap_cylinder`", build.name()));
            return Err(problem.help(format!(
                "π times the radius to either side of the middle, {:.6} units, are the most",
                PI * radius
            )));
        }
        if own.min.z <= -radius {
            return Err(problem(format!("`{}` reaches below the axis of its `wrap_cylinder`", build.name())));
        }
        let map = Mapped::new(move |graph| {
            let (x, y, z) = (graph.x(), graph.y(), graph.z());
            let angle = graph.atan2(y, x);
            let far = graph.length(&[x, y]);
            [graph.linear(angle, radius, 0.0), z, graph.linear(far, 1.0, -radius)]
        });
        let forth = move |own: DVec3| {
            let (angle, far) = (own.x / radius, radius + own.z);
            DVec3::new(far * libm::cos(angle), far * libm::sin(angle), own.y)
        };
        let reach = radius + own.max.z;
        let solid = Aabb::new(DVec3::new(-reach, -reach, own.min.y), DVec3::new(reach, reach, own.max.y));
        Ok(Arc::new(map.solid(Some(solid)).forth(forth)))
    }),
    ..Spec::PLAIN
};
