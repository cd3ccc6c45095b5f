//! A level set or fog of another program.

use std::sync::Arc;

use glam::DAffine3;

use crate::attribute::{Attribute, Colour, Outside};
use crate::distance::SampledLevelSet;
use crate::field::Field;
use crate::grid::{Band, InsideTile, Lattice, VoxelSize};
use crate::node::argument::Argument;
use crate::node::keys::{FRAME_OFFSET, OUTSIDE_FRAMES};
use crate::node::model::VoxelSource;
use crate::node::spec::{Carries, ColoursOf, Import, Imported, Spec};
use crate::node::volume;
use crate::text::diagnostic::{Diagnostic, Severity, clip, listed, nearest};
use crate::text::key::Absent::{Nothing, Required, Words};
use crate::text::key::{Key, Kind};
use crate::text::problem::Problem;
use crate::vdb::walk::GridLayout;
use crate::vdb::{Opened, SparseBlocks, StoredClass, StoredGrid, Transform, VELOCITIES, Voxels};

/// The value at which fog has its surface where nobody says.
const THRESHOLD: f64 = 0.5;
/// Grids that are a file's colour where it has one of them.
const COLOURS: [&str; 2] = ["Cd", "color"];
/// A block's values, and what finds them.
const BYTES_A_BLOCK: u64 = 2048 + 128;

/// A level set or fog of another program.
pub const NODE: Spec = Spec {
    key: Key::new(
        "vdb",
        Kind::Paths,
        Required,
        "What is solid in a `.vdb` file of any maker: a level set, or fog from a value on. It stands where its own transform puts it, also turned, sheared or with voxels that are no cubes. Between voxels it is trilinear; its distances are measured anew. Its `Cd` or `color` is its colour where `color` is left out.",
    ),
    parameters: &[
        Key::new(
            "grid",
            Kind::Text,
            Words("the first level set, else `density`, else the first grid of numbers"),
            "The grid: one number a voxel.",
        ),
        Key::new(
            "threshold",
            Kind::Constant,
            Nothing,
            "Of fog: the value from which on it is solid; 0.5 where it is left out. Of a level set there is none.",
        ),
        FRAME_OFFSET,
        OUTSIDE_FRAMES,
    ],
    formula: "trilinear between voxels: −φ of a level set, v − `threshold` of fog",
    example: "vdb = \"ball.vdb\"",
    carries: Carries::Import,
    import: Some(import),
    build: |build| build.imported_field(),
    ..Spec::PLAIN
};

fn import(import: &Import<'_>) -> Result<Imported, Problem> {
    let file = import.file("vdb");
    let (named, span) = match import.arguments.get("grid") {
        Some(Argument::Text(grid, span)) => (Some(grid.as_str()), *span),
        _ => (None, file.span),
    };
    let opened = volume::opened(file)?;
    let layout = chosen(&opened, named)
        .map_err(|(problem, help)| Problem::new(span, format!("{}: {problem}", file.name())).help(help))?;
    let wrong = |what: &str| Problem::new(span, format!("grid '{}' of {} {what}", layout.name, file.name()));
    let bytes =
        opened.layout.tree(layout).map_or(0, |tree| tree.leaves.saturating_mul(2 * BYTES_A_BLOCK)) + opened.size();
    if let Some(text) = volume::too_much(bytes, import.memory_limit) {
        return Err(wrong(&text).help(volume::LESS));
    }
    let stored = opened.grid(layout).map_err(|error| Problem::new(file.span, error.to_string()))?;
    let Some(StoredGrid { class, transform, voxels: Voxels::Floats(blocks), .. }) = stored else {
        return Err(wrong("has no single number a voxel").help(there_is(&opened)));
    };
    let Transform::Affine(matrix) = transform else {
        return Err(wrong("stands in a frustum, which is not read").help("resample it onto a grid with even voxels"));
    };
    let place = DAffine3::from_mat4(matrix);
    let edge = place.matrix3.determinant().abs().cbrt();
    if !(place.is_finite() && edge > 0.0) {
        return Err(wrong("has a transform that cannot be turned back"));
    }
    let threshold = import.arguments.constant("threshold").copied();
    let (level, scale) = match (class, threshold) {
        (StoredClass::LevelSet, Some(_)) => {
            return Err(wrong("is a level set, whose surface is at 0").help("leave out `threshold`"));
        }
        // In voxels, so that where its own transform puts it they are world units.
        (StoredClass::LevelSet, None) => (0.0, 1.0 / edge),
        // What is just as dense is solid, not surface all through.
        (_, threshold) => {
            let threshold = threshold.unwrap_or(THRESHOLD);
            (threshold - 1e-5 * threshold.abs(), 1.0)
        }
    };
    let field = SampledLevelSet::new(band(blocks, level, scale).map_err(|what| wrong(&what))?);
    let Some(solid) = field.bounding_box().filter(|aabb| aabb.size().max_element() > 0.0) else {
        let help = match class {
            StoredClass::LevelSet => "a level set is negative inside; `hfvdb check` tells what is wrong with it",
            _ => "choose a lower `threshold`; `hfvdb info` tells the range of its values",
        };
        return Err(wrong("has nothing inside").help(help));
    };
    let mut warnings = Vec::new();
    if class != StoredClass::LevelSet && threshold.is_none() {
        let note = format!("{}: fog '{}' is solid from {THRESHOLD} on", file.name(), layout.name);
        let mut note = Diagnostic::warning(span, note).help("`threshold` says another value");
        note.severity = Severity::Note;
        warnings.push(note);
    }
    let three = |wanted: &volume::Wanted<3>, names: &[&str]| {
        let is_there = |name: &&&str| opened.layout.grids.iter().any(|grid| grid.name == **name);
        let Some(grid) = names.iter().find(is_there) else { return Ok(None) };
        let grid = (*grid).to_owned();
        let source = VoxelSource { file: file.clone(), grid, grid_span: file.span, outside: Outside::Foot };
        volume::load(wanted, &source, import.memory_limit).map(|values| Some(Arc::new(values)))
    };
    let mut colours = None;
    if import.shows_colours
        && let Some(values) = three(&volume::COLOURS, &COLOURS)?
    {
        colours = Some(Box::new(move |_: f64| Arc::clone(&values) as Arc<Colour>) as ColoursOf);
    }
    let mut velocity = None;
    if import.shows_velocity {
        velocity = three(&volume::VELOCITIES, &VELOCITIES)?.map(|values| values as Arc<dyn Attribute<3>>);
    }
    Ok(Imported {
        distance: Arc::new(field),
        place,
        solid,
        half_spaces: None,
        colours,
        materials: None,
        velocity,
        warnings,
        bytes,
    })
}

