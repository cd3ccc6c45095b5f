//! What is bright in a picture, or dark.

use glam::DVec2;

use crate::field::outline;
use crate::node::argument::Arguments;
use crate::node::profile::flat_import;
use crate::node::spec::{Import, Imported, Plane, Spec};
use crate::raster::{Channel, Raster};
use crate::text::files::FileReference;
use crate::text::key::Absent::{Number, Required, Text};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// What is bright in a picture, or dark.
pub const NODE: Spec = Spec {
    key: Key::new(
        "image",
        Kind::Path,
        Required,
        "What is bright in a picture (PNG), or dark: around the origin. Its edge is where the number between the middles of two pixels passes the threshold, and the picture's own edge. `leaf.png`, where there is no such file beside the scene, is a built-in picture.",
    ),
    parameters: &[
        Key::new("width", Kind::Constant, Number(1.0), "How wide the whole picture is.")
            .limit(Limit::Positive)
            .unit("units"),
        Key::new(
            "threshold",
            Kind::Constant,
            Number(0.5),
            "The number at its edge, of 0 (black) to 1 (white), as it is written in the file.",
        )
        .limit(Limit::Within(0.0, 1.0)),
        Key::new(
            "inside",
            Kind::Choice(&["above", "below"]),
            Text("above"),
            "Whether the shape is what is above the threshold or below it.",
        ),
        CHANNEL,
    ],
    formula: "the signed distance to that edge, of straight pieces from pixel to pixel",
    source: "marching squares",
    example: "image = \"leaf.png\"\nwidth = 2\ninside = \"below\"",
    plane: Plane::Flat,
    import: Some(import),
    build: |build| build.imported_field(),
    ..Spec::PLAIN
};

/// What of pixels counts.
pub const CHANNEL: Key = Key::new(
    "channel",
    Kind::Choice(&["luminance", "alpha", "red", "green", "blue"]),
    Text("luminance"),
    "What of its pixels counts.",
);

/// The picture of a key.
pub fn raster(file: &FileReference, arguments: &Arguments) -> Result<Raster, Problem> {
    const MOST_BYTES: u64 = 1 << 30;
    let channel = match arguments.choice("channel") {
        Some(&"alpha") => Channel::Alpha,
        Some(&"red") => Channel::Red,
        Some(&"green") => Channel::Green,
        Some(&"blue") => Channel::Blue,
        _ => Channel::Luminance,
    };
    let read = Raster::read(&file.read_at_most(MOST_BYTES)?, channel);
    read.map_err(|problem| file.problem(problem).help("a PNG picture, and a `channel` that it has"))
}

fn import(import: &Import<'_>) -> Result<Imported, Problem> {
    let arguments = import.arguments;
    let constant = |key: &str| *arguments.constant(key).expect("it has a default");
    let file = arguments.file("image").expect("it must be there");
    let raster = raster(file, arguments)?;
    let above = arguments.choice("inside") != Some(&"below");
    let (threshold, width) = (constant("threshold"), constant("width"));
    let mut loops = raster
        .level(threshold, above)
        .map_err(|problem| file.problem(problem).help("a smaller picture, or one with less noise"))?;
    let scale = width / raster.width() as f64;
    let middle = DVec2::new(raster.width() as f64, raster.height() as f64) / 2.0;
    for corner in loops.iter_mut().flatten() {
        *corner = ((DVec2::from(*corner) - middle) * scale).to_array();
    }
    let outline = outline(&loops).ok_or_else(|| {
        let side = if above { "above" } else { "below" };
        file.problem(format!("nothing in it is {side} {threshold}"))
            .help("another `threshold`, the other `inside`, or another `channel`, such as \"alpha\"")
    })?;
    Ok(flat_import(outline))
}
