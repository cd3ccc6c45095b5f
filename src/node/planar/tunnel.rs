//! A rectangle with a round top.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::Required;
use crate::text::key::{Key, Kind, Limit};

/// A rectangle with a round top.
pub const NODE: Spec = Spec {
    key: Key::new(
        "tunnel",
        Kind::Pair,
        Required,
        "Rectangle with half a disc on top, around the origin: its width and its whole height.",
    )
    .limit(Limit::Positive)
    .unit("units"),
    formula: "the signed distance to it",
    example: "tunnel = [1.2, 1.6]",
    plane: Plane::Flat,
    build: |build| {
        let size = build.pair("tunnel")?;
        let (wide, half) = (size.x / 2.0, size.y / 2.0);
        if wide > size.y {
            let problem = format!("the round top alone is higher than `tunnel`: its height must be at least {wide}");
            return Err(build.wrong("tunnel", problem).help("a greater height, or `cut_disk`"));
        }
        let spring = half - wide;
        let mut outline = Outline::new();
        outline
            .line(DVec2::new(-wide, -half))
            .line(DVec2::new(wide, -half))
            .line(DVec2::new(wide, spring))
            .arc(DVec2::new(-wide, spring), DVec2::Y * spring, true)
            .close();
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