/// The grid of a name, or the one that is most likely meant.
pub(in crate::node) fn chosen<'o>(opened: &'o Opened, named: Option<&str>) -> Result<&'o GridLayout, (String, String)> {
    let grids = &opened.layout.grids;
    if let Some(name) = named {
        return grids.iter().find(|grid| grid.name == name).ok_or_else(|| {
            let near = nearest(name, grids.iter().map(|grid| grid.name.as_str()));
            let help = near.map_or_else(|| there_is(opened), |near| format!("did you mean `{near}`?"));
            (format!("there is no grid '{}'", clip(name)), help)
        });
    }
    let numbers = || grids.iter().filter(|grid| ["float", "double"].contains(&grid.value_type()));
    let level_set = numbers().find(|grid| StoredClass::of(&grid.metadata) == StoredClass::LevelSet);
    let found = level_set.or_else(|| numbers().find(|grid| grid.name == "density")).or_else(|| numbers().next());
    found.ok_or_else(|| ("there is no grid of numbers".into(), there_is(opened)))
}

fn there_is(opened: &Opened) -> String {
    let grid = |grid: &GridLayout| format!("{} ({})", clip(&grid.name), clip(grid.value_type()));
    let names: Vec<String> = opened.layout.grids.iter().map(grid).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    if names.is_empty() { "it has no grids".into() } else { format!("there is {}", listed(&names)) }
}

/// A grid's values above a level, positive inside, in voxels of edge 1; beyond the blocks as far below as the background.
fn band(blocks: SparseBlocks<f32>, level: f64, scale: f64) -> Result<Band, String> {
    let SparseBlocks { origins, mut values, active, tiles, background } = blocks;
    let moved = |value: f32| ((f64::from(value) - level) * scale) as f32;
    let half_width = -moved(background);
    if !(half_width.is_finite() && half_width > 0.0) {
        return Err(format!("has a background of {background}, which is not outside"));
    }
    for value in values.as_flattened_mut() {
        let found = moved(*value);
        if found.is_nan() {
            return Err("has values that are no numbers".into());
        }
        *value = found.clamp(-half_width, half_width);
    }
    let inside = tiles.iter().filter(|tile| moved(tile.value) > 0.0);
    let inside_tiles = inside.map(|tile| InsideTile { origin: tile.origin, edge: tile.edge }).collect();
    let voxel_size = VoxelSize::new(1.0).expect("1 is a size");
    Ok(Band { lattice: Lattice { voxel_size }, half_width, origins, distances: values, active, inside_tiles })
}
