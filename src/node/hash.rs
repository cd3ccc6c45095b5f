//! What identifies a scene's content: for the files' metadata and for resuming.

use std::path::PathBuf;

use sha2::{Digest, Sha256};

use crate::disk;
use crate::mesh;
use crate::node::argument::Arguments;
use crate::node::id::{ShapeId, Stage};
use crate::node::model::{Model, Morph, Shape};
use crate::text::files::{FilePlace, FileReference};
use crate::text::sequence::FileSequence;
use crate::text::value::Table;

/// A shape's own colour.
const COLOURS: [&str; 2] = ["color", "colour"];
/// What of a scene decides the surface of no shape.
const WITHOUT_SHAPE: [&str; 5] = ["output", "variant", "palette", "color", "colour"];

impl Model {
    /// SHA-256 of all that decides the voxels: the scene with its overrides, without spacing, comments, order of
    /// keys and unused variants, and the content of the files it names. Fails where such a file cannot be read.
    pub fn hash(&self) -> Result<[u8; 32], (FileReference, std::io::Error)> {
        self.hash_of(&self.document, &self.shapes.iter().collect::<Vec<_>>())
    }

    /// SHA-256 of all in the scene that decides the field of a shape, made as far as a stage: what it is made from, and all
    /// that these may name. Neither its colours nor what is done with it.
    pub(crate) fn part_hash(&self, id: ShapeId, stage: Stage) -> Result<[u8; 32], (FileReference, std::io::Error)> {
        let parts: Vec<&Shape> = self.with_parts(&[id]).into_iter().map(|part| self.shape(part)).collect();
        let own = &self.shape(id).name;
        let mut document = self.document.clone();
        let stands =
            document.get("shape").and_then(|entry| entry.value.table()).is_some_and(|all| all.get(own).is_some());
        if !stands {
            // Written in place, wherever that is.
            return self.hash_of(&document, &parts).map(|hash| of_stage(hash, own, stage));
        }
        document.0.retain(|entry| entry.key != "morph" && !WITHOUT_SHAPE.contains(&entry.key.as_str()));
        let shapes = document.get_mut("shape").and_then(|entry| entry.value.table_mut());
        if let Some(shapes) = shapes {
            shapes.0.retain(|entry| parts.iter().any(|part| part.name == entry.key));
            for entry in &mut shapes.0 {
                // Those of its parts are inside of it.
                let later: &[&str] = match stage {
                    Stage::Own if entry.key == *own => &["scale", "rotate", "move"],
                    Stage::Scaled if entry.key == *own => &["rotate", "move"],
                    _ => &[],
                };
                if let Some(table) = entry.value.table_mut() {
                    table
                        .0
                        .retain(|entry| !COLOURS.contains(&entry.key.as_str()) && !later.contains(&entry.key.as_str()));
                }
            }
        }
        self.hash_of(&document, &parts).map(|hash| of_stage(hash, own, stage))
    }

    /// SHA-256 of all in the scene that decides how a morph is planned: neither what is done with its frames nor, unless
    /// places wait, which may be by a colour, any colour.
    pub(crate) fn plan_hash(&self, morph: &Morph) -> Result<[u8; 32], (FileReference, std::io::Error)> {
        const AFTERWARDS: [&str; 16] = [
            "alpha",
            "beta",
            "color_space",
            "colour_space",
            "color_over",
            "colour_over",
            "octopus",
            "master",
            "master_color",
            "master_colour",
            "overlap",
            "cut",
            "fill",
            "displace",
            "keep",
            "min_piece",
        ];
        let link = format!("{:?} {:?} {:?}", morph.from, morph.to, morph.over);
        let of_link = |hash: [u8; 32]| Sha256::new().chain_update(hash).chain_update(&link).finalize().into();
        if morph.mode.delay().is_some() {
            return self.hash().map(of_link);
        }
        let mut document = self.document.clone();
        document.0.retain(|entry| !WITHOUT_SHAPE.contains(&entry.key.as_str()));
        if let Some(morph) = document.get_mut("morph").and_then(|entry| entry.value.table_mut()) {
            morph.0.retain(|entry| !AFTERWARDS.contains(&entry.key.as_str()));
        }
        if let Some(shapes) = document.get_mut("shape").and_then(|entry| entry.value.table_mut()) {
            for table in shapes.0.iter_mut().filter_map(|entry| entry.value.table_mut()) {
                table.0.retain(|entry| !COLOURS.contains(&entry.key.as_str()));
            }
        }
        let parts = self.with_parts(&[morph.from, morph.to]);
        self.hash_of(&document, &parts.into_iter().map(|part| self.shape(part)).collect::<Vec<_>>()).map(of_link)
    }

    /// The files on a disk that it names.
    pub fn files(&self) -> Vec<PathBuf> {
        let arguments = self.shapes.iter().flat_map(|shape| shape.all_arguments().chain(shape.given_arguments()));
        let places = arguments.flat_map(Arguments::files).map(|file| &file.place);
        let on_disk = |place: &FilePlace| match place {
            FilePlace::Disk(path) => {
                let bytes = if mesh::has_companions(path) { disk::read(path).unwrap_or_default() } else { Vec::new() };
                [path.clone()].into_iter().chain(mesh::companions(path, &bytes)).collect()
            }
            FilePlace::BuiltIn(_) => Vec::new(),
        };
        places.flat_map(on_disk).chain(self.imports.iter().cloned()).collect()
    }

    fn hash_of(&self, document: &Table, shapes: &[&Shape]) -> Result<[u8; 32], (FileReference, std::io::Error)> {
        let mut digest = Sha256::new();
        let mut canonical = String::new();
        document.canonical(&mut canonical);
        digest.update(canonical.as_bytes());
        for shape in shapes {
            let named = shape.all_arguments().flat_map(Arguments::files);
            let voxels = shape.given_arguments().flat_map(Arguments::files);
            // Which frame shows which of them.
            shape.sequences().flat_map(FileSequence::numbers).for_each(|number| digest.update(number.to_le_bytes()));
            for file in named.chain(voxels) {
                let bytes = file.read().map_err(|error| (file.clone(), error))?;
                digest.update(shape.name.as_bytes());
                digest.update((bytes.len() as u64).to_le_bytes());
                digest.update(&bytes);
                for other in companions(file, &bytes) {
                    let unreadable =
                        |error| (FileReference { place: FilePlace::Disk(other.clone()), span: file.span }, error);
                    let bytes = disk::read(&other).map_err(unreadable)?;
                    digest.update((bytes.len() as u64).to_le_bytes());
                    digest.update(&bytes);
                }
            }
        }
        Ok(digest.finalize().into())
    }
}

/// The files that a file names.
fn companions(file: &FileReference, bytes: &[u8]) -> Vec<PathBuf> {
    match &file.place {
        FilePlace::Disk(path) => mesh::companions(path, bytes),
        FilePlace::BuiltIn(_) => Vec::new(),
    }
}

/// Two shapes may be made of the same text.
fn of_stage(hash: [u8; 32], name: &str, stage: Stage) -> [u8; 32] {
    Sha256::new().chain_update(hash).chain_update(name).chain_update(format!("{stage:?}")).finalize().into()
}
