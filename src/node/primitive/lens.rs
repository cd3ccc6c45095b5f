//! A lens of two caps.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::revolved;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required};
use crate::text::key::Key;

/// A lens of two caps.
pub const NODE: Spec = Spec {
    key: Key::length("lens", Required, "Lens around the z axis, what two equal balls share: the radius of its rim."),
    parameters: &[Key::length("thickness", Of("lens", 0.6), "Its thickness in the middle.")],
    formula: "the signed distance to it",
    example: "lens = 1\nthickness = 0.6",
    build: |build| {
        let (rim, half) = (build.number("lens")?, build.number("thickness")? / 2.0);
        if half > rim {
            let problem = format!("`thickness` is more than twice the rim's radius, {}", 2.0 * rim);
            return Err(build.wrong("thickness", problem).help("`sphere` or `ellipsoid` are thicker"));
        }
        let radius = (rim * rim + half * half) / (2.0 * half);
        let (below, above) = (DVec2::Y * (half - radius), DVec2::Y * (radius - half));
        let mut outline = Outline::new();
        outline.line(DVec2::NEG_Y * half).arc(DVec2::X * rim, above, true).arc(DVec2::Y * half, below, true).close();
        Ok(revolved(build, outline))
    },
    ..Spec::PLAIN
};
