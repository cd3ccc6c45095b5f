//! The volume runs evenly from the one's to the other's.

use std::sync::Arc;

use crate::morph::Volume;
use crate::node::morph_mode::{ModeSpec, SHARED};
use crate::text::key::Absent::{Nothing, Number};
use crate::text::key::{Key, Kind, Limit};

/// Space-time blending by volume.
pub const NODE: ModeSpec = ModeSpec {
    key: ModeSpec::named(
        "volume",
        "Space-time blending whose volume runs evenly from the one object's to the other's: no frame is empty, and none jumps.",
    ),
    parameters: &[
        Key::new(
            "bridge",
            Kind::Number,
            Number(0.5),
            "How much separate shapes flow through one body: 0.05 is the shortest way.",
        )
        .limit(Limit::Within(0.05, 100.0)),
        Key::new(
            "volume",
            Kind::Number,
            Number(1.0),
            "How many times the volume of the straight way between the two; 1 at the first and at the last frame of `over`.",
        )
        .limit(Limit::Within(0.001, 100.0)),
        Key::new(
            "delay",
            Kind::Delay,
            Nothing,
            "Places that start later: the share of the morph, 0 to 0.95, that each waits before shape and colours begin to \
             change; all end together (parts with times of their own are morphs as shapes, `morph = [\"a\", \"b\"]` with \
             `mix`). A formula of x, y, z in the world, or what a shape has there. As smooth as a lattice of some 50 cells \
             across both objects.",
        ),
    ],
    shared: &SHARED,
    formula: "the section at t of g₁ ∨₀ g₂ + a₀·disp, g₁ and g₂ the objects as half-cylinders over time, a₀ by the volume",
    source: "heterogeneous STB, eqs. 5 and 6",
    example: "from = \"a\"\nto = \"b\"\nbridge = 0.8",
    carries_apart: true,
    where_empty: None,
    by_level_sets: false,
    build: |setting| {
        Ok(Arc::new(Volume {
            bridge: setting.number("bridge")?,
            pace: setting.pace(),
            volume: setting.factor("volume")?,
            delay: setting.delay(),
        }))
    },
};
