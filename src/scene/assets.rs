//! What a scene reads from files: once, before any frame.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::attribute::VoxelValues;
use crate::mesh::{Holes, MeshDistance, TriangleMesh, read, read_obj};

use super::error::Problem;
use super::files::{FilePlace, FileReference};
use super::model::{AttributeSource, Maker, Model, ShapeId, VoxelSource};
use super::volume;

/// The meshes and volumes of a scene.
#[derive(Clone, Default)]
pub(super) struct Assets {
    meshes: BTreeMap<ShapeId, Arc<MeshDistance>>,
    colours: BTreeMap<ShapeId, Arc<VoxelValues<3>>>,
    /// By shape and name.
    scalars: BTreeMap<(ShapeId, String), Arc<VoxelValues<1>>>,
}

impl Assets {
    /// Reads the files of some shapes. No volume of voxels may take more than the limit, in bytes.
    pub fn load(model: &Model, shapes: &[ShapeId], memory_limit: Option<usize>) -> Result<Self, Problem> {
        let mut assets = Self::default();
        let (mut colours, mut scalars) = (Loaded::new(memory_limit), Loaded::new(memory_limit));
        for &id in shapes {
            let shape = model.shape(id);
            if let Maker::Mesh { file } = &shape.maker {
                assets.meshes.insert(id, Arc::new(load_mesh(file)?));
            }
            if let Some(AttributeSource::Voxels(source)) = &shape.colour {
                assets.colours.insert(id, colours.values(&volume::COLOURS, source)?);
            }
            for (name, scalar) in &shape.scalars {
                if let AttributeSource::Voxels(source) = scalar {
                    assets.scalars.insert((id, name.clone()), scalars.values(&volume::SCALARS, source)?);
                }
            }
        }
        Ok(assets)
    }

    /// The mesh of a shape with the maker `mesh`, which was among those loaded.
    pub fn mesh(&self, id: ShapeId) -> &Arc<MeshDistance> {
        &self.meshes[&id]
    }

    /// The colours of a shape that has them from voxels, which was among those loaded.
    pub fn colours(&self, id: ShapeId) -> &Arc<VoxelValues<3>> {
        &self.colours[&id]
    }

    /// A scalar of a shape that has it from voxels, which was among those loaded.
    pub fn scalar(&self, id: ShapeId, name: &str) -> &Arc<VoxelValues<1>> {
        &self.scalars[&(id, name.to_owned())]
    }

    /// Memory that the meshes and volumes take, about, in bytes.
    pub fn bytes(&self) -> u64 {
        /// Corners, triangles, normals and tree, by triangle.
        const BYTES_A_TRIANGLE: u64 = 300;
        let meshes = self.meshes.values().map(|mesh| mesh.mesh().triangles().len() as u64 * BYTES_A_TRIANGLE);
        meshes.sum::<u64>() + memory_of(self.colours.values()) + memory_of(self.scalars.values())
    }
}

/// Memory of volumes, each counted once.
fn memory_of<'v, const N: usize>(volumes: impl Iterator<Item = &'v Arc<VoxelValues<N>>>) -> u64 {
    let mut volumes: Vec<&Arc<VoxelValues<N>>> = volumes.collect();
    volumes.sort_by_key(|values| Arc::as_ptr(values));
    volumes.dedup_by(|a, b| Arc::ptr_eq(a, b));
    volumes.into_iter().map(|values| values.memory()).sum()
}

/// Volumes read so far: what several shapes name is read once.
struct Loaded<'m, const N: usize> {
    memory_limit: Option<usize>,
    known: Vec<(&'m VoxelSource, Arc<VoxelValues<N>>)>,
}

impl<'m, const N: usize> Loaded<'m, N> {
    fn new(memory_limit: Option<usize>) -> Self {
        Self { memory_limit, known: Vec::new() }
    }

    fn values(&mut self, wanted: &volume::Wanted<N>, source: &'m VoxelSource) -> Result<Arc<VoxelValues<N>>, Problem> {
        if let Some((_, values)) = self.known.iter().find(|(other, _)| source.is_same(other)) {
            return Ok(Arc::clone(values));
        }
        let values = Arc::new(volume::load(wanted, source, self.memory_limit)?);
        self.known.push((source, Arc::clone(&values)));
        Ok(values)
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
