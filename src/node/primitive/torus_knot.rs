//! A torus knot.

use glam::DVec3;

use crate::field::{Joined, Struts};
use crate::node::spec::Spec;
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};

/// A torus knot.
pub const NODE: Spec = Spec {
    key: Key::length("torus_knot", Required, "Knot on a torus around the z axis: the torus' major radius."),
    parameters: &[
        Key::length("minor", Of("torus_knot", 0.4), "The torus' minor radius."),
        Key::length("tube", Of("torus_knot", 0.15), "The radius of the rope."),
        Key::new("p", Kind::Whole, Number(2.0), "How often it goes round the z axis.").limit(Limit::Within(1.0, 50.0)),
        Key::new("q", Kind::Whole, Number(3.0), "How often it goes round the tube; it and `p` have no common divisor.")
            .limit(Limit::Within(1.0, 50.0)),
    ],
    formula: "s − |p − c|, c the nearest of the curve ((R + r·cos qφ)·cos pφ, (R + r·cos qφ)·sin pφ, r·sin qφ), of straight pieces",
    example: "torus_knot = 0.8",
    build: |build| {
        let (major, minor, tube) = (build.number("torus_knot")?, build.number("minor")?, build.number("tube")?);
        let (p, q) = (build.whole("p"), build.whole("q"));
        if let Some(divisor) = (2..=p.min(q)).find(|divisor| p % divisor == 0 && q % divisor == 0) {
            let problem =
                format!("`p` and `q` are both multiples of {divisor}: the knot would be traced {divisor} times");
            return Err(build.wrong("torus_knot", problem).help(format!("p = {}, q = {}", p / divisor, q / divisor)));
        }
        let at = move |share: f64| {
            let angle = share * std::f64::consts::TAU;
            let (round, about) = (angle * p as f64, angle * q as f64);
            let across = major + minor * libm::cos(about);
            DVec3::new(across * libm::cos(round), across * libm::sin(round), minor * libm::sin(about))
        };
        Ok(build.graph().field(Joined::shared(Struts::along(at, |_| tube, 192 * (p + q) as usize))))
    },
    ..Spec::PLAIN
};
