//! What two equal discs share.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// What two equal discs share.
pub const NODE: Spec = Spec {
    key: Key::length(
        "vesica",
        Required,
        "What two equal discs share, upright around the origin: its height from tip to tip.",
    ),
    parameters: &[Key::length("width", Of("vesica", 0.5), "Its width.")],
    formula: "the signed distance to it",
    example: "vesica = 1.8",
    plane: Plane::Flat,
    build: |build| {
        let (tip, wide) = (build.number("vesica")? / 2.0, build.number("width")? / 2.0);
        if wide > tip {
            let problem = format!("`width` is more than the height, {}", 2.0 * tip);
            return Err(build.wrong("width", problem).help("turn it with `rotate`"));
        }
        let radius = (tip * tip + wide * wide) / (2.0 * wide);
        let aside = DVec2::X * (radius - wide);
        let (top, bottom) = (DVec2::Y * tip, DVec2::NEG_Y * tip);
        let mut outline = Outline::new();
        outline.line(bottom).arc(top, -aside, true).arc(bottom, aside, true).close();
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
