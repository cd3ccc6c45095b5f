//! A shape of the plane, drawn out along z.

use glam::{DVec2, DVec3};

use crate::field::{Aabb, Side, Slope};
use crate::node::profile::{plane_box, profile};
use crate::node::spec::{Carries, Plane, Spec};
use crate::text::key::Absent::{Nothing, Number, Required, Words};
use crate::text::key::{Key, Kind, Limit};

/// A shape of the plane, drawn out along z.
pub const NODE: Spec = Spec {
    key: Key::new("extrude", Kind::Shape, Required, "A shape of the plane drawn out along z, around z = 0."),
    parameters: &[
        Key::new(
            "height",
            Kind::Number,
            Words("an eighth of the longer side of the shape"),
            "From its bottom to its top.",
        )
        .limit(Limit::Positive)
        .unit("units"),
        Key::new("edge_radius", Kind::Number, Number(0.0), "The radius of the edges at its bottom and its top.")
            .limit(Limit::NotNegative)
            .unit("units"),
        Key::new("turn", Kind::Number, Number(0.0), "By how much the top is turned against the bottom.")
            .unit("degrees"),
        Key::new("top_scale", Kind::Number, Number(1.0), "How many times as large as the bottom the top is.")
            .limit(Limit::Positive),
        Key::new(
            "top_shape",
            Kind::Shape,
            Nothing,
            "The shape of the plane that it becomes towards the top, evenly by F.",
        ),
    ],
    formula: "the signed distance where F of the shape is one and no parameter is given",
    example: "extrude = { star = 0.9 }\nheight = 0.6",
    carries: Carries::First,
    plane: Plane::Lifts,
    build: |build| {
        let profile = profile(build, "extrude")?;
        let [min, max] = plane_box(build, profile)?;
        let height = match build.arguments().number("height") {
            Some(_) => build.number("height")?,
            None => (max - min).max_element() / 8.0,
        };
        let (edge, turn) = (build.number("edge_radius")?, build.number("turn")?.to_radians());
        let scale = build.number("top_scale")?;
        let known = build.graph().slope(profile);
        if edge > 0.0 && !known.is_exact(Side::Inside) {
            let problem = "`edge_radius` needs a shape whose F is its distance";
            return Err(build
                .wrong("edge_radius", problem)
                .help("a single shape other than `superellipse`, without `scale` to different factors"));
        }
        if 2.0 * edge > height {
            let problem = format!("`edge_radius` is more than half of the height, {height}");
            return Err(build.wrong("edge_radius", problem).help("a smaller radius, or a greater height"));
        }
        let top = match build.arguments().shape("top_shape") {
            Some(_) => Some(self::profile(build, "top_shape")?),
            None => None,
        };
        let top_box = top.map(|top| plane_box(build, top)).transpose()?;
        let is_straight = turn == 0.0 && scale == 1.0;
        let graph = build.graph();
        let z = graph.z();
        let (zero, one) = (graph.constant(0.0), graph.constant(1.0));
        let share = graph.linear(z, 1.0 / height, 0.5);
        let share = graph.max(share, zero);
        let share = graph.min(share, one);
        let mut section = profile;
        let (mut min, mut max) = (min, max);
        if let (Some(top), Some([top_min, top_max])) = (top, top_box) {
            let change = graph.sub(top, profile);
            let change = graph.mul(change, share);
            section = graph.add(profile, change);
            (min, max) = (min.min(top_min), max.max(top_max));
        }
        if !is_straight {
            let size = graph.linear(share, scale - 1.0, 1.0);
            let angle = graph.linear(share, turn, 0.0);
            let (sin, cos) = (graph.sin(angle), graph.cos(angle));
            let (x, y) = (graph.x(), graph.y());
            let [xc, ys, yc, xs] = [(x, cos), (y, sin), (y, cos), (x, sin)].map(|(a, b)| graph.mul(a, b));
            let (along, aside) = (graph.add(xc, ys), graph.sub(yc, xs));
            let back = [graph.div(along, size), graph.div(aside, size), zero];
            let read = graph.warp(section, back);
            section = graph.mul(read, size);
            let reach =
                if turn == 0.0 { min.abs().max(max.abs()) } else { DVec2::splat(min.abs().max(max.abs()).length()) };
            let reach = reach * scale.max(1.0);
            (min, max) = (-reach, reach);
        }
        let caps = graph.slab(DVec3::Z, height - 2.0 * edge);
        let section = graph.linear(section, 1.0, -edge);
        let node = graph.corner(section, caps);
        let node = graph.linear(node, 1.0, edge);
        let bounds = Aabb::new(min.extend(-height / 2.0), max.extend(height / 2.0));
        let slope = match known {
            _ if !is_straight || top.is_some() => Slope::Unknown,
            // Rounded edges take the corners of the shape for rounder than they are.
            Slope::Exact { .. } if edge > 0.0 => Slope::Lipschitz(1.0),
            // The corner with the caps keeps what is exact on each side.
            Slope::Exact { .. } => known,
            _ => Slope::Unknown,
        };
        Ok(graph.sloped(node, slope, Some(bounds)))
    },
    ..Spec::PLAIN
};
