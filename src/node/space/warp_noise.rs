//! A shape whose every place is moved by noise.

use std::sync::Arc;

use glam::DVec3;

use crate::field::{Field, Fold, Fractal, NoiseField};
use crate::node::bend::Mapped;
use crate::node::keys::seed;
use crate::node::own_box::known_box;
use crate::node::spec::Spec;
use crate::text::key::Absent::{Nothing, Number};
use crate::text::key::{Key, Kind, Limit};

/// Moved by noise.
pub const NODE: Spec = Spec {
    key: Key::new(
        "warp_noise",
        Kind::Number,
        Nothing,
        "Moves every place by noise, along each axis by so much at most.",
    )
    .limit(Limit::NotNegative)
    .unit("units"),
    parameters: &[
        Key::length("warp_size", Number(0.5), "The size of the noise's largest cells."),
        Key::new("warp_octaves", Kind::Whole, Number(2.0), "How many octaves of noise are summed.")
            .limit(Limit::Within(1.0, 8.0)),
        seed("The number that the noise starts from."),
    ],
    formula: "f(p − a·(2·fbm(p/s) − 1))",
    example: "sphere = 0.8\nwarp_noise = 0.3",
    bend: Some(|build| {
        let (amount, size) = (build.number("warp_noise")?, build.number("warp_size")?);
        let octaves = build.arguments().whole("warp_octaves").map_or(1, |octaves| *octaves as u32);
        let seed = *build.arguments().seed("seed").expect("it has a default");
        let solid = known_box(build)?.map(|own| own.grown(amount));
        let noises: [Arc<dyn Field>; 3] = std::array::from_fn(|axis| {
            let noise = Fractal { seed: seed.wrapping_add(1000 * axis as u64), octaves, fold: Fold::Plain };
            Arc::new(NoiseField(noise)) as Arc<dyn Field>
        });
        let map = Mapped::new(move |graph| {
            let at = DVec3::AXES.map(|axis| graph.affine(axis / size, 0.0));
            let coordinates = [graph.x(), graph.y(), graph.z()];
            std::array::from_fn(|axis| {
                let noise = graph.field_at(Arc::clone(&noises[axis]), at);
                let way = graph.linear(noise, 2.0 * amount, -amount);
                graph.sub(coordinates[axis], way)
            })
        });
        Ok(Arc::new(map.solid(solid)))
    }),
    ..Spec::PLAIN
};
