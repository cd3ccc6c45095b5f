//! A shape of the plane, drawn along the outline of another one, or along a closed curve of space.

use std::sync::Arc;

use glam::{DVec2, DVec3};

use crate::field::{Aabb, Bent, Expression, Field, Folded, Node, Side, Slope, Spine};
use crate::node::curves::line_along;
use crate::node::profile::{plane_box, profile};
use crate::node::spec::{Build, Carries, Plane, Spec};
use crate::text::key::Absent::{Nothing, Number, Required, Text};
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;

/// A shape of the plane, drawn along the outline of another one, or along a closed curve of space.
pub const NODE: Spec = Spec {
    key: Key::new(
        "sweep",
        Kind::Shape,
        Required,
        "A shape of the plane drawn along the outline of another one, which lies level: its x points out of that outline, its y is z. Or along a closed curve of space: its y points to z at the beginning as far as it can, its x to the left, and it turns about the curve no more than it must to meet itself.",
    ),
    parameters: &[
        Key::new("path", Kind::Shape, Nothing, "The shape of the plane whose outline it is drawn along."),
        Key::new(
            "closed_path",
            Kind::Places,
            Nothing,
            "Points of the closed curve that it is drawn along instead, `[[x, y, z], …]`, or a file of them; the last is joined to the first.",
        )
        .unit("units"),
        Key::new(
            "path_curve",
            Kind::Choice(&["smooth", "b_spline"]),
            Text("smooth"),
            "How `closed_path` goes by its points: smooth through them (Catmull and Rom), or as their B-spline.",
        ),
        Key::new(
            "turn",
            Kind::Number,
            Number(0.0),
            "By how much it is turned on the way along `closed_path`: whole turns, or what brings it onto itself, such as multiples of 90 for a square.",
        )
        .unit("degrees"),
    ],
    formula: "f(−g(x, y), z), g the signed distance of the path; f((p − c)·n, (p − c)·b), c the nearest place of the closed path, and n, b across it",
    source: "Wang, Jüttler, Zheng and Liu, Computation of rotation minimizing frames, 2008",
    example: "sweep = { rectangle = [0.3, 0.5] }\npath = { star = 1, tips = 6, inner = 0.6 }",
    carries: Carries::First,
    plane: Plane::Lifts,
    build: |build| {
        match (build.arguments().shape("path").is_some(), build.arguments().places("closed_path").is_some()) {
            (true, false) => along_outline(build),
            (false, true) => along_curve(build),
            (true, true) => Err(build
                .wrong("closed_path", "`path` and `closed_path` both say where `sweep` goes")
                .help("leave one of them out")),
            (false, false) => Err(build
                .wrong("sweep", "nothing says where `sweep` goes")
                .help("`path`, a shape of the plane, or `closed_path`, points of a curve of space")),
        }
    },
    ..Spec::PLAIN
};

fn along_outline(build: &mut dyn Build) -> Result<Node, Problem> {
    if build.arguments().number("turn").is_some_and(|turn| turn.as_constant() != Some(0.0)) {
        return Err(build
            .wrong("turn", "`turn` goes with `closed_path`")
            .help("leave it out; along an outline y stays z"));
    }
    let (section, path) = (profile(build, "sweep")?, profile(build, "path")?);
    let ([min, max], [from, to]) = (plane_box(build, section)?, plane_box(build, path)?);
    let graph = build.graph();
    let known = graph.slope(path);
    if !known.is_exact(Side::Outside) || !known.is_exact(Side::Inside) {
        let problem = "`path` needs a shape whose F is its distance";
        return Err(build
            .wrong("path", problem)
            .help("a single shape other than `superellipse`, without `scale` to different factors"));
    }
    let steep = match graph.slope(section) {
        Slope::Exact { .. } => Slope::Lipschitz(1.0),
        slope => slope,
    };
    let (z, zero) = (graph.z(), graph.constant(0.0));
    let out = graph.neg(path);
    let node = graph.warp(section, [out, z, zero]);
    let reach = max.x.max(0.0);
    let bounds = Aabb::new((from - reach).extend(min.y), (to + reach).extend(max.y));
    Ok(graph.sloped(node, steep, Some(bounds)))
}

fn along_curve(build: &mut dyn Build) -> Result<Node, Problem> {
    let curve = build.arguments().choice("path_curve").copied().unwrap_or("smooth");
    let line = line_along(build, "closed_path", curve, true)?;
    let section = profile(build, "sweep")?;
    let [min, max] = plane_box(build, section)?;
    let section_field = Expression::new(build.graph(), section);
    let turn = build.number("turn")?;
    if !meets_itself(&section_field, [min, max], turn.to_radians()) {
        let problem = format!("turned by {turn} degrees on its way, the shape of `sweep` does not meet itself");
        return Err(build.wrong("turn", problem).help(whole_turns(&section_field, [min, max])));
    }
    let spine = Spine::closed(&line, DVec3::Z, turn.to_radians());
    // The section knows no z: as much of it as it is wide is as good as any.
    let height = (max - min).max_element();
    let own = Aabb::new(min.extend(0.0), max.extend(height));
    let stretch = height / spine.length();
    match Bent::new(section_field, own, spine, 0.0, stretch) {
        Ok(bent) => {
            let graph = build.graph();
            let node = graph.field(Arc::new(bent));
            // It is held below minus the distance to its box.
            Ok(graph.falling(node, 1.0))
        }
        Err(Folded { at, radius, reach }) => {
            let problem = format!(
                "`{}` folds where the curve turns sharply, at [{:.4}, {:.4}, {:.4}]",
                build.name(),
                at.x,
                at.y,
                at.z
            );
            let help = format!(
                "the curve's radius there is {radius:.4} units, and the shape reaches {reach:.4} to its middle: a smaller shape, or points that turn less"
            );
            Err(build.wrong("closed_path", problem).help(help))
        }
    }
}

/// Whether a shape of the plane is the same turned by an angle, by its values on a lattice around it.
fn meets_itself(section: &Expression, [min, max]: [DVec2; 2], angle: f64) -> bool {
    /// Points along each side; no symmetry of a whole number of turns has its lattice.
    const SIDE: i32 = 23;
    let reach = min.abs().max(max.abs()).max_element();
    let turn = DVec2::new(libm::cos(angle), libm::sin(angle));
    (0..SIDE * SIDE).all(|i| {
        let at = |i: i32| reach * 1.2 * (2.0 * f64::from(i) / f64::from(SIDE - 1) - 1.0);
        let here = DVec2::new(at(i % SIDE), at(i / SIDE));
        let [value, turned] = [here, turn.rotate(here)].map(|at| section.reference(at.extend(0.0)));
        (value - turned).abs() <= 1e-6 * reach
    })
}

/// By what a shape may be turned.
fn whole_turns(section: &Expression, corners: [DVec2; 2]) -> String {
    /// Sides alike that are looked for.
    const MOST: u32 = 60;
    let alike =
        (2..=MOST).rev().find(|sides| meets_itself(section, corners, std::f64::consts::TAU / f64::from(*sides)));
    let step = 360.0 / f64::from(alike.unwrap_or(1));
    format!("0, or a multiple of {step}")
}
