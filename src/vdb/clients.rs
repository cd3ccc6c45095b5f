//! What single programs need of a file beyond what [`super::lint()`] asks of all of them. Only what was tried in the
//! program, or what its maker's documentation says: where nothing is known, nothing is said.

use std::collections::HashSet;
use std::path::Path;

use glam::IVec3;

use super::active::{active_values, missing_voxels};
use super::finding::Severity;
use super::programs::{Client, Program, Three};
use super::read::StoredClass;
use super::voxels::{SparseBlocks, Voxels};
use super::walk::{GridLayout, Layout};
use super::{Metadata, MetadataValue, metadata_text};
use crate::grid::node_origin;

/// Channels that a Sparse Volume Texture has: two attributes of four.
const UNREAL_CHANNELS: usize = 8;
/// Names that velocities have, the first that is there being taken.
pub const VELOCITIES: [&str; 3] = ["velocity", "vel", "v"];
/// Cycles drops values up to this by default.
const CLIPPED: f32 = 1e-3;
/// Metadata that OpenVDB itself writes.
const OWN_METADATA: [&str; 7] =
    ["class", "name", "creator", "value_type", "vector_type", "is_local_space", "is_saved_as_half_float"];

/// A file as the rules see it.
pub(super) struct Subject<'a> {
    pub path: &'a Path,
    pub layout: &'a Layout,
    pub grids: &'a [(&'a GridLayout, Option<Voxels>)],
}

/// What is found: how bad, of which grid, what and what to do.
pub(super) type Note = (Severity, Option<String>, String);

/// What is wrong for one program.
pub(super) fn check(client: Client, subject: &Subject<'_>) -> Vec<Note> {
    let mut notes = Notes(Vec::new());
    let program = client.program();
    match client {
        Client::Blender => blender(subject, &mut notes),
        Client::Houdini | Client::Karma => houdini(subject, &mut notes),
        Client::Unreal => unreal(subject, &mut notes),
        Client::Usd => usd(subject, &mut notes),
        Client::RenderMan => first_field(subject, &mut notes),
        Client::Arnold | Client::VRay | Client::Redshift | Client::MoonRay => {}
    }
    names(program, subject, &mut notes);
    if let Some(what) = program.not_verified {
        notes.0.push((Severity::Note, None, format!("not verified: {what}")));
    }
    notes.0
}

/// What is wrong with a file's number in its name, for whoever plays sequences.
pub(super) fn frame_number(path: &Path, metadata: &Metadata) -> Option<String> {
    let (named, _) = numbers(path);
    let named = named?;
    match metadata.get("hfvdb_frame") {
        Some(MetadataValue::Int32(frame)) if i64::from(*frame) != named => Some(format!(
            "the last number of its name is {named}, and it says of itself that it is frame {frame}; rename it"
        )),
        _ => None,
    }
}

struct Notes(Vec<Note>);

impl Notes {
    fn error(&mut self, grid: Option<&str>, problem: impl Into<String>) {
        self.0.push((Severity::Error, grid.map(Into::into), problem.into()));
    }

    fn warn(&mut self, grid: Option<&str>, problem: impl Into<String>) {
        self.0.push((Severity::Warning, grid.map(Into::into), problem.into()));
    }
}

