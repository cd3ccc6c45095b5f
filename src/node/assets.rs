//! What a scene reads from files: once, before any frame.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use crate::attribute::VoxelValues;

use crate::node::model::{Content, Model, ShapeId, VoxelSource};
use crate::node::spec::{Import, Imported};
use crate::node::volume;
use crate::text::diagnostic::Diagnostic;
use crate::text::problem::Problem;

/// The files of a scene.
#[derive(Clone, Default)]
pub(crate) struct Assets {
    imported: BTreeMap<ShapeId, Arc<Imported>>,
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
        let coloured = shown_with_own_colours(model);
        for &id in shapes {
            let shape = model.shape(id);
            if let Some(import) = shape.spec.import {
                let mut imported = import(&Import {
                    arguments: &shape.arguments,
                    up: model.up,
                    unit: model.unit,
                    shows_colours: coloured.contains(&id),
                    memory_limit,
                })?;
                for warning in imported.warnings.drain(..) {
                    assets.warn_once(warning);
                }
                assets.imported.insert(id, Arc::new(imported));
            }
            if let Some(given) = shape.colour.as_ref().filter(|given| given.source.is_volume) {
                let source = VoxelSource::of(&given.arguments, "Cd");
                assets.colours.insert(id, colours.values(&volume::COLOURS, source)?);
            }
            for (name, given) in shape.scalars.iter().filter(|(_, given)| given.source.is_volume) {
                let source = VoxelSource::of(&given.arguments, name);
                assets.scalars.insert((id, name.clone()), scalars.values(&volume::SCALARS, source)?);
            }
        }
        Ok(assets)
    }

    /// Keeps what is to be said about a file, once however many shapes name it.
    fn warn_once(&mut self, warning: Diagnostic) {
        if self.warnings.iter().all(|known| known.message != warning.message) {
            self.warnings.push(warning);
        }
    }

    /// What the file of a shape holds, which was among those loaded.
    pub fn imported(&self, id: ShapeId) -> &Arc<Imported> {
        &self.imported[&id]
    }

    /// The colours of a shape that has them from voxels, which was among those loaded.
    pub fn colours(&self, id: ShapeId) -> &Arc<VoxelValues<3>> {
        &self.colours[&id]
    }

    /// A scalar of a shape that has it from voxels, which was among those loaded.
    pub fn scalar(&self, id: ShapeId, name: &str) -> &Arc<VoxelValues<1>> {
        &self.scalars[&(id, name.to_owned())]
    }

    /// Memory that they take, about, in bytes.
    pub fn bytes(&self) -> u64 {
        let imported: u64 = self.imported.values().map(|imported| imported.bytes).sum();
        imported + memory_of(self.colours.values()) + memory_of(self.scalars.values())
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
struct Loaded<const N: usize> {
    memory_limit: Option<usize>,
    known: Vec<(VoxelSource, Arc<VoxelValues<N>>)>,
}

impl<const N: usize> Loaded<N> {
    fn new(memory_limit: Option<usize>) -> Self {
        Self { memory_limit, known: Vec::new() }
    }

    fn values(&mut self, wanted: &volume::Wanted<N>, source: VoxelSource) -> Result<Arc<VoxelValues<N>>, Problem> {
        if let Some((_, values)) = self.known.iter().find(|(other, _)| source.is_same(other)) {
            return Ok(Arc::clone(values));
        }
        let values = Arc::new(volume::load(wanted, &source, self.memory_limit)?);
        self.known.push((source, Arc::clone(&values)));
        Ok(values)
    }
}

/// The imported shapes whose own colours a frame shows.
fn shown_with_own_colours(model: &Model) -> HashSet<ShapeId> {
    let mut shown = HashSet::new();
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
            Some(given) => open.extend(given.arguments.all_shapes()),
            None => open.extend(shape.painters()),
        }
        if shape.colour.is_none() && shape.spec.import.is_some() {
            shown.insert(id);
        }
    }
    shown
}
