//! A shape turned about z, the more the nearer to the axis.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::node::bend::{Mapped, turned_about_z};
use crate::node::own_box::known_box;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number};
use crate::text::key::{Key, Kind};

/// Turned about z, the more the nearer to the axis.
pub const NODE: Spec = Spec {
    key: Key::new("swirl", Kind::Number, Nothing, "Turns what is near the z axis about it: by so much at the axis.")
        .unit("degrees"),
    parameters: &[Key::length("swirl_radius", Number(1.0), "From here on nothing is turned.")],
    formula: "f(R(−a·(1 − smoothstep(0, s, |(x, y)|)))·p)",
    example: "box = [1.6, 0.4, 0.4]\nswirl = 180\nswirl_radius = 0.9",
    bend: Some(|build| {
        let (angle, radius) = (build.number("swirl")?.to_radians(), build.number("swirl_radius")?);
        let solid = known_box(build)?.map(|own| turned_about_z(&own));
        let map = Mapped::new(move |graph| {
            let (x, y, z) = (graph.x(), graph.y(), graph.z());
            let far = graph.length(&[x, y]);
            let share = graph.linear(far, 1.0 / radius, 0.0);
            let rest = graph.smooth(share);
            let angle = graph.linear(rest, -angle, angle);
            let (sin, cos) = (graph.sin(angle), graph.cos(angle));
            let [xc, ys, yc, xs] = [(x, cos), (y, sin), (y, cos), (x, sin)].map(|(a, b)| graph.mul(a, b));
            [graph.add(xc, ys), graph.sub(yc, xs), z]
        });
        // The turn changes with the radius r by r·a·6t(1 − t)/s, t = r/s, which is 8/9·a at most: a shear of that.
        let shear = 8.0 / 9.0 * angle.abs();
        let steepest = (shear + (shear * shear + 4.0).sqrt()) / 2.0;
        let forth = move |own: DVec3| {
            let share = (own.x.hypot(own.y) / radius).min(1.0);
            DMat3::from_rotation_z(angle * (1.0 - share * share * (3.0 - 2.0 * share))) * own
        };
        Ok(Arc::new(map.solid(solid).steepest(steepest * (1.0 + 1e-9)).forth(forth)))
    }),
    ..Spec::PLAIN
};
