//! A helix of round wire.

use glam::DVec3;

use crate::field::{Joined, Struts};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required, Text};
use crate::text::key::{Key, Kind, Limit};

/// A helix of round wire.
pub const NODE: Spec = Spec {
    key: Key::length("helix", Required, "Spring of round wire around the z axis: the radius of its windings.")
        .also(&["spring", "coil"]),
    parameters: &[
        Key::length("pitch", Of("helix", 0.5), "How far it rises in one turn."),
        Key::new("turns", Kind::Number, Number(4.0), "How many turns.").limit(Limit::Within(0.01, 500.0)),
        Key::length("wire", Of("helix", 0.12), "The radius of the wire."),
        Key::new(
            "hand",
            Kind::Choice(&["right", "left"]),
            Text("right"),
            "Which way it winds; screws are right-handed.",
        ),
    ],
    formula: "s − |p − c|, c the nearest of the curve, of straight pieces",
    example: "helix = 0.7",
    build: |build| {
        let (radius, pitch) = (build.number("helix")?, build.number("pitch")?);
        let (turns, wire) = (build.number("turns")?, build.number("wire")?);
        let hand = if build.arguments().choice("hand") == Some(&"left") { -1.0 } else { 1.0 };
        let at = move |share: f64| {
            let angle = share * turns * std::f64::consts::TAU;
            let up = (share - 0.5) * turns * pitch;
            DVec3::new(radius * libm::cos(angle), hand * radius * libm::sin(angle), up)
        };
        let pieces = (192.0 * turns).ceil() as usize;
        Ok(build.graph().field(Joined::shared(Struts::along(at, |_| wire, pieces))))
    },
    ..Spec::PLAIN
};
