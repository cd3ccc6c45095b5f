//! A shape that narrows along z.

use std::sync::Arc;

use glam::DVec3;

use crate::field::Aabb;
use crate::node::bend::Mapped;
use crate::node::own_box::known_box;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// Narrower, or wider, along z.
pub const NODE: Spec = Spec {
    key: Key::new(
        "taper",
        Kind::Number,
        Nothing,
        "How many times as wide it is at its upper end as at its lower end; even in between, constant beyond.",
    )
    .limit(Limit::Within(0.001, 1000.0)),
    parameters: &[
        Key::new("taper_from", Kind::Number, Number(-0.5), "The level of the lower end: below it nothing changes.")
            .unit("units"),
        Key::new("taper_to", Kind::Number, Number(0.5), "The level of the upper end.").unit("units"),
    ],
    formula: "f(x/s, y/s, z), s = mix(1, k, clamp((z − a)/(b − a), 0, 1))",
    source: "Barr, Global and local deformations of solid primitives, 1984",
    example: "box = [1, 1, 1.6]\ntaper = 0.3\ntaper_from = -0.8\ntaper_to = 0.8",
    bend: Some(|build| {
        let (width, from, to) = (build.number("taper")?, build.number("taper_from")?, build.number("taper_to")?);
        if to - from < 1e-9 {
            let problem = format!("`taper_to` of `{}` must be above `taper_from`", build.name());
            return Err(Problem::new(build.span(), problem));
        }
        let scale = move |z: f64| 1.0 + (width - 1.0) * ((z - from) / (to - from)).clamp(0.0, 1.0);
        let solid = known_box(build)?.map(|own| {
            let wide = scale(own.min.z).max(scale(own.max.z));
            let narrow = scale(own.min.z).min(scale(own.max.z));
            let end = |value: f64, least: bool| if (value < 0.0) == least { value * wide } else { value * narrow };
            let corner = |at: DVec3, least: bool| DVec3::new(end(at.x, least), end(at.y, least), at.z);
            Aabb::new(corner(own.min, true), corner(own.max, false))
        });
        let map = Mapped::new(move |graph| {
            let (x, y, z) = (graph.x(), graph.y(), graph.z());
            let [zero, one] = [0.0, 1.0].map(|value| graph.constant(value));
            let share = graph.linear(z, 1.0 / (to - from), -from / (to - from));
            let share = graph.max(share, zero);
            let share = graph.min(share, one);
            let scale = graph.linear(share, width - 1.0, 1.0);
            [graph.div(x, scale), graph.div(y, scale), z]
        });
        Ok(Arc::new(map.solid(solid).forth(move |own| DVec3::new(own.x * scale(own.z), own.y * scale(own.z), own.z))))
    }),
    ..Spec::PLAIN
};
