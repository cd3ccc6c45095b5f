//! What a scene reads from files: once, before any frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::attribute::VoxelColours;
use crate::mesh::{Holes, MeshDistance, TriangleMesh, read, read_obj};

use super::error::Problem;
use super::files::{FilePlace, FileReference};
use super::model::{AttributeSource, Maker, Model, ShapeId, VoxelSource};
use super::volume;

/// The meshes and volumes of a scene.
#[derive(Clone, Default)]
pub(super) struct Assets {
    meshes: BTreeMap<ShapeId, Arc<MeshDistance>>,
    colours: BTreeMap<ShapeId, Arc<VoxelColours>>,
}

impl Assets {
    /// Reads the files of some shapes. No volume of voxels may take more than the limit, in bytes.
    pub fn load(model: &Model, shapes: &[ShapeId], memory_limit: Option<usize>) -> Result<Self, Problem> {
        let mut assets = Self::default();
        let mut loaded: Vec<(&VoxelSource, Arc<VoxelColours>)> = Vec::new();
        for &id in shapes {
            let shape = model.shape(id);
            if let Maker::Mesh { file } = &shape.maker {
                assets.meshes.insert(id, Arc::new(load_mesh(file)?));
            }
            if let Some(AttributeSource::Voxels(source)) = &shape.colour {
                let known = loaded.iter().find(|(other, _)| source.is_same(other));
                let colours = match known {
                    Some((_, colours)) => Arc::clone(colours),
                    None => Arc::new(volume::load(source, memory_limit)?),
                };
                loaded.push((source, Arc::clone(&colours)));
                assets.colours.insert(id, colours);
            }
        }
        Ok(assets)
    }

    /// The mesh of a shape with the maker `mesh`, which was among those loaded.
    pub fn mesh(&self, id: ShapeId) -> &Arc<MeshDistance> {
        &self.meshes[&id]
    }

    /// The colours of a shape that has them from voxels, which was among those loaded.
    pub fn colours(&self, id: ShapeId) -> &Arc<VoxelColours> {
        &self.colours[&id]
    }

    /// Memory that the meshes and volumes take, about, in bytes.
    pub fn bytes(&self) -> u64 {
        /// Corners, triangles, normals and tree, by triangle.
        const BYTES_A_TRIANGLE: u64 = 300;
        let mut volumes: Vec<&Arc<VoxelColours>> = self.colours.values().collect();
        volumes.sort_by_key(|colours| Arc::as_ptr(colours));
        volumes.dedup_by(|a, b| Arc::ptr_eq(a, b));
        let meshes = self.meshes.values().map(|mesh| mesh.mesh().triangles().len() as u64 * BYTES_A_TRIANGLE);
        meshes.chain(volumes.into_iter().map(|colours| colours.memory())).sum()
    }
}

fn load_mesh(file: &FileReference) -> Result<MeshDistance, Problem> {
    let triangles: TriangleMesh = match &file.place {
        FilePlace::Disk(path) => read(path).map_err(|error| Problem::new(file.span, error.to_string()))?,
        FilePlace::BuiltIn(_) => {
            let bytes = file.read().unwrap_or_default();
            read_obj(&bytes).map_err(|error| Problem::new(file.span, format!("{}: {error}", file.name())))?
        }
    };
    MeshDistance::new(triangles, Holes::Refuse)
        .map_err(|error| Problem::new(file.span, format!("{}: {error}", file.name())))
}