/// Whether grids are called as a program looks for them.
fn names(program: &Program, subject: &Subject<'_>, notes: &mut Notes) {
    let is_fog = |grid: &GridLayout| class(grid) == StoredClass::FogVolume;
    // What Unreal and Blender ask of fog is said of them alone.
    if program.shows_fog && program.client != Client::Unreal {
        let name = program.density;
        let fog = subject.scalars().find(|(grid, _)| is_fog(grid) && grid.name != name);
        match (subject.scalars().any(|(grid, _)| grid.name == name), fog) {
            (true, _) => {}
            (false, Some((fog, _))) => {
                notes.warn(Some(&fog.name), format!("the density is called `{name}` by convention; rename it"));
            }
            // Of what reads USD some show surfaces.
            (false, None) if program.client == Client::Usd => {}
            (false, None) => {
                notes.warn(None, format!("it has no fog volume `{name}`, which is what it shows; write one with it"));
            }
        }
    }
    for (grid, _) in subject.scalars().filter(|(grid, _)| class(grid) == StoredClass::LevelSet) {
        match program.level_set {
            // Another name is nowhere in the way but where nodes ask for it.
            Some(name) if grid.name != name && matches!(program.client, Client::Houdini | Client::Karma) => {
                let problem = format!("a level set is called `{name}` by convention; nodes ask for it by name");
                notes.warn(Some(&grid.name), problem);
            }
            Some(_) => {}
            None if program.client == Client::RenderMan => {
                notes.warn(Some(&grid.name), "a level set is shown as fog, its outside too; leave it out");
            }
            None => notes.warn(Some(&grid.name), "a level set is not shown; leave it out, or make polygons of it"),
        }
    }
    for (grid, _) in subject.colours() {
        match program.colour {
            Three::Numbers(_) => {
                let problem = format!("a colour is three grids there, {}", program.colour.words());
                notes.warn(Some(&grid.name), problem);
            }
            Three::Vectors(name) if program.needs_colour_name && grid.name != name => {
                let problem = format!("a colour is called `{name}` by convention; nodes ask for it by name");
                notes.warn(Some(&grid.name), problem);
            }
            Three::Vectors(_) => {}
        }
    }
    for (grid, _) in subject.velocities() {
        match program.velocity {
            None => notes.warn(Some(&grid.name), "a velocity is of no use there; leave it out"),
            Some(three @ Three::Numbers(_)) => {
                let problem = format!("a velocity is three grids there, {}", three.words());
                notes.warn(Some(&grid.name), problem);
            }
            Some(Three::Vectors(_)) => {
                let known = program.velocities;
                if !known.is_empty() && !known.contains(&grid.name.as_str()) {
                    let problem = format!("a velocity is found by the names {}; rename it", known.join(", "));
                    notes.warn(Some(&grid.name), problem);
                }
            }
        }
    }
}

/// hdPrman takes the first of a volume's fields, which are sorted by their names, for its density.
fn first_field(subject: &Subject<'_>, notes: &mut Notes) {
    let Some((first, voxels)) = subject.grids.iter().min_by(|(a, _), (b, _)| a.name.cmp(&b.name)) else { return };
    if !matches!(voxels, Some(Voxels::Floats(_))) {
        let problem = "its name is the first of all, and the first field is taken for the density; call it by a later \
                       one, such as diffuseColor";
        notes.warn(Some(&first.name), problem);
    }
}

fn blender(subject: &Subject<'_>, notes: &mut Notes) {
    if let (Some(number), Some(meant)) = numbers(subject.path) {
        notes.warn(
            None,
            format!("its frame's number is read as {number}, not {meant}: the number has to stand last before .vdb"),
        );
    }
    if subject.scalars().next().is_none() && !subject.layout.grids.is_empty() {
        notes.error(None, "it has no grid of numbers: there is nothing to mesh or to render");
    }
    let densities: Vec<_> = subject.scalars().filter(|(grid, _)| class(grid) == StoredClass::FogVolume).collect();
    if let [(only, _)] = densities[..]
        && only.name != "density"
    {
        let problem = "the default material renders `density` only; rename it, or set Density Attribute";
        notes.warn(Some(&only.name), problem);
    }
    three_scalars(subject, notes);
    for (fog, density) in &densities {
        for (grid, colours) in subject.colours() {
            let missing = missing_voxels(density, colours) + missing_tiles(density, colours);
            if missing > 0 {
                let problem = format!(
                    "{missing} active voxels or tiles of '{}' have no active colour: smoke is black there",
                    fog.name
                );
                notes.error(Some(&grid.name), problem);
            }
            let dark = active_values(colours).filter(|colour| colour.iter().any(|channel| *channel <= 0.0)).count();
            if dark > 0 {
                let problem = format!(
                    "{dark} colours have a channel of 0, which Cycles of 5.0 renders near-black in smoke; set \
                     scene.cycles.volume_biased = True there"
                );
                notes.warn(Some(&grid.name), problem);
            }
        }
    }
    for (grid, vectors) in subject.velocities() {
        let rests = |velocity: [f32; 3]| velocity.iter().all(|part| part.abs() <= CLIPPED);
        if !densities.is_empty() && active_values(vectors).all(rests) {
            let problem = "it is nowhere more than 0.001, which Cycles drops, and 5.0.1 crashes where nothing is left of \
                           a velocity; set the volume's render.clipping = 0 there";
            notes.warn(Some(&grid.name), problem);
        }
        // Looked up at the displaced place: it has to reach farther out than what it moves.
        for (moved, blocks) in subject.scalars() {
            let missing = missing_voxels(blocks, vectors);
            if missing > 0 {
                let problem = format!(
                    "it ends before '{}' does ({missing} voxels), so no blur shows there; extend it by the motion of \
                     a frame",
                    moved.name
                );
                notes.warn(Some(&grid.name), problem);
                break;
            }
        }
    }
}

