//! What a scene reads from files: once, before any frame.

use std::collections::{BTreeMap, HashSet};
use std::sync::{Arc, Mutex, PoisonError};

use crate::attribute::VoxelValues;

use crate::node::model::{Content, Model, ShapeId, VoxelSource};
use crate::node::spec::{Import, ImportOf, Imported};
use crate::node::volume;
use crate::text::diagnostic::Diagnostic;
use crate::text::problem::Problem;
use crate::text::sequence::FileSequence;

/// The files of a scene.
#[derive(Default)]
pub(crate) struct Assets {
    memory_limit: Option<usize>,
    /// The imported shapes whose own colours a frame shows.
    coloured: HashSet<ShapeId>,
    imported: BTreeMap<ShapeId, Arc<Imported>>,
    colours: BTreeMap<ShapeId, Arc<VoxelValues<3>>>,
    /// By shape and name.
    scalars: BTreeMap<(ShapeId, String), Arc<VoxelValues<1>>>,
    by_frame: ByFrame,
    warnings: Mutex<Vec<Said>>,
}

/// What was read last of files by frame.
#[derive(Default)]
struct ByFrame {
    imported: Kept<(ShapeId, i64), Imported>,
    colours: Kept<VoxelSource, VoxelValues<3>>,
    scalars: Kept<VoxelSource, VoxelValues<1>>,
}

/// What there is to know about files, and of which it was said.
struct Said {
    warning: Diagnostic,
    /// Its text without the file's name.
    text: String,
    files: Vec<String>,
}

impl Assets {
    /// Reads the files of some shapes; of files by frame those of the shot's first. No volume of voxels may take more than
    /// the limit, in bytes.
    pub fn load(model: &Model, shapes: &[ShapeId], memory_limit: Option<usize>) -> Result<Self, Problem> {
        let mut assets = Self { memory_limit, coloured: shown_with_own_colours(model), ..Self::default() };
        let (mut colours, mut scalars) = (Loaded::new(memory_limit), Loaded::new(memory_limit));
        let first = model.shot.range.first as f64;
        for &id in shapes {
            let shape = model.shape(id);
            if let Some(import) = shape.spec.import {
                if shape.arguments.sequence().is_some() {
                    assets.by_frame.imported.most += KEPT_OF_EACH;
                    assets.imported(model, id, first)?;
                } else {
                    let imported = assets.import(model, id, import, first)?;
                    assets.imported.insert(id, Arc::new(imported));
                }
            }
            if let Some(given) = shape.colour.as_ref().filter(|given| given.source.is_volume) {
                if given.arguments.sequence().is_some() {
                    assets.by_frame.colours.most += KEPT_OF_EACH;
                    assets.colours(model, id, first)?;
                } else {
                    let source = VoxelSource::of(&given.arguments, "Cd", first);
                    assets.colours.insert(id, colours.values(&volume::COLOURS, source)?);
                }
            }
            for (name, given) in shape.scalars.iter().filter(|(_, given)| given.source.is_volume) {
                if given.arguments.sequence().is_some() {
                    assets.by_frame.scalars.most += KEPT_OF_EACH;
                    assets.scalar(model, id, name, first)?;
                } else {
                    let source = VoxelSource::of(&given.arguments, name, first);
                    assets.scalars.insert((id, name.clone()), scalars.values(&volume::SCALARS, source)?);
                }
            }
        }
        Ok(assets)
    }

    /// Reads the file of a shape at a frame.
    fn import(&self, model: &Model, id: ShapeId, import: ImportOf, frame: f64) -> Result<Imported, Problem> {
        let shape = model.shape(id);
        let mut imported = import(&Import {
            arguments: &shape.arguments,
            frame,
            up: model.up,
            unit: model.unit,
            shows_colours: self.coloured.contains(&id),
            shows_velocity: model.output.writes("vel"),
            memory_limit: self.memory_limit,
        })?;
        if model.output.writes("vel")
            && imported.velocity.is_none()
            && shape.arguments.sequence().is_some_and(FileSequence::varies)
        {
            let file = shape.arguments.file_at(shape.spec.key.name, frame).expect("it is a sequence");
            let text = format!("{}: what changes from file to file is not in `vel`", file.name());
            let help = match shape.spec.key.name {
                "vdb" => "grids `vel`, `velocity` or `v` of three numbers would tell; leave `vel` out of output.grids",
                _ => "such files tell no velocity; leave `vel` out of output.grids",
            };
            imported.warnings.push(Diagnostic::warning(file.span, text).help(help));
        }
        let name = match shape.arguments.sequence() {
            Some(files) => files.at(frame).1.name(),
            None => String::new(),
        };
        for warning in imported.warnings.drain(..) {
            self.warn(warning, &name);
        }
        Ok(imported)
    }

