//! What is known of a frame that was written.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::compute::Computed;
use super::identity::Identity;
use super::velocity::Velocities;
use crate::grid::{is_active, measure};
use crate::scene::MorphReport;

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
    /// Seconds to compute it.
    pub compute_seconds: f64,
    /// Seconds to hand it over, encode, check and sync it.
    pub write_seconds: f64,
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
    /// The record of a frame in a file of that name, size and content.
    pub fn new(
        frame: i64,
        file: String,
        (bytes, sha256): (u64, String),
        computed: &Computed,
        morph: Option<MorphReport>,
        durations: [Duration; 2],
    ) -> Self {
        let [compute_seconds, write_seconds] = durations.map(|duration| duration.as_secs_f64());
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
            compute_seconds,
            write_seconds,
        }
    }
}

fn grids(computed: &Computed) -> Vec<GridRecord> {
    let band = &computed.band;
    // Positive inside here, negative inside in the file.
    let distances = band.distances.iter().map(|block| block.iter().map(|distance| [-distance]));
    let mut grids = vec![grid("surface", &band.active, distances)];
    if let Some(colour) = &computed.colour {
        grids.push(grid(&colour.name, &band.active, colour.values.iter().map(|block| block.iter().copied())));
    }
    for scalar in &computed.scalars {
        let values = scalar.values.iter().map(|block| block.iter().map(|value| [*value]));
        grids.push(grid(&scalar.name, &band.active, values));
    }
    if let Some(Velocities { active, channel, .. }) = &computed.velocities {
        grids.push(grid(&channel.name, active, channel.values.iter().map(|block| block.iter().copied())));
    }
    grids
}

fn grid<const N: usize>(
    name: &str,
    masks: &[crate::grid::BlockMask],
    blocks: impl Iterator<Item = impl Iterator<Item = [f32; N]>>,
) -> GridRecord {
    let (mut least, mut greatest, mut active_voxels) = ([f32::INFINITY; N], [f32::NEG_INFINITY; N], 0);
    for (mask, values) in masks.iter().zip(blocks) {
        for (_, value) in values.enumerate().filter(|(at, _)| is_active(mask, *at)) {
            active_voxels += 1;
            for axis in 0..N {
                least[axis] = least[axis].min(value[axis]);
                greatest[axis] = greatest[axis].max(value[axis]);
            }
        }
    }
    let some = |values: [f32; N]| if active_voxels > 0 { values.to_vec() } else { Vec::new() };
    GridRecord { name: name.into(), active_voxels, least: some(least), greatest: some(greatest) }
}
