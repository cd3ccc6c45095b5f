//! A disc without another one.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::flat;
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A disc without another one.
pub const NODE: Spec = Spec {
    key: Key::length("moon", Required, "Disc around the origin without another one: its radius.").also(&["crescent"]),
    parameters: &[
        Key::length("bite", Of("moon", 0.8), "The radius of the disc that is taken away."),
        Key::length("bite_at", Of("moon", 0.5), "The x of the middle of that disc."),
    ],
    formula: "the signed distance to it",
    example: "moon = 1",
    plane: Plane::Flat,
    build: |build| {
        let (radius, bite, aside) = (build.number("moon")?, build.number("bite")?, build.number("bite_at")?);
        if aside >= radius + bite || aside <= (radius - bite).abs() {
            let (least, most) = ((radius - bite).abs(), radius + bite);
            let problem = format!("the two discs must cross: `bite_at` between {least} and {most}");
            return Err(build.wrong("bite_at", problem).help("`ring` has a hole in the middle"));
        }
        let x = (radius * radius - bite * bite + aside * aside) / (2.0 * aside);
        let y = (radius * radius - x * x).max(0.0).sqrt();
        let (top, bottom) = (DVec2::new(x, y), DVec2::new(x, -y));
        let mut outline = Outline::new();
        outline.line(top).arc(bottom, DVec2::ZERO, true).arc(top, DVec2::X * aside, false).close();
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};