    /// Keeps what is to be said about a file, once however many shapes name it, and once for all files by frame; `file` is the
    /// name of one of those.
    fn warn(&self, warning: Diagnostic, file: &str) {
        let text = warning.message.strip_prefix(file).unwrap_or(&warning.message).to_owned();
        let mut said = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        if said.iter().any(|known| known.text == text && known.files.iter().any(|known| known == file)) {
            return;
        }
        match said.iter_mut().find(|known| known.text == text && known.warning.span == warning.span) {
            Some(known) => known.files.push(file.to_owned()),
            None => said.push(Said { warning, text, files: vec![file.to_owned()] }),
        }
    }

    /// What there is to know about the files that were read.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let said = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        let told = |Said { warning, text, files }: &Said| {
            let mut warning = warning.clone();
            if let (Some(first), more @ 1..) = (files.iter().min(), files.len() - 1) {
                warning.message = format!("{first} and {more} more of its files{text}");
            }
            warning
        };
        said.iter().map(told).collect()
    }

    /// What the file of a shape holds at a frame; the shape was among those loaded.
    pub fn imported(&self, model: &Model, id: ShapeId, frame: f64) -> Result<Arc<Imported>, Problem> {
        let shape = model.shape(id);
        match (shape.arguments.sequence(), shape.spec.import) {
            (Some(files), Some(import)) => {
                let (number, _) = files.at(frame);
                self.by_frame.imported.get((id, *number), || self.import(model, id, import, frame))
            }
            _ => Ok(Arc::clone(&self.imported[&id])),
        }
    }

    /// The colours at a frame of a shape that has them from voxels; it was among those loaded.
    pub fn colours(&self, model: &Model, id: ShapeId, frame: f64) -> Result<Arc<VoxelValues<3>>, Problem> {
        match model.shape(id).colour.as_ref().filter(|given| given.arguments.sequence().is_some()) {
            Some(given) => {
                let source = VoxelSource::of(&given.arguments, "Cd", frame);
                let load = || volume::load(&volume::COLOURS, &source, self.memory_limit);
                self.by_frame.colours.get(source.clone(), load)
            }
            None => Ok(Arc::clone(&self.colours[&id])),
        }
    }

    /// A scalar at a frame of a shape that has it from voxels; it was among those loaded.
    pub fn scalar(&self, model: &Model, id: ShapeId, name: &str, frame: f64) -> Result<Arc<VoxelValues<1>>, Problem> {
        match model.shape(id).scalars.get(name).filter(|given| given.arguments.sequence().is_some()) {
            Some(given) => {
                let source = VoxelSource::of(&given.arguments, name, frame);
                let load = || volume::load(&volume::SCALARS, &source, self.memory_limit);
                self.by_frame.scalars.get(source.clone(), load)
            }
            None => Ok(Arc::clone(&self.scalars[&(id, name.to_owned())])),
        }
    }

    /// Memory that they take, about, in bytes.
    pub fn bytes(&self) -> u64 {
        let ByFrame { imported, colours, scalars } = &self.by_frame;
        let by_frame = imported.bytes(|imported| imported.bytes)
            + colours.bytes(VoxelValues::memory)
            + scalars.bytes(VoxelValues::memory);
        let imported: u64 = self.imported.values().map(|imported| imported.bytes).sum();
        imported + memory_of(self.colours.values()) + memory_of(self.scalars.values()) + by_frame
    }
}

/// How many files of a sequence are kept at a time: those of a frame and of the next one, which are computed at once. Fewer:
/// files are read twice; more: memory.
const KEPT_OF_EACH: usize = 2;

/// What was used last.
struct Kept<K, V> {
    /// How many are kept.
    most: usize,
    /// The last used stands last.
    known: Mutex<Vec<(K, Arc<V>)>>,
}

impl<K, V> Default for Kept<K, V> {
    fn default() -> Self {
        Self { most: 0, known: Mutex::default() }
    }
}

impl<K: PartialEq, V> Kept<K, V> {
    /// What is known by a key, or what `load` gives. Two threads may load the same: none waits for the other, which may be at
    /// work further up its own stack.
    fn get(&self, key: K, load: impl FnOnce() -> Result<V, Problem>) -> Result<Arc<V>, Problem> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut known = known();
            if let Some(place) = known.iter().position(|(other, _)| *other == key) {
                let entry = known.remove(place);
                let value = Arc::clone(&entry.1);
                known.push(entry);
                return Ok(value);
            }
        }
        let value = Arc::new(load()?);
        let mut known = known();
        if known.len() >= self.most {
            known.remove(0);
        }
        known.push((key, Arc::clone(&value)));
        Ok(value)
    }

    /// Memory of as many as are kept, as large as those there are.
    fn bytes(&self, of: impl Fn(&V) -> u64) -> u64 {
        let known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let largest = known.iter().map(|(_, value)| of(value)).max().unwrap_or(0);
        largest * self.most as u64
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
