//! What a scene reads from files: once, before any frame.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use crate::attribute::VoxelValues;
use crate::mesh::{About, Conventions, Holes, MeshDistance, Remark, read, read_obj};

use crate::node::model::{AttributeSource, Content, Maker, Model, ShapeId, VoxelSource};
use crate::node::volume;
use crate::text::diagnostic::{Diagnostic, Severity};
use crate::text::files::{FilePlace, FileReference};
use crate::text::problem::Problem;

/// The meshes and volumes of a scene.
#[derive(Clone, Default)]
pub(crate) struct Assets {
    meshes: BTreeMap<ShapeId, Arc<MeshDistance>>,
    colours: BTreeMap<ShapeId, Arc<VoxelValues<3>>>,
    /// By shape and name.
    scalars: BTreeMap<(ShapeId, String), Arc<VoxelValues<1>>>,
    /// What there is to know about the files.
    pub warnings: Vec<Diagnostic>,
}

impl Assets {
    /// Reads the files of some shapes. No volume of voxels may take more than the limit, in bytes.
    pub fn load(model: &Model, shapes: &[ShapeId], memory_limit: Option<usize>) -> Result<Self, Problem> {
        let mut assets = Self::default();
        let (mut colours, mut scalars) = (Loaded::new(memory_limit), Loaded::new(memory_limit));
        let coloured = meshes_with_colours(model);
        for &id in shapes {
            let shape = model.shape(id);
            if let Maker::Mesh { file, conventions, up_is_given } = &shape.maker {
                let (mesh, mut remarks) = load_mesh(file, conventions)?;
                for note in mesh.notes() {
                    assets.warn_once(Diagnostic::warning(file.span, format!("{}: {note}", file.name())));
                }
                assets.meshes.insert(id, Arc::new(mesh));
                remarks.retain(|remark| match remark.about {
                    About::Faces => true,
                    About::Colours => coloured.contains(&id),
                    About::Up => !up_is_given,
                });
                assets.warn(file, remarks);
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

    /// Keeps what is to be said about a file, once however many shapes name it.
    fn warn(&mut self, file: &FileReference, remarks: Vec<Remark>) {
        for Remark { about, place, text, help } in remarks {
            let place = place.map_or_else(String::new, |place| format!(", {place}"));
            let mut warning = Diagnostic::warning(file.span, format!("{}{place}: {text}", file.name())).help(help);
            if about == About::Up {
                warning.severity = Severity::Note;
            }
            self.warn_once(warning);
        }
    }

    fn warn_once(&mut self, warning: Diagnostic) {
        if self.warnings.iter().all(|known| known.message != warning.message) {
            self.warnings.push(warning);
        }
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

/// The meshes whose own colours a frame shows.
fn meshes_with_colours(model: &Model) -> HashSet<ShapeId> {
    let mut meshes = HashSet::new();
    let mut open = match &model.content {
        _ if !model.output.writes(&model.output.colour_name) => Vec::new(),
        Content::Shape(id) => vec![*id],
        Content::Morph(morphs) => morphs.iter().flat_map(|morph| [morph.from, morph.to]).collect(),
    };
    let mut seen = HashSet::new();
    while let Some(id) = open.pop() {
        if !seen.insert(id) {
            continue;
        }
        let shape = model.shape(id);
        match &shape.colour {
            Some(source) => open.extend(source.parts()),
            None => open.extend(shape.maker.painters()),
        }
        if shape.colour.is_none() && matches!(shape.maker, Maker::Mesh { .. }) {
            meshes.insert(id);
        }
    }
    meshes
}

fn load_mesh(file: &FileReference, conventions: &Conventions) -> Result<(MeshDistance, Vec<Remark>), Problem> {
    let imported = match &file.place {
        FilePlace::Disk(path) => read(path, conventions).map_err(|error| Problem::new(file.span, error.to_string()))?,
        FilePlace::BuiltIn(_) => {
            let bytes = file.read().unwrap_or_default();
            read_obj(&bytes, conventions)
                .map_err(|error| Problem::new(file.span, format!("{}: {error}", file.name())))?
        }
    };
    let mesh = MeshDistance::new(imported.mesh, Holes::Refuse)
        .map_err(|error| Problem::new(file.span, format!("{}: {error}", file.name())))?;
    Ok((mesh, imported.remarks))
}
