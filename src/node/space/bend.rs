//! A shape bent about an axis.

use std::sync::Arc;

use glam::DVec3;

use crate::field::Aabb;
use crate::node::bend::{Mapped, Straight};
use crate::node::own_box::own_box;
use crate::node::spec::Spec;
use crate::text::key::Absent::Nothing;
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;

/// Bent about an axis along y.
pub const NODE: Spec = Spec {
    key: Key::new(
        "bend",
        Kind::Number,
        Nothing,
        "Bends the x axis upward, to a circle about an axis along y: by how much a unit of x. Lengths on the x axis stay.",
    )
    .unit("degrees"),
    formula: "f(R·θ, y, R − r), (r, θ) = polar(R − z, x)",
    source: "Barr, Global and local deformations of solid primitives, 1984",
    example: "box = [2.4, 0.5, 0.25]\nbend = 70",
    bend: Some(|build| {
        let degrees = build.number("bend")?;
        let own = own_box(build)?;
        let turn = degrees.to_radians();
        // Bent by so little it is straight.
        if (turn * own.size().max_element()).abs() < 1e-9 {
            return Ok(Arc::new(Straight::new(glam::DAffine3::IDENTITY).expect("it is the identity")));
        }
        let radius = 1.0 / turn;
        let problem = |message: String| Problem::new(build.span(), message);
        let far = own.min.x.abs().max(own.max.x.abs()) * turn.abs();
        if far > std::f64::consts::PI {
            let most = 180.0 / own.min.x.abs().max(own.max.x.abs());
            let problem = problem(format!("`bend` closes `{}` to more than a circle", build.name()));
            return Err(problem.help(format!("{most:.4} degrees a unit are the most for what reaches so far along x")));
        }
        let thick = if radius > 0.0 { own.max.z } else { -own.min.z };
        if thick >= radius.abs() {
            let problem = problem(format!("`{}` is thicker than the radius that it is bent to", build.name()));
            return Err(problem.help(format!("the radius is {:.4} units", radius.abs())));
        }
        let map = Mapped::new(move |graph| {
            let (x, y, z) = (graph.x(), graph.y(), graph.z());
            // From the centre, upright for either sign.
            let sign = radius.signum();
            let up = graph.linear(z, -sign, radius.abs());
            let along = graph.atan2(x, up);
            let along = graph.linear(along, radius.abs(), 0.0);
            let far = graph.length(&[x, up]);
            let across = graph.linear(far, -sign, radius);
            [along, y, across]
        });
        let forth = move |own: DVec3| {
            let angle = own.x * turn;
            let far = radius - own.z;
            DVec3::new(far * libm::sin(angle), own.y, radius - far * libm::cos(angle))
        };
        let solid = bent_box(&own, radius);
        Ok(Arc::new(map.solid(Some(solid)).forth(forth)))
    }),
    ..Spec::PLAIN
};

/// A box around a bent box.
fn bent_box(own: &Aabb, radius: f64) -> Aabb {
    let angles = [own.min.x / radius, own.max.x / radius];
    let (from, to) = (angles[0].min(angles[1]), angles[0].max(angles[1]));
    let fars = [radius - own.max.z, radius - own.min.z];
    // Sine and cosine are extreme at the ends and at quarter turns.
    let quarters = (-4..=4).map(|quarter| f64::from(quarter) * std::f64::consts::FRAC_PI_2);
    let extremes: Vec<f64> = [from, to].into_iter().chain(quarters.filter(|at| (from..=to).contains(at))).collect();
    let corners = extremes
        .iter()
        .flat_map(|angle| fars.map(|far| DVec3::new(far * libm::sin(*angle), 0.0, radius - far * libm::cos(*angle))));
    let mut around = crate::node::bend::around(corners).grown(1e-9 * (own.size().max_element() + radius.abs()));
    (around.min.y, around.max.y) = (own.min.y, own.max.y);
    around
}