/// Vectors that were written as three grids of numbers, which nothing puts together again.
fn three_scalars(subject: &Subject<'_>, notes: &mut Notes) {
    let has = |name: String| subject.scalars().any(|(grid, _)| grid.name == name);
    for (grid, _) in subject.scalars() {
        let Some(base) = grid.name.strip_suffix(".x") else { continue };
        if has(format!("{base}.y")) && has(format!("{base}.z")) {
            let problem =
                format!("with '{base}.y' and '{base}.z' it is one vector in three grids; write one vec3s grid");
            notes.warn(Some(&grid.name), problem);
        }
    }
}

fn houdini(subject: &Subject<'_>, notes: &mut Notes) {
    for (grid, _) in subject.grids {
        for name in grid.metadata.keys() {
            let own = name.starts_with("file_") || OWN_METADATA.contains(&name.as_str());
            if !own && !is_plain(name) {
                let problem = format!("metadata '{name}' becomes an attribute: name it in plain lower-case letters");
                notes.warn(Some(&grid.name), problem);
            }
        }
    }
    for (grid, _) in subject.velocities() {
        if !vector_type(grid).is_some_and(|kind| kind.starts_with("contra")) {
            let problem = "a Transform does not turn its vectors: make their type contravariant relative";
            notes.warn(Some(&grid.name), problem);
        }
    }
}

fn unreal(subject: &Subject<'_>, notes: &mut Notes) {
    let channels: usize = subject.grids.iter().map(|(_, voxels)| width(voxels.as_ref())).sum();
    if channels > UNREAL_CHANNELS {
        let problem = format!(
            "it has {channels} channels, and a Sparse Volume Texture holds {UNREAL_CHANNELS}; leave some out when you \
             import it"
        );
        notes.warn(None, problem);
    }
    if !subject.scalars().any(|(grid, _)| class(grid) == StoredClass::FogVolume) {
        let problem = "it has no density (a fog volume), which a Heterogeneous Volume shows; a distance needs a \
                       material that makes a density of it";
        notes.warn(None, problem);
    }
    if numbers(subject.path).0.is_none() {
        notes.warn(None, "no number ends its name: it is imported as a still, not as a frame of a sequence");
    }
}

fn usd(subject: &Subject<'_>, notes: &mut Notes) {
    for (grid, _) in subject.grids {
        let mut letters = grid.name.chars();
        let first = letters.next().is_some_and(|first| first.is_ascii_alphabetic() || first == '_');
        if !(first && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_')) {
            let problem = "a field is reached by the relationship field:NAME, and this is no name for one: letters, \
                           digits and underscores, no digit first";
            notes.error(Some(&grid.name), problem);
        }
    }
    let shape = subject.scalars().any(|(grid, _)| class(grid) != StoredClass::Unknown);
    if !shape {
        notes.warn(None, "no grid is a level set or a fog volume: write fieldClass by hand in the layer");
    }
}

impl<'a> Subject<'a> {
    fn scalars(&self) -> impl Iterator<Item = (&'a GridLayout, &'a SparseBlocks<f32>)> {
        self.grids.iter().filter_map(|(grid, voxels)| match voxels {
            Some(Voxels::Floats(blocks)) => Some((*grid, blocks)),
            _ => None,
        })
    }

    fn vectors(&self) -> impl Iterator<Item = (&'a GridLayout, &'a SparseBlocks<[f32; 3]>)> {
        self.grids.iter().filter_map(|(grid, voxels)| match voxels {
            Some(Voxels::Vectors(blocks)) => Some((*grid, blocks)),
            _ => None,
        })
    }

