//! What is known of a frame that was written.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::compute::{Computed, Ranges};
use super::identity::Identity;
use super::inside::Insides;
use super::range::Range;
use super::velocity::Velocities;
use crate::grid::measure;
use crate::shot::MorphReport;

/// A frame that was written.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Its number.
    pub frame: i64,
    /// Its file's name, without a folder.
    pub file: String,
    /// SHA-256 of the file as it stands, in hexadecimal.
    pub sha256: String,
    /// Size of the file in bytes.
    pub bytes: u64,
    /// A voxel's edge, world units.
    pub voxel_size: f64,
    /// Active voxels of the level set.
    pub active_voxels: u64,
    /// Leaf blocks.
    pub blocks: u64,
    /// Volume inside, cubic world units.
    pub volume: f64,
    /// Of a morph: its numbers, measured on the morph's coarse grid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub morph: Option<MorphReport>,
    /// Its grids.
    pub grids: Vec<GridRecord>,
    /// Of polygons that were merged: how many.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub polygons: Option<PolygonRecord>,
    /// Seconds to compute it.
    pub compute_seconds: f64,
    /// Seconds to hand it over, encode, check and sync it.
    pub write_seconds: f64,
    /// Of a file that holds several frames: those of each, with its share of the bytes. What else stands here is that of the
    /// first, and the seconds are those of all.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub frames: Vec<Self>,
}

/// The polygons of a frame of which some were merged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PolygonRecord {
    /// The file's triangles.
    pub triangles: u64,
    /// How many they would be if none were merged.
    pub unmerged: u64,
    /// Those that are further from the surface than they should be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub beyond: Option<Beyond>,
}

/// Triangles that are too far from the surface.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Beyond {
    /// How many.
    pub triangles: u64,
    /// A place of one, world units.
    pub near: [f64; 3],
}

/// A grid of a frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GridRecord {
    /// Its name.
    pub name: String,
    /// Active voxels.
    pub active_voxels: u64,
    /// The least active value as the file has it (level sets: negative inside), before any rounding to 16 bits; of
    /// vectors, of each component. Empty where no voxel is active.
    pub least: Vec<f32>,
    /// The greatest.
    pub greatest: Vec<f32>,
    /// Of velocities: voxels of the band whose own is held to a greatest speed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_voxels: Option<u64>,
}

/// The file that stands beside a frame: its record, and what it was baked from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RecordFile {
    /// The version of this shape: 1.
    pub hfvdb_record: u32,
    /// The sequence's pattern, without a folder.
    pub pattern: String,
    /// What it was baked from.
    pub identity: Identity,
    /// The record.
    pub record: Record,
}

impl Record {
    /// The record of a frame in a file of that name, size and content; how long writing it takes is known later.
    pub fn new(
        frame: i64,
        file: String,
        (bytes, sha256): (u64, String),
        computed: &Computed,
        morph: Option<MorphReport>,
        polygons: Option<PolygonRecord>,
        compute: Duration,
    ) -> Self {
        Self {
            frame,
            file,
            sha256,
            bytes,
            voxel_size: computed.band.lattice.voxel_size.get(),
            active_voxels: computed.band.active_voxels(),
            blocks: computed.band.origins.len() as u64,
            volume: measure::volume(&computed.band),
            morph,
            grids: grids(computed),
            polygons,
            compute_seconds: compute.as_secs_f64(),
            write_seconds: 0.0,
            frames: Vec::new(),
        }
    }
}

fn grids(computed: &Computed) -> Vec<GridRecord> {
    let Ranges { distances, colours, scalars } = &computed.ranges;
    let active_voxels = computed.band.active_voxels();
    // Positive inside here, negative inside in the file.
    let flipped =
        Range { least: distances.greatest.map(|value| -value), greatest: distances.least.map(|value| -value) };
    let mut grids = vec![GridRecord::new("surface", active_voxels, flipped)];
    if let Some(Insides { colour, scalars, density }) = &computed.insides {
        grids.extend(density.iter().chain(scalars).map(|inside| {
            let blocks: Vec<&[[f32; 1]]> = inside.channel.values.iter().map(|block| block.as_chunks().0).collect();
            let range = Range::of_blocks(&blocks).joined(Range::of(inside.tile_values.as_chunks().0));
            GridRecord::new(&inside.channel.name, inside.active_voxels(), range)
        }));
        grids.extend(colour.iter().map(|inside| {
            let range = Range::of_blocks(&inside.channel.values).joined(Range::of(&inside.tile_values));
            GridRecord::new(&inside.channel.name, inside.active_voxels(), range)
        }));
    } else {
        grids.extend(computed.colour.iter().map(|colour| GridRecord::new(&colour.name, active_voxels, *colours)));
        let all = computed.scalars.iter().zip(scalars);
        grids.extend(all.map(|(scalar, range)| GridRecord::new(&scalar.name, active_voxels, *range)));
    }
    if let Some(Velocities { channel, held_voxels, .. }) = &computed.velocities {
        let active_voxels = channel.values.iter().map(|block| block.len() as u64).sum();
        let grid = GridRecord::new(&channel.name, active_voxels, Range::of_blocks(&channel.values));
        grids.push(GridRecord { held_voxels: Some(*held_voxels), ..grid });
    }
    grids
}

impl GridRecord {
    fn new<const N: usize>(name: &str, active_voxels: u64, range: Range<N>) -> Self {
        let some = |values: [f32; N]| if active_voxels > 0 { values.to_vec() } else { Vec::new() };
        let (least, greatest) = (some(range.least), some(range.greatest));
        Self { name: name.into(), active_voxels, least, greatest, held_voxels: None }
    }
}
