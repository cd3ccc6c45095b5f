//! What is known of a frame that was written.

use std::time::Duration;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::compute::Computed;
use super::identity::Identity;
use super::velocity::Velocities;
use crate::grid::{BLOCK_VOXELS, BlockMask, measure};
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
    /// The record of a frame in a file of that name, size and content; how long writing it takes is known later.
    pub fn new(
        frame: i64,
        file: String,
        (bytes, sha256): (u64, String),
        computed: &Computed,
        morph: Option<MorphReport>,
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
            compute_seconds: compute.as_secs_f64(),
            write_seconds: 0.0,
        }
    }
}

fn grids(computed: &Computed) -> Vec<GridRecord> {
    let band = &computed.band;
    let active_voxels = band.active_voxels();
    // Positive inside here, negative inside in the file.
    let distances = band.distances.par_iter().zip(&band.active);
    let distances = distances.map(|(block, active)| Range::of_active(block, active)).reduce(Range::none, Range::joined);
    let flipped =
        Range { least: distances.greatest.map(|value| -value), greatest: distances.least.map(|value| -value) };
    let mut grids = vec![flipped.record("surface", active_voxels)];
    if let Some(colour) = &computed.colour {
        grids.push(Range::of_blocks(&colour.values).record(&colour.name, active_voxels));
    }
    for scalar in &computed.scalars {
        let blocks: Vec<_> = scalar.values.iter().map(|block| block.as_chunks::<1>().0).collect();
        grids.push(Range::of_blocks(&blocks).record(&scalar.name, active_voxels));
    }
    if let Some(Velocities { channel, .. }) = &computed.velocities {
        let active_voxels = channel.values.iter().map(|block| block.len() as u64).sum();
        grids.push(Range::of_blocks(&channel.values).record(&channel.name, active_voxels));
    }
    grids
}

/// The least and the greatest of values, each component for itself.
#[derive(Clone, Copy)]
struct Range<const N: usize> {
    least: [f32; N],
    greatest: [f32; N],
}

impl<const N: usize> Range<N> {
    fn none() -> Self {
        Self { least: [f32::INFINITY; N], greatest: [f32::NEG_INFINITY; N] }
    }

    fn joined(self, other: Self) -> Self {
        Self {
            least: std::array::from_fn(|part| self.least[part].min(other.least[part])),
            greatest: std::array::from_fn(|part| self.greatest[part].max(other.greatest[part])),
        }
    }

    fn of_blocks(blocks: &[impl AsRef<[[f32; N]]> + Sync]) -> Self {
        let of_block = |block: &[[f32; N]]| {
            let [least, greatest] = range(block);
            Self { least, greatest }
        };
        blocks.par_iter().map(|block| of_block(block.as_ref())).reduce(Self::none, Self::joined)
    }

    fn record(self, name: &str, active_voxels: u64) -> GridRecord {
        let some = |values: [f32; N]| if active_voxels > 0 { values.to_vec() } else { Vec::new() };
        GridRecord { name: name.into(), active_voxels, least: some(self.least), greatest: some(self.greatest) }
    }
}

impl Range<1> {
    fn of_active(block: &[f32; BLOCK_VOXELS], active: &BlockMask) -> Self {
        let [least, greatest] = active_range(block, active);
        Self { least: [least], greatest: [greatest] }
    }
}

/// The least and the greatest: of every eighth value, then of these, at any vector width.
#[multiversion::multiversion(targets = "simd")]
fn range<const N: usize>(values: &[[f32; N]]) -> [[f32; N]; 2] {
    let (mut least, mut greatest) = ([[f32::INFINITY; N]; 8], [[f32::NEG_INFINITY; N]; 8]);
    let (rows, rest) = values.as_chunks::<8>();
    for row in rows {
        for i in 0..8 {
            for part in 0..N {
                least[i][part] = if row[i][part] < least[i][part] { row[i][part] } else { least[i][part] };
                greatest[i][part] = if row[i][part] > greatest[i][part] { row[i][part] } else { greatest[i][part] };
            }
        }
    }
    let all = |start: &[[f32; N]; 8], choose: fn(f32, f32) -> f32| {
        let first = rest.iter().chain(start);
        std::array::from_fn(|part| first.clone().map(|value| value[part]).fold(start[0][part], choose))
    };
    [all(&least, f32::min), all(&greatest, f32::max)]
}

/// The least and the greatest of a block's active values.
#[multiversion::multiversion(targets = "simd")]
fn active_range(block: &[f32; BLOCK_VOXELS], active: &BlockMask) -> [f32; 2] {
    let (mut least, mut greatest) = ([f32::INFINITY; 64], [f32::NEG_INFINITY; 64]);
    for (values, word) in block.as_chunks::<64>().0.iter().zip(active) {
        for i in 0..64 {
            let on = word >> i & 1 == 1;
            least[i] = if on && values[i] < least[i] { values[i] } else { least[i] };
            greatest[i] = if on && values[i] > greatest[i] { values[i] } else { greatest[i] };
        }
    }
    [least.into_iter().fold(f32::INFINITY, f32::min), greatest.into_iter().fold(f32::NEG_INFINITY, f32::max)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::mask;

    #[test]
    fn ranges_are_those_of_the_active_values() {
        let block: [f32; BLOCK_VOXELS] = std::array::from_fn(|at| ((at * 37 + 11) % 512) as f32 - 200.0);
        for step in [1, 3, 7, 100, 511] {
            let active = mask::pack(&std::array::from_fn(|at| u8::from(at % step == step - 1)));
            let values: Vec<f32> = mask::places(&active).map(|at| block[at]).collect();
            let least = values.iter().copied().fold(f32::INFINITY, f32::min);
            let greatest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            assert_eq!(active_range(&block, &active), [least, greatest]);
            let triples: Vec<[f32; 3]> = values.iter().map(|&value| [value, -value, value + 1.0]).collect();
            let expected = [[least, -greatest, least + 1.0], [greatest, -least, greatest + 1.0]];
            assert_eq!(range(&triples), expected);
        }
        assert_eq!(range::<1>(&[]), [[f32::INFINITY], [f32::NEG_INFINITY]]);
    }
}
