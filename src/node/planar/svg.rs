//! What a drawing fills.

use glam::DVec2;

use crate::field::outline;
use crate::node::profile::flat_import;
use crate::node::spec::{Import, Imported, Plane, Spec};
use crate::svg;
use crate::text::diagnostic::Diagnostic;
use crate::text::key::Absent::{Required, Text, Words};
use crate::text::key::{Key, Kind, Limit};
use crate::text::problem::Problem;

/// What a drawing fills.
pub const NODE: Spec = Spec {
    key: Key::new(
        "svg",
        Kind::Path,
        Required,
        "What an SVG drawing fills, in whatever colours: its paths by their own fill rules, and its strokes. Text must be paths; clips, masks and pictures are not read. `logo.svg`, where there is no such file beside the scene, is a built-in drawing.",
    ),
    parameters: &[
        Key::new("width", Kind::Constant, Words("its own size, a unit for each pixel"), "How wide it is.")
            .limit(Limit::Positive)
            .unit("units"),
        Key::new(
            "fit",
            Kind::Choice(&["drawing", "page"]),
            Text("drawing"),
            "What `width` is that of and what stands around the origin: what is drawn, or the page, so that several drawings fit.",
        ),
    ],
    formula: "the signed distance to what is filled, curves of straight pieces within 1e-5 of the page",
    source: "SVG 2",
    example: "svg = \"logo.svg\"\nwidth = 2",
    plane: Plane::Flat,
    import: Some(import),
    build: |build| build.imported_field(),
    ..Spec::PLAIN
};

const MOST_BYTES: u64 = 256 << 20;

fn import(import: &Import<'_>) -> Result<Imported, Problem> {
    let file = import.file("svg");
    let mut read = svg::read(&file.read_at_most(MOST_BYTES)?)
        .map_err(|problem| file.problem(problem).help("save it anew from the program that made it, as plain SVG"))?;
    let mut corners = read.loops.iter().flatten();
    let first = corners.next().ok_or_else(|| {
        file.problem("it draws nothing").help("its shapes need a fill or a stroke; text must be turned into paths")
    })?;
    let start = [DVec2::from(*first); 2];
    let [mut min, mut max] =
        corners.fold(start, |[min, max], at| [min.min(DVec2::from(*at)), max.max(DVec2::from(*at))]);
    if import.arguments.choice("fit") == Some(&"page") {
        (min, max) = (-read.page / 2.0, read.page / 2.0);
    }
    let middle = (min + max) / 2.0;
    let scale = import.arguments.constant("width").map_or(1.0, |width| width / (max.x - min.x));
    for corner in read.loops.iter_mut().flatten() {
        *corner = ((DVec2::from(*corner) - middle) * scale).to_array();
    }
    let mut imported = flat_import(outline(&read.loops).expect("it has loops"));
    imported.warnings.extend(read.leaves_out.map(|what| {
        Diagnostic::warning(file.span, format!("{}: {what} not read", file.name()))
            .help("turn text into paths, and cut paths where they are clipped")
    }));
    Ok(imported)
}
