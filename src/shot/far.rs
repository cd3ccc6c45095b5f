//! Shapes whose formulas and patterns are too far from the origin for 32 bits.

use glam::DVec3;

use crate::node::id::{ShapeId, Stage};
use crate::node::model::Model;
use crate::node::solid::Solids;
use crate::node::source::Given;
use crate::text::diagnostic::{Diagnostic, clip};
use crate::text::frames::plain;
use crate::text::source::Span;

/// How far, in voxels, a coordinate may be rounded: patterns a few voxels wide still look as they are.
const ROUNDED: f64 = 0.1;

/// Beyond that a box has no end.
const ENDLESS: f64 = 1e12;

/// A warning of each of some shapes whose coordinates, in its own space, are so large that they are rounded by much of a voxel,
/// and that has formulas or patterns which go by them.
pub(crate) fn far_out(model: &Model, solids: &mut Solids, parts: &[ShapeId], voxel: f64) -> Vec<Diagnostic> {
    parts.iter().filter_map(|id| of_shape(model, solids, *id, voxel)).collect()
}

fn of_shape(model: &Model, solids: &mut Solids, id: ShapeId, voxel: f64) -> Option<Diagnostic> {
    let shape = model.shape(id);
    let read = |farthest: DVec3| {
        let colour = shape.colour.iter().find_map(|given| by_coordinates(given, farthest));
        colour.or_else(|| shape.scalars.values().find_map(|given| by_coordinates(given, farthest)))
    };
    // Most shapes read none, and need not be built for it.
    read(DVec3::ZERO)?;
    let own = solids.field(id, Stage::Own).ok()?.bounding_box()?;
    let farthest = own.min.abs().max(own.max.abs());
    let farthest = DVec3::select(farthest.cmplt(DVec3::splat(ENDLESS)), farthest, DVec3::ZERO);
    let (span, farthest) = read(farthest)?;
    let scale = shape.placement.scale[0].as_constant().unwrap_or(1.0).abs();
    let nearest = farthest as f32;
    let spacing = f64::from(nearest.next_up() - nearest);
    if 0.5 * spacing * scale <= ROUNDED * voxel {
        return None;
    }
    let problem = format!(
        "`{}` reaches {} units from the origin of its own space, where 32-bit coordinates are {spacing} apart, {:.1} voxels: \
         its formulas and patterns are no finer",
        clip(&shape.name),
        plain(farthest.round()),
        spacing * scale / voxel
    );
    let help = "build it, with what it is made of, around the origin and put the whole there by its own `move`";
    Some(Diagnostic::warning(span, problem).help(help))
}

/// Where an attribute stands that goes by coordinates, and the greatest of those that it goes by.
fn by_coordinates<const N: usize>(given: &Given<N>, farthest: DVec3) -> Option<(Span, f64)> {
    if given.source.goes_by_coordinates {
        return Some((given.span, farthest.max_element()));
    }
    let axis = |name: &str| ["x", "y", "z"].iter().position(|axis| *axis == name);
    let axes = given.arguments.formulas().flat_map(|formula| formula.names().filter_map(axis));
    let most = axes.map(|axis| farthest[axis]).reduce(f64::max)?;
    Some((given.span, most))
}
