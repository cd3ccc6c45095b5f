//! What a mesh file holds, and what is wrong with it: for people who are about to use it.

use std::path::Path;

use serde::Serialize;

use super::read::{Conventions, Place, Remark};
use super::{Holes, MeshDistance, MeshError, Picture, read};

/// What there is to say about a mesh file.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Vertices of its triangles.
    pub vertices: usize,
    /// Triangles: polygons are cut into them.
    pub triangles: usize,
    /// The least and the greatest corner of its box, in the file's own axes and unit.
    pub extent: [[f64; 3]; 2],
    /// Edges at holes: that one triangle uses, or an odd number.
    pub boundary_edges: usize,
    /// Edges whose triangles face opposite ways.
    pub inconsistent_edges: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Of a closed mesh: the volume of its solid.
    pub volume: Option<f64>,
    /// Materials.
    pub materials: usize,
    /// Width and height of each material's picture, or of its first tile.
    pub pictures: Vec<[usize; 2]>,
    /// Whether its vertices have colours.
    pub vertex_colours: bool,
    /// What was left out, mended, or is worth knowing, each with what to do.
    pub notes: Vec<String>,
}

/// Reads a mesh file and looks at it.
///
/// # Errors
/// Those of [`read`]; a surface with holes is none.
pub fn report(file: &Path) -> Result<Report, MeshError> {
    let imported = read(file, &Conventions::default())?;
    let told = |Remark { place, text, help, .. }: &Remark| {
        let place = place.as_ref().map_or_else(String::new, |place: &Place| format!("{place}: "));
        format!("{place}{text} ({help})")
    };
    let mut notes: Vec<String> = imported.remarks.iter().map(told).collect();
    let topology = imported.mesh.topology();
    let extent = imported.mesh.bounding_box();
    let pictures = imported.materials.iter().filter_map(|material| match &material.picture {
        Some(Picture::Single(texture)) => Some(texture.pixels()),
        Some(Picture::Tiles(tiles)) => tiles.values().next().map(|texture| texture.pixels()),
        None => None,
    });
    let mut report = Report {
        vertices: imported.mesh.positions().len(),
        triangles: imported.mesh.triangles().len(),
        extent: [extent.min.to_array(), extent.max.to_array()],
        boundary_edges: topology.boundary_edges,
        inconsistent_edges: topology.inconsistent_edges,
        non_manifold_edges: topology.non_manifold_edges,
        volume: None,
        materials: imported.materials.len(),
        pictures: pictures.collect(),
        vertex_colours: imported.mesh.colours().is_some(),
        notes: Vec::new(),
    };
    if topology.is_closed() {
        match MeshDistance::new(imported.mesh, Holes::Refuse) {
            Ok(solid) => {
                report.volume = Some(solid.mesh().volume());
                notes.extend(solid.notes().iter().cloned());
            }
            Err(problem) => notes.push(problem.to_string()),
        }
    }
    report.notes = notes;
    Ok(report)
}
