//! What a scene reads from files: once, before any frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::mesh::{Holes, MeshDistance, TriangleMesh, read, read_obj};

use super::error::Problem;
use super::files::{FilePlace, FileReference};
use super::model::{Maker, Model, ShapeId};

/// The meshes of a scene.
#[derive(Clone, Debug, Default)]
pub(super) struct Assets {
    meshes: BTreeMap<ShapeId, Arc<MeshDistance>>,
}

impl Assets {
    /// Reads the files of some shapes.
    pub fn load(model: &Model, shapes: &[ShapeId]) -> Result<Self, Problem> {
        let mut assets = Self::default();
        for &id in shapes {
            if let Maker::Mesh { file } = &model.shape(id).maker {
                assets.meshes.insert(id, Arc::new(load_mesh(file)?));
            }
        }
        Ok(assets)
    }

    /// The mesh of a shape with the maker `mesh`, which was among those loaded.
    pub fn mesh(&self, id: ShapeId) -> &Arc<MeshDistance> {
        &self.meshes[&id]
    }

    /// Memory that the meshes take, about, in bytes.
    pub fn bytes(&self) -> u64 {
        /// Corners, triangles, normals and tree, by triangle.
        const BYTES_A_TRIANGLE: u64 = 300;
        self.meshes.values().map(|mesh| mesh.mesh().triangles().len() as u64 * BYTES_A_TRIANGLE).sum()
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
