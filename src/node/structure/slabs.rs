//! Walls side by side.

use glam::DVec3;

use crate::field::{Joined, Procedure, Slope};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Of, Required, Text};
use crate::text::key::{Key, Kind};

/// Walls side by side.
pub const NODE: Spec = Spec {
    key: Key::length(
        "slabs",
        Required,
        "Plane walls side by side: the distance between the middles of neighbours. Unbounded: cut it with `bounds`, \
         `intersection`, or as what a shape is filled with.",
    ),
    parameters: &[
        Key::length("wall", Of("slabs", 0.2), "The thickness of each."),
        Key::new(
            "axes",
            Kind::Choice(&["x", "y", "z", "xy", "xz", "yz", "xyz"]),
            Text("z"),
            "The axes that there are walls across, the middle of one at the origin.",
        ),
    ],
    formula: "the greatest over the axes of w/2 − |x − a·round(x/a)|",
    source: "HFRep, equation 24, as a distance",
    example: "slabs = 0.4\naxes = \"xy\"\nbounds = { box = 1.6, cut = true }",
    is_endless: true,
    build: |build| {
        let (apart, wall) = (build.number("slabs")?, build.number("wall")?);
        if wall >= apart {
            let problem = format!("`wall` must be less than the distance of the walls, {apart}");
            return Err(build.wrong("wall", problem).help("a thinner wall, or `slabs` farther apart"));
        }
        let names = build.arguments().choice("axes").copied().unwrap_or("z");
        let has = ["x", "y", "z"].map(|name| names.contains(name));
        let at = move |p: DVec3| {
            let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
            for axis in (0..3).filter(|axis| has[*axis]) {
                let folded = p[axis] - apart * (p[axis] / apart).round();
                let value = wall / 2.0 - folded.abs();
                if value > best.0 {
                    best = (value, DVec3::AXES[axis] * -1.0_f64.copysign(folded));
                }
            }
            if p.is_finite() { best } else { (f64::NAN, DVec3::NAN) }
        };
        // Where walls cross, the surface is farther away than they are thick.
        let slope = Slope::Exact { outside: true, inside: names.len() == 1 };
        let walls = Procedure { at, bounds: None, slope, is_flat: !has[2] };
        Ok(build.graph().field(Joined::shared(walls)))
    },
    ..Spec::PLAIN
};
