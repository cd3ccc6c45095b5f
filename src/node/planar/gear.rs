//! A gear wheel.

use glam::DVec2;

use crate::field::Outline;
use crate::node::profile::{flat, polar};
use crate::node::spec::{Plane, Spec};
use crate::text::key::Absent::{Number, Required};
use crate::text::key::{Key, Kind, Limit};

/// A gear wheel.
pub const NODE: Spec = Spec {
    key: Key::length("gear", Required, "Gear wheel with involute teeth around the origin: the radius of its pitch circle."),
    parameters: &[
        Key::new("teeth", Kind::Whole, Number(16.0), "How many teeth. Two wheels run in one another where radius over teeth is the same, and their middles are the sum of the radii apart.")
            .limit(Limit::Within(6.0, 400.0)),
        Key::new("pressure_angle", Kind::Number, Number(20.0), "The angle at which teeth press on one another.")
            .limit(Limit::Within(10.0, 30.0))
            .unit("degrees"),
        Key::new("hole", Kind::Number, Number(0.0), "The radius of a hole in the middle.").limit(Limit::NotNegative).unit("units"),
    ],
    formula: "the signed distance to it, flanks of straight pieces",
    source: "the usual proportions: a tooth rises by 2·radius/teeth above the pitch circle and falls by 1.25 of that below it",
    example: "gear = 0.9\nhole = 0.3",
    plane: Plane::Flat,
    build: |build| {
        let (pitch, teeth, hole) = (build.number("gear")?, build.whole("teeth"), build.number("hole")?);
        let pressure = build.number("pressure_angle")?.to_radians();
        let module = 2.0 * pitch / teeth as f64;
        let (base, top, root) = (pitch * libm::cos(pressure), pitch + module, pitch - 1.25 * module);
        if hole >= root {
            let problem = format!("`hole` must be less than the radius between the teeth, {root}");
            return Err(build.wrong("hole", problem).help("a smaller hole"));
        }
        let involute = |angle: f64| libm::tan(angle) - angle;
        // Half of a tooth's angle at a radius; below the base circle its flanks run straight to the middle.
        let half = |radius: f64| {
            let unwound = libm::acos((base / radius).min(1.0));
            (std::f64::consts::FRAC_PI_2 / teeth as f64 + involute(pressure) - involute(unwound)).max(0.0)
        };
        let low = base.max(root);
        let radii: Vec<f64> = (0..=PIECES).map(|i| low + (top - low) * i as f64 / PIECES as f64).collect();
        let flank: Vec<DVec2> = radii.iter().map(|radius| polar(*radius, half(*radius).to_degrees())).collect();
        let root_end = polar(root, half(low).to_degrees());
        let mut outline = Outline::new();
        for tooth in 0..teeth {
            let turn = polar(1.0, 360.0 * tooth as f64 / teeth as f64);
            let mirrored = |point: DVec2| turn.rotate(point * DVec2::new(1.0, -1.0));
            if tooth == 0 {
                outline.line(mirrored(root_end));
            } else {
                outline.arc(mirrored(root_end), DVec2::ZERO, true);
            }
            for point in &flank {
                outline.line(mirrored(*point));
            }
            outline.arc(turn.rotate(flank[PIECES]), DVec2::ZERO, true);
            for point in flank.iter().rev().chain([&root_end]) {
                outline.line(turn.rotate(*point));
            }
        }
        let first = root_end * DVec2::new(1.0, -1.0);
        outline.arc(first, DVec2::ZERO, true).close();
        if hole > 0.0 {
            outline.draw_circle(DVec2::ZERO, hole);
        }
        Ok(flat(build, outline))
    },
    ..Spec::PLAIN
};

/// Straight pieces of a flank: off by less than a thousandth of the tooth.
const PIECES: usize = 8;
