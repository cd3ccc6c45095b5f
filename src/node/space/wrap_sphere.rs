//! A flat shape laid around a ball.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use glam::DVec3;

use crate::field::Aabb;
use crate::node::bend::Mapped;
use crate::node::own_box::own_box;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::Key;
use crate::text::problem::Problem;

/// Laid around a ball.
pub const NODE: Spec = Spec {
    key: Key::length(
        "wrap_sphere",
        Nothing,
        "Lays the plane z = 0 around a ball of this radius: x becomes the way along the equator, from the x axis on, y the way \
         to the pole, z the height above the ball.",
    ),
    formula: "f(r·atan2(y, x), r·atan2(z, |(x, y)|), |p| − r)",
    example: "box = [3, 1.2, 0.2]\nwrap_sphere = 0.9",
    bend: Some(|build| {
        let radius = build.number("wrap_sphere")?;
        let own = own_box(build)?;
        let far = own.min.abs().max(own.max.abs());
        let problem = |message: String| Problem::new(build.span(), message);
        if far.x > PI * radius || far.y > FRAC_PI_2 * radius {
            let problem = problem(format!("`{}` reaches farther than around its `wrap_sphere`", build.name()));
            let (x, y) = (PI * radius, FRAC_PI_2 * radius);
            return Err(problem.help(format!("from the middle {x:.4} units along x and {y:.4} along y are the most")));
        }
        if own.min.z <= -radius {
            return Err(problem(format!("`{}` reaches below the middle of its `wrap_sphere`", build.name())));
        }
        let map = Mapped::new(move |graph| {
            let (x, y, z) = (graph.x(), graph.y(), graph.z());
            let (across, far) = (graph.length(&[x, y]), graph.length(&[x, y, z]));
            let (east, north) = (graph.atan2(y, x), graph.atan2(z, across));
            [graph.linear(east, radius, 0.0), graph.linear(north, radius, 0.0), graph.linear(far, 1.0, -radius)]
        });
        let forth = move |own: DVec3| {
            let (east, north, far) = (own.x / radius, own.y / radius, radius + own.z);
            let across = far * libm::cos(north);
            DVec3::new(across * libm::cos(east), across * libm::sin(east), far * libm::sin(north))
        };
        let solid = Aabb::new(DVec3::splat(-radius - own.max.z), DVec3::splat(radius + own.max.z));
        Ok(Arc::new(map.solid(Some(solid)).forth(forth)))
    }),
    ..Spec::PLAIN
};