    fn colours(&self) -> impl Iterator<Item = (&'a GridLayout, &'a SparseBlocks<[f32; 3]>)> {
        self.vectors().filter(|(grid, _)| !is_velocity(grid))
    }

    fn velocities(&self) -> impl Iterator<Item = (&'a GridLayout, &'a SparseBlocks<[f32; 3]>)> {
        self.vectors().filter(|(grid, _)| is_velocity(grid))
    }
}

/// The number that the name ends in, and, where that seems not to be the frame's, the one that does: an earlier one of
/// more digits.
fn numbers(path: &Path) -> (Option<i64>, Option<String>) {
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
    let runs: Vec<&str> = stem.split(|letter: char| !letter.is_ascii_digit()).collect();
    let last = runs.last().copied().unwrap_or_default();
    let longer = runs.iter().rev().find(|run| run.len() >= 3 && run.len() > last.len() && !last.is_empty());
    (last.parse().ok(), longer.map(|run| (*run).to_owned()))
}

fn class(grid: &GridLayout) -> StoredClass {
    StoredClass::of(&grid.metadata)
}

fn vector_type(grid: &GridLayout) -> Option<&str> {
    metadata_text(&grid.metadata, "vector_type")
}

/// Whether vectors are a velocity, by their name or by their type.
pub(super) fn is_velocity(grid: &GridLayout) -> bool {
    VELOCITIES.contains(&grid.name.as_str())
        || vector_type(grid).is_some_and(|kind| kind.starts_with("contra"))
        || class(grid) == StoredClass::Staggered
}

fn is_plain(name: &str) -> bool {
    name.starts_with(|first: char| first.is_ascii_lowercase() || first == '_')
        && name.chars().all(|letter| letter.is_ascii_lowercase() || letter.is_ascii_digit() || letter == '_')
}

/// The channels of a grid.
fn width(voxels: Option<&Voxels>) -> usize {
    if matches!(voxels, Some(Voxels::Vectors(_))) { 3 } else { 1 }
}

/// How many active tiles of the one have neither an active tile nor blocks of the other all over them.
fn missing_tiles(densities: &SparseBlocks<f32>, colours: &SparseBlocks<[f32; 3]>) -> u64 {
    let blocks: HashSet<IVec3> = colours.origins.iter().copied().collect();
    let tiles: HashSet<(IVec3, i32)> =
        colours.tiles.iter().filter(|tile| tile.active).map(|tile| (tile.origin, tile.edge)).collect();
    let in_tile = |origin: IVec3, from: i32| {
        [8, 128, 4096].into_iter().filter(|edge| *edge >= from).any(|edge| {
            let around = node_origin(origin, edge);
            tiles.contains(&(around, edge))
        })
    };
    let is_covered = |origin: IVec3, edge: i32| {
        let steps = || (0..edge / 8).map(|step| step * 8);
        in_tile(origin, edge)
            || edge <= 128
                && steps().all(|x| {
                    steps().all(|y| {
                        steps().all(|z| {
                            let block = origin + IVec3::new(x, y, z);
                            blocks.contains(&block) || in_tile(block, 8)
                        })
                    })
                })
    };
    let missing = densities.tiles.iter().filter(|tile| tile.active && !is_covered(tile.origin, tile.edge));
    missing.count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_as_programs_read_them() {
        let read = |name: &str| numbers(Path::new(name));
        assert_eq!(read("out/m.0017.vdb"), (Some(17), None));
        assert_eq!(read("m_1.vdb"), (Some(1), None));
        assert_eq!(read("m_0001_v2.vdb"), (Some(2), Some("0001".into())));
        assert_eq!(read("v2_1.vdb"), (Some(1), None));
        assert_eq!(read("heart.vdb"), (None, None));
        let metadata = Metadata::from([("hfvdb_frame".into(), 12.into())]);
        assert!(frame_number(Path::new("m.0007.vdb"), &metadata).unwrap().contains("is 7"));
        assert_eq!(frame_number(Path::new("m.0012.vdb"), &metadata), None);
        assert_eq!(frame_number(Path::new("heart.vdb"), &metadata), None);
    }
}
