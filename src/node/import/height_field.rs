//! A landscape of a picture.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::field::{Aabb, Field, Heights, SetSystem};
use crate::node::planar::image::{CHANNEL, raster};
use crate::node::spec::{Import, Imported, Spec};
use crate::text::key::Absent::{Number, Of, Required};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// A landscape of a picture.
pub const NODE: Spec = Spec {
    key: Key::new(
        "height_field",
        Kind::Path,
        Required,
        "A landscape: what lies below the heights of a picture (PNG, of 8 or 16 bits), black at z = 0, around the origin. Heights go evenly from the middle of one pixel to the next. `relief.png`, where there is no such file beside the scene, is a built-in picture.",
    ),
    parameters: &[
        Key::length("width", Number(1.0), "How wide the whole picture is along x."),
        Key::length("height", Of("width", 0.25), "How high white lies above black."),
        Key::new("base", Kind::Number, Of("height", 0.2), "How far it goes on below black.")
            .limit(Limit::NotNegative)
            .unit("units"),
        CHANNEL,
    ],
    formula: "min(height·v(x, y) − z, the distances to its sides and its base), v from 0 to 1 between pixels; no steeper than the greatest step from one pixel to the next",
    example: "height_field = \"relief.png\"\nwidth = 2",
    import: Some(import),
    build: |build| {
        let heights = build.imported()?;
        let [width, height, base] = [build.number("width")?, build.number("height")?, build.number("base")?];
        let side = heights.solid.size() * width;
        let graph = build.graph();
        let picture = graph.field(Arc::clone(&heights.distance));
        let wide = DAffine3::from_scale(DVec3::new(width, width, 1.0));
        let picture = graph.transform(picture, &wide).expect("a width is greater than 0");
        let (top, z) = (graph.linear(picture, height, 0.0), graph.z());
        let top = graph.sub(top, z);
        let walls = [graph.slab(DVec3::X, side.x), graph.slab(DVec3::Y, side.y), graph.half_space(-DVec3::Z, base)];
        let solid = graph.intersection(SetSystem::MinMax, &[top, walls[0], walls[1], walls[2]]);
        let half = side / 2.0;
        let bounds = Aabb::new(DVec3::new(-half.x, -half.y, -base), DVec3::new(half.x, half.y, height));
        Ok(graph.bounded(solid, bounds))
    },
    ..Spec::PLAIN
};

/// The heights from 0 to 1 of a picture one unit wide, and the box that it takes.
fn import(import: &Import<'_>) -> Result<Imported, Problem> {
    let file = import.file("height_field");
    let raster = raster(file, import.arguments)?;
    let pixels = (raster.width() * raster.height()) as u64;
    let heights = Heights::new(raster);
    let half = DVec3::new(0.5, 0.5 * heights.aspect(), 0.5);
    Ok(Imported {
        place: DAffine3::IDENTITY,
        solid: Aabb::new(-half, half),
        half_spaces: None,
        colours: None,
        materials: None,
        velocity: None,
        warnings: Vec::new(),
        bytes: Heights::bytes(pixels),
        distance: Arc::new(heights) as Arc<dyn Field>,
    })
}
